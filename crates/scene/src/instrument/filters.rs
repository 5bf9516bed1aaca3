//! Which passbands an instrument has.

use spectra::passband::Passband;

use super::Instrument;
use crate::error::{Error, Result};

/// Passbands of the catalogue by what their names begin with and where their pivot wavelengths lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filters {
    /// Prefix of the names.
    pub family: &'static str,
    /// The shortest and the longest pivot wavelength \[µm\].
    pub um: (f64, f64),
}

impl Filters {
    /// All passbands of a family.
    pub const fn all(family: &'static str) -> Self {
        Self { family, um: (0.0, f64::INFINITY) }
    }

    fn has(&self, band: &Passband) -> bool {
        band.name().starts_with(self.family) && (self.um.0..=self.um.1).contains(&band.pivot().0)
    }
}

impl Instrument {
    /// Refuses passbands of the catalogue that belong to other instruments; those that a scene defines itself are taken to be its own.
    pub(super) fn check_filters(&self, bands: &[Passband]) -> Result<()> {
        let is_own = |band: &Passband| self.filters.is_empty() || self.filters.iter().any(|filters| filters.has(band));
        let is_foreign = |band: &&Passband| !is_own(band) && Passband::by_name(band.name()).is_ok();
        let Some(foreign) = bands.iter().find(is_foreign).filter(|_| !self.allow_foreign_filters) else { return Ok(()) };
        let family = passbands(|name| self.filters.iter().any(|filters| name.starts_with(filters.family)));
        let names: Vec<String> = family.into_iter().filter(is_own).map(|band| band.name().to_owned()).collect();
        let shown = match &names[..] {
            [first, .., last] if names.len() > 8 => format!("{first} to {last} and {} more", names.len() - 2),
            all => all.join(", "),
        };
        let problem = format!("{} is not a filter of {}", foreign.name(), self.name);
        Err(Error::conflict(problem, format!("use its own ({shown}), another instrument, or allow_foreign_filters = true")))
    }
}

/// The passbands of the catalogue with some names, by wavelength.
fn passbands(is_wanted: impl Fn(&str) -> bool) -> Vec<Passband> {
    let names = spectra::passband::names().into_iter().filter(|name| is_wanted(name));
    let mut all: Vec<Passband> = names.filter_map(|name| Passband::by_name(name).ok()).collect();
    all.sort_by(|a, b| a.pivot().0.total_cmp(&b.pivot().0));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::preset;

    /// UVIS has no filter of the infrared channel, of Webb or of Johnson, and says which it has.
    #[test]
    fn filters_of_others_are_refused() {
        let instrument = preset("hst-wfc3-uvis").unwrap();
        let band = |name: &str| Passband::by_name(name).unwrap();
        for name in ["hst-wfc3-f656n", "hst-wfc3-f225w", "hst-wfc3-f953n"] {
            assert!(instrument.check_filters(&[band(name)]).is_ok(), "{name}");
        }
        for name in ["jwst-miri-f770w", "jwst-nircam-f164n", "johnson-V", "hst-wfc3-f160w"] {
            let words = instrument.check_filters(&[band("hst-wfc3-f656n"), band(name)]).unwrap_err().to_string();
            assert!(words.contains(name) && words.contains("hst-wfc3-f953n") && words.contains("allow_foreign_filters"), "{words}");
            let allowed = Instrument { allow_foreign_filters: true, ..instrument.clone() };
            assert!(allowed.check_filters(&[band(name)]).is_ok());
        }
        let short = preset("jwst-nircam-short").unwrap();
        assert!(short.check_filters(&[band("jwst-nircam-f200w")]).is_ok() && short.check_filters(&[band("jwst-nircam-f444w")]).is_err());
        assert!(Instrument::of_aperture(1.0).check_filters(&[band("johnson-V")]).is_ok());
        // One's own curve is one's own filter.
        let measured = Passband::by_name("johnson-V").unwrap().with_name("my V");
        assert!(instrument.check_filters(&[measured]).is_ok());
    }
}
