//! How large the kernels around the gathered stars are: what cells do not see of a star falls as L/R² in the picture,
//! marching what is in the kernel costs as R³ for each. With as much work as is allowed along an average ray the error
//! is least for R ∝ L^(2/7).

use super::cells::SweepCells;
use super::problem::Problem;
use crate::light::Route;
use crate::plan::ManyLights;
use crate::plan::many_lights::near_field_kernel::NearFieldKernel;

/// Smallest and largest R, in cells.
const REACH: (f64, f64) = (0.75, 4.0);
/// Gathered stars that a sample in the dust is in the kernels of, on average.
const FILLED: f64 = 0.15;
/// Cells that the forward peak of a phase function must be wide for cells to see it.
const PEAK: f64 = 2.5;
const EXPONENT: f64 = 2.0 / 7.0;
/// Halvings of what is between the smallest and the largest.
const HALVINGS: usize = 40;

/// Kernel sizes: R in cells, one number per star relative to a common scale.
struct Sizes {
    parts: Vec<f64>,
    /// Edge of a cell \[pc\].
    edge_pc: f64,
    /// Shortest forward reach of a kernel, for the forward peak of a phase function \[pc\].
    peak_pc: f64,
    /// Volume that is allowed to all kernels together \[pc³\].
    allowed: f64,
}

impl Sizes {
    fn kernel(&self, reach: f64) -> NearFieldKernel {
        NearFieldKernel { reach_pc: reach * self.edge_pc, ahead_pc: (reach * self.edge_pc).max(self.peak_pc) }
    }

    fn kernels(&self, scale: f64) -> impl Iterator<Item = NearFieldKernel> + '_ {
        self.parts.iter().map(move |size| self.kernel((scale * size).clamp(REACH.0, REACH.1)))
    }

    fn fit(&self, scale: f64) -> bool {
        self.kernels(scale).map(|kernel| kernel.volume()).sum::<f64>() <= self.allowed
    }

    /// The largest scale whose kernels fit, by halving.
    fn largest_scale(&self) -> f64 {
        // Whatever a star is in parts of the mean, none needs less than the one nor more than the other.
        let (mut low, mut high) = (1e-3 * REACH.0, 1e3 * REACH.1);
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            *if self.fit(middle) { &mut low } else { &mut high } = middle;
        }
        low
    }
}

impl Problem<'_> {
    /// The kernel around each gathered star, for these cells.
    pub fn kernels(&self, cells: &SweepCells) -> Vec<NearFieldKernel> {
        let Some(many_lights) = &self.draft.space.many_lights else { return Vec::new() };
        let edge_pc = cells.lattice.voxel_pc().max_element();
        let filled = cells.sigma.iter().filter(|sigma| **sigma > cells.least).count() as f64 * cells.lattice.voxel_pc().element_product();
        let parts = self.brightness(many_lights).into_iter().map(|part| part.powf(EXPONENT)).collect();
        let peak_pc = PEAK * edge_pc / self.draft.spectral.forward_peak();
        let mut sizes = Sizes { parts, edge_pc, peak_pc, allowed: FILLED * filled };
        // Where there are too many stars even for the smallest kernels, peaks are left to the cells.
        if many_lights.stars.len() as f64 * sizes.kernel(REACH.0).volume() > sizes.allowed {
            sizes.peak_pc = 0.0;
        }
        sizes.kernels(sizes.largest_scale()).collect()
    }

    /// The largest part of each gathered star through any band, in parts of the mean.
    fn brightness(&self, many_lights: &ManyLights) -> Vec<f64> {
        let mut parts = vec![0.0f64; many_lights.stars.len()];
        let mut light_of = vec![None; self.draft.space.stars.len()];
        for (light, l) in self.draft.lights.iter().enumerate() {
            if let Route::Scattered { star } = l.route {
                light_of[star] = Some(light);
            }
        }
        for band in &self.draft.spectral.bands {
            let weight = |star: &usize| light_of[*star].map_or(0.0, |light| band.rule.form.decay().weights(light).iter().sum::<f64>());
            let powers: Vec<f64> = many_lights.stars.iter().map(weight).collect();
            let mean = powers.iter().sum::<f64>() / powers.len().max(1) as f64;
            parts.iter_mut().zip(powers).filter(|_| mean > 0.0).for_each(|(part, power)| *part = part.max(power / mean));
        }
        parts
    }
}
