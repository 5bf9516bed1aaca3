//! One octave of displacement: the curl of simplex noise along one axis, in single precision by lanes and in double precision, from
//! one text.
//!
//! n(p) = Σ_corners max(0, ½ − r²)⁴ (g · r), g one of the eight diagonals of a cube by a hash of the corner and the seed. With ½ each
//! corner ends within its simplices: n has three derivatives everywhere. The curl of (0, 0, n) is (∂n/∂y, −∂n/∂x, 0), which keeps
//! volumes (Bridson, Hourihan & Nordenstam 2007, ACM Trans. Graph. 26, 46). Source of n: Perlin 2001; Gustavson 2005, "Simplex noise
//! demystified".
//!
//! The correlation of n passes zero at 0.48 and is least at 0.6: [`WAVELENGTH`] is twice that.

/// The wavelength of the strongest waves, in units of the noise's place.
pub const WAVELENGTH: f64 = 1.2;
/// 1 over the deviation of a component.
pub const NORM: f64 = 35.761;
/// Upper bound of the length of the displacement.
pub const MOST: f64 = 6.0;
/// Combination of the three numbers of a corner.
const ROWS: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];

/// Both components at a place \[1\] in single precision.
#[inline(always)]
pub fn single(p: [f32; 3], seed: u32) -> [f32; 2] {
    noise!(p, seed, single_corner, f32, 12_582_912.0)
}

/// Both components at a place \[1\] in double precision.
#[inline(always)]
pub fn double(p: [f64; 3], seed: u32) -> [f64; 2] {
    noise!(p, seed, double_corner, f64, 6_755_399_441_055_744.0)
}

/// Contribution of a corner at a position relative to it; `rows` are those of the first corner; the steps lead from there to it.
#[inline(always)]
fn single_corner(rows: [u32; 3], steps: [bool; 3], seed: u32, at: [f32; 3]) -> [f32; 2] {
    corner!(rows, steps, seed, at, f32, u32)
}

#[inline(always)]
fn double_corner(rows: [u32; 3], steps: [bool; 3], seed: u32, at: [f64; 3]) -> [f64; 2] {
    corner!(rows, steps, seed, at, f64, u64)
}

/// The noise in one precision: `whole` is 1.5 times the first number that has no fraction; adding it rounds to an integer,
/// which then stands in the low bits.
macro_rules! noise {
    ($p:expr, $seed:expr, $corner:ident, $real:ty, $whole:expr) => {{
        let (p, seed): ([$real; 3], u32) = ($p, $seed);
        // Skew to find the simplex, unskew to measure distances; rounding what is less by a half is the floor.
        let skew = (p[0] + p[1] + p[2]) * (1.0 / 3.0) - 0.5;
        let rounded = [p[0] + skew + $whole, p[1] + skew + $whole, p[2] + skew + $whole];
        let cell = [rounded[0] - $whole, rounded[1] - $whole, rounded[2] - $whole];
        let unskew = (cell[0] + cell[1] + cell[2]) * (1.0 / 6.0);
        let d = [p[0] - (cell[0] - unskew), p[1] - (cell[1] - unskew), p[2] - (cell[2] - unskew)];
        // Steps from the first corner along the largest, then the second largest coordinate.
        let (xy, yz, xz) = (d[0] >= d[1], d[1] >= d[2], d[0] >= d[2]);
        let (second, third) = ([xy & xz, !xy & yz, !xz & !yz], [xy | xz, !xy | yz, !xz | !yz]);
        let whole = |axis: usize| (rounded[axis].to_bits() as u32).wrapping_sub((<$real>::to_bits($whole)) as u32);
        let rows = [whole(0).wrapping_mul(ROWS[0]), whole(1).wrapping_mul(ROWS[1]), whole(2).wrapping_mul(ROWS[2])];
        let away = |axis: usize, step: bool, unskew: $real| d[axis] - if step { 1.0 - unskew } else { -unskew };
        let at = |steps: [bool; 3], unskew: $real| [away(0, steps[0], unskew), away(1, steps[1], unskew), away(2, steps[2], unskew)];
        let (first, second) = ($corner(rows, [false; 3], seed, d), $corner(rows, second, seed, at(second, 1.0 / 6.0)));
        let (third, fourth) = ($corner(rows, third, seed, at(third, 1.0 / 3.0)), $corner(rows, [true; 3], seed, at([true; 3], 0.5)));
        [0, 1].map(|i| NORM as $real * ((first[i] + second[i]) + (third[i] + fourth[i])))
    }};
}
use noise;

