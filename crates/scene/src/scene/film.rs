//! Gas of a film: solved at some of its moments, and a smooth curve between them.
//!
//! Ionisation fronts are resolved to voxels, so that gas solved for each frame flickers. A film has knots t_k = k Δt at least [`SMOOTH`] frames
//! apart. The gas G_k of a knot is the mean of solutions at moments within Δt/2 of it, between which no star moves by more than a voxel or
//! changes by more than [`DIMMED`] of its light. With s = t/Δt − k from −½ to ½, a frame has
//!
//!   G(t) = ½ (½ − s)² G_(k−1) + (¾ − s²) G_k + ½ (½ + s)² G_(k+1)
//!
//! (the uniform quadratic B-spline): lines change without a jump in value or slope, and films of slow stars need fewer solutions.

use spectra::constants::{PARSEC, SPEED_OF_LIGHT};
use spectra::units::{Length, Time};

use super::band::BANDS;
use super::root::{FIELD, GAS, STAR, STAR_TABLE};
use super::{Fields, Loader, Scene, Star};
use crate::animation::Timeline;
use crate::error::Result;
use crate::properties::{Section, Table};

/// Animated scene and a moment \[s\].
#[derive(Debug, Clone, Copy)]
pub struct Film<'a> {
    /// How it changes.
    pub timeline: &'a Timeline,
    /// The scene with its changes.
    pub tree: &'a Table,
    /// The moment.
    pub time: f64,
}

/// A knot: the stars at each moment at which gas is solved for it.
pub(super) type Knot = Vec<Vec<Star>>;
/// The three nearest knots and their weights \[1\].
pub(super) type Nearest = [(Knot, f64); 3];

/// By how much the light of a star may change between solutions, as a natural logarithm.
const DIMMED: f64 = 0.1;
/// Wavelengths at which ionising starlight is compared \[µm\].
const IONISING_UM: f64 = 0.08;
/// Wavelengths at which scattered starlight is compared \[µm\].
const VISIBLE_UM: f64 = 0.55;
/// Least frames between knots. Differences between solutions are noise of the voxels, which grows with their number.
const SMOOTH: f64 = 5.0;
/// Most frames between solutions, and most frames that are looked at.
const MOST_FRAMES: f64 = 16.0;
const LOOKS: u64 = 48;
/// Tables of stars.
const STARS: [&str; 2] = [STAR.row.name, STAR_TABLE.row.name];
/// Gas inputs other than the stars: where that changes, gas is solved at every moment.
const OTHERS: [&str; 3] = [GAS.row.name, FIELD.row.name, BANDS.row.name];

impl Film<'_> {
    /// Keyframes of the gas of a table at this moment; `None` if it is solved at each.
    ///
    /// # Errors
    /// If what the scene says at a moment cannot be read.
    pub(super) fn around(&self, gas: &Section, fields: &Fields, loader: &Loader) -> Result<Option<Nearest>> {
        if !self.changes(&STARS) || self.changes(&OTHERS) {
            return Ok(None);
        }
        let frames = match self.timeline.solved_every.get() {
            Some(frames) => *frames,
            None => {
                let frames = self.frames_between(super::gas::voxel_pc(gas, fields)?, loader)?;
                *self.timeline.solved_every.get_or_init(|| frames)
            }
        };
        let apart = frames.max(SMOOTH);
        let (step, solutions) = (apart / self.timeline.frames.per_second, (apart / frames).ceil());
        let nearest = (self.time / step).round();
        let s = self.time / step - nearest;
        let knot = |number: f64| -> Result<Knot> {
            let place = |solution: usize| number + (solution as f64 + 0.5) / solutions - 0.5;
            (0..solutions as usize).map(|solution| self.stars((place(solution) * step).max(0.0), loader)).collect()
        };
        Ok(Some([
            (knot(nearest - 1.0)?, 0.5 * (0.5 - s).powi(2)),
            (knot(nearest)?, 0.75 - s * s),
            (knot(nearest + 1.0)?, 0.5 * (0.5 + s).powi(2)),
        ]))
    }

    /// True if a key of some tables is animated.
    fn changes(&self, tables: &[&str]) -> bool {
        self.timeline.tracks().any(|(place, _)| tables.contains(&place.split(['.', '[']).next().unwrap_or_default()))
    }

    /// The stars at a moment.
    fn stars(&self, time: f64, loader: &Loader) -> Result<Vec<Star>> {
        super::star_table::stars(&Section::root(&self.timeline.at(self.tree, time)?), loader)
    }

    /// Warning about a star whose light changes faster than light crosses the cloud, which as a whole grows bright at once; none where no star does.
    ///
    /// # Errors
    /// If what the scene says at a moment cannot be read.
    pub fn missing_echo(&self, scene: &Scene, loader: &Loader) -> Result<Option<String>> {
        let bounds = scene.densities().map(|density| density.bounds().size().max_element()).filter(|size| size.is_finite());
        let crossing_s = bounds.fold(0.0, f64::max) * PARSEC / SPEED_OF_LIGHT;
        let step = 1.0 / self.timeline.frames.per_second;
        if step >= crossing_s || !self.changes(&STARS) {
            return Ok(None);
        }
        let mut fastest: Option<(f64, String)> = None;
        self.frame_by_frame(loader, |before, after| {
            let changed = changed(before, after, VISIBLE_UM);
            if changed > fastest.as_ref().map_or(DIMMED, |(most, _)| *most) {
                fastest = Some((changed, before.name.clone()));
            }
        })?;
        Ok(fastest.map(|(changed, name)| {
            format!(
                "{name} changes by a factor of {:.3} within {}, in which light crosses {} of the {} cloud; light travel time (a light echo) is not modelled",
                changed.exp(),
                Time(step),
                Length(step * SPEED_OF_LIGHT / PARSEC),
                Length(crossing_s * SPEED_OF_LIGHT / PARSEC)
            )
        }))
    }

    /// Calls `show` with each star at sampled frames and one frame later.
    fn frame_by_frame(&self, loader: &Loader, mut show: impl FnMut(&Star, &Star)) -> Result<()> {
        let frames = &self.timeline.frames;
        let (looks, step) = (frames.count.clamp(1, LOOKS), 1.0 / frames.per_second);
        for look in 0..looks {
            let time = frames.time(frames.first + (look * frames.count.saturating_sub(1) / looks) as i64);
            let [before, after] = [self.stars(time, loader)?, self.stars(time + step, loader)?];
            before.iter().zip(&after).for_each(|(before, after)| show(before, after));
        }
        Ok(())
    }

    /// Frames between two solutions, by what changes most from one frame to the next.
    fn frames_between(&self, voxel_pc: f64, loader: &Loader) -> Result<f64> {
        let mut most = 0.0f64;
        self.frame_by_frame(loader, |before, after| {
            most = most.max((after.position - before.position).length() / voxel_pc).max(changed(before, after, IONISING_UM) / DIMMED);
        })?;
        Ok((1.0 / most).floor().clamp(1.0, MOST_FRAMES))
    }
}

/// Change of a star's spectrum at a wavelength \[µm\], |ln(after/before)|.
fn changed(before: &Star, after: &Star, lambda_um: f64) -> f64 {
    let [before, after] = [before, after].map(|star| star.spectrum.continuum(lambda_um));
    if before > 0.0 { (after / before).ln().abs() } else { 0.0 }
}
