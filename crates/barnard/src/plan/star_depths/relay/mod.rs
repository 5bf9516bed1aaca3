//! Star depths from brick to brick: the sweeps of `frustum_sweep` where nobody holds all of the dust.
//!
//! Along the axis of a frustum bricks stand in layers. A layer takes the rays over from the one before, on its last
//! plane, and hands them on on its own; within it each brick follows the rays that its own voxels ask for. No ray
//! leaves the axis by more than a voxel a plane, so what they meet in the layer lies in the brick and in its neighbours
//! towards the star. A ray is handed on by the brick in which it leaves the layer, one that runs beside the box by the
//! outermost. Places are counted as in the whole, so that the depths are those of one sweep, bit by bit.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec3;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Grid, Lattice, Partition};
use crate::plan::star_depths::between_rays::beside;
use crate::plan::star_depths::frustum::{Frustum, Rays, TierOf, frustums};
use crate::plan::star_depths::frustum_sweep::{FrustumSweep, Tier, exact_depth};
use crate::plan::star_depths::planes::DustWindow;

/// Voxels around those of a brick between which and its own rays are interpolated, and σ between voxels.
const AROUND: f64 = 4.0;
/// Voxels beside a side in which no ray may tell a depth, and those between which σ is interpolated there.
const BORDER: usize = 4;

/// The sweeps of one star's depths through bricks.
#[derive(Debug, Clone)]
pub struct Relay {
    partition: Partition,
    star: DVec3,
    frustums: Vec<Frustum>,
}

/// A layer of bricks as a frustum's rays meet it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layer {
    /// The number of the frustum.
    pub frustum: usize,
    /// Its planes, by their numbers in the order in which rays meet them.
    pub numbers: Range<usize>,
    /// The bricks in which rays have something to do, by their numbers along x, y and z.
    pub bricks: Vec<[usize; 3]>,
}

/// Purpose of a pass over all layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pass {
    /// Rays that come into the box through a side learn the depth at which they do.
    Entries,
    /// Voxels get their depths.
    Depths,
}

/// A brick with the dust that its rays meet.
#[derive(Debug)]
pub struct Brick<'a> {
    /// Its numbers along x, y and z.
    pub place: [usize; 3],
    /// The extinction σ at V [pc⁻¹] of the voxels that [`Relay::needs`] selects.
    pub dust: &'a Grid,
    /// The extinction of the voxels that [`Relay::border`] selects, for both sides.
    pub borders: [Option<&'a Grid>; 2],
}

/// Depths of some rays of a tier.
#[derive(Debug, Clone)]
pub struct Handed {
    /// The number of the tier.
    pub tier: usize,
    /// The rays along u and v.
    pub rays: [Range<usize>; 2],
    /// Their depths so far, v × u \[1\].
    pub depths: Vec<f32>,
    /// The depths at which they came into the box, in the pass that finds them.
    pub entries: Vec<f32>,
}

/// All rays of some tiers, by number: depths and entries, v × u.
pub type Carried<'a> = BTreeMap<usize, (&'a [f32], &'a [f32])>;

impl Relay {
    /// The sweeps from `star` \[pc\] through a volume that is cut into bricks.
    pub fn new(partition: Partition, star: DVec3) -> Self {
        let frustums = frustums(partition.lattice(), star);
        Self { partition, star, frustums }
    }

    /// The voxel along x, y and z on whose centre the star stands: no frustum has it, its depth is zero.
    pub fn own_voxel(&self) -> Option<[usize; 3]> {
        let Lattice { dims, bounds } = self.partition.lattice();
        let place = (self.star - bounds.low) / self.partition.lattice().voxel_pc() - 0.5;
        let is_voxel = |axis: usize| place[axis].fract() == 0.0 && (0.0..dims[axis] as f64).contains(&place[axis]);
        (0..3).all(is_voxel).then(|| [0, 1, 2].map(|axis| place[axis] as usize))
    }

    /// True if rays come in through sides, so that a pass must find their entries.
    pub fn has_entries(&self, frustum: usize) -> bool {
        self.frustums[frustum].has_side_entries()
    }

    /// Rays along u and v of each tier.
    pub fn rays(&self, frustum: usize) -> Vec<[usize; 2]> {
        self.frustums[frustum].tiers().into_iter().map(|tier| tier.rays.counts).collect()
    }

    /// The layers of all frustums; those of one in the order in which its rays meet them.
    pub fn layers(&self) -> Vec<Layer> {
        (0..self.frustums.len()).flat_map(|number| self.layers_of(number)).collect()
    }

