//! The truth: f64, adaptive in space and wavelength, exact star depths, plain and readable.
//!
//! It reads the scene's physics itself and shares none of the plan's approximations: no baked grids, no cached star
//! depths, no nodes.
//!
//! Along a ray, per wavelength, eq. (1) of docs/method.md:
//!
//!   I_λ = Σ_ℓ ∫dt σ k ω p(θ_ℓ) L_ℓ/(4π r_ℓ²) e^(−k(τ + τ_ℓ)) + Σ_e ∫dt j_e Φ_e e^(−k τ) + background e^(−k τ_end)
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | σ | dust profile | pc⁻¹ |
//! | τ, τ_ℓ | `tau`, `tau_star` | 1 |
//! | k, ω, p | `Wavelength` | 1, 1, sr⁻¹ |
//!
//! Each star is integrated over the angle ϑ at which it sees the ray, t = t₀ + b tan ϑ, so that dt/r² = dϑ/b has no
//! peak (Kulla & Fajardo 2012, EGSR, eq. 7). Cells between the fields' own crossings are bisected until the (G3, K7)
//! pair agrees. Source of the transport: Kajiya & von Herzen 1984.

mod profile;
mod ray;
mod seen;

use glam::DVec3;
use rayon::prelude::*;
use spectra::quadrature::integrate;
use spectra::rule::truth_points;

use super::{Backend, BackendEntry, DeviceUse, Input, Job, Radiance, RenderStats};
use crate::backend::seen_detail::SeenDetail;
use crate::camera::Camera;
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::geometry::Ray;
use crate::image::{PointSource, Report, Samples};
use crate::light::{Light, Route, factor, law, lights};
use crate::points::{self, Sources};
use crate::scene::{Dust, Scene};
use profile::Profile;
use ray::RayRadiance;
use seen::SeenField;

pub use crate::scene::REFERENCE_ACCURACY as DEFAULT_ACCURACY;

/// Optical depths at V behind which the integrals over wavelength must have converged, and cosines at which those of
/// scattered light.
const DEPTHS: [f64; 7] = [0.0, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
const PHASES: [f64; 3] = [-1.0, 0.0, 1.0];

/// One wavelength of one band, with its quadrature weights.
struct ReferenceWave {
    band: usize,
    lambda_um: f64,
    k: f64,
    /// R dλ times spectrum and factor, for each light; a line belongs to one light alone.
    weight: Vec<f64>,
}

/// Everything that is the same for all rays.
struct RayConstants<'a> {
    scene: &'a Scene,
    lights: Vec<Light>,
    waves: Vec<ReferenceWave>,
    /// Density detail below the voxel size, along rays of the camera.
    detail: Option<SeenDetail>,
    accuracy: f64,
    control: &'a Control,
}

/// The row of this back end in the catalogue.
pub const ENTRY: BackendEntry = BackendEntry {
    name: "reference",
    summary: "f64, adaptive in space and wavelength, exact star depths: the slow reference",
    planned: false,
    device: DeviceUse::Never,
    open: |scene| Ok(Box::new(Reference { accuracy: scene.method.backends.reference_accuracy })),
};

/// The exact picture, of light that scatters once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// The allowed error of each pixel, relative to its radiance.
    pub accuracy: f64,
}

impl Backend for Reference {
    fn name(&self) -> String {
        ENTRY.name.into()
    }

    fn input(&self) -> Input {
        Input::Scene { accuracy: self.accuracy }
    }

    fn unsupported(&self, job: &Job, _: &Control) -> Result<Option<String>> {
        Ok(check(job.scene()).err().map(|e| e.to_string()))
    }

