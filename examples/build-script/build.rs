//! Compiles the force files of `forces`.

fn main() {
    forcec::Build::new().input("forces").run();
}
