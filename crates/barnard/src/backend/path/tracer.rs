//! One path of light, backwards from the eye.
//!
//! A path carries four wavelengths. The first draws its collisions and directions; every wavelength's share is weighed
//! by how likely all four would have drawn the same path (balance heuristic; Wilkie et al. 2014, Hero wavelength
//! spectral sampling; Miller, Georgiev & Jarosz 2019 for null collisions). As extinction is k(λ) σ(x) everywhere, the
//! density of a path at wavelength i is e^(−k_i M) k_i^n Π p_i(θ), with M = ∫μ dt along it and n its collisions, null
//! ones too: all else is common.
//!
//! Starlight is added on each segment of the path twice, at its collision and at a place drawn in proportion to F(t) = Σ
//! L/r² (equiangular sampling, Kulla & Fajardo 2012), the two weighed so that their sum counts once: near a star, where
//! 1/r² has a peak, the second counts alone.
//!
//! A star's light may scatter `bounces` times; light of gas and background, which comes from everywhere, one time less.
//! One bounce is thus eq. (1) of docs/method.md.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

use glam::DVec3;

use super::majorant::Majorant;
use super::medium::{Leg, Medium};
use super::sampled_wavelengths::{CARRIED, SampledWavelengths, Wave, is_extended};
use crate::backend::seen_detail::SeenDetail;
use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::light::{Light, Route};
use crate::random::Counter;
use crate::scene::Scene;

/// Paths are ended by chance from this scattering on.
const ROULETTE: usize = 4;
/// The probability with which a segment begins towards the stars rather than by the phase function.
const TOWARDS_STARS: f64 = 0.25;
/// Rays pass stars at this distance at least [pc]: the light of one that is met has no finite radiance.
const NEAREST: f64 = 1e-6;

/// A number for each wavelength that is carried.
type CarriedLight = [f64; CARRIED];

/// The scene as paths meet it.
pub struct Tracer<'a> {
    lights: &'a [Light],
    medium: Option<Medium<'a>>,
    stars: Vec<PathStar>,
    species: Vec<PathSpecies<'a>>,
    background: Option<usize>,
    bands: Vec<SampledWavelengths>,
    /// Density detail below the voxel size, as seen by the eye.
    detail: Option<&'a SeenDetail>,
    /// The numbers of scatterings that are counted.
    bounces: RangeInclusive<usize>,
}

/// A star that lights the dust.
struct PathStar {
    light: usize,
    position: DVec3,
    /// The power that the star sends through each band, by which stars are drawn.
    power: Vec<f64>,
}

impl PathStar {
    /// L/r² at a place, of a band.
    fn fluence(&self, place: DVec3, band: usize) -> f64 {
        self.power[band] / (place - self.position).length_squared().max(NEAREST * NEAREST)
    }
}

/// A species of gas that glows.
struct PathSpecies<'a> {
    light: usize,
    density: &'a dyn crate::field::Field,
    majorant: Majorant,
}

/// The state of a path on its way.
struct PathState {
    waves: [Wave; CARRIED],
    /// The weight that is common to all wavelengths.
    weight: f64,
    /// Π ω of each wavelength.
    albedo: CarriedLight,
    /// The probability with which each wavelength would have drawn the path, relative to the first.
    likely: CarriedLight,
}

impl PathState {
    /// The weight of the light that wavelength `i` brings to where the path is now.
    fn share(&self, i: usize) -> f64 {
        self.weight * self.albedo[i] * self.likely[i] / self.likely.iter().sum::<f64>()
    }

    fn k(&self) -> CarriedLight {
        self.waves.map(|w| w.k)
    }

    /// The mean extinction of the wavelengths, on which weights may depend: it is the same whichever wavelength leads.
    fn mean_k(&self) -> f64 {
        self.k().iter().sum::<f64>() / CARRIED as f64
    }

    fn sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        (0..CARRIED).map(|i| self.share(i) * value(i)).sum()
    }
}