    fn layers_of(&self, number: usize) -> Vec<Layer> {
        let frustum = &self.frustums[number];
        let planes = frustum.planes();
        let w = frustum.axes[2];
        let mut layers: Vec<Layer> = Vec::new();
        let mut along: Vec<usize> = (0..self.partition.count(w)).collect();
        if frustum.sign < 0.0 {
            along.reverse();
        }
        for layer in along {
            let first = layers.last().map_or(0, |layer| layer.numbers.end);
            let of_layer = planes[first..].iter().take_while(|plane| self.partition.range(w, layer).contains(plane)).count();
            if of_layer == 0 {
                continue;
            }
            let numbers = first..first + of_layer;
            let mut bricks = self.partition.bricks();
            bricks.retain(|place| place[w] == layer && self.is_met(number, &planes, &numbers, *place));
            layers.push(Layer { frustum: number, numbers, bricks });
        }
        layers
    }

    /// True if a brick has rays to hand on, or voxels in the frustum.
    fn is_met(&self, number: usize, planes: &[usize], numbers: &Range<usize>, place: [usize; 3]) -> bool {
        let frustum = &self.frustums[number];
        let tiers = frustum.tiers().into_iter().filter(|tier| tier.end > numbers.start);
        tiers.into_iter().any(|TierOf { rays, end, .. }| {
            let last = frustum.distance(planes[end.min(numbers.end) - 1]);
            let is_left_here = (0..2).all(|axis| !self.left_in(number, &rays, axis, last, place).is_empty());
            let z = frustum.distance(planes[numbers.end - 1]);
            let has_voxels = (0..2).all(|axis| {
                let range = self.partition.range(frustum.axes[axis], place[frustum.axes[axis]]);
                range.start as f64 - frustum.star[axis] <= z + 1.0 && frustum.star[axis] - range.end as f64 <= z + 1.0
            });
            is_left_here || has_voxels
        })
    }

    /// The rays along u or v that are in a brick on a plane at distance `z`; those beside the box are in the outermost.
    fn left_in(&self, number: usize, rays: &Rays, axis: usize, z: f64, place: [usize; 3]) -> Range<usize> {
        let frustum = &self.frustums[number];
        let (range, count) = (self.partition.range(frustum.axes[axis], place[frustum.axes[axis]]), frustum.dims[axis]);
        let at = |ray: usize| frustum.star[axis] + (rays.first[axis] + (ray as f64 - 1.0) * rays.spacing) * z;
        // The first ray beyond a border between bricks: both sides of it find the same.
        let beyond = |cut: usize| match cut {
            0 => 0,
            cut if cut == count => rays.counts[axis],
            cut => {
                let guess = (1.0 + ((cut as f64 - 0.5 - frustum.star[axis]) / z - rays.first[axis]) / rays.spacing).ceil();
                let mut ray = guess.clamp(0.0, rays.counts[axis] as f64) as usize;
                while ray > 0 && at(ray - 1) >= cut as f64 - 0.5 {
                    ray -= 1;
                }
                while ray < rays.counts[axis] && at(ray) < cut as f64 - 0.5 {
                    ray += 1;
                }
                ray
            }
        };
        beyond(range.start)..beyond(range.end)
    }

    /// The planes of a layer of which σ is read, from the voxel before the first to that behind the last.
    fn depth_range(&self, layer: &Layer, from_entry: bool) -> Range<usize> {
        let frustum = &self.frustums[layer.frustum];
        let planes = frustum.planes();
        let first = if from_entry { planes[0] } else { planes[layer.numbers.start] };
        let last = planes[layer.numbers.end - 1];
        let count = frustum.dims[2];
        first.min(last).saturating_sub(2)..(first.max(last) + 3).min(count)
    }

    /// The voxels along x, y and z whose dust the rays of a brick meet in a layer.
    pub fn needs(&self, layer: &Layer, place: [usize; 3]) -> [Range<usize>; 3] {
        let frustum = &self.frustums[layer.frustum];
        let planes = frustum.planes();
        let entry = frustum.before(&planes, layer.numbers.start);
        let [near, far] = [layer.numbers.start, layer.numbers.end - 1].map(|number| frustum.distance(planes[number]));
        let mut needs = [0..0, 0..0, 0..0];
        for axis in 0..2 {
            let (range, count) = (self.partition.range(frustum.axes[axis], place[frustum.axes[axis]]), frustum.dims[axis]);
            let star = frustum.star[axis];
            let ends = [range.start as f64 - AROUND, range.end as f64 + AROUND];
            // Where rays that pass the brick's ends on its planes are there, and where they came into the layer.
            let places = ends.into_iter().flat_map(|end| [end, star + (end - star) * entry / near, star + (end - star) * entry / far]);
            let (low, high) = places.fold((f64::MAX, f64::MIN), |(low, high), place| (low.min(place), high.max(place)));
            let low = low.floor().clamp(0.0, count as f64 - 1.0) as usize;
            let high = (high.ceil() + 1.0).clamp(0.0, count as f64) as usize;
            needs[frustum.axes[axis]] = low..high.max(low + 1);
        }
        needs[frustum.axes[2]] = self.depth_range(layer, false);
        needs
    }

