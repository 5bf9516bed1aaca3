//! `barnard study`

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::bail;
use barnard_study::{BOOKS, Book, Chapter};
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::progress;

/// Compares all spectral methods, or the fast back ends with the path tracer, and writes tables and
/// figures.
///
/// Writes the page (study.md or validation.md) and figures (CSV, SVG, PNG) into a folder. All chapters take
/// some minutes.
#[derive(Args)]
pub struct Study {
    /// Chapter, or all
    #[arg(default_value = "all", value_name = "NAME", value_parser = chapters())]
    name: String,
    /// Page
    #[arg(long, default_value = BOOKS[0].name, value_name = "PAGE", value_parser = pages())]
    page: String,
    /// Output folder, created if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

fn chapters() -> PossibleValuesParser {
    PossibleValuesParser::new(std::iter::once("all").chain(BOOKS.iter().flat_map(|book| book.chapters.iter().map(|c| c.name))))
}

fn pages() -> PossibleValuesParser {
    PossibleValuesParser::new(BOOKS.iter().map(|book| book.name))
}

impl Study {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let Some(book) = BOOKS.iter().find(|book: &&&Book| book.name == self.page) else { bail!("unknown page {}", self.page) };
        let chapters: Vec<Chapter> = match self.name.as_str() {
            "all" => book.chapters.to_vec(),
            name => vec![*book.chapter(name)?],
        };
        let control = progress::control()?;
        barnard_study::write(book, &chapters, &self.output, &control, |chapter| complain!("{}", chapter.title))?;
        say!("wrote {}", self.output.display());
        Ok(ExitCode::SUCCESS)
    }
}
