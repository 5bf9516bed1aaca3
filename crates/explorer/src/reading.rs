//! Reading of a text: its tables and its scene.

use std::sync::Arc;

use barnard::Result;
use barnard::scene::{Loader, Part, Provenance, Scene};
use barnard::sequence::{Follower, Sequence};
use barnard_files::toml;
use spectra::fingerprint::{Digest, Fingerprint};
use toml_edit::DocumentMut;

use crate::origin::Origin;

/// A text and what it says.
pub(crate) struct Reading {
    /// The tables of the text.
    pub toml: DocumentMut,
    /// The scene that it means.
    pub scene: Arc<Scene>,
    /// Fingerprint of all that a plan depends on but the camera.
    pub physics: Fingerprint,
    /// The scene over time, if it changes.
    pub followed: Option<Follower>,
}

/// Reads a text. An opening has a number: files of equal texts may differ.
pub(crate) fn read(origin: &Origin, text: &str, loader: &Loader, opening: u64) -> Result<Reading> {
    let (file, name) = origin.names();
    let properties = toml::properties(&file, text)?;
    let scene = Scene::from_properties(&properties, &name, loader)?;
    let files = if let Origin::File(path) = origin { vec![path.clone()] } else { Vec::new() };
    let scene = scene.with_provenance(Provenance { text: text.into(), files });
    let mut followed = None;
    if scene.timeline.is_some() {
        let sequence = Sequence::new(properties, loader.clone(), &scene)?;
        followed = Some(Follower::new(&sequence));
    }
    let physics = physics(&scene, opening);
    Ok(Reading { toml: edited(text)?, scene: Arc::new(scene), physics, followed })
}

/// Fingerprint of all that a plan of a scene depends on but the camera, and of the opening of the document.
pub(crate) fn physics(scene: &Scene, opening: u64) -> Fingerprint {
    let parts = scene.parts();
    let mut digest = Digest::new("physics");
    digest.integer(opening).part(parts.physics());
    // Stars of a catalogue are where the observation places them.
    if scene.background.catalogue.is_some() {
        digest.part(parts.get(Part::Observation));
    }
    digest.finish()
}

/// The text as edits change it.
pub(crate) fn edited(text: &str) -> Result<DocumentMut> {
    text.parse().map_err(|e: toml_edit::TomlError| toml::error(text, &e))
}
