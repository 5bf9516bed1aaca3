//! Pilot rays: what a step size and the resolution of the star depths cost in error, measured on the scene itself.
//!
//! Some rays of the image, those at stars and at the edges of the dust among them, are marched in f64 with six steps a voxel or more and exact star depths;
//! then with coarser steps and the baked depths, as the fast back ends do. The coarsest that keeps `accuracy` (relative rms over the pilots, each
//! for as many pixels as it stands for, worst band) is taken.

use rayon::prelude::*;
use spectra::rule::{Measure, mean_transmittance};

use super::walk::{Eye, walk};
use super::{LightField, Options, Space, Spectral, Stepping};
use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::{relative_rms, worst};
use crate::light::Light;
use crate::scene::Scene;

/// The spatial error that pilot rays measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spatial {
    /// How the rays were sampled.
    pub stepping: Stepping,
    /// Relative rms error of the worst band.
    pub error: f64,
    /// How many rays were asked.
    pub rays: usize,
}

/// Pilot rays along each edge of the image, evenly.
const EDGE: usize = 10;
/// Pilots on each edge of the dust's box, where star depths have kinks.
const ON_EDGE: usize = 3;
/// Most stars that get pilots of their own: the pixel they stand in and those around it.
const STARS: usize = 16;
/// The part of the accuracy that the pilots may use up: rays between them can be worse.
const SHARE: f64 = 0.7;
/// Samples in a voxel edge, from cheap to dear.
const STEPS: [f64; 10] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0];
/// Samples of the truth in a voxel edge at least and at most, and in an optical depth of one: its own error is a few parts in 1e5.
const TRUTH: (f64, f64) = (6.0, 48.0);
const TRUTH_PER_DEPTH: f64 = 8.0;
/// And along the longest edge of a small grid, up to half of the most.
const TRUTH_PER_EDGE: f64 = 768.0;
/// Cells of the even pilots, the brightest, that are looked at by nine rays each.
const BRIGHT: usize = 6;
/// The part of the accuracy that spectral rules may cost in the picture: they are chosen by the light without dust, pixels hold what is left of it.
const SPECTRAL_SHARE: f64 = 0.3;
/// How often a rule that is too coarse for what is left is made finer, and by how much.
const SPECTRAL_TRIES: usize = 4;
const FINER: f64 = 0.01;
/// What a finer step or finer star depths must make of the error, else they are not worth their price.
const WORTHWHILE: f64 = 0.8;
/// Images of no more pixels are marched whole.
const SMALL: usize = 400;
/// How finely star depths are baked, in voxels along one of dust: past the third only while all of them take less than `FINE_BYTES`.
const FACTORS: [usize; 7] = [1, 2, 3, 4, 6, 8, 12];
const MODEST: usize = 3;
const FINE_BYTES: u64 = 64 << 20;

/// A pilot ray and how many pixels it stands for.
struct Pilot {
    ray: Ray,
    pixels: f64,
}

