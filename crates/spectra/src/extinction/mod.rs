//! Extinction laws: the shape k(λ) = A(λ)/A(V) of dust extinction.
//!
//! A law is one file and one row of [`LAWS`]. Outside of its validity range a law is an error, never an extrapolation:
//! [`Extinction::check`] is asked once for each passband, [`ExtinctionLaw::k`] may then be called inside.

mod ccm89;
mod fitzpatrick99;
mod fitzpatrick_massa90;
mod gordon23;
mod inverse_wavelength;
mod odonnell94;
mod tabulated;

pub use tabulated::DustTable;

use std::borrow::Cow;

use crate::error::{Result, SpectraError};
use crate::fingerprint::{Digest, Fingerprint};

/// Extinction curve.
///
/// # Examples
/// Extinction proportional to λ^-1.5:
///
/// ```
/// use spectra::extinction::{Extinction, ExtinctionLaw};
///
/// #[derive(Debug)]
/// struct PowerLaw;
///
/// impl ExtinctionLaw for PowerLaw {
///     fn k(&self, lambda_um: f64) -> f64 {
///         (lambda_um / 0.55).powf(-1.5)
///     }
///     fn range_um(&self) -> (f64, f64) {
///         (0.1, 5.0)
///     }
/// }
///
/// let law = Extinction::new("power law", PowerLaw);
/// assert!((law.k(0.55) - 1.0).abs() < 1e-12);
/// ```
pub trait ExtinctionLaw: std::fmt::Debug + Send + Sync {
    /// Extinction relative to V, k(λ) = A(λ)/A(V) \[1\]; λ \[µm\] within [`Self::range_um`].
    fn k(&self, lambda_um: f64) -> f64;
    /// The interval in which the law is valid, (lowest, highest) \[µm\].
    fn range_um(&self) -> (f64, f64);
    /// Wavelengths at which the law is not smooth \[µm\].
    fn breakpoints_um(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Albedo and mean cosine, where the law comes with them.
    fn dust_table(&self) -> Option<&DustTable> {
        None
    }
    /// Adds the content to a digest. The default distinguishes objects by address.
    fn content(&self, digest: &mut Digest) {
        digest.object(self);
    }
}

/// The way in which a law is made.
#[derive(Clone, Copy)]
pub enum Maker {
    /// The law is made from R_V, valid between two values; the default is 3.1.
    RatioOfV {
        /// The least R_V.
        low: f64,
        /// The largest R_V.
        high: f64,
        /// Makes the law of an R_V.
        make: fn(f64) -> Box<dyn ExtinctionLaw>,
    },
    /// The law has no parameter.
    Fixed(fn() -> Result<Box<dyn ExtinctionLaw>>),
}

/// One row of the catalogue of extinction laws.
#[derive(Clone, Copy)]
pub struct LawEntry {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary and source in one line.
    pub summary: &'static str,
    /// The way in which it is made.
    pub maker: Maker,
}

/// All extinction laws.
pub const LAWS: &[LawEntry] = &[
    inverse_wavelength::ENTRY,
    ccm89::ENTRY,
    odonnell94::ENTRY,
    fitzpatrick99::ENTRY,
    gordon23::ENTRY,
    tabulated::DRAINE_RV31,
    tabulated::DRAINE_RV40,
    tabulated::DRAINE_RV55,
    tabulated::LMC,
    tabulated::SMC,
];

/// The ratio A(V)/E(B−V) of the diffuse Milky Way \[1\].
pub const DEFAULT_R_V: f64 = 3.1;

/// A law with its name.
#[derive(Debug)]
pub struct Extinction {
    /// The catalogue's name, or one's own.
    pub name: Cow<'static, str>,
    /// R_V, where the law takes one \[1\].
    pub r_v: Option<f64>,
    law: Box<dyn ExtinctionLaw>,
}

impl Extinction {
    /// Fingerprint of name, R_V and law.
    pub fn fingerprint(&self) -> Fingerprint {
        let mut digest = Digest::new("extinction");
        self.law.content(digest.text(&self.name).plain(&self.r_v));
        digest.finish()
    }

    /// A law of one's own.
    pub fn new(name: impl Into<Cow<'static, str>>, law: impl ExtinctionLaw + 'static) -> Self {
        Self { name: name.into(), r_v: None, law: Box::new(law) }
    }

    /// The law of the catalogue called `name`, with R_V = 3.1 where it takes one.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn by_name(name: &str) -> Result<Self> {
        Self::with_r_v(name, None)
    }

