//! Pilot rays: what a step size and the resolution of the star depths cost in error, measured on the scene itself.
//!
//! Some rays of the image, those at stars and at the edges of the dust among them, are marched in f64 with six steps a
//! voxel or more and exact star depths; then with coarser steps and the baked depths, as the fast back ends do. The
//! coarsest that keeps `accuracy` (relative rms over the pilots, each for as many pixels as it stands for, worst band)
//! is taken.

pub(crate) mod march_f64;
mod sampled_pixels;
mod unresolved;

pub use unresolved::Unresolved;

use rayon::prelude::*;
use spectra::rule::{Measure, mean_transmittance};

use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::worst;
use crate::light::Light;
use crate::plan::pilots::march_f64::{Eye, RayMarch, Segment};
use crate::plan::spatial::bake::{MAX_BAKE, MIN_BAKE};
use crate::plan::{END_SHARE, LightField, Settings, SpatialPlan, SpectralPlan, Stepping};
use crate::scene::Scene;

/// The spatial error that pilot rays measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spatial {
    /// How the rays were sampled.
    pub stepping: Stepping,
    /// Relative rms error of the worst band.
    pub error: f64,
    /// What samples of fields that are functions have of it, and voxels along the longest edge of the coarsest.
    pub sampling: Option<(f64, usize)>,
    /// How many rays were asked.
    pub rays: usize,
    /// What samples of a function cost stars that are seen through it; none where they cost nothing.
    pub unresolved: Option<Unresolved>,
}

/// The part of the accuracy that the pilots may use up: rays between them can be worse.
const SHARE: f64 = 0.7;
/// The part of that which samples of functions may cost.
const SAMPLING_SHARE: f64 = 0.5;
/// Samples in a voxel edge, from cheap to dear.
const STEPS: [f64; 10] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0];
/// Fewest of them where there are many lights: a step passes stars that no pilot marches, and takes the dust linear
/// beside each.
const BESIDE_MANY_LIGHTS: f64 = 2.0;
/// Samples of the truth in a voxel edge at least and at most, and in an optical depth of one: its own error is a few
/// parts in 1e5.
const TRUTH: (f64, f64) = (6.0, 48.0);
const TRUTH_PER_DEPTH: f64 = 8.0;
/// And along the longest edge of a small grid, up to half of the most.
const TRUTH_PER_EDGE: f64 = 768.0;
/// The part of the accuracy that spectral rules may cost in the picture: they are chosen by the light without dust,
/// pixels hold what is left of it.
const SPECTRAL_SHARE: f64 = 0.3;
/// How often a rule that is too coarse for what is left is made finer, and by how much.
const SPECTRAL_TRIES: usize = 4;
const FINER: f64 = 0.01;
/// What a finer step or finer star depths must make of the error, else they are not worth their price.
const WORTHWHILE: f64 = 0.8;
/// How finely star depths are baked, in voxels along one of dust: past the third only while all of them take less than
/// `FINE_BYTES`.
const FACTORS: [usize; 7] = [1, 2, 3, 4, 6, 8, 12];
const MODEST: usize = 3;
const FINE_BYTES: u64 = 64 << 20;

/// A pilot ray and how many pixels it stands for.
struct Pilot {
    ray: Ray,
    pixels: f64,
}

