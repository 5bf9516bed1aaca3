//! Verbs of a program that was built without them.

use std::process::ExitCode;

use anyhow::bail;
use clap::Args;

/// A verb that is not there.
#[derive(Args)]
#[command(disable_help_flag = true)]
pub struct Missing {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _rest: Vec<String>,
}

impl Missing {
    /// Says how the program is built with it.
    pub fn run(self, verb: &str, feature: &str) -> anyhow::Result<ExitCode> {
        bail!("this build has no `barnard {verb}`; build it with: cargo run --release -F {feature} -- {verb}")
    }
}
