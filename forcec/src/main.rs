//! The `forcec` command.

fn main() -> std::process::ExitCode {
    forcec::cli::main()
}
