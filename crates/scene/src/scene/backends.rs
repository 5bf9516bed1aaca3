//! The tables `[method.path]`, `[method.reference]` and `[method.gpu]`: options of single back ends.

use crate::error::Result;
use crate::properties::{Flag, Integer, Key, KeyRow, Number, OrDefault, Section, SubTable, Table};

/// Options of the path tracer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PathOptions {
    /// Fewest scatterings of starlight that are included; for light of gas and background one less. 1 includes all.
    pub first: usize,
    /// Largest number of paths per pixel and band.
    pub samples: u64,
    /// Relative standard error of the worst band at which to stop earlier.
    pub target_error: Option<f64>,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self { first: 1, samples: 64, target_error: None, seed: 1 }
    }
}

impl PathOptions {
    /// Options without light of fewer scatterings.
    #[must_use]
    pub fn with_first(self, first: usize) -> Self {
        Self { first, ..self }
    }

    /// Options with another number of paths per pixel and band.
    #[must_use]
    pub fn with_samples(self, samples: u64) -> Self {
        Self { samples, ..self }
    }

    /// Options with a relative standard error at which to stop.
    #[must_use]
    pub fn with_target_error(self, target_error: Option<f64>) -> Self {
        Self { target_error, ..self }
    }

    /// Options with another seed.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }
}

/// Options of single back ends.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct BackendOptions {
    /// Options of the path tracer.
    pub path: PathOptions,
    /// Allowed relative error of each pixel of the reference.
    pub reference_accuracy: f64,
    /// True if graphics processors evaluate dust of a single field of kind "fbm" at every sample.
    pub on_the_fly: bool,
}

impl Default for BackendOptions {
    fn default() -> Self {
        Self { path: PathOptions::default(), reference_accuracy: REFERENCE_ACCURACY, on_the_fly: false }
    }
}

/// Most paths per pixel: a double holds their number exactly.
const MAX_SAMPLES: i64 = 1_000_000_000_000;

const SAMPLES: Key<Integer<u64>, OrDefault> =
    Key::integer("samples", "largest number of paths per pixel and band").range(1..=MAX_SAMPLES).default(64);
const TARGET_ERROR: Key<Number> =
    Key::number("target_error", "relative standard error of the worst band at which to stop earlier").range(1e-6..=1.0).example("0.01");
const SEED: Key<Integer<u64>, OrDefault> = Key::integer("seed", "seed of the noise").not_negative().default(1);

/// Keys of `[method.path]`.
pub(super) const PATH: &[KeyRow] = &[SAMPLES.row, TARGET_ERROR.row, SEED.row];

/// Allowed relative error of each pixel of the reference, unless stated.
pub const REFERENCE_ACCURACY: f64 = 1e-5;

const ACCURACY: Key<Number, OrDefault> =
    Key::number("accuracy", "allowed error of each pixel, relative to its radiance").range(1e-12..=0.5).default(REFERENCE_ACCURACY);

/// Keys of `[method.reference]`.
pub(super) const REFERENCE: &[KeyRow] = &[ACCURACY.row];

const ON_THE_FLY: Key<Flag, OrDefault> =
    Key::flag("on_the_fly", "evaluate dust of a single field of kind \"fbm\" at every sample, instead of sampling it to a grid")
        .default(false);

/// Keys of `[method.gpu]`.
pub(super) const GPU: &[KeyRow] = &[ON_THE_FLY.row];

pub(super) const PATH_TABLE: Key<SubTable> = Key::table("path", "options of the path tracer, [method.path]").otherwise("defaults");
pub(super) const REFERENCE_TABLE: Key<SubTable> =
    Key::table("reference", "options of the reference, [method.reference]").otherwise("defaults");
pub(super) const GPU_TABLE: Key<SubTable> = Key::table("gpu", "options of graphics processors, [method.gpu]").otherwise("defaults");

impl BackendOptions {
    /// The options with those of a table, which has tables `path`, `reference` and `gpu` as `[method]` has.
    ///
    /// # Errors
    /// If a key is unknown, or a value has the wrong type or is out of range.
    pub fn with_properties(self, table: &Table) -> Result<Self> {
        self.with_section(&Section::new(table, "method"))
    }

    pub(super) fn with_section(mut self, method: &Section) -> Result<Self> {
        if let Some(section) = method.read(&PATH_TABLE)? {
            section.check(PATH)?;
            self.path.samples = section.stated(&SAMPLES)?.unwrap_or(self.path.samples);
            self.path.target_error = section.stated(&TARGET_ERROR)?.or(self.path.target_error);
            self.path.seed = section.stated(&SEED)?.unwrap_or(self.path.seed);
        }
        if let Some(section) = method.read(&REFERENCE_TABLE)? {
            section.check(REFERENCE)?;
            self.reference_accuracy = section.stated(&ACCURACY)?.unwrap_or(self.reference_accuracy);
        }
        if let Some(section) = method.read(&GPU_TABLE)? {
            section.check(GPU)?;
            self.on_the_fly = section.stated(&ON_THE_FLY)?.unwrap_or(self.on_the_fly);
        }
        Ok(self)
    }
}
