//! The choice of steps and star depths: the cheapest that keep the accuracy beside the truth.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Pilot, Shading, march, measures, pilots, relative_error, unresolved};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::image::{SpatialError, UnresolvedStars};
use crate::light::Light;
use crate::plan::draft::Draft;
use crate::plan::multiple_scattering::PilotLight;
use crate::plan::spatial::bake::{MAX_BAKE, MIN_BAKE};
use crate::plan::{BandPlan, END_SHARE, LightField, Options, SpatialPlan, SpectralPlan, Stepping};
use crate::scene::Scene;

/// The part of the accuracy that the pilots may use up: rays between them can be worse.
const SHARE: f64 = 0.7;
/// The part of that which samples of functions may cost.
const SAMPLING_SHARE: f64 = 0.5;
/// The part of what samples of functions do cost that steps and star depths may add, up to the accuracy asked for: the
/// whole, which is worse than that already, becomes half a percent larger.
const BESIDE_SAMPLING: f64 = 0.1;
/// Steps in a voxel edge, from cheap to dear: a segment costs about what its sample does. Pairs are taken where they are
/// short beside what is near a star: longer ones were seen to be worse than their pilots say.
const STEPS: [Stepping; 12] = [
    Stepping::PerVoxel(0.5),
    Stepping::PerVoxel(1.0),
    Stepping::PerVoxel(1.5),
    Stepping::PerVoxel(2.0),
    Stepping::PerVoxel(3.0),
    Stepping::PerVoxel(4.0),
    Stepping::Paired(3.5),
    Stepping::Paired(4.0),
    Stepping::Paired(6.0),
    Stepping::PerVoxel(12.0),
    Stepping::Paired(8.0),
    Stepping::PerVoxel(16.0),
];
/// The fewest samples in a voxel edge where there are many lights: a step passes stars that no pilot marches, and takes the dust linear
/// beside each.
const BESIDE_MANY_LIGHTS: f64 = 2.0;
/// Samples of the truth in a voxel edge at least and at most, and in an optical depth of one: its own error is a few
/// parts in 1e5.
const TRUTH: (f64, f64) = (6.0, 48.0);
const TRUTH_PER_DEPTH: f64 = 8.0;
/// The samples of the truth along the longest edge of a small grid, up to half of the most.
const TRUTH_PER_EDGE: f64 = 768.0;
/// The factor by which a finer step or finer star depths must change the error, else they are not worth their price.
const WORTHWHILE: f64 = 0.8;
/// The resolutions of star depths that are tried, in voxels along one of dust: past the third only while all of them
/// take less than `FINE_BYTES`.
const FACTORS: [usize; 7] = [1, 2, 3, 4, 6, 8, 12];
const MODEST: usize = 3;
const FINE_BYTES: u64 = 64 << 20;

/// Finds how finely the star depths must be baked and, where the settings do not say it, the rays sampled; the former
/// matters not where a `field` holds the light, whose whole error is then measured. Returns the steps, and the light of the
/// pilots.
pub fn choose(draft: &mut Draft, field: Option<&LightField>, control: &Control) -> Result<(Stepping, PilotLight)> {
    let Draft { scene, options, lights, space, spectral, .. } = draft;
    let space = Arc::make_mut(space);
    let accuracy = SHARE * scene.method.accuracy;
    let plain = Shading::new(spectral, lights);
    let mut marches = Marches {
        scene,
        options,
        pilots: pilots(scene, space, spectral, lights, control)?,
        fast: Shading { field, ..plain },
        exact: Shading { measures: field.map(|_| measures(spectral)), ..plain },
        control,
    };
    let finest = finest(space);
    let truth = marches.exact(space, finest)?;
    let sampling = if field.is_none() { sampled(&mut marches, space, (spectral, lights), &truth)? } else { None };
    // Steps and star depths can mend what they cost themselves, and no more: they are chosen beside an exact march
    // through the same samples.
    let reachable = sampling.as_ref().map_or(&truth, |s| &s.values);
    let candidates = match (scene.method.steps, scene.method.steps_per_voxel) {
        (Some(n), _) => vec![Stepping::Fixed(n)],
        (None, Some(n)) => vec![Stepping::PerVoxel(n)],
        (None, None) => candidates(space, finest, field.is_some()),
    };
    let beside_sampling = BESIDE_SAMPLING * sampling.as_ref().map_or(0.0, Sampling::worst);
    let enough = beside_sampling.min(scene.method.accuracy).max(accuracy);
    let Some(TriedChoice { stepping, factor, values, .. }) = marches.cheapest(space, &candidates, reachable, enough)? else {
        return Ok((Stepping::PerVoxel(1.0), PilotLight::default()));
    };
    let error = marches.error(&values, &truth);
    if space.star_factor != factor {
        space.refine_stars(factor, scene, options, control)?;
    }
    // What a ray leaves behind where it ends early is beside what the pilots, who go on, have found.
    let early = if space.occupied.is_some() && spectral.bands.iter().any(BandPlan::is_bounded) {
        f64::from(END_SHARE) * spectral.accuracy
    } else {
        0.0
    };
    let unresolved = sampling.as_ref().and_then(|s| s.unresolved);
    let sampling = sampling.map(|s| (s.error, s.edge));
    space.spatial = Some(SpatialError { stepping, error: error + early, sampling, rays: marches.pilots.len(), unresolved });
    let rays = marches.pilots.iter().map(|pilot| (pilot.ray, pilot.pixels)).collect();
    Ok((stepping, PilotLight { rays, radiance: truth }))
}

