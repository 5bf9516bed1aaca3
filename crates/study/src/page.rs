//! The page: chapters as Markdown, with their figures.

use crate::{Book, Chapter, Findings};

/// A page in the making.
pub struct Page<'a> {
    book: &'a Book,
    text: String,
}

impl<'a> Page<'a> {
    /// A page of a book, without chapters.
    pub fn new(book: &'a Book) -> Self {
        Self { book, text: String::new() }
    }

    /// Adds a chapter with its findings.
    pub fn add(&mut self, chapter: &Chapter, findings: &Findings) {
        self.text += &format!("\n## {}\n\n{}\n\n{}\n", chapter.title, chapter.question, findings.text.trim_end());
        let folder = self.book.name;
        for figure in &findings.figures {
            let (title, name) = (&figure.title, &figure.name);
            self.text += &format!("\n![{title}]({folder}/{name}.svg)\n\n*{title}* ([values]({folder}/{name}.csv))\n");
        }
        for picture in &findings.pictures {
            let (title, name) = (&picture.title, &picture.name);
            self.text += &format!("\n![{title}]({folder}/{name}.png)\n\n*{title}*\n");
        }
    }

    /// The whole text of the page.
    pub fn text(&self) -> String {
        format!(
            "# {}\n\nWritten by `barnard study --page {}`, version {}, {} threads. Times are from one run on a shared machine: compare ratios. {}\n{}",
            self.book.title,
            self.book.name,
            env!("CARGO_PKG_VERSION"),
            std::thread::available_parallelism().map_or(1, usize::from),
            self.book.preface,
            self.text
        )
    }
}

/// A table in Markdown.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &mut dyn Iterator<Item = &str>| format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "));
    let mut text = line(&mut head.iter().copied());
    text += &line(&mut head.iter().map(|_| "---"));
    rows.iter().for_each(|row| text += &line(&mut row.iter().map(String::as_str)));
    text + "\n"
}

/// A number in two digits.
pub fn short(v: f64) -> String {
    match v.abs() {
        _ if !v.is_finite() => "-".into(),
        0.0 => "0".into(),
        a if (0.1..100.0).contains(&a) => format!("{v:.2}"),
        a if (100.0..10000.0).contains(&a) => format!("{v:.0}"),
        _ => format!("{v:.1e}"),
    }
}
