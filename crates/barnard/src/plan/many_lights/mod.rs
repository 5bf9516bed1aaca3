//! The many lights: stars that are too many to be marched one by one.
//!
//! A star's light is split by a smooth kernel around it,
//!
//!   1/r² = w/r² + (1 − w)/r²                                                        eq. (24) of docs/method.md
//!
//! so that the second part is smooth: that of all stars together is gathered in cells (`multiple_scattering`) and
//! marched as one field. The first part is marched star by star, but only where it is: a ray meets few of the
//! neighbourhoods. So a frame does not grow with the stars. Depths of these stars are swept through merged
//! dust, at most 32 voxels an edge: what is finer of their shadows is lost.

pub mod near_field_kernel;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use spectra::passband::Passband;

use crate::control::{Control, Stage};
use crate::error::Result;
use crate::field::{Field, Grid, Lattice};
use crate::geometry::{Bounds, Ray};
use crate::memory;
use crate::plan::Options;
use crate::plan::many_lights::near_field_kernel::{NearFieldKernel, PROFILE, Profile};
use crate::plan::star_depths::{self, Progress};
use crate::scene::{Scene, Star, StarDepthSource};
use crate::volume::{Bricks, Channel, ChannelMut, Volume};

/// Up to this number, stars are marched one by one by default.
const ALL: usize = 8;
/// The part of all light through a band from which on a star is marched by itself, where there are more.
const BRIGHT: f64 = 0.5;
/// Most voxels along an edge of the depths of one star, fewest where memory is short, and the part of the memory that
/// all may take.
const EDGE: usize = 32;
const MIN_EDGE: usize = 8;
const MEMORY_SHARE: u64 = 4;
/// Stars that are looked for together.
const GROUP: usize = 16;
/// Gathered stars that pilot rays march where no other star shines.
const REPRESENTATIVES: usize = 4;

/// The many lights of one scene.
#[derive(Debug, Clone)]
pub struct ManyLights {
    /// Numbers of its stars in the scene; neighbours in space stand beside each other.
    pub stars: Vec<usize>,
    /// The places of these stars \[pc\].
    pub places: Vec<DVec3>,
    /// The extinction σ at V at each of them [pc⁻¹].
    pub sigma: Vec<f32>,
    /// True if each star of the scene is one of these.
    member: Vec<bool>,
    /// The brightest, by which pilot rays choose their steps where all stars are among the many lights.
    pub representatives: Vec<usize>,
    /// Depths at V from each of them.
    depths: Vec<Arc<Volume>>,
    /// The dust that the depths were swept through.
    dust: Arc<Grid>,
    groups: Vec<StarGroup>,
}

/// Neighbouring stars in a sphere.
#[derive(Debug, Clone)]
struct StarGroup {
    centre: DVec3,
    radius: f64,
    stars: Range<usize>,
}

/// The stars of `scene` that `method` gathers, from the brightest on.
pub fn members(scene: &Scene) -> Vec<usize> {
    let method = &scene.method;
    let can = scene.dust.is_some() && method.entry.rule.nodes && method.entry.star_depth == StarDepthSource::Cached;
    if !can || scene.stars.len() <= method.exact_stars.unwrap_or(ALL) {
        return Vec::new();
    }
    let parts = brightness(&scene.stars, &scene.bands);
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|a, b| parts[*b].total_cmp(&parts[*a]));
    let marched = method.exact_stars.unwrap_or_else(|| parts.iter().filter(|part| **part > BRIGHT).count());
    order.split_off(marched.min(order.len()))
}

/// The largest part that each star has of the light of all through any band.
fn brightness(stars: &[Star], bands: &[Passband]) -> Vec<f64> {
    let power = |star: &Star, band: &Passband| {
        let lines = star.spectrum.lines().iter().map(|line| line.strength * band.response(line.lambda_um)).sum::<f64>();
        band.integrate(|lambda| star.spectrum.continuum(lambda)) + lines
    };
    let of_band = |band: &Passband| {
        let powers: Vec<f64> = stars.par_iter().map(|star| power(star, band)).collect();
        let all = powers.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        powers.into_iter().map(|power| power / all).collect::<Vec<f64>>()
    };
    let none = vec![0.0; stars.len()];
    bands.iter().map(of_band).fold(none, |most, part_values| most.iter().zip(part_values).map(|(m, o)| m.max(o)).collect())
}