    fn radiance(&mut self, job: &Job, control: &Control) -> Result<Radiance> {
        let scene = job.scene();
        check(scene)?;
        let rays = scene.camera.width * scene.camera.height * scene.camera.supersampling.pow(2);
        let detail = SeenDetail::of(scene, job.options(), control)?;
        let samples = Samples::Double(extended(scene, detail, self.accuracy, control)?);
        let report = Report {
            method: Some("adaptive integration in double precision".into()),
            bounces: Some(1),
            accuracy: Some(self.accuracy),
            notes: vec![("accuracy".into(), format!("{:e} of each pixel", self.accuracy))],
            ..Report::default()
        };
        Ok(Radiance { report, ..Radiance::new(samples, RenderStats::of_rays(rays as u64)) })
    }
}

/// Refuses what the reference does not know.
fn check(scene: &Scene) -> Result<()> {
    if scene.method.bounces > 1 { Err(Error::OneBounce("the reference".into(), "the path tracer")) } else { Ok(()) }
}

/// Light without stars that are seen as points, bands × height × width [W m⁻² sr⁻¹].
fn extended(scene: &Scene, detail: Option<SeenDetail>, accuracy: f64, control: &Control) -> Result<Vec<f64>> {
    let truth = RayConstants { detail, ..RayConstants::new(scene, accuracy, control)? };
    let camera = &scene.camera;
    let bands = scene.bands.len();
    let rows: Vec<Vec<f64>> = {
        let done = std::sync::atomic::AtomicU64::new(0);
        let row = |i: usize| {
            let pixel = |j: usize| {
                let light = truth.pixel(camera, i, j);
                control.check().map(|()| light)
            };
            let pixels = (0..camera.width).map(pixel).collect::<Result<Vec<Vec<f64>>>>()?;
            let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            control.report(Stage::Rays, count, camera.height as u64);
            Ok((0..bands).flat_map(|b| pixels.iter().map(move |p| p[b])).collect())
        };
        (0..camera.height).into_par_iter().map(row).collect::<Result<_>>()?
    };
    let mut data = vec![0.0; bands * camera.width * camera.height];
    for (i, row) in rows.iter().enumerate() {
        for b in 0..bands {
            let start = (b * camera.height + i) * camera.width;
            data[start..start + camera.width].copy_from_slice(&row[b * camera.width..(b + 1) * camera.width]);
        }
    }
    Ok(data)
}

/// Draws the unresolved sources of `scene` to `accuracy`: `add` receives indices in bands × height × width, and
/// radiances [W m⁻² sr⁻¹].
pub(super) fn draw_points(scene: &Scene, accuracy: f64, control: &Control, add: impl FnMut(usize, f64)) -> Result<Vec<PointSource>> {
    RayConstants::new(scene, accuracy, control)?.draw_points(add)
}

impl<'a> RayConstants<'a> {
    fn new(scene: &'a Scene, accuracy: f64, control: &'a Control) -> Result<Self> {
        let lights = lights(scene)?;
        let law = law(scene)?;
        let mut waves = Vec::new();
        for (band, passband) in scene.bands.iter().enumerate() {
            let factors: Vec<_> = lights.iter().map(|l| factor(l.route, scene.dust.as_ref())).collect();
            let breaks: Vec<f64> = lights.iter().flat_map(|l| l.spectrum.breakpoints_um()).chain(law.breakpoints_um()).collect();
            let sent = |lambda: f64| lights.iter().zip(&factors).map(move |(l, f)| l.spectrum.continuum(lambda) * f(lambda));
            // What a ray is asked for: every light behind every depth, and at the angles over which its phase function
            // changes most.
            let integrand = |lambda: f64| -> Vec<f64> {
                let phases = PHASES.map(|cosine| scene.dust.as_ref().map_or(1.0, |d| d.phase.at(cosine, lambda)));
                let decays = DEPTHS.map(|a| (-a * law.k(lambda)).exp());
                sent(lambda)
                    .flat_map(|w| decays.iter().map(move |d| w * d).chain(phases.iter().map(move |p| w * p)).collect::<Vec<_>>())
                    .collect()
            };
            // λ may take a tenth of the allowed error.
            for (lambda_um, response) in truth_points(passband, &breaks, integrand, 0.1 * accuracy) {
                let weight = sent(lambda_um).map(|w| response * w).collect();
                waves.push(ReferenceWave { band, lambda_um, k: law.k(lambda_um), weight });
            }
            for (i, light) in lights.iter().enumerate() {
                for line in light.spectrum.lines_through(passband) {
                    let response = passband.response(line.lambda_um);
                    if response > 0.0 {
                        let mut weight = vec![0.0; lights.len()];
                        weight[i] = response * line.strength * factors[i](line.lambda_um);
                        waves.push(ReferenceWave { band, lambda_um: line.lambda_um, k: law.k(line.lambda_um), weight });
                    }
                }
            }
        }
        waves.retain(|w| w.weight.iter().any(|v| *v != 0.0));
        Ok(Self { scene, lights, waves, detail: None, accuracy, control })
    }

