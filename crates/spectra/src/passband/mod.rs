//! Passbands: what a telescope, a filter and a detector let through.
//!
//! R(λ) = T(λ) for energy-counting, T(λ) λ/λ_p for photon-counting detectors, so that a band radiance ∫ R I_λ dλ is in
//! W m⁻² sr⁻¹ for both and equals T·I for a line at the pivot wavelength λ_p (Tokunaga & Vacca 2005, PASP 117, 421):
//! λ_p² = ∫ T λ dλ / ∫ T/λ dλ (photons), ∫ T dλ / ∫ T/λ² dλ (energy).
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | T | `throughput` | 1 |
//! | R | `response` | 1 |
//!
//! Embedded curves are sections of the files of [`FAMILIES`], sets of them rows of [`SETS`]; analytic windows are in
//! `window`.

mod embedded;
mod leak;
mod window;

use std::sync::Arc;

pub use embedded::{FAMILIES, Family, SETS, SetEntry, family, names, set};
pub use leak::Leak;
pub use window::{Window, window};

use crate::curve::{CurveOptions, Ordinate, SpectralCurve};
use crate::error::{Result, SpectraError};
use crate::fingerprint::{Digest, Fingerprint};
use crate::quadrature::gauss_legendre;
use crate::table::Table;
use crate::units::Wavelength;

/// The quantity that a detector counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Counting {
    /// The detector counts energy: R = T.
    Energy,
    /// The detector counts photons: R = T λ/λ_p.
    Photon,
}

impl Counting {
    /// The name in scenes: "energy" or "photon".
    pub fn name(self) -> &'static str {
        match self {
            Counting::Energy => "energy",
            Counting::Photon => "photon",
        }
    }

    /// The way of counting called `name`.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "energy" => Ok(Counting::Energy),
            "photon" => Ok(Counting::Photon),
            _ => Err(SpectraError::unknown("way of counting", name, &["energy", "photon"])),
        }
    }
}

/// Throughput curve T(λ).
///
/// # Examples
/// A triangular filter from 0.5 to 0.7 µm:
///
/// ```
/// use spectra::passband::{Counting, Curve, Passband};
///
/// #[derive(Debug)]
/// struct Triangle;
///
/// impl Curve for Triangle {
///     fn throughput(&self, lambda_um: f64) -> f64 {
///         (1.0 - (lambda_um - 0.6).abs() / 0.1).max(0.0)
///     }
///     fn support_um(&self) -> (f64, f64) {
///         (0.5, 0.7)
///     }
///     fn breakpoints_um(&self) -> Vec<f64> {
///         vec![0.5, 0.6, 0.7]
///     }
/// }
///
/// let passband = Passband::new("triangle", Counting::Energy, Triangle)?;
/// assert!((passband.width().nm() - 100.0).abs() < 1e-9);
/// # Ok::<(), spectra::SpectraError>(())
/// ```
pub trait Curve: std::fmt::Debug + Send + Sync {
    /// The throughput T at a wavelength \[1\].
    fn throughput(&self, lambda_um: f64) -> f64;
    /// The interval in which T is not zero, (lowest, highest) \[µm\].
    fn support_um(&self) -> (f64, f64);
    /// The wavelengths at which T is not smooth, both ends of the support included \[µm\].
    fn breakpoints_um(&self) -> Vec<f64>;
    /// Adds the content to a digest. The default distinguishes objects by address.
    fn content(&self, digest: &mut Digest) {
        digest.object(self);
    }
}

impl Curve for Table {
    fn content(&self, digest: &mut Digest) {
        self.add_to(digest.text("table"));
    }
    fn throughput(&self, lambda_um: f64) -> f64 {
        self.at_or_zero(lambda_um)
    }
    fn support_um(&self) -> (f64, f64) {
        let first = self.y().iter().position(|t| *t > 0.0).unwrap_or(0);
        let last = self.y().iter().rposition(|t| *t > 0.0).unwrap_or(0);
        (self.x()[first.saturating_sub(1)], self.x()[(last + 1).min(self.x().len() - 1)])
    }
    fn breakpoints_um(&self) -> Vec<f64> {
        let (low, high) = self.support_um();
        self.x().iter().copied().filter(|x| (low..=high).contains(x)).collect()
    }
}

/// A passband: a throughput curve with its name, and what its detector counts.
#[derive(Debug, Clone)]
pub struct Passband {
    name: String,
    counting: Counting,
    pivot_um: f64,
    curve: Arc<dyn Curve>,
}

/// Gauss points a smooth piece of a passband is integrated with.
const PIECE_ORDER: usize = 4;
/// The widest piece, in parts of its wavelength: over it Wien's exponent of 2000 K at 0.2 µm changes by 0.7, k of any
/// law by a twentieth, so that four points leave a few parts in 1e10 of the piece. A curve's own pieces can be far
/// wider: the red leak of an ultraviolet filter is a few straight lines over hundreds of nanometres.
const PIECE_WIDTH: f64 = 0.02;
/// Most parts of one piece, whatever a user's curve says.
const MAX_PARTS: f64 = 1000.0;

impl Passband {
    /// Fingerprint of name, detector type and curve.
    pub fn fingerprint(&self) -> Fingerprint {
        let mut digest = Digest::new("passband");
        self.curve.content(digest.text(&self.name).text(self.counting.name()));
        digest.finish()
    }

    /// The largest throughput at its breakpoints \[1\].
    pub fn largest(&self) -> f64 {
        self.curve.breakpoints_um().iter().map(|l| self.curve.throughput(*l)).fold(0.0, f64::max)
    }