/// Samples functions finely enough for the accuracy, and measures the error that is left; `None` where nothing is sampled.
fn sampled(
    marches: &mut Marches,
    space: &mut SpatialPlan,
    (spectral, lights): (&SpectralPlan, &[Light]),
    truth: &[Vec<f64>],
) -> Result<Option<Sampling>> {
    let (scene, options, control) = (marches.scene, marches.options, marches.control);
    let (accuracy, finest) = (SHARE * scene.method.accuracy, finest(space));
    let mut sampling = None;
    while let Some(edge) = space.sampled_edge() {
        // Densities alone: steps as fine as the truth's, and exact star depths, through the samples.
        let values = marches.exact(&space.of_samples(), finest)?;
        let unresolved = unresolved::error(scene, space, spectral, lights, control)?;
        let measured = Sampling { error: marches.error(&values, truth), edge, unresolved, values };
        let error = measured.worst();
        sampling = Some(measured);
        // Errors fall between the first and the second power of a voxel: at least half of one.
        let times = (error / (SAMPLING_SHARE * accuracy)).powf(1.0 / 1.5).ceil().clamp(2.0, MAX_BAKE as f64);
        let finer = edge.saturating_mul(times as usize).next_multiple_of(MIN_BAKE).min(MAX_BAKE);
        if error <= SAMPLING_SHARE * accuracy || finer == edge || scene.method.bake.is_some() {
            break;
        }
        let Some(resampled) = space.resampled(scene, finer, options, control)? else { break };
        *space = resampled;
        marches.look_anew(space);
    }
    Ok(sampling)
}

/// The error that sampling of densities costs which are functions.
struct Sampling {
    /// Relative rms error of the pilots, worst band, and of stars that are seen through the samples.
    error: f64,
    unresolved: Option<UnresolvedStars>,
    /// Voxels along the longest edge of the coarsest samples.
    edge: usize,
    /// The light of the pilots through them, pilot × band.
    values: Vec<Vec<f64>>,
}

impl Sampling {
    /// The larger error of the two.
    fn worst(&self) -> f64 {
        self.unresolved.map_or(self.error, |stars| self.error.max(stars.error))
    }
}

/// Samples in a voxel edge with which the truth is marched.
fn finest(space: &SpatialPlan) -> f64 {
    let voxel_depth = space.dust.as_ref().map_or(0.0, |_| f64::from(space.bricks[0].largest()) * space.voxel_pc());
    let edge = space.dust.as_ref().map_or(1, |d| d.lattice().dims.into_iter().max().unwrap_or(1)) as f64;
    (TRUTH_PER_DEPTH * voxel_depth).max((TRUTH_PER_EDGE / edge).min(0.5 * TRUTH.1)).clamp(TRUTH.0, TRUTH.1)
}

/// Steps that are tried, from cheap to dear.
fn candidates(space: &SpatialPlan, finest: f64, field: bool) -> Vec<Stepping> {
    let coarsest = if space.many_lights.is_some() { BESIDE_MANY_LIGHTS } else { 0.0 };
    let fits = |stepping: &Stepping| match *stepping {
        Stepping::PerVoxel(n) => n < finest && n >= coarsest,
        // The field of a method that marches one has no middles.
        Stepping::Paired(n) => !field && 2.0 * n < finest && n >= coarsest,
        Stepping::Fixed(_) => false,
    };
    STEPS.into_iter().filter(fits).collect()
}

