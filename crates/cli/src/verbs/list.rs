//! `barnard list`

use std::io::Write;
use std::process::ExitCode;

use barnard_files::catalogue::{CATALOGUES, Catalogue};
use clap::Args;

use crate::backends::registry;

/// Prints a catalogue, one entry per line: name and summary. Without a name, lists the catalogues.
#[derive(Args)]
pub struct List {
    /// Name of a catalogue
    catalogue: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl List {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let rows: Vec<(String, String)> = match &self.catalogue {
            None => CATALOGUES.iter().map(|c| (c.name.to_owned(), c.summary.to_owned())).collect(),
            // What this program was built with, not what a library has.
            Some(name) if name == "backends" => {
                registry().entries().iter().map(|entry| (entry.name.to_owned(), entry.summary.to_owned())).collect()
            }
            Some(name) => (Catalogue::by_name(name)?.rows)(),
        };
        let mut out = std::io::stdout().lock();
        if self.json {
            let list: Vec<_> = rows.iter().map(|(name, summary)| serde_json::json!({ "name": name, "summary": summary })).collect();
            writeln!(out, "{}", serde_json::to_string_pretty(&list)?)?;
            return Ok(ExitCode::SUCCESS);
        }
        let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, summary) in rows {
            writeln!(out, "{name:width$}  {summary}")?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