    /// A passband of a curve.
    ///
    /// # Errors
    /// If the curve is empty, negative, or no number.
    pub fn new(name: &str, counting: Counting, curve: impl Curve + 'static) -> Result<Self> {
        let breaks = curve.breakpoints_um();
        let wrong = |l: &&f64| !(0.0..).contains(&curve.throughput(**l));
        if let Some(l) = breaks.iter().find(wrong) {
            return Err(SpectraError::table(
                name,
                format!("throughput is negative or not a number at {:.4} nm; it must be between 0 and 1", l * 1e3),
            ));
        }
        let mut band = Self { name: name.to_owned(), counting, pivot_um: 1.0, curve: Arc::new(curve) };
        let moment = |power: i32| band.samples(&[]).iter().map(|(l, w)| w * band.curve.throughput(*l) * l.powi(power)).sum::<f64>();
        let (above, below) = match counting {
            Counting::Photon => (moment(1), moment(-1)),
            Counting::Energy => (moment(0), moment(-2)),
        };
        if !(above > 0.0 && below > 0.0 && above.is_finite()) {
            return Err(SpectraError::table(name, "the passband is empty: its throughput is zero everywhere"));
        }
        band.pivot_um = (above / below).sqrt();
        Ok(band)
    }

    /// The embedded passband called `name`, such as `johnson-V` or `hst-wfc3-f656n`.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn by_name(name: &str) -> Result<Self> {
        embedded::named(name)
    }

    /// A passband from the text of a user's curve: wavelength and throughput, as [`SpectralCurve::parse`] reads them.
    ///
    /// # Errors
    /// If the text is no such curve, its unit is unknown or ambiguous, or the curve is empty or negative.
    pub fn from_csv(name: &str, text: &str, counting: Counting) -> Result<Self> {
        Self::new(name, counting, SpectralCurve::parse(name, text, CurveOptions::of_file(Ordinate::Throughput))?.table)
    }

    /// The name of the band.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Copy of the band under another name.
    pub fn with_name(mut self, name: &str) -> Self {
        self.name = name.to_owned();
        self
    }

    /// The quantity that its detector counts.
    pub fn counting(&self) -> Counting {
        self.counting
    }

    /// The pivot wavelength λ_p.
    pub fn pivot(&self) -> Wavelength {
        Wavelength(self.pivot_um)
    }

    /// The response R(λ) \[1\].
    pub fn response(&self, lambda_um: f64) -> f64 {
        let t = self.curve.throughput(lambda_um);
        match self.counting {
            Counting::Energy => t,
            Counting::Photon => t * lambda_um / self.pivot_um,
        }
    }

    /// The interval in which the response is not zero, (lowest, highest) \[µm\].
    pub fn support_um(&self) -> (f64, f64) {
        self.curve.support_um()
    }

    /// Points and weights dλ \[µm\] for integrals over the band, split at its own breaks and at `breaks_um`.
    pub fn samples(&self, breaks_um: &[f64]) -> Vec<(f64, f64)> {
        let rule = gauss_legendre(PIECE_ORDER);
        let pieces = self.pieces(breaks_um);
        let narrow = |piece: &[f64]| {
            let (low, high) = (piece[0], piece[1]);
            let count = ((high - low) / (PIECE_WIDTH * low.max(f64::MIN_POSITIVE))).ceil().clamp(1.0, MAX_PARTS) as usize;
            let end = move |i: usize| low + (high - low) * i as f64 / count as f64;
            (0..count).map(move |i| (end(i), end(i + 1)))
        };
        let points = |(low, high): (f64, f64)| {
            let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
            rule.iter().map(move |(x, w)| (centre + half * x, half * w))
        };
        pieces.windows(2).flat_map(narrow).flat_map(points).collect()
    }

    /// The ascending ends of the pieces on which band and `breaks_um` are smooth \[µm\].
    pub fn pieces(&self, breaks_um: &[f64]) -> Vec<f64> {
        let (low, high) = self.support_um();
        let mut ends = self.curve.breakpoints_um();
        ends.extend(breaks_um.iter().copied().filter(|b| (low..=high).contains(b)));
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() < 1e-12 * b.abs());
        ends
    }

    /// ∫ R f dλ, in the unit of f times µm.
    pub fn integrate(&self, f: impl Fn(f64) -> f64) -> f64 {
        self.samples(&[]).iter().map(|(l, w)| w * self.response(*l) * f(*l)).sum()
    }

    /// Effective wavelength ∫ λ R s dλ / ∫ R s dλ for a spectrum s.
    pub fn effective_wavelength(&self, spectrum: impl Fn(f64) -> f64) -> Wavelength {
        Wavelength(self.integrate(|l| l * spectrum(l)) / self.integrate(&spectrum))
    }

    /// Equivalent width ∫ T dλ / max T.
    pub fn width(&self) -> Wavelength {
        let samples = self.samples(&[]);
        let area: f64 = samples.iter().map(|(l, w)| w * self.curve.throughput(*l)).sum();
        Wavelength(area / self.peak())
    }

    /// The largest throughput \[1\].
    pub fn peak(&self) -> f64 {
        let pieces = self.curve.breakpoints_um();
        let inner = self.samples(&[]);
        pieces.iter().copied().chain(inner.iter().map(|s| s.0)).map(|l| self.curve.throughput(l)).fold(0.0, f64::max)
    }
}
