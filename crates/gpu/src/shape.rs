//! The shape that a shader is made for: what of a plan is printed into its source.

use std::sync::Arc;

use barnard::camera::panorama::PanoramaLayout;
use barnard::camera::{Camera, Projection};
use barnard::plan::{LightField, Plan, Weights};
use barnard::volume::{Channel, Volume};
use spectra::basis::MAX_SIZE;

use crate::error::{GpuError, Result};
use crate::forms::{FormEntry, Heads, form};
use crate::many_lights;
use crate::tables::{Quad, room, slot_of};
use crate::written_out::{MOST_ENTRIES, MOST_TURNS};

/// Most sums of lights at shared nodes that stay in registers, of which a ray has about 250.
const SUMS_IN_REGISTERS: usize = 64;
/// Most sums of lights at shared nodes that a ray may carry beside them: 16 KiB.
const MOST_SUMS: u64 = 4096;
/// Most turns of loops in which a ray may make bands of its sums, half of what software adapters allow.
const MOST_RESOLVED: u64 = 1 << 15;
/// The bytes that WebGPU promises for a uniform buffer.
const UNIFORM_BYTES: usize = 1 << 16;

/// The way in which scattered light is spread over angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PhaseKind {
    /// Light is scattered evenly.
    Isotropic,
    /// One function serves all wavelengths.
    Separable,
    /// Each term has a function of its own.
    Spectral,
}

/// How pixels become rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// The image lies in a plane.
    Plane,
    /// Angles from the middle of a circle.
    Dome,
    /// Longitude and latitude.
    Sphere,
    /// Faces of a cube.
    Cube,
}

impl Sight {
    fn of(camera: &Camera) -> Self {
        match camera.projection {
            Projection::Perspective { .. } | Projection::Orthographic { .. } => Self::Plane,
            Projection::Panorama { layout: PanoramaLayout::Dome { .. }, .. } => Self::Dome,
            Projection::Panorama { layout: PanoramaLayout::Sphere, .. } => Self::Sphere,
            Projection::Panorama { layout: PanoramaLayout::Cube, .. } => Self::Cube,
        }
    }
}

/// Elements and polynomials of a light field, and the quad of its first channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldShape {
    pub elements: usize,
    pub polynomials: usize,
    pub quad: usize,
}

/// The shape that a shader is made for; a change of it makes another shader.
#[derive(Debug, Clone, PartialEq)]
pub struct ShaderShape {
    pub sight: Sight,
    pub form: &'static FormEntry,
    pub quads: usize,
    /// Room for a given number of terms.
    pub room: usize,
    /// The number of terms of each band; where bands share them, all stand first.
    pub terms: Vec<usize>,
    /// True if bands share their terms, and a ray sums each light at each of them.
    pub shared: bool,
    /// Channel offsets of the optical depths of each marched star.
    pub star_slots: Vec<usize>,
    /// Channel offsets of the densities of each gas species.
    pub emitter_slots: Vec<usize>,
    /// Channel offset of the front at which gas ends.
    pub front: Option<usize>,
    /// By species true if it ends at the front.
    pub fronted: Vec<bool>,
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
    /// The number of gathered stars.
    pub many_lights: usize,
    /// True if star depths are marched again at every sample.
    pub star_march: bool,
    /// True if dust is noise that is evaluated at every sample.
    pub cloud: bool,
    /// Octaves of displacement below the voxels.
    pub detail: usize,
    /// True if segments have a sample in their middle.
    pub middles: bool,
    /// Which of the quads are atlases of pages.
    pub paged: Vec<bool>,
    /// The quads at the head of the tables that all rays ask for at every step.
    pub constants: usize,
}

impl ShaderShape {
    /// The shape of a plan whose channels stand in `quads` of its `volumes`.
    pub fn of(plan: &Plan, weights: &Weights, quads: &[Quad], volumes: &[&Volume], on_the_fly: bool) -> Result<Self> {
        let slot_of = |channel| slot_of(quads, volumes, channel);
        let number_of = |channel| slot_of(channel).map_or(0, |(quad, lane)| 4 * quad + lane);
        let phase = plan.spectral().phase.as_ref();
        let mut terms: Vec<usize> = plan.spectral().bands.iter().map(|band| band.terms()).collect();
        let shared = plan.spectral().common_nodes().map(<[_]>::len);
        if let Some(all) = shared {
            terms.fill(0);
            terms[0] = all;
        }
        let field = |f: &Arc<LightField>| FieldShape {
            elements: f.propagation.projection.basis.size(),
            polynomials: f.propagation.span.len(),
            quad: slot_of(Channel::Light(0)).map_or(0, |(quad, _)| quad),
        };
        Ok(Self {
            sight: Sight::of(plan.camera()),
            form: form(plan)?,
            quads: quads.len().max(1),
            room: room(plan.spectral().terms()),
            terms,
            shared: shared.is_some(),
            star_slots: weights.scattered.iter().map(|s| number_of(Channel::StarDepth(s.star))).collect(),
            emitter_slots: weights.emitted.iter().map(|e| number_of(Channel::Emission(e.species))).collect(),
            front: slot_of(Channel::Front).map(|(quad, lane)| 4 * quad + lane),
            fronted: weights.emitted.iter().map(|e| plan.space().gas()[e.species].front().is_some()).collect(),
            inner: plan.space().inner_boxes().len(),
            brick_grids: plan.space().bricks.len(),
            voxels: plan.space().voxels().len(),
            phase: phase.map_or(PhaseKind::Isotropic, |p| if p.separable { PhaseKind::Separable } else { PhaseKind::Spectral }),
            dust: slot_of(Channel::Dust),
            background: weights.background.is_some(),
            field: plan.light_field().map(field),
            scattered_field: slot_of(Channel::MultipleScattering(0)).map(|(quad, _)| quad),
            many_lights: many_lights::fields(plan).map_or(0, |_| weights.many_lights.len()),
            star_march: plan.star_march().is_some(),
            cloud: on_the_fly,
            detail: plan.detail().map_or(0, |detail| detail.octaves.len()),
            middles: plan.stepping().has_middles(),
            paged: quads.iter().map(|quad| !volumes[quad.volume].pages().is_whole()).collect(),
            constants: 0,
        })
    }

