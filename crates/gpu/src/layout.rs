//! A plan as a shader reads it: flat tables, the frame, and the shape that is printed into the source.
//!
//! Places are seen from the middle of the occupied box, so that f32 is finest where the light is. Channels are stored in f16 as parts of the largest value of
//! each, four to a texture.

use barnard::camera::{Camera, Projection};
use barnard::plan::{Channel, END_SHARE, Plan, Stepping, Volume, Weights};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use spectra::rule::Form;

use crate::error::{GpuError, Result};

/// What changes from picture to picture; the fields are those of `frame.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Frame {
    pub middle: [f32; 4],
    pub across: [f32; 4],
    pub upwards: [f32; 4],
    pub forward: [f32; 4],
    pub turn_x: [f32; 4],
    pub turn_y: [f32; 4],
    pub low: [f32; 4],
    pub high: [f32; 4],
    pub steps: [f32; 4],
    pub limits: [f32; 4],
    pub size: [u32; 4],
    pub strip: [u32; 4],
}

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

/// What a shader is made for; a change of these makes another one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    pub quads: usize,
    pub terms: usize,
    pub bands: usize,
    pub scatterers: usize,
    pub emitters: usize,
    pub inner: usize,
    pub brick_grids: usize,
    pub phase: PhaseKind,
    pub phase_entries: usize,
    /// The quad and channel of dust.
    pub dust: Option<(usize, usize)>,
    pub background: bool,
}

/// Where tables start, in quads of numbers.
#[derive(Debug, Clone, Copy)]
pub struct Offsets {
    pub extinction: usize,
    pub band_of: usize,
    pub background: usize,
    pub stars: usize,
    pub emitter_slots: usize,
    pub weights: usize,
    pub brightest: usize,
    pub lattices: usize,
    pub inner_boxes: usize,
    pub brick_table: usize,
    pub phase: usize,
}

impl Shape {
    /// Terms, four at a time.
    pub fn term_quads(&self) -> usize {
        self.terms.div_ceil(4).max(1)
    }

    /// Where tables start.
    pub fn offsets(&self) -> Offsets {
        let (n, lights) = (self.term_quads(), self.scatterers + self.emitters);
        let sizes = [n, n, n, self.scatterers, self.emitters, lights * n, lights * n, 5 * self.quads, 2 * self.inner, 3 * self.brick_grids];
        let mut starts = [0; 11];
        for (i, size) in sizes.iter().enumerate() {
            starts[i + 1] = starts[i] + size;
        }
        let [extinction, band_of, background, stars, emitter_slots, weights, brightest, lattices, inner_boxes, brick_table, phase] = starts;
        Offsets { extinction, band_of, background, stars, emitter_slots, weights, brightest, lattices, inner_boxes, brick_table, phase }
    }
}

/// Four channels of a volume.
#[derive(Debug, Clone, Copy)]
pub struct Quad {
    /// The volume's number.
    pub volume: usize,
    /// Its first channel here.
    pub first: usize,
    /// The largest value of each channel.
    pub unit: [f32; 4],
}

/// All that a shader reads, but the volumes' values.
#[derive(Debug)]
pub struct Layout {
    pub shape: Shape,
    pub frame: Frame,
    pub tables: Vec<[f32; 4]>,
    pub bricks: Vec<u32>,
    pub quads: Vec<Quad>,
}

