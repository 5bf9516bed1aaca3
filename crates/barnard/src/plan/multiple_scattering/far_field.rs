//! The gathered stars' light in cells, beyond the neighbourhood of each star: as one camera sees it scattered, and as
//! moments of the radiance, from which it scatters again.
//!
//!   S_t(x, n) = ω_t Σ_s w_st p_t(θ_s) e^(−k_t τ_s) (1 − w(r_s))/r_s²
//!
//! Light from afar is smooth and is gathered in cells of twice the edge; of stars that are nearer than [`MIDDLE`] of
//! those, only what that leaves out is gathered in the cells themselves. So a star costs as many cells as the coarse
//! lattice has, and a few thousand more. The phase function is asked for every star and cell: nothing of it is lost but
//! what changes within a cell.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | (1 − w)/r² | `KernelShape::beyond` | pc⁻² |
//! | w_st: weights without k ω | `sent` | W m⁻² sr⁻¹ pc² |

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use spectra::simd;

use super::cells::{DirectSource, SweepCells};
use super::harmonics::{COUNT, harmonics_of};
use super::lanes::{EightLanes, WIDTH};
use super::moments::Moments;
use super::view::Viewpoint;
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::field::Lattice;
use crate::geometry::{Bounds, Ray};
use crate::packet::{LANES, Lane, exp, fma, lanes};
use crate::plan::many_lights::near_field_kernel::{KernelShape, NearFieldKernel};
use crate::plan::{ManyLights, PhaseEntry, PhaseTable};

/// Radius within which a star's light is gathered in the finer cells, in coarse ones.
const MIDDLE: f64 = 4.0;

/// The gathered stars, as eight terms see them.
#[derive(Clone, Copy)]
pub struct FarField<'a> {
    pub many_lights: &'a ManyLights,
    /// The weights without k ω that each star sends.
    pub sent: &'a [EightLanes],
    /// The extinctions of the terms relative to V.
    pub k: &'a EightLanes,
    /// The kernel around each star.
    pub kernels: &'a [NearFieldKernel],
}

/// The way in which eight terms scatter light towards an eye.
#[derive(Clone, Copy)]
pub struct Scattering<'a> {
    pub view: Viewpoint,
    /// Phase functions; even scattering where there are none.
    pub phase: Option<&'a PhaseTable>,
    /// Number of the first of the terms among all.
    pub first: usize,
    /// The number of all terms.
    pub terms: usize,
    /// The albedo of each of the eight terms.
    pub albedo: EightLanes,
}

/// Cells that take a star's light between two kernels.
struct CellLevel {
    lattice: Lattice,
    /// The number of harmonics of a cell.
    count: usize,
    /// The eye, where light is seen by one.
    view: Option<Viewpoint>,
    /// The kernel within which nothing counts, for all stars; each star's own where there is none.
    inner: Option<NearFieldKernel>,
    outer: Option<NearFieldKernel>,
}

/// A star beside a row of cells.
struct Beside<'a> {
    /// The vector from the star to the first cell of the row [pc].
    offset: [f32; 3],
    /// The distance from cell to cell [pc].
    edge: f32,
    /// Depths along the row, and where the first cell and the others stand in them.
    depths: &'a [f32],
    first: f32,
    step: f32,
    sent: &'a EightLanes,
    k: &'a EightLanes,
    /// The kernels between which its light counts.
    inner: KernelShape,
    outer: Option<KernelShape>,
    /// The directions from the cells to the eye; zero where kernels are even.
    eye: [Lane; 3],
}