    /// The voxels beside a side along u (0) or v (1) through which straight ways from the star to those of a brick
    /// beside it run: none where no ray comes in there, or the brick does not touch it.
    pub fn border(&self, layer: &Layer, place: [usize; 3], side: usize) -> Option<[Range<usize>; 3]> {
        let frustum = &self.frustums[layer.frustum];
        let border = frustum.side(side)?;
        let (axis, count) = (frustum.axes[side], frustum.dims[side]);
        let range = self.partition.range(axis, place[axis]);
        let beside = if border < 0.0 { 0..BORDER.min(count) } else { count.saturating_sub(BORDER)..count };
        if range.end <= beside.start || range.start >= beside.end {
            return None;
        }
        let other = 1 - side;
        let (range, count) = (self.partition.range(frustum.axes[other], place[frustum.axes[other]]), frustum.dims[other]);
        let star = frustum.star[other].clamp(0.0, count as f64 - 1.0) as usize;
        let mut voxels = [0..0, 0..0, 0..0];
        voxels[axis] = beside;
        voxels[frustum.axes[other]] = range.start.min(star).saturating_sub(2)..(range.end.max(star) + 3).min(count);
        voxels[frustum.axes[2]] = self.depth_range(layer, true);
        Some(voxels)
    }

    /// Sweeps a brick in a layer, from what the layer before carried to it; nothing where the layer is the first.
    ///
    /// Returns the depths of its voxels, z × y × x, NaN where the frustum has none, in the pass that makes them, and
    /// the rays that it hands on.
    ///
    /// # Errors
    /// On interruption by the user, and if dust or rays are not those that the sweep needs.
    pub fn sweep(
        &self,
        layer: &Layer,
        pass: Pass,
        brick: &Brick,
        carried: &Carried,
        control: &Control,
    ) -> Result<(Option<Vec<f32>>, Vec<Handed>)> {
        let frustum = &self.frustums[layer.frustum];
        let planes = frustum.planes();
        let part = self.part(brick.dust, &self.needs(layer, brick.place))?;
        let exact = |place: [usize; 3]| self.exact(layer, brick, place);
        let ranges = [0, 1].map(|axis| self.partition.range(frustum.axes[axis], brick.place[frustum.axes[axis]]));
        let sweep = FrustumSweep { dust: part, frustum: frustum.clone(), ranges, exact: &exact };
        let mut out = (pass == Pass::Depths).then(|| BrickDepths::new(self, frustum, brick.place));
        let mut handed = Vec::new();
        for (number, TierOf { rays, begin, end }) in frustum.tiers().into_iter().enumerate() {
            let numbers = layer.numbers.start..layer.numbers.end.min(end);
            if numbers.is_empty() {
                continue;
            }
            // Entries are handed on to the end; depths where more planes follow.
            let left = (pass == Pass::Entries || end > layer.numbers.end).then(|| {
                let last = frustum.distance(planes[numbers.end - 1]);
                [0, 1].map(|axis| self.left_in(layer.frustum, &rays, axis, last, brick.place))
            });
            let written = if pass == Pass::Depths { begin.max(numbers.start)..numbers.end } else { 0..0 };
            let asked = written.clone().filter_map(|number| asked(&sweep, &rays, frustum.distance(planes[number])));
            let left = left.filter(|rays| rays.iter().all(|rays| !rays.is_empty()));
            let Some(window) = asked.chain(left.clone()).reduce(|a, b| [0, 1].map(|axis| hull(&a[axis], &b[axis]))) else { continue };
            let mut tier = self.tier(number, rays, window, pass, carried)?;
            sweep.follow(&mut tier, &planes[..end], numbers, control, |tier, number| {
                if let Some(out) = out.as_mut().filter(|_| written.contains(&number)) {
                    let covered = sweep.plane_values(tier, planes[number], &mut out.plane);
                    out.write(planes[number], &covered);
                }
            })?;
            handed.extend(left.map(|rays| cut_out(number, &tier, rays)));
        }
        Ok((out.map(|out| out.values), handed))
    }