/// Finds how finely the star depths must be baked and, where the options do not say it, the rays sampled; the former matters not where a `field`
/// holds the light, whose whole error is then measured.
pub fn choose(
    scene: &Scene,
    lights: &[Light],
    spectral: &Spectral,
    space: &mut Space,
    field: Option<&LightField>,
    options: &Options,
    control: &Control,
) -> Result<Stepping> {
    let pilots = pilots(scene, space, spectral, lights);
    let (plain, gathered) = (Shading::new(spectral, lights), Shading { field, ..Shading::new(spectral, lights) });
    let exactly = Shading { measures: field.map(|_| measures(spectral)), ..Shading::new(spectral, lights) };
    let march = |space: &Space, stepping: Stepping, exact: bool| -> Result<Vec<Vec<f64>>> {
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
    let accuracy = SHARE * options.method.accuracy;
    let mut best: Option<(Stepping, usize, f64)> = None;
    for factor in FACTORS {
        if factor > 1 {
            if factor > MODEST && space.star_bytes(factor) > FINE_BYTES {
                break;
            }
            // More memory than allowed for finer depths is no failure of the scene: the coarser ones stay, with their error stated.
            match space.refine_stars(factor, options, control) {
                Err(crate::Error::Memory { .. }) => break,
                other => other?,
            }
        }
        let per_voxel = STEPS.into_iter().filter(|n| *n < finest).map(Stepping::PerVoxel);
        let fixed = options.method.steps.map(|n| vec![Stepping::Fixed(n)]);
        let candidates = fixed.unwrap_or_else(|| per_voxel.collect());
        let before = best.map_or(f64::INFINITY, |b| b.2);
        for stepping in candidates {
            let error = relative_error(&march(space, stepping, false)?, &truth, &pilots);
            let worthwhile = best.is_none_or(|b| error < b.2 * if field.is_some() { WORTHWHILE } else { 1.0 });
            if worthwhile {
                best = Some((stepping, factor, error));
            }
            if error <= accuracy || field.is_some() && !worthwhile {
                break;
            }
        }
        let error = best.map_or(f64::INFINITY, |b| b.2);
        if error <= accuracy || error > WORTHWHILE * before || space.marched().is_empty() || field.is_some() {
            break;
        }
    }
    let (stepping, factor, error) = best.unwrap_or((Stepping::PerVoxel(1.0), 1, f64::INFINITY));
    if space.star_factor != factor {
        space.refine_stars(factor, options, control)?;
    }
    space.spatial = Some(Spatial { stepping, error, rays: pilots.len() });
    Ok(stepping)
}

/// The rules of `scene`, made finer until what they cost in the picture is a part of the accuracy.
pub fn spectral(scene: &Scene, lights: &[Light], space: &Space, options: &Options, control: &Control) -> Result<Spectral> {
    let accuracy = options.method.accuracy;
    let reach = space.reach(&scene.camera);
    let mut finer = options.clone();
    let mut best: Option<(Spectral, f64)> = None;
    // What shines does not depend on the rule: the rays and the truth are those of the first.
    let mut exact: Option<(Vec<Pilot>, Vec<Vec<f64>>)> = None;
    for _ in 0..SPECTRAL_TRIES {
        control.check()?;
        let mut spectral = Spectral::new(scene, lights, space.crowd.as_deref(), &finer, reach, control)?;
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
        if error <= SPECTRAL_SHARE * accuracy || options.method.settings.count.is_some() {
            break;
        }
        finer.method.accuracy *= FINER;
    }
    best.map(|b| b.0).ok_or_else(|| crate::Error::Render("no spectral rule was found".into()))
}

/// What shines through each band, exactly: band × light.
fn measures(spectral: &Spectral) -> Vec<Vec<Measure>> {
    let of_band = |band: &super::BandPlan| band.sources.iter().map(|s| s.measure.condensed(spectral.depth)).collect();
    spectral.bands.iter().map(of_band).collect()
}

/// Rays evenly over the image, more where it is bright, those of the pixels at and around stars, and those along the edges of the dust's box.
fn pilots(scene: &Scene, space: &Space, spectral: &Spectral, lights: &[Light]) -> Vec<Pilot> {
    let camera = &scene.camera;
    let size = (camera.width, camera.height);
    if size.0 * size.1 <= SMALL {
        let centre = |i: usize| camera.ray((i % size.0) as f64 + 0.5, (i / size.0) as f64 + 0.5);
        return (0..size.0 * size.1).map(|i| Pilot { ray: centre(i), pixels: 1.0 }).collect();
    }
    let along = |n: usize, i: usize, shift: f64| n as f64 * (i as f64 + 0.5 + shift) / EDGE as f64;
    let even = (size.0 * size.1) as f64 / (EDGE * EDGE) as f64;
    let ray = |i: usize, x: f64, y: f64| camera.ray(along(size.0, i % EDGE, x), along(size.1, i / EDGE, y));
    let shading = Shading::new(spectral, lights);
    let light: Vec<Vec<f64>> =
        (0..EDGE * EDGE).into_par_iter().map(|i| march(space, &shading, &ray(i, 0.0, 0.0), Stepping::PerVoxel(1.0), false)).collect();
    let bands = spectral.bands.len();
    let most: Vec<f64> = (0..bands).map(|b| light.iter().map(|l| l[b]).fold(f64::MIN_POSITIVE, f64::max)).collect();
    let bright = |i: usize| light[i].iter().zip(&most).map(|(l, m)| l / m).fold(0.0, f64::max);
    let mut cells: Vec<usize> = (0..EDGE * EDGE).collect();
    cells.sort_by(|a, b| bright(*b).total_cmp(&bright(*a)));
    let (looked_at, others) = cells.split_at(BRIGHT);
    let mut pilots: Vec<Pilot> = others.iter().map(|i| Pilot { ray: ray(*i, 0.0, 0.0), pixels: even }).collect();
    let thirds = |i: usize| (f64::from(i as u32 % 3) - 1.0, f64::from(i as u32 / 3) - 1.0);
    let within = |cell: usize| (0..9).map(thirds).map(move |(x, y)| (cell, x / 3.0, y / 3.0));
    pilots.extend(looked_at.iter().flat_map(|i| within(*i)).map(|(i, x, y)| Pilot { ray: ray(i, x, y), pixels: even / 9.0 }));
    let pixel = |column: f64, row: f64, pixels: f64| {
        let inside = (0.0..size.0 as f64).contains(&column) && (0.0..size.1 as f64).contains(&row);
        inside.then(|| Pilot { ray: camera.ray(column.floor() + 0.5, row.floor() + 0.5), pixels })
    };
    for (column, row) in space.stars.iter().take(STARS).filter_map(|star| camera.project(*star)) {
        for i in 0..9 {
            pilots.extend(pixel(column + f64::from(i % 3 - 1), row + f64::from(i / 3 - 1), 1.0));
        }
    }
    let Some(bounds) = space.dust.as_ref().map(|d| d.lattice.bounds) else { return pilots };
    for axis in 0..3 {
        for corner in 0..4 {
            let place = |part: f64| {
                let mut unit = [0.0; 3];
                unit[axis] = part;
                unit[(axis + 1) % 3] = f64::from(corner & 1);
                unit[(axis + 2) % 3] = f64::from(corner >> 1);
                camera.project(bounds.low + glam::DVec3::from(unit) * bounds.size())
            };
            let (Some(a), Some(b)) = (place(0.0), place(1.0)) else { continue };
            // The pixels that an edge crosses, shared by its pilots.
            let pixels = ((a.0 - b.0).hypot(a.1 - b.1) / ON_EDGE as f64).max(1.0).min(even);
            let parts = (0..ON_EDGE).map(|i| (i as f64 + 0.5) / ON_EDGE as f64);
            pilots.extend(parts.filter_map(place).filter_map(|(column, row)| pixel(column, row, pixels)));
        }
    }
    pilots
}

/// Largest relative rms over the bands.
fn relative_error(values: &[Vec<f64>], truth: &[Vec<f64>], pilots: &[Pilot]) -> f64 {
    let bands = truth.first().map_or(0, Vec::len);
    let of_band =
        |b: usize| relative_rms(values.iter().zip(truth).zip(pilots).map(|((v, t), p)| (p.pixels.sqrt() * v[b], p.pixels.sqrt() * t[b])));
    worst((0..bands).map(of_band))
}

/// How spectral integrals are done: by the rules, or exactly.
struct Shading<'a> {
    spectral: &'a Spectral,
    lights: &'a [Light],
    measures: Option<Vec<Vec<Measure>>>,
    field: Option<&'a LightField>,
}

