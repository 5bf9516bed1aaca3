//! What the window asks of the worker behind it.

use std::sync::Arc;

use barnard::camera::Camera;
use barnard::scene::Scene;

use crate::document::Document;

/// By how much a difference is amplified, as in Barrès & Neyret's figure.
pub const AMPLIFIED: f32 = 16.0;

/// One picture that is asked for.
#[derive(Clone)]
pub struct View {
    /// What is seen; its camera does not count.
    pub scene: Arc<Scene>,
    /// What its text says beside camera and display: equal texts are one plan.
    pub physics: Arc<str>,
}

impl View {
    /// Of a document.
    pub fn of(document: &Document) -> Self {
        Self { scene: document.scene().clone(), physics: document.physics().clone() }
    }
}

/// What is asked for.
#[derive(Clone)]
pub struct Order {
    /// The scene, and what it is compared with.
    pub views: Vec<View>,
    /// From where, in the pixels of the window.
    pub camera: Camera,
    /// Whether a coarse look is enough, since another order will follow.
    pub moving: bool,
    /// Whether the second view is shown as what the first differs from it.
    pub difference: bool,
    /// How often the levels that pictures are shown by were asked for anew.
    pub exposure: u64,
    /// Most bytes that a plan may take.
    pub memory_limit: u64,
}

/// How far a picture has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// By a quick plan, with fewer pixels than the window has.
    Coarse,
    /// By a quick plan, in all pixels.
    Full,
    /// As `barnard render` makes it.
    Settled,
}