    /// The number of lights: scatterers, emitters and the background, in this order.
    pub fn lights(&self) -> usize {
        self.star_slots.len() + self.emitter_slots.len() + 1
    }

    /// Variant without a background where there is none.
    pub fn shining(&self) -> usize {
        self.lights() - usize::from(!self.background)
    }

    /// The number of passbands.
    pub fn bands(&self) -> usize {
        self.terms.len()
    }

    /// The number of sums that a ray carries: one for each band, or for each light and shared term, and then as many as
    /// loops over bands are written out to.
    pub fn sums(&self) -> usize {
        if self.shared { (self.shining() * self.terms[0]).max(self.bands().min(MOST_TURNS)) } else { self.bands() }
    }

    /// Turns by which a loop shows that it turns: more than what a ray takes behind it, to make bands and store them.
    pub fn shown_turns(&self, plan: &Plan) -> usize {
        8 + 4 * (self.bands() + self.sums() + self.field_channels().max(1)) + self.resolving_turns(plan)
    }

    /// Turns of loops in which a ray makes bands of sums at shared terms.
    fn resolving_turns(&self, plan: &Plan) -> usize {
        let taken: usize = plan.spectral().bands.iter().map(|band| band.terms() + 1).sum();
        if self.shared { taken * self.shining() } else { 0 }
    }

    /// Refuses more sums than a ray can carry, or make bands of.
    pub fn check(&self, plan: &Plan) -> Result<()> {
        if !self.shared {
            return Ok(());
        }
        let instead = "use fewer stars or passbands, or render on the processor";
        GpuError::too_large("the number of sums per ray", self.sums() as u64, MOST_SUMS, instead)?;
        let turns = self.resolving_turns(plan) as u64;
        GpuError::too_large("the number of passes over the bands of a ray", turns, MOST_RESOLVED, instead)
    }

    /// True if registers hold all of them, and loops over them are written out.
    pub fn sums_in_registers(&self) -> bool {
        self.shared && self.sums() <= SUMS_IN_REGISTERS && self.terms[0] <= MOST_ENTRIES && self.shining() <= MOST_TURNS
    }

    /// The most coordinates of a basis; what a band has beyond its own terms weighs nothing.
    pub fn elements(&self) -> usize {
        self.terms.iter().copied().max().unwrap_or(0).min(MAX_SIZE)
    }

    /// Values of an entry of a phase table, in whole quads where terms have values of their own.
    pub fn phase_stride(&self) -> usize {
        if self.phase == PhaseKind::Spectral { self.terms.iter().sum::<usize>().next_multiple_of(4) } else { 1 }
    }

    /// A phase table, entry by entry, each filled up to the [stride](Self::phase_stride).
    pub fn phase_rows(&self, values: &[f32]) -> Vec<f32> {
        let (columns, stride) = (if self.phase == PhaseKind::Spectral { self.terms.iter().sum() } else { 1 }, self.phase_stride());
        let rows = values.chunks_exact(columns.max(1));
        rows.flat_map(|row| row.iter().copied().chain(std::iter::repeat_n(0.0, stride - columns))).collect()
    }

    /// True if the constants fit into a uniform buffer of any device.
    pub fn constants_are_uniform(&self) -> bool {
        16 * self.constants <= UNIFORM_BYTES
    }

    /// The number of table heads.
    pub fn heads(&self) -> usize {
        match self.form.heads {
            Heads::Bands => self.bands(),
            Heads::LightsAndBands => self.lights() * self.bands(),
            Heads::LightsAndTerms => self.lights() * self.room,
        }
    }

    /// Numbers that a ray carries of the light field.
    pub fn field_channels(&self) -> usize {
        self.field.map_or(0, |f| f.elements * f.polynomials)
    }
}
