//! Displacements of a packet's samples by detail below the voxels.

use spectra::simd;

use super::state::PacketState;
use crate::detail::{Octave, single};
use crate::packet::{LANES, Lane, fma, lanes, largest};
use crate::plan::Plan;

/// Octaves along the rays of a packet.
pub(super) struct PacketDetail {
    octaves: Vec<PacketOctave>,
    /// Width of a pixel at the start \[pc\] and its growth per pc.
    width: Lane,
    widening: f32,
}

/// Waves of one length along the rays of a packet.
struct PacketOctave {
    start: [Lane; 3],
    speed: [Lane; 3],
    seed: u32,
    wavelength: f32,
    /// Displacements by both components of the noise \[pc\].
    displacements: [[f32; 3]; 2],
}

impl PacketOctave {
    fn new(octave: &Octave, state: &PacketState) -> Self {
        let place = |lane: usize| octave.turn * state.rays[lane].at(state.span.0[lane]) + octave.shift;
        let speed = |lane: usize| octave.turn * state.rays[lane].direction;
        Self {
            start: [0, 1, 2].map(|axis| lanes!(|lane| place(lane)[axis] as f32)),
            speed: [0, 1, 2].map(|axis| lanes!(|lane| speed(lane)[axis] as f32)),
            seed: octave.seed,
            wavelength: octave.wavelength_pc as f32,
            displacements: octave.displacements.map(|displacement| displacement.as_vec3().to_array()),
        }
    }
}

impl PacketDetail {
    /// Detail of a plan along the rays of a packet, whose distances begin at its span; none where the plan has none.
    pub(super) fn along(plan: &Plan, state: &PacketState) -> Option<Self> {
        let detail = plan.detail.as_deref().filter(|detail| !detail.octaves.is_empty())?;
        let footprint = plan.camera.footprint();
        // Rays that meet nothing see nothing.
        let width = |lane: usize| if state.dt[lane] > 0.0 { footprint.at(state.span.0[lane]) as f32 } else { f32::MAX };
        Some(Self {
            octaves: detail.octaves.iter().map(|octave| PacketOctave::new(octave, state)).collect(),
            width: lanes!(|lane| width(lane)),
            widening: footprint.per_pc as f32,
        })
    }

    /// Displacements of the places at distance `t` of each ray, along each axis \[pc\].
    pub(super) fn displacements(&self, t: &Lane) -> [Lane; 3] {
        let mut displaced = [[0.0; LANES]; 3];
        displace(self, t, &mut displaced);
        displaced
    }
}

simd! {
    fn displace(detail: &PacketDetail, t: &Lane, displaced: &mut [Lane; 3]) {
        let half = lanes!(|lane| 0.5 / fma(detail.widening, t[lane], detail.width[lane]));
        for octave in &detail.octaves {
            let PacketOctave { start, speed, seed, wavelength, displacements: [first, second] } = octave;
            let seen = lanes!(|lane| {
                let part = fma(*wavelength, half[lane], -1.5);
                let part = if part > 0.0 { part } else { 0.0 };
                if part < 1.0 { part } else { 1.0 }
            });
            // Shorter waves are seen no better.
            if largest(&seen) <= 0.0 {
                return;
            }
            let mut components = [[0.0; LANES]; 2];
            for lane in 0..LANES {
                let place = [0, 1, 2].map(|axis| fma(speed[axis][lane], t[lane], start[axis][lane]));
                [components[0][lane], components[1][lane]] = single(place, *seed);
            }
            for axis in 0..3 {
                let (sum, first, second) = (displaced[axis], first[axis], second[axis]);
                displaced[axis] =
                    lanes!(|lane| fma(seen[lane], fma(first, components[0][lane], second * components[1][lane]), sum[lane]));
            }
        }
    }
}
