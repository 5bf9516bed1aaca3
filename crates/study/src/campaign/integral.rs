//! Integrals over a passband that share nothing with the rules: no pieces, no Gauss points, no measures and no variable
//! but λ.
//!
//! ∫ R(λ) S(λ) T(λ) dλ by the trapezoid rule with Richardson's correction (Simpson's rule) on a grid of equal steps of
//! ln λ between any two corners of the curve, S by Planck's law with its own constants, T by whatever attenuates. Known
//! to about 1e-9 of F(0): as halved steps show.

use spectra::extinction::ExtinctionLaw;
use spectra::passband::Passband;

/// Widest step in ln λ.
const STEP: f64 = 5e-4;

/// The constant h c / k_B [µm K], CODATA 2018 (exact).
const SECOND_RADIATION: f64 = 14_387.768_775;

/// The spectral shape of what shines.
#[derive(Debug, Clone, Copy)]
pub enum SourceShape {
    /// Planck's law, in parts of its value at a wavelength: temperature [K], wavelength [µm].
    BlackBody(f64, f64),
    /// (λ / reference)^exponent: exponent, reference [µm].
    PowerLaw(f64, f64),
}

impl SourceShape {
    fn at(self, lambda_um: f64) -> f64 {
        match self {
            SourceShape::BlackBody(temperature, at) => {
                let planck = |l: f64| l.powi(-5) / (SECOND_RADIATION / (l * temperature)).exp_m1();
                planck(lambda_um) / planck(at)
            }
            SourceShape::PowerLaw(exponent, at) => (lambda_um / at).powf(exponent),
        }
    }
}

/// The samples of ∫ R S … dλ: (R S dλ, k) at each.
pub struct IntegrandSamples(Vec<(f64, f64)>);

impl IntegrandSamples {
    /// The integral of a passband, a shape and a law.
    pub fn new(band: &Passband, shape: SourceShape, law: &dyn ExtinctionLaw) -> Self {
        let mut corners = band.pieces(&law.breakpoints_um());
        corners.dedup();
        let mut samples = Vec::new();
        for ends in corners.windows(2) {
            let (low, high) = (ends[0], ends[1]);
            let count = 2 * (((high / low).ln() / (2.0 * STEP)).ceil() as usize).max(2);
            let step = (high / low).ln() / count as f64;
            for i in 0..=count {
                let weight = match i {
                    0 => 1.0,
                    i if i == count => 1.0,
                    i if i % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                // A law may jump at a corner: its own side of it is asked.
                let inner = (i as f64).clamp(1e-7, count as f64 - 1e-7);
                let lambda = low * (inner * step).exp();
                let width = lambda * step * weight / 3.0;
                samples.push((width * band.response(lambda) * shape.at(lambda), law.k(lambda)));
            }
        }
        Self(samples)
    }

    /// ∫ R S e^(−a k) dλ: what is left of light behind a depth.
    pub fn behind(&self, depth: f64) -> f64 {
        self.0.iter().map(|(w, k)| w * (-depth * k).exp()).sum()
    }

    /// ∫ R S (1 − e^(−a k))/(a k) dλ: what is left of light that comes from everywhere within it.
    pub fn within(&self, depth: f64) -> f64 {
        let left = |x: f64| if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
        self.0.iter().map(|(w, k)| w * left(depth * k)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spectra::extinction::Extinction;

    /// A flat response, a power law and k = 0.55/λ have closed forms: ∫ λ⁻² e^(−a c/λ) dλ = [e^(−a c/λ)/(a c)].
    #[test]
    fn closed_forms_are_met() {
        let table = spectra::table::Table::new("flat", vec![0.3, 0.9], vec![1.0, 1.0]).unwrap();
        let band = Passband::new("flat", spectra::passband::Counting::Energy, table).unwrap();
        let law = Extinction::by_name("inverse_wavelength").unwrap();
        let samples = IntegrandSamples::new(&band, SourceShape::PowerLaw(-2.0, 1.0), &*law);
        let c = law.k(1.0);
        for a in [0.1, 3.0, 40.0] {
            let truth = ((-a * c / 0.9).exp() - (-a * c / 0.3).exp()) / (a * c);
            assert!((samples.behind(a) / truth - 1.0).abs() < 1e-10, "{a}: {}", samples.behind(a) / truth - 1.0);
        }
        assert!((samples.behind(0.0) / (1.0 / 0.3 - 1.0 / 0.9) - 1.0).abs() < 1e-10);
        assert!((samples.within(0.0) / samples.behind(0.0) - 1.0).abs() < 1e-14);
        // With k = c/λ the light within is the difference of two closed forms of the next power.
        let steeper = IntegrandSamples::new(&band, SourceShape::PowerLaw(-1.0, 1.0), &*law);
        let within = (steeper.behind(0.0) - steeper.behind(3.0)) / (3.0 * c);
        assert!((samples.within(3.0) / within - 1.0).abs() < 1e-10);
    }
}
