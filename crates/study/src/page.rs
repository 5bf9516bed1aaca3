//! The page: chapters as Markdown, with their figures.

use crate::{Chapter, Findings};

/// A page in the making.
#[derive(Debug, Default)]
pub struct Page {
    text: String,
}

impl Page {
    /// Adds a chapter.
    pub fn add(&mut self, chapter: &Chapter, findings: &Findings) {
        self.text += &format!("\n## {}\n\n{}\n\n{}\n", chapter.title, chapter.question, findings.text.trim_end());
        for figure in &findings.figures {
            self.text +=
                &format!("\n![{}](study/{}.svg)\n\n*{}* ([values](study/{}.csv))\n", figure.title, figure.name, figure.title, figure.name);
        }
        for picture in &findings.pictures {
            self.text += &format!("\n![{}](study/{}.png)\n\n*{}*\n", picture.title, picture.name, picture.title);
        }
    }

    /// All of it.
    pub fn text(&self) -> String {
        format!(
            "# Spectral methods, side by side\n\nWritten by `barnard study`, version {}, on {} threads of one machine; times are of one run on a shared machine, so ratios count. \
             \"The deck\" is Barrès & Neyret 2023; equations are numbered as in [method.md](method.md). Errors are parts of the light without dust, F(0), unless said otherwise.\n{}",
            env!("CARGO_PKG_VERSION"),
            std::thread::available_parallelism().map_or(1, usize::from),
            self.text
        )
    }
}

/// A Markdown table.
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