/// Finds how finely the star depths must be baked and, where the settings do not say it, the rays sampled; the former
/// matters not where a `field` holds the light, whose whole error is then measured.
pub fn choose(
    scene: &Scene,
    lights: &[Light],
    spectral: &SpectralPlan,
    space: &mut SpatialPlan,
    field: Option<&LightField>,
    settings: &Settings,
    control: &Control,
) -> Result<Stepping> {
    let pilots = pilots(scene, space, spectral, lights);
    let (plain, gathered) = (Shading::new(spectral, lights), Shading { field, ..Shading::new(spectral, lights) });
    let exactly = Shading { measures: field.map(|_| measures(spectral)), ..Shading::new(spectral, lights) };
    let march = |space: &SpatialPlan, stepping: Stepping, exact: bool| -> Result<Vec<Vec<f64>>> {
        let shading = match (field, exact) {
            (None, _) => &plain,
            (Some(_), false) => &gathered,
            (Some(_), true) => &exactly,
        };
        pilots.par_iter().map(|pilot| control.check().map(|()| march(space, shading, &pilot.ray, stepping, exact))).collect()
    };
    let voxel_depth = space.dust.as_ref().map_or(0.0, |_| f64::from(space.bricks[0].largest()) * space.voxel_pc());
    let edge = space.dust.as_ref().map_or(1, |d| d.lattice.dims.into_iter().max().unwrap_or(1)) as f64;
    let finest = (TRUTH_PER_DEPTH * voxel_depth).max((TRUTH_PER_EDGE / edge).min(0.5 * TRUTH.1)).clamp(TRUTH.0, TRUTH.1);
    let truth = march(space, Stepping::PerVoxel(finest), true)?;
    let accuracy = SHARE * settings.method.accuracy;
    let (mut sampling, mut through_samples, mut unresolved) = (None, None, None);
    while let Some(edge) = space.sampled_edge().filter(|_| field.is_none()) {
        // Densities alone: steps as fine as the truth's, and exact star depths, through the samples.
        let values = march(&space.of_samples(), Stepping::PerVoxel(finest), true)?;
        let error = relative_error(&values, &truth, &pilots);
        through_samples = Some(values);
        sampling = Some((error, edge));
        unresolved = unresolved::error(scene, space, spectral, lights)?;
        let error = unresolved.map_or(error, |stars| error.max(stars.error));
        // Errors fall between the first and the second power of a voxel: at least half of one.
        let times = (error / (SAMPLING_SHARE * accuracy)).powf(1.0 / 1.5).ceil().clamp(2.0, MAX_BAKE as f64);
        let finer = edge.saturating_mul(times as usize).next_multiple_of(MIN_BAKE).min(MAX_BAKE);
        if error <= SAMPLING_SHARE * accuracy || finer == edge || settings.method.bake.is_some() {
            break;
        }
        let Some(resampled) = space.resampled(scene, finer, settings, control)? else { break };
        *space = resampled;
    }
    // Steps and star depths can mend what they cost themselves, and no more: they are chosen beside an exact march
    // through the same samples.
    let reachable = through_samples.as_ref().unwrap_or(&truth);
    let mut best: Option<Choice> = None;
    for factor in FACTORS {
        if factor > 1 {
            if factor > MODEST && space.star_bytes(factor) > FINE_BYTES {
                break;
            }
            // More memory than allowed for finer depths is no failure of the scene: the coarser ones stay, with their
            // error stated.
            match space.refine_stars(factor, settings, control) {
                Err(crate::Error::Memory { .. }) => break,
                other => other?,
            }
        }
        let coarsest = if space.many_lights.is_some() { BESIDE_MANY_LIGHTS } else { 0.0 };
        let per_voxel = STEPS.into_iter().filter(|n| *n < finest && *n >= coarsest).map(Stepping::PerVoxel);
        let fixed = settings.method.steps.map(|n| vec![Stepping::Fixed(n)]);
        let candidates = fixed.unwrap_or_else(|| per_voxel.collect());
        let before = best.as_ref().map_or(f64::INFINITY, |b| b.error);
        for stepping in candidates {
            let values = march(space, stepping, false)?;
            let error = relative_error(&values, reachable, &pilots);
            let worthwhile = best.as_ref().is_none_or(|b| error < b.error * if field.is_some() { WORTHWHILE } else { 1.0 });
            if worthwhile {
                best = Some(Choice { stepping, factor, error, values });
            }
            if error <= accuracy || field.is_some() && !worthwhile {
                break;
            }
        }
        let error = best.as_ref().map_or(f64::INFINITY, |b| b.error);
        if error <= accuracy || error > WORTHWHILE * before || space.marched().is_empty() || field.is_some() {
            break;
        }
    }
    let Some(Choice { stepping, factor, values, .. }) = best else { return Ok(Stepping::PerVoxel(1.0)) };
    let error = relative_error(&values, &truth, &pilots);
    if space.star_factor != factor {
        space.refine_stars(factor, settings, control)?;
    }
    // What a ray leaves behind where it ends early is beside what the pilots, who go on, have found.
    let early = if space.occupied.is_some() && spectral.bands.iter().any(|b| b.nodes().is_some()) {
        f64::from(END_SHARE) * spectral.accuracy
    } else {
        0.0
    };
    space.spatial = Some(Spatial { stepping, error: error + early, sampling, rays: pilots.len(), unresolved });
    Ok(stepping)
}