impl FarField<'_> {
    /// Source functions of each cell beyond all kernels.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn seen(&self, cells: &SweepCells, scattering: &Scattering, control: &Control) -> Result<Moments> {
        self.levels(cells, 1, Some(scattering.view), control, |star, first, out| add_seen(star, scattering, first, out))
    }

    /// Moments of the radiance of each cell beyond all kernels, which must be even, for a given number of harmonics.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn moments(&self, cells: &SweepCells, count: usize, control: &Control) -> Result<Moments> {
        self.levels(cells, count, None, control, |star, first, out| add_moments(star, first, count, out))
    }

    /// The stars whose kernels reach into a row of cells, as those see what is within.
    pub fn near(&self, cells: &SweepCells, row: usize) -> Vec<DirectSource<'_>> {
        let lattice = &cells.lattice;
        let [_, y, z] = lattice.place(row * lattice.dims[0]);
        let (along, length) = Ray::between(lattice.centre(0, y, z), lattice.centre(lattice.dims[0] - 1, y, z));
        let widest = self.kernels.iter().map(|kernel| kernel.reach_pc).fold(0.0, f64::max);
        let reach = widest + 0.5 * lattice.voxel_pc().length();
        let direct_source = |star: usize| DirectSource {
            place: self.many_lights.places[star],
            sent: &self.sent[star],
            depth: Box::new(move |place, sigma| self.many_lights.near_depth(star, (place - self.many_lights.places[star]).length(), sigma)),
            kernel_pc: Some(self.kernels[star].reach_pc),
        };
        self.many_lights.beside(&along, 0.0, length, reach).map(direct_source).collect()
    }

    /// Sums what `add` makes of each star for sixteen cells of a row, by (star, first cell, values), on both levels.
    fn levels(
        &self,
        cells: &SweepCells,
        count: usize,
        view: Option<Viewpoint>,
        control: &Control,
        add: impl Fn(&Beside, usize, &mut [EightLanes]) + Sync,
    ) -> Result<Moments> {
        let cell_lattice = &cells.lattice;
        let coarse = Lattice { dims: cell_lattice.dims.map(|n| n.div_ceil(2)), bounds: cell_lattice.bounds };
        let largest = |quantity: fn(&NearFieldKernel) -> f64| self.kernels.iter().map(quantity).fold(0.0, f64::max);
        let reach = (MIDDLE * coarse.voxel_pc().max_element()).max(largest(|w| w.reach_pc));
        // Twice as far ahead: coarse cells see peaks from there on.
        let outer =
            NearFieldKernel { reach_pc: reach, ahead_pc: if view.is_some() { reach.max(2.0 * largest(|w| w.ahead_pc)) } else { reach } };
        let mut far = self.level(&CellLevel { lattice: coarse.clone(), count, view, inner: Some(outer), outer: None }, control, &add)?;
        let mut all =
            self.level(&CellLevel { lattice: cell_lattice.clone(), count, view, inner: None, outer: Some(outer) }, control, &add)?;
        if view.is_some() {
            far.match_means(&coarse);
            all.match_means(cell_lattice);
        }
        all.add_interpolated(cell_lattice, &far, &coarse);
        Ok(all)
    }

    fn level(&self, level: &CellLevel, control: &Control, add: &(impl Fn(&Beside, usize, &mut [EightLanes]) + Sync)) -> Result<Moments> {
        let (count, view) = (level.count, level.view);
        let mut light = Moments::dark(level.lattice.cells(), count);
        let [nx, ny, nz] = level.lattice.dims;
        let reached: Vec<Option<Bounds>> = self.many_lights.places.iter().map(|star| level.reached(*star)).collect();
        let done = AtomicU64::new(0);
        light.data.par_chunks_mut(nx * count).enumerate().try_for_each_init(Vec::new, |depths, (row, out)| {
            control.check()?;
            let place = |x: usize| level.lattice.centre(x.min(nx - 1), row % ny, row / ny);
            let eyes: Vec<[Lane; 3]> = (0..nx)
                .step_by(LANES)
                .map(|first| {
                    let eye: [[f32; 3]; LANES] =
                        std::array::from_fn(|i| view.map_or([0.0; 3], |view| view.towards(place(first + i)).as_vec3().to_array()));
                    std::array::from_fn(|axis| lanes!(|i| eye[i][axis]))
                })
                .collect();
            for (star, reached) in reached.iter().enumerate() {
                let Some(range) = level.cells_within(reached.as_ref(), place(0)) else { continue };
                let mut beside: Option<Beside> = None;
                // Chunks stand where those of the eye do.
                for first in (range.start / LANES * LANES..range.end).step_by(LANES) {
                    if beside.is_none() {
                        beside = self.beside(level, star, place(0), depths);
                    }
                    let Some(beside) = &mut beside else { continue };
                    beside.eye = eyes[first / LANES];
                    let cells = LANES.min(nx - first);
                    add(beside, first, &mut out[first * count..][..cells * count]);
                }
            }
            control.report(Stage::Light, done.fetch_add(1, Ordering::Relaxed) + 1, (ny * nz) as u64);
            Ok::<(), Error>(())
        })?;
        Ok(light)
    }

    /// A star as the row of cells that begins at `start` has it.
    fn beside<'a>(&'a self, level: &CellLevel, star: usize, start: DVec3, depths: &'a mut Vec<f32>) -> Option<Beside<'a>> {
        let theirs = self.many_lights.lattice()?;
        self.many_lights.row(star, [start.y, start.z], depths);
        let (edge, voxel) = (level.lattice.voxel_pc().x, theirs.voxel_pc().x);
        Some(Beside {
            offset: (start - self.many_lights.places[star]).as_vec3().to_array(),
            edge: edge as f32,
            depths,
            first: ((start.x - theirs.bounds.low.x) / voxel - 0.5) as f32,
            step: (edge / voxel) as f32,
            sent: &self.sent[star],
            k: self.k,
            inner: level.inner.unwrap_or(self.kernels[star]).shape(),
            outer: level.outer.map(|kernel| kernel.shape()),
            eye: [[0.0; LANES]; 3],
        })
    }
}