impl Layout {
    /// Of a plan whose method is one of exponentials; `quads` are those of its volumes.
    pub fn new(plan: &Plan, quads: Vec<Quad>) -> Result<Self> {
        let k = exponents(plan)?;
        let weights = Weights::new(plan);
        let middle = plan.space.occupied.map_or(DVec3::ZERO, |b| 0.5 * (b.low + b.high));
        let volumes: Vec<&Volume> = plan.volumes().collect();
        let slot_of = |channel: Channel| {
            let at = |(q, quad): (usize, &Quad)| {
                let lane = volumes[quad.volume].channels.iter().skip(quad.first).take(4).position(|c| *c == channel);
                lane.map(|lane| 4 * q + lane)
            };
            quads.iter().enumerate().find_map(at)
        };
        let phase = &plan.spectral.phase;
        let shape = Shape {
            quads: quads.len().max(1),
            terms: k.len(),
            bands: plan.spectral.bands.len(),
            scatterers: weights.scattered.len(),
            emitters: weights.emitted.len(),
            inner: plan.space.inner_boxes().len(),
            brick_grids: plan.space.bricks.len(),
            phase: phase.as_ref().map_or(PhaseKind::Isotropic, |p| if p.separable { PhaseKind::Separable } else { PhaseKind::Spectral }),
            phase_entries: phase.as_ref().map_or(2, |p| p.entries),
            dust: slot_of(Channel::Dust).map(|slot| (slot / 4, slot % 4)),
            background: weights.background.is_some(),
        };
        let mut tables = Tables { list: Vec::new(), middle };
        tables.numbers(&k, shape.term_quads());
        tables.numbers(&weights.band_of.iter().map(|b| *b as f32).collect::<Vec<_>>(), shape.term_quads());
        tables.numbers(&weights.background.map_or(Vec::new(), |light| barnard::plan::weights_of(plan, light)), shape.term_quads());
        for scatterer in &weights.scattered {
            let slot = slot_of(Channel::StarDepth(scatterer.star)).unwrap_or(0);
            tables.place(plan.space.stars[scatterer.star], slot as f32);
        }
        for emitter in &weights.emitted {
            tables.list.push([slot_of(Channel::Emission(emitter.species)).unwrap_or(0) as f32, 0.0, 0.0, 0.0]);
        }
        let scattered = weights.scattered.iter().map(|s| &s.weights);
        for weights in scattered.chain(weights.emitted.iter().map(|e| &e.weights)) {
            tables.numbers(weights, shape.term_quads());
        }
        let largest: Vec<f32> = plan.space.bricks.iter().map(|b| b.largest()).collect();
        let species = largest.len() - plan.space.species();
        for scatterer in &weights.scattered {
            tables.numbers(&scatterer.brightest, shape.term_quads());
        }
        for emitter in &weights.emitted {
            let brightest: Vec<f32> = emitter.weights.iter().map(|w| w * largest[species + emitter.species]).collect();
            tables.numbers(&brightest, shape.term_quads());
        }
        for quad in &quads {
            tables.lattice(volumes[quad.volume], quad);
        }
        if quads.is_empty() {
            tables.list.extend([[0.0; 4]; 5]);
        }
        for bounds in plan.space.inner_boxes() {
            tables.place(bounds.low, 0.0);
            tables.place(bounds.high, 0.0);
        }
        let bricks = tables.bricks(plan);
        if let Some(phase) = phase {
            debug_assert_eq!(tables.list.len(), shape.offsets().phase);
            let of = weights.scattered.iter().map(|s| &phase.weights[s.light]);
            match shape.phase {
                PhaseKind::Separable => tables.numbers(&of.flatten().copied().collect::<Vec<_>>(), 0),
                _ => of.for_each(|list| list.chunks(shape.terms).for_each(|entry| tables.numbers(entry, shape.term_quads()))),
            }
        }
        let frame = frame(plan, middle, &k, if shape.dust.is_some() { largest[0] } else { 0.0 });
        Ok(Self { shape, frame, tables: tables.list, bricks, quads })
    }

    /// The frame for some rows of the image.
    pub fn strip(&self, first: usize, rows: usize) -> Frame {
        Frame { strip: [first as u32, rows as u32, 0, 0], ..self.frame }
    }
}

/// k of each term.
pub fn exponents(plan: &Plan) -> Result<Vec<f32>> {
    if plan.star_march.is_some() || plan.light_field.is_some() {
        return Err(GpuError::Method(plan.spectral.method.into()));
    }
    let of_band = |form: &Form| match form {
        Form::Nodes(nodes) => Ok(nodes.nodes.iter().map(|n| n.k as f32).collect::<Vec<f32>>()),
        _ => Err(GpuError::Method(plan.spectral.method.into())),
    };
    Ok(plan.spectral.bands.iter().map(|b| of_band(&b.rule.form)).collect::<Result<Vec<_>>>()?.concat())
}

