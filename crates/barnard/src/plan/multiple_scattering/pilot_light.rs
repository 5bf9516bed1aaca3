//! Light of a field in the picture, along the pilots' rays.

use glam::DVec3;
use rayon::prelude::*;

use super::eye_source::EyeSource;
use super::lanes::WIDTH;
use super::problem::{Problem, nodes};
use super::reduction::Reduction;
use crate::field::Field;
use crate::geometry::Ray;
use crate::image::worst;

/// The light of the pilots without that of the field.
#[derive(Debug, Clone, Default)]
pub(in crate::plan) struct PilotLight {
    /// Each ray, and how many pixels it stands for.
    pub rays: Vec<(Ray, f64)>,
    /// Radiance: pilot × band.
    pub radiance: Vec<Vec<f64>>,
}

/// Most samples of a ray.
const MOST: f64 = 1024.0;

impl PilotLight {
    /// Relative rms of the difference that another source makes in the picture, of the worst band.
    pub fn difference(&self, problem: &Problem, reduction: &Reduction, source: &EyeSource, other: &EyeSource) -> f64 {
        let pair = |(ray, _): &(Ray, f64)| [source, other].map(|source| seen(problem, reduction, source, ray));
        let pairs: Vec<[Vec<f64>; 2]> = self.rays.par_iter().map(pair).collect();
        let bands = problem.draft.spectral.bands.len();
        let unit = f64::from(problem.unit);
        let error = |band: usize| {
            let (mut wrong, mut all) = (0.0, 0.0);
            for (([a, b], (_, pixels)), radiance) in pairs.iter().zip(&self.rays).zip(&self.radiance) {
                let (a, b) = (unit * a[band], unit * b[band]);
                wrong += pixels * (a - b).powi(2);
                all += pixels * (radiance[band] + a).powi(2);
            }
            if all > 0.0 { (wrong / all).sqrt() } else { 0.0 }
        };
        worst((0..bands).map(error))
    }
}

/// Radiance of a field along a ray, ∫ k σ S e^(−kτ) ds by midpoints of voxels, band by band, in units of the field.
fn seen(problem: &Problem, reduction: &Reduction, source: &EyeSource, ray: &Ray) -> Vec<f64> {
    let bands = &problem.draft.spectral.bands;
    let mut sums = vec![0.0; bands.len()];
    let dust = problem.dust;
    let Some((from, to)) = dust.lattice().bounds.clip(ray).map(|(from, to)| (from.max(0.0), to)).filter(|(from, to)| from < to) else {
        return sums;
    };
    let count = ((to - from) / dust.lattice().voxel_pc().min_element()).ceil().clamp(1.0, MOST);
    let step = (to - from) / count;
    let (mut tau, mut solved) = (0.0, vec![0.0f32; reduction.solved.len()]);
    for i in 0..count as usize {
        let place: DVec3 = ray.at(from + (i as f64 + 0.5) * step);
        let depth = dust.at(place) * step;
        if depth <= 0.0 {
            continue;
        }
        for (group, values) in solved.chunks_mut(WIDTH).enumerate() {
            values.copy_from_slice(&source.at(group, place)[..values.len()]);
        }
        let mut term = 0;
        for (sum, band) in sums.iter_mut().zip(bands) {
            for node in nodes(band).unwrap_or_default() {
                let light: f32 = reduction.coefficients[term].iter().zip(&solved).map(|(share, value)| share * value).sum();
                // The mean over the step of what is behind the dust before it.
                let through = (-node.k * tau).exp() * -(-node.k * depth).exp_m1();
                *sum += f64::from(light.max(0.0)) * through;
                term += 1;
            }
        }
        tau += depth;
    }
    sums
}