impl ManyLights {
    /// The stars `members`, from the brightest on, of those at `places` [pc] in `dust`, with depths of at most `edge`
    /// voxels an edge; those that other many lights have swept through the same dust are not swept again.
    ///
    /// # Errors
    /// For more memory than is allowed, and on interruption by the user.
    pub(crate) fn new(
        before: Option<&Self>,
        members: &[usize],
        places: &[DVec3],
        dust: &Arc<Grid>,
        options: &Options,
        control: &Control,
    ) -> Result<Self> {
        // The order is that of places, whatever shines.
        let mut stars = members.to_vec();
        stars.sort_unstable();
        let mut groups = Vec::new();
        group(&mut stars, places, 0, &mut groups);
        let positions: Vec<DVec3> = stars.iter().map(|star| places[*star]).collect();
        let (merged, lattice) = fitting(dust, stars.len(), options)?;
        let known = before.filter(|b| Arc::ptr_eq(&b.dust, dust) && b.depths.first().is_some_and(|d| d.inner == lattice));
        let bits = |place: &DVec3| place.to_array().map(f64::to_bits);
        let known: HashMap<[u64; 3], &Arc<Volume>> = known.iter().flat_map(|b| b.places.iter().map(bits).zip(&b.depths)).collect();
        let done = AtomicU64::new(0);
        let swept = |place: &DVec3| -> Result<Arc<Volume>> {
            control.check()?;
            let depths = match known.get(&bits(place)) {
                Some(depths) => Arc::clone(depths),
                None => {
                    let mut volume = Volume::zeroed(&lattice, vec![Channel::StarDepth(0)]);
                    star_depths::bake(
                        &merged,
                        *place,
                        ChannelMut { volume: &mut volume, slot: 0 },
                        Progress::UNHEARD,
                        &Control::default(),
                    )?;
                    Arc::new(volume)
                }
            };
            control.report(Stage::StarDepths, done.fetch_add(1, Ordering::Relaxed) + 1, positions.len() as u64);
            Ok(depths)
        };
        let depths = positions.par_iter().map(swept).collect::<Result<Vec<_>>>()?;
        let sigma = positions.iter().map(|place| dust.at(*place) as f32).collect();
        let representatives = representatives(members, places.len());
        let member = mask(members, places.len());
        Ok(Self { stars, places: positions, member, sigma, representatives, depths, dust: dust.clone(), groups })
    }

    /// Copy of the stars with other representatives, where others are the brightest; none where they are not.
    pub fn led_by(&self, members: &[usize]) -> Option<Self> {
        let representatives = representatives(members, self.member.len());
        (representatives != self.representatives).then(|| Self { representatives, ..self.clone() })
    }

    /// Copy of the stars in `dust`, which is `ratio` times the dust before; none where depths were or would be cut.
    pub fn scaled(&self, ratio: f64, dust: &Arc<Grid>) -> Option<Self> {
        let largest = self.depths.iter().map(|depths| depths.largest(0)).fold(0.0, f32::max);
        let fits = ratio.is_finite() && ratio > 0.0 && f64::from(largest) * ratio.max(1.0) < 0.99 * star_depths::OPAQUE;
        fits.then(|| {
            let scaled = |volume: &Arc<Volume>| {
                let mut volume = (**volume).clone();
                volume.scale(0, ratio as f32);
                Arc::new(volume)
            };
            let sigma = self.places.iter().map(|place| dust.at(*place) as f32).collect();
            Self { depths: self.depths.par_iter().map(scaled).collect(), sigma, dust: dust.clone(), ..self.clone() }
        })
    }

