//! Implementations of the runtime's traits for kernels.
//!
//! In: a compiled force function and its companions, which are kernels of the same function with other
//! outputs or for several instances at once. Out: the tokens of `impl`s.

use crate::compile::Stages;
use crate::emit::rust::module_name;
use crate::kernel::{Kernel, Precision};
use crate::layout::Lanes;
use crate::model::bodies::{BodyKind, Signature};
use crate::model::outputs::Part;
use crate::names::{Arguments, Target};
use crate::vector::definition::Law;
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// A row of the table of companions: kernels of the same function with other outputs, for methods that do not
/// need the separate derivatives.
pub(crate) struct CompanionRow {
    pub(crate) outputs: &'static [Part],
    /// Whether a function of this law has the companion.
    pub(crate) is_of: fn(&Law) -> bool,
    pub(crate) forms: &'static [Form],
}

/// The kernels of a companion for a number of instances.
pub(crate) struct Form {
    /// The module of these kernels for all functions; no kernel's name begins like it.
    pub(crate) module: &'static str,
    pub(crate) lanes: Lanes,
    /// The items of `Kernel` that call the kernel.
    items: fn(&Call<'_>) -> TokenStream,
}

/// A companion of a function.
pub(crate) struct Companion {
    pub(crate) form: &'static Form,
    pub(crate) kernel: Kernel,
}

const fn one(module: &'static str, items: fn(&Call<'_>) -> TokenStream) -> Form {
    Form { module, lanes: Lanes::One, items }
}

const fn any(module: &'static str, items: fn(&Call<'_>) -> TokenStream) -> Form {
    Form { module, lanes: Lanes::Generic, items }
}

/// For measurements; for explicit methods, also with constraints that multipliers enforce; for implicit methods
/// with such constraints; for implicit steps with λ of the stiffness; for implicit steps without.
pub(crate) static COMPANIONS: [CompanionRow; 6] = [
    CompanionRow {
        outputs: &[Part::Value],
        is_of: |law| law.rows() > 0,
        forms: &[one("forcec_values", measured)],
    },
    CompanionRow {
        outputs: &[Part::Force],
        is_of: |_| true,
        forms: &[one("forcec_loads", force), any("forcec_lane_loads", force_lanes)],
    },
    CompanionRow {
        outputs: &[Part::Value, Part::Jacobian, Part::Drift],
        is_of: Law::has_multipliers,
        forms: &[any("forcec_lane_rows", rows_lanes)],
    },
    CompanionRow {
        outputs: &[Part::Value, Part::Jacobian, Part::Geometric],
        is_of: Law::has_multipliers,
        forms: &[one("forcec_saddles", saddle)],
    },
    CompanionRow {
        outputs: &[Part::Multiplier, Part::Force, Part::MultiplierStep, Part::Held],
        is_of: Law::has_multipliers,
        forms: &[one("forcec_steps", step)],
    },
    CompanionRow {
        outputs: &[Part::Force, Part::Matrix],
        is_of: |law| !law.has_multipliers(),
        forms: &[one("forcec_steps", step)],
    },
];

