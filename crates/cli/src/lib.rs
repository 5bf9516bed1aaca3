//! The command `barnard` as a library, for programs that bring it along.

/// Prints a line; a reader that closed the pipe stops neither the work nor the file it writes.
macro_rules! say {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        // Words stay out of a picture's way.
        let _ = match $crate::outputs::IS_PICTURE.load(std::sync::atomic::Ordering::Relaxed) {
            true => writeln!(std::io::stderr(), $($part)*),
            false => writeln!(std::io::stdout(), $($part)*),
        };
    }};
}

/// Prints a line on standard error; whoever closed that hears nothing.
macro_rules! complain {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($part)*);
    }};
}

pub mod backends;
#[cfg(not(all(feature = "view", feature = "study")))]
mod missing;
mod outputs;
mod progress;
mod source;
mod verbs;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

/// Physically calibrated spectral rendering of nebulae.
///
/// Begin with:  barnard render --builtin pleiades -o nebula.png
#[derive(Parser)]
#[command(name = "barnard", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    verb: Option<verbs::Verb>,
}

/// Runs the command with its arguments, the program's own name first; ends the process where they are none that it has.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let Some(verb) = Cli::parse_from(arguments).verb.or_else(verbs::Verb::unsaid) else {
        // As where clap itself misses a verb: the help, and a failure.
        let _ = Cli::command().write_help(&mut std::io::stderr());
        return ExitCode::from(2);
    };
    match verb.run() {
        Ok(code) => code,
        Err(error) => {
            // A reader that closed the pipe has seen enough.
            if error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe) {
                return ExitCode::SUCCESS;
            }
            let flag = match error.downcast_ref::<barnard::Error>() {
                Some(barnard::Error::Memory { .. }) => " (--memory)",
                Some(barnard::Error::Device(_)) => " (--backend cpu)",
                Some(barnard::Error::Interrupted) => "; nothing was written",
                _ => "",
            };
            complain!("barnard: {error:#}{flag}");
            ExitCode::FAILURE
        }
    }
}
