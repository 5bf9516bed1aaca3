//! Pilot rays: what a step size and the resolution of the star depths cost in error, measured on the scene itself.
//!
//! Some rays of the image, those at stars and at the edges of the dust among them, are marched in f64 with six steps a
//! voxel or more and exact star depths; then with coarser steps and the baked depths, as the fast back ends do. The
//! coarsest that keeps `accuracy` (relative rms over the pilots, each for as many pixels as it stands for, worst band)
//! is taken.

mod choice;
pub(crate) mod march_f64;
mod sampled_pixels;
mod samples;
pub(crate) mod star_columns;
mod steps;
mod unresolved;

pub use choice::choose;

use rayon::prelude::*;
use spectra::rule::{DepthSpan, Measure, mean_transmittance};

use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::worst;
use crate::light::Light;
use crate::plan::pilots::march_f64::{Eye, RayMarch};
use crate::plan::pilots::star_columns::StarColumns;
use crate::plan::segment::Segment;
use crate::plan::{LightField, RuleTarget, SpatialPlan, SpectralPlan, Stepping};
use crate::scene::Scene;

/// The part of the accuracy that spectral rules may cost in the picture: they are chosen by the light without dust,
/// pixels hold what is left of it.
const SPECTRAL_SHARE: f64 = 0.3;
/// The number of times that a rule too coarse for what is left is made finer, and the factor in accuracy.
const SPECTRAL_TRIES: usize = 4;
const FINER: f64 = 0.01;

/// A pilot ray and how many pixels it stands for.
struct Pilot {
    ray: Ray,
    pixels: f64,
    /// Exact star depths along the ray, as far as they were asked for; none where those of all pilots would take too
    /// much memory, and each march makes its own.
    columns: Option<StarColumns>,
}

/// Bytes of star depths that pilots keep from march to march.
const KEPT_BYTES: usize = 64 << 20;

impl Pilot {
    fn new(space: &SpatialPlan, ray: Ray, pixels: f64, accuracy: f64) -> Self {
        Self { ray, pixels, columns: Some(columns(space, &ray, accuracy)) }
    }
}

/// Room for the star depths along a pilot ray, which sees the stars that have depths of their own, and of many lights
/// their representatives where there are no others.
fn columns(space: &SpatialPlan, ray: &Ray, accuracy: f64) -> StarColumns {
    let representatives = space.many_lights.iter().flat_map(|many_lights| &many_lights.representatives);
    StarColumns::new(space, ray, space.marched().iter().chain(representatives).copied().collect(), accuracy)
}

/// The rules of `scene`, made finer until what they cost in the picture is a part of the accuracy.
pub fn spectral(scene: &Scene, lights: &[Light], space: &SpatialPlan, control: &Control) -> Result<SpectralPlan> {
    let accuracy = scene.method.accuracy;
    let mut rules = RuleTarget { accuracy, depth: space.reach(&scene.camera) };
    let mut best: Option<(SpectralPlan, f64)> = None;
    // What shines does not depend on the rule: the rays and the truth are those of the first.
    let mut exact: Option<(Vec<Pilot>, Vec<Vec<f64>>)> = None;
    for _ in 0..SPECTRAL_TRIES {
        control.check()?;
        let spectral = SpectralPlan::with_rules(scene, lights, space, rules, control)?;
        let march = |pilots: &[Pilot], shading: &Shading| -> Result<Vec<Vec<f64>>> {
            let checked = |pilot| control.check().map(|()| march(space, shading, pilot, Stepping::PerVoxel(1.0), false));
            pilots.par_iter().map(checked).collect()
        };
        let by_rules = Shading::new(&spectral, lights);
        if exact.is_none() {
            let pilots = pilots(scene, space, &spectral, lights, control)?;
            let truth = march(&pilots, &Shading { measures: Some(measures(&spectral)), ..Shading::new(&spectral, lights) })?;
            exact = Some((pilots, truth));
        }
        let Some((pilots, truth)) = &exact else { break };
        let error = relative_error(&march(pilots, &by_rules)?, truth, pilots);
        if best.as_ref().is_none_or(|b| error < b.1) {
            best = Some((spectral, error));
        }
        // A rule of fixed size stays as it is.
        if error <= SPECTRAL_SHARE * accuracy || scene.method.settings.count.is_some() {
            break;
        }
        rules.accuracy *= FINER;
    }
    best.map(|b| b.0).ok_or_else(|| crate::Error::Method("no spectral rule reaches the accuracy; increase accuracy".into()))
}

/// The exact measure of every light through each band: band × light.
fn measures(spectral: &SpectralPlan) -> Vec<Vec<Measure>> {
    let of_band = |band: &crate::plan::BandPlan| band.sources.iter().map(|s| s.measure.condensed(spectral.depth)).collect();
    spectral.bands.iter().map(of_band).collect()
}

