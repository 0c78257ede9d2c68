//! Implementations of the runtime's traits for kernels.
//!
//! In: a compiled force function and its companions, which are kernels of the same function with other
//! outputs. Out: the tokens of `impl`s.

use crate::compile::Stages;
use crate::emit::rust::module_name;
use crate::kernel::Precision;
use crate::model::bodies::{BodyKind, Signature};
use crate::model::outputs::Part;
use crate::names::{Arguments, Target};
use crate::vector::definition::Law;
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// A kernel of the same function with other outputs, for methods that do not need the separate derivatives.
#[derive(Debug)]
pub(crate) struct Companion {
    /// The module of this companion for all functions; no kernel's name begins like it.
    pub(crate) module: &'static str,
    pub(crate) outputs: &'static [Part],
    /// Whether a function of this law has the companion.
    pub(crate) is_of: fn(&Law) -> bool,
}

/// For measurements; for explicit methods; for implicit steps with multipliers; for implicit steps without.
pub(crate) static COMPANIONS: [Companion; 4] = [
    Companion { module: "forcec_values", outputs: &[Part::Value], is_of: |law| law.rows() > 0 },
    Companion { module: "forcec_loads", outputs: &[Part::Force], is_of: |_| true },
    Companion {
        module: "forcec_steps",
        outputs: &[Part::Multiplier, Part::Force, Part::MultiplierStep, Part::Held],
        is_of: Law::has_multipliers,
    },
    Companion {
        module: "forcec_steps",
        outputs: &[Part::Force, Part::Matrix],
        is_of: |law| !law.has_multipliers(),
    },
];

