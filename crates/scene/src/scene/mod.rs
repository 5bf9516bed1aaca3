//! Scenes: what is in front of the telescope, and the telescope.
//!
//! A [`Scene`] is made of objects, or read from a tree of [`properties`](crate::properties), whoever made that. In a
//! tree quantities are texts with units, and unknown keys are refused with the nearest known one. Every table that has
//! a `kind` reads a catalogue; the catalogues also make the manual of the scene format.

mod albedo;
mod backends;
mod background;
mod band;
mod catalogue;
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
mod root;
pub mod schema;
mod spectrograph;
mod star;
mod star_table;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use spectra::fingerprint::Digest;
use spectra::passband::{self, Passband};

pub use albedo::Albedo;
pub use backends::{BackendOptions, PathOptions, REFERENCE_ACCURACY};
pub use background::{Background, StarField};
pub use dust::{Dust, Scale};
pub use emission::Emission;
pub use fields::Fields;
pub use film::Film;
pub use gas::ionised::Glow;
pub use gas::{Gas, GasCloud, IonisedGas, IonisingStar};
pub use inspect::inspect;
pub use ionisation::tracer::RayTracer;
pub use loader::Loader;
pub use method::{MANY_BOUNCES, MAX_STEPS, Method, MethodEntry, Sparsity, StarDepthSource, methods};
pub use motion::Motion;
pub use parameters::{Parameter, parameter, parameters};
pub use parts::{Part, Parts};
pub use spectrograph::Spectrograph;
pub use star::Star;

use crate::animation::Timeline;
use crate::camera::{self, Camera, Projection};
use crate::data::InputNote;
use crate::detail::Detail;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::image::{Display, Output, PixelScale};
use crate::instrument::Instrument;
use crate::memory;
use crate::observation::{InUnit, Observation};
use crate::properties::{Place, Section, Table};
use root::*;

/// Everything that is in front of the telescope, and the telescope.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The name of the scene.
    pub name: String,
    /// Description of the scene, in sentences.
    pub description: String,
    /// The camera that looks at it.
    pub camera: Camera,
    /// Views that are worth going back to, by name.
    pub bookmarks: BTreeMap<String, Camera>,
    /// Dust that absorbs and scatters.
    pub dust: Option<Dust>,
    /// The species of gas that glow, those of [`gas`](Self::gas) last.
    pub emission: Vec<Emission>,
    /// Ionised state of `[gas]`.
    pub gas: Option<Arc<IonisedGas>>,
    /// Stars within or near the cloud: those of `[[star]]`, then those of each `[[star_table]]`.
    pub stars: Vec<Star>,
    /// Background.
    pub background: Background,
    /// Density detail below the voxel size; `None` for densities as smooth as their grids.
    pub detail: Option<Detail>,
    /// The passbands through which the telescope looks.
    pub bands: Vec<Passband>,
    /// The channels that the first passbands are, where they are those of a spectrograph.
    pub spectrograph: Option<Spectrograph>,
    /// Display settings of the picture.
    pub display: Display,
    /// Position on the sky, if stated.
    pub observation: Option<Observation>,
    /// Instrument, if stated.
    pub instrument: Option<Arc<Instrument>>,
    /// Additional contents of files and their encoding.
    pub output: Output,
    /// The method by which spectral integrals are done.
    pub method: Method,
    /// Its animation, and the frames that show it: none where all of it stands still.
    pub timeline: Option<Arc<Timeline>>,
    /// True if what takes long was made roughly, as a [loader](Loader::roughly) asked.
    pub is_rough: bool,
    /// The text that the scene was read from; none where a program made it.
    pub provenance: Option<Provenance>,
    /// Interpretations of the files that were read for it; those kept from an earlier reading are not among them.
    pub inputs: Vec<InputNote>,
}

/// The text that a scene was read from.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// The text.
    pub text: Arc<str>,
    /// The files that were read for it, the scene's own first.
    pub files: Vec<PathBuf>,
}

