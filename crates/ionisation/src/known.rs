//! State of a cloud's gas under the light of several stars, per voxel.
//!
//! Each voxel is solved once, as a slab that has all light that comes to it from one side: one step where it is thin, as many
//! as a beam would make where a front runs through it. Beams go through it with the opacity that it has, (G7) of docs/gas.md.

use rayon::prelude::*;

use crate::atoms::STAGES;
use crate::balance::{Gas, GasState};
use crate::beam::{Beam, BeamStep, mean_square, shell};
use crate::cloud::{Cloud, PARSEC_CM, Quantity, Settings};
use crate::lanes::LANES;
use crate::light::{ABSORBERS, ByNode, DETOUR, IonisingLight, NODES, OWN_NODES, ion};
use crate::lit::BEHIND;
use crate::nodes::Nodes;
use crate::packet::Packet;
use crate::voxel::{ALL, Voxel, absorbing};

/// The variance of ways that photons have for that of all rays: those on short ways come in farther behind, where there are
/// fewer. Found on spheres of 8 and 16 voxels in radius, where photons are as many as recombinations to a hundredth.
const OF_PHOTONS: f64 = 0.8;
/// Voxels that are solved one after the other by one thread.
const CHUNK: usize = 512;

/// State of a cloud's voxels and the requested quantities of their gas.
pub struct Known {
    /// Result of the beams.
    pub voxels: Vec<Voxel>,
    /// Ions of hydrogen \[cm⁻³\].
    pub ions: Vec<f32>,
    /// By quantity.
    pub quantities: Vec<Vec<f32>>,
    /// Steps that were made, and of those in how many the gas did not settle.
    pub steps: [u64; 2],
}

impl Known {
    /// Solves all voxels, given by voxel the flux of all stars by node \[s⁻¹ cm⁻²\] and what stands behind it ([`BEHIND`]).
    ///
    /// Where `goes_on` says that it is not to, not all of them are solved.
    pub fn new(
        (cloud, settings): (&Cloud, &Settings),
        kind: &IonisingLight,
        flux: &[f32],
        quantities: &[Quantity],
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let (cells, nodes) = (cloud.hydrogen.len(), kind.energies_ev.len());
        let mut voxels = vec![Voxel::dark(Nodes::each(|_| 0.0)); cells];
        let slabs = VoxelSolver { cloud, kind, settings, quantities };
        let found: Vec<(Vec<f32>, [u64; 2])> = voxels
            .par_chunks_mut(CHUNK)
            .zip(flux.par_chunks(CHUNK * (nodes + BEHIND)))
            .enumerate()
            .filter(|_| goes_on())
            .map(|(number, (voxels, flux))| slabs.solve(number * CHUNK, voxels, flux))
            .collect();
        let quantity_values = |quantity: usize| -> Vec<f32> {
            let chunk = |(found, _): &(Vec<f32>, [u64; 2])| {
                let voxels = found.len() / (quantities.len() + 1);
                found[quantity * voxels..][..voxels].to_vec()
            };
            found.iter().flat_map(chunk).collect()
        };
        let steps = found.iter().fold([0; 2], |sum, (_, steps)| [sum[0] + steps[0], sum[1] + steps[1]]);
        Self { voxels, ions: quantity_values(0), quantities: (1..=quantities.len()).map(quantity_values).collect(), steps }
    }
}

/// The opacity of neutral gas by node, for one nucleus of hydrogen \[cm²\].
pub fn dark(cloud: &Cloud, settings: &Settings, kind: &IonisingLight) -> ByNode {
    let gas = Gas { hydrogen: 1.0, ..cloud.gas(0, settings) };
    opacity(kind, &gas, &GasState::neutral(&gas))
}

/// The opacity of gas by node \[cm⁻¹\].
pub(crate) fn opacity(light: &IonisingLight, gas: &Gas, state: &GasState) -> [f64; NODES] {
    let part = |ion: usize| {
        let (element, charge) = (ion / STAGES, ion % STAGES);
        gas.hydrogen * gas.abundances[element] * state.fractions[element][charge]
    };
    let absorbers = ABSORBERS.map(|(element, charge)| part(ion(element, charge)));
    std::array::from_fn(|node| {
        let metals = light.metals.get(node).map_or(0.0, |ions| ions.iter().map(|(ion, sigma)| part(*ion) * sigma).sum());
        // Weights of metals may be negative.
        (gas.hydrogen * gas.dust_cm2 + metals + light.opacity(absorbers, node)).max(0.0)
    })
}

