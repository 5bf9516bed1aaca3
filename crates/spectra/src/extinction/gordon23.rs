//! Extinction of Gordon et al. 2023 with R_V, from the far ultraviolet to 32 µm.
//!
//! k(λ) = [a(x) + b(x)(1/R_V − 1/3.1)] / 0.9854,  x = 1/λ
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | x | `x` | µm⁻¹ |
//! | R_V | `r_v` | 1 |
//!
//! λ < 0.33 µm: FM90 forms; 0.3 to 1.1 µm: polynomials and three Drude profiles; from 0.9 µm: a broken power law with
//! two silicate features; cubic smooth steps in the overlaps. Valid for 0.0912 ≤ λ ≤ 32 µm and 2.3 ≤ R_V ≤ 5.6. Source:
//! ApJ 950, 86, tables 2–5, 10.3847/1538-4357/accb59; the division by 0.9854 is the authors' renormalisation of the
//! ground-based photometry to Hubble's spectroscopy, stated with their published implementation.

use super::fitzpatrick_massa90::FitzpatrickMassa;
use super::{ExtinctionLaw, LawEntry, Maker};
use crate::fingerprint::Digest;

pub(super) const ENTRY: LawEntry = LawEntry {
    name: "gordon23",
    summary: "Gordon et al. 2023 with R_V 2.3 to 5.6; 0.0912 to 32 um",
    maker: Maker::RatioOfV { low: 2.3, high: 5.6, make: |r_v| Box::new(Gordon23 { r_v }) },
};

const ULTRAVIOLET_A: FitzpatrickMassa = FitzpatrickMassa { c: [0.81297, 0.2775, 1.06295, 0.11303], centre: 4.60, width: 0.99 };
const ULTRAVIOLET_B: FitzpatrickMassa = FitzpatrickMassa { c: [-2.97868, 1.89808, 3.10334, 0.65484], centre: 4.60, width: 0.99 };

/// A polynomial in x (lowest power first) and three Drude profiles (amplitude, centre, width) [µm⁻¹].
type OpticalTerms = ([f64; 5], [[f64; 3]; 3]);
const OPTICAL_A: OpticalTerms =
    ([-0.35848, 0.7122, 0.08746, -0.05403, 0.00674], [[0.03893, 2.288, 0.243], [0.02965, 2.054, 0.179], [0.01747, 1.587, 0.243]]);
const OPTICAL_B: OpticalTerms =
    ([0.12354, -2.68335, 2.01901, -0.39299, 0.03355], [[0.18453, 2.288, 0.243], [0.19728, 2.054, 0.179], [0.1713, 1.587, 0.243]]);

#[derive(Debug)]
struct Gordon23 {
    r_v: f64,
}

impl ExtinctionLaw for Gordon23 {
    fn content(&self, digest: &mut Digest) {
        digest.text("gordon23").number(self.r_v);
    }
    fn k(&self, lambda_um: f64) -> f64 {
        let x = 1.0 / lambda_um;
        let infrared = smooth_step(lambda_um, 0.9, 1.1);
        let blue = smooth_step(lambda_um, 0.30, 0.33);
        let blend = |uv: f64, optical: f64, ir: f64| (1.0 - blue) * uv + blue * ((1.0 - infrared) * optical + infrared * ir);
        let a = blend(ULTRAVIOLET_A.at(x), optical(&OPTICAL_A, x), infrared_a(lambda_um));
        let b = blend(ULTRAVIOLET_B.at(x), optical(&OPTICAL_B, x), -1.01251 * lambda_um.powf(-1.06099));
        (a + b * (1.0 / self.r_v - 1.0 / 3.1)) / 0.9854
    }
    fn range_um(&self) -> (f64, f64) {
        (0.0912, 32.0)
    }
    fn breakpoints_um(&self) -> Vec<f64> {
        let (start, end) = BREAK;
        vec![1.0 / 5.9, 0.30, 0.33, 0.9, 1.1, start, end]
    }
}

fn optical(parameters: &OpticalTerms, x: f64) -> f64 {
    let (coefficients, drudes) = parameters;
    let polynomial = coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let profile = |[amplitude, centre, width]: &[f64; 3]| {
        amplitude * (width / centre).powi(2) / ((x / centre - centre / x).powi(2) + (width / centre).powi(2))
    };
    polynomial + drudes.iter().map(profile).sum::<f64>()
}

/// The interval in which the two infrared power laws pass into each other: 4.30578 ± 4.78338/2 [µm].
const BREAK: (f64, f64) = (4.30578 - 4.78338 / 2.0, 4.30578 + 4.78338 / 2.0);

/// Two power laws and the silicate features at 10 and 20 µm (their eq. 9).
fn infrared_a(lambda_um: f64) -> f64 {
    let (scale, alpha, alpha2, at) = (0.38526, 1.68467, 0.78791, 4.30578f64);
    let near = scale * lambda_um.powf(-alpha);
    let far = scale * at.powf(alpha2 - alpha) * lambda_um.powf(-alpha2);
    let step = smooth_step(lambda_um, BREAK.0, BREAK.1);
    near * (1.0 - step)
        + far * step
        + modified_drude(lambda_um, 0.06652, 9.8434, 2.21205, -0.24703)
        + modified_drude(lambda_um, 0.0267, 19.58294, 17.0, -0.27)
}

fn modified_drude(x: f64, amplitude: f64, centre: f64, width: f64, asymmetry: f64) -> f64 {
    let gamma = 2.0 * width / (1.0 + (asymmetry * (x - centre)).exp());
    amplitude * (gamma / centre).powi(2) / ((x / centre - centre / x).powi(2) + (gamma / centre).powi(2))
}

fn smooth_step(x: f64, low: f64, high: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
