//! A packet of rays on its way: where the values of a sample stand, what has been found, and the steps to come.

use std::ops::Range;

use super::borders::Span;
use super::terms::Drawn;
use crate::geometry::Ray;
use crate::packet::{LANES, Lane};
use crate::plan::Plan;
use crate::volume::Channel;

/// Offsets of the channels of all volumes in a sample.
pub(super) struct Slots {
    pub(super) count: usize,
    /// First slot of each volume.
    pub(super) first: Vec<usize>,
    pub(super) dust: Option<usize>,
    pub(super) stars: Vec<usize>,
    pub(super) species: Vec<usize>,
    /// Slot of the front at which gas ends, and by species true if it does.
    pub(super) front: Option<usize>,
    pub(super) has_front: Vec<bool>,
    /// Element × polynomial of the light field.
    pub(super) light: Vec<usize>,
    /// Terms of the field of scattered light.
    pub(super) scattered_field: Vec<usize>,
}

impl Slots {
    pub(super) fn new(plan: &Plan) -> Self {
        let space = &plan.space;
        let mut slots = Self {
            count: 0,
            first: Vec::new(),
            dust: None,
            stars: vec![0; space.stars.len()],
            species: vec![0; space.species()],
            front: None,
            has_front: space.gas().iter().map(|gas| gas.front().is_some()).collect(),
            light: vec![0; plan.light_field.as_ref().map_or(0, |f| f.propagation.channels())],
            scattered_field: vec![0; plan.scattered_field.as_ref().map_or(0, |_| plan.spectral.terms())],
        };
        for volume in plan.volumes() {
            slots.first.push(slots.count);
            for channel in &volume.channels {
                match *channel {
                    Channel::Dust => slots.dust = Some(slots.count),
                    Channel::StarDepth(star) => slots.stars[star] = slots.count,
                    Channel::Emission(species) => slots.species[species] = slots.count,
                    Channel::Front => slots.front = Some(slots.count),
                    Channel::Light(channel) => slots.light[channel] = slots.count,
                    Channel::MultipleScattering(term) => slots.scattered_field[term] = slots.count,
                }
                slots.count += 1;
            }
        }
        slots
    }
}

/// A packet on its way.
pub(super) struct PacketState<'a> {
    pub(super) rays: &'a [Ray; LANES],
    /// Random wavelengths, where the method has them.
    pub(super) drawn: Drawn,
    /// True if no later span and no background asks for τ at the end of this one.
    pub(super) final_span: bool,
    /// Start and end of the current span.
    pub(super) span: Span,
    pub(super) dt: Lane,
    pub(super) tau: Lane,
    /// Light so far, term × lane.
    pub(super) sum: Vec<Lane>,
    /// Emission of a light in a segment for each term, and room up to whole quads of terms, term × lane.
    pub(super) bases: Vec<Lane>,
    /// Scattered light so far where it comes from the light field, element × polynomial × lane.
    pub(super) channels: Vec<Lane>,
    pub(super) deepest: Lane,
    /// Radiance so far times its distance, if distances are measured.
    pub(super) moments: Option<Moments>,
}

/// Sums of light times the distance that it comes from [pc], like those of the light.
pub(super) struct Moments {
    pub(super) sum: Vec<Lane>,
    pub(super) channels: Vec<Lane>,
    /// The light when a segment began.
    before: (Vec<Lane>, Vec<Lane>),
}

impl Moments {
    pub(super) fn new(sums: usize, channels: usize) -> Self {
        let zeros = |count: usize| vec![[0.0; LANES]; count];
        Self { sum: zeros(sums), channels: zeros(channels), before: (zeros(sums), zeros(channels)) }
    }

    /// Counts the light that came since the last time, from a distance on each lane.
    pub(super) fn count(&mut self, sum: &[Lane], channels: &[Lane], distance: &Lane) {
        let sums = self.sum.iter_mut().chain(&mut self.channels).zip(self.before.0.iter_mut().chain(&mut self.before.1));
        for ((moment, before), now) in sums.zip(sum.iter().chain(channels)) {
            for lane in 0..LANES {
                moment[lane] += (now[lane] - before[lane]) * distance[lane];
            }
            *before = *now;
        }
    }
}

/// A star as the packet sees it: foot of the perpendicular, from the span's start, and length of it.
pub(super) struct StarView {
    pub(super) foot: Lane,
    pub(super) distance: Lane,
    /// Steps that may be long beside their distance to the star.
    pub(super) long: Range<usize>,
    /// Steps that the star may see under so wide an angle that the phase function changes along them.
    pub(super) wide: Range<usize>,
}

/// Start and length of a segment, in steps.
#[derive(Clone, Copy)]
pub(super) struct StepSpan {
    pub(super) start: f32,
    pub(super) length: f32,
}

impl StepSpan {
    pub(super) fn end(self) -> f32 {
        self.start + self.length
    }
}
