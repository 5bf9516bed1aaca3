//! Fractional Brownian motion on simplex noise, as in Barrès & Neyret, with its ridged and warped variants.
//!
//! f(p) = max(0, offset + Σ_{i<octaves} gainⁱ n_i(p lacunarityⁱ / scale)) · falloff(|p|/radius)
//!
//! | variant | n_i |
//! |---|---|
//! | plain | n |
//! | ridged | 1 − 2|n| |
//! | warped | n(p + warp · (n', n'', n''')) |
//!
//! Falloff: 1 − smoothstep between half the radius and the radius, so the cloud ends inside its box. Unit: 1.

use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::Digest;
use spectra::simd;
use spectra::units::Length;

use super::{Field, Simplex, above_zero, place, within};
use crate::data::Inputs;
use crate::error::Result;
use crate::geometry::Bounds;
use crate::properties::{Choice, Choices, Integer, Key, Kind, Number, OrDefault, Position, Section};

const SEED: Key<Integer<u32>, OrDefault> = Key::integer("seed", "seed of the noise").default(1);
const CENTRE: Key<Position, OrDefault> = Key::position("centre", "centre of the cloud").default("0 0 0 pc");
const RADIUS: Key<Length, OrDefault> =
    Key::quantity::<Length>("radius", "radius of the cloud; it fades from half of it on").positive().default("1 pc");
const SCALE: Key<Length, OrDefault> = Key::quantity::<Length>("scale", "size of the largest structures").positive().default("0.7 pc");
const OCTAVES: Key<Integer<i32>, OrDefault> = Key::integer("octaves", "number of octaves").range(1..=12).default(5);
const LACUNARITY: Key<Number, OrDefault> =
    Key::number("lacunarity", "frequency ratio of successive octaves").range(1.0..=16.0).default(2.0);
const GAIN: Key<Number, OrDefault> = Key::number("gain", "amplitude ratio of successive octaves").range(0.0..=1.0).default(0.5);
const OFFSET: Key<Number, OrDefault> =
    Key::number("offset", "offset before clipping at zero; larger values fill more of space").range(-10.0..=10.0).default(0.2);
const VARIANT: Key<Choice<Variant>, OrDefault> = Key::choice("variant", "shape of the noise").default("plain");
const WARP: Key<Length, OrDefault> = Key::quantity::<Length>("warp", "strength of domain warping by a second noise").default("0 pc");

#[derive(Clone, Copy)]
enum Variant {
    Plain,
    Ridged,
}

impl Choices for Variant {
    const ROWS: &'static [(&'static str, Self)] = &[("plain", Self::Plain), ("ridged", Self::Ridged)];
}

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "fbm",
    summary: "fractional Brownian motion of simplex noise (values of about 0 to 1)",
    keys: &[SEED.row, CENTRE.row, RADIUS.row, SCALE.row, OCTAVES.row, LACUNARITY.row, GAIN.row, OFFSET.row, VARIANT.row, WARP.row],
    build,
};

/// A cloud of fractal noise.
#[derive(Debug, Clone)]
pub struct Fbm {
    /// The noise of all octaves.
    pub noise: Simplex,
    /// The noises that bend space along x, y and z.
    pub warps: [Simplex; 3],
    /// The middle of the cloud \[pc\].
    pub centre: DVec3,
    /// The radius at which the cloud has ended \[pc\].
    pub radius: f64,
    /// Size of the largest structures \[pc\].
    pub scale: f64,
    /// The number of octaves.
    pub octaves: i32,
    /// Ratio of frequencies from octave to octave.
    pub lacunarity: f64,
    /// The ratio of the amplitudes of successive octaves.
    pub gain: f64,
    /// The number that is added before the cut at zero.
    pub offset: f64,
    /// True if octaves are 1 − 2|n| instead of n.
    pub ridged: bool,
    /// The length by which space is bent \[pc\].
    pub warp: f64,
}