/// The pilots of a scene: pixels that are chosen by a first look at the light of some.
fn pilots(scene: &Scene, space: &SpatialPlan, spectral: &SpectralPlan, lights: &[Light], control: &Control) -> Result<Vec<Pilot>> {
    let camera = &scene.camera;
    let shading = Shading::new(spectral, lights);
    let ray = |column: usize, row: usize| camera.ray(column as f64 + 0.5, row as f64 + 0.5);
    let pilot = |column: usize, row: usize, pixels: f64| Pilot::new(space, ray(column, row), pixels, scene.method.accuracy);
    let look = |column: usize, row: usize| {
        control.check()?;
        Ok(march(space, &shading, &pilot(column, row, 1.0), Stepping::PerVoxel(1.0), false))
    };
    let pixels = sampled_pixels::sampled(camera, space, look)?;
    let mut count = 0;
    let kept_if_small = |p: sampled_pixels::SampledPixel| {
        let mut pilot = pilot(p.column, p.row, p.stands_for);
        count += pilot.columns.as_ref().map_or(0, StarColumns::bytes);
        pilot.columns = pilot.columns.filter(|_| count <= KEPT_BYTES);
        pilot
    };
    Ok(pixels.into_iter().map(kept_if_small).collect())
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

/// The way in which spectral integrals are done: by the rules, or exactly.
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

/// The light of a ray in every band as it arrives.
struct Bands<'a> {
    shading: &'a Shading<'a>,
    ray: &'a Ray,
    /// Radiance by the rules of the spectral plan.
    sums: Vec<f64>,
    /// Exact radiance per band.
    exact: Vec<f64>,
    /// The light that a field brings, element × polynomial.
    channels: Vec<f64>,
}

impl Eye for Bands<'_> {
    fn light(&mut self, light: usize, amount: f64, depths: DepthSpan) {
        let Some(measures) = &self.shading.measures else {
            return self.shading.spectral.add(light, amount, depths, &mut self.sums);
        };
        for (band, measures) in self.exact.iter_mut().zip(measures) {
            let Measure { k, mass, .. } = &measures[light];
            *band += amount * k.iter().zip(mass).map(|(k, m)| m * mean_transmittance(k * depths.from, k * depths.to)).sum::<f64>();
        }
    }

    fn scattered_together(&self) -> bool {
        self.shading.field.is_some()
    }

    fn dust(&mut self, segment: &Segment) {
        if let Some(field) = self.shading.field {
            let (a, b) = (field.at(self.ray.at(segment.from)), field.at(self.ray.at(segment.to)));
            let light: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
            field.propagation.accumulate(segment.tau + 0.5 * segment.growth, segment.growth, &light, &mut self.channels);
        }
    }
}