/// The depth whose e^(−τ), in the mean over ways through a voxel of a relative variance v, is that of the slab: of a gamma
/// distribution of ways (1 + v τ)^(−1/v) is the mean.
fn on_ways(depth: f64, variance: f64) -> f64 {
    /// As good as all is absorbed.
    const DEEP: f64 = 60.0;
    let product = variance * depth;
    if product > 1e-3 { product.min(DEEP).exp_m1() / variance } else { depth * (1.0 + 0.5 * product) }
}

/// How voxels are solved.
struct VoxelSolver<'a> {
    cloud: &'a Cloud<'a>,
    kind: &'a IonisingLight,
    settings: &'a Settings,
    quantities: &'a [Quantity<'a>],
}

/// A voxel that is being solved.
struct SolvedVoxel<'a> {
    voxel: usize,
    gas: Gas,
    beam: Beam<'a>,
    /// Start and end \[cm\].
    begin_cm: f64,
    end_cm: f64,
    rate: f64,
    /// The relative variance of the ways that photons have through it.
    variance: f64,
    depths: ByNode,
    emitted: [f64; OWN_NODES],
    /// Sums of parts of the way: of ions of hydrogen, and by quantity.
    values: Vec<f64>,
}

impl SolvedVoxel<'_> {
    /// Takes gas along a part of the way.
    fn take(&mut self, part: f64, state: &GasState, quantities: &[Quantity]) {
        self.values[0] += part * state.fractions[0][1];
        for (sum, quantity) in self.values[1..].iter_mut().zip(quantities) {
            *sum += part * quantity.part(&self.gas, state);
        }
    }

    /// A part of its way in parts of its volume.
    fn part(&self, inner: f64, thickness: f64) -> f64 {
        shell(1.0, inner, thickness) / shell(1.0, self.begin_cm, self.end_cm - self.begin_cm)
    }

    fn step(&mut self, step: &BeamStep, quantities: &[Quantity]) {
        let part = self.part(step.inner_cm, step.thickness_cm);
        self.take(part, &step.state, quantities);
        for (node, (sum, depth)) in self.depths.iter_mut().zip(step.depths).enumerate() {
            // That of the gas's own light has its detours in it: κ (1 + a κ r).
            let detour = 2.0 * DETOUR * (step.inner_cm / step.thickness_cm + 0.5);
            *sum += if node < OWN_NODES && depth > 0.0 { 2.0 * depth / (1.0 + (1.0 + 2.0 * detour * depth).sqrt()) } else { depth };
        }
        self.emitted.iter_mut().zip(step.emitted).for_each(|(sum, rate)| *sum += part * rate);
    }
}

