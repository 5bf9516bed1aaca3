//! Requests of the window to the render thread.

use std::sync::Arc;

use barnard::camera::Camera;
use barnard::scene::Scene;
use spectra::fingerprint::Fingerprint;

use crate::document::Document;

/// The factor by which a difference is amplified, as in Barrès & Neyret's figure.
pub const AMPLIFIED: f32 = 16.0;

/// A picture that is asked for.
#[derive(Clone)]
pub struct View {
    /// The scene that is seen; its camera does not count.
    pub scene: Arc<Scene>,
    /// Text without camera and display: equal texts share a plan.
    pub physics: Fingerprint,
    /// True if it is shown as the scene's instrument records the first view, of which it is.
    pub recorded: bool,
}

impl View {
    /// The view of a document.
    pub fn of(document: &Document) -> Self {
        Self { scene: document.scene().clone(), physics: document.physics(), recorded: false }
    }
}

/// An order for pictures.
#[derive(Clone)]
pub struct Order {
    /// The scene, and what it is compared with.
    pub views: Vec<View>,
    /// The camera, in the pixels of the window.
    pub camera: Camera,
    /// True if a coarse look is enough, since another order will follow.
    pub moving: bool,
    /// True if the scenes are final: those that are known roughly get quick pictures alone.
    pub settles: bool,
    /// True if the second view is shown as its difference from the first.
    pub difference: bool,
    /// The number of times that the levels of pictures were asked for anew.
    pub exposure: u64,
    /// Most bytes that a plan may take.
    pub memory_limit: u64,
}

/// How far a picture is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refinement {
    /// The picture is by a preview of the plan, with fewer pixels than the window has.
    Coarse,
    /// The picture is by a preview of the plan, in all pixels.
    Full,
    /// The picture is by plates of the settled one before: that of `barnard render` to a stated error.
    Exposed,
    /// The picture is the one that `barnard render` makes.
    Settled,
}
