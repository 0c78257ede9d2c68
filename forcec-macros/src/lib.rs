//! The attribute macros of forcec. Use them through `forcec-runtime`, which defines the types in force
//! functions.
//!
//! A macro passes its tokens to the compiler, and returns the kernels or the errors.

use proc_macro::TokenStream;

/// Marks a function that returns the rows of a constraint.
///
/// Next to the function, the macro generates a module with the kernel, named like the function, and a second
/// module with the suffix `_f32` for single precision. Options: `unilateral`, `per_row`, `real = f32` for a
/// single precision, and those of the command line, such as `outputs(value, jacobian)`, `fixed(b)`,
/// `set(damping = 0.0)`, `layout = packed`, `lanes = 4`, `mode = fast`, `effort = max` or `fma`.
#[proc_macro_attribute]
pub fn constraint(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::function("constraint", options.into(), item.into()).into()
}

/// Marks a function that returns an energy. Options: those of `constraint` but `unilateral` and `per_row`.
#[proc_macro_attribute]
pub fn energy(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::function("energy", options.into(), item.into()).into()
}

/// Marks a function that returns a force for each of its bodies. Options: those of `constraint`, except
/// `unilateral` and `per_row`.
#[proc_macro_attribute]
pub fn force(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::function("force", options.into(), item.into()).into()
}

/// States the values of parameters, `#[domain(rest_length = 0.1..2.0, axis = unit)]`, next to one of the
/// attributes of force functions.
#[proc_macro_attribute]
pub fn domain(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::domain(options.into(), item.into()).into()
}

/// Marks a module of force functions, helpers and constants. The options of a function apply to all of them.
#[proc_macro_attribute]
pub fn forces(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::module(options.into(), item.into()).into()
}

/// Compiles a force file: `include_forces!("joints.rs")` is a public module `joints` with the items of the
/// file and the kernels of its force functions. The path is relative to the calling file. Options may follow,
/// as in `#[forces(…)]`.
#[proc_macro]
pub fn include_forces(input: TokenStream) -> TokenStream {
    forcec::macros::file(input.into()).into()
}
