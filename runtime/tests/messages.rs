//! The messages of the macros, also for Rust that is not part of the force language. `TRYBUILD=overwrite` accepts new
//! messages.

#![cfg(feature = "macros")]

#[test]
fn messages() {
    let cases = trybuild::TestCases::new();
    cases.compile_fail("tests/ui/*.rs");
    cases.pass("tests/ui/pass/*.rs");
}