    /// Dust that must be that of some voxels.
    fn part<'a>(&self, dust: &'a Grid, voxels: &[Range<usize>; 3]) -> Result<DustWindow<'a>> {
        let wanted = voxels.each_ref().map(|v| v.len());
        if dust.lattice().dims != wanted {
            return Err(Error::mismatch("dust of a brick", format!("{wanted:?} voxels"), format!("{:?}", dust.lattice().dims)));
        }
        Ok(DustWindow { grid: dust, first: voxels.each_ref().map(|v| v.start), dims: self.partition.lattice().dims })
    }

    /// The depth of the straight way to a voxel beside a side that rays graze.
    fn exact(&self, layer: &Layer, brick: &Brick, place: [usize; 3]) -> f32 {
        let frustum = &self.frustums[layer.frustum];
        let is_beside = |side: usize| match frustum.side(side) {
            Some(border) if border < 0.0 => place[side] + 1 < BORDER,
            Some(_) => place[side] + BORDER > frustum.dims[side],
            None => false,
        };
        let border = (0..2).find(|side| is_beside(*side)).and_then(|side| brick.borders[side]);
        exact_depth(border.unwrap_or(brick.dust), self.star, self.partition.lattice(), frustum.axes, place)
    }

    /// The rays of a window as they come into a layer.
    fn tier(&self, number: usize, rays: Rays, window: [Range<usize>; 2], pass: Pass, carried: &Carried) -> Result<Tier> {
        let count = rays.counts[0] * rays.counts[1];
        let (depths, entries) = carried.get(&number).copied().unwrap_or_default();
        let moved = |values: &[f32]| -> Result<Vec<f32>> {
            if values.is_empty() {
                return Ok(vec![0.0; window[0].len() * window[1].len()]);
            }
            if values.len() != count {
                return Err(Error::mismatch("rays of a tier", format!("{count} values"), values.len()));
            }
            Ok(window[1].clone().flat_map(|j| &values[j * rays.counts[0]..][window[0].clone()]).copied().collect())
        };
        let entries = (pass == Pass::Entries).then(|| moved(entries)).transpose()?;
        Ok(Tier { depths: moved(depths)?, entries, window, rays })
    }
}

/// The rays that the voxels of a plane at distance `z` ask for.
fn asked(sweep: &FrustumSweep, rays: &Rays, z: f64) -> Option<[Range<usize>; 2]> {
    let counts = |axis: usize| {
        let voxels = sweep.covered(axis, z);
        let (first, step) = sweep.among(rays, axis, z);
        let second = |voxel: usize| beside(first + voxel as f64 * step, rays.counts[axis]).0;
        (!voxels.is_empty()).then(|| second(voxels.start) - 1..second(voxels.end - 1) + 3)
    };
    Some([counts(0)?, counts(1)?])
}

/// The smallest range that holds both.
fn hull(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    a.start.min(b.start)..a.end.max(b.end)
}

/// Some rays of a tier's window.
fn cut_out(number: usize, tier: &Tier, rays: [Range<usize>; 2]) -> Handed {
    let width = tier.window[0].len();
    let moved = |values: &[f32]| -> Vec<f32> {
        let columns = rays[0].start - tier.window[0].start..rays[0].end - tier.window[0].start;
        rays[1].clone().flat_map(|j| &values[(j - tier.window[1].start) * width..][columns.clone()]).copied().collect()
    };
    let entries = tier.entries.as_deref().map_or_else(Vec::new, moved);
    Handed { tier: number, depths: moved(&tier.depths), entries, rays }
}

/// The depths of a brick's voxels, z × y × x, while planes across any axis are written into them.
struct BrickDepths {
    values: Vec<f32>,
    /// One plane, v × u.
    plane: Vec<f32>,
    /// The first voxels along u, v, w, voxels along u, and values from one to the next along u, v, w.
    first: [usize; 3],
    width: usize,
    strides: [usize; 3],
}

impl BrickDepths {
    fn new(relay: &Relay, frustum: &Frustum, place: [usize; 3]) -> Self {
        let voxels = relay.partition.voxels(place);
        let strides = [1, voxels[0].len(), voxels[0].len() * voxels[1].len()];
        let [u, v, _] = frustum.axes.map(|axis| voxels[axis].len());
        Self {
            values: vec![f32::NAN; voxels.iter().map(|range| range.len()).product()],
            plane: vec![0.0; u * v],
            first: frustum.axes.map(|axis| voxels[axis].start),
            width: u,
            strides: frustum.axes.map(|axis| strides[axis]),
        }
    }

    /// Writes the voxels of a plane that are covered.
    fn write(&mut self, plane: usize, [columns, rows]: &[Range<usize>; 2]) {
        let ([u, v, w], [du, dv, dw]) = (self.first, self.strides);
        for y in rows.clone() {
            for x in columns.clone() {
                self.values[(x - u) * du + (y - v) * dv + (plane - w) * dw] = self.plane[(y - v) * self.width + (x - u)];
            }
        }
    }
}

#[cfg(test)]
mod tests;