impl<'a> VoxelSolver<'a> {
    /// The slab of a voxel, where there is gas and light.
    fn slab(&'a self, voxel: usize, flux: &[f32]) -> Option<SolvedVoxel<'a>> {
        let (gas, nodes) = (self.cloud.gas(voxel, self.settings), self.kind.energies_ev.len());
        let flux_of = |node: usize| f64::from(flux[node]);
        let rate: f64 = (0..nodes).map(|node| flux_of(node) * self.kind.weakening[0][node]).sum();
        if gas.hydrogen <= 0.0 || rate <= 0.0 {
            return None;
        }
        let all = (0..nodes).map(flux_of).sum::<f64>();
        let [distance, area, variance] = std::array::from_fn(|place| flux_of(nodes + place) / all);
        if area <= 0.0 {
            return None;
        }
        // As many photons come to the slab as to the voxel, and it has its volume.
        let thickness = (self.cloud.voxel * PARSEC_CM).element_product().cbrt() / area;
        let inner = (distance * PARSEC_CM - 0.5 * thickness).max(thickness);
        let solid_angle = 1.0 / mean_square(inner, thickness);
        let photons = std::array::from_fn(|node| if node < nodes { flux_of(node) } else { 0.0 });
        let beam = Beam::bringing(photons, self.kind, &self.settings.accuracy, (solid_angle, inner));
        let (depths, rates, values) = ([0.0; NODES], [0.0; OWN_NODES], vec![0.0; self.quantities.len() + 1]);
        Some(SolvedVoxel { voxel, gas, beam, begin_cm: inner, end_cm: inner + thickness, rate, variance, depths, emitted: rates, values })
    }

    /// Solves voxels from `first` on; gives the ions of hydrogen and what is asked for one behind the other, and the steps.
    fn solve(&'a self, first: usize, voxels: &mut [Voxel], flux: &[f32]) -> (Vec<f32>, [u64; 2]) {
        let count = voxels.len();
        let (mut found, mut steps) = (vec![0.0; count * (self.quantities.len() + 1)], [0; 2]);
        let mut packet = Packet::new(self.kind, self.settings.diffuse, &self.settings.accuracy, self.cloud.gas(first, self.settings));
        let mut waiting = flux.chunks_exact(flux.len() / count).enumerate().filter_map(|(voxel, flux)| self.slab(first + voxel, flux));
        let mut slabs: [Option<SolvedVoxel>; LANES] = [const { None }; LANES];
        // The next voxel of a lane is most often not far from the last.
        let mut last: [Option<Beam>; LANES] = [const { None }; LANES];
        loop {
            for (lane, place) in slabs.iter_mut().enumerate() {
                if let Some(slab) = place
                    && packet.has_settled(lane)
                    && let Some(step) = slab.beam.end((&mut packet, lane))
                {
                    slab.step(&step, self.quantities);
                    steps[0] += 1;
                    steps[1] += u64::from(step.moved > self.settings.accuracy.settled);
                    let left_cm = slab.end_cm - slab.beam.radius_cm;
                    if left_cm > 1e-12 * slab.end_cm && !slab.beam.is_used_up() {
                        slab.beam.begin((&mut packet, lane), &slab.gas, left_cm);
                    } else if let Some(mut slab) = place.take() {
                        let voxel = slab.voxel - first;
                        voxels[voxel] = self.end(&mut slab, |number, value| found[number * count + voxel] = value as f32);
                        last[lane] = Some(slab.beam);
                    }
                }
                if place.is_none()
                    && let Some(mut slab) = waiting.next()
                {
                    match &last[lane] {
                        Some(near) => slab.beam.near_to(near),
                        None => packet.forget(lane),
                    }
                    slab.beam.begin((&mut packet, lane), &slab.gas, slab.end_cm - slab.beam.radius_cm);
                    *place = Some(slab);
                }
            }
            if slabs.iter().all(Option::is_none) {
                return (found, steps);
            }
            packet.pass();
        }
    }

    /// State of a solved voxel; `tell` receives its hydrogen ions and the requested quantities.
    fn end(&self, slab: &mut SolvedVoxel, mut tell: impl FnMut(usize, f64)) -> Voxel {
        let whole_cm = slab.end_cm - slab.begin_cm;
        let rest_cm = (slab.end_cm - slab.beam.radius_cm).max(0.0);
        if rest_cm > 1e-12 * slab.end_cm {
            let neutral = GasState::neutral(&slab.gas);
            slab.take(slab.part(slab.beam.radius_cm, rest_cm), &neutral, self.quantities);
            let dark = opacity(self.kind, &slab.gas, &neutral);
            slab.depths.iter_mut().zip(dark).for_each(|(sum, opacity)| *sum += opacity * rest_cm);
        }
        tell(0, slab.gas.hydrogen * slab.values[0]);
        for (number, quantity) in self.quantities.iter().enumerate() {
            tell(number + 1, quantity.most * slab.values[number + 1]);
        }
        let opacity = |depth: f64| (on_ways(depth, OF_PHOTONS * slab.variance) / whole_cm).max(0.0) as f32;
        let absorbed = ((1.0 - slab.beam.left()) as f32).clamp(1e-9, ALL);
        Voxel {
            opacity: std::array::from_fn(|place| slab.depths.get(place).map_or(0.0, |depth| opacity(*depth))),
            dust: (slab.gas.hydrogen * slab.gas.dust_cm2) as f32,
            emitted: slab.emitted.map(|rate| rate as f32),
            rate: slab.rate as f32,
            absorbed,
            depth: absorbing(absorbed),
            ionised: slab.values[0] as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the mean over ways that are of that distribution, as much light is left as behind the slab.
    #[test]
    fn as_much_is_left_on_all_ways() {
        let left = |depth: f64, variance: f64, opacity: f64| {
            // A gamma distribution of mean one: of shape 1/v.
            let shape = 1.0 / variance;
            let weight = |way: f64| way.powf(shape - 1.0) * (-way * shape).exp();
            let ways: Vec<f64> = (0..40_000).map(|i| (f64::from(i) + 0.5) * 1e-3).collect();
            let sum = |value: &dyn Fn(f64) -> f64| ways.iter().map(|way| weight(*way) * value(*way)).sum::<f64>();
            sum(&|way| (-opacity * way).exp()) / sum(&|_| 1.0) / (-depth).exp()
        };
        for variance in [0.1, 1.0 / 3.0, 0.5] {
            for depth in [1e-3, 0.1, 1.0, 4.0] {
                let rest = left(depth, variance, on_ways(depth, variance));
                assert!((rest - 1.0).abs() < 2e-3, "{depth} {variance}: {rest}");
            }
            assert!(left(4.0, variance, 4.0) > 1.1);
        }
    }
}
