//! Tests of the compiler as a whole; everything is in `tests/`.
