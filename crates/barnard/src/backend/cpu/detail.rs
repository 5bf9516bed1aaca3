//! Detail below the voxels at the samples of a packet.
//!
//! A sample stands for the stretch of a ray around it; its factor is the mean over places in it, about a wave apart. Places that
//! far apart vary more than the stretch does: the mean square of noise along a stretch is 0.39 of a wave over its length, and
//! deviations are made smaller so that columns of many samples vary as they should.

use spectra::simd;

use super::state::PacketState;
use crate::camera::Footprint;
use crate::detail::{FineDetail, Octave, log_mean, single};
use crate::packet::{LANES, Lane, exp, fma, lanes, largest};
use crate::plan::Plan;

/// Most places of a sample at which the finest waves are asked.
pub const DETAIL_PLACES: usize = 16;
/// The part of a wave over which noise is alike along a line: ∫ of its correlation.
pub const DETAIL_ALIKE: f32 = 0.39;

/// The noise of a plan, and what it changes.
pub(super) struct DetailNoise<'a> {
    noise: &'a FineDetail,
    footprint: Footprint,
    /// The slots that are changed, and which densities they are.
    slots: Vec<(usize, usize)>,
}

impl<'a> DetailNoise<'a> {
    /// The noise of a plan whose dust and gas stand in these slots; none where it has none.
    pub(super) fn new(plan: &'a Plan, dust: Option<usize>, species: &[usize]) -> Option<Self> {
        let noise = plan.detail.as_deref().filter(|noise| !noise.octaves.is_empty())?;
        let gas = usize::from(plan.space.dust.is_some());
        let slots = dust.map(|slot| (slot, 0)).into_iter().chain(species.iter().enumerate().map(|(i, slot)| (*slot, gas + i))).collect();
        Some(Self { noise, footprint: plan.camera.footprint(), slots })
    }

    /// Variant along the rays of a packet, whose stretch begins at its span.
    pub(super) fn along(&self, state: &PacketState) -> PacketDetail {
        let start = |lane: usize| state.span.0[lane];
        let noise = |octave: &'a Octave| {
            let place = |lane: usize| octave.turn * state.rays[lane].at(start(lane)) + octave.shift;
            let speed = |lane: usize| octave.turn * state.rays[lane].direction;
            PacketOctave {
                start: [0, 1, 2].map(|axis| lanes!(|lane| place(lane)[axis] as f32)),
                speed: [0, 1, 2].map(|axis| lanes!(|lane| speed(lane)[axis] as f32)),
                seed: octave.seed,
                wavelength: octave.wavelength_pc as f32,
                deviations: self.slots.iter().map(|(_, density)| octave.deviations[*density] as f32).collect(),
                seen: [0.0; LANES],
                places: 0,
                values: [0.0; LANES],
            }
        };
        let slot = |(slot, _): &(usize, usize)| PacketSlot { slot: *slot, mean: [0.0; LANES], factor: [0.0; LANES] };
        PacketDetail {
            slots: self.slots.iter().map(slot).collect(),
            octaves: self.noise.octaves.iter().map(noise).collect(),
            // Rays that meet nothing see nothing.
            width: lanes!(|lane| if state.dt[lane] > 0.0 { self.footprint.at(start(lane)) as f32 } else { f32::MAX }),
            widening: self.footprint.per_pc as f32,
        }
    }
}

/// Waves of one length along the rays of a packet.
struct PacketOctave {
    start: [Lane; 3],
    speed: [Lane; 3],
    seed: u32,
    wavelength: f32,
    /// By slot.
    deviations: Vec<f32>,
    /// The part of them that pixels see, at the sample that was asked for last.
    seen: Lane,
    /// Places of that sample at which they are asked; none where no pixel sees them.
    places: usize,
    /// The noise at the last of them.
    values: Lane,
}

