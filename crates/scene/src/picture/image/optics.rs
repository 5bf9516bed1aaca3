//! Optics: how telescopes and the eye spread the light of a point.
//!
//! A telescope's pattern is the squared Fourier transform of its pupil (Fraunhofer; Born & Wolf, Principles of Optics, 8.3),
//!
//!   P(u) = |A(u)|²,   A(u) = ∫ T(x) e^(−2πi x·u) d²x,
//!
//! x in diameters D of the pupil, u in λ/D, T one where light comes through and zero elsewhere. Discs and polygons have it in closed
//! form: a disc of radius r is r J₁(2πru)/u, and a polygon with edges of length L, direction t, outward normal n and middle m
//!
//!   A = (i/2π|u|²) Σ (u·n) L sinc(L u·t) e^(−2πi m·u).
//!
//! The eye's pattern is the scatter in cornea, lens and retina (Spencer, Shirley, Zimmerman & Greenberg 1995, SIGGRAPH, photopic), the
//! same at all wavelengths.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, vec2};
use spectra::SpectraError;
use wide::f32x8;

/// One row of the optics.
pub struct OpticsRow {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// The pattern of a point.
    pub pattern: fn() -> Pattern,
}

/// All optics.
pub const OPTICS: &[OpticsRow] = &[
    OpticsRow { name: "hubble", summary: "Hubble: a mirror of 2.4 m, four vanes: a cross", pattern: hubble },
    OpticsRow { name: "webb", summary: "Webb: eighteen hexagons and three struts: six long spikes and two short ones", pattern: webb },
    OpticsRow { name: "newtonian", summary: "a reflector of 0.2 m with four thin vanes: a cross", pattern: newtonian },
    OpticsRow { name: "refractor", summary: "a lens: rings, no spikes", pattern: refractor },
    OpticsRow { name: "eye", summary: "an eye with a pupil of 6 mm: a broad glow", pattern: || Pattern::Scatter(photopic) },
];

impl PartialEq for OpticsRow {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for OpticsRow {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// The optics called `name`.
///
/// # Errors
/// If there are none.
pub fn by_name(name: &str) -> Result<&'static OpticsRow, SpectraError> {
    let known: Vec<&str> = OPTICS.iter().map(|row| row.name).collect();
    OPTICS.iter().find(|row| row.name == name).ok_or_else(|| SpectraError::unknown("optics", name, &known))
}

/// How light of one wavelength spreads.
#[non_exhaustive]
pub enum Pattern {
    /// Pattern of a pupil.
    Pupil(Pupil),
    /// The light in a unit of solid angle, by degrees from the middle.
    Scatter(fn(f64) -> f64),
}

/// The angle λ/D at 550 nm of the pupil of an eye \[deg\], 6 mm wide.
pub const EYE_DEG: f64 = 550e-9 / 6e-3 * 180.0 / std::f64::consts::PI;

/// The radius within which the sharpest part of the eye's glow falls to 1/e \[deg\].
pub const EYE_CORE_DEG: f64 = 0.02;

/// Aperture of a telescope.
pub struct Pupil {
    parts: Vec<ApertureShape>,
}

/// A shape that lets light through, or holds it back where its sign is negative.
enum ApertureShape {
    Disc {
        radius: f32,
        sign: f32,
    },
    /// One polygon at several positions.
    Polygon {
        edges: Vec<Edge>,
        places: Vec<Vec2>,
        area: f32,
        sign: f32,
    },
}

struct Edge {
    middle: Vec2,
    normal: Vec2,
    along: Vec2,
    length: f32,
}

impl ApertureShape {
    /// A polygon whose corners run counterclockwise.
    fn polygon(corners: &[Vec2], places: Vec<Vec2>, sign: f32) -> Self {
        let pairs = || corners.iter().zip(corners.iter().cycle().skip(1));
        let edge = |(a, b): (&Vec2, &Vec2)| {
            let along = (*b - *a).normalize();
            Edge { middle: 0.5 * (*a + *b), normal: vec2(along.y, -along.x), along, length: a.distance(*b) }
        };
        let area = 0.5 * pairs().map(|(a, b)| a.perp_dot(*b)).sum::<f32>();
        Self::Polygon { edges: pairs().map(edge).collect(), places, area, sign }
    }

