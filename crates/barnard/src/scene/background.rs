//! The `[background]` table: what lies behind the cloud.

use spectra::sed::{Scale, StarShape, scaled};
use spectra::spectrum::Spectrum;
use spectra::units::{SkyDensity, SpectralLuminosity, SpectralRadiance, Wavelength};

use super::star::SPECTRA;
use super::{Key, Loader, Section, build_kind_with};
use crate::error::Result;

/// What lies behind.
#[derive(Debug, Clone, Default)]
pub struct Background {
    /// Even light I_λ [W m⁻² sr⁻¹ µm⁻¹].
    pub spectrum: Option<Spectrum>,
    /// Stars at infinity.
    pub star_field: Option<StarField>,
}

/// Stars scattered over the sky, the same from every camera.
#[derive(Debug, Clone, PartialEq)]
pub struct StarField {
    /// Number of the field.
    pub seed: u64,
    /// Stars per solid angle [sr⁻¹].
    pub density_per_sr: f64,
    /// Brightest and faintest V magnitude.
    pub magnitudes: (f64, f64),
}

/// Keys of an even background beside those of its spectrum.
pub(super) const UNIFORM_KEYS: &[Key] = &[
    Key::required("radiance", "spectral radiance", "at `wavelength`"),
    Key::optional("wavelength", "wavelength", "550 nm", "where the radiance holds"),
    Key::optional("stars", "table", "none", "a field of stars as well"),
];

/// Keys of `[background.stars]`.
pub(super) const STAR_KEYS: &[Key] = &[
    Key::optional("seed", "integer", "1", "number of the field"),
    Key::optional("density", "density on the sky", "2000 /deg2", "stars per solid angle"),
    Key::optional("brightest", "number", "8", "V magnitude (Vega) of the brightest"),
    Key::optional("faintest", "number", "18", "V magnitude (Vega) of the faintest; counts grow as 10^(0.4 m)"),
];

pub(super) fn build(section: &Section, loader: &Loader) -> Result<Background> {
    let star_field = section.table("stars")?.map(|s| star_field(&s)).transpose()?;
    if !section.has("kind") {
        let keys: Vec<&str> = vec!["kind", "stars"];
        section.check_keys(&keys)?;
        return Ok(Background { spectrum: None, star_field });
    }
    let shape: StarShape = build_kind_with("spectrum", SPECTRA, UNIFORM_KEYS, section, loader)?;
    let radiance = section.need_positive::<SpectralRadiance>("radiance")?;
    let at = section.positive::<Wavelength>("wavelength")?.unwrap_or(Wavelength(0.55));
    // Only the shape and its value at one wavelength matter: radiance takes the place of luminosity.
    let spectrum = section.wrap("radiance", scaled(shape, &Scale::SpectralLuminosity(SpectralLuminosity(radiance.0), at)))?;
    Ok(Background { spectrum: Some(spectrum), star_field })
}

fn star_field(section: &Section) -> Result<StarField> {
    let keys: Vec<&str> = STAR_KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let magnitudes = (section.number("brightest", -30.0..=40.0)?.unwrap_or(8.0), section.number("faintest", -30.0..=40.0)?.unwrap_or(18.0));
    if magnitudes.0 >= magnitudes.1 {
        return Err(section.error("faintest", "faintest must be a larger magnitude than brightest"));
    }
    Ok(StarField {
        seed: section.integer("seed", 0..=i64::MAX)?.unwrap_or(1) as u64,
        density_per_sr: section.positive::<SkyDensity>("density")?.map_or_else(default_density, |d| d.0),
        magnitudes,
    })
}

fn default_density() -> f64 {
    use spectra::units::Quantity;
    2000.0 * SkyDensity::unit_size("/deg2").unwrap_or(1.0)
}
