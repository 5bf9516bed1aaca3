//! `barnard study`

use std::path::PathBuf;
use std::process::ExitCode;

use barnard_study::{CHAPTERS, Chapter, chapter};
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::progress;

/// Measures every spectral method beside the others and writes tables and figures.
///
/// `study.md` and the figures (CSV, SVG, PNG) go into a folder; all chapters together take some minutes.
#[derive(Args)]
pub struct Study {
    /// A chapter, or all
    #[arg(default_value = "all", value_name = "NAME", value_parser = names())]
    name: String,
    /// The folder, made where it is missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(std::iter::once("all").chain(CHAPTERS.iter().map(|c| c.name)))
}

impl Study {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let chapters: Vec<Chapter> = match self.name.as_str() {
            "all" => CHAPTERS.to_vec(),
            name => vec![*chapter(name)?],
        };
        let control = progress::control()?;
        barnard_study::write(&chapters, &self.output, &control, |chapter| complain!("{}", chapter.title))?;
        say!("wrote {}", self.output.display());
        Ok(ExitCode::SUCCESS)
    }
}
