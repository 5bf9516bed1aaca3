//! Closure: moments of the radiance above the kept degrees, continued around the direction of the flux.
//!
//! A sum that ends at degree L swings about the truth, and may be less than zero where light is nearly a beam. Let f be the
//! direction of the flux, and A_l the Legendre moments of the radiance around it,
//!
//!   A_l = 4π / (2l + 1) Σ_m Y_lm(f) L_lm,   A_l = A_L r^(l − L) for l > L,  r = A_L / A_(L−1) between 0 and 1.
//!
//! Then S(n) has besides the kept degrees  Σ_(l>L) ω p_l A_l (2l + 1) / 4π P_l(f·n). This is exact for a beam, for a beam
//! in isotropic light, and for light that is distributed as Henyey & Greenstein's function (A_l = β^l).

use spectra::constants::SPHERE;

use super::harmonics::{ALL_DEGREES, COUNT, degree, harmonics_of};
use super::lanes::{EightLanes, WIDTH};
use super::term::Term;

/// The part of the phase functions of eight terms above the kept degrees.
pub struct Closure {
    /// The highest degree of the moments.
    highest: usize,
    /// ω p_l (2l + 1) / 4π of the degrees above it; none if there are none.
    scattering: Vec<EightLanes>,
}

/// Moments of less are none.
const NEGLIGIBLE: f64 = 1e-5;

impl Closure {
    /// The closure of `harmonics` kept ones.
    pub fn new(terms: &[Term], harmonics: usize) -> Self {
        let highest = degree(harmonics.saturating_sub(1));
        let last = (highest..=ALL_DEGREES).rev().find(|l| terms.iter().any(|term| term.legendre[*l].abs() > NEGLIGIBLE)).unwrap_or(0);
        let factor = |l: usize, term: &Term| (term.albedo * term.legendre[l] * (2 * l + 1) as f64 / SPHERE) as f32;
        let of_degree = |l: usize| std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| factor(l, term)));
        let above = if highest == 0 { Vec::new() } else { (highest + 1..=last).map(of_degree).collect() };
        Self { highest, scattering: above }
    }

    /// Σ_(l>L) of the source function towards `direction`, from the kept moments of a cell.
    pub fn above(&self, direction: [f32; 3], moments: &[EightLanes]) -> EightLanes {
        let mut light = [0.0; WIDTH];
        if self.scattering.is_empty() {
            return light;
        }
        // Y_1m are y, z and x.
        let flux: [EightLanes; 3] = [moments[3], moments[1], moments[2]];
        let length: EightLanes = std::array::from_fn(|t| flux.iter().map(|f| f[t] * f[t]).sum::<f32>().sqrt().max(f32::MIN_POSITIVE));
        let axis = flux.map(|f| std::array::from_fn(|t| f[t] / length[t]));
        let mu: EightLanes = std::array::from_fn(|t| (0..3).map(|a| axis[a][t] * direction[a]).sum());
        let mut around = [[0.0; WIDTH]; COUNT];
        let around = &mut around[..moments.len()];
        harmonics_of(axis, |x| x as f32, around);
        let axial = |l: usize| -> EightLanes {
            let factor = SPHERE as f32 / (2 * l + 1) as f32;
            let of_degree = l * l..(l + 1) * (l + 1);
            let pairs = || around[of_degree.clone()].iter().zip(&moments[of_degree.clone()]);
            std::array::from_fn(|t| factor * pairs().map(|(y, moment)| y[t] * moment[t]).sum::<f32>())
        };
        let (before, mut moment) = (axial(self.highest - 1), axial(self.highest));
        let ratio: EightLanes = std::array::from_fn(|t| if before[t] > 0.0 { (moment[t] / before[t]).clamp(0.0, 1.0) } else { 0.0 });
        let (mut below, mut legendre) = ([1.0; WIDTH], mu);
        let mut next = |l: usize| {
            let [a, b] = [(2 * l + 1) as f32 / (l + 1) as f32, l as f32 / (l + 1) as f32];
            for t in 0..WIDTH {
                (below[t], legendre[t]) = (legendre[t], a * mu[t] * legendre[t] - b * below[t]);
            }
            legendre
        };
        for l in 1..self.highest {
            next(l);
        }
        for (i, scattering) in self.scattering.iter().enumerate() {
            let legendre = next(self.highest + i);
            for t in 0..WIDTH {
                moment[t] *= ratio[t];
                light[t] += scattering[t] * moment[t] * legendre[t];
            }
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::harmonics::{count, harmonics};
    use super::super::term::scattering;
    use super::*;

    /// Bonnet's recurrence.
    fn legendre(l: usize, mu: f64) -> f64 {
        (0..l).fold((0.0, 1.0), |(before, value), l| (value, ((2 * l + 1) as f64 * mu * value - l as f64 * before) / (l + 1) as f64)).1
    }

    /// Beams, beams in isotropic light, and light as Henyey & Greenstein's function, scattered by that function with g = 0.7,
    /// are what their whole series say at all angles; without the closure, beams at degree 2 are less than zero at 90°.
    #[test]
    fn beams_scatter_by_the_whole_phase_function() {
        let g: f64 = 0.7;
        let term = Term { lambda_um: 0.5, k: 1.0, albedo: 0.8, legendre: std::array::from_fn(|l| g.powi(l as i32)) };
        let beam = DVec3::new(0.3, -0.5, 0.7).normalize();
        let aside = beam.cross(DVec3::X).normalize();
        for kept in [1, 2, 3, 5] {
            let closure = Closure::new(&[term], count(kept));
            // Name, β, and the isotropic light beside it.
            let lights = [("beam", 1.0, 0.0), ("distributed", 0.6, 0.0), ("beam in isotropic light", 1.0, 2.0)];
            for (name, beta, isotropic) in lights.into_iter().take(if kept > 1 { 3 } else { 2 }) {
                let axial = |l: usize| f64::powi(beta, l as i32);
                let moments: Vec<EightLanes> = (0..count(kept))
                    .map(|h| {
                        let alone = if h == 0 { isotropic / SPHERE.sqrt() } else { 0.0 };
                        [(harmonics(beam)[h] * axial(degree(h)) + alone) as f32; WIDTH]
                    })
                    .collect();
                for degrees in [0.0f64, 40.0, 90.0, 150.0, 180.0] {
                    let mu = degrees.to_radians().cos();
                    let n = mu * beam + (1.0 - mu * mu).sqrt() * aside;
                    let series = |l: usize| (2 * l + 1) as f64 / SPHERE * g.powi(l as i32) * axial(l) * legendre(l, mu);
                    let exact = 0.8 * ((0..200).map(series).sum::<f64>() + isotropic / SPHERE);
                    let kept_part: f64 =
                        (0..count(kept)).map(|h| harmonics(n)[h] * f64::from(scattering(&[term])[h][0] * moments[h][0])).sum();
                    let whole = kept_part + f64::from(closure.above(n.as_vec3().to_array(), &moments)[0]);
                    assert!((whole - exact).abs() < 0.02 * exact, "{name}, {kept}, {degrees}: {whole} for {exact}");
                    if name == "beam" && kept == 2 && degrees == 90.0 {
                        assert!(kept_part < 0.0, "{kept_part}");
                    }
                }
            }
        }
    }
}