/// A corner in one precision of a number of bits.
macro_rules! corner {
    ($rows:expr, $steps:expr, $seed:expr, $at:expr, $real:ty, $bits:ty) => {{
        let [x, y, z]: [$real; 3] = $at;
        let row = |axis: usize| $rows[axis].wrapping_add(if $steps[axis] { ROWS[axis] } else { 0 });
        let hash = mixed(row(0) ^ row(1) ^ row(2) ^ $seed);
        let falloff = 0.5 - (x * x + y * y + z * z);
        let falloff = if falloff > 0.0 { falloff } else { 0.0 };
        const SIGN: $bits = 1 << (<$bits>::BITS - 1);
        let signed = |v: $real, bit: u32| <$real>::from_bits(v.to_bits() ^ (((hash as $bits) << (<$bits>::BITS - 32 + bit)) & SIGN));
        let (cube, product) = (falloff * falloff * falloff, signed(x, 0) + signed(y, 1) + signed(z, 2));
        let derivative = |v: $real, bit: u32| cube * (falloff * signed(1.0, bit) - 8.0 * product * v);
        [derivative(y, 1), -derivative(x, 0)]
    }};
}
use corner;

/// A number whose highest bits look random.
#[inline(always)]
fn mixed(h: u32) -> u32 {
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    (h ^ (h >> 12)).wrapping_mul(0x297a_2d39)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Counter;

    fn place(i: u64) -> [f64; 3] {
        let mut random = Counter::new(9, i);
        [0; 3].map(|_| 900.0 * (random.uniform() - 0.5))
    }

    /// Mean, variance and bound of both components, over a million places of three seeds.
    #[test]
    fn moments_are_as_stated() {
        let values: Vec<[f64; 2]> = (0..1_000_000).map(|i| double(place(i), [1, 77, 0xffff_ffff][i as usize % 3])).collect();
        let mean = |f: &dyn Fn(&[f64; 2]) -> f64| values.iter().map(f).sum::<f64>() / values.len() as f64;
        for i in 0..2 {
            let (first, second) = (mean(&|v| v[i]), mean(&|v| v[i] * v[i]));
            assert!(first.abs() < 4e-3 && (second - 1.0).abs() < 1e-2, "{i}: {first} {second}");
        }
        let most = values.iter().map(|v| v[0].hypot(v[1])).fold(0.0, f64::max);
        assert!(most < MOST && most > 0.6 * MOST, "{most}");
    }

    /// Volumes are kept: what flows out of a small cube flows in.
    #[test]
    fn divergence_is_zero() {
        const STEP: f64 = 1e-4;
        for i in 0..2000 {
            let p = place(i);
            let along = |axis: usize, component: usize| {
                let at = |sign: f64| double(std::array::from_fn(|a| p[a] + if a == axis { sign * STEP } else { 0.0 }), 5)[component];
                (at(1.0) - at(-1.0)) / (2.0 * STEP)
            };
            let (x, y) = (along(0, 0), along(1, 1));
            assert!((x + y).abs() < 1e-4 * (1.0 + x.abs()), "{p:?}: {x} {y}");
        }
    }

    /// Both precisions are one noise, and another seed is another.
    #[test]
    fn precisions_agree() {
        let (mut worst, mut others) = (0.0f64, 0);
        for i in 0..50_000 {
            let p = place(i).map(|x| x as f32);
            let (exact, single) = (double(p.map(f64::from), 5), single(p, 5));
            worst = (0..2).map(|c| (exact[c] - f64::from(single[c])).abs()).fold(worst, f64::max);
            others += usize::from(exact != double(p.map(f64::from), 4));
        }
        assert!(worst > 0.0 && worst < 2e-3 && others > 49_000, "{worst} {others}");
    }

    /// Displacements half a wave apart are opposed, those a tenth of it apart alike, those a whole one apart independent.
    #[test]
    fn waves_have_their_length() {
        let correlation = |r: f64| {
            let product = |i: u64| {
                let p = place(i);
                let mut random = Counter::new(4, i);
                let (z, turn) = (2.0 * random.uniform() - 1.0, std::f64::consts::TAU * random.uniform());
                let aside = r * (1.0 - z * z).sqrt();
                let (here, there) = (double(p, 8), double([p[0] + aside * turn.cos(), p[1] + aside * turn.sin(), p[2] + r * z], 8));
                0.5 * (here[0] * there[0] + here[1] * there[1])
            };
            (0..200_000).map(product).sum::<f64>() / 200_000.0
        };
        assert!(correlation(0.1 * WAVELENGTH) > 0.8 && correlation(WAVELENGTH).abs() < 0.02);
        assert!((-0.11..-0.06).contains(&correlation(0.5 * WAVELENGTH)), "{}", correlation(0.5 * WAVELENGTH));
    }
}