/// Steps and star depths that were tried.
struct Choice {
    stepping: Stepping,
    /// Voxels of star depths along one of dust.
    factor: usize,
    /// What they cost.
    error: f64,
    /// The light of the pilots, pilot × band.
    values: Vec<Vec<f64>>,
}

/// The rules of `scene`, made finer until what they cost in the picture is a part of the accuracy.
pub fn spectral(scene: &Scene, lights: &[Light], space: &SpatialPlan, settings: &Settings, control: &Control) -> Result<SpectralPlan> {
    let accuracy = settings.method.accuracy;
    let reach = space.reach(&scene.camera);
    let mut finer = settings.clone();
    let mut best: Option<(SpectralPlan, f64)> = None;
    // What shines does not depend on the rule: the rays and the truth are those of the first.
    let mut exact: Option<(Vec<Pilot>, Vec<Vec<f64>>)> = None;
    for _ in 0..SPECTRAL_TRIES {
        control.check()?;
        let mut spectral = SpectralPlan::new(scene, lights, space.many_lights.as_deref(), &finer, reach, control)?;
        spectral.accuracy = accuracy;
        let march = |pilots: &[Pilot], shading: &Shading| -> Vec<Vec<f64>> {
            pilots.par_iter().map(|pilot| march(space, shading, &pilot.ray, Stepping::PerVoxel(1.0), false)).collect()
        };
        let rules = Shading::new(&spectral, lights);
        let (pilots, truth) = exact.get_or_insert_with(|| {
            let pilots = pilots(scene, space, &spectral, lights);
            let truth = march(&pilots, &Shading { measures: Some(measures(&spectral)), ..Shading::new(&spectral, lights) });
            (pilots, truth)
        });
        let error = relative_error(&march(pilots, &rules), truth, pilots);
        if best.as_ref().is_none_or(|b| error < b.1) {
            best = Some((spectral, error));
        }
        // A rule of fixed size stays as it is.
        if error <= SPECTRAL_SHARE * accuracy || settings.method.settings.count.is_some() {
            break;
        }
        finer.method.accuracy *= FINER;
    }
    best.map(|b| b.0).ok_or_else(|| crate::Error::Method("no spectral rule was found".into()))
}

/// What shines through each band, exactly: band × light.
fn measures(spectral: &SpectralPlan) -> Vec<Vec<Measure>> {
    let of_band = |band: &crate::plan::BandPlan| band.sources.iter().map(|s| s.measure.condensed(spectral.depth)).collect();
    spectral.bands.iter().map(of_band).collect()
}

/// The pilots of a scene: pixels that are chosen by a first look at the light of some.
fn pilots(scene: &Scene, space: &SpatialPlan, spectral: &SpectralPlan, lights: &[Light]) -> Vec<Pilot> {
    let camera = &scene.camera;
    let shading = Shading::new(spectral, lights);
    let ray = |column: usize, row: usize| camera.ray(column as f64 + 0.5, row as f64 + 0.5);
    let look = |column: usize, row: usize| march(space, &shading, &ray(column, row), Stepping::PerVoxel(1.0), false);
    let pixels = sampled_pixels::sampled(camera, space, look).into_iter();
    pixels.map(|p| Pilot { ray: ray(p.column, p.row), pixels: p.stands_for }).collect()
}

