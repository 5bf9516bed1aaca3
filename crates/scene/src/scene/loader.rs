//! Cache between readings of a scene: fields, stars and gas whose inputs did not change.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, Weak};

use ionisation::tracer::RayTracer;
use spectra::fingerprint::{Digest, Fingerprint};

use super::Star;
use super::gas::ionised::IonisedGas;
use super::gas::voxel_gas::VoxelGas;
use crate::cache::{Cache, Layered};
use crate::control::Control;
use crate::data::{DataSource, Inputs, NoData};
use crate::error::Result;
use crate::field::Field;
use crate::memory;
use crate::star_catalogue::StarCatalogue;

/// Most fields of which it is remembered that they could be made.
const MAX_REMEMBERED: usize = 512;
/// Tables of stars that are kept at most.
const MAX_TABLES: usize = 8;
/// Gases that are kept at most: each has a grid for every species.
const MAX_GAS: usize = 4;

/// Results in memory by the fingerprint of their inputs, the latest last.
type Recent<T> = Arc<Mutex<VecDeque<(Fingerprint, Arc<T>)>>>;

/// Inputs of a scene and a cache of what was read; clones share it.
#[derive(Debug, Clone)]
pub struct Loader {
    /// Access to the files that the scene names.
    pub inputs: Inputs,
    fields: Arc<Mutex<HashMap<Fingerprint, Weak<dyn Field>>>>,
    /// Of fields that were made, whether they are grids.
    grids: Arc<Mutex<HashMap<Fingerprint, bool>>>,
    stars: Recent<Vec<Star>>,
    catalogues: Recent<StarCatalogue>,
    gas: Recent<IonisedGas>,
    knots: Recent<VoxelGas>,
    rough_gas: Recent<IonisedGas>,
    /// Results that came with the scene, before those of any other cache.
    given: Option<Arc<dyn Cache>>,
    /// True if what takes long is made roughly.
    pub(super) is_rough: bool,
    /// A device that has the light of several stars go through gas, where there is one.
    pub(super) tracer: Option<Arc<dyn RayTracer>>,
    /// The moment at which a scene is read that changes \[s\].
    pub(super) moment: f64,
    /// Progress and cancellation of a reading.
    pub(crate) control: Control,
}

impl Default for Loader {
    /// A loader of scenes that name no files.
    fn default() -> Self {
        Self::new(Arc::new(NoData), memory::DEFAULT_LIMIT)
    }
}

impl Loader {
    /// Reads from `source`; each array may take `memory_limit` bytes.
    pub fn new(source: Arc<dyn DataSource>, memory_limit: u64) -> Self {
        Self {
            inputs: Inputs::new(source, memory_limit),
            fields: Arc::default(),
            grids: Arc::default(),
            stars: Arc::default(),
            catalogues: Arc::default(),
            gas: Arc::default(),
            rough_gas: Arc::default(),
            knots: Arc::default(),
            given: None,
            is_rough: false,
            tracer: None,
            moment: 0.0,
            control: Control::default(),
        }
    }

    /// Variant for one reading, which records how its files are understood.
    pub(super) fn recording(&self) -> Self {
        Self { inputs: self.inputs.recording(), ..self.clone() }
    }

    /// Variant for readings that `control` can interrupt.
    #[must_use]
    pub fn under(&self, control: &Control) -> Self {
        Self { control: control.clone(), ..self.clone() }
    }

    /// Variant for readings of a scene as it is at a moment \[s\], the first being 0 s. What is kept is shared.
    #[must_use]
    pub fn at(&self, moment: f64) -> Self {
        Self { moment, ..self.clone() }
    }

    /// The moment at which scenes are read that change \[s\].
    pub fn moment(&self) -> f64 {
        self.moment
    }

    /// Variant for readings in which a device has the light of several stars go through gas, where one is given.
    #[must_use]
    pub fn traced_by(&self, tracer: Option<Arc<dyn RayTracer>>) -> Self {
        Self { tracer, ..self.clone() }
    }

    /// Variant with a cache of results between runs: solved gas and sampled fields.
    #[must_use]
    pub fn with_cache(&self, cache: Option<Arc<dyn Cache>>) -> Self {
        let mut loader = self.clone();
        loader.inputs.cache = match &self.given {
            Some(given) => Some(Arc::new(Layered { first: given.clone(), then: cache })),
            None => cache,
        };
        loader
    }

    /// Variant with results that came with the scene: they are used before those of any cache.
    #[must_use]
    pub fn with_given(&self, results: Arc<dyn Cache>) -> Self {
        let cache = self.inputs.cache.clone();
        Self { given: Some(results), ..self.clone() }.with_cache(cache)
    }

