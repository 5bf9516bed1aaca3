//! The `[method]` table: how spectral integrals are done, and how exact.

use spectra::basis::{CRITERIA, Criterion};
use spectra::polynomial::MAX_DEGREE;
use spectra::rule::{RULES, RuleEntry, Settings};
use spectra::units::Wavelength;

use super::backends::{self, BackendOptions};
use crate::error::{Error, Result};
use crate::properties::{Choice, Choices, Integer, Key, KeyRow, Number, OrDefault, Quantities, Section, Text};
use crate::stored::Precision;

/// One row of the catalogue: a spectral rule and where star depths come from.
#[derive(Clone, Copy)]
pub struct MethodEntry {
    /// The name in scenes and on the command line.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// The rule by which spectral integrals are done.
    pub rule: &'static RuleEntry,
    /// The source of star depths.
    pub star_depth: StarDepthSource,
}

/// Source of the optical depth from a star to a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StarDepthSource {
    /// Star depths are read from a grid that is made once.
    Cached,
    /// Star depths are marched again at every sample.
    Marched,
    /// There are no star depths: the light of all stars is deposited in voxels once.
    LightField,
}

impl std::fmt::Debug for MethodEntry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for MethodEntry {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// Methods beside the rules over cached star depths: rule, name, summary, star depths.
const OTHERS: [(&str, &str, &str, StarDepthSource); 2] = [
    (
        "midpoint",
        "double_integration",
        "midpoint with a new star-depth march at every sample: Barrès & Neyret's baseline",
        StarDepthSource::Marched,
    ),
    (
        "projection",
        "propagation",
        "projection with the light of all stars stored in voxels as polynomials: Barrès & Neyret's many lights; scattering is isotropic",
        StarDepthSource::LightField,
    ),
];

/// Names that methods had before, and have now.
const ALIASES: [(&str, &str); 1] = [("newton", "midpoint")];

/// All methods; the first is the default.
pub fn methods() -> impl Iterator<Item = MethodEntry> {
    let cached =
        |rule: &'static RuleEntry| MethodEntry { name: rule.name, summary: rule.summary, rule, star_depth: StarDepthSource::Cached };
    let others = OTHERS.iter().flat_map(|(rule_name, name, summary, star_depth)| {
        let rules = RULES.iter().filter(move |rule| rule.name == *rule_name);
        rules.map(|rule| MethodEntry { name, summary, rule, star_depth: *star_depth })
    });
    RULES.iter().map(cached).chain(others)
}

/// Which empty pages of a volume take no memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Sparsity {
    /// All, where volumes are large and a good part of them is empty.
    #[default]
    Auto,
    /// All.
    Always,
    /// None.
    Never,
}

impl Choices for Sparsity {
    const ROWS: &'static [(&'static str, Self)] = &[("auto", Self::Auto), ("always", Self::Always), ("never", Self::Never)];
}

impl Choices for Precision {
    const ROWS: &'static [(&'static str, Self)] = &[("single", Self::Single), ("half", Self::Half)];
}

impl Choices for Criterion {
    const ROWS: &'static [(&'static str, Self)] = &CRITERIA;
}

/// The method by which spectral integrals are done, and how exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    /// The row of the catalogue.
    pub entry: MethodEntry,
    /// The allowed error, relative to F(0) for integrals and to its rms for the image \[1\].
    pub accuracy: f64,
    /// Fixed parameters of the rule, independent of the accuracy.
    pub settings: Settings,
    /// A fixed number of samples a ray.
    pub steps: Option<usize>,
    /// A fixed number of samples in each voxel edge, where there is none for a ray.
    pub steps_per_voxel: Option<f64>,
    /// A fixed number of voxels of star depths along one of dust.
    pub star_depth_voxels: Option<usize>,
    /// Voxels along the longest edge of a baked function; by the field's finest structure otherwise.
    pub bake: Option<usize>,
    /// How volumes of densities and star depths are stored.
    pub volumes: Precision,
    /// True if parts of them that are empty take no memory.
    pub sparse: Sparsity,
    /// Times that light of stars may scatter.
    pub bounces: usize,
    /// Stars that are marched one by one, the brightest; the light of the others is gathered. By their number and light
    /// otherwise.
    pub exact_stars: Option<usize>,
    /// Options of single back ends.
    pub backends: BackendOptions,
}

