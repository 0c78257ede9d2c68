//! Every message of the macros, and what they say to Rust that the force language leaves out. `TRYBUILD=overwrite` accepts
//! new messages.

#![cfg(feature = "macros")]

#[test]
fn messages() {
    let cases = trybuild::TestCases::new();
    cases.compile_fail("tests/ui/*.rs");
    cases.pass("tests/ui/pass/*.rs");
}
