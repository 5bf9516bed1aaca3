//! Objects of a scene as they are stated, and the scene that follows from them.

use std::collections::BTreeMap;
use std::sync::Arc;

use spectra::fingerprint::{Digest, Fingerprint};
use spectra::passband::{self, Passband};

use super::check::at;
use super::gas::{Solver, sources};
use super::{Background, Dust, Emission, Gas, IonisedGas, Method, Provenance, Scene, Spectrograph, Star, fields};
use crate::animation::Timeline;
use crate::camera::Camera;
use crate::control::Control;
use crate::data::InputNote;
use crate::detail::Detail;
use crate::error::Result;
use crate::image::{Display, Output};
use crate::instrument::Instrument;
use crate::memory;
use crate::observation::Observation;

/// Objects of a scene, freely changed until [`build`](Self::build) makes the [`Scene`] that follows from them.
///
/// # Examples
/// Gas that is ionised by the stars of its scene, and again once a star has changed:
/// ```
/// use barnard_scene::Camera;
/// use barnard_scene::field::Sphere;
/// use barnard_scene::glam::{DVec3, dvec3};
/// use barnard_scene::scene::{Gas, SceneSpec, Star};
/// use spectra::units::{Luminosity, Temperature};
///
/// let gas = Gas::new(Sphere::new(DVec3::ZERO, 1.0)?).with_voxels(12);
/// let star = Star::blackbody(Temperature(40_000.0), Luminosity::suns(1e5));
/// let spec = SceneSpec::new(Camera::look_at(dvec3(0.0, 0.0, 8.0), DVec3::ZERO)).with_star(star).with_gas(gas);
/// let scene = spec.build()?;
/// assert!(scene.ionised().is_some_and(|gas| gas.temperature.is_some()) && !scene.species().is_empty());
/// let dark = scene.edited(|spec| spec.stars.clear())?;
/// assert!(dark.ionised().is_some_and(|gas| gas.temperature.is_none()));
/// # Ok::<(), barnard_scene::Error>(())
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SceneSpec {
    /// Name of the scene.
    pub name: String,
    /// Description of the scene, in sentences.
    pub description: String,
    /// Camera.
    pub camera: Camera,
    /// Cameras by name, for views to return to.
    pub bookmarks: BTreeMap<String, Camera>,
    /// Dust that absorbs and scatters.
    pub dust: Option<Dust>,
    /// Emitting gas as stated; [`Scene::species`] has all emitting gas, ionised gas included.
    pub emission: Vec<Emission>,
    /// Gas that the stars ionise.
    pub gas: Option<Gas>,
    /// Stars within or near the cloud: those of `[[star]]`, then those of each `[[star_table]]`.
    pub stars: Vec<Star>,
    /// Background.
    pub background: Background,
    /// Density detail below the voxel size; `None` for densities as smooth as their grids.
    pub detail: Option<Detail>,
    /// Passbands of the telescope.
    pub bands: Vec<Passband>,
    /// Spectrograph whose channels are the first passbands.
    pub spectrograph: Option<Spectrograph>,
    /// Display settings of the picture.
    pub display: Display,
    /// Position on the sky, if stated.
    pub observation: Option<Observation>,
    /// Instrument, if stated.
    pub instrument: Option<Arc<Instrument>>,
    /// Additional contents of files and their encoding.
    pub output: Output,
    /// Method of spectral integrals.
    pub method: Method,
    /// Animation and its frames; `None` for a scene that does not change.
    pub timeline: Option<Arc<Timeline>>,
    /// True if what takes long is made roughly, as a [loader](super::Loader::roughly) requests.
    pub is_rough: bool,
    /// Text that the scene was read from; `None` if a program made it.
    pub provenance: Option<Provenance>,
    /// Interpretations of the files that were read for the scene, without those of an earlier reading.
    pub inputs: Vec<InputNote>,
}

impl SceneSpec {
    /// Empty scene in front of `camera`, in the passbands of Johnson, with the default method.
    pub fn new(camera: Camera) -> Self {
        let bands = passband::set("johnson").unwrap_or_default();
        Self {
            name: "scene".into(),
            description: String::new(),
            camera,
            bookmarks: BTreeMap::new(),
            dust: None,
            emission: Vec::new(),
            gas: None,
            stars: Vec::new(),
            background: Background::default(),
            detail: None,
            spectrograph: None,
            display: Display::of(&bands),
            observation: None,
            instrument: None,
            output: Output::default(),
            bands,
            method: Method::default(),
            timeline: None,
            is_rough: false,
            provenance: None,
            inputs: Vec::new(),
        }
    }

    /// Copy under another name.
    #[must_use]
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Copy with other passbands and their default display.
    #[must_use]
    pub fn with_bands(self, bands: Vec<Passband>) -> Self {
        Self { display: Display::of(&bands), bands, spectrograph: None, ..self }
    }

    /// Copy with this dust in place of any before.
    #[must_use]
    pub fn with_dust(self, dust: Dust) -> Self {
        Self { dust: Some(dust), ..self }
    }