/// Most samples a ray that may be asked for.
pub const MAX_STEPS: i64 = 1_000_000;

/// Most stars that may be asked to be marched one by one.
const MAX_EXACT_STARS: i64 = 1_000_000;

/// More bounces than any light lives.
pub const MANY_BOUNCES: usize = 1000;

/// The default accuracy.
pub const DEFAULT_ACCURACY: f64 = 1e-3;

impl Default for Method {
    fn default() -> Self {
        let entry = MethodEntry { name: RULES[0].name, summary: RULES[0].summary, rule: &RULES[0], star_depth: StarDepthSource::Cached };
        Self {
            entry,
            accuracy: DEFAULT_ACCURACY,
            settings: Settings::default(),
            steps: None,
            steps_per_voxel: None,
            star_depth_voxels: None,
            bake: None,
            volumes: Precision::Single,
            sparse: Sparsity::Auto,
            bounces: 1,
            exact_stars: None,
            backends: BackendOptions::default(),
        }
    }
}

impl Method {
    /// The method called `name` in place of this one's.
    ///
    /// # Errors
    /// If there is none.
    pub fn with_name(mut self, name: &str) -> spectra::Result<Self> {
        let name = ALIASES.iter().find(|(before, _)| *before == name).map_or(name, |(_, now)| now);
        let known: Vec<&str> = methods().map(|m| m.name).collect();
        self.entry = methods().find(|m| m.name == name).ok_or_else(|| spectra::SpectraError::unknown("method", name, &known))?;
        Ok(self)
    }

    /// Refuses what no method can be asked for.
    ///
    /// # Errors
    /// If a number lies outside of what scene files may say.
    pub fn check(&self) -> Result<()> {
        let Settings { count, domain_um, degree, range, .. } = &self.settings;
        ACCURACY.check(self.accuracy)?;
        DEGREE.check(*degree as f64)?;
        BOUNCES.check(self.bounces as f64)?;
        range.map_or(Ok(()), |range| RANGE.check(range))?;
        self.steps_per_voxel.map_or(Ok(()), |steps| STEPS_PER_VOXEL.check(steps))?;
        let counts = [
            (&COUNT, *count),
            (&STEPS, self.steps),
            (&STAR_DEPTH_VOXELS, self.star_depth_voxels),
            (&BAKE, self.bake),
            (&EXACT_STARS, self.exact_stars),
        ];
        counts.iter().try_for_each(|(key, count)| count.map_or(Ok(()), |count| key.check(count as f64)))?;
        match domain_um {
            Some((low, high)) if !(*low > 0.0 && low < high && high.is_finite()) => {
                Err(Error::out_of_range("domain", format!("{low} to {high} um"), "two ascending wavelengths above zero"))
            }
            _ => Ok(()),
        }
    }
}

const NAME: Key<Text, OrDefault> = Key::text("name", "name in the catalogue `methods`").default("band_quadrature").of("methods");
const ACCURACY: Key<Number, OrDefault> =
    Key::number("accuracy", "allowed error: spectral relative to the light without extinction, spatial relative to the image's rms")
        .range(1e-9..=0.5)
        .default(DEFAULT_ACCURACY);
const COUNT: Key<Integer<usize>> = Key::integer("count", "fixed number of nodes, intervals, elements or samples per band, for comparisons")
    .range(1..=4096)
    .otherwise("chosen by accuracy");
const DOMAIN: Key<Quantities<Wavelength>> =
    Key::quantities("domain", "wavelength range of midpoint, gauss_legendre, preintegrated, analytic and projection")
        .example("[\"300 nm\", \"1 um\"]")
        .positive()
        .otherwise("that of each band (projection: that of all bands)");
const DEGREE: Key<Integer<usize>, OrDefault> =
    Key::integer("degree", "degree of the spectral polynomials of analytic").range(0..=MAX_DEGREE as i64).default(5);
const RANGE: Key<Number> =
    Key::number("range", "largest optical depth of the basis of projection").range(1e-6..=1e6).otherwise("largest depth of the scene");