/// The implementations of the runtime's traits for a kernel.
pub(crate) fn ties(
    function: &Stages,
    companions: &[(&Companion, Stages)],
    precision: Precision,
) -> TokenStream {
    let kernel = &function.kernel;
    let signature = &kernel.schedule.signature;
    let module = format_ident!("{}", module_name(kernel, precision));
    let real = format_ident!("{}", precision.name());
    let count = signature.bodies.len();
    let kinds = signature.bodies.iter().map(|body| format_ident!("{}", body.kind.row().name));
    let arguments = signature.bodies.iter().enumerate().map(|(k, body)| {
        let array = format_ident!("{}", if body.kind == BodyKind::RIGID { "rigid" } else { "particles" });
        quote!(&bodies.#array[indices[#k]],)
    });
    let arguments = arguments.collect::<Vec<_>>();
    let companions = companions.iter().map(|(row, companion)| tie(row, companion, &arguments, precision));
    let numbers = numbers(function, precision);
    let (params, pass, knows) = if !signature.has_given() {
        (quote!(()), quote!(), quote!())
    } else {
        let knows = quote! {
            impl ::forcec_runtime::Parameters for #module::Params {
                type Kernel = #module::Output;
            }
        };
        (quote!(#module::Params), quote!(params,), knows)
    };
    let unused = if !signature.has_given() { quote!(_params) } else { quote!(params) };
    quote! {
        impl ::forcec_runtime::Kernel for #module::Output {
            type Real = #real;
            type Params = #params;
            type Indices = [usize; #count];
            const NAME: &'static str = #module::NAME;
            const BODIES: &'static [::forcec_runtime::BodyKind] = &[#(::forcec_runtime::BodyKind::#kinds),*];
            const DOFS: usize = #module::DOFS;
            const DFDX_NONZERO: &'static [&'static str] = &#module::DFDX_NONZERO;
            const DFDV_NONZERO: &'static [&'static str] = &#module::DFDV_NONZERO;

            #[inline]
            fn evaluate(
                &mut self,
                bodies: &::forcec_runtime::Bodies<'_, #real>,
                indices: [usize; #count],
                #unused: &#params,
            ) {
                #module::evaluate(#(#arguments)* #pass self);
            }

            fn force(&self) -> &[#real] {
                &self.force
            }

            fn dfdx(&self) -> &[#real] {
                self.dfdx.as_flattened()
            }

            fn dfdv(&self) -> &[#real] {
                self.dfdv.as_flattened()
            }

            #(#companions)*
            #numbers
        }
        #knows
    }
}

/// The function that evaluates a companion with the bodies of a world.
fn tie(row: &Companion, companion: &Stages, arguments: &[TokenStream], precision: Precision) -> TokenStream {
    let signature = &companion.kernel.schedule.signature;
    let module = format_ident!("{}", module_name(&companion.kernel, precision));
    let real = format_ident!("{}", precision.name());
    let own = format_ident!("{}", row.module);
    let count = arguments.len();
    let names = field_names(signature);
    let (params, pass) = if signature.has_given() {
        let pass = quote!(&#own::#module::Params { #(#names: params.#names),* },);
        (quote!(params: &#module::Params), pass)
    } else {
        (quote!(_params: &()), quote!())
    };
    let place = quote!(bodies: &::forcec_runtime::Bodies<'_, #real>, indices: [usize; #count], #params);
    let output = quote!(#own::#module::Output);
    let evaluate = quote!(#own::#module::evaluate);
    let pass = quote!(#(#arguments)* #pass);
    match row.outputs {
        [Part::Value] => {
            let measure = measure(companion, &real);
            quote! {
                const HAS_POTENTIAL: bool = true;

                #[inline]
                fn measure(#place) -> ::forcec_runtime::Measure<#real> {
                    let mut out = #output::default();
                    #evaluate(#pass &mut out);
                    #measure
                }
            }
        }
        [Part::Force] => quote! {
            type Force = #output;

            #[inline]
            fn evaluate_force<'a>(out: &'a mut #output, #place) -> &'a [#real] {
                #evaluate(#pass out);
                &out.force
            }
        },
        _ => {
            let (law, count) = (&companion.definition.law, signature.rows);
            let rows = match law {
                Law::Constraint { unilateral, .. } => {
                    quote!(const ROWS: usize = #count; const ONE_SIDED: bool = #unilateral;)
                }
                _ => quote!(),
            };
            let (taken, passed, matrix, own) = if law.has_multipliers() {
                (
                    quote!(multipliers),
                    quote!(multipliers.first_chunk().expect("a multiplier for each row"),),
                    quote!(held_matrix),
                    quote!(multipliers: &out.multiplier, slopes: out.multiplier_step.as_flattened(),),
                )
            } else {
                (quote!(_multipliers), quote!(), quote!(matrix), quote!(multipliers: &[], slopes: &[],))
            };
            quote! {
                type Step = #output;
                #rows

                #[inline]
                fn evaluate_step<'a>(
                    out: &'a mut #output,
                    #place,
                    step: #real,
                    #taken: &[#real],
                ) -> ::forcec_runtime::Linear<'a, #real> {
                    #evaluate(#pass step, #passed out);
                    ::forcec_runtime::Linear { force: &out.force, matrix: out.#matrix.as_flattened(), #own }
                }
            }
        }
    }
}

/// The contribution of a constraint or an energy to a world's measurements, from the values in `out`.
fn measure(value: &Stages, real: &Ident) -> TokenStream {
    let signature = &value.kernel.schedule.signature;
    match value.definition.law {
        Law::Constraint { unilateral, per_row, .. } => {
            let side = unilateral.then(|| quote!(.min(0.0)));
            let given =
                signature.parameters.iter().find(|p| p.name == "stiffness").and_then(|p| p.value.as_ref());
            let stiffness = match given {
                Some(value) => {
                    let numbers = value.iter().map(|x| Literal::f64_unsuffixed(x.to_f64()));
                    if per_row { quote!([#(#numbers),*]) } else { quote!(#(#numbers)*) }
                }
                None => quote!(params.stiffness),
            };
            let stiffness = if per_row { quote!(#stiffness[row]) } else { stiffness };
            let rows = if per_row { quote!((row, value)) } else { quote!(value) };
            let each = per_row.then(|| quote!(.enumerate()));
            quote! {
                let mut measure = ::forcec_runtime::Measure::<#real>::default();
                for #rows in out.value.into_iter()#each {
                    let value: #real = value #side;
                    measure.energy += 0.5 * #stiffness * value * value;
                    measure.max_violation = measure.max_violation.max(value.abs());
                }
                measure
            }
        }
        _ => quote!(::forcec_runtime::Measure { energy: out.value[0], max_violation: 0.0 }),
    }
}

/// Conversions between parameters and a list of numbers.
fn numbers(function: &Stages, precision: Precision) -> TokenStream {
    let kernel = &function.kernel;
    let signature = &kernel.schedule.signature;
    let module = format_ident!("{}", module_name(kernel, precision));
    let real = format_ident!("{}", precision.name());
    if !signature.has_given() {
        return quote! {
            fn write_params(_params: &(), _numbers: &mut ::forcec_runtime::Numbers<#real>) {}

            fn read_params(_numbers: &mut dyn ::core::iter::Iterator<Item = #real>) -> ::core::option::Option<()> {
                ::core::option::Option::Some(())
            }
        };
    }
    let names = field_names(signature);
    let writes = signature.given().zip(&names).map(|((_, parameter), name)| {
        let flat = parameter.ty.extents().iter().skip(1).map(|_| quote!(.as_flattened())).collect::<Vec<_>>();
        match parameter.ty.extents().len() {
            0 => quote!(numbers.push(params.#name);),
            _ => quote!(numbers.extend_from_slice((&params.#name[..]) #(#flat)*);),
        }
    });
    let writes = writes.collect::<Vec<_>>();
    let reads = signature.given().zip(&names).map(|((_, parameter), name)| {
        let empty = parameter.ty.extents().iter().rev().fold(quote!(0.0), |inner, &n| {
            let n = n as usize;
            quote!([#inner; #n])
        });
        let flat =
            parameter.ty.extents().iter().skip(1).map(|_| quote!(.as_flattened_mut())).collect::<Vec<_>>();
        let fill = match parameter.ty.extents().len() {
            0 => quote!(params.#name = numbers.next()?;),
            _ => quote! {
                for number in params.#name #(#flat)* .iter_mut() {
                    *number = numbers.next()?;
                }
            },
        };
        (quote!(#name: #empty), fill)
    });
    let (empty, fill): (Vec<TokenStream>, Vec<TokenStream>) = reads.unzip();
    quote! {
        #[inline]
        fn write_params(params: &#module::Params, numbers: &mut ::forcec_runtime::Numbers<#real>) {
            #(#writes)*
        }

        #[inline]
        fn read_params(
            numbers: &mut dyn ::core::iter::Iterator<Item = #real>,
        ) -> ::core::option::Option<#module::Params> {
            let mut params = #module::Params { #(#empty),* };
            #(#fill)*
            ::core::option::Option::Some(params)
        }
    }
}

/// The fields of the parameters that a kernel takes.
fn field_names(signature: &Signature) -> Vec<Ident> {
    let names = Arguments::new(signature, Target::Rust).parameters;
    signature.given().map(|(index, _)| identifier(&names[index])).collect()
}

fn identifier(name: &str) -> Ident {
    match name.strip_prefix("r#") {
        Some(raw) => Ident::new_raw(raw, proc_macro2::Span::call_site()),
        None => format_ident!("{name}"),
    }
}