impl CellLevel {
    /// The box that a star's light can be in on this level; none where it is everywhere.
    fn reached(&self, star: DVec3) -> Option<Bounds> {
        let bounds = self.outer?.bounds(self.view.map_or(DVec3::ZERO, |view| view.towards(star)));
        Some(Bounds { low: star + bounds.low, high: star + bounds.high })
    }

    /// The cells of the row that begins at `start` whose middles are within a box; none where no cell is.
    fn cells_within(&self, reached: Option<&Bounds>, start: DVec3) -> Option<Range<usize>> {
        let (nx, edge) = (self.lattice.dims[0], self.lattice.voxel_pc().x);
        let Some(Bounds { low, high }) = reached else { return Some(0..nx) };
        let beside = start.y < low.y || start.y > high.y || start.z < low.z || start.z > high.z;
        let cell = |x: f64| ((x - start.x) / edge).ceil().clamp(0.0, nx as f64) as usize;
        let range = cell(low.x)..cell(high.x);
        (!beside && !range.is_empty()).then_some(range)
    }
}

/// The light of a star at sixteen cells.
struct LitCells {
    /// The part of 1/r² that this level takes, (1 − w)/r² [pc⁻²].
    strength: Lane,
    depth: Lane,
    /// The cosine of the angle by which light turns towards the eye.
    cosine: Lane,
    /// The direction in which light goes.
    towards: [Lane; 3],
}