/// The channels of all volumes, four at a time.
pub fn quads(plan: &Plan) -> Vec<Quad> {
    let of = |(volume, v): (usize, &Volume)| {
        let unit = |first: usize| {
            let mut unit = [0.0f32; 4];
            for row in v.data.chunks_exact(v.channels.len()) {
                row.iter().skip(first).zip(&mut unit).for_each(|(value, unit)| *unit = unit.max(value.abs()));
            }
            unit
        };
        (0..v.channels.len()).step_by(4).map(|first| Quad { volume, first, unit: unit(first) }).collect::<Vec<_>>()
    };
    plan.volumes().enumerate().flat_map(of).collect()
}

/// Quads of numbers in the order of [`Offsets`].
struct Tables {
    list: Vec<[f32; 4]>,
    middle: DVec3,
}

impl Tables {
    /// Numbers in a row, filled up with zeros to at least so many quads.
    fn numbers(&mut self, numbers: &[f32], least: usize) {
        let quads = numbers.len().div_ceil(4).max(least);
        let at = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
        self.list.extend((0..quads).map(|q| std::array::from_fn(|i| at(4 * q + i))));
    }

    /// A place, and one number more.
    fn place(&mut self, p: DVec3, fourth: f32) {
        self.list.push(four(p - self.middle, fourth));
    }

    fn lattice(&mut self, volume: &Volume, quad: &Quad) {
        let size = volume.lattice.bounds.size();
        self.list.push(four(size.recip(), 0.0));
        self.list.push(four((self.middle - volume.lattice.bounds.low) / size, 0.0));
        self.list.push(quad.unit);
        self.place(volume.inner.bounds.low, 0.0);
        self.place(volume.inner.bounds.high, 0.0);
    }

    /// The grids of bricks, and how far from each the next light is.
    fn bricks(&mut self, plan: &Plan) -> Vec<u32> {
        let mut distances = Vec::new();
        for bricks in &plan.space.bricks {
            let lattice = &bricks.lattice;
            let edge = lattice.voxel_pc();
            self.place(lattice.bounds.low, edge.min_element() as f32);
            self.list.push(four(edge.recip(), 0.0));
            let [x, y, z] = lattice.dims.map(|n| n as f32);
            self.list.push([x, y, z, distances.len() as f32]);
            distances.extend((0..lattice.cells()).map(|i| bricks.clear(lattice.place(i)) as u32));
        }
        distances.resize(distances.len().max(1), 0);
        distances
    }
}

fn four(p: DVec3, fourth: f32) -> [f32; 4] {
    [p.x as f32, p.y as f32, p.z as f32, fourth]
}

fn frame(plan: &Plan, middle: DVec3, k: &[f32], brightest: f32) -> Frame {
    let camera: &Camera = &plan.camera;
    let bounds = plan.space.occupied.unwrap_or(barnard::geometry::Bounds { low: middle, high: middle });
    // The observer moves along the view until the middle of the scene is beside them.
    let ahead = (middle - camera.position).dot(camera.forward).max(0.0);
    let start = camera.position + ahead * camera.forward - middle;
    let (right, up) = (camera.right, camera.up);
    let (across, upwards, turn_x, turn_y) = match camera.projection {
        Projection::Perspective { half_width: h } => (ahead * h * right, ahead * h * up, h * right, h * up),
        Projection::Orthographic { half_width_pc: h } => (h * right, h * up, DVec3::ZERO, DVec3::ZERO),
    };
    let voxel = plan.space.voxel_pc();
    let (per_pc, fixed) = match plan.stepping {
        Stepping::PerVoxel(n) => (n / voxel, 0.0),
        Stepping::Fixed(n) => (0.0, n as f64),
    };
    let smallest = k.iter().copied().fold(f32::MAX, f32::min);
    let angle = plan.spectral.phase_angle.min(10.0);
    Frame {
        middle: four(start, ahead as f32),
        across: four(across, 0.0),
        upwards: four(upwards, 0.0),
        forward: four(camera.forward, 0.0),
        turn_x: four(turn_x, 0.0),
        turn_y: four(turn_y, 0.0),
        low: four(bounds.low - middle, 0.0),
        high: four(bounds.high - middle, 0.0),
        steps: [per_pc as f32, fixed as f32, voxel as f32, angle as f32],
        limits: [smallest, END_SHARE * plan.spectral.accuracy as f32, brightest, 0.0],
        size: [camera.width as u32, camera.height as u32, camera.supersampling as u32, 0],
        strip: [0; 4],
    }
}
