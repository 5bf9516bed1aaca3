//! A plan as a shader reads it: flat tables, beside the shape that is printed into the source.
//!
//! Places are seen from the middle of the occupied box, so that f32 is finest where the light is. Channels are stored
//! in f16 as parts of the largest value of each, four to a texture. What all rays ask for at every step stands first,
//! phase tables stand last: an edit of a spectrum that needs no other number of terms changes numbers, not the shape.

use barnard::plan::HALF;
use barnard::plan::star_depths::OPAQUE;
use barnard::plan::{Plan, Weights, weights_of};
use barnard::volume::{Channel, Volume};
use glam::DVec3;

use crate::error::{GpuError, Result};
use crate::forms::{Contents, cumulants, extinctions};
use crate::frame::{FrameConstants, four};
use crate::shape::ShaderShape;
use crate::tables::{Offsets, Quad, Tables};

/// The largest stored value: f16 then holds what is a hundred million times less with as many digits.
const LARGEST: f32 = 32768.0;

/// The channels of all volumes from number `first` on, four at a time.
pub fn quads(plan: &Plan, first: usize) -> Vec<Quad> {
    let volume_rows = |(volume, v): (usize, &Volume)| {
        let unit = |first: usize| {
            let mut unit: [f32; 4] = std::array::from_fn(|i| if first + i < v.channels.len() { v.largest(first + i) } else { 0.0 });
            // Depths may change on the device.
            for (unit, channel) in unit.iter_mut().zip(&v.channels[first..]) {
                if let Channel::StarDepth(_) = channel {
                    *unit = OPAQUE as f32;
                }
            }
            unit.map(|largest| largest / LARGEST)
        };
        (0..v.channels.len()).step_by(4).map(|first| Quad { volume, first, unit: unit(first) }).collect::<Vec<_>>()
    };
    plan.volumes().enumerate().skip(first).flat_map(volume_rows).collect()
}

/// Everything that a shader reads, but the volumes' values.
#[derive(Debug)]
pub struct ShaderLayout {
    pub shape: ShaderShape,
    pub frame: FrameConstants,
    pub tables: Vec<[f32; 4]>,
    /// The quads at which sections of the tables start.
    pub offsets: Offsets,
    /// The empty edges around each brick, and lists of the many lights behind them.
    pub bricks: Vec<u32>,
    /// The number of distances.
    pub distances: usize,
    pub quads: Vec<Quad>,
    /// Rays along each side of a pixel.
    pub supersampling: usize,
    /// The star of each scatterer.
    pub stars: Vec<usize>,
    /// The middle of the scene, from which places are seen [pc].
    pub middle: DVec3,
    /// The largest relative error of what textures hold: that of the plan's volumes, and their own.
    pub storage: f64,
}

