//! The picture of a volume that nobody holds as a whole, brick by brick.
//!
//! Extinction is k(λ) σ(x), so all that a brick does to a ray is to add one depth τ and, for each term, one light:
//!
//!   front over back = (L_f + e^(−k τ_f) L_b, τ_f + τ_b),
//!
//! which is associative and exact. Rays, their steps and the rules are chosen once for all bricks, on a coarse volume;
//! a segment belongs to the brick in which its middle lies. So any number of bricks makes the picture of one, but for
//! the order in which numbers are rounded. Star depths come from [`Relay`](crate::plan::star_depths::relay::Relay).
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | L | the first values of a ray in `Partial::values` | that of a sum |
//! | τ | the value after them | 1 |
//! | k | `extinctions` | 1 |

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::borders::moved_out;
use super::march::March;
use super::tables::Tables;
use super::{ENTRY, TILE};
use crate::backend::finish::{draw_behind, end_of_space, stated};
use crate::backend::{Radiance, RenderStats};
use crate::camera::{Camera, Projection};
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::field::{Lattice, Partition};
use crate::geometry::{Bounds, Ray};
use crate::image::Image;
use crate::memory;
use crate::packet::{LANES, Lane, exp, lanes};
use crate::plan::{BrickFields, Options, Plan, Planned, Planner, SpatialPlan, Stepping};
use crate::points;
use crate::scene::Scene;

/// Voxels that the march of a brick reads beyond those of its segments: the pieces beside a star, the cells around a
/// place, and the neighbours that move a star depth to its mean.
const HALO: f64 = 6.0;
/// Numbers of a ray beside its sums: the optical depth, and the largest depth that was met.
const BESIDE_SUMS: usize = 2;

/// Data shared by all bricks of a volume: a scene of coarse fields with its plan, and where the voxels are.
#[derive(Debug)]
pub struct Whole {
    planned: Planned,
    partition: Partition,
    memory_limit: u64,
}

/// Effect of a brick, or of several consecutive bricks, on the rays of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Partial {
    /// The rays that meet it, by rows and columns; others see nothing of it.
    pub rows: Range<usize>,
    /// The columns of these rays.
    pub columns: Range<usize>,
    /// For each ray the light of each sum, the optical depth at V, and the largest of those from eye to sample to star
    /// that were met: rows × columns × (sums + 2).
    pub values: Vec<f32>,
    /// The optical depth at V before each unresolved source of the picture \[1\].
    pub points: Vec<f64>,
}

impl Whole {
    /// Plans a scene whose fields are those of a volume of `dims` voxels along x, y and z, made coarse in the same box. The
    /// volume is cut at `cuts`: where bricks begin along each axis, and the end of the last.
    ///
    /// # Errors
    /// Errors of [`Planner::plan`]; features that bricks do not support: stereo, multiple scattering, detail, aggregated stars, rules
    /// without exponentials; fields with several boxes; cuts that do not cover the volume.
    pub fn new(scene: &Scene, dims: [usize; 3], cuts: [Vec<usize>; 3], options: &Options, control: &Control) -> Result<Self> {
        // Bricks have the depths of stars at their own voxels.
        let options = Options { star_depth_voxels: 1, ..options.clone() };
        let refused = |feature: &str, alternative: &str| Err(Error::unsupported(feature, "a picture in bricks", alternative));
        if scene.camera.stereo.is_some() || scene.camera.eye.is_some() {
            return refused("stereo cameras", "remove stereo");
        }
        if scene.method.bounces > 1 {
            return refused("multiple scattering", "set bounces = 1");
        }
        if scene.detail.is_some() {
            return refused("[detail]", "remove [detail]");
        }
        let planned = Planner::new(&options).plan(scene, None, control)?;
        if planned.space.many_lights.is_some() {
            return refused("aggregated stars", "set exact_stars to the number of stars");
        }
        let tables = Tables::new(&planned);
        if planned.star_march.is_some() || planned.light_field.is_some() || tables.terms.exponentials().is_none() {
            return refused("this spectral method", "use the default method");
        }
        drop(tables);
        let mut boxes = planned.space.dust.iter().map(|d| &**d).chain(planned.space.gas()).map(|grid| grid.lattice().bounds);
        let Some(bounds) = boxes.next() else { return Err(Error::missing("dust or gas", "add some to the scene")) };
        if let Some(other) = boxes.find(|other| *other != bounds) {
            let named = |bounds: Bounds| format!("{} to {} pc", bounds.low, bounds.high);
            return Err(Error::mismatch("boxes of bricked densities", named(bounds), named(other)));
        }
        let lattice = Lattice { dims, bounds };
        // Each brick brings its own.
        let mut space = SpatialPlan::clone(&planned.space);
        space.volumes = Vec::new();
        let planned = planned.with_space(Arc::new(space));
        Ok(Self { planned, partition: Partition::new(lattice, cuts)?, memory_limit: options.memory_limit })
    }