    /// True if a star of the scene is one of these.
    pub fn holds(&self, star: usize) -> bool {
        self.member.get(star) == Some(&true)
    }

    /// Depth at V from star number `i` to a near place of extinction σ: that of a mean of both ends \[1\].
    pub fn near_depth(&self, i: usize, distance_pc: f64, sigma: f64) -> f64 {
        0.5 * distance_pc * (f64::from(self.sigma[i]) + sigma)
    }

    /// The profile of each star for an eye in its direction, as far as its kernel goes.
    pub fn profiles(&self, kernels: &[NearFieldKernel], eye: impl Fn(DVec3) -> DVec3 + Sync) -> Vec<Profile> {
        let profile = |(place, kernel): (&DVec3, &NearFieldKernel)| {
            let step = kernel.ahead_pc / PROFILE as f64 * eye(*place);
            let mut depth = 0.0;
            std::array::from_fn(|i| {
                if i > 0 {
                    depth += self.dust.column(*place + (i - 1) as f64 * step, *place + i as f64 * step, star_depths::OPAQUE);
                }
                depth.min(star_depths::OPAQUE) as f32
            })
        };
        self.places.par_iter().zip(kernels).map(profile).collect()
    }

    /// Depths at V from star number `i` along the row at (y, z) \[pc\], from voxel to voxel.
    pub fn row(&self, i: usize, [y, z]: [f64; 2], out: &mut Vec<f32>) {
        let volume = &self.depths[i];
        let Lattice { dims: [nx, ny, nz], bounds } = volume.lattice;
        let voxel = volume.lattice.voxel_pc();
        let along = |at: f64, low: f64, edge: f64, count: usize| {
            let u = ((at - low) / edge - 0.5).clamp(0.0, (count - 1) as f64);
            let first = (u as usize).min(count - 2);
            (first, (u - first as f64) as f32)
        };
        let ((y, fy), (z, fz)) = (along(y, bounds.low.y, voxel.y, ny), along(z, bounds.low.z, voxel.z, nz));
        let row = |dy: usize, dz: usize| &volume.single()[volume.lattice.index(0, y + dy, z + dz)..][..nx];
        let (a, b, c, d) = (row(0, 0), row(1, 0), row(0, 1), row(1, 1));
        out.clear();
        out.extend((0..nx).map(|x| {
            let (low, high) = (a[x] + fy * (b[x] - a[x]), c[x] + fy * (d[x] - c[x]));
            low + fz * (high - low)
        }));
    }

    /// The lattice of their depths, with the layer around it.
    pub fn lattice(&self) -> Option<&Lattice> {
        self.depths.first().map(|d| &d.lattice)
    }

    /// Voxels along the longest edge of its depths.
    pub fn edge(&self) -> usize {
        self.depths.first().and_then(|d| d.inner.dims.into_iter().max()).unwrap_or(0)
    }

    /// The largest depth at a place with dust \[1\].
    pub fn deepest(&self, dust: &Bricks) -> f64 {
        self.depths.par_iter().map(|d| f64::from(star_depths::deepest(d, 0, dust))).reduce(|| 0.0, f64::max)
    }

    /// Numbers among the many lights of stars no farther than `reach` \[pc\] from `ray` between two distances.
    pub fn beside(&self, ray: &Ray, near: f64, far: f64, reach: f64) -> impl Iterator<Item = usize> {
        let square = move |place: DVec3| (ray.at((place - ray.origin).dot(ray.direction).clamp(near, far)) - place).length_squared();
        let groups = self.groups.iter().filter(move |group| square(group.centre) <= (group.radius + reach).powi(2));
        groups.flat_map(|group| group.stars.clone()).filter(move |i| square(self.places[*i]) <= reach * reach)
    }

    /// The bytes that all depths take.
    pub fn bytes(&self) -> u64 {
        self.depths.iter().map(|d| d.bytes()).sum()
    }
}

