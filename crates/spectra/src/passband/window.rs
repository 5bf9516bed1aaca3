//! Analytic passbands.
//!
//! | window | T(λ) | support |
//! |---|---|---|
//! | top-hat | 1 | centre ± width/2 |
//! | Gaussian | exp(−4 ln 2 ((λ − c)/FWHM)²) | centre ± 2.5 FWHM |
//! | cos² | cos²(π(λ − c)/(2 h)) | centre ± half-width h |
//! | channel | ½ [erf((λ − l)/(σ√2)) − erf((λ − h)/(σ√2))], l and h at centre ± width/2: neighbours sum to one | 6 σ beyond both |
//! | polynomial | Σ cᵢ λⁱ, λ in µm, cut at zero | given |

use super::{Counting, Curve, Passband};
use crate::error::{Result, SpectraError};
use crate::fingerprint::Digest;
use crate::units::Wavelength;

/// The shape of an analytic passband.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Window {
    /// A window that is one within centre ± width/2.
    TopHat {
        /// The middle of the window.
        centre: Wavelength,
        /// The full width.
        width: Wavelength,
    },
    /// A Gaussian window.
    Gaussian {
        /// The middle of the window.
        centre: Wavelength,
        /// The full width at half maximum.
        fwhm: Wavelength,
    },
    /// A squared cosine.
    Cos2 {
        /// The middle of the window.
        centre: Wavelength,
        /// The distance at which it reaches zero on both sides.
        half_width: Wavelength,
    },
    /// A window that is one between two edges, spread by a Gaussian: a channel of a spectrograph.
    Channel {
        /// The middle of the window.
        centre: Wavelength,
        /// The width before it is spread.
        width: Wavelength,
        /// The standard deviation of the Gaussian.
        deviation: Wavelength,
    },
    /// A polynomial in λ \[µm\], lowest power first.
    Polynomial {
        /// The coefficients of Σ cᵢ λⁱ.
        coefficients: Vec<f64>,
        /// The lowest wavelength.
        low: Wavelength,
        /// The highest wavelength.
        high: Wavelength,
    },
}

/// Standard deviations beyond which a channel sees nothing: a part in 1e9 of a line.
const TAIL: f64 = 6.0;
/// Pieces that a smooth window is cut into for integration.
const PIECES: usize = 32;

impl Curve for Window {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn throughput(&self, lambda_um: f64) -> f64 {
        let (low, high) = self.support_um();
        if !(low..=high).contains(&lambda_um) {
            return 0.0;
        }
        match self {
            Window::TopHat { .. } => 1.0,
            Window::Gaussian { centre, fwhm } => (-4.0 * std::f64::consts::LN_2 * ((lambda_um - centre.0) / fwhm.0).powi(2)).exp(),
            Window::Cos2 { centre, half_width } => (std::f64::consts::FRAC_PI_2 * (lambda_um - centre.0) / half_width.0).cos().powi(2),
            Window::Channel { centre, width, deviation } => {
                let risen = |edge: f64| libm::erf((lambda_um - centre.0 - edge) / (deviation.0 * std::f64::consts::SQRT_2));
                0.5 * (risen(-0.5 * width.0) - risen(0.5 * width.0))
            }
            Window::Polynomial { coefficients, .. } => coefficients.iter().rev().fold(0.0, |s, c| s * lambda_um + c).max(0.0),
        }
    }

    fn support_um(&self) -> (f64, f64) {
        match self {
            Window::TopHat { centre, width } => (centre.0 - 0.5 * width.0, centre.0 + 0.5 * width.0),
            Window::Gaussian { centre, fwhm } => (centre.0 - 2.5 * fwhm.0, centre.0 + 2.5 * fwhm.0),
            Window::Cos2 { centre, half_width } => (centre.0 - half_width.0, centre.0 + half_width.0),
            Window::Channel { centre, width, deviation } => {
                let half = 0.5 * width.0 + TAIL * deviation.0;
                (centre.0 - half, centre.0 + half)
            }
            Window::Polynomial { low, high, .. } => (low.0, high.0),
        }
    }