    /// Band flux of a light behind optical depth `tau`.
    fn flux(&self, light: usize, band: usize, tau: f64) -> f64 {
        self.waves.iter().filter(|w| w.band == band).map(|w| w.weight[light] * (-w.k * tau).exp()).sum()
    }

    fn draw_points(&self, add: impl FnMut(usize, f64)) -> Result<Vec<PointSource>> {
        let fluxes = |_: usize, light: usize, ray: &Ray, length: f64| {
            let depth = self.depth(ray.origin, ray.at(length.min(self.horizon(ray))));
            (0..self.scene.bands.len()).map(|band| self.flux(light, band, depth)).collect()
        };
        points::draw(Sources::All, self.scene, &self.scene.camera, &self.lights, fluxes, self.control, add)
    }

    /// End of the last field along a ray [pc].
    fn horizon(&self, ray: &Ray) -> f64 {
        self.scene.densities().filter_map(|f| f.bounds().clip(ray)).map(|(_, far)| far).fold(0.0, f64::max)
    }

    /// Exact optical depth between two places.
    fn depth(&self, a: DVec3, b: DVec3) -> f64 {
        self.scene.dust.as_ref().map_or(0.0, |dust| dust.sigma_v_per_pc * column(&*dust.density, a, b, self.accuracy))
    }

    fn pixel(&self, camera: &Camera, row: usize, column: usize) -> Vec<f64> {
        let n = camera.supersampling;
        let mut sum = vec![0.0; self.scene.bands.len()];
        for s in 0..n * n {
            let place = |i: usize, s: usize| i as f64 + (s as f64 + 0.5) / n as f64;
            let (column, row) = (place(column, s % n), place(row, s / n));
            if !camera.sees(column, row) {
                continue;
            }
            let radiance = self.ray(&camera.ray(column, row));
            sum.iter_mut().zip(radiance).for_each(|(s, r)| *s += r / (n * n) as f64);
        }
        sum
    }

    /// Radiance along a ray, band by band.
    fn ray(&self, ray: &Ray) -> Vec<f64> {
        let far = self.horizon(ray);
        let profile = |field: &dyn Field| {
            let near = field.bounds().clip(ray).map_or(0.0, |(near, _)| near);
            let seen = self.detail.as_ref().and_then(|detail| Some((detail, detail.finest_pc(near)?)));
            match seen {
                None => Profile::new(field, ray, far, 0.1 * self.accuracy),
                Some((detail, finest_pc)) => Profile::new(&SeenField { field, detail, ray, finest_pc }, ray, far, 0.1 * self.accuracy),
            }
        };
        let dust = self.scene.dust.as_ref().map(|d| (d, profile(&*d.density)));
        let tau = |t: f64| dust.as_ref().map_or(0.0, |(d, p)| d.sigma_v_per_pc * p.column(t));
        let mut radiance = RayRadiance::new(self);
        for (light, l) in self.lights.iter().enumerate() {
            match l.route {
                Route::Scattered { star } => {
                    if let Some((d, p)) = &dust {
                        self.scattered(&mut radiance, ray, light, self.scene.stars[star].position, d, p);
                    }
                }
                Route::Emitted { species } => {
                    let species_profile = profile(&*self.scene.species()[species].density);
                    let cells = species_profile.pieces().iter().flat_map(|p| split_by(p.start, p.end, dust.as_ref().map(|d| &d.1)));
                    radiance.adapt(cells, |t, wave| species_profile.at(t) * wave.weight[light] * (-wave.k * tau(t)).exp());
                }
                Route::Background => {
                    let end = tau(f64::INFINITY);
                    radiance.add(|wave| wave.weight[light] * (-wave.k * end).exp());
                }
                Route::Direct { .. } | Route::FieldStar { .. } => {}
            }
        }
        radiance.bands
    }