impl<'a> Tracer<'a> {
    /// A tracer of `lights` in `scene`, with density detail, that counts paths of a given number of scatterings.
    ///
    /// # Errors
    /// If a density has no bound, and on interruption by the user.
    pub fn new(
        scene: &'a Scene,
        lights: &'a [Light],
        detail: Option<&'a SeenDetail>,
        bounces: RangeInclusive<usize>,
        control: &Control,
    ) -> Result<Self> {
        let bands = (0..scene.bands.len()).map(|b| SampledWavelengths::new(scene, lights, b)).collect::<Result<Vec<_>>>()?;
        let (mut stars, mut species, mut background) = (Vec::new(), Vec::new(), None);
        for (light, l) in lights.iter().enumerate().filter(|(_, l)| is_extended(l.route)) {
            match l.route {
                Route::Scattered { star } => {
                    let power = scene.bands.iter().map(|band| band.integrate(|lambda| l.spectrum.continuum(lambda)));
                    let lines =
                        |b: usize| l.spectrum.lines().iter().map(move |line| scene.bands[b].response(line.lambda_um) * line.strength);
                    let power = power.enumerate().map(|(b, p)| p + lines(b).sum::<f64>()).collect();
                    stars.push(PathStar { light, position: scene.stars[star].position, power });
                }
                Route::Emitted { species: i } => {
                    let density = &*scene.species()[i].density;
                    species.push(PathSpecies { light, density, majorant: Majorant::new(density, control)? });
                }
                Route::Background => background = Some(light),
                Route::Direct { .. } | Route::FieldStar { .. } => {}
            }
        }
        let medium = scene.dust.as_ref().map(|dust| Medium::new(dust, detail, control)).transpose()?;
        Ok(Self { lights, medium, stars, species, background, bands, detail, bounces })
    }

    /// Radiance along `ray` through a band, in the mean of all `random` [W m⁻² sr⁻¹].
    pub fn radiance(&self, ray: Ray, band: usize, random: &mut Counter) -> f64 {
        if self.bands[band].is_dark() {
            return 0.0;
        }
        let waves = self.bands[band].draw(random.uniform());
        let mut path = PathState { waves, weight: 1.0, albedo: [1.0; CARRIED], likely: [1.0; CARRIED] };
        let mut leg = Leg { ray, from_eye: true };
        let mut radiance = 0.0;
        for scattered in 0..*self.bounces.end() {
            let counts = if scattered + 1 < *self.bounces.start() { 0.0 } else { 1.0 };
            radiance += counts * self.glow(&path, &leg, random);
            let Some(medium) = &self.medium else { return radiance + counts * self.behind(&path) };
            let segment = PathSegment::new(&self.stars, medium, leg, band);
            radiance += counts * self.near_stars(&path, medium, &segment, band, random);
            let k = path.k();
            let flight = medium.fly(&leg, k[0], random);
            path.weight *= flight.weight;
            for (likely, k_i) in path.likely.iter_mut().zip(k) {
                *likely *= (f64::from(flight.tentative) * (k_i / k[0]).ln() - (k_i - k[0]) * flight.bound_depth).exp();
            }
            let Some(t) = flight.collision else { return radiance + counts * self.behind(&path) };
            let place = leg.ray.at(t);
            for (albedo, wave) in path.albedo.iter_mut().zip(path.waves) {
                *albedo *= medium.dust.albedo.at(wave.lambda_um);
            }
            let weight = 1.0 - segment.by_stars(self.fluence(place, band), path.mean_k() * medium.sigma(&leg, t));
            radiance += counts * weight * self.lit(&path, medium, place, leg.ray.direction, band, random);
            if !self.survives(&mut path, scattered, random) {
                return radiance;
            }
            let ray = self.scatter(&mut path, medium, place, leg.ray.direction, band, random);
            leg = Leg { ray, from_eye: false };
        }
        radiance
    }

    /// Light of the background, where a path leaves.
    fn behind(&self, path: &PathState) -> f64 {
        self.background.map_or(0.0, |light| path.sum(|i| path.waves[i].of(light, self.lights)))
    }

