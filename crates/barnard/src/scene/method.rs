//! The `[method]` table: how spectral integrals are done, and how exact.

use spectra::rule;
use spectra::units::Wavelength;

use super::{Key, Section};
use crate::error::Result;

/// How the spectral integrals are done.
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    /// The spectral rule's name.
    pub name: &'static str,
    /// Allowed error relative to F(0), and of the image relative to its rms [1].
    pub accuracy: f64,
    /// A fixed number of nodes a band.
    pub count: Option<usize>,
    /// The domain D of rules that work in λ [µm]; each band's own support otherwise.
    pub domain_um: Option<(f64, f64)>,
    /// A fixed number of samples a ray.
    pub steps: Option<usize>,
    /// Voxels along the longest edge of a baked function; by the field's finest structure otherwise.
    pub bake: Option<usize>,
}

/// Most samples a ray that may be asked for.
pub const MAX_STEPS: i64 = 1_000_000;

/// The accuracy that holds unless told otherwise.
pub const DEFAULT_ACCURACY: f64 = 1e-3;

impl Default for Method {
    fn default() -> Self {
        Self { name: rule::RULES[0].name, accuracy: DEFAULT_ACCURACY, count: None, domain_um: None, steps: None, bake: None }
    }
}

impl Method {
    /// The rule called `name` in place of this one's.
    pub fn with_name(mut self, name: &str) -> spectra::Result<Self> {
        self.name = rule::rule(name)?.name;
        Ok(self)
    }
}

pub(super) const KEYS: &[Key] = &[
    Key::optional("name", "text", "band_quadrature", "spectral rule"),
    Key::optional(
        "accuracy",
        "number",
        "0.001",
        "allowed error: spectral relative to the light without extinction, spatial relative to the image's rms",
    ),
    Key::optional("count", "integer", "chosen by accuracy", "fixed number of nodes a band, for comparisons"),
    Key::optional(
        "domain",
        "list of texts",
        "each band's own",
        "wavelengths between which newton and gauss_legendre place their points, such as [\"300 nm\", \"1 um\"]",
    ),
    Key::optional("steps", "integer", "chosen by accuracy", "fixed number of samples a ray, for comparisons"),
    Key::optional(
        "bake",
        "integer",
        "by the finest structure, at most 256",
        "voxels along the longest edge onto which functions are sampled for the fast back ends",
    ),
];

pub(super) fn build(section: Option<&Section>) -> Result<Method> {
    let Some(section) = section else { return Ok(Method::default()) };
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let name = section.wrap("name", rule::rule(section.text("name")?.unwrap_or(rule::RULES[0].name)))?.name;
    let domain_um = match section.texts("domain")? {
        None => None,
        Some(ends) => {
            let wrong = || section.error("domain", "a domain is two ascending wavelengths, such as [\"300 nm\", \"1 um\"]");
            let &[low, high] = &ends[..] else { return Err(wrong()) };
            let low: Wavelength = section.wrap("domain", low.parse())?;
            let high: Wavelength = section.wrap("domain", high.parse())?;
            if !(low.0 > 0.0 && low.0 < high.0) {
                return Err(wrong());
            }
            Some((low.0, high.0))
        }
    };
    Ok(Method {
        name,
        accuracy: section.number("accuracy", 1e-9..=0.5)?.unwrap_or(DEFAULT_ACCURACY),
        count: section.integer("count", 1..=4096)?.map(|n| n as usize),
        domain_um,
        steps: section.integer("steps", 1..=MAX_STEPS)?.map(|n| n as usize),
        bake: section.integer("bake", 4..=2048)?.map(|n| n as usize),
    })
}