/// For each of a given number of stars, whether it is one of `members`.
pub fn mask(members: &[usize], stars: usize) -> Vec<bool> {
    let mut mask = vec![false; stars];
    members.iter().for_each(|star| mask[*star] = true);
    mask
}

/// The brightest, where there is no star beside them.
fn representatives(members: &[usize], stars: usize) -> Vec<usize> {
    members.iter().copied().take(if members.len() == stars { REPRESENTATIVES } else { 0 }).collect()
}

/// Dust that is merged for sweeps, and the lattice of the depths of `count` stars that fits into memory.
fn fitting(dust: &Grid, count: usize, options: &Options) -> Result<(Grid, Lattice)> {
    let longest = dust.lattice().dims.into_iter().max().unwrap_or(1);
    // The sweeps of a lattice read the dust at two places a voxel.
    let merged = dust.merged(longest.div_ceil(2 * EDGE), 1.0);
    let lattice_of = |edge: usize| {
        let block = merged.lattice().dims.into_iter().max().unwrap_or(1).div_ceil(edge);
        Lattice { dims: merged.lattice().dims.map(|n| n.div_ceil(block)), bounds: merged.lattice().bounds }
    };
    let bytes = |lattice: &Lattice| Volume::zeroed(lattice, vec![Channel::StarDepth(0)]).bytes().saturating_mul(count as u64);
    let mut edge = EDGE;
    while bytes(&lattice_of(edge)) > options.memory_limit / MEMORY_SHARE && edge > MIN_EDGE {
        edge = (edge / 2).max(MIN_EDGE);
    }
    let lattice = lattice_of(edge);
    memory::check(&format!("depths of {count} stars"), bytes(&lattice), options.memory_limit)?;
    Ok((merged, lattice))
}