impl Beside<'_> {
    /// The light at cells from number `first` on.
    #[inline(always)]
    fn at(&self, first: usize) -> LitCells {
        let x: Lane = lanes!(|i| fma((first + i) as f32, self.edge, self.offset[0]));
        let [_, y, z] = self.offset;
        let square: Lane = lanes!(|i| fma(x[i], x[i], fma(y, y, z * z)));
        // At the star itself light goes nowhere.
        let inverse: Lane = lanes!(|i| if square[i] > 0.0 { 1.0 / square[i].sqrt() } else { 0.0 });
        let towards = [lanes!(|i| x[i] * inverse[i]), lanes!(|i| y * inverse[i]), lanes!(|i| z * inverse[i])];
        let [a, b, c] = &self.eye;
        let cosine: Lane = lanes!(|i| fma(towards[0][i], a[i], fma(towards[1][i], b[i], towards[2][i] * c[i])).clamp(-1.0, 1.0));
        let strength: Lane = match &self.outer {
            None => lanes!(|i| self.inner.beyond(square[i], cosine[i])),
            Some(outer) => lanes!(|i| self.inner.beyond(square[i], cosine[i]) - outer.beyond(square[i], cosine[i])),
        };
        let last = (self.depths.len() - 2) as f32;
        let depth: Lane = lanes!(|i| {
            let u = fma((first + i) as f32, self.step, self.first).clamp(0.0, last + 1.0);
            let voxel = u.min(last) as usize;
            let (a, b) = (self.depths[voxel], self.depths[voxel + 1]);
            fma(u - voxel as f32, b - a, a).max(0.0)
        });
        LitCells { strength, depth, cosine, towards }
    }

    /// The light of each term that arrives in cell `i` of them.
    #[inline(always)]
    fn light(&self, lit: &LitCells, i: usize) -> EightLanes {
        let mut light = [0.0; WIDTH];
        for t in 0..WIDTH {
            light[t] = self.sent[t] * lit.strength[i] * exp(-self.k[t] * lit.depth[i]);
        }
        light
    }
}

simd! {
    /// Adds moments of a star's light, a given number of harmonics a cell, to up to sixteen cells from number `first` of the row on.
    fn add_moments(star: &Beside, first: usize, count: usize, out: &mut [EightLanes]) {
        let lit = star.at(first);
        let mut values = [[0.0; LANES]; COUNT];
        harmonics_of(lit.towards, |x| x as f32, &mut values[..count]);
        // In the middle of a cell it goes everywhere.
        let somewhere: Lane = lanes!(|i| lit.towards.iter().map(|axis| axis[i] * axis[i]).sum());
        values[1..].iter_mut().for_each(|value| *value = lanes!(|i| if somewhere[i] > 0.0 { value[i] } else { 0.0 }));
        for (i, moments) in out.chunks_exact_mut(count).enumerate() {
            let light = star.light(&lit, i);
            for (moment, value) in moments.iter_mut().zip(&values) {
                for t in 0..WIDTH {
                    moment[t] = fma(value[i], light[t], moment[t]);
                }
            }
        }
    }
}

simd! {
    /// Adds what of a star's light is scattered towards the eye in up to sixteen cells, from number `first` of the row on.
    fn add_seen(star: &Beside, scattering: &Scattering, first: usize, out: &mut [EightLanes]) {
        const EVENLY: f32 = 1.0 / spectra::constants::SPHERE as f32;
        let lit = star.at(first);
        let cosine = &lit.cosine;
        for (i, source) in out.iter_mut().enumerate() {
            let mut phase = [EVENLY; WIDTH];
            if let Some(table) = scattering.phase {
                let PhaseEntry { entry, fraction: f } = PhaseTable::entry(table.entries, cosine[i], fma(-cosine[i], cosine[i], 1.0));
                let entry = entry as usize;
                if table.separable {
                    let (low, high) = (table.at_nodes[entry], table.at_nodes[entry + 1]);
                    phase = [fma(f, high - low, low); WIDTH];
                } else {
                    let row = |entry: usize| &table.at_nodes[entry * scattering.terms + scattering.first..];
                    for ((phase, low), high) in phase.iter_mut().zip(row(entry)).zip(row(entry + 1)) {
                        *phase = fma(f, high - low, *low);
                    }
                }
            }
            let light = star.light(&lit, i);
            for t in 0..WIDTH {
                source[t] = fma(scattering.albedo[t] * phase[t], light[t], source[t]);
            }
        }
    }
}
