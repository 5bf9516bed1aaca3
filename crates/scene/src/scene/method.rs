//! The `[method]` table: how spectral integrals are done, and how exact.

use std::ops::RangeInclusive;

use spectra::basis::CRITERIA;
use spectra::polynomial::MAX_DEGREE;
use spectra::rule::{RULES, RuleEntry, Settings};
use spectra::units::Wavelength;

use crate::error::{Error, Result};
use crate::properties::{Key, Section};
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
    let others = OTHERS.iter().flat_map(|(of, name, summary, star_depth)| {
        let rules = RULES.iter().filter(move |rule| rule.name == *of);
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
}

/// Most samples a ray that may be asked for.
pub const MAX_STEPS: i64 = 1_000_000;

/// Most stars that may be asked to be marched one by one.
const MAX_EXACT_STARS: i64 = 1_000_000;

/// More bounces than any light lives.
pub const MANY_BOUNCES: usize = 1000;

/// Parameters of a method: nodes or elements, the range of a basis, the accuracy, voxels of a sampled function.
const COUNT: RangeInclusive<i64> = 1..=4096;
const RANGE: RangeInclusive<f64> = 1e-6..=1e6;
const ACCURACY: RangeInclusive<f64> = 1e-9..=0.5;
const BAKE: RangeInclusive<i64> = 4..=2048;
/// Samples in a voxel edge, and voxels of star depths along one of dust.
const STEPS_PER_VOXEL: RangeInclusive<f64> = 0.5..=100.0;
const STAR_DEPTH_VOXELS: RangeInclusive<i64> = 1..=12;

/// The accuracy that holds unless told otherwise.
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
        let whole = |what: &'static str, value: Option<usize>, range: RangeInclusive<i64>| match value {
            Some(n) if !i64::try_from(n).is_ok_and(|n| range.contains(&n)) => {
                Err(Error::out_of_range(what, n, format!("between {} and {}", range.start(), range.end())))
            }
            _ => Ok(()),
        };
        let number = |what: &'static str, value: Option<f64>, range: RangeInclusive<f64>| match value {
            Some(v) if !range.contains(&v) => {
                Err(Error::out_of_range(what, v, format!("between {:e} and {:e}", range.start(), range.end())))
            }
            _ => Ok(()),
        };
        let Settings { count, domain_um, degree, range, .. } = &self.settings;
        number("accuracy", Some(self.accuracy), ACCURACY)?;
        whole("count", *count, COUNT)?;
        whole("degree", Some(*degree), 0..=MAX_DEGREE as i64)?;
        number("range", *range, RANGE)?;
        whole("steps", self.steps, 1..=MAX_STEPS)?;
        number("steps_per_voxel", self.steps_per_voxel, STEPS_PER_VOXEL)?;
        whole("star_depth_voxels", self.star_depth_voxels, STAR_DEPTH_VOXELS)?;
        whole("bake", self.bake, BAKE)?;
        whole("bounces", Some(self.bounces), 1..=MANY_BOUNCES as i64)?;
        whole("exact_stars", self.exact_stars, 0..=MAX_EXACT_STARS)?;
        match domain_um {
            Some((low, high)) if !(*low > 0.0 && low < high && high.is_finite()) => {
                Err(Error::out_of_range("domain", format!("{low} to {high} um"), "two ascending wavelengths above zero"))
            }
            _ => Ok(()),
        }
    }
}

