//! `barnard completions`

use std::process::ExitCode;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Prints completions for a shell; for bash: barnard completions bash > ~/.local/share/bash-completion/completions/barnard
#[derive(Args)]
pub struct Completions {
    /// Which shell
    shell: Shell,
}

impl Completions {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        clap_complete::generate(self.shell, &mut crate::Cli::command(), "barnard", &mut std::io::stdout());
        Ok(ExitCode::SUCCESS)
    }
}