/// A density that is changed.
struct PacketSlot {
    slot: usize,
    /// ln of the mean of what it is multiplied by.
    mean: Lane,
    /// The sum of factors.
    factor: Lane,
}

/// The noise along the rays of a packet.
pub(super) struct PacketDetail {
    slots: Vec<PacketSlot>,
    octaves: Vec<PacketOctave>,
    /// Width of a pixel at the start \[pc\] and its growth per pc.
    width: Lane,
    widening: f32,
}

impl PacketDetail {
    /// Changes a sample at distance `t` of each ray that stands for `stretch` of it \[pc\].
    pub(super) fn apply(&mut self, t: &Lane, stretch: &Lane, sample: &mut [Lane]) {
        if self.slots.iter().any(|slot| largest(&sample[slot.slot]) > 0.0) {
            multiply(self, t, stretch, sample);
        }
    }
}

simd! {
    fn multiply(detail: &mut PacketDetail, t: &Lane, stretch: &Lane, sample: &mut [Lane]) {
        let PacketDetail { slots, octaves, width, widening } = detail;
        let half = lanes!(|lane| 0.5 / fma(*widening, t[lane], width[lane]));
        let longest = largest(stretch);
        let mut most = 0;
        for octave in octaves.iter_mut() {
            let waves = longest / octave.wavelength;
            let places = waves.round().clamp(1.0, DETAIL_PLACES as f32);
            let alike = DETAIL_ALIKE * places / waves;
            let scale = if alike < 1.0 { alike.sqrt() } else { 1.0 };
            let wavelength = octave.wavelength;
            octave.seen = lanes!(|lane| {
                let part = fma(wavelength, half[lane], -1.5);
                let part = if part > 0.0 { part } else { 0.0 };
                scale * if part < 1.0 { part } else { 1.0 }
            });
            octave.places = if largest(&octave.seen) > 0.0 { places as usize } else { 0 };
            most = most.max(octave.places);
        }
        if most == 0 {
            return;
        }
        for (c, slot) in slots.iter_mut().enumerate() {
            let mut mean = [0.0; LANES];
            for octave in octaves.iter().filter(|octave| octave.places > 0) {
                let (deviation, seen) = (octave.deviations[c], octave.seen);
                mean = lanes!(|lane| mean[lane] + log_mean(deviation * seen[lane]));
            }
            (slot.mean, slot.factor) = (mean, [0.0; LANES]);
        }
        for place in 0..most {
            for octave in octaves.iter_mut().filter(|octave| octave.places > 0) {
                // Longer waves stay as they are over several places.
                let position = place * octave.places / most;
                if place == 0 || position != (place - 1) * octave.places / most {
                    let at = (position as f32 + 0.5) / octave.places as f32 - 0.5;
                    let PacketOctave { start, speed, seed, .. } = &*octave;
                    let at = lanes!(|lane| fma(at, stretch[lane], t[lane]));
                    octave.values = lanes!(|lane| single(
                        [
                            fma(speed[0][lane], at[lane], start[0][lane]),
                            fma(speed[1][lane], at[lane], start[1][lane]),
                            fma(speed[2][lane], at[lane], start[2][lane])
                        ],
                        *seed
                    ));
                }
            }
            for (c, slot) in slots.iter_mut().enumerate() {
                let mut exponent = lanes!(|lane| -slot.mean[lane]);
                for octave in octaves.iter().filter(|octave| octave.places > 0) {
                    let (deviation, seen, values) = (octave.deviations[c], octave.seen, octave.values);
                    exponent = lanes!(|lane| fma(deviation * seen[lane], values[lane], exponent[lane]));
                }
                let factor = slot.factor;
                slot.factor = lanes!(|lane| factor[lane] + exp(exponent[lane]));
            }
        }
        let share = 1.0 / most as f32;
        for slot in slots {
            let (values, factor) = (sample[slot.slot], slot.factor);
            sample[slot.slot] = lanes!(|lane| values[lane] * (share * factor[lane]));
        }
    }
}
