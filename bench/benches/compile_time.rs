//! `cargo bench -p forcec-bench`: how long compiling takes, for the library and for kernels of any size.

use divan::Bencher;
use forcec::internals::source::span::Source;
use forcec_bench::{chain, compile_all, library};

fn main() {
    divan::main();
}

/// Every file of the library, from text to statements.
#[divan::bench]
fn whole_library(bencher: Bencher<'_, '_>) {
    let sources = library();
    bencher.bench(|| sources.iter().map(compile_all).collect::<Vec<_>>());
}

fn kernels() -> Vec<String> {
    library().iter().flat_map(|source| compile_all(source).names).collect()
}

/// One kernel of the library, including the front end for the whole file.
#[divan::bench(args = kernels())]
fn kernel(bencher: Bencher<'_, '_>, name: &str) {
    let has = |source: &Source| source.text.contains(&format!("fn {name}("));
    let source = library().into_iter().find(has).expect("the file of the kernel");
    bencher.bench(|| {
        forcec::internals::compile::compile(&source, &|wanted| wanted == name, forcec::Effort::Default)
            .is_ok()
    });
}

/// Made-up kernels of about 1e4 and 1e5 nodes.
#[divan::bench(args = [220, 2200], sample_count = 5, sample_size = 1)]
fn chain_of_helpers(bencher: Bencher<'_, '_>, links: usize) {
    let source = chain(links);
    bencher.bench(|| compile_all(&source));
}