impl ShaderLayout {
    /// The layout of a plan; `quads` are those of its volumes. Dust that is noise is evaluated `on_the_fly`, or read as
    /// it was sampled.
    ///
    /// # Errors
    /// For methods that no shader has, and dust that is no noise.
    pub fn new(plan: &Plan, quads: Vec<Quad>, on_the_fly: bool) -> Result<Self> {
        if on_the_fly && plan.space().cloud.is_none() {
            return Err(GpuError::NoCloud);
        }
        let weights = Weights::new(plan);
        let middle = plan.space().occupied.map_or(DVec3::ZERO, |b| 0.5 * (b.low + b.high));
        let volumes: Vec<&Volume> = plan.volumes().collect();
        let mut shape = ShaderShape::of(plan, &weights, &quads, &volumes, on_the_fly)?;
        shape.check(plan)?;
        let mut tables = Tables::new(middle);
        let largest = plan.largest_densities();
        let k = extinctions(plan);
        tables.extinction(&k, shape.room);
        tables.begin("STARS");
        weights.scattered.iter().for_each(|s| tables.place(plan.space().stars[s.star], 0.0));
        tables.begin("EMITTED");
        weights.emitted.iter().for_each(|e| tables.list.0.push([e.total, 0.0, 0.0, 0.0]));
        tables.weights(plan, &weights, &largest, shape.room);
        tables.cloud(plan);
        tables.detail(plan);
        tables.places(plan, &quads, &volumes);
        let mut bricks = Tables::distances(plan);
        let distances = bricks.len();
        tables.paging(&quads, &volumes, &mut bricks);
        let heads = tables.reserve("HEADS", shape.heads());
        let field_head = tables.reserve("FIELD_HEAD", 1);
        shape.constants = tables.list.0.len();
        tables.scattered(plan, shape.room);
        tables.many_lights(plan, &weights, shape.room, &mut bricks);
        // What forms have stands behind, as long as it may be: heads say where.
        let mut contents = Contents::new(shape.heads(), tables.list.0.len());
        (shape.form.fill)(plan, &lights(&weights), &mut contents)?;
        let corner = plan.light_field().map_or([0.0; 4], |f| contents.coordinates(&f.propagation.projection));
        tables.put(heads, &contents.heads);
        tables.put(field_head, &[corner]);
        let offsets = tables.offsets();
        tables.list.0.extend(contents.tables.0);
        let phase_start = tables.list.0.len();
        let phase = &plan.spectral().phase;
        if let Some(phase) = phase {
            let of_stars = weights.scattered.iter().map(|s| &phase.weights[s.light]);
            let rows = of_stars.chain([&phase.at_nodes]).flat_map(|values| shape.phase_rows(values));
            tables.list.numbers(&rows.collect::<Vec<f32>>(), 0);
        }
        let entries = phase.as_ref().map_or(2, |p| p.entries);
        let counts = [plan.spectral().terms(), entries, phase_start, plan.star_march().unwrap_or(0)].map(|n| n as u32);
        let stars = weights.scattered.iter().map(|s| s.star).collect();
        let brightest = if shape.dust.is_some() { largest[0] } else { 0.0 };
        let mut frame = FrameConstants::new(plan, shape.shown_turns(plan), middle, &k, brightest, counts);
        if !shape.form.bounded {
            // No depth is asked for what lies behind it.
            frame.limits[0] = 0.0;
        }
        let (tables, supersampling) = (tables.list.0, plan.camera().supersampling);
        Ok(Self { shape, frame, tables, offsets, bricks, distances, quads, supersampling, stars, middle, storage: HALF + plan.storage() })
    }

    /// Puts a star at another place.
    pub fn place_star(&mut self, star: usize, place: DVec3) {
        let first = self.offsets.of("STARS");
        for i in self.stars.iter().enumerate().filter(|(_, s)| **s == star).map(|(i, _)| i) {
            self.tables[first + i] = four(place - self.middle, 0.0);
        }
    }
}

impl Tables {
    /// Extinction k at the nodes, and what series of exp(−k τ) take of it.
    fn extinction(&mut self, k: &[f32], room: usize) {
        self.begin("EXTINCTION");
        self.list.numbers(k, room / 4);
        for (section, power) in ["EXPONENTS", "SQUARES", "FOURTHS"].into_iter().zip(0..) {
            self.begin(section);
            self.list.numbers(&k.iter().map(|k| cumulants(*k)[power]).collect::<Vec<f32>>(), room / 4);
        }
    }

    /// Weights of all lights, and the most that each can send; `largest` are the largest densities of all grids.
    fn weights(&mut self, plan: &Plan, weights: &Weights, largest: &[f32], room: usize) {
        let species = largest.len() - plan.space().species();
        let behind = weights.background.map_or(Vec::new(), |light| weights_of(plan, light));
        let (scattered, emitted) = (|| weights.scattered.iter(), || weights.emitted.iter());
        self.begin("WEIGHTS");
        let rows = scattered().map(|s| s.weights.clone()).chain(emitted().map(|e| e.weights.clone())).chain([behind.clone()]);
        rows.for_each(|row| self.list.numbers(&row, room / 4));
        self.begin("BRIGHTEST");
        let glow = emitted().map(|e| e.weights.iter().map(|w| w * largest[species + e.species]).collect::<Vec<f32>>());
        let rows = scattered().map(|s| s.brightest.clone()).chain(glow).chain([behind]);
        rows.for_each(|row| self.list.numbers(&row, room / 4));
    }