    /// A bar that holds light back, outwards from one radius to another.
    fn vane(degrees: f32, from: f32, to: f32, width: f32) -> Self {
        let along = Vec2::from_angle(degrees.to_radians());
        let (near, far, aside) = (from * along, to * along, 0.5 * width * along.perp());
        Self::polygon(&[near - aside, far - aside, far + aside, near + aside], vec![Vec2::ZERO], -1.0)
    }

    /// Its transform, real and imaginary part.
    fn amplitude(&self, [u, v]: [f32x8; 2]) -> [f32x8; 2] {
        let square = (u * u + v * v).max(f32x8::splat(1e-8));
        match self {
            Self::Disc { radius, sign } => {
                let x = square.sqrt() * (TAU * radius);
                [bessel_over_x(x) * (TAU * radius * radius * sign), f32x8::ZERO]
            }
            Self::Polygon { edges, places, area, sign } => {
                let dot = |with: Vec2| u * with.x + v * with.y;
                let mut amplitudes = [f32x8::ZERO; 2];
                for edge in edges {
                    let weight = dot(edge.normal) * sinc(dot(edge.along) * edge.length) * edge.length;
                    let (sin, cos) = (dot(edge.middle) * TAU).sin_cos();
                    // i e^(−iφ) = sin φ + i cos φ.
                    amplitudes = [amplitudes[0] + weight * sin, amplitudes[1] + weight * cos];
                }
                let factor = f32x8::splat(1.0 / TAU) / square;
                // In the middle it is its area.
                let near = square.simd_lt(f32x8::splat(1e-4));
                amplitudes = [near.select(f32x8::splat(*area), amplitudes[0] * factor), near.select(f32x8::ZERO, amplitudes[1] * factor)];
                let mut sum = [f32x8::ZERO; 2];
                for place in places {
                    let (sin, cos) = (dot(*place) * TAU).sin_cos();
                    sum = [sum[0] + cos, sum[1] - sin];
                }
                [(amplitudes[0] * sum[0] - amplitudes[1] * sum[1]) * *sign, (amplitudes[0] * sum[1] + amplitudes[1] * sum[0]) * *sign]
            }
        }
    }
}

impl Pupil {
    /// A circular aperture with a circular central obstruction and a number of vanes, the first at an angle from the right \[deg\]; sizes are parts
    /// of its diameter.
    pub fn round(obstruction: f32, vanes: usize, width: f32, first_deg: f32) -> Self {
        let discs = [(0.5, 1.0), (0.5 * obstruction, -1.0)].into_iter().filter(|(radius, _)| *radius > 0.0);
        let discs = discs.map(|(radius, sign)| ApertureShape::Disc { radius, sign });
        let vane = |i: usize| ApertureShape::vane(first_deg + 360.0 * i as f32 / vanes as f32, 0.5 * obstruction, 0.5, width);
        Self { parts: discs.chain((0..vanes).map(vane)).collect() }
    }

    /// Its area, by its diameter: the square root of the pattern in the middle.
    pub fn area(&self) -> f64 {
        f64::from(self.pattern([f32x8::ZERO; 2]).to_array()[0]).sqrt()
    }