pub(super) const KEYS: &[Key] = &[
    Key::optional("name", "text", "band_quadrature", "name in the catalogue `methods`").of("methods"),
    Key::optional(
        "accuracy",
        "number",
        "0.001",
        "allowed error: spectral relative to the light without extinction, spatial relative to the image's rms",
    ),
    Key::optional(
        "count",
        "integer",
        "chosen by accuracy",
        "fixed number of nodes, intervals, elements or samples per band, for comparisons",
    ),
    Key::optional(
        "domain",
        "list of texts",
        "that of each band (projection: that of all bands)",
        "wavelength range of midpoint, gauss_legendre, preintegrated, analytic and projection, such as [\"300 nm\", \"1 um\"]",
    ),
    Key::optional("degree", "integer", "5", "degree of the spectral polynomials of analytic"),
    Key::optional("range", "number", "largest depth of the scene", "largest optical depth of the basis of projection"),
    Key::optional(
        "criterion",
        "text",
        "mean",
        "norm that the exponents of projection minimise over the range: mean error, largest error, or mean weighted by each filter",
    ),
    Key::optional("steps", "integer", "chosen by accuracy", "fixed number of samples per ray, for comparisons"),
    Key::optional(
        "steps_per_voxel",
        "number",
        "chosen by accuracy",
        "fixed number of samples per voxel edge, 0.5 to 100; `steps` takes precedence",
    ),
    Key::optional(
        "star_depth_voxels",
        "integer",
        "chosen by accuracy",
        "fixed number of star-depth voxels per dust voxel edge, 1 to 12, within the memory limit",
    ),
    Key::optional("bake", "integer", "from the sampling error, 32 to 256", "voxels along the longest edge of sampled functions, 4 to 2048"),
    Key::optional(
        "volumes",
        "text",
        "single",
        "precision of march volumes, single or half; half has errors of up to 1/700 and takes half of the memory",
    ),
    Key::optional(
        "sparse",
        "text",
        "auto",
        "omit volume pages of 16 x 16 x 16 voxels without dust and gas: auto, always or never; auto does so from 64 MiB on if it saves a quarter",
    ),
    Key::optional(
        "bounces",
        "integer",
        "1",
        "largest number of scatterings of starlight, 1000 for all; light of gas and background scatters one time less",
    ),
    Key::optional(
        "exact_stars",
        "integer",
        "all of up to 8; of more, one that emits over half of the light",
        "number of the brightest stars to march individually; the light of the others is aggregated in cells beyond the neighbourhood of each (methods of nodes only)",
    ),
];

pub(super) fn build(section: Option<&Section>) -> Result<Method> {
    let Some(section) = section else { return Ok(Method::default()) };
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let domain_um = match section.texts("domain")? {
        None => None,
        Some(ends) => {
            let wrong = || section.error("domain", "a domain must be two ascending wavelengths, such as [\"300 nm\", \"1 um\"]");
            let &[low, high] = &ends[..] else { return Err(wrong()) };
            let low: Wavelength = section.wrap("domain", low.parse())?;
            let high: Wavelength = section.wrap("domain", high.parse())?;
            if !(low.0 > 0.0 && low.0 < high.0) {
                return Err(wrong());
            }
            Some((low.0, high.0))
        }
    };
    let names = CRITERIA.map(|(name, _)| name);
    let criterion = section.choice("criterion", &names)?.unwrap_or(names[0]);
    let defaults = Settings::default();
    let settings = Settings {
        count: section.integer("count", COUNT)?.map(|n| n as usize),
        domain_um,
        degree: section.integer("degree", 0..=MAX_DEGREE as i64)?.map_or(defaults.degree, |n| n as usize),
        range: section.number("range", RANGE)?,
        criterion: CRITERIA.iter().find(|c| c.0 == criterion).map_or(defaults.criterion, |c| c.1),
        ..defaults
    };
    if section.has("steps") {
        section.refuse(&["steps_per_voxel"], "no `steps`")?;
    }
    let method = Method {
        accuracy: section.number("accuracy", ACCURACY)?.unwrap_or(DEFAULT_ACCURACY),
        settings,
        steps: section.integer("steps", 1..=MAX_STEPS)?.map(|n| n as usize),
        steps_per_voxel: section.number("steps_per_voxel", STEPS_PER_VOXEL)?,
        star_depth_voxels: section.integer("star_depth_voxels", STAR_DEPTH_VOXELS)?.map(|n| n as usize),
        bake: section.integer("bake", BAKE)?.map(|n| n as usize),
        volumes: match section.choice("volumes", &["single", "half"])? {
            Some("half") => Precision::Half,
            _ => Precision::Single,
        },
        sparse: match section.choice("sparse", &["auto", "always", "never"])? {
            Some("always") => Sparsity::Always,
            Some("never") => Sparsity::Never,
            _ => Sparsity::Auto,
        },
        bounces: section.integer("bounces", 1..=MANY_BOUNCES as i64)?.map_or(1, |n| n as usize),
        exact_stars: section.integer("exact_stars", 0..=MAX_EXACT_STARS)?.map(|n| n as usize),
        ..Method::default()
    };
    match section.text("name")? {
        Some(name) => section.wrap("name", method.with_name(name)),
        None => Ok(method),
    }
}