    /// Copy with one more species of emitting gas.
    #[must_use]
    pub fn with_emission(mut self, emission: Emission) -> Self {
        self.emission.push(emission);
        self
    }

    /// Copy with gas that the stars ionise, in place of any before.
    #[must_use]
    pub fn with_gas(self, gas: Gas) -> Self {
        Self { gas: Some(gas), ..self }
    }

    /// Copy with one more star.
    #[must_use]
    pub fn with_star(mut self, star: Star) -> Self {
        self.stars.push(star);
        self
    }

    /// Copy with another background.
    #[must_use]
    pub fn with_background(self, background: Background) -> Self {
        Self { background, ..self }
    }

    /// Copy with density detail below the voxel size.
    #[must_use]
    pub fn with_detail(self, detail: Detail) -> Self {
        Self { detail: Some(detail), ..self }
    }

    /// Copy at a position on the sky.
    #[must_use]
    pub fn with_observation(self, observation: Observation) -> Self {
        Self { observation: Some(observation), ..self }
    }

    /// Copy recorded by an instrument.
    #[must_use]
    pub fn with_instrument(self, instrument: Instrument) -> Self {
        Self { instrument: Some(Arc::new(instrument)), ..self }
    }

    /// Copy with another method or accuracy.
    #[must_use]
    pub fn with_method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// The scene of these objects: gas is ionised, and lines of moving gas are shifted, within the default memory limit.
    ///
    /// # Errors
    /// If the gas or its motion cannot be solved, and errors of [`Scene::check`].
    pub fn build(self) -> Result<Scene> {
        self.build_within(memory::DEFAULT_LIMIT, &Control::default())
    }

    /// Variant of [`build`](Self::build) with a memory limit \[bytes\], progress and interruption.
    ///
    /// # Errors
    /// Errors of [`build`](Self::build), if the limit does not suffice, and on interruption by the user.
    pub fn build_within(self, memory_limit: u64, control: &Control) -> Result<Scene> {
        self.build_from(None, memory_limit, control)
    }

    /// The scene, with the gas of an earlier scene if nothing that it depends on differs.
    pub(super) fn build_from(self, earlier: Option<&Scene>, memory_limit: u64, control: &Control) -> Result<Scene> {
        let sources = self.sources();
        let ionised = match (earlier.filter(|scene| scene.ionised_from == sources.0), &self.gas) {
            (Some(scene), _) => scene.ionised.clone(),
            (None, None) => None,
            (None, Some(gas)) => {
                let solver = Solver { is_rough: self.is_rough, memory_limit, tracer: None, cache: None, control };
                Some(Arc::new(gas.ionised_by(&self.stars, &self.bands, &solver)?.with_fronts()))
            }
        };
        let species = match earlier.filter(|scene| scene.species_from == sources.1) {
            Some(scene) => scene.species.clone(),
            None => self.species(ionised.as_deref(), memory_limit, control)?,
        };
        self.derived(ionised, species, sources)
    }

    /// The scene with what was derived from these `sources`.
    pub(super) fn derived(
        self,
        ionised: Option<Arc<IonisedGas>>,
        species: Vec<Emission>,
        (ionised_from, species_from): (Fingerprint, Fingerprint),
    ) -> Result<Scene> {
        let scene = Scene { spec: self, species, species_from, ionised, ionised_from };
        scene.check()?;
        Ok(scene)
    }

    /// All emitting gas: each emission and the glow of ionised gas, with the lines of moving gas shifted.
    pub(super) fn species(&self, ionised: Option<&IonisedGas>, memory_limit: u64, control: &Control) -> Result<Vec<Emission>> {
        let stated = self.emission.iter().enumerate().map(|(number, emission)| (format!("emission[{number}]"), emission));
        let glow = ionised.iter().flat_map(|gas| &gas.species).map(|species| ("gas".to_owned(), species));
        let shifted =
            |(path, species): (String, &Emission)| at(&path, fields::VELOCITY.name, species.shifted(&self.camera, memory_limit, control));
        Ok(stated.chain(glow).map(shifted).collect::<Result<Vec<_>>>()?.concat())
    }

    /// Fingerprints of all that the ionised gas, and all species, are derived from.
    pub(super) fn sources(&self) -> (Fingerprint, Fingerprint) {
        let mut ionised = Digest::new("ionised gas");
        if let Some(gas) = &self.gas {
            ionised.part(gas.fingerprint()).part(sources(&self.stars, &self.bands)).plain(&self.is_rough);
        }
        let ionised = ionised.finish();
        let mut species = Digest::new("species");
        species.part(ionised);
        for emission in &self.emission {
            species.part(emission.fingerprint());
        }
        // Shifts of lines depend on the line of sight.
        if self.emission.iter().map(|emission| &emission.motion).chain(self.gas.iter().map(|gas| &gas.motion)).any(Option::is_some) {
            let Camera { projection, position, forward, .. } = &self.camera;
            species.plain(projection).numbers(&position.to_array()).numbers(&forward.to_array());
        }
        (ionised, species.finish())
    }
}