    /// Light of glowing gas along a segment: at one place of each species, drawn by its bounds.
    fn glow(&self, path: &PathState, leg: &Leg, random: &mut Counter) -> f64 {
        let mut radiance = 0.0;
        for species in &self.species {
            let total: f64 = species.majorant.cells(&leg.ray, f64::INFINITY).map(|(start, end, bound)| bound * (end - start)).sum();
            if total <= 0.0 {
                continue;
            }
            let mut left = random.uniform() * total;
            let drawn = species.majorant.cells(&leg.ray, f64::INFINITY).find_map(|(start, end, bound)| {
                let most = bound * (end - start);
                left -= most;
                (left < 0.0).then(|| (end + left / bound, bound))
            });
            let Some((t, bound)) = drawn else { continue };
            let glow = leg.density(species.density, self.detail, t) * total / bound;
            let through = self.medium.as_ref().map_or([1.0; CARRIED], |m| m.transmittances(leg, t, &path.k(), random));
            radiance += glow * path.sum(|i| through[i] * path.waves[i].of(species.light, self.lights));
        }
        radiance
    }

    /// F = Σ L/r² at a place, of a band.
    fn fluence(&self, place: DVec3, band: usize) -> f64 {
        self.stars.iter().map(|s| s.fluence(place, band)).sum()
    }

    /// Starlight scattered once on a segment of the path, at a place drawn in proportion to F.
    fn near_stars(&self, path: &PathState, medium: &Medium, segment: &PathSegment, band: usize, random: &mut Counter) -> f64 {
        let Some(star) = picked(segment.stars.iter().map(|s| s.0), segment.total, random) else { return 0.0 };
        let t = segment.stars[star].1.place(random.uniform());
        let (place, sigma) = (segment.leg.ray.at(t), medium.sigma(&segment.leg, t));
        if sigma == 0.0 {
            return 0.0;
        }
        let k = path.k();
        let through = medium.transmittances(&segment.leg, t, &k, random);
        let fluence = self.fluence(place, band);
        // ∫ over t with the density F/total, and the part of the light that collisions do not bring.
        let weight = segment.total / fluence * sigma * segment.by_stars(fluence, path.mean_k() * sigma);
        let mut there = PathState { ..*path };
        for i in 0..CARRIED {
            there.albedo[i] *= through[i] * k[i] * medium.dust.albedo.at(path.waves[i].lambda_um);
        }
        weight * self.lit(&there, medium, place, segment.leg.ray.direction, band, random)
    }

    /// Light of one star, drawn by power and distance, that scatters at `place` against `direction`.
    fn lit(&self, path: &PathState, medium: &Medium, place: DVec3, direction: DVec3, band: usize, random: &mut Counter) -> f64 {
        let total = self.fluence(place, band);
        if total <= 0.0 {
            return 0.0;
        }
        let star = self.drawn(place, total, band, random);
        let (to_star, distance) = Ray::between(place, star.position);
        // 1/r² over the chance of the star.
        let chance = total / star.power[band];
        let cosine = to_star.direction.dot(direction);
        let through = medium.transmittances(&Leg { ray: to_star, from_eye: false }, distance, &path.k(), random);
        let phase = |i: usize| medium.dust.phase.at(cosine, path.waves[i].lambda_um);
        chance * path.sum(|i| through[i] * phase(i) * path.waves[i].of(star.light, self.lights))
    }

    /// Ends long paths by chance; those that go on count more.
    fn survives(&self, path: &mut PathState, scattered: usize, random: &mut Counter) -> bool {
        let brightest = (0..CARRIED).map(|i| (CARRIED as f64 * path.share(i)).abs()).fold(0.0, f64::max);
        if scattered + 1 < ROULETTE || brightest >= 1.0 {
            return brightest > 0.0;
        }
        path.weight /= brightest;
        random.uniform() < brightest
    }