/// A choice of steps and star depths that was tried.
struct TriedChoice {
    stepping: Stepping,
    /// Voxels of star depths along one of dust.
    factor: usize,
    /// The error that they cost, relative rms of the worst band.
    error: f64,
    /// The light of the pilots, pilot × band.
    values: Vec<Vec<f64>>,
}

/// The pilots, and how they are marched.
struct Marches<'a> {
    pilots: Vec<Pilot>,
    /// As the fast back ends shade, and exactly.
    fast: Shading<'a>,
    exact: Shading<'a>,
    scene: &'a Scene,
    options: &'a Options,
    control: &'a Control,
}

impl Marches<'_> {
    /// The light of all pilots with exact star depths, at a given number of samples in a voxel edge: pilot × band.
    fn exact(&self, space: &SpatialPlan, per_voxel: f64) -> Result<Vec<Vec<f64>>> {
        self.all(|pilot| march(space, &self.exact, pilot, Stepping::PerVoxel(per_voxel), true))
    }

    /// The light of all pilots as the fast back ends march it: pilot × band.
    fn fast(&self, space: &SpatialPlan, stepping: Stepping) -> Result<Vec<Vec<f64>>> {
        self.all(|pilot| march(space, &self.fast, pilot, stepping, false))
    }

    /// Forgets the depths along the pilots: the dust has become other samples.
    fn look_anew(&mut self, space: &SpatialPlan) {
        let known = self.pilots.iter_mut().filter(|pilot| pilot.columns.is_some());
        known.for_each(|pilot| *pilot = Pilot::new(space, pilot.ray, pilot.pixels, self.scene.method.accuracy));
    }

    fn all(&self, march: impl Fn(&Pilot) -> Vec<f64> + Sync) -> Result<Vec<Vec<f64>>> {
        let checked = |pilot| self.control.check().map(|()| march(pilot));
        self.pilots.par_iter().map(checked).collect()
    }

    fn error(&self, values: &[Vec<f64>], truth: &[Vec<f64>]) -> f64 {
        relative_error(values, truth, &self.pilots)
    }

    /// The cheapest of `candidates` with the coarsest star depths whose error is small `enough`, or the best there is. Star
    /// depths of `space` are refined on the way, and may be finer in the end than those that were chosen.
    fn cheapest(
        &self,
        space: &mut SpatialPlan,
        candidates: &[Stepping],
        reachable: &[Vec<f64>],
        enough: f64,
    ) -> Result<Option<TriedChoice>> {
        // A field of light has no star depths to refine, and finer steps may be of no use to it.
        let field = self.fast.field.is_some();
        let mut best: Option<TriedChoice> = None;
        let Self { scene, options, .. } = *self;
        let fixed = scene.method.star_depth_voxels.map(|voxels| voxels.min(options.star_depth_voxels));
        let factors = match &fixed {
            Some(only) => std::slice::from_ref(only),
            None => &FACTORS,
        };
        for &factor in factors.iter().take_while(|factor| **factor == 1 || **factor <= options.star_depth_voxels) {
            if factor > 1 {
                if fixed.is_none() && factor > MODEST && space.star_bytes(factor) > FINE_BYTES {
                    break;
                }
                // More memory than allowed for finer depths is no failure of the scene: the coarser ones stay, with
                // their error stated.
                match space.refine_stars(factor, scene, options, self.control) {
                    Err(Error::Memory { .. }) if fixed.is_none() => break,
                    other => other?,
                }
            }
            let before = best.as_ref().map_or(f64::INFINITY, |b| b.error);
            for &stepping in candidates {
                let values = self.fast(space, stepping)?;
                let error = self.error(&values, reachable);
                let worthwhile = best.as_ref().is_none_or(|b| error < b.error * if field { WORTHWHILE } else { 1.0 });
                if worthwhile {
                    best = Some(TriedChoice { stepping, factor, error, values });
                }
                if error <= enough || field && !worthwhile {
                    break;
                }
            }
            let error = best.as_ref().map_or(f64::INFINITY, |b| b.error);
            if error <= enough || error > WORTHWHILE * before || space.marched().is_empty() || field {
                break;
            }
        }
        Ok(best)
    }
}