impl<'a> Shading<'a> {
    fn new(spectral: &'a Spectral, lights: &'a [Light]) -> Self {
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

    fn dust(&mut self, (t0, t1): (f64, f64), (tau, growth): (f64, f64)) {
        if let Some(field) = self.shading.field {
            let (a, b) = (field.at(self.ray.at(t0)), field.at(self.ray.at(t1)));
            let light: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
            field.propagation.gather(tau + 0.5 * growth, growth, &light, &mut self.gathered);
        }
    }
}

/// Band radiances of one ray, marched as the fast back ends do, in f64.
fn march(space: &Space, shading: &Shading, ray: &Ray, stepping: Stepping, exact: bool) -> Vec<f64> {
    let radiance = vec![0.0; shading.spectral.bands.len()];
    let gathered = shading.field.map_or_else(Vec::new, |field| vec![0.0; field.propagation.channels()]);
    let mut bands = Bands { shading, ray, radiance, gathered };
    walk(space, shading.spectral, shading.lights, ray, stepping, exact, &mut bands);
    let Bands { mut radiance, gathered, .. } = bands;
    if let Some(field) = shading.field {
        for (band, resolution) in radiance.iter_mut().zip(&field.resolution) {
            *band += gathered.iter().zip(resolution).map(|(s, r)| s * r).sum::<f64>();
        }
    }
    radiance
}