    /// The law called `name` with another R_V = A(V)/E(B−V).
    ///
    /// # Errors
    /// If there is no such law, it takes no R_V, or not this one.
    pub fn with_r_v(name: &str, r_v: Option<f64>) -> Result<Self> {
        let known: Vec<&str> = LAWS.iter().map(|l| l.name).collect();
        let entry = LAWS.iter().find(|l| l.name == name).ok_or_else(|| SpectraError::unknown("extinction law", name, &known))?;
        let (law, r_v) = match (entry.maker, r_v) {
            (Maker::RatioOfV { low, high, make }, r_v) => {
                let r_v = r_v.unwrap_or(DEFAULT_R_V);
                if !(low..=high).contains(&r_v) {
                    return Err(SpectraError::Range { what: format!("R_V of {name}"), value: r_v, low, high });
                }
                (make(r_v), Some(r_v))
            }
            (Maker::Fixed(make), None) => (make()?, None),
            (Maker::Fixed(_), Some(_)) => {
                return Err(SpectraError::Law(format!(
                    "extinction law \"{name}\" does not support r_v; remove it or use ccm89, odonnell94, fitzpatrick99 or gordon23"
                )));
            }
        };
        Ok(Self { name: Cow::Borrowed(entry.name), r_v, law })
    }

    /// Grain model of the scattering by the law's dust: its own; for a law of the Milky Way, which takes R_V
    /// and is extinction alone, that of Draine 2003 whose R_V is nearest. Other laws have none.
    pub fn grains(&self) -> Option<DustTable> {
        let borrowed = || match tabulated::nearest_in_the_milky_way(self.r_v?).maker {
            Maker::Fixed(make) => make().ok()?.dust_table().cloned(),
            Maker::RatioOfV { .. } => None,
        };
        self.dust_table().cloned().or_else(borrowed)
    }

    /// Checks that the law holds from `low_um` to `high_um`; the error names `what` asked.
    ///
    /// # Errors
    /// If it does not, with the interval in which it does.
    pub fn check(&self, what: &str, low_um: f64, high_um: f64) -> Result<()> {
        let (low, high) = self.law.range_um();
        // Ranges are published with few digits: a part in 10⁹ is rounding, not extrapolation.
        if low_um < low * (1.0 - 1e-9) || high_um > high * (1.0 + 1e-9) {
            return Err(SpectraError::Reach(format!(
                "{what} covers {:.6} to {:.6} um, but extinction law \"{}\" is valid only from {low:.6} to {high:.6} um; use a law with a wider range, such as {}",
                low_um,
                high_um,
                self.name,
                if self.name == "gordon23" { "draine03_rv31" } else { "gordon23" }
            )));
        }
        Ok(())
    }
}

impl std::ops::Deref for Extinction {
    type Target = dyn ExtinctionLaw;
    fn deref(&self) -> &Self::Target {
        &*self.law
    }
}

/// Σ cᵢ xⁱ, highest power first: as the papers print their polynomials.
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_is_near_one_at_v_and_falls_to_the_red() {
        for entry in LAWS {
            let law = Extinction::by_name(entry.name).unwrap();
            assert!((law.k(0.55) - 1.0).abs() < 0.025, "{}: {}", entry.name, law.k(0.55));
            assert!(law.k(0.44) > law.k(0.55) && law.k(0.55) > law.k(0.8), "{}", entry.name);
        }
    }

    #[test]
    fn ranges_are_enforced() {
        for entry in LAWS {
            let law = Extinction::by_name(entry.name).unwrap();
            let (low, high) = law.range_um();
            assert!(law.check("x", low, high).is_ok(), "{}", entry.name);
            assert!(law.check("x", low * 0.99, high).is_err() || low == 0.0, "{}", entry.name);
            assert!(law.check("x", low, high * 1.01).is_err() || high.is_infinite(), "{}", entry.name);
            if let Maker::RatioOfV { low, high, .. } = entry.maker {
                assert!(Extinction::with_r_v(entry.name, Some(low - 0.1)).is_err());
                assert!(Extinction::with_r_v(entry.name, Some(high + 0.1)).is_err());
            }
        }
    }

    #[test]
    fn laws_of_the_milky_way_have_the_grains_of_their_r_v() {
        let grains = |law, r_v| Extinction::with_r_v(law, r_v).unwrap().grains().map(|g| g.name);
        assert_eq!(grains("gordon23", None), Some("draine03_rv31"));
        assert_eq!(grains("ccm89", Some(3.7)), Some("draine03_rv40"));
        assert_eq!(grains("gordon23", Some(5.6)), Some("draine03_rv55"));
        assert_eq!(grains("wd01_smc", None), Some("wd01_smc"));
        assert_eq!(grains("inverse_wavelength", None), None);
        // They reach wherever a law of the Milky Way does.
        for entry in LAWS.iter().filter(|entry| matches!(entry.maker, Maker::RatioOfV { .. })) {
            let law = Extinction::by_name(entry.name).unwrap();
            let ((low, high), (least, most)) = (law.range_um(), law.grains().unwrap().albedo.range());
            assert!(least <= low && most >= high, "{}", entry.name);
        }
    }

    #[test]
    fn unknown_names_are_answered_with_the_nearest() {
        let message = Extinction::by_name("ccm98").unwrap_err().to_string();
        assert!(message.contains("ccm89"), "{message}");
    }
}