    /// The plan of the coarse volume, without what a march reads of it.
    pub fn plan(&self) -> &Plan {
        &self.planned
    }

    /// Positions of the voxels and the bricks.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// Places of the stars that have depths \[pc\], in the order of [`BrickFields::star_depths`].
    pub fn stars(&self) -> Vec<DVec3> {
        let with_depths = if self.planned.space.dust.is_some() { self.planned.space.marched() } else { &[] };
        with_depths.iter().map(|star| self.planned.space.stars[*star]).collect()
    }

    /// The voxels that the march of a brick reads: its own and a halo around them.
    pub fn stored(&self, place: [usize; 3]) -> [Range<usize>; 3] {
        let (voxels, dims) = (self.partition.voxels(place), self.partition.lattice().dims);
        let diagonal = DVec3::from(dims.map(|n| n as f64)).length();
        let step = match self.planned.stepping {
            Stepping::PerVoxel(n) | Stepping::Paired(n) => 1.0 / n,
            Stepping::Fixed(n) => diagonal / n as f64,
        };
        let halo = (0.5 * step + HALO).ceil() as usize;
        std::array::from_fn(|axis| voxels[axis].start.saturating_sub(halo)..(voxels[axis].end + halo).min(dims[axis]))
    }

    /// The part of space whose segments are a brick's own; the outermost bricks have all that is beyond.
    fn domain(&self, place: [usize; 3]) -> Bounds {
        let voxels = self.partition.voxels(place);
        let lattice = self.partition.lattice();
        let (Lattice { dims, bounds }, voxel) = (lattice, lattice.voxel_pc());
        let border = |axis: usize, cut: usize| match cut {
            0 => f64::NEG_INFINITY,
            cut if cut == dims[axis] => f64::INFINITY,
            cut => bounds.low[axis] + cut as f64 * voxel[axis],
        };
        let corner = |ends: [usize; 3]| DVec3::from_array(std::array::from_fn(|axis| border(axis, ends[axis])));
        Bounds { low: corner(voxels.each_ref().map(|range| range.start)), high: corner(voxels.each_ref().map(|range| range.end)) }
    }

    /// Marches the rays of the picture through a brick, whose fields stand at the voxels that it [stores](Self::stored).
    ///
    /// # Errors
    /// If fields have other numbers of values, the result would take more memory than allowed, and when the user
    /// wishes to stop.
    pub fn march(&self, place: [usize; 3], fields: BrickFields, control: &Control) -> Result<Partial> {
        let whole = self.partition.lattice();
        let space = self.planned.space.brick(whole, &self.stored(place), fields, self.memory_limit)?;
        let plan = &Plan { space: Arc::new(space), ..self.planned.plan().clone() };
        let domain = self.domain(place);
        let camera = &plan.camera;
        let tiles = Tiles::new(camera);
        let meeting = domain.intersection(&whole.bounds).and_then(|overlap| tiles.meeting(camera, &moved_out(&overlap, &whole.bounds)));
        // Sources stand between pixels: what no pixel's ray meets may lie before one.
        let points = self.points(plan, &domain)?;
        let Some((rows, columns)) = meeting else {
            return Ok(Partial { rows: 0..0, columns: 0..0, values: Vec::new(), points });
        };
        let tables = Tables::new(plan);
        let march = March::new(plan, &tables, Some(domain));
        let size = self.size(&tables);
        let (width, height) = (columns.len() * TILE, rows.len() * TILE);
        memory::check("picture of a brick", 4 * (width * height * size) as u64, self.memory_limit)?;
        let mut values = vec![0.0; width * height * size];
        let done = AtomicU64::new(0);
        let of_row = |(row, out): (usize, &mut [f32])| -> Result<()> {
            control.check()?;
            for column in columns.clone() {
                let (rays, numbers) = tiles.packet(camera, column, rows.start + row);
                let state = march.light(&rays, &numbers);
                for lane in 0..LANES {
                    let (x, y) = ((column - columns.start) * TILE + lane % TILE, lane / TILE);
                    let pixel_out = &mut out[(y * width + x) * size..][..size];
                    let numbers = state.sum.iter().chain([&state.tau, &state.deepest]);
                    pixel_out.iter_mut().zip(numbers).for_each(|(out, lanes)| *out = lanes[lane]);
                }
            }
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            control.report(Stage::Rays, count, rows.len() as u64);
            Ok(())
        };
        values.par_chunks_exact_mut(TILE * width * size).enumerate().try_for_each(of_row)?;
        let [rows, columns] = [rows, columns].map(|tiles| tiles.start * TILE..tiles.end * TILE);
        Ok(Partial { rows, columns, values, points })
    }

