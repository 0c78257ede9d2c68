//! How compile time grows with a kernel.
//!
//!     cargo run --release -p forcec-bench --bin growth

fn main() {
    print!("{}", forcec_bench::document::growth_table(&[220, 2200, 22_000]));
}
