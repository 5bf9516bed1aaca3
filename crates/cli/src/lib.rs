//! The command `barnard` as a library, for programs that bring it along.

/// Prints a line; a reader that closed the pipe stops neither the work nor the file it writes.
macro_rules! say {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        // Words stay out of the way of an image or JSON.
        let _ = match $crate::outputs::STDOUT_IS_TAKEN.load(std::sync::atomic::Ordering::Relaxed) {
            true => writeln!(std::io::stderr(), $($part)*),
            false => writeln!(std::io::stdout(), $($part)*),
        };
    }};
}

/// Prints a line if details are requested.
macro_rules! detail {
    ($($part:tt)*) => {
        if $crate::IS_VERBOSE.load(std::sync::atomic::Ordering::Relaxed) {
            say!($($part)*);
        }
    };
}

/// Prints a line on standard error, ignoring a closed pipe.
macro_rules! complain {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($part)*);
    }};
}

pub mod backends;
mod json;
#[cfg(not(all(feature = "view", feature = "study")))]
mod missing;
mod outputs;
mod progress;
mod source;
mod verbs;

use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{CommandFactory, Parser};

/// Physically calibrated spectral rendering of nebulae.
///
/// Begin with:  barnard render --builtin pleiades -o nebula.png
#[derive(Parser)]
#[command(name = "barnard", version, propagate_version = true)]
struct Cli {
    /// Print error bounds, settings and timings
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Neither read nor write the cache of long computations (see `barnard cache`)
    #[arg(long, global = true)]
    no_cache: bool,
    #[command(subcommand)]
    verb: Option<verbs::Verb>,
}

/// A count with its noun: "1 band", "3 bands".
fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// True if details are requested.
static IS_VERBOSE: AtomicBool = AtomicBool::new(false);

/// True if no cache is used.
static IS_WITHOUT_CACHE: AtomicBool = AtomicBool::new(false);

/// Reference page of all commands (Markdown), from their help.
pub fn manual() -> String {
    let mut command = Cli::command();
    command.build();
    let verbs = command.get_subcommands_mut().filter(|verb| verb.get_name() != "help");
    let sections = verbs.map(|verb| {
        let (name, help) = (verb.get_name().to_owned(), verb.render_long_help().to_string());
        let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
        format!("\n## barnard {name}\n\n```text\n{}\n```\n", lines.join("\n").trim_end())
    });
    let head =
        "# Commands\n\nThis page is generated from the program's help (`BLESS=1 cargo test -p barnard-cli --all-features manual`).\n";
    std::iter::once(head.to_owned()).chain(sections).collect()
}

/// Runs the command with its arguments, the program's own name first; ends the process where they are none that it has.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let Cli { verbose, no_cache, verb } = Cli::parse_from(arguments);
    IS_VERBOSE.store(verbose, Ordering::Relaxed);
    IS_WITHOUT_CACHE.store(no_cache, Ordering::Relaxed);
    let Some(verb) = verb.or_else(verbs::Verb::unsaid) else {
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