    /// The pattern at eight places \[λ/D\]; its integral is the area of the pupil.
    pub fn pattern(&self, places: [f32x8; 2]) -> f32x8 {
        let amplitude = self.parts.iter().fold([f32x8::ZERO; 2], |sum, part| {
            let amplitude = part.amplitude(places);
            [sum[0] + amplitude[0], sum[1] + amplitude[1]]
        });
        amplitude[0] * amplitude[0] + amplitude[1] * amplitude[1]
    }
}

/// sin(πx)/(πx).
fn sinc(x: f32x8) -> f32x8 {
    let x = x * PI;
    let near = x.abs().simd_lt(f32x8::splat(1e-3));
    near.select(f32x8::ONE, x.sin() / near.select(f32x8::ONE, x))
}

/// J₁(x)/x of x above zero, to 2e-7 (Abramowitz & Stegun 1964, 9.4.4 and 9.4.6).
fn bessel_over_x(x: f32x8) -> f32x8 {
    let series = |coefficients: [f32; 7], t: f32x8| coefficients.into_iter().rev().fold(f32x8::ZERO, |sum, c| sum * t + c);
    let (third, inverse) = (x * (1.0 / 3.0), f32x8::splat(3.0) / x.max(f32x8::splat(1e-6)));
    let near = series([0.5, -0.562_499_9, 0.210_935_73, -0.039_542_89, 0.004_433_19, -0.000_317_61, 0.000_011_09], third * third);
    let size = series([0.797_884_6, 0.000_001_56, 0.016_596_67, 0.000_171_05, -0.002_495_11, 0.001_136_53, -0.000_200_33], inverse);
    let shift = series([-2.356_194_5, 0.124_996_12, 0.000_056_5, -0.006_378_79, 0.000_743_48, 0.000_798_24, -0.000_291_66], inverse);
    let far = size * (x + shift).cos() / (x * x.sqrt());
    x.simd_lt(f32x8::splat(3.0)).select(near, far)
}

/// A mirror with a hole in the middle and four vanes, by diameters.
fn reflector(obstruction: f32, vane: f32, first_deg: f32) -> Pattern {
    Pattern::Pupil(Pupil::round(obstruction, 4, vane, first_deg))
}

/// The obstruction is 0.33 of the diameter and a vane 0.011 of it wide, 45° from the detector's axes (Krist, Hook & Stoehr 2011, Proc.
/// SPIE 8127, 81270J: Tiny Tim).
fn hubble() -> Pattern {
    reflector(0.33, 0.011, 45.0)
}

/// A secondary mirror of 50 mm, vanes of 1 mm.
fn newtonian() -> Pattern {
    reflector(0.25, 0.005, 0.0)
}

fn refractor() -> Pattern {
    Pattern::Pupil(Pupil::round(0.0, 0, 0.0, 0.0))
}

/// Eighteen segments of 1.32 m from flat to flat, 7 mm apart, the middle one missing, in a circle of 6.6 m; one strut runs upwards, two
/// down at 30° from the vertical, taken to be 0.1 m wide (Perrin et al. 2014, Proc. SPIE 9143, 91433X: WebbPSF).
fn webb() -> Pattern {
    const DIAMETER: f32 = 6.6;
    let (flat, step) = (1.32 / DIAMETER, 1.327 / DIAMETER);
    let corner = |i: usize| Vec2::from_angle((60.0 * i as f32).to_radians()) * (flat / 3f32.sqrt());
    let corners: Vec<Vec2> = (0..6).map(corner).collect();
    // Steps to neighbours lie across flats.
    let (a, b) = (Vec2::from_angle(30f32.to_radians()) * step, Vec2::from_angle(90f32.to_radians()) * step);
    let lattice = (-2i32..=2).flat_map(|i| (-2i32..=2).map(move |j| (i, j)));
    let ring = lattice.filter(|(i, j)| (i + j).abs() <= 2 && (*i, *j) != (0, 0));
    let places: Vec<Vec2> = ring.map(|(i, j)| i as f32 * a + j as f32 * b).collect();
    let mirror = ApertureShape::polygon(&corners, places, 1.0);
    let struts = [90.0, 240.0, 300.0].map(|degrees| ApertureShape::vane(degrees, 0.5 * flat, 0.46, 0.1 / DIAMETER));
    Pattern::Pupil(Pupil { parts: std::iter::once(mirror).chain(struts).collect() })
}

/// The light in a steradian by degrees from the middle.
fn photopic(degrees: f64) -> f64 {
    let (near, far) = ((degrees / EYE_CORE_DEG).powi(2), degrees + EYE_CORE_DEG);
    0.384 * 2.61e6 * (-near).exp() + 0.478 * 20.91 / far.powi(3) + 0.138 * 72.37 / far.powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use spectra::quadrature::integrate;

    fn pupil(name: &str) -> Pupil {
        match (OPTICS.iter().find(|row| row.name == name).unwrap().pattern)() {
            Pattern::Pupil(pupil) => pupil,
            Pattern::Scatter(_) => panic!("{name} has a pupil"),
        }
    }

    fn at(pupil: &Pupil, u: f32, v: f32) -> f64 {
        f64::from(pupil.pattern([f32x8::splat(u), f32x8::splat(v)]).to_array()[0])
    }

    /// J₁ is Bessel's integral.
    #[test]
    fn bessels_function_is_its_integral() {
        for x in [1e-3, 0.5, 1.8, 2.9, 3.1, 7.0, 20.0, 90.0] {
            let turn = |t: f64| (t - x * t.sin()).cos();
            let truth = integrate(turn, 0.0, std::f64::consts::PI, 1e-10) / std::f64::consts::PI / x;
            let found = f64::from(bessel_over_x(f32x8::splat(x as f32)).to_array()[3]);
            assert!((found - truth).abs() < 1e-6 / x.max(1.0), "{x}: {found} {truth}");
        }
    }

    /// Each pattern is the transform of its pupil, drawn on a lattice: this one knows no closed form.
    #[test]
    fn patterns_are_transforms_of_pupils() {
        let inside = |part: &ApertureShape, x: Vec2| match part {
            ApertureShape::Disc { radius, .. } => usize::from(x.length() < *radius),
            ApertureShape::Polygon { edges, places, .. } => {
                places.iter().filter(|place| edges.iter().all(|e| (x - **place - e.middle).dot(e.normal) < 0.0)).count()
            }
        };
        let sign = |part: &ApertureShape| match part {
            ApertureShape::Disc { sign, .. } | ApertureShape::Polygon { sign, .. } => f64::from(*sign),
        };
        const COUNT: usize = 1500;
        for row in OPTICS.iter().filter(|row| row.name != "eye") {
            let pupil = pupil(row.name);
            let open = |i: usize| {
                let x = vec2((i % COUNT) as f32 + 0.5, (i / COUNT) as f32 + 0.5) * (1.1 / COUNT as f32) - 0.55;
                (x, pupil.parts.iter().map(|part| sign(part) * inside(part, x) as f64).sum::<f64>())
            };
            let drawn: Vec<(Vec2, f64)> = (0..COUNT * COUNT).map(open).filter(|(_, t)| *t != 0.0).collect();
            // Nothing is held back twice.
            let whole = drawn.iter().filter(|(_, t)| (*t - 1.0).abs() > 1e-6).count() as f64 / drawn.len() as f64;
            assert!(whole < 2e-3, "{}: {whole}", row.name);
            // Edges of the drawing are as uncertain as its cells: a vane less would be five times this tolerance.
            let cell = f64::from(1.1f32 / COUNT as f32).powi(2);
            for (u, v) in [(0.0, 0.0), (0.6, -0.3), (1.9, 1.7), (-4.0, 0.4), (3.2, 5.0)] {
                let phase = |x: &Vec2| std::f64::consts::TAU * f64::from(x.x * u + x.y * v);
                let sum = drawn.iter().fold([0.0; 2], |s, (x, t)| [s[0] + t * phase(x).cos(), s[1] - t * phase(x).sin()]);
                let truth = (sum[0] * cell).hypot(sum[1] * cell).powi(2);
                assert!((at(&pupil, u, v) - truth).abs() < 4e-3 * truth + 2e-5, "{} {u} {v}: {} {truth}", row.name, at(&pupil, u, v));
            }
        }
    }

    /// A cross has its arms across the vanes, six spikes stand across the edges of hexagons, a lens has none.
    #[test]
    fn spikes_stand_where_they_are_known() {
        let beyond = |from: f32, pupil: &Pupil, degrees: f32| {
            let along = Vec2::from_angle(degrees.to_radians());
            (0..400).map(|i| along * (from + 0.1 * i as f32)).map(|u| at(pupil, u.x, u.y)).sum::<f64>()
        };
        let spoke = |pupil: &Pupil, degrees: f32| beyond(20.0, pupil, degrees);
        let (hubble, webb, lens) = (pupil("hubble"), pupil("webb"), pupil("refractor"));
        assert!(spoke(&hubble, 45.0) > 30.0 * spoke(&hubble, 20.0));
        for spike in [30.0, 90.0, 150.0] {
            let (on, beside) = (spoke(&webb, spike), spoke(&webb, spike + 12.0));
            assert!(on > 10.0 * beside, "{spike}: {on} {beside}");
        }
        // The strut that runs upwards has a pair that is short, since it is wider than what parts mirrors.
        assert!(spoke(&webb, 0.0) > 3.0 * spoke(&webb, 8.0));
        let (strut, mirrors) = (beyond(110.0, &webb, 0.0), beyond(110.0, &webb, 90.0));
        assert!(strut < 0.5 * mirrors, "{strut} {mirrors}");
        assert!((spoke(&lens, 0.0) / spoke(&lens, 33.0) - 1.0).abs() < 1e-3);
    }

    /// All light of the eye's pattern together is one.
    #[test]
    fn the_eye_keeps_light() {
        let ring = |degrees: f64| std::f64::consts::TAU * degrees.to_radians().sin() * photopic(degrees) * 1f64.to_radians();
        let all = integrate(ring, 0.0, 0.2, 1e-9) + integrate(ring, 0.2, 90.0, 1e-9);
        assert!((all - 1.0).abs() < 0.02, "{all}");
    }
}