/// Orders stars by halves along the longest axis of their box until few are left.
fn group(stars: &mut [usize], places: &[DVec3], first: usize, out: &mut Vec<StarGroup>) {
    let box_of = |stars: &[usize]| {
        let empty = Bounds { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        stars.iter().fold(empty, |b, s| Bounds { low: b.low.min(places[*s]), high: b.high.max(places[*s]) })
    };
    let bounds = box_of(stars);
    if stars.len() <= GROUP {
        let centre = 0.5 * (bounds.low + bounds.high);
        let radius = stars.iter().map(|s| (places[*s] - centre).length()).fold(0.0, f64::max);
        out.extend((!stars.is_empty()).then(|| StarGroup { centre, radius, stars: first..first + stars.len() }));
        return;
    }
    let size = bounds.size();
    let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
    // Equal coordinates by number.
    stars.sort_unstable_by(|a, b| places[*a][axis].total_cmp(&places[*b][axis]).then(a.cmp(b)));
    let (low, high) = stars.split_at_mut(stars.len() / 2);
    let middle = first + low.len();
    group(low, places, first, out);
    group(high, places, middle, out);
}

#[cfg(test)]
mod tests {
    use super::near_field_kernel::depth_within;
    use super::*;

    fn dust() -> Arc<Grid> {
        let lattice =
            Lattice { dims: [40, 36, 30], bounds: Bounds { low: DVec3::new(-1.0, -0.9, -0.75), high: DVec3::new(1.0, 0.9, 0.75) } };
        Arc::new(Grid::sampled(lattice, |p| 2.0 + (5.0 * p.x).sin() + p.y * p.z))
    }

    fn places(count: usize) -> Vec<DVec3> {
        let part = |i: usize, step: f64| 1.6 * (step * (i + 1) as f64).fract() - 0.8;
        (0..count).map(|i| DVec3::new(part(i, 0.618_034), part(i, 0.414_214), 0.8 * part(i, 0.732_051))).collect()
    }

    fn many_lights(before: Option<&ManyLights>, places: &[DVec3], dust: &Arc<Grid>) -> ManyLights {
        let members: Vec<usize> = (0..places.len()).collect();
        ManyLights::new(before, &members, places, dust, &Options::default(), &Control::default()).unwrap()
    }

    /// Rows of depths and profiles are those of exact columns, as far as merged dust goes.
    #[test]
    fn depths_are_those_of_columns() {
        let (dust, places) = (dust(), places(20));
        let many_lights = many_lights(None, &places, &dust);
        let lattice = many_lights.lattice().unwrap().clone();
        let mut row = Vec::new();
        for (i, star) in many_lights.places.iter().enumerate() {
            many_lights.row(i, [0.21, -0.33], &mut row);
            for x in 1..lattice.dims[0] - 1 {
                let place = DVec3::new(lattice.centre(x, 0, 0).x, 0.21, -0.33);
                let exact = dust.column(*star, place, f64::INFINITY);
                assert!((f64::from(row[x]) - exact).abs() < 0.02 * (1.0 + exact), "{star} {place}: {} {exact}", row[x]);
            }
        }
        let kernel = NearFieldKernel { reach_pc: 0.1, ahead_pc: 0.4 };
        let profiles = many_lights.profiles(&vec![kernel; 20], |_| DVec3::Z);
        for (profile, star) in profiles.iter().zip(&many_lights.places) {
            let exact = |part: f64| dust.column(*star, *star + 0.4 * part * DVec3::Z, f64::INFINITY);
            let inverse_step = PROFILE as f32 / 0.4;
            // At its places, and between two of them.
            for (part, tolerance) in [(0.0, 1e-6), (0.25, 1e-5), (0.75, 1e-5), (1.0, 1e-5), (0.3, 0.01)] {
                let found = f64::from(depth_within(profile, inverse_step, 1.0, 0.4 * part as f32, 1.0));
                assert!((found - exact(part)).abs() < tolerance, "{part}: {found} {}", exact(part));
            }
            // Behind a star its profile does not count.
            assert_eq!(depth_within(profile, inverse_step, 1.5, 0.1, -0.5), 0.15);
        }
    }

    /// Stars that stay are not swept again, whatever their order is; one that moves is, and has the depths of many
    /// lights that are new.
    #[test]
    fn only_what_moved_is_swept() {
        let (dust, mut places) = (dust(), places(50));
        let first = many_lights(None, &places, &dust);
        places[7] = DVec3::new(-0.5, 0.5, 0.3);
        let (moved, new) = (many_lights(Some(&first), &places, &dust), many_lights(None, &places, &dust));
        assert_eq!(moved.stars, new.stars);
        for i in 0..50 {
            let at = first.stars.iter().position(|star| *star == moved.stars[i]).unwrap();
            assert_eq!(Arc::ptr_eq(&moved.depths[i], &first.depths[at]), moved.stars[i] != 7);
            assert!(moved.depths[i].single() == new.depths[i].single());
        }
        // Through other dust all are.
        let other = self::dust();
        let swept = many_lights(Some(&first), &places, &other);
        assert!((0..50).all(|i| !first.depths.iter().any(|d| Arc::ptr_eq(d, &swept.depths[i]))));
    }

    /// The stars that are found beside a ray are those that a look at every star finds.
    #[test]
    fn stars_beside_a_ray_are_found() {
        let (dust, places) = (dust(), places(300));
        let many_lights = many_lights(None, &places, &dust);
        for i in 0..40 {
            let ray = Ray { origin: places[i], direction: (places[i + 60] - places[i]).normalize() };
            for (span, reach) in [((0.0, 2.0), 0.1), ((0.3, 0.5), 0.02), ((-1.0, f64::INFINITY), 0.3)] {
                let far = |p: DVec3| (ray.at((p - ray.origin).dot(ray.direction).clamp(span.0, span.1)) - p).length();
                let mut found: Vec<usize> = many_lights.beside(&ray, span.0, span.1, reach).collect();
                found.sort_unstable();
                let expected: Vec<usize> = (0..300).filter(|s| far(many_lights.places[*s]) <= reach).collect();
                assert_eq!(found, expected);
            }
        }
    }
}