    /// The light field of many stars, and the largest of light that was scattered before.
    fn scattered(&mut self, plan: &Plan, room: usize) {
        let field = plan.light_field();
        let single = |values: &mut dyn Iterator<Item = &f64>| values.map(|v| *v as f32).collect::<Vec<f32>>();
        self.begin("FIELD_PRODUCTS");
        field.iter().for_each(|f| self.list.numbers(&single(&mut f.propagation.products.iter()), 0));
        self.begin("FIELD_RESOLUTION");
        field.iter().for_each(|f| self.list.numbers(&single(&mut f.resolution.iter().flatten()), 0));
        self.begin("SCATTERED_LARGEST");
        plan.scattered_field().iter().for_each(|f| self.list.numbers(&f.largest, room / 4));
    }

    /// Writes where volumes, boxes and bricks are, and the kinds of voxels.
    fn places(&mut self, plan: &Plan, quads: &[Quad], volumes: &[&Volume]) {
        self.begin("LATTICES");
        for quad in quads {
            self.lattice(volumes[quad.volume], quad);
        }
        if quads.is_empty() {
            self.list.0.extend([[0.0; 4]; 5]);
        }
        self.begin("INNER_BOXES");
        for bounds in plan.space().inner_boxes() {
            self.place(bounds.low, 0.0);
            self.place(bounds.high, 0.0);
        }
        self.bricks(plan);
        self.begin("VOXELS");
        plan.space().voxels().iter().for_each(|voxel| self.list.0.push(four(voxel.recip(), 0.0)));
    }
}

/// The plan's numbers of the lights, in the order of [`ShaderShape::lights`].
fn lights(weights: &Weights) -> Vec<usize> {
    let (scattered, emitted) = (weights.scattered.iter().map(|s| s.light), weights.emitted.iter().map(|e| e.light));
    scattered.chain(emitted).chain(weights.background).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{parsed, plan_of, scene, text};
    use crate::resources::tuned;
    use crate::tuning::Tuning;

    /// What the tuning leaves out is left out of the tables: no brick is known to be empty, and no depth is deep enough
    /// to end at.
    #[test]
    fn tuning_is_heard() {
        let plan = plan_of(&scene(128, ""));
        let by = |tuning| tuned(ShaderLayout::new(&plan, quads(&plan, 0), false).unwrap(), tuning);
        let usual = by(Tuning::default());
        assert!(usual.bricks.iter().any(|b| *b > 0) && usual.frame.limits[0] > 0.0);
        assert!(by(Tuning { skip_empty: false, ..Tuning::default() }).bricks.iter().all(|b| *b == 0));
        assert_eq!(by(Tuning { end_early: false, ..Tuning::default() }).frame.limits[0], 0.0);
    }

    /// Edits of spectra, phase angle, steps and camera are numbers: the shape, and with it the pipeline, stays. Another
    /// method, another number of terms or another star is another shape.
    #[test]
    fn edits_of_spectra_keep_the_shape() {
        let shape = |method: &str, from: &str, to: &str| {
            let before = text(24, method);
            assert!(before.contains(from), "{from}");
            let plan = plan_of(&parsed(before.replacen(from, to, 1)));
            ShaderLayout::new(&plan, quads(&plan, 0), false).unwrap().shape
        };
        let usual = shape("", "", "");
        let edits = [
            ("", "9000 K", "30000 K"),
            ("", "100 Lsun", "1 Lsun"),
            ("", "albedo = 0.6", "albedo = 0.2"),
            ("", "g = 0.6", "g = 0.85"),
            ("", "8000 K", "12000 K"),
            ("", "field_of_view = \"40 deg\"", "field_of_view = \"10 deg\""),
        ];
        for (method, from, to) in edits {
            assert_eq!(shape(method, from, to), usual, "{method} {to}");
        }
        assert_ne!(shape("name = \"lookup\"", "", ""), usual);
        assert_ne!(shape("accuracy = 1e-5", "", ""), usual);
        assert_ne!(shape("count = 30", "", ""), usual);
    }
}