/// Band radiances of one ray, marched as the fast back ends do, in f64.
fn march(space: &SpatialPlan, shading: &Shading, pilot: &Pilot, stepping: Stepping, exact: bool) -> Vec<f64> {
    let ray = &pilot.ray;
    let made;
    let columns = match &pilot.columns {
        Some(count) => count,
        None => {
            made = columns(space, ray, shading.spectral.accuracy);
            &made
        }
    };
    let nothing = vec![0.0; shading.spectral.bands.len()];
    let channels = shading.field.map_or_else(Vec::new, |field| vec![0.0; field.propagation.channels()]);
    let mut bands = Bands { shading, ray, sums: Vec::new(), exact: nothing, channels };
    RayMarch { space, spectral: shading.spectral, lights: shading.lights, ray, stepping, exact, columns }.run(&mut bands);
    let Bands { sums, exact, channels, .. } = bands;
    let mut radiance = if shading.measures.is_some() { exact } else { shading.spectral.resolved(&sums) };
    if let Some(field) = shading.field {
        for (band, resolution) in radiance.iter_mut().zip(&field.resolution) {
            *band += channels.iter().zip(resolution).map(|(s, r)| s * r).sum::<f64>();
        }
    }
    radiance
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use spectra::spectrum::{Line, Spectrum};

    use super::*;
    use crate::field::Plummer;
    use crate::fixtures::{ball, dust, on_axis, scene, star};
    use crate::plan::{Options, Planned, Planner, Quality};
    use crate::scene::{Emission, Method};

    /// Pilots that keep no star depths march as those that do, bit by bit: by the fields themselves, and by the plan's
    /// volumes where stars have no depths of their own there.
    #[test]
    fn depths_that_are_not_kept_are_the_same() {
        let places = [DVec3::new(0.2, 0.1, 0.3), DVec3::new(-1.5, 0.4, 0.0)];
        let scene = scene(on_axis(4.0, 20.0, (8, 8)), 16).with_dust(dust(ball(1.0), "ccm89", 2.0));
        let scene = places.into_iter().fold(scene, |scene, place| scene.with_star(star(9000.0, 1.0, place))).build().unwrap();
        let gathered = Method { exact_stars: Some(0), ..scene.method.clone() };
        for method in [scene.method.clone(), gathered] {
            let scene = scene.clone().with_method(method);
            let plan = Planner::new(&Options::default()).with_quality(Quality::Fixed(16)).plan(&scene, None, &Control::default()).unwrap();
            let shading = Shading::new(plan.spectral(), plan.lights());
            let ray = scene.camera.ray(4.6, 3.7);
            let cached = Pilot::new(plan.space(), ray, 1.0, plan.spectral().accuracy);
            let not_kept = Pilot { ray, pixels: 1.0, columns: None };
            for exact in [false, true] {
                let light = |pilot: &Pilot| march(plan.space(), &shading, pilot, Stepping::PerVoxel(2.0), exact);
                // Asked for the second time, depths are read from what was kept.
                let (first, second) = (light(&cached), light(&cached));
                assert!(first == second && first == light(&not_kept) && first[0] > 0.0, "{first:?} {second:?}");
            }
        }
    }

    /// A rule that no accuracy makes good, since it has one wavelength, is made finer in vain; the phase function is asked at as
    /// many angles as for any other rule.
    #[test]
    fn finer_rules_leave_phase_functions_as_they_are() {
        let phase = crate::phase::HenyeyGreenstein::new(0.7).unwrap();
        let scene = scene(on_axis(4.0, 30.0, (8, 8)), 16).with_dust(dust(ball(1.0), "ccm89", 6.0).with_phase(phase));
        let scene = scene.with_star(star(5000.0, 1.0, DVec3::new(0.2, 0.1, 0.3))).build().unwrap();
        let angle = |name: &str| {
            let method = scene.method.clone().with_name(name).unwrap();
            let scene = scene.clone().with_method(method);
            let plan = Planner::new(&Options::default()).plan(&scene, None, &Control::default()).unwrap();
            let worst = plan.certificates(0, &plan.expected()).into_iter().map(|(_, c)| c.absolute).fold(0.0, f64::max);
            (plan.spectral().phase_angle, plan.spectral().phase.as_ref().unwrap().entries, worst)
        };
        let (one, good) = (angle("fixed_wavelength"), angle("band_quadrature"));
        assert!(one.2 > 1e-3 && good.2 < 1e-3, "{} {}", one.2, good.2);
        assert_eq!((one.0, one.1), (good.0, good.1));
    }

    /// Dust and gas that thicken inwards, with a star inside, seen by a camera of a given number of degrees and pixels.
    fn glowing_cloud(degrees: f64, size: (usize, usize)) -> Planned {
        let ball = |core: f64| Plummer::new(DVec3::ZERO, core).unwrap().with_cut(1.0).unwrap();
        let gas = Emission::new(ball(0.2), Spectrum::of_lines(vec![Line { lambda_um: 0.55, strength: 1e-20 }]));
        let scene = scene(on_axis(4.0, degrees, size), 20).with_dust(dust(ball(0.4), "ccm89", 6.0)).with_emission(gas);
        let scene = scene.with_star(star(9000.0, 1.0, DVec3::new(0.45, 0.4, -0.2))).build().unwrap();
        Planner::new(&Options::default()).with_quality(Quality::Fixed(16)).plan(&scene, None, &Control::default()).unwrap()
    }

    /// Segments of two samples are nearly as good as twice as many of one, and far better than as many.
    #[test]
    fn middles_are_worth_their_samples() {
        let plan = glowing_cloud(20.0, (24, 24));
        let shading = Shading::new(plan.spectral(), plan.lights());
        let pilots: Vec<Pilot> = (0..24 * 24)
            .map(|i| Pilot::new(plan.space(), plan.camera().ray((i % 24) as f64 + 0.5, (i / 24) as f64 + 0.5), 1.0, 0.0))
            .collect();
        let by = |stepping| -> Vec<Vec<f64>> { pilots.iter().map(|p| march(plan.space(), &shading, p, stepping, false)).collect() };
        let truth = by(Stepping::PerVoxel(40.0));
        let error = |stepping| relative_error(&by(stepping), &truth, &pilots);
        for n in [1.0, 2.0] {
            let [paired, twice, single] = [Stepping::Paired(n), Stepping::PerVoxel(2.0 * n), Stepping::PerVoxel(n)].map(error);
            assert!(paired < 2.0 * twice && paired < 0.5 * single, "{n}: {paired:e} {twice:e} {single:e}");
        }
    }

    /// The processor marches such segments as pilots do.
    #[test]
    fn the_processor_pairs_samples_as_pilots_do() {
        // So narrow that all rays of a packet are one.
        let plan = glowing_cloud(1e-4, (1, 1));
        let shading_of = |plan: &Planned, stepping| {
            let shading = Shading::new(plan.spectral(), plan.lights());
            march(plan.space(), &shading, &Pilot::new(plan.space(), plan.camera().ray(0.5, 0.5), 1.0, 0.0), stepping, false)[0]
        };
        for (stepping, other) in [(Stepping::Paired(1.0), Stepping::PerVoxel(1.0)), (Stepping::PerVoxel(1.0), Stepping::Paired(1.0))] {
            let plan = plan.clone().with_stepping(stepping);
            let radiance = f64::from(crate::backend::cpu::radiance(&plan, &Control::default()).unwrap().0[0]);
            let (truth, wrong) = (shading_of(&plan, stepping), shading_of(&plan, other));
            assert!(
                (radiance / truth - 1.0).abs() < 2e-6 && (radiance / wrong - 1.0).abs() > 2e-5,
                "{stepping}: {radiance:e} {truth:e} {wrong:e}"
            );
        }
    }
}
