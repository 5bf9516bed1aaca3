//! A plan as a shader reads it: flat tables, and the shape that is printed into the source.
//!
//! Places are seen from the middle of the occupied box, so that f32 is finest where the light is. Channels are stored
//! in f16 as parts of the largest value of each, four to a texture. Terms have room to grow, and phase tables stand
//! last: an edit of a spectrum changes numbers, not the shape.

use barnard::plan::star_depths::OPAQUE;
use barnard::plan::{Plan, Weights, weights_of};
use barnard::volume::{Channel, Volume};
use glam::DVec3;

use crate::error::{GpuError, Result};
use crate::forms::{Contents, FormEntry, Heads, extinctions, form};
use crate::frame::{Frame, four};
use crate::many_lights;
use crate::tables::{QuadList, Tables};

/// How scattered light is spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PhaseKind {
    /// Evenly.
    Isotropic,
    /// By one function for all wavelengths.
    Separable,
    /// By one for each term.
    Spectral,
}

/// Elements and polynomials of a light field, and the quad of its first channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldShape {
    pub elements: usize,
    pub polynomials: usize,
    pub quad: usize,
}

/// What a shader is made for; a change of these makes another one.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    pub form: &'static FormEntry,
    pub quads: usize,
    /// Room for so many terms.
    pub room: usize,
    pub bands: usize,
    pub scatterers: usize,
    pub emitters: usize,
    pub inner: usize,
    pub brick_grids: usize,
    /// Kinds of voxels of the plan's grids.
    pub voxels: usize,
    pub phase: PhaseKind,
    /// The quad and channel of dust.
    pub dust: Option<(usize, usize)>,
    pub background: bool,
    pub field: Option<FieldShape>,
    /// The quad of the first term of the field of scattered light.
    pub scattered_field: Option<usize>,
    /// Gathered stars.
    pub many_lights: usize,
    /// Whether star depths are marched again at every sample.
    pub star_march: bool,
    /// Whether dust is noise that is evaluated at every sample.
    pub cloud: bool,
}

/// Where tables start, in quads of numbers.
#[derive(Debug, Clone, Copy)]
pub struct Offsets {
    pub extinction: usize,
    pub band_ranges: usize,
    pub stars: usize,
    pub emitter_slots: usize,
    pub weights: usize,
    pub brightest: usize,
    pub heads: usize,
    pub field_head: usize,
    pub field_products: usize,
    pub field_resolution: usize,
    pub diffuse_largest: usize,
    pub crowd_head: usize,
    pub crowd_stars: usize,
    pub cloud: usize,
    pub lattices: usize,
    pub inner_boxes: usize,
    pub brick_table: usize,
    pub voxels: usize,
    /// What forms have, and phase tables behind that.
    pub contents: usize,
}

/// Room for so many terms: a power of two, so that an edit seldom leaves it.
pub fn room(terms: usize) -> usize {
    terms.next_power_of_two().max(32)
}

impl Shape {
    /// Scatterers, emitters and the background, in this order.
    pub fn lights(&self) -> usize {
        self.scatterers + self.emitters + 1
    }

    /// Heads of tables.
    pub fn heads(&self) -> usize {
        match self.form.heads {
            Heads::Bands => self.bands,
            Heads::LightsAndBands => self.lights() * self.bands,
            Heads::LightsAndTerms => self.lights() * self.room,
        }
    }

    /// Numbers that a ray carries of the light field.
    pub fn field_channels(&self) -> usize {
        self.field.map_or(0, |f| f.elements * f.polynomials)
    }