    /// Light of one star, scattered once: over the angle at which the star sees the ray.
    fn scattered(&self, radiance: &mut RayRadiance, ray: &Ray, light: usize, star: DVec3, dust: &Dust, profile: &Profile) {
        let foot = (star - ray.origin).dot(ray.direction);
        // A ray through the star itself has no finite radiance: it passes by at a millionth of a parsec.
        let b = (star - ray.at(foot)).length().max(1e-6);
        let angle = |t: f64| ((t - foot) / b).atan();
        let cells = profile.pieces().iter().flat_map(|p| {
            let split = if p.start < foot && foot < p.end { vec![(p.start, foot), (foot, p.end)] } else { vec![(p.start, p.end)] };
            split.into_iter().map(|(s, e)| (angle(s), angle(e))).collect::<Vec<_>>()
        });
        let sample = |theta: f64| {
            let t = foot + b * theta.tan();
            let place = ray.at(t);
            let sigma = dust.sigma_v_per_pc * profile.at(t).max(0.0);
            let lit = self.detail.as_ref().map_or(place, |detail| detail.place(ray, t, &dust.density.bounds()));
            let tau = dust.sigma_v_per_pc * profile.column(t) + if sigma > 0.0 { self.depth(star, lit) } else { 0.0 };
            let incoming = (place - star).normalize_or_zero();
            (sigma / b, tau, incoming.dot(-ray.direction))
        };
        radiance.adapt_sampled(cells, sample, |(density, tau, cosine), wave| {
            density * dust.phase.at(*cosine, wave.lambda_um) * wave.weight[light] * (-wave.k * tau).exp()
        });
    }
}

/// [start, end] cut at the ends of another profile's pieces.
fn split_by(start: f64, end: f64, other: Option<&Profile>) -> Vec<(f64, f64)> {
    let inner = other.into_iter().flat_map(|p| p.pieces()).flat_map(|p| [p.start, p.end]).filter(|t| *t > start && *t < end);
    let mut ends: Vec<f64> = [start, end].into_iter().chain(inner).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    ends.windows(2).map(|w| (w[0], w[1])).collect()
}

/// ∫ of a field between two places: exact for grids, adaptive for functions.
pub(crate) fn column(field: &dyn Field, a: DVec3, b: DVec3, accuracy: f64) -> f64 {
    if let Some(grid) = field.grid() {
        return grid.column(a, b, f64::INFINITY);
    }
    let (ray, length) = Ray::between(a, b);
    let Some((near, far)) = field.bounds().clip(&ray) else { return 0.0 };
    let far = far.min(length);
    let mut ends = vec![near, far];
    field.crossings(&ray, &mut ends);
    ends.retain(|t| (near..=far).contains(t));
    ends.sort_by(f64::total_cmp);
    let piece = |w: &[f64]| if w[1] > w[0] { integrate(|t| field.at(ray.at(t)), w[0], w[1], 0.1 * accuracy) } else { 0.0 };
    ends.windows(2).map(piece).sum()
}
