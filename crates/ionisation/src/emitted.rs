//! The gas's own light in a sphere, in all directions: the formal solution along rays, shell by shell.
//!
//! A ray passes the centre at a distance p. Along a part s of it in a shell of opacity κ that makes ε photons per volume
//! the intensity goes on as
//!
//!   I' = I e^(−κ s) + (ε/4π κ) (1 − e^(−κ s))
//!
//! and the flux of photons from all directions is the mean of 4π I over all parts of rays in the shell, each weighted by
//! its length and by 2π p dp (Mihalas 1978, Stellar Atmospheres, §7-6; Hummer & Rybicki 1971, MNRAS 152, 1).

use spectra::constants::SPHERE;

use crate::light::OWN_NODES;

/// Rays through the hole in the middle.
const INNER_RAYS: usize = 24;
/// Rays for each shell.
const RAYS: usize = 2;

/// Light of one node in a shell.
#[derive(Debug, Clone, Copy)]
pub struct ShellSource {
    /// Photons that it makes \[cm⁻³ s⁻¹\].
    pub made: f64,
    /// Extinction \[cm⁻¹\].
    pub opacity: f64,
}

/// The flux of the gas's own light over the distance from the middle.
#[derive(Debug, Clone, Default)]
pub struct EmittedLight {
    /// The middles of shells \[cm\].
    radii_cm: Vec<f64>,
    /// By shell and node \[s⁻¹ cm⁻²\].
    flux: Vec<[f64; OWN_NODES]>,
    /// Photons that leave the outermost shell by node \[s⁻¹\].
    pub left: [f64; OWN_NODES],
}

impl EmittedLight {
    /// That of shells, given where they begin and the last of them ends \[cm\], and what each has by node.
    pub fn new(edges_cm: &[f64], sources: &[[ShellSource; OWN_NODES]]) -> Self {
        let radii_cm: Vec<f64> = edges_cm.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        let mut light = Self { radii_cm, flux: vec![[0.0; OWN_NODES]; sources.len()], left: [0.0; OWN_NODES] };
        for node in 0..OWN_NODES {
            let shells: Vec<ShellSource> = sources.iter().map(|shell| shell[node]).collect();
            let (flux, left) = flux(edges_cm, &shells);
            light.flux.iter_mut().zip(flux).for_each(|(to, value)| to[node] = value);
            light.left[node] = left;
        }
        light
    }

    /// The flux of each node at a distance from the middle \[cm\]: linear between the middles of shells.
    pub fn at(&self, radius_cm: f64) -> [f64; OWN_NODES] {
        let place = self.radii_cm.partition_point(|radius| *radius < radius_cm);
        if place == 0 || place == self.radii_cm.len() {
            return self.flux[place.saturating_sub(1)];
        }
        let (low, high) = (self.radii_cm[place - 1], self.radii_cm[place]);
        let part = (radius_cm - low) / (high - low);
        std::array::from_fn(|node| self.flux[place - 1][node] * (1.0 - part) + self.flux[place][node] * part)
    }
}

/// The flux in each shell \[s⁻¹ cm⁻²\], and the photons that leave the outermost \[s⁻¹\].
fn flux(edges: &[f64], shells: &[ShellSource]) -> (Vec<f64>, f64) {
    let count = shells.len();
    let (mut sums, mut ways) = (vec![0.0; count], vec![0.0; count]);
    let mut left = 0.0;
    let mut lengths = vec![0.0; count];
    let inner = (0..INNER_RAYS).map(|i| (edges[0] * (i as f64 + 0.5) / INNER_RAYS as f64, edges[0] / INNER_RAYS as f64, 0));
    let others = (0..count).flat_map(|shell| {
        let step = (edges[shell + 1] - edges[shell]) / RAYS as f64;
        (0..RAYS).map(move |ray| (ray, shell, step))
    });
    let others = others.map(|(ray, shell, step)| (edges[shell] + (ray as f64 + 0.5) * step, step, shell));
    for (nearest, step, first) in inner.chain(others) {
        let weight = SPHERE / 2.0 * nearest * step;
        let along = |radius: f64| (radius * radius - nearest * nearest).max(0.0).sqrt();
        for shell in first..count {
            lengths[shell] = along(edges[shell + 1]) - along(edges[shell]);
        }
        let mut intensity = 0.0;
        for shell in (first..count).rev().chain(first..count) {
            let (ShellSource { made, opacity }, length) = (shells[shell], lengths[shell]);
            let depth = opacity * length;
            let (mean, rest) = means(depth);
            let source = made / SPHERE * length;
            sums[shell] += weight * length * (intensity * mean + source * rest);
            ways[shell] += weight * length;
            intensity = intensity * (-depth).exp() + source * mean;
        }
        left += weight * intensity;
    }
    let flux = sums.iter().zip(&ways).map(|(sum, way)| SPHERE * sum / way).collect();
    (flux, SPHERE * left)
}

/// The means along a way of a depth of what is left of light that came in, (1 − e^(−τ))/τ, and of what is there of light
/// that is made along it, (τ − 1 + e^(−τ))/τ², in parts of all that is made.
fn means(depth: f64) -> (f64, f64) {
    if depth < 1e-3 {
        return (1.0 - depth * (0.5 - depth / 6.0), 0.5 - depth * (1.0 / 6.0 - depth / 24.0));
    }
    let mean = -(-depth).exp_m1() / depth;
    (mean, (1.0 - mean) / depth)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of what a uniform sphere makes the part 3/4τ (1 − 1/2τ² + (1/τ + 1/2τ²) e^(−2τ)) leaves it: Osterbrock & Ferland
    /// 2006, appendix 2. What stays is what the gas absorbs.
    #[test]
    fn as_much_leaves_a_uniform_sphere_as_is_known() {
        for depth in [0.1f64, 1.0, 3.0, 10.0] {
            let shells = 200;
            let edges: Vec<f64> = (0..=shells).map(|i| f64::from(i) / f64::from(shells)).collect();
            let sources = vec![ShellSource { made: 1.0, opacity: depth }; shells as usize];
            let (flux, left) = flux(&edges, &sources);
            let all = SPHERE / 3.0;
            let known = 0.75 / depth * (1.0 - 0.5 / depth.powi(2) + (1.0 / depth + 0.5 / depth.powi(2)) * (-2.0 * depth).exp());
            assert!((left / all / known - 1.0).abs() < 5e-3, "{depth}: {} {known}", left / all);
            let taken: f64 = edges.windows(2).zip(&flux).map(|(edge, flux)| all * (edge[1].powi(3) - edge[0].powi(3)) * depth * flux).sum();
            assert!(((taken + left) / all - 1.0).abs() < 5e-3, "{depth}: {taken} {left} {all}");
        }
    }
}
