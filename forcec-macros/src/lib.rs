//! The attribute macros of forcec. Use them through `forcec-runtime`, which has the types they speak of.
//!
//! A macro hands its tokens to the compiler and returns what that makes of them, kernels or messages.

use proc_macro::TokenStream;

/// Marks a function that returns the rows of a constraint.
///
/// Beside the function stands a module of the same name, the kernel, and one with `_f32` behind it in single precision.
/// Options: `unilateral`, `per_row`, `real = f32` for one precision only, and those of the command line: `outputs(value, jacobian)`,
/// `fixed(b)`, `set(damping = 0.0)`, `layout = packed`, `lanes = 4`, `mode = fast`, `effort = max`, `fma`.
#[proc_macro_attribute]
pub fn constraint(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::function("constraint", options.into(), item.into()).into()
}

/// Marks a function that returns an energy; otherwise as `constraint`, with the options but `unilateral` and `per_row`.
#[proc_macro_attribute]
pub fn energy(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::function("energy", options.into(), item.into()).into()
}

/// Marks a function that returns a force for each of its bodies; otherwise as `constraint`, with the options but `unilateral` and `per_row`.
#[proc_macro_attribute]
pub fn force(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::function("force", options.into(), item.into()).into()
}

/// States what values parameters have, `#[domain(rest_length = 0.1..2.0, axis = unit)]`; beside one of the attributes of
/// force functions.
#[proc_macro_attribute]
pub fn domain(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::domain(options.into(), item.into()).into()
}

/// Marks a module of force functions and the helpers and constants they use. Options are those of a function, for all of them.
#[proc_macro_attribute]
pub fn forces(options: TokenStream, item: TokenStream) -> TokenStream {
    forcec::macros::module(options.into(), item.into()).into()
}

/// Compiles a force file: `include_forces!("joints.rs")` is a public module `joints` with all that stands in the file and
/// the kernels of its force functions. The path counts from the file that calls. Options may follow, as in `#[forces(…)]`.
#[proc_macro]
pub fn include_forces(input: TokenStream) -> TokenStream {
    forcec::macros::file(input.into()).into()
}