impl From<&Scene> for Arc<Scene> {
    /// A shared copy of the scene; large parts are shared with it.
    fn from(scene: &Scene) -> Self {
        Self::new(scene.clone())
    }
}

impl Provenance {
    /// SHA-256 of the text, in hexadecimal digits.
    pub fn digest(&self) -> String {
        use sha2::{Digest, Sha256};
        Sha256::digest(self.text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
    }
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

impl Scene {
    /// A scene that `camera` looks at, empty: seen through johnson's bands, by the default method. The methods below
    /// fill it.
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

    /// Copy of the scene under another name.
    #[must_use]
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Copy of the scene through these passbands, with the display that they have by default.
    #[must_use]
    pub fn bands(self, bands: Vec<Passband>) -> Self {
        Self { display: Display::of(&bands), bands, spectrograph: None, ..self }
    }

    /// Copy of the scene with this dust in place of any before.
    #[must_use]
    pub fn dust(self, dust: Dust) -> Self {
        Self { dust: Some(dust), ..self }
    }

    /// Copy of the scene with one more species of glowing gas.
    #[must_use]
    pub fn emission(mut self, emission: Emission) -> Self {
        self.emission.push(emission);
        self
    }

    /// Copy of the scene with one more star.
    #[must_use]
    pub fn star(mut self, star: Star) -> Self {
        self.stars.push(star);
        self
    }

    /// Copy of the scene with another background.
    #[must_use]
    pub fn background(self, background: Background) -> Self {
        Self { background, ..self }
    }

    /// Copy of the scene with detail below the voxels of its densities.
    #[must_use]
    pub fn detail(self, detail: Detail) -> Self {
        Self { detail: Some(detail), ..self }
    }

    /// Copy of the scene, seen at a place of the sky.
    #[must_use]
    pub fn observed(self, observation: Observation) -> Self {
        Self { observation: Some(observation), ..self }
    }

    /// Copy of the scene, recorded by an instrument.
    #[must_use]
    pub fn recorded(self, instrument: Instrument) -> Self {
        Self { instrument: Some(Arc::new(instrument)), ..self }
    }

    /// Copy of the scene by another method or accuracy.
    #[must_use]
    pub fn method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// Reads a scene from its properties; `name` is what it is called where it does not say. One that changes is read as it
    /// is at the loader's [moment](Loader::at).
    ///
    /// # Errors
    /// If a key is unknown or missing, a value is wrong, a file cannot be read, and those of [`check`](Self::check);
    /// each says its place.
    pub fn from_properties(table: &Table, name: &str, loader: &Loader) -> Result<Self> {
        let inputs = loader.inputs.recording();
        match Timeline::build(&Section::root(table), &inputs)? {
            None => Self::still(table, name, loader, None),
            Some(timeline) => {
                let film = Film { timeline: &timeline, tree: table, time: loader.moment };
                let mut scene = Self::still(&timeline.at(table, loader.moment)?, name, loader, Some(film))?;
                scene.inputs.extend(inputs.notes());
                Ok(Self { timeline: Some(Arc::new(timeline)), ..scene })
            }
        }
    }

    /// Reads a scene without changes from its properties; `film` says which moment of a film it is.
    ///
    /// # Errors
    /// If a key is unknown or missing, or a value is out of range.
    pub fn still(table: &Table, name: &str, loader: &Loader, film: Option<Film>) -> Result<Self> {
        let root = &Section::root(table);
        root.check(ROOT)?;
        let loader = &loader.recording();
        let inputs = &loader.inputs;
        let camera = camera::build(&root.read(&CAMERA)?, inputs)?;
        let bookmark = |(name, section): (&str, Section)| Ok((name.to_owned(), camera::bookmark(&section, inputs, &camera)?));
        let bookmarks = root.read(&BOOKMARK)?.unwrap_or_default().into_iter().map(bookmark).collect::<Result<_>>()?;
        let spectrograph = root.read(&SPECTROGRAPH)?.map(|s| spectrograph::build(&s).map(|own| (own, s))).transpose()?;
        let bands = match &spectrograph {
            Some((own, section)) => {
                root.refuse(&[&band::BANDS.row, &BAND.row], "custom passbands, without [spectrograph]")?;
                spectrograph::bands(section, own)?
            }
            None => band::build(root, inputs)?,
        };
        let mut spectrograph = spectrograph.map(|(own, _)| own);
        let stars = star_table::stars(root, loader)?;
        let display = display::build(root.read(&DISPLAY)?.as_ref(), &bands)?;
        let observation = root.read(&OBSERVATION)?.map(|s| observation::build(&s)).transpose()?;
        let background = root.read(&BACKGROUND)?.map(|s| Self::behind(&s, loader, observation.as_ref())).transpose()?;
        let instrument = root.read(&INSTRUMENT)?.map(|s| Instrument::from_properties(s.properties(), inputs).map(Arc::new)).transpose()?;
        let output = output::build(root.read(&OUTPUT)?.as_ref())?;
        let method = method::build(root.read(&METHOD)?.as_ref())?;
        let detail = root.read(&DETAIL)?.map(|s| detail::build(&s)).transpose()?;
        // Fields may take long: whatever else the text says is read first.
        let fields = Fields::new(root, loader)?;
        let dust = root.read(&DUST)?.map(|s| dust::build(&s, loader, &fields)).transpose()?;
        let (mut emission, mut at_rest) = (Vec::new(), Vec::new());
        for s in root.read(&EMISSION)?.unwrap_or_default() {
            let Emission { name, density, spectrum } = emission::build(&s, loader, &fields)?;
            at_rest.extend(spectrum.lines().iter().map(|line| line.lambda_um));
            emission.extend(Self::moving(&s, &fields, (name, density, spectrum), &camera, loader)?);
        }
        let mut ionised = None;
        if let Some(gas) = root.read(&GAS)? {
            // The mean over the stars of several moments.
            let solved = |moments: &[&[Star]]| {
                let mut content = Digest::new("gas");
                content.part(gas.fingerprint()).part(fields.fingerprint());
                for stars in moments {
                    content.part(star::fingerprint(stars));
                }
                for band in &bands {
                    content.part(band.fingerprint());
                }
                loader.gas(content.finish(), || gas::mean(moments, |stars| gas::solve(&gas, loader, &fields, stars, &bands)))
            };
            let nearest = match film.as_ref().filter(|_| !loader.is_rough) {
                Some(film) => film.around(&gas, &fields, loader)?,
                None => None,
            };
            let made = match nearest {
                None => solved(&[&stars])?,
                Some([(before, first), (own, second), (after, third)]) => {
                    let solve = |knot: &film::Knot| solved(&knot.iter().map(Vec::as_slice).collect::<Vec<_>>());
                    let earlier = solve(&before)?.mixed(&*solve(&own)?, second / (first + second));
                    let mixed = earlier.mixed(&*solve(&after)?, third);
                    Arc::new(IonisedGas { derived_from: gas::sources(&stars, &bands), ..mixed })
                }
            };
            for species in made.species.iter().cloned() {
                at_rest.extend(species.2.lines().iter().map(|line| line.lambda_um));
                emission.extend(Self::moving(&gas, &fields, species, &camera, loader)?);
            }
            ionised = Some(made);
        }
        if let Some(spectrograph) = &mut spectrograph {
            spectrograph.axis.rest_um = spectrograph.axis.rest_um.or_else(|| spectrograph.only_line(&at_rest));
        }
        let is_rough = fields.are_rough() || ionised.as_ref().is_some_and(|gas: &Arc<IonisedGas>| gas.is_rough);
        let scene = Self {
            name: root.read(&NAME)?.unwrap_or(name).to_owned(),
            description: root.read(&DESCRIPTION)?.unwrap_or("").to_owned(),
            camera,
            bookmarks,
            dust,
            emission,
            gas: ionised,
            stars,
            background: background.unwrap_or_default(),
            detail,
            bands,
            spectrograph,
            display,
            observation,
            instrument,
            output,
            method,
            timeline: None,
            is_rough,
            provenance: None,
            inputs: inputs.notes(),
        };
        scene.check().map_err(|error| placed(error, root))?;
        Ok(scene)
    }

    /// A species as it is seen: several, where its table says that it moves.
    fn moving(section: &Section, fields: &Fields, species: Glow, camera: &Camera, loader: &Loader) -> Result<Vec<Emission>> {
        let all = match motion::of(section, fields)? {
            Some(motion) => {
                section.wrap(fields::VELOCITY.name, motion.split(species, camera, loader.inputs.memory_limit, &loader.control))?
            }
            None => vec![species],
        };
        Ok(all.into_iter().map(|(name, density, spectrum)| Emission { name, density, spectrum }).collect())
    }

    /// Reads what lies behind the cloud; stars of a catalogue that was read before are taken again.
    fn behind(section: &Section, loader: &Loader, observation: Option<&Observation>) -> Result<Background> {
        let placed = |table: Section| {
            table.check(catalogue::KEYS)?;
            let stars = loader.catalogue(table.fingerprint(), || catalogue::build(&table, &loader.inputs))?;
            catalogue::placed(&table, stars, observation)
        };
        let catalogue = section.table("catalogue")?.map(placed).transpose()?;
        background::build(section, &loader.inputs, catalogue)
    }

    /// The densities: dust, then gas.
    pub fn densities(&self) -> impl Iterator<Item = &Arc<dyn Field>> {
        self.dust.iter().map(|d| &d.density).chain(self.emission.iter().map(|e| &e.density))
    }

    /// Refuses an image that would take more than `memory_limit` bytes, sixteen for each value, whatever its layers are.
    ///
    /// # Errors
    /// If it would.
    pub fn check_image(&self, memory_limit: u64) -> Result<()> {
        memory::check("the image", self.image_bytes(self.bands.len()), memory_limit)
    }

    /// Memory of an image with `values` numbers per pixel \[bytes\].
    pub fn image_bytes(&self, values: usize) -> u64 {
        // Both eyes, and both together.
        let images = if self.camera.stereo.is_some() { 4 } else { 1 };
        let pixels = (self.camera.width as u64).saturating_mul(self.camera.height as u64).saturating_mul(images);
        pixels.saturating_mul(16 * values as u64)
    }

    /// Checks that the scene can be rendered: every number is one that its object can have, and spectra and laws reach
    /// over every passband. Everything that renders a scene asks this first.
    ///
    /// # Errors
    /// If something is wrong, with its place such as `star[2].position` and what would be right.
    pub fn check(&self) -> Result<()> {
        at("", "camera", self.camera.check())?;
        self.bookmarks.iter().try_for_each(|(name, camera)| at("bookmark", name, camera.check()))?;
        self.check_bands()?;
        if let Some(dust) = &self.dust {
            at("", "dust", dust.check())?;
        }
        self.emission.iter().try_for_each(|gas| at("", "emission", gas.check()))?;
        self.stars.iter().enumerate().try_for_each(|(i, star)| at(&format!("star[{i}]"), "position", star.check()))?;
        at("", "background", self.background.check())?;
        at("", "detail", self.detail.as_ref().map_or(Ok(()), Detail::check))?;
        let dust = self.dust.iter().map(|dust| ("dust", &dust.density));
        for (key, density) in dust.chain(self.emission.iter().map(|gas| ("emission", &gas.density))) {
            at("", key, density.check())?;
        }
        at("", "gas", self.check_gas())?;
        at("", "method", self.method.check())?;
        at("", "display", self.display.check())?;
        if let Some(observation) = &self.observation {
            let mut cameras = std::iter::once(&self.camera).chain(self.bookmarks.values());
            at("", "observation", cameras.try_for_each(|camera| observation::check(observation, camera)))?;
            let of = |band| self.in_unit(band, &self.camera).map(|_| ());
            self.bands.iter().try_for_each(|band| at("observation", "unit", of(band)))?;
        }
        let parallel = |camera: &Camera| matches!(camera.projection, Projection::Orthographic { .. });
        if self.background.has_stars() && std::iter::once(&self.camera).chain(self.bookmarks.values()).any(parallel) {
            return Err(placed_error(
                "",
                "background",
                "stars at infinity require a [camera], and bookmarks, whose rays start at one point; use a kind such as \"perspective\"",
            ));
        }
        Ok(())
    }

    /// Checks that there are passbands, each with a name of its own and a colour, and that laws and spectra reach over
    /// all of them.
    fn check_bands(&self) -> Result<()> {
        if self.bands.is_empty() {
            return Err(placed_error("", "bands", "the scene has no passbands; write bands = \"johnson\""));
        }
        for (i, band) in self.bands.iter().enumerate() {
            if self.bands[..i].iter().any(|b| b.name() == band.name()) {
                let message = format!("two passbands have the name \"{}\"; rename one", band.name());
                return Err(placed_error("", "bands", message));
            }
            let (low, high) = band.support_um();
            let what = format!("passband {}", band.name());
            if let Some(dust) = &self.dust {
                at("", "bands", dust.extinction.check(&what, low, high))?;
            }
            for spectrum in self.spectra() {
                at("", "bands", spectrum.check(&what, low, high))?;
            }
        }
        let (columns, bands) = (self.display.palette.columns.len(), self.bands.len());
        if columns != bands {
            let message = format!("the palette has colours for {columns} bands, the scene has {bands}");
            return Err(placed_error("display", "palette", message));
        }
        Ok(())
    }

    /// How band radiances through a passband become the unit of the observation, as a camera sees them; none where there is no observation.
    ///
    /// # Errors
    /// If Vega is unknown in the passband, or electrons are requested without an instrument.
    pub fn in_unit(&self, band: &Passband, camera: &Camera) -> Result<Option<InUnit>> {
        let Some(observation) = self.observation else { return Ok(None) };
        let own = match (camera.pixel_scale(), observation.distance_pc) {
            (PixelScale::Length(pc), Some(distance)) => pc / distance,
            (pixel, _) => pixel.in_unit().0.to_radians(),
        };
        let electrons = |instrument: &Arc<Instrument>| instrument.electrons(band.pivot().0) * instrument.pixel_rad.unwrap_or(own).powi(2);
        observation.unit.of(band, self.instrument.as_ref().map(electrons)).map(Some)
    }

    /// Every spectrum in the scene.
    fn spectra(&self) -> impl Iterator<Item = &spectra::spectrum::Spectrum> {
        let stars = self.stars.iter().map(|s| &s.spectrum);
        let catalogue = self.background.catalogue.iter().flat_map(|placed| placed.catalogue.classes.iter().map(|class| &class.spectrum));
        stars.chain(self.emission.iter().map(|e| &e.spectrum)).chain(self.background.spectrum.iter()).chain(catalogue)
    }
}

fn placed_error(path: &str, key: &str, message: impl Into<String>) -> Error {
    Error::Scene { message: message.into(), place: Place { origin: None, path: path.into(), key: key.into() } }
}

/// Adds a place to what was found about one object.
fn at<T, E: Into<Error>>(path: &str, key: &str, result: std::result::Result<T, E>) -> Result<T> {
    result.map_err(|error| placed_error(path, key, error.into().to_string()))
}

/// Copy of the error with the line of the text, where the tree that the scene is from knows it.
fn placed(error: Error, root: &Section) -> Error {
    let Error::Scene { message, place } = error else { return error };
    let own = if place.path.is_empty() { place.key.as_str() } else { place.path.split('.').next().unwrap_or("") };
    // Passbands of one's own stand elsewhere.
    let key = if own == "bands" && root.has(&BAND) { "band" } else { own };
    root.error(key, message)
}