/// The implementations of the runtime's traits for a kernel.
pub(crate) fn ties(function: &Stages, companions: &[Companion], precision: Precision) -> TokenStream {
    let kernel = &function.kernel;
    let signature = &kernel.schedule.signature;
    let law = &function.definition.law;
    let module = format_ident!("{}", module_name(kernel, precision));
    let real = format_ident!("{}", precision.name());
    let count = signature.bodies.len();
    let kinds = signature.bodies.iter().map(|body| format_ident!("{}", body.kind.row().name));
    let arguments = arguments(signature);
    let companions = companions.iter().map(|own| (own.form.items)(&Call::new(own, law, precision)));
    let rows = match law {
        Law::Constraint { unilateral, per_row, .. } => {
            let rows = signature.rows;
            let penalty = penalty(signature, *per_row);
            quote!(const ROWS: usize = #rows; const ONE_SIDED: bool = #unilateral; #penalty)
        }
        _ => quote! {
            type RowParams<const L: usize> = ();
            type LaneRows<const L: usize> = ();
            type Saddle = ();

            #[inline(always)]
            fn gather_row_params<const L: usize>(_each: [&Self::Params; L]) {}
        },
    };
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
            #rows

            #[inline]
            fn evaluate(
                &mut self,
                bodies: &::forcec_runtime::Bodies<'_, #real>,
                indices: [usize; #count],
                #unused: &#params,
            ) {
                #module::evaluate(#arguments #pass self);
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

/// The bodies of a world that a kernel reads.
fn arguments(signature: &Signature) -> TokenStream {
    let arguments = signature.bodies.iter().enumerate().map(|(k, body)| {
        let array = format_ident!("{}", if body.kind == BodyKind::RIGID { "rigid" } else { "particles" });
        quote!(&bodies.#array[indices[#k]],)
    });
    arguments.collect()
}

/// A call of a companion with the bodies of a world.
struct Call<'a> {
    law: &'a Law,
    signature: &'a Signature,
    real: Ident,
    /// The module of the kernel.
    module: TokenStream,
    /// The struct of the parameters that the kernel takes; `()` without parameters.
    params: TokenStream,
    /// The declarations of the arguments `bodies`, `indices` and `params`.
    place: TokenStream,
    /// What is passed to the kernel before extra arguments and the output.
    pass: TokenStream,
}

impl<'a> Call<'a> {
    fn new(companion: &'a Companion, law: &'a Law, precision: Precision) -> Call<'a> {
        let Companion { form, kernel } = companion;
        let signature = &kernel.schedule.signature;
        let real = format_ident!("{}", precision.name());
        let (outer, name) = (format_ident!("{}", form.module), module_name(kernel, precision));
        let name = format_ident!("{name}");
        let module = quote!(#outer::#name);
        let (bodies, own) = match form.lanes {
            Lanes::Generic => (quote!(BodiesLanes<'_, #real, L>), quote!(#module::Params<L>)),
            _ => (quote!(Bodies<'_, #real>), quote!(#module::Params)),
        };
        let params = if signature.has_given() { own } else { quote!(()) };
        let taken = match form.lanes {
            Lanes::Generic => &params,
            _ => &quote!(Self::Params),
        };
        let names = field_names(signature);
        let (name, passed) = match form.lanes {
            _ if !signature.has_given() => (quote!(_params), quote!()),
            Lanes::Generic => (quote!(params), quote!(params,)),
            _ => (quote!(params), quote!(&#module::Params { #(#names: params.#names),* },)),
        };
        let arguments = arguments(signature);
        let place = quote! {
            bodies: &::forcec_runtime::#bodies,
            indices: Self::Indices,
            #name: &#taken
        };
        let pass = quote!(#arguments #passed);
        Call { law, signature, real, module, params, place, pass }
    }
}

/// `measure`, from the values.
fn measured(call: &Call<'_>) -> TokenStream {
    let Call { real, module, place, pass, .. } = call;
    let measure = measure(call.law, call.signature, real);
    quote! {
        const HAS_POTENTIAL: bool = true;

        #[inline]
        fn measure(#place) -> ::forcec_runtime::Measure<#real> {
            let mut out = #module::Output::default();
            #module::evaluate(#pass &mut out);
            #measure
        }
    }
}

/// `evaluate_force`.
fn force(call: &Call<'_>) -> TokenStream {
    let Call { real, module, place, pass, .. } = call;
    quote! {
        type Force = #module::Output;

        #[inline]
        fn evaluate_force<'a>(out: &'a mut Self::Force, #place) -> &'a [#real] {
            #module::evaluate(#pass out);
            &out.force
        }
    }
}

/// `force_lanes`, with its parameters.
fn force_lanes(call: &Call<'_>) -> TokenStream {
    let Call { real, module, params, place, pass, .. } = call;
    let gather = gather("gather_params", call);
    quote! {
        type LaneParams<const L: usize> = #params;
        type LaneForce<const L: usize> = #module::Output<L>;

        #gather

        #[inline(always)]
        fn force_lanes<'a, const L: usize>(out: &'a mut Self::LaneForce<L>, #place) -> &'a [[#real; L]] {
            #module::evaluate(#pass out);
            &out.force
        }
    }
}

/// `rows_lanes`, with its parameters.
fn rows_lanes(call: &Call<'_>) -> TokenStream {
    let Call { real, module, params, place, pass, .. } = call;
    let gather = gather("gather_row_params", call);
    quote! {
        const JACOBIAN_NONZERO: &'static [&'static str] = &#module::JACOBIAN_NONZERO;

        type RowParams<const L: usize> = #params;
        type LaneRows<const L: usize> = #module::Output<L>;

        #gather

        #[inline(always)]
        fn rows_lanes<'a, const L: usize>(
            out: &'a mut Self::LaneRows<L>,
            #place,
        ) -> ::forcec_runtime::Rows<'a, #real, L> {
            #module::evaluate(#pass out);
            ::forcec_runtime::Rows { value: &out.value, jacobian: out.jacobian.as_flattened(), drift: &out.drift }
        }
    }
}

/// The function of this name that makes the parameters of a kernel of L instances.
fn gather(name: &str, call: &Call<'_>) -> TokenStream {
    let Call { module, params, .. } = call;
    let name = format_ident!("{name}");
    if !call.signature.has_given() {
        return quote! {
            #[inline(always)]
            fn #name<const L: usize>(_each: [&Self::Params; L]) {}
        };
    }
    let names = field_names(call.signature);
    let fields = call.signature.given().zip(&names).map(|((_, parameter), name)| {
        let indices = (0..parameter.ty.extents().len()).map(|depth| format_ident!("i{depth}"));
        let indices: Vec<Ident> = indices.collect();
        let lanes = quote!(::core::array::from_fn(|lane| each[lane].#name #([#indices])*));
        let value = indices.iter().rev().fold(lanes, |inner, i| quote!(::core::array::from_fn(|#i| #inner)));
        quote!(#name: #value)
    });
    quote! {
        #[inline(always)]
        fn #name<const L: usize>(each: [&Self::Params; L]) -> #params {
            #module::Params { #(#fields),* }
        }
    }
}

/// The argument `multipliers` of a kernel, from the slice of this name.
fn multipliers() -> TokenStream {
    quote!(multipliers.first_chunk().expect("a multiplier for each row"),)
}

/// `saddle`.
fn saddle(call: &Call<'_>) -> TokenStream {
    let Call { real, module, place, pass, .. } = call;
    let multipliers = multipliers();
    quote! {
        type Saddle = #module::Output;

        #[inline]
        fn saddle<'a>(
            out: &'a mut Self::Saddle,
            #place,
            multipliers: &[#real],
        ) -> ::forcec_runtime::Saddle<'a, #real> {
            #module::evaluate(#pass #multipliers out);
            ::forcec_runtime::Saddle {
                value: &out.value,
                jacobian: out.jacobian.as_flattened(),
                geometric: out.geometric.as_flattened(),
            }
        }
    }
}

/// `evaluate_step`.
fn step(call: &Call<'_>) -> TokenStream {
    let Call { real, module, place, pass, .. } = call;
    let (taken, passed, matrix, own) = if call.law.has_multipliers() {
        (
            quote!(multipliers),
            multipliers(),
            quote!(held_matrix),
            quote!(multipliers: &out.multiplier, slopes: out.multiplier_step.as_flattened(),),
        )
    } else {
        (quote!(_multipliers), quote!(), quote!(matrix), quote!(multipliers: &[], slopes: &[],))
    };
    quote! {
        type Step = #module::Output;

        #[inline]
        fn evaluate_step<'a>(
            out: &'a mut Self::Step,
            #place,
            step: #real,
            #taken: &[#real],
        ) -> ::forcec_runtime::Linear<'a, #real> {
            #module::evaluate(#pass step, #passed out);
            ::forcec_runtime::Linear { force: &out.force, matrix: out.#matrix.as_flattened(), #own }
        }
    }
}

/// `set_penalty`, where stiffness and damping are parameters.
fn penalty(signature: &Signature, per_row: bool) -> Option<TokenStream> {
    let given = |name: &str| signature.given().any(|(_, parameter)| parameter.name == name);
    let rows = signature.rows;
    let all = |name: TokenStream| if per_row { quote!([#name; #rows]) } else { name };
    let [stiffness, damping] = [all(quote!(stiffness)), all(quote!(damping))];
    (given("stiffness") && given("damping")).then(|| {
        quote! {
            fn set_penalty(params: &mut Self::Params, stiffness: Self::Real, damping: Self::Real) -> bool {
                params.stiffness = #stiffness;
                params.damping = #damping;
                true
            }
        }
    })
}

/// The contribution of a constraint or an energy to a world's measurements, from the values in `out`.
fn measure(law: &Law, signature: &Signature, real: &Ident) -> TokenStream {
    match *law {
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
