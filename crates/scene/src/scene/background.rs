//! The `[background]` table: what lies behind the cloud.

use spectra::sed::{Scale, StarShape, scaled};
use spectra::spectrum::Spectrum;
use spectra::units::{SkyDensity, SpectralLuminosity, SpectralRadiance, Wavelength};

use super::star::SPECTRA;
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::properties::{Key, Section, build_kind_with};
use crate::star_catalogue::PlacedCatalogue;

/// Background: light from all directions, and stars.
#[derive(Debug, Clone, Default)]
pub struct Background {
    /// Even light I_λ [W m⁻² sr⁻¹ µm⁻¹].
    pub spectrum: Option<Spectrum>,
    /// Stars at infinity that are scattered.
    pub star_field: Option<StarField>,
    /// Stars at infinity that are known.
    pub catalogue: Option<PlacedCatalogue>,
}

impl Background {
    /// An even light I_λ [W m⁻² sr⁻¹ µm⁻¹].
    pub fn even(spectrum: Spectrum) -> Self {
        Self { spectrum: Some(spectrum), ..Self::default() }
    }

    /// A background of stars alone.
    pub fn stars(field: StarField) -> Self {
        Self { star_field: Some(field), ..Self::default() }
    }

    /// Copy of the background with a field of stars over its light.
    #[must_use]
    pub fn with_stars(self, field: StarField) -> Self {
        Self { star_field: Some(field), ..self }
    }

    /// Copy of the background with the stars of a catalogue over its light.
    #[must_use]
    pub fn with_catalogue(self, catalogue: PlacedCatalogue) -> Self {
        Self { catalogue: Some(catalogue), ..self }
    }

    /// True if there are stars at infinity.
    pub fn has_stars(&self) -> bool {
        self.star_field.is_some() || self.catalogue.is_some()
    }

    /// Refuses numbers that no sky has.
    pub(super) fn check(&self) -> Result<()> {
        if self.spectrum.as_ref().is_some_and(|s| !s.is_light()) {
            return Err(Error::out_of_range("spectrum of the background", "negative or not finite", "finite and at least zero"));
        }
        self.star_field.as_ref().map_or(Ok(()), StarField::check)
    }
}

/// Stars scattered over the sky, the same from every camera.
#[derive(Debug, Clone, PartialEq)]
pub struct StarField {
    /// The seed of the field.
    pub seed: u64,
    /// Stars per solid angle [sr⁻¹].
    pub density_per_sr: f64,
    /// Brightest and faintest V magnitude.
    pub magnitudes: (f64, f64),
}

impl Default for StarField {
    /// The field that `[background.stars]` is where it says nothing else.
    fn default() -> Self {
        Self { seed: 1, density_per_sr: default_density(), magnitudes: (8.0, 18.0) }
    }
}

/// Magnitudes that stars may have.
const MAGNITUDES: std::ops::RangeInclusive<f64> = -30.0..=40.0;

impl StarField {
    fn check(&self) -> Result<()> {
        let (bright, faint) = self.magnitudes;
        if !(self.density_per_sr > 0.0 && self.density_per_sr.is_finite()) {
            return Err(Error::out_of_range("density of field stars", self.density_per_sr, "finite and above zero"));
        }
        if !(MAGNITUDES.contains(&bright) && MAGNITUDES.contains(&faint) && bright < faint) {
            let value = format!("{bright} to {faint}");
            return Err(Error::out_of_range("magnitude range of field stars", value, "from brighter to fainter, within -30 to 40"));
        }
        Ok(())
    }
}

/// Keys of an even background beside those of its spectrum.
pub(super) const UNIFORM_KEYS: &[Key] = &[
    Key::required("radiance", "spectral radiance", "at `wavelength`"),
    Key::optional("wavelength", "wavelength", "550 nm", "wavelength of the radiance"),
    Key::optional("stars", "table", "none", "a field of stars"),
    Key::optional("catalogue", "table", "none", "stars of a CSV at their sky positions"),
];

/// The keys of `[background.stars]`.
pub(super) const STAR_KEYS: &[Key] = &[
    Key::optional("seed", "integer", "1", "seed of the random field"),
    Key::optional("density", "density on the sky", "2000 /deg2", "stars per solid angle"),
    Key::optional("brightest", "number", "8", "V magnitude (Vega) of the brightest"),
    Key::optional("faintest", "number", "18", "V magnitude (Vega) of the faintest; counts grow as 10^(0.4 m)"),
];

/// Reads all but the catalogue's stars, which are the loader's to keep.
pub(super) fn build(section: &Section, inputs: &Inputs, catalogue: Option<PlacedCatalogue>) -> Result<Background> {
    let star_field = section.table("stars")?.map(|s| star_field(&s)).transpose()?;
    if !section.has("kind") {
        let keys: Vec<&str> = vec!["kind", "stars", "catalogue"];
        section.check_keys(&keys)?;
        return Ok(Background { spectrum: None, star_field, catalogue });
    }
    let shape: StarShape = build_kind_with("spectrum", SPECTRA, UNIFORM_KEYS, section, inputs)?;
    let radiance = section.need_positive::<SpectralRadiance>("radiance")?;
    let at = section.positive::<Wavelength>("wavelength")?.unwrap_or(Wavelength(0.55));
    // Only the shape and its value at one wavelength matter: radiance takes the place of luminosity.
    let spectrum = section.wrap("radiance", scaled(shape, &Scale::SpectralLuminosity(SpectralLuminosity(radiance.0), at)))?;
    Ok(Background { spectrum: Some(spectrum), star_field, catalogue })
}

fn star_field(section: &Section) -> Result<StarField> {
    let keys: Vec<&str> = STAR_KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let plain = StarField::default();
    let magnitude = |key, otherwise| section.number(key, MAGNITUDES).map(|m| m.unwrap_or(otherwise));
    let magnitudes = (magnitude("brightest", plain.magnitudes.0)?, magnitude("faintest", plain.magnitudes.1)?);
    if magnitudes.0 >= magnitudes.1 {
        return Err(section.error("faintest", "faintest must be larger than brightest"));
    }
    Ok(StarField {
        seed: section.integer("seed", 0..=i64::MAX)?.map_or(plain.seed, |n| n as u64),
        density_per_sr: section.positive::<SkyDensity>("density")?.map_or(plain.density_per_sr, |d| d.0),
        magnitudes,
    })
}

fn default_density() -> f64 {
    use spectra::units::Quantity;
    2000.0 * SkyDensity::unit_size("/deg2").unwrap_or(1.0)
}
