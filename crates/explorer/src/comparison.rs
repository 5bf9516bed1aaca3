//! Comparison target: what an instrument records of it, other filters, or a finer method.

use barnard::Result;

use crate::document::Document;
use crate::edit::Edit;
use crate::order::View;

/// The factor by which the method is finer that shows the error of the one in use.
const FINER: f64 = 0.05;
/// The picture that stands beside the scene's own.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum With {
    /// No picture stands beside it.
    #[default]
    Nothing,
    /// Exposure of the scene's instrument.
    Recorded,
    /// Copy of the scene through another set of filters.
    Filters(String),
    /// Copy of the scene by a finer method: the difference is shown, amplified.
    Finer,
}

/// The way in which two pictures share the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Arrangement {
    /// One picture is behind the other, with an edge that is dragged.
    #[default]
    Wipe,
    /// One picture is beside the other.
    SideBySide,
}

/// A comparison of the scene's picture with another.
#[derive(Default)]
pub struct Comparison {
    /// The other picture.
    pub with: With,
    /// The way in which both share the window.
    pub arrangement: Arrangement,
    /// The edge of a wipe as a part of the width; in the middle before it was dragged.
    pub edge: Option<f32>,
    /// The other view, and what it was made of.
    made: Option<(String, With, View)>,
}

impl Comparison {
    /// True if both pictures are looked at as they are, side by side or with an edge between them.
    pub fn is_of_pictures(&self) -> bool {
        matches!(self.with, With::Recorded | With::Filters(_))
    }

    /// The document's view, and the one beside it.
    ///
    /// # Errors
    /// If the scene is none with other filters.
    pub fn views(&mut self, document: &Document) -> Result<Vec<View>> {
        let view = View::of(document);
        let edit = match &self.with {
            With::Nothing => return Ok(vec![view]),
            With::Recorded if view.scene.instrument.is_none() => return Ok(vec![view]),
            With::Recorded => return Ok(vec![view.clone(), View { recorded: true, ..view }]),
            With::Filters(set) => filters(set),
            With::Finer => Edit::set("method", "name", "band_quadrature")
                .and(Edit::set("method", "accuracy", crate::edit::significant((FINER * document.scene().method.accuracy).max(1e-6))))
                .and(Edit::remove("method", "count"))
                .and(Edit::remove("method", "steps")),
        };
        // One text says something else once gas that was known roughly is known exactly.
        let own_text = format!("{}\n{}", document.physics(), document.text());
        let stale = self.made.as_ref().is_none_or(|(text, with, _)| *text != own_text || *with != self.with);
        if stale {
            let (scene, physics) = document.variant(edit)?;
            self.made = Some((own_text, self.with.clone(), View { scene, physics, recorded: false }));
        }
        Ok(std::iter::once(view).chain(self.made.iter().map(|m| m.2.clone())).collect())
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
        .with_name("filters")
}
