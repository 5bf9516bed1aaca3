//! The command `barnard`: what any telescope would see of a three-dimensional nebula, in true units.

/// Prints a line; a reader that closed the pipe stops neither the work nor the file it writes.
macro_rules! say {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($part)*);
    }};
}

/// Prints a line on standard error; whoever closed that hears nothing.
macro_rules! complain {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($part)*);
    }};
}

mod backends;
#[cfg(not(all(feature = "view", feature = "study")))]
mod missing;
mod progress;
mod source;
mod verbs;

use clap::{CommandFactory, Parser};

/// Physically calibrated spectral rendering of nebulae.
///
/// Begin with:  barnard render --builtin reflection_nebula -o nebula.png
#[derive(Parser)]
#[command(name = "barnard", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    verb: Option<verbs::Verb>,
}

fn main() -> std::process::ExitCode {
    let Some(verb) = Cli::parse().verb.or_else(verbs::Verb::unsaid) else {
        // As where clap itself misses a verb: the help, and a failure.
        let _ = Cli::command().write_help(&mut std::io::stderr());
        return std::process::ExitCode::from(2);
    };
    match verb.run() {
        Ok(code) => code,
        Err(error) => {
            // A reader that closed the pipe has seen enough.
            if error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe) {
                return std::process::ExitCode::SUCCESS;
            }
            let flag = match error.downcast_ref::<barnard::Error>() {
                Some(barnard::Error::Memory { .. }) => " (--memory)",
                Some(barnard::Error::Device(_)) => " (--backend cpu)",
                Some(barnard::Error::Interrupted) => "; nothing was written",
                _ => "",
            };
            complain!("barnard: {error:#}{flag}");
            std::process::ExitCode::FAILURE
        }
    }
}
