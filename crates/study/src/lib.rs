//! Measurements as generated pages: the [`STUDY`] has every spectral method beside the others,
//! with figures and tables that lie beside those of Barrès & Neyret 2023, the [`VALIDATION`] what is fast beside the
//! path tracer.
//!
//! A chapter is one file and one row of its page's catalogue. It measures, and says in words with numbers what was
//! found. Whether a claim holds is decided by the numbers; why, and what to make of it, is ours.

mod backends;
pub mod bench;
mod campaign;
mod chapters;
mod corner;
mod figure;
pub mod gas;
pub mod maps;
mod page;
mod rules;
mod validation;

use std::path::Path;

use barnard::control::Control;

pub use corner::Corner;
pub use figure::{Axis, Figure, Picture, Series};
use page::Page;

/// Errors of a study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Failure of the renderer, or interruption by the user.
    #[error(transparent)]
    Render(#[from] barnard::Error),
    /// The λ-mathematics failed.
    #[error(transparent)]
    Spectra(#[from] spectra::SpectraError),
    /// The gas of a scene could not be solved.
    #[error(transparent)]
    Gas(#[from] ionisation::error::IonisationError),
    /// A figure could not be drawn.
    #[error("cannot draw the figure {0}: {1}")]
    Figure(String, String),
}

/// The result of functions of this crate.
pub type Result<T> = std::result::Result<T, StudyError>;

/// The findings of a chapter.
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// Figures, each a CSV and two pictures.
    pub figures: Vec<Figure>,
    /// The pictures without axes.
    pub pictures: Vec<Picture>,
    /// Markdown: tables and what they say.
    pub text: String,
}

/// One row of the catalogue of chapters.
#[derive(Clone, Copy)]
pub struct Chapter {
    /// The name on the command line.
    pub name: &'static str,
    /// The headline of the chapter.
    pub title: &'static str,
    /// The question that it answers.
    pub question: &'static str,
    /// Finds the answer.
    pub run: fn(&Control) -> Result<Findings>,
}

/// A page of chapters.
pub struct Book {
    /// The name of its file and of the folder of its figures.
    pub name: &'static str,
    /// The headline of the page.
    pub title: &'static str,
    /// Introduction of the chapters.
    pub preface: &'static str,
    /// The chapters of the page.
    pub chapters: &'static [Chapter],
}

/// Every spectral method beside the others.
pub const STUDY: Book = Book {
    name: "study",
    title: "Comparison of spectral methods",
    preface: "Barrès & Neyret 2023 is a talk at INRIA. Equations are those of [method.md](method.md). Errors are relative to the unattenuated light F(0) unless stated.",
    chapters: chapters::CHAPTERS,
};

/// The page that holds what is fast to the path tracer.
pub const VALIDATION: Book = Book {
    name: "validation",
    title: "Validation",
    preface: "Ground truth is the back end `path`, an unbiased Monte Carlo path tracer without the plan's approximations. Its noise is listed with every error. Equations are those of [method.md](method.md).",
    chapters: validation::CHAPTERS,
};

/// Stated errors beside true ones.
pub const CERTIFICATES: Book = Book {
    name: "certificates",
    title: "Certificates compared with true errors",
    preface: "A certificate bounds the spectral error of a method, including rounding, over all depths of a scene, relative to the unattenuated light F(0) and the attenuated light F(a). This page compares bounds with true errors.",
    chapters: campaign::CHAPTERS,
};

/// All pages of the study.
pub const BOOKS: &[&Book] = &[&STUDY, &VALIDATION, &CERTIFICATES];

impl Book {
    /// The chapter called `name`.
    ///
    /// # Errors
    /// If there is none.
    pub fn chapter(&self, name: &str) -> Result<&'static Chapter> {
        let known: Vec<&str> = self.chapters.iter().map(|c| c.name).collect();
        Ok(self.chapters.iter().find(|c| c.name == name).ok_or_else(|| spectra::SpectraError::unknown("chapter", name, &known))?)
    }
}

/// Runs `chapters` of `book` and writes `BOOK.md`, or `BOOK-NAME.md` where one of several is run alone, into `folder`,
/// with the figures in `folder/BOOK`; `heard` receives each.
///
/// # Errors
/// If a chapter cannot be measured, or a file cannot be written.
pub fn write(book: &Book, chapters: &[Chapter], folder: &Path, control: &Control, mut heard: impl FnMut(&Chapter)) -> Result<()> {
    let book_folder = folder.join(book.name);
    std::fs::create_dir_all(&book_folder).map_err(|e| barnard::Error::file(&book_folder, format!("the folder cannot be made: {e}")))?;
    let mut page = Page::new(book);
    for chapter in chapters {
        heard(chapter);
        let findings = (chapter.run)(control)?;
        for figure in &findings.figures {
            let path = |extension: &str| book_folder.join(format!("{}.{extension}", figure.name));
            barnard_files::formats::replace(&path("csv"), figure.csv().as_bytes())?;
            barnard_files::formats::replace(&path("svg"), figure.svg()?.as_bytes())?;
            barnard_files::formats::replace(&path("png"), &figure.png()?)?;
        }
        for picture in &findings.pictures {
            barnard_files::formats::replace(&book_folder.join(format!("{}.png", picture.name)), &picture.png()?)?;
        }
        page.add(chapter, &findings);
    }
    let name = match chapters {
        [one] if book.chapters.len() > 1 => format!("{}-{}.md", book.name, one.name),
        _ => format!("{}.md", book.name),
    };
    barnard_files::formats::replace(&folder.join(name), page.text().as_bytes())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chapters that time nothing, whole: what they write is there, and their figures hold numbers.
    #[test]
    fn quick_chapters_are_written() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["convergence", "basis_size", "augmentation", "density"] {
            let one = [*STUDY.chapter(name).unwrap()];
            write(&STUDY, &one, folder.path(), &Control::default(), |_| {}).unwrap();
            let page = std::fs::read_to_string(folder.path().join(format!("study-{name}.md"))).unwrap();
            let files: Vec<&str> = page.split("](study/").skip(1).filter_map(|rest| rest.split(')').next()).collect();
            assert!(files.len() == 2 * page.matches("![").count() && !files.is_empty() && page.contains("| --- |"), "{page}");
            for name in files {
                let file = std::fs::read(folder.path().join("study").join(name)).unwrap();
                assert!(file.len() > 200, "{name}");
            }
        }
        let csv = std::fs::read_to_string(folder.path().join("study/convergence.csv")).unwrap();
        let numbers = csv.lines().skip(1).filter_map(|l| l.rsplit(',').next()?.parse::<f64>().ok());
        assert!(numbers.clone().count() > 40 && numbers.into_iter().all(|v| (0.0..1.0).contains(&v)));
    }

    #[test]
    fn stopped_work_stops_and_bad_names_are_refused() {
        assert!(STUDY.chapter("convergance").err().unwrap().to_string().contains("convergence"));
        let control = Control::default();
        control.interrupt();
        for (book, chapter) in BOOKS.iter().flat_map(|book| book.chapters.iter().map(move |chapter| (book, chapter))) {
            let stopped = write(book, &[*chapter], tempfile::tempdir().unwrap().path(), &control, |_| {});
            assert!(matches!(stopped, Err(StudyError::Render(barnard::Error::Interrupted))), "{}", chapter.name);
        }
    }
}
