//! The command `barnard`: what any telescope would see of a three-dimensional nebula, in true units.

fn main() -> std::process::ExitCode {
    barnard_cli::run(std::env::args_os())
}