fn build(section: &Section, _: &Inputs) -> Result<Arc<dyn Field>> {
    let seed = section.read(&SEED)?;
    let plain = Fbm::new(seed);
    let fbm = Fbm {
        centre: section.read(&CENTRE)?,
        radius: section.read(&RADIUS)?.0,
        scale: section.read(&SCALE)?.0,
        octaves: section.read(&OCTAVES)?,
        lacunarity: section.read(&LACUNARITY)?,
        gain: section.read(&GAIN)?,
        offset: section.read(&OFFSET)?,
        ridged: matches!(section.read(&VARIANT)?, Variant::Ridged),
        warp: section.read(&WARP)?.0,
        ..plain
    };
    Ok(Arc::new(section.wrap("kind", fbm.checked())?))
}

impl Fbm {
    /// Noise number `seed`, as a scene has it that says nothing else: a cloud of radius 1 pc around the origin. Change
    /// its fields, then ask [`checked`](Self::checked).
    pub fn new(seed: u32) -> Self {
        Self {
            noise: Simplex::new(seed),
            warps: [1, 2, 3].map(|i| Simplex::new(seed.wrapping_add(0x9e37_79b9u32.wrapping_mul(i)))),
            centre: DVec3::ZERO,
            radius: 1.0,
            scale: 0.7,
            octaves: 5,
            lacunarity: 2.0,
            gain: 0.5,
            offset: 0.2,
            ridged: false,
            warp: 0.0,
        }
    }

    /// Validated cloud.
    ///
    /// # Errors
    /// If a length is not above zero, or a number lies outside of what scenes may say.
    pub fn checked(self) -> Result<Self> {
        self.check()?;
        Ok(self)
    }

    /// The values at `N` places at most.
    fn block<const N: usize>(&self, places: &[DVec3], values: &mut [f64]) {
        let (mut from_middle, mut r): (PlaceBlock<N>, _) = ([[0.0; N]; 3], [0.0; N]);
        for (i, p) in places.iter().enumerate() {
            let q = *p - self.centre;
            (0..3).for_each(|axis| from_middle[axis][i] = q[axis]);
            r[i] = q.length() / self.radius;
        }
        if r[..places.len()].iter().all(|r| *r >= 1.0) {
            values.fill(0.0);
            return;
        }
        let mut bent = from_middle;
        if self.warp != 0.0 {
            for (noise, bent) in self.warps.iter().zip(&mut bent) {
                let warp = noises(noise, &scaled(&from_middle, |x| x / self.scale));
                bent.iter_mut().zip(warp).for_each(|(q, warp)| *q += self.warp * warp);
            }
        }
        let (mut frequency, mut amplitude, mut sum) = (1.0 / self.scale, 1.0, [self.offset; N]);
        for _ in 0..self.octaves {
            let octave = noises(&self.noise, &scaled(&bent, |x| x * frequency));
            let folded = |n: f64| if self.ridged { 1.0 - 2.0 * n.abs() } else { n };
            sum.iter_mut().zip(octave).for_each(|(sum, n)| *sum += amplitude * folded(n));
            frequency *= self.lacunarity;
            amplitude *= self.gain;
        }
        for (value, (sum, r)) in values.iter_mut().zip(sum.iter().zip(r)) {
            let edge = ((r - 0.5) / 0.5).clamp(0.0, 1.0);
            *value = if r < 1.0 { sum.max(0.0) * (1.0 - edge * edge * (3.0 - 2.0 * edge)) } else { 0.0 };
        }
    }
}

/// Places whose noise is evaluated together.
const BLOCK: usize = 64;

/// The coordinates of some places, axis × place.
type PlaceBlock<const N: usize> = [[f64; N]; 3];

fn scaled<const N: usize>(places: &PlaceBlock<N>, scale: impl Fn(f64) -> f64) -> PlaceBlock<N> {
    places.map(|axis| axis.map(&scale))
}