    fn breakpoints_um(&self) -> Vec<f64> {
        let (low, high) = self.support_um();
        (0..=PIECES).map(|i| low + (high - low) * i as f64 / PIECES as f64).collect()
    }
}

/// A passband from an analytic window; its support must lie at positive wavelengths and have a width.
///
/// # Errors
/// If its support lies elsewhere or has no width.
pub fn window(name: &str, counting: Counting, shape: Window) -> Result<Passband> {
    let (low, high) = shape.support_um();
    if !(low > 0.0 && high > low && high.is_finite()) {
        return Err(SpectraError::Passband(format!(
            "passband {name} covers {:.4} to {:.4} nm; it must have a positive width above 0 nm",
            low * 1e3,
            high * 1e3
        )));
    }
    Passband::new(name, counting, shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nm(v: f64) -> Wavelength {
        Wavelength::from_nm(v)
    }

    /// ∫ cos² = h, ∫ top-hat = w, ∫ Gaussian = FWHM √(π/(4 ln 2)).
    #[test]
    fn areas() {
        let area = |shape| window("w", Counting::Energy, shape).unwrap().integrate(|_| 1.0);
        assert!((area(Window::Cos2 { centre: nm(550.0), half_width: nm(70.0) }) - 0.07).abs() < 1e-12);
        assert!((area(Window::TopHat { centre: nm(550.0), width: nm(70.0) }) - 0.07).abs() < 1e-12);
        let gaussian = 0.07 * (std::f64::consts::PI / (4.0 * std::f64::consts::LN_2)).sqrt();
        assert!((area(Window::Gaussian { centre: nm(550.0), fwhm: nm(70.0) }) / gaussian - 1.0).abs() < 1e-7);
        let channel = |centre: f64| Window::Channel { centre: nm(centre), width: nm(2.0), deviation: nm(1.5) };
        assert!((area(channel(550.0)) - 0.002).abs() < 1e-10);
        // Channels side by side are one together, but for the ends.
        for lambda in [0.55, 0.5513, 0.5487] {
            let sum: f64 = (-12..=12).map(|i| channel(550.0 + 2.0 * f64::from(i)).throughput(lambda)).sum();
            assert!((sum - 1.0).abs() < 1e-8, "{lambda}: {sum}");
        }
        let polynomial = Window::Polynomial { coefficients: vec![0.0, 1.0], low: nm(400.0), high: nm(600.0) };
        assert!((area(polynomial) - 0.5 * (0.36 - 0.16)).abs() < 1e-12);
    }

    #[test]
    fn effective_wavelength_and_width() {
        let band = window("w", Counting::Photon, Window::TopHat { centre: nm(500.0), width: nm(100.0) }).unwrap();
        // Photon-counting flat spectrum: ∫λ²/∫λ over 0.45…0.55.
        let expected = (0.55f64.powi(3) - 0.45f64.powi(3)) / 3.0 / (0.5 * (0.55f64.powi(2) - 0.45f64.powi(2)));
        assert!((band.effective_wavelength(|_| 1.0).0 - expected).abs() < 1e-10);
        assert!((band.width().0 - 0.1).abs() < 1e-12);
    }

    #[test]
    fn empty_windows_are_refused() {
        assert!(window("w", Counting::Energy, Window::TopHat { centre: nm(500.0), width: nm(0.0) }).is_err());
        assert!(window("w", Counting::Energy, Window::Gaussian { centre: nm(10.0), fwhm: nm(100.0) }).is_err());
        let zero = Window::Polynomial { coefficients: vec![0.0], low: nm(400.0), high: nm(600.0) };
        assert!(window("w", Counting::Energy, zero).unwrap_err().to_string().contains("empty"));
    }
}
