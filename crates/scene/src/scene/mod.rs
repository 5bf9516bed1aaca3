//! Scenes: what is in front of the telescope, and the telescope.
//!
//! A [`SceneSpec`] holds objects as they are stated; a [`Scene`] adds what follows from them and is read-only. Scenes are made of
//! objects, or read from a tree of [`properties`](crate::properties). In a tree quantities are texts with units, and unknown keys
//! are refused with the nearest known one. Every table with a `kind` reads a catalogue; the catalogues also make the manual of the
//! scene format.

mod albedo;
mod backends;
mod background;
mod band;
mod catalogue;
mod check;
mod detail;
mod display;
mod dust;
mod emission;
mod fields;
mod film;
mod gas;
mod glare;
mod inspect;
mod instrument;
mod loader;
mod method;
mod motion;
mod observation;
mod output;
mod parameters;
mod parts;
mod proper_motion;
mod read;
mod root;
pub mod schema;
mod spec;
mod species;
mod spectrograph;
mod star;
mod star_table;

use std::ops::Deref;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::Fingerprint;

pub use albedo::Albedo;
pub use backends::{BackendOptions, PathOptions, REFERENCE_ACCURACY};
pub use background::{Background, StarField};
pub use dust::{Dust, Scale};
pub use fields::Fields;
pub use film::Film;
pub use gas::{Gas, GasCloud, IonisedGas, IonisingStar};
pub use inspect::inspect;
pub use ionisation::tracer::RayTracer;
pub use loader::Loader;
pub use method::{MANY_BOUNCES, MAX_STEPS, Method, MethodEntry, Sparsity, StarDepthSource, methods};
pub use parameters::{Parameter, parameter, parameters};
pub use parts::{Part, Parts};
pub use spec::SceneSpec;
pub use species::{Emission, Motion};
pub use spectrograph::Spectrograph;
pub use star::Star;

use crate::animation::Timeline;
use crate::camera::Camera;
use crate::control::Control;
use crate::error::Result;
use crate::field::Field;
use crate::image::{Display, LayerChoice};
use crate::memory;

/// A complete scene: the stated objects, which it derefs to, and the emitting gas that follows from them.
///
/// Objects cannot be changed in place, so that gas is always that of its stars: [`edited`](Self::edited) makes another scene.
#[derive(Debug, Clone)]
pub struct Scene {
    spec: SceneSpec,
    species: Vec<Emission>,
    /// Fingerprint of all that the species are derived from.
    species_from: Fingerprint,
    ionised: Option<Arc<IonisedGas>>,
    /// Fingerprint of all that the ionised gas is derived from.
    ionised_from: Fingerprint,
}

impl Deref for Scene {
    type Target = SceneSpec;

    fn deref(&self) -> &SceneSpec {
        &self.spec
    }
}

/// The text that a scene was read from.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// The text.
    pub text: Arc<str>,
    /// The files that were read for it, the scene's own first.
    pub files: Vec<PathBuf>,
}

/// (name, summary) of the kinds of spectrum that stars and backgrounds choose from.
pub fn star_spectra() -> impl Iterator<Item = (&'static str, &'static str)> {
    star::SPECTRA.iter().map(|k| (k.name, k.summary))
}

/// (name, summary) of the kinds of glowing gas.
pub fn emission_kinds() -> impl Iterator<Item = (&'static str, &'static str)> {
    emission::KINDS.iter().map(|k| (k.name, k.summary))
}

/// (name, summary) of the kinds of passband.
pub fn band_kinds() -> impl Iterator<Item = (&'static str, &'static str)> {
    band::KINDS.iter().map(|k| (k.name, k.summary))
}

/// (name, summary) of the kinds of field.
pub fn field_kinds() -> impl Iterator<Item = (&'static str, &'static str)> {
    fields::kinds().into_iter().map(|k| (k.name, k.summary))
}

impl Provenance {
    /// SHA-256 of the text, in hexadecimal digits.
    pub fn digest(&self) -> String {
        use sha2::{Digest, Sha256};
        Sha256::digest(self.text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl From<&Scene> for Arc<Scene> {
    /// A shared copy of the scene; large parts are shared with it.
    fn from(scene: &Scene) -> Self {
        Self::new(scene.clone())
    }
}

impl Scene {
    /// All species of emitting gas: the stated ones, then those of the ionised gas. Moving gas has one for each velocity.
    pub fn species(&self) -> &[Emission] {
        &self.species
    }

    /// State of the gas that the stars ionise.
    pub fn ionised(&self) -> Option<&Arc<IonisedGas>> {
        self.ionised.as_ref()
    }

    /// Densities of the dust, then of each species.
    pub fn densities(&self) -> impl Iterator<Item = &Arc<dyn Field>> {
        self.dust.iter().map(|dust| &dust.density).chain(self.species.iter().map(|species| &species.density))
    }

    /// Variant with changed objects; gas is solved again if something it depends on changed.
    ///
    /// # Errors
    /// Errors of [`SceneSpec::build`].
    pub fn edited(&self, edit: impl FnOnce(&mut SceneSpec)) -> Result<Self> {
        self.edited_within(memory::DEFAULT_LIMIT, &Control::default(), edit)
    }

    /// Variant of [`edited`](Self::edited) with a memory limit \[bytes\], progress and interruption.
    ///
    /// # Errors
    /// Errors of [`SceneSpec::build_within`].
    pub fn edited_within(&self, memory_limit: u64, control: &Control, edit: impl FnOnce(&mut SceneSpec)) -> Result<Self> {
        let mut spec = self.spec.clone();
        edit(&mut spec);
        spec.build_from(Some(self), memory_limit, control)
    }

    /// The objects with every species as a light of its own, whatever ionised or moved it.
    #[must_use]
    pub fn as_lights(&self) -> SceneSpec {
        SceneSpec { emission: self.species.clone(), gas: None, ..self.spec.clone() }
    }

    /// Copy with the text that it was read from.
    #[must_use]
    pub fn with_provenance(mut self, provenance: impl Into<Option<Provenance>>) -> Self {
        self.spec.provenance = provenance.into();
        self
    }

    /// Copy as a moment of an animation.
    #[must_use]
    pub fn with_timeline(mut self, timeline: Arc<Timeline>) -> Self {
        self.spec.timeline = Some(timeline);
        self
    }

    /// Copy with other layers.
    #[must_use]
    pub fn with_layers(mut self, layers: LayerChoice) -> Self {
        self.spec.output.layers = layers;
        self
    }

    /// Copy with another display.
    #[must_use]
    pub fn with_display(mut self, display: Display) -> Self {
        self.spec.display = display;
        self
    }

    /// Copy with a star at another position \[pc\] in gas as it is: a first look while the star is moved.
    #[must_use]
    pub fn with_moved_star(mut self, star: usize, position: DVec3) -> Self {
        self.spec.stars[star].position = position;
        self
    }

    /// Copy through another camera; lines of moving gas keep the shifts that the camera of the scene sees.
    #[must_use]
    pub fn with_camera(mut self, camera: Camera) -> Self {
        self.spec.camera = camera;
        self
    }

    /// Copy with another method or accuracy.
    #[must_use]
    pub fn with_method(mut self, method: Method) -> Self {
        self.spec.method = method;
        self
    }
}
