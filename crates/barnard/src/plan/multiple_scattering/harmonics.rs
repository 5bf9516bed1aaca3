//! Real spherical harmonics, and phase functions in them.
//!
//!   p(a·b) = Σ_l p_l Σ_m Y_lm(a) Y_lm(b),  p_l = 2π ∫ p(μ) P_l(μ) dμ
//!
//! The addition theorem; p_0 = 1, p_1 = g, and p_l = g^l for Henyey & Greenstein. Y_lm by the recurrences of associated
//! Legendre functions and of sin mφ, cos mφ in Cartesian form (Sloan 2013, JCGT 2 (2), 84), l by l, m from −l to l.

use std::ops::{Add, Mul, Sub};
use std::sync::LazyLock;

use glam::DVec3;
use spectra::quadrature::integrate_each;

use crate::phase::Phase;

/// The highest degree that is kept of any field.
pub const DEGREE: usize = 5;
/// The highest degree that is known of phase functions.
pub const ALL_DEGREES: usize = 32;
/// The number of harmonics up to the highest kept degree.
pub const COUNT: usize = count(DEGREE);

/// Harmonics up to a degree.
pub const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 1)
}

/// The factors of the recurrences for normalised functions: from l to l + 1 at the same m, and from m to m + 1 along
/// the diagonal.
struct Recurrence {
    rise: [[f64; DEGREE + 1]; DEGREE + 1],
    fall: [[f64; DEGREE + 1]; DEGREE + 1],
    diagonal: [f64; DEGREE + 1],
}

static RECURRENCE: LazyLock<Recurrence> = LazyLock::new(|| {
    let rise = |l: usize, m: usize| {
        let (n, m2) = ((l + 1) as f64, (m * m) as f64);
        ((4.0 * n * n - 1.0) / (n * n - m2)).sqrt()
    };
    let fall = |l: usize, m: usize| {
        let (l, m2) = (l as f64, (m * m) as f64);
        ((l * l - m2) / (4.0 * l * l - 1.0)).max(0.0).sqrt()
    };
    let mut diagonal = [(1.0 / spectra::constants::SPHERE).sqrt(); DEGREE + 1];
    for m in 0..DEGREE {
        diagonal[m + 1] = diagonal[m] * ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
    }
    let table = |f: &dyn Fn(usize, usize) -> f64| std::array::from_fn(|m| std::array::from_fn(|l| if l < m { 0.0 } else { f(l, m) }));
    Recurrence { rise: table(&rise), fall: table(&fall), diagonal }
});

/// Y_lm of a direction, l by l [sr^-½].
pub fn harmonics(d: DVec3) -> [f64; COUNT] {
    let mut values = [[0.0]; COUNT];
    harmonics_of([[d.x], [d.y], [d.z]], |x| x, &mut values);
    values.map(|[value]| value)
}

/// Y_lm of several directions, l by l, as many harmonics as there is room for: harmonic × direction [sr^-½].
#[inline(always)]
pub fn harmonics_of<F, const N: usize>([x, y, z]: [[F; N]; 3], number: impl Fn(f64) -> F, values: &mut [[F; N]])
where
    F: Copy + Add<Output = F> + Sub<Output = F> + Mul<Output = F>,
{
    let Some(most) = values.len().checked_sub(1).map(degree) else { return };
    let recurrence = &*RECURRENCE;
    // sin^m θ times cos mφ and sin mφ, and P_mm without sin^m θ, with its norm.
    let (mut cosine, mut sine) = ([number(1.0); N], [number(0.0); N]);
    for m in 0..=most {
        let (mut before, mut legendre) = ([number(0.0); N], [number(recurrence.diagonal[m]); N]);
        let around = number(if m == 0 { 1.0 } else { std::f64::consts::SQRT_2 });
        for l in m..=most {
            let (rise, fall) = (number(recurrence.rise[m][l]), number(recurrence.fall[m][l]));
            for i in 0..N {
                values[l * (l + 1) + m][i] = around * legendre[i] * cosine[i];
            }
            if m > 0 {
                for i in 0..N {
                    values[l * (l + 1) - m][i] = around * legendre[i] * sine[i];
                }
            }
            for i in 0..N {
                (before[i], legendre[i]) = (legendre[i], rise * (z[i] * legendre[i] - fall * before[i]));
            }
        }
        for i in 0..N {
            (cosine[i], sine[i]) = (x[i] * cosine[i] - y[i] * sine[i], x[i] * sine[i] + y[i] * cosine[i]);
        }
    }
}

/// The degree l of each harmonic.
pub fn degree(harmonic: usize) -> usize {
    harmonic.isqrt()
}

/// The Legendre polynomials P_l(μ) of all degrees.
fn legendre(mu: f64) -> [f64; ALL_DEGREES + 1] {
    let mut values = [1.0; ALL_DEGREES + 1];
    let (mut before, mut value) = (0.0, 1.0);
    for (l, v) in values.iter_mut().enumerate() {
        *v = value;
        let l = l as f64;
        (before, value) = (value, ((2.0 * l + 1.0) * mu * value - l * before) / (l + 1.0));
    }
    values
}

/// The Legendre moments p_l of a phase function at a wavelength [1].
pub fn legendre_moments(phase: &dyn Phase, lambda_um: f64) -> [f64; ALL_DEGREES + 1] {
    let mut moments = [0.0; ALL_DEGREES + 1];
    if !phase.is_isotropic() {
        let products = |mu: f64| {
            let density = std::f64::consts::TAU * phase.at(mu, lambda_um);
            legendre(mu).map(|value| density * value)
        };
        moments = integrate_each(products, -1.0, 1.0, 1e-9);
    }
    moments[0] = 1.0;
    moments
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Henyey & Greenstein's function of g = 0.6, written out again.
    #[derive(Debug)]
    struct Forward;

    impl Phase for Forward {
        fn at(&self, cosine: f64, _: f64) -> f64 {
            0.64 / (1.36 - 1.2 * cosine).powf(1.5) / spectra::constants::SPHERE
        }
        fn sample(&self, _: f64, _: &mut crate::random::Counter) -> f64 {
            0.0
        }
        fn is_spectral(&self) -> bool {
            false
        }
    }

    /// Σ_lm p_l Y_lm(a) Y_lm(b) is the Legendre series of Henyey & Greenstein's function, and harmonics are
    /// orthonormal.
    #[test]
    fn the_addition_theorem_holds() {
        let g: f64 = 0.6;
        let moments = legendre_moments(&Forward, 0.5);
        for (l, p) in moments.iter().enumerate() {
            assert!((p - g.powi(l as i32)).abs() < 1e-7, "{l}: {p}");
        }
        let (a, b) = (DVec3::new(0.3, -0.5, 0.7).normalize(), DVec3::new(-0.8, 0.1, 0.4).normalize());
        let (ya, yb, mu) = (harmonics(a), harmonics(b), a.dot(b));
        for l in 0..=DEGREE {
            let legendre = (0..COUNT).filter(|h| degree(*h) == l).map(|h| ya[h] * yb[h]).sum::<f64>();
            // Bonnet's polynomials, written out.
            let polynomials = [1.0, mu, 0.5 * (3.0 * mu * mu - 1.0), 0.5 * mu * (5.0 * mu * mu - 3.0)];
            let Some(polynomial) = polynomials.get(l) else { break };
            let expected = (2 * l + 1) as f64 / spectra::constants::SPHERE * polynomial;
            assert!((legendre - expected).abs() < 1e-12, "{l}: {legendre} {expected}");
        }
    }
}
