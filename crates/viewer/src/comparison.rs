//! What the scene is compared with: other filters, or a finer method.

use barnard::Result;

use crate::document::Document;
use crate::edit::Edit;
use crate::order::View;

/// How much finer the method is that shows the error of the one in use.
const FINER: f64 = 0.05;
/// What stands beside the scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum With {
    /// Nothing.
    #[default]
    Nothing,
    /// The same through another set of filters.
    Filters(String),
    /// The same by a finer method: the difference is shown, amplified.
    Finer,
}

/// How two pictures share the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Arrangement {
    /// One behind the other, with an edge that is dragged.
    #[default]
    Wipe,
    /// One beside the other.
    SideBySide,
}

/// A comparison.
#[derive(Default)]
pub struct Comparison {
    /// What with.
    pub with: With,
    /// How.
    pub arrangement: Arrangement,
    /// Where the edge of a wipe is, as a part of the width; the middle before it was dragged.
    pub edge: Option<f32>,
    /// The other view, and what it was made of.
    made: Option<(String, With, View)>,
}

impl Comparison {
    /// The document's view, and the one beside it.
    ///
    /// # Errors
    /// Where the scene is none with other filters.
    pub fn views(&mut self, document: &Document) -> Result<Vec<View>> {
        let own = View::of(document);
        let edit = match &self.with {
            With::Nothing => return Ok(vec![own]),
            With::Filters(set) => filters(set),
            With::Finer => Edit::set("method", "name", "band_quadrature")
                .and(Edit::set("method", "accuracy", crate::edit::significant((FINER * document.scene().method.accuracy).max(1e-6))))
                .and(Edit::remove("method", "count"))
                .and(Edit::remove("method", "steps")),
        };
        let stale = self.made.as_ref().is_none_or(|(text, with, _)| text != document.text() || *with != self.with);
        if stale {
            let (scene, physics) = document.variant(edit)?;
            self.made = Some((document.text().to_owned(), self.with.clone(), View { scene, physics }));
        }
        Ok(std::iter::once(own).chain(self.made.iter().map(|m| m.2.clone())).collect())
    }
}

/// Another set of filters, in colours of its own.
pub fn filters(set: &str) -> Edit {
    Edit::set("", "bands", set)
        .and(Edit::remove("", "band"))
        .and(Edit::remove("display", "palette"))
        .and(Edit::remove("display", "matrix"))
        .and(Edit::remove("display", "white"))
        .and(Edit::remove("display", "black"))
        .named("filters")
}