const CRITERION: Key<Choice<Criterion>, OrDefault> = Key::choice(
    "criterion",
    "norm that the exponents of projection minimise over the range: mean error, largest error, or mean weighted by each filter",
)
.default("mean");
const STEPS: Key<Integer<usize>> =
    Key::integer("steps", "fixed number of samples per ray, for comparisons").range(1..=MAX_STEPS).otherwise("chosen by accuracy");
const STEPS_PER_VOXEL: Key<Number> = Key::number("steps_per_voxel", "fixed number of samples per voxel edge")
    .range(0.5..=100.0)
    .otherwise("chosen by accuracy")
    .excludes("steps");
const STAR_DEPTH_VOXELS: Key<Integer<usize>> =
    Key::integer("star_depth_voxels", "fixed number of star-depth voxels per dust voxel edge, within the memory limit")
        .range(1..=12)
        .example("2")
        .otherwise("chosen by accuracy");
const BAKE: Key<Integer<usize>> = Key::integer("bake", "voxels along the longest edge of sampled functions")
    .range(4..=2048)
    .otherwise("from the sampling error, 32 to 256");
const VOLUMES: Key<Choice<Precision>, OrDefault> =
    Key::choice("volumes", "precision of march volumes; half has errors of up to 1/700 and takes half of the memory").default("single");
const SPARSE: Key<Choice<Sparsity>, OrDefault> = Key::choice(
    "sparse",
    "omit volume pages of 16 x 16 x 16 voxels without dust and gas; auto does so from 64 MiB on if it saves a quarter",
)
.default("auto");
const BOUNCES: Key<Integer<usize>, OrDefault> =
    Key::integer("bounces", "largest number of scatterings of starlight, 1000 for all; light of gas and background scatters one time less")
        .range(1..=MANY_BOUNCES as i64)
        .default(1);
const EXACT_STARS: Key<Integer<usize>> = Key::integer(
    "exact_stars",
    "number of the brightest stars to march individually; the light of the others is aggregated in cells beyond the neighbourhood of each (methods of nodes only)",
)
.range(0..=MAX_EXACT_STARS)
.otherwise("all of up to 8; of more, one that emits over half of the light");

pub(super) const KEYS: &[KeyRow] = &[
    NAME.row,
    ACCURACY.row,
    COUNT.row,
    DOMAIN.row,
    DEGREE.row,
    RANGE.row,
    CRITERION.row,
    STEPS.row,
    STEPS_PER_VOXEL.row,
    STAR_DEPTH_VOXELS.row,
    BAKE.row,
    VOLUMES.row,
    SPARSE.row,
    BOUNCES.row,
    EXACT_STARS.row,
    backends::PATH_TABLE.row,
    backends::REFERENCE_TABLE.row,
    backends::GPU_TABLE.row,
];

pub(super) fn build(section: Option<&Section>) -> Result<Method> {
    let Some(section) = section else { return Ok(Method::default()) };
    section.check(KEYS)?;
    let domain_um = match section.read(&DOMAIN)? {
        None => None,
        Some(ends) => {
            let wrong = || section.error(&DOMAIN, "a domain must be two ascending wavelengths, such as [\"300 nm\", \"1 um\"]");
            let &[low, high] = &ends[..] else { return Err(wrong()) };
            if low >= high {
                return Err(wrong());
            }
            Some((low.0, high.0))
        }
    };
    let defaults = Settings::default();
    let settings = Settings {
        count: section.read(&COUNT)?,
        domain_um,
        degree: section.read(&DEGREE)?,
        range: section.read(&RANGE)?,
        criterion: section.read(&CRITERION)?,
        ..defaults
    };
    let method = Method {
        accuracy: section.read(&ACCURACY)?,
        settings,
        steps: section.read(&STEPS)?,
        steps_per_voxel: section.read(&STEPS_PER_VOXEL)?,
        star_depth_voxels: section.read(&STAR_DEPTH_VOXELS)?,
        bake: section.read(&BAKE)?,
        volumes: section.read(&VOLUMES)?,
        sparse: section.read(&SPARSE)?,
        bounces: section.read(&BOUNCES)?,
        exact_stars: section.read(&EXACT_STARS)?,
        backends: BackendOptions::default().with_section(section)?,
        ..Method::default()
    };
    section.wrap(&NAME, method.with_name(section.read(&NAME)?))
}
