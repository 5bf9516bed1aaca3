//! The `[background]` table: what lies behind the cloud.

use spectra::sed::{Scale, StarShape, scaled};
use spectra::spectrum::Spectrum;
use spectra::units::{SkyDensity, SpectralLuminosity, SpectralRadiance, Wavelength};

use super::star::SPECTRA;
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::properties::{Integer, Key, KeyRow, Number, OrDefault, Required, Section, SubTable, build_kind_with};
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

const RADIANCE: Key<SpectralRadiance, Required> = Key::quantity::<SpectralRadiance>("radiance", "at `wavelength`").positive().required();
const WAVELENGTH: Key<Wavelength, OrDefault> =
    Key::quantity::<Wavelength>("wavelength", "wavelength of the radiance").positive().default("550 nm");
const STARS: Key<SubTable> = Key::table("stars", "a field of stars");
const CATALOGUE: Key<SubTable> = Key::table("catalogue", "stars of a CSV at their sky positions");
const SEED: Key<Integer<u64>, OrDefault> = Key::integer("seed", "seed of the random field").default(1);
const DENSITY: Key<SkyDensity, OrDefault> =
    Key::quantity::<SkyDensity>("density", "stars per solid angle").positive().default("2000 /deg2");
const BRIGHTEST: Key<Number, OrDefault> = Key::number("brightest", "V magnitude (Vega) of the brightest").range(MAGNITUDES).default(8.0);
const FAINTEST: Key<Number, OrDefault> =
    Key::number("faintest", "V magnitude (Vega) of the faintest; counts grow as 10^(0.4 m)").range(MAGNITUDES).default(18.0);

/// Keys of an even background beside those of its spectrum.
pub(super) const UNIFORM_KEYS: &[KeyRow] = &[RADIANCE.row, WAVELENGTH.row, STARS.row, CATALOGUE.row];

/// The keys of `[background.stars]`.
pub(super) const STAR_KEYS: &[KeyRow] = &[SEED.row, DENSITY.row, BRIGHTEST.row, FAINTEST.row];

/// Reads all but the catalogue's stars, which are the loader's to keep.
pub(super) fn build(section: &Section, inputs: &Inputs, catalogue: Option<PlacedCatalogue>) -> Result<Background> {
    let star_field = section.read(&STARS)?.map(|s| star_field(&s)).transpose()?;
    if section.kind().is_none() {
        section.check(&[STARS.row, CATALOGUE.row])?;
        return Ok(Background { spectrum: None, star_field, catalogue });
    }
    let shape: StarShape = build_kind_with("spectrum", SPECTRA, UNIFORM_KEYS, section, inputs)?;
    let radiance = section.read(&RADIANCE)?;
    let at = section.read(&WAVELENGTH)?;
    // Only the shape and its value at one wavelength matter: radiance takes the place of luminosity.
    let spectrum = section.wrap(&RADIANCE, scaled(shape, &Scale::SpectralLuminosity(SpectralLuminosity(radiance.0), at)))?;
    Ok(Background { spectrum: Some(spectrum), star_field, catalogue })
}

fn star_field(section: &Section) -> Result<StarField> {
    section.check(STAR_KEYS)?;
    let magnitudes = (section.read(&BRIGHTEST)?, section.read(&FAINTEST)?);
    if magnitudes.0 >= magnitudes.1 {
        return Err(section.error(&FAINTEST, "faintest must be larger than brightest"));
    }
    Ok(StarField { seed: section.read(&SEED)?, density_per_sr: section.read(&DENSITY)?.0, magnitudes })
}

fn default_density() -> f64 {
    use spectra::units::Quantity;
    2000.0 * SkyDensity::unit_size("/deg2").unwrap_or(1.0)
}