    /// Where tables start.
    pub fn offsets(&self) -> Offsets {
        let rows = self.room / 4;
        let products = self.field.map_or(0, |f| f.elements.pow(3).div_ceil(4));
        let mut next = 0;
        let mut take = |size: usize| {
            next += size;
            next - size
        };
        Offsets {
            extinction: take(rows),
            band_ranges: take(self.bands),
            stars: take(self.scatterers),
            emitter_slots: take(self.emitters),
            weights: take(self.lights() * rows),
            brightest: take(self.lights() * rows),
            heads: take(self.heads()),
            field_head: take(usize::from(self.field.is_some())),
            field_products: take(products),
            field_resolution: take((self.bands * self.field_channels()).div_ceil(4)),
            diffuse_largest: take(if self.scattered_field.is_some() { rows } else { 0 }),
            crowd_head: take(if self.many_lights > 0 { many_lights::HEAD } else { 0 }),
            crowd_stars: take(self.many_lights * (many_lights::STAR + rows)),
            cloud: take(3),
            lattices: take(5 * self.quads),
            inner_boxes: take(2 * self.inner),
            brick_table: take(3 * self.brick_grids),
            voxels: take(self.voxels),
            contents: take(0),
        }
    }
}

/// Four channels of a volume.
#[derive(Debug, Clone, Copy)]
pub struct Quad {
    /// The volume's number.
    pub volume: usize,
    /// Its first channel here.
    pub first: usize,
    /// What a stored one stands for, channel by channel.
    pub unit: [f32; 4],
}

/// The largest stored value: f16 then holds what is a hundred million times less with as many digits.
const LARGEST: f32 = 32768.0;