    /// Variant for readings in which what takes long is made roughly: turbulence, and gas that stars ionise, on few voxels,
    /// unless they are known. What is kept is shared.
    #[must_use]
    pub fn roughly(&self) -> Self {
        Self { is_rough: true, ..self.clone() }
    }

    /// The cached field with the fingerprint `content`, or a new one from `build`. Fields stay cached while they are in use.
    fn field(&self, content: Fingerprint, build: impl FnOnce() -> Result<Arc<dyn Field>>) -> Result<Arc<dyn Field>> {
        if let Some(field) = self.known_field(content) {
            return Ok(field);
        }
        self.control.check()?;
        let field = build()?;
        if let Ok(mut fields) = self.fields.lock() {
            fields.retain(|_, field| field.strong_count() > 0);
            fields.insert(content, Arc::downgrade(&field));
        }
        Ok(field)
    }

    /// The cached field with the fingerprint `content`, if it is still in use.
    pub(super) fn known_field(&self, content: Fingerprint) -> Option<Arc<dyn Field>> {
        self.fields.lock().ok().and_then(|fields| fields.get(&content).and_then(Weak::upgrade))
    }

    /// Variant for a field that may take `long`, which may be [made roughly](Self::makes_roughly).
    pub(super) fn long_field(
        &self,
        content: Fingerprint,
        long: bool,
        build: impl FnOnce(&Inputs) -> Result<Arc<dyn Field>>,
    ) -> Result<Arc<dyn Field>> {
        if !self.makes_roughly(content, long) {
            return self.field(content, || build(&self.inputs));
        }
        let mut inputs = self.inputs.clone();
        inputs.is_rough = true;
        self.field(Digest::new("roughly").part(content).finish(), || build(&inputs))
    }

    /// True if a field that may take `long` is made roughly: where it is not known yet, and the reading is a rough one.
    pub(super) fn makes_roughly(&self, content: Fingerprint, long: bool) -> bool {
        long && self.is_rough && self.known_field(content).is_none()
    }

    /// True if the field that `content` describes, which was made once, is a grid; nothing where none was.
    pub(super) fn is_grid(&self, content: Fingerprint) -> Option<bool> {
        self.grids.lock().ok().and_then(|grids| grids.get(&content).copied())
    }

    /// Remembers that the field that `content` describes could be made.
    pub(super) fn remember(&self, content: Fingerprint, is_grid: bool) {
        if let Ok(mut grids) = self.grids.lock() {
            if grids.len() >= MAX_REMEMBERED {
                grids.clear();
            }
            grids.insert(content, is_grid);
        }
    }

    /// The stars of the table that `content` describes: those of before, or new ones. The file is not read again for it.
    pub(super) fn stars(&self, content: Fingerprint, build: impl FnOnce() -> Result<Vec<Star>>) -> Result<Arc<Vec<Star>>> {
        cached(&self.stars, MAX_TABLES, content, build)
    }

    /// The stars of the catalogue that `content` describes: those of before, or read anew.
    pub(super) fn catalogue(&self, content: Fingerprint, build: impl FnOnce() -> Result<StarCatalogue>) -> Result<Arc<StarCatalogue>> {
        cached(&self.catalogues, 1, content, build)
    }

    /// Gas at a knot of a film: that of before, or anew.
    pub(super) fn knot(&self, content: Fingerprint, build: impl FnOnce() -> Result<VoxelGas>) -> Result<Arc<VoxelGas>> {
        cached(&self.knots, MAX_GAS, content, build)
    }

    /// Ionised state of the gas that `content` describes: that of before, or anew.
    pub(super) fn gas(&self, content: Fingerprint, build: impl FnOnce() -> Result<IonisedGas>) -> Result<Arc<IonisedGas>> {
        match known(&self.gas, content) {
            Some(gas) => Ok(gas),
            None if self.is_rough => cached(&self.rough_gas, 1, content, build),
            None => cached(&self.gas, MAX_GAS, content, build),
        }
    }
}

/// Cached result of some content.
fn known<T>(all: &Mutex<VecDeque<(Fingerprint, Arc<T>)>>, content: Fingerprint) -> Option<Arc<T>> {
    all.lock().ok().and_then(|all| all.iter().find(|(known, _)| *known == content).map(|(_, value)| value.clone()))
}

/// Cached or new result of some content; the cache is bounded.
fn cached<T>(
    all: &Mutex<VecDeque<(Fingerprint, Arc<T>)>>,
    most: usize,
    content: Fingerprint,
    build: impl FnOnce() -> Result<T>,
) -> Result<Arc<T>> {
    if let Some(value) = known(all, content) {
        return Ok(value);
    }
    let built = Arc::new(build()?);
    if let Ok(mut all) = all.lock() {
        while all.len() >= most {
            all.pop_front();
        }
        all.push_back((content, built.clone()));
    }
    Ok(built)
}