    /// The optical depth at V in a domain before each unresolved source, exact through the samples of the dust \[1\].
    fn points(&self, plan: &Plan, domain: &Bounds) -> Result<Vec<f64>> {
        let far = end_of_space(plan);
        let points = points::points(plan.sources, self.planned.scene(), &plan.camera, &plan.lights)?;
        let grown = moved_out(domain, &self.partition.lattice().bounds);
        let depth = |point: &points::Point| {
            let ray = point.ray(&plan.camera);
            let (near, end) = grown.clip(&ray)?;
            let end = end.min(point.length).min(far);
            // A ray between two bricks runs through one.
            (near < end && domain.holds(ray.at(0.5 * (near + end)))).then(|| plan.space.depth(ray.at(near), ray.at(end)))
        };
        Ok(points.par_iter().map(|point| depth(point).unwrap_or(0.0)).collect())
    }

    /// Bricks in an order in which no ray meets one before another that stands before it, by their numbers along x, y
    /// and z.
    pub fn front_to_back(&self) -> Vec<[usize; 3]> {
        let (camera, lattice) = (&self.planned.camera, self.partition.lattice());
        // How many bricks lie before one along an axis.
        let before = |axis: usize, brick: usize| -> usize {
            let count = self.partition.count(axis);
            match camera.projection {
                Projection::Orthographic { .. } if camera.forward[axis] < 0.0 => count - 1 - brick,
                Projection::Orthographic { .. } => brick,
                Projection::Perspective { .. } | Projection::Panorama { .. } => {
                    let end = |brick: usize| self.partition.range(axis, brick).end as f64 * lattice.voxel_pc()[axis];
                    let from = camera.position[axis] - lattice.bounds.low[axis];
                    brick.abs_diff((0..count).filter(|brick| end(*brick) <= from).count())
                }
            }
        };
        let mut all = self.partition.bricks();
        all.sort_by_key(|place| (0..3).map(|axis| before(axis, place[axis])).sum::<usize>());
        all
    }

    /// The numbers of a ray.
    fn size(&self, tables: &Tables) -> usize {
        tables.terms.sums(tables.weights.terms) + BESIDE_SUMS
    }

    /// The extinction of each sum relative to V.
    fn extinctions(&self, tables: &Tables) -> Vec<f32> {
        let k = tables.terms.exponentials().map_or(&[][..], |nodes| &nodes.k);
        k.iter().copied().cycle().take(tables.terms.sums(tables.weights.terms)).collect()
    }

    /// Combined effect of two bricks, the nearer one first.
    ///
    /// # Errors
    /// If the parts are not those of this picture.
    pub fn over(&self, front: Partial, back: Partial) -> Result<Partial> {
        let tables = Tables::new(&self.planned);
        let (k, size) = (self.extinctions(&tables), self.size(&tables));
        front.check(size)?;
        back.check(size)?;
        if front.points.len() != back.points.len() {
            return Err(Error::mismatch("sources of a partial picture", back.points.len(), front.points.len()));
        }
        let points = front.points.iter().zip(&back.points).map(|(a, b)| a + b).collect();
        if front.values.is_empty() || back.values.is_empty() {
            let front_or_back = if front.values.is_empty() { back } else { front };
            return Ok(Partial { points, ..front_or_back });
        }
        let hull = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        let (rows, columns) = (hull(&front.rows, &back.rows), hull(&front.columns, &back.columns));
        memory::check("picture of bricks", 4 * (rows.len() * columns.len() * size) as u64, self.memory_limit)?;
        let mut values = vec![0.0; rows.len() * columns.len() * size];
        values.par_chunks_mut(columns.len() * size).zip(rows.clone()).for_each(|(line, row)| {
            for (out, column) in line.chunks_exact_mut(size).zip(columns.clone()) {
                match (front.at(row, column, size), back.at(row, column, size)) {
                    (Some(front), Some(back)) => {
                        let tau = front[k.len()];
                        for (i, k) in k.iter().enumerate() {
                            out[i] = front[i] + exp(-k * tau) * back[i];
                        }
                        let [depth, deepest] = [k.len(), k.len() + 1];
                        out[depth] = tau + back[depth];
                        out[deepest] = if back[deepest] > 0.0 { front[deepest].max(tau + back[deepest]) } else { front[deepest] };
                    }
                    (Some(only), None) | (None, Some(only)) => out.copy_from_slice(only),
                    (None, None) => {}
                }
            }
        });
        Ok(Partial { rows, columns, values, points })
    }