simd! {
    /// The noise at some places.
    fn noises<const N: usize>(noise: &Simplex, [x, y, z]: &PlaceBlock<N>) -> [f64; N] {
        let mut out = [0.0; N];
        for (i, out) in out.iter_mut().enumerate() {
            *out = noise.noise([x[i], y[i], z[i]]);
        }
        out
    }
}

impl Field for Fbm {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn check(&self) -> Result<()> {
        place("centre", self.centre)?;
        above_zero("radius", self.radius)?;
        above_zero("scale", self.scale)?;
        OCTAVES.check(f64::from(self.octaves))?;
        LACUNARITY.check(self.lacunarity)?;
        GAIN.check(self.gain)?;
        OFFSET.check(self.offset)?;
        within("warp", self.warp, -f64::MAX..=f64::MAX)?;
        Ok(())
    }

    fn at(&self, p: DVec3) -> f64 {
        let mut value = [0.0];
        self.block::<1>(&[p], &mut value);
        value[0]
    }
    fn sample(&self, places: &[DVec3], values: &mut [f64]) {
        for (places, values) in places.chunks(BLOCK).zip(values.chunks_mut(BLOCK)) {
            self.block::<BLOCK>(places, values);
        }
    }
    fn bounds(&self) -> Bounds {
        Bounds::cube(self.centre, self.radius)
    }
    fn fbm(&self) -> Option<&Fbm> {
        Some(self)
    }
    fn feature_pc(&self) -> f64 {
        0.25 * self.scale / self.lacunarity.powi(self.octaves - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(seed: u32, ridged: bool, warp: f64) -> Fbm {
        Fbm {
            noise: Simplex::new(seed),
            warps: [4, 5, 6].map(Simplex::new),
            centre: DVec3::ZERO,
            radius: 1.0,
            scale: 0.5,
            octaves: 4,
            lacunarity: 2.0,
            gain: 0.5,
            offset: 0.2,
            ridged,
            warp,
        }
    }

    #[test]
    fn never_negative_and_ends_at_its_radius() {
        for (ridged, warp) in [(false, 0.0), (true, 0.0), (false, 0.3)] {
            let cloud = cloud(3, ridged, warp);
            let points = (0..5000).map(|i| DVec3::new((i as f64 * 0.61).sin(), (i as f64 * 0.37).cos(), (i as f64 * 0.23).sin()));
            let values: Vec<(f64, f64)> = points.map(|p| (p.length(), cloud.at(p))).collect();
            assert!(values.iter().all(|(r, v)| *v >= 0.0 && (*r < 1.0 || *v == 0.0)));
            assert!(values.iter().any(|(_, v)| *v > 0.3));
        }
    }

    /// Side by side the values have the bits that they have one by one, also where a block is not full.
    #[test]
    fn samples_are_the_values_themselves() {
        let places: Vec<DVec3> =
            (0..1000).map(|i| 0.9 * DVec3::new((i as f64 * 0.61).sin(), (i as f64 * 0.37).cos(), (i as f64 * 0.23).sin())).collect();
        for cloud in [cloud(3, false, 0.0), cloud(4, true, 0.3), Fbm { centre: DVec3::splat(-0.4), ..cloud(5, false, -0.7) }] {
            let mut values = vec![f64::NAN; places.len()];
            cloud.sample(&places, &mut values);
            assert!(places.iter().zip(&values).all(|(p, value)| cloud.at(*p) == *value));
            assert!(values.iter().filter(|v| **v > 0.0).count() > 100 && values.contains(&0.0));
        }
    }

    #[test]
    fn variants_and_seeds_differ() {
        let p = DVec3::new(0.1, 0.2, -0.15);
        let values = [cloud(3, false, 0.0).at(p), cloud(3, true, 0.0).at(p), cloud(3, false, 0.4).at(p), cloud(4, false, 0.0).at(p)];
        assert!((0..4).all(|i| (0..i).all(|j| values[i] != values[j])), "{values:?}");
    }
}