    /// A new segment: by the phase function of the first wavelength, now and then towards a star.
    ///
    /// A segment that passes a star at the distance b brings light as 1/b, that is as 1/sin ϑ with ϑ the angle between segment
    /// and star: segments with ϑ drawn evenly, 1/(2π² sin ϑ) a steradian, take that peak away.
    fn scatter(&self, path: &mut PathState, medium: &Medium, place: DVec3, direction: DVec3, band: usize, random: &mut Counter) -> Ray {
        let phase = &medium.dust.phase;
        let total = self.fluence(place, band);
        let towards = if total > 0.0 { TOWARDS_STARS } else { 0.0 };
        let new = if random.uniform() < towards {
            let star = self.drawn(place, total, band, random);
            let (sine, cosine) = (PI * random.uniform()).sin_cos();
            around((star.position - place).normalize_or(DVec3::Z), cosine, sine, random)
        } else {
            let cosine = phase.sample(path.waves[0].lambda_um, random);
            around(direction, cosine, (1.0 - cosine * cosine).max(0.0).sqrt(), random)
        };
        let by_star = |star: &PathStar| {
            let sine = new.cross((star.position - place).normalize_or(DVec3::Z)).length().max(f64::MIN_POSITIVE);
            star.fluence(place, band) / total / (2.0 * PI * PI * sine)
        };
        let by_stars: f64 = if towards > 0.0 { towards * self.stars.iter().map(by_star).sum::<f64>() } else { 0.0 };
        let cosine = new.dot(direction);
        let phases = path.waves.map(|w| phase.at(cosine, w.lambda_um));
        let densities = phases.map(|p| (1.0 - towards) * p + by_stars);
        for i in 0..CARRIED {
            path.albedo[i] *= phases[i] / densities[i];
            path.likely[i] *= densities[i] / densities[0];
        }
        Ray { origin: place, direction: new }
    }

    /// A star by its share of `total`, the light of all at `place`.
    fn drawn(&self, place: DVec3, total: f64, band: usize, random: &mut Counter) -> &PathStar {
        let found = picked(self.stars.iter().map(|s| s.fluence(place, band)), total, random);
        // What rounding leaves over belongs to the last.
        &self.stars[found.unwrap_or(self.stars.len() - 1)]
    }
}

/// A direction at an angle from another, anywhere around it.
fn around(axis: DVec3, cosine: f64, sine: f64, random: &mut Counter) -> DVec3 {
    let (across, other) = axis.any_orthonormal_pair();
    let (y, x) = (TAU * random.uniform()).sin_cos();
    (cosine * axis + sine * (x * across + y * other)).normalize()
}

/// Draws one of some shares of `total`; none where all are nothing, or rounding leaves the draw over.
fn picked(mut shares: impl Iterator<Item = f64>, total: f64, random: &mut Counter) -> Option<usize> {
    if total <= 0.0 {
        return None;
    }
    let mut left = random.uniform() * total;
    shares.position(|share| {
        left -= share;
        left < 0.0
    })
}

/// A segment of a path as the stars see it.
struct PathSegment {
    leg: Leg,
    /// For each star, its power times ∫dt/r² through the dust, and the distribution of angles.
    stars: Vec<(f64, Equiangular)>,
    /// The sum over all stars, ∫F dt.
    total: f64,
}

impl PathSegment {
    fn new(stars: &[PathStar], medium: &Medium, leg: Leg, band: usize) -> Self {
        let light = |star: &PathStar, (near, far)| {
            let angles = Equiangular::new(&leg.ray, star.position, near, far);
            (star.power[band] * angles.integral(), angles)
        };
        let stars: Vec<_> =
            medium.extent(&leg.ray).into_iter().flat_map(|extent| stars.iter().map(move |star| light(star, extent))).collect();
        Self { leg, total: stars.iter().map(|s| s.0).sum(), stars }
    }

    /// The probability with which a place is drawn by the stars, F/∫F dt, beside that by collision, kσ.
    fn by_stars(&self, fluence: f64, by_collision: f64) -> f64 {
        let both = fluence + by_collision * self.total;
        if both > 0.0 { fluence / both } else { 1.0 }
    }
}

/// Places along a ray in equal steps of the angle at which a star sees them: t = t₀ + b tan ϑ.
#[derive(Debug, Clone, Copy)]
struct Equiangular {
    foot: f64,
    distance: f64,
    angles: (f64, f64),
}

impl Equiangular {
    fn new(ray: &Ray, star: DVec3, near: f64, far: f64) -> Self {
        let foot = (star - ray.origin).dot(ray.direction);
        let distance = (star - ray.at(foot)).length().max(NEAREST);
        Self { foot, distance, angles: (((near - foot) / distance).atan(), ((far - foot) / distance).atan()) }
    }

    /// ∫dt/r² over the ray's way through the dust [pc⁻¹].
    fn integral(&self) -> f64 {
        (self.angles.1 - self.angles.0) / self.distance
    }

    fn place(&self, u: f64) -> f64 {
        self.foot + self.distance * (self.angles.0 + u * (self.angles.1 - self.angles.0)).tan()
    }
}