    /// The picture of what all bricks do, stars and background behind them, and what was measured on the way.
    ///
    /// # Errors
    /// If values are no numbers or the parts are not those of this picture, and on interruption by the user.
    pub fn picture(&self, all: &Partial, control: &Control) -> Result<(Image, RenderStats)> {
        let plan = &self.planned;
        let tables = Tables::new(plan);
        let size = self.size(&tables);
        let (sums, depth) = (size - BESIDE_SUMS, size - BESIDE_SUMS);
        all.check(size)?;
        let march = March::new(plan, &tables, None);
        let (camera, bands) = (&plan.camera, plan.spectral.bands.len());
        let (width, height, s) = (camera.width, camera.height, camera.supersampling);
        let mut data = vec![0.0; bands * width * height];
        for y in 0..height * s {
            control.check()?;
            for first in (0..width * s).step_by(LANES) {
                let value = |lane: usize, i: usize| all.at(y, first + lane, size).map_or(0.0, |pixel| pixel[i]);
                let sum: Vec<Lane> = (0..sums).map(|i| lanes!(|lane| value(lane, i))).collect();
                let radiance = march.bands_of(&sum, &lanes!(|lane| value(lane, depth)), &[]);
                for (lane, x) in (first..width * s).take(LANES).enumerate() {
                    for band in 0..bands {
                        data[(band * height + y / s) * width + x / s] += radiance[band * LANES + lane] / (s * s) as f32;
                    }
                }
            }
        }
        let negative = data.iter().filter(|v| **v < 0.0).count() as u64;
        let largest = |i: usize| all.values.chunks_exact(size).map(|ray| ray[i]).fold(0.0, f32::max);
        let behind = if tables.weights.background.is_some() { largest(depth) } else { 0.0 };
        let deepest = f64::from(largest(depth + 1).max(behind));
        let stats = RenderStats { depth: deepest, rays: (width * height * s * s) as u64, storage: plan.storage(), negative };
        let mut radiance = Radiance::single(data, stats);
        let before = |number: usize, _: &Ray, _: f64| all.points.get(number).copied().unwrap_or(0.0);
        let points = draw_behind(plan.sources, plan, before, control, |i, value| radiance.samples.add(i, value))?;
        Ok((Image { points, ..stated(plan, radiance, ENTRY.name)? }, stats))
    }
}

impl Partial {
    fn check(&self, size: usize) -> Result<()> {
        let wanted = self.rows.len().checked_mul(self.columns.len()).and_then(|rays| rays.checked_mul(size));
        if wanted == Some(self.values.len()) {
            return Ok(());
        }
        let what = format!("{} x {} rays of {size} numbers", self.rows.len(), self.columns.len());
        Err(Error::mismatch("partial picture", what, format!("{} numbers", self.values.len())))
    }

    /// The numbers of a ray, where the ray is among those that meet the bricks.
    fn at(&self, row: usize, column: usize, size: usize) -> Option<&[f32]> {
        let is_met = self.rows.contains(&row) && self.columns.contains(&column);
        let first = || ((row - self.rows.start) * self.columns.len() + column - self.columns.start) * size;
        is_met.then(|| &self.values[first()..][..size])
    }
}

/// The packets of a picture: tiles of rays.
struct Tiles {
    /// Rays along a row and along a column.
    rays: [usize; 2],
    rows: usize,
    columns: usize,
    supersampling: usize,
}

impl Tiles {
    fn new(camera: &Camera) -> Self {
        let supersampling = camera.supersampling;
        let rays = [camera.width * supersampling, camera.height * supersampling];
        Self { rays, rows: rays[1].div_ceil(TILE), columns: rays[0].div_ceil(TILE), supersampling }
    }

    /// The rays of a tile, and their numbers in the image; those beside the image are like its border.
    fn packet(&self, camera: &Camera, column: usize, row: usize) -> ([Ray; LANES], [u64; LANES]) {
        let place = |lane: usize| (column * TILE + lane % TILE, row * TILE + lane / TILE);
        let s = self.supersampling as f64;
        let ray = |lane: usize| {
            let (x, y) = place(lane);
            camera.ray((x.min(self.rays[0] - 1) as f64 + 0.5) / s, (y.min(self.rays[1] - 1) as f64 + 0.5) / s)
        };
        let number = |lane: usize| (place(lane).1 * self.rays[0] + place(lane).0) as u64;
        (std::array::from_fn(ray), std::array::from_fn(number))
    }

    /// The rows and columns of tiles that meet a box.
    fn meeting(&self, camera: &Camera, bounds: &Bounds) -> Option<(Range<usize>, Range<usize>)> {
        let of_row = |row: usize| {
            let meets = |column: &usize| self.packet(camera, *column, row).0.iter().any(|ray| bounds.clip(ray).is_some());
            let first = (0..self.columns).find(meets)?;
            let last = (first..self.columns).rev().find(meets)?;
            Some((row..row + 1, first..last + 1))
        };
        let hull = |a: Range<usize>, b: Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        let rows: Vec<_> = (0..self.rows).into_par_iter().filter_map(of_row).collect();
        rows.into_iter().reduce(|a, b| (hull(a.0, b.0), hull(a.1, b.1)))
    }
}