/// Largest relative rms over the bands, one standard error above what the pilots say: few rays carry most of an error,
/// and those between them can be worse.
fn relative_error(values: &[Vec<f64>], truth: &[Vec<f64>], pilots: &[Pilot]) -> f64 {
    let bands = truth.first().map_or(0, Vec::len);
    let all: f64 = pilots.iter().map(|p| p.pixels).sum();
    let of_band = |b: usize| {
        let mean = |f: &dyn Fn(usize) -> f64| pilots.iter().enumerate().map(|(i, p)| p.pixels * f(i)).sum::<f64>() / all;
        let square = |i: usize| (values[i][b] - truth[i][b]).powi(2);
        let wrong = mean(&square);
        if wrong == 0.0 {
            return 0.0;
        }
        // Of a weighted mean; pilots that stand for all pixels alone have none.
        let scatter: f64 = pilots.iter().enumerate().map(|(i, p)| (p.pixels / all * (square(i) - wrong)).powi(2)).sum();
        let chance = if pilots.iter().all(|p| p.pixels == 1.0) { 0.0 } else { scatter.sqrt() };
        ((wrong + chance) / mean(&|i| truth[i][b].powi(2))).sqrt()
    };
    worst((0..bands).map(of_band))
}

/// How spectral integrals are done: by the rules, or exactly.
struct Shading<'a> {
    spectral: &'a SpectralPlan,
    lights: &'a [Light],
    measures: Option<Vec<Vec<Measure>>>,
    field: Option<&'a LightField>,
}

impl<'a> Shading<'a> {
    fn new(spectral: &'a SpectralPlan, lights: &'a [Light]) -> Self {
        Self { spectral, lights, measures: None, field: None }
    }
}

/// What arrives of a ray in every band.
struct Bands<'a> {
    shading: &'a Shading<'a>,
    ray: &'a Ray,
    radiance: Vec<f64>,
    gathered: Vec<f64>,
}

impl Eye for Bands<'_> {
    fn light(&mut self, light: usize, amount: f64, depths: (f64, f64)) {
        for (b, band) in self.radiance.iter_mut().enumerate() {
            *band += amount
                * match &self.shading.measures {
                    None => self.shading.spectral.bands[b].rule.mean(light, depths),
                    Some(measures) => {
                        let Measure { k, mass, .. } = &measures[b][light];
                        k.iter().zip(mass).map(|(k, m)| m * mean_transmittance(k * depths.0, k * depths.1)).sum()
                    }
                };
        }
    }

    fn scattered_together(&self) -> bool {
        self.shading.field.is_some()
    }

    fn dust(&mut self, segment: &Segment) {
        if let Some(field) = self.shading.field {
            let (a, b) = (field.at(self.ray.at(segment.from)), field.at(self.ray.at(segment.to)));
            let light: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
            field.propagation.gather(segment.tau + 0.5 * segment.growth, segment.growth, &light, &mut self.gathered);
        }
    }
}

/// Band radiances of one ray, marched as the fast back ends do, in f64.
fn march(space: &SpatialPlan, shading: &Shading, ray: &Ray, stepping: Stepping, exact: bool) -> Vec<f64> {
    let radiance = vec![0.0; shading.spectral.bands.len()];
    let gathered = shading.field.map_or_else(Vec::new, |field| vec![0.0; field.propagation.channels()]);
    let mut bands = Bands { shading, ray, radiance, gathered };
    RayMarch { space, spectral: shading.spectral, lights: shading.lights, ray, stepping, exact }.run(&mut bands);
    let Bands { mut radiance, gathered, .. } = bands;
    if let Some(field) = shading.field {
        for (band, resolution) in radiance.iter_mut().zip(&field.resolution) {
            *band += gathered.iter().zip(resolution).map(|(s, r)| s * r).sum::<f64>();
        }
    }
    radiance
}
