//! `barnard study`

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::bail;
use barnard_study::{BOOKS, Book, Chapter};
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::progress;

/// Measures every spectral method beside the others, or what is fast beside the path tracer, and writes tables and
/// figures.
///
/// The page (study.md or validation.md) and the figures (CSV, SVG, PNG) go into a folder; all chapters together take
/// some minutes.
#[derive(Args)]
pub struct Study {
    /// A chapter, or all
    #[arg(default_value = "all", value_name = "NAME", value_parser = chapters())]
    name: String,
    /// Which page
    #[arg(long, default_value = BOOKS[0].name, value_name = "PAGE", value_parser = pages())]
    page: String,
    /// The folder, made where it is missing
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
        let Some(book) = BOOKS.iter().find(|book: &&&Book| book.name == self.page) else { bail!("no page is called {}", self.page) };
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