/// The channels of all volumes from number `first` on, four at a time.
pub fn quads(plan: &Plan, first: usize) -> Vec<Quad> {
    let of = |(volume, v): (usize, &Volume)| {
        let unit = |first: usize| {
            let mut unit = [0.0f32; 4];
            for row in v.data.chunks_exact(v.channels.len()) {
                row.iter().skip(first).zip(&mut unit).for_each(|(value, unit)| *unit = unit.max(value.abs()));
            }
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
    plan.volumes().enumerate().skip(first).flat_map(of).collect()
}

/// All that a shader reads, but the volumes' values.
#[derive(Debug)]
pub struct Layout {
    pub shape: Shape,
    pub frame: Frame,
    pub tables: Vec<[f32; 4]>,
    /// Distances of bricks to the next light, and lists of the many lights behind them.
    pub bricks: Vec<u32>,
    /// How many distances there are.
    pub distances: usize,
    pub quads: Vec<Quad>,
    /// Rays along each side of a pixel.
    pub supersampling: usize,
    /// The star of each scatterer.
    pub stars: Vec<usize>,
    /// The middle of the scene, from which places are seen [pc].
    pub middle: DVec3,
}

impl Layout {
    /// Of a plan; `quads` are those of its volumes. Dust that is noise is evaluated `on_the_fly`, or read as it was
    /// sampled.
    ///
    /// # Errors
    /// For methods that no shader has, and dust that is no noise.
    pub fn new(plan: &Plan, quads: Vec<Quad>, on_the_fly: bool) -> Result<Self> {
        if on_the_fly && plan.space().cloud.is_none() {
            return Err(GpuError::NoCloud);
        }
        let form = form(plan)?;
        let weights = Weights::new(plan);
        let middle = plan.space().occupied.map_or(DVec3::ZERO, |b| 0.5 * (b.low + b.high));
        let volumes: Vec<&Volume> = plan.volumes().collect();
        let slot_of = |channel| slot_of(&quads, &volumes, channel);
        let number_of = |channel| slot_of(channel).map_or(0, |(quad, lane)| 4 * quad + lane) as f32;
        let phase = &plan.spectral().phase;
        let field = plan.light_field();
        let shape = Shape {
            form,
            quads: quads.len().max(1),
            room: room(plan.spectral().terms()),
            bands: plan.spectral().bands.len(),
            scatterers: weights.scattered.len(),
            emitters: weights.emitted.len(),
            inner: plan.space().inner_boxes().len(),
            brick_grids: plan.space().bricks.len(),
            voxels: plan.space().voxels().len(),
            phase: phase.as_ref().map_or(PhaseKind::Isotropic, |p| if p.separable { PhaseKind::Separable } else { PhaseKind::Spectral }),
            dust: slot_of(Channel::Dust),
            background: weights.background.is_some(),
            field: field.map(|f| FieldShape {
                elements: f.propagation.projection.basis.size(),
                polynomials: f.propagation.span.len(),
                quad: slot_of(Channel::Light(0)).map_or(0, |(quad, _)| quad),
            }),
            scattered_field: slot_of(Channel::MultipleScattering(0)).map(|(quad, _)| quad),
            many_lights: many_lights::of(plan).map_or(0, |_| weights.many_lights.len()),
            star_march: plan.star_march().is_some(),
            cloud: on_the_fly,
        };
        let offsets = shape.offsets();
        let lights: Vec<usize> = lights(&weights);
        let mut contents = Contents::new(shape.heads(), offsets.contents);
        (form.fill)(plan, &lights, &mut contents)?;
        let field_head = field.map(|f| contents.coordinates(&f.propagation.projection));

        let mut tables = Tables { list: QuadList::default(), middle };
        let k = extinctions(plan);
        tables.list.numbers(&k, shape.room / 4);
        let mut first = 0.0;
        for band in &plan.spectral().bands {
            let end = first + band.terms() as f32;
            tables.list.0.push([first, end, 0.0, 0.0]);
            first = end;
        }
        for scatterer in &weights.scattered {
            tables.place(plan.space().stars[scatterer.star], number_of(Channel::StarDepth(scatterer.star)));
        }
        for emitter in &weights.emitted {
            tables.list.0.push([number_of(Channel::Emission(emitter.species)), 0.0, 0.0, 0.0]);
        }
        let largest: Vec<f32> = plan.space().bricks.iter().map(|b| b.largest()).collect();
        let species = largest.len() - plan.space().species();
        let behind = weights.background.map_or(Vec::new(), |light| weights_of(plan, light));
        let scattered = || weights.scattered.iter();
        let rows = scattered().map(|s| s.weights.clone()).chain(weights.emitted.iter().map(|e| e.weights.clone())).chain([behind.clone()]);
        rows.for_each(|row| tables.list.numbers(&row, shape.room / 4));
        let emitted = weights.emitted.iter().map(|e| e.weights.iter().map(|w| w * largest[species + e.species]).collect::<Vec<f32>>());
        let rows = scattered().map(|s| s.brightest.clone()).chain(emitted).chain([behind]);
        rows.for_each(|row| tables.list.numbers(&row, shape.room / 4));
        tables.list.0.extend(&contents.heads);
        tables.list.0.extend(field_head);
        if let Some(field) = field {
            let single = |values: &mut dyn Iterator<Item = &f64>| values.map(|v| *v as f32).collect::<Vec<f32>>();
            tables.list.numbers(&single(&mut field.propagation.products.iter()), 0);
            tables.list.numbers(&single(&mut field.resolution.iter().flatten()), 0);
        }
        if let Some(scattered_field) = &plan.scattered_field() {
            tables.list.numbers(&scattered_field.largest, shape.room / 4);
        }
        let mut bricks = Tables::distances(plan);
        let distances = bricks.len();
        tables.many_lights(plan, &weights, shape.room, &mut bricks);
        tables.cloud(plan);
        for quad in &quads {
            tables.lattice(volumes[quad.volume], quad);
        }
        if quads.is_empty() {
            tables.list.0.extend([[0.0; 4]; 5]);
        }
        for bounds in plan.space().inner_boxes() {
            tables.place(bounds.low, 0.0);
            tables.place(bounds.high, 0.0);
        }
        tables.bricks(plan);
        plan.space().voxels().iter().for_each(|voxel| tables.list.0.push(four(voxel.recip(), 0.0)));
        debug_assert_eq!(tables.list.0.len(), offsets.contents);
        tables.list.0.extend(contents.tables.0);
        let phase_start = 4 * tables.list.0.len();
        if let Some(phase) = phase {
            let of_stars = scattered().flat_map(|s| &phase.weights[s.light]);
            tables.list.numbers(&of_stars.chain(&phase.at_nodes).copied().collect::<Vec<f32>>(), 0);
        }
        let entries = phase.as_ref().map_or(2, |p| p.entries);
        let counts = [plan.spectral().terms(), entries, phase_start, plan.star_march().unwrap_or(0)].map(|n| n as u32);
        let stars = scattered().map(|s| s.star).collect();
        let mut frame = Frame::new(plan, middle, &k, if shape.dust.is_some() { largest[0] } else { 0.0 }, counts);
        if !form.bounded {
            // No depth is asked for what lies behind it.
            frame.limits[0] = 0.0;
        }
        Ok(Self {
            shape,
            frame,
            tables: tables.list.0,
            bricks,
            distances,
            quads,
            supersampling: plan.camera().supersampling,
            stars,
            middle,
        })
    }

    /// Puts a star elsewhere.
    pub fn place_star(&mut self, star: usize, place: DVec3) {
        let first = self.shape.offsets().stars;
        for i in self.stars.iter().enumerate().filter(|(_, s)| **s == star).map(|(i, _)| i) {
            let slot = self.tables[first + i][3];
            self.tables[first + i] = four(place - self.middle, slot);
        }
    }
}

/// The quad that holds a channel, and which of its four it is.
pub fn slot_of(quads: &[Quad], volumes: &[&Volume], channel: Channel) -> Option<(usize, usize)> {
    let lane = |quad: &Quad| volumes[quad.volume].channels.iter().skip(quad.first).take(4).position(|c| *c == channel);
    quads.iter().enumerate().find_map(|(q, quad)| lane(quad).map(|lane| (q, lane)))
}

/// The plan's numbers of the lights, in the order of [`Shape::lights`].
fn lights(weights: &Weights) -> Vec<usize> {
    let (scattered, emitted) = (weights.scattered.iter().map(|s| s.light), weights.emitted.iter().map(|e| e.light));
    scattered.chain(emitted).chain(weights.background).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::Tuning;
    use crate::resources::tuned;
    use crate::twins::{parsed, plan_of, scene, text};

    /// What the tuning leaves out is left out: no brick is known to be empty, and no depth is deep enough to end at.
    #[test]
    fn tuning_is_heard() {
        let plan = plan_of(&scene(128, ""));
        let by = |tuning| tuned(Layout::new(&plan, quads(&plan, 0), false).unwrap(), tuning);
        let usual = by(Tuning::default());
        assert!(usual.bricks.iter().any(|b| *b > 0) && usual.frame.limits[0] > 0.0);
        assert!(by(Tuning { skip_empty: false, ..Tuning::default() }).bricks.iter().all(|b| *b == 0));
        assert_eq!(by(Tuning { end_early: false, ..Tuning::default() }).frame.limits[0], 0.0);
    }

    /// Edits of spectra, accuracy, phase angle, steps and camera are numbers: the shape, and with it the pipeline,
    /// stays. Another method or another star is another shape.
    #[test]
    fn edits_of_spectra_keep_the_shape() {
        let shape = |method: &str, from: &str, to: &str| {
            let before = text(24, method);
            assert!(before.contains(from), "{from}");
            let plan = plan_of(&parsed(before.replacen(from, to, 1)));
            (Layout::new(&plan, quads(&plan, 0), false).unwrap().shape, plan.spectral().terms())
        };
        let (usual, terms) = shape("", "", "");
        let edits = [
            ("", "9000 K", "30000 K"),
            ("", "100 Lsun", "1 Lsun"),
            ("", "albedo = 0.6", "albedo = 0.2"),
            ("", "g = 0.6", "g = 0.85"),
            ("", "8000 K", "12000 K"),
            ("", "field_of_view = \"40 deg\"", "field_of_view = \"10 deg\""),
            ("accuracy = 1e-5", "", ""),
            ("count = 9", "", ""),
        ];
        let mut most = 0;
        for (method, from, to) in edits {
            let (edited, terms) = shape(method, from, to);
            assert_eq!(edited, usual, "{method} {to}");
            most = most.max(terms);
        }
        assert!(most > 2 * terms);
        assert_ne!(shape("name = \"lookup\"", "", "").0, usual);
        assert_ne!(shape("count = 30", "", "").0, usual);
    }
}
