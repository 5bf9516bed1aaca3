//! Numbers of several beams side by side, so that the processor reckons them together.

use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Sub};

/// Beams that stand side by side.
pub const LANES: usize = 8;

/// A number for each beam.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// Zeros.
    pub const ZERO: Self = Self::splat(0.0);
    /// Ones.
    pub const ONE: Self = Self::splat(1.0);

    /// Variant for all.
    pub const fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// A number for each, by its place.
    #[inline(always)]
    pub fn each(value: impl Fn(usize) -> f64) -> Self {
        let mut all = [0.0; LANES];
        for lane in 0..LANES {
            all[lane] = value(lane);
        }
        Self(all)
    }

    /// Those that are not less than a bound.
    #[inline(always)]
    pub fn at_least(self, bound: f64) -> Self {
        Self::each(|lane| if self.0[lane] > bound { self.0[lane] } else { bound })
    }

    /// Those that are not more than a bound.
    #[inline(always)]
    pub fn at_most(self, bound: f64) -> Self {
        Self::each(|lane| if self.0[lane] < bound { self.0[lane] } else { bound })
    }

    /// The larger of two.
    #[inline(always)]
    pub fn or_more(self, other: Self) -> Self {
        Self::each(|lane| if self.0[lane] > other.0[lane] { self.0[lane] } else { other.0[lane] })
    }

    /// The smaller of two.
    #[inline(always)]
    pub fn or_less(self, other: Self) -> Self {
        Self::each(|lane| if self.0[lane] < other.0[lane] { self.0[lane] } else { other.0[lane] })
    }

    /// One number where this is above a bound, the other elsewhere.
    #[inline(always)]
    pub fn above(self, bound: f64, yes: Self, no: Self) -> Self {
        Self::each(|lane| if self.0[lane] > bound { yes.0[lane] } else { no.0[lane] })
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self::each(|lane| self.0[lane].sqrt())
    }

    /// Absolute values.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::each(|lane| self.0[lane].abs())
    }

    /// e^(−x) for x from zero up, right to 1e-12; what lies beyond 700 counts as that.
    #[inline(always)]
    pub fn decay(self) -> Self {
        /// 1/k! from the tenth down.
        const FACTORIALS: [f64; 11] = [
            1.0 / 3_628_800.0,
            1.0 / 362_880.0,
            1.0 / 40_320.0,
            1.0 / 5040.0,
            1.0 / 720.0,
            1.0 / 120.0,
            1.0 / 24.0,
            1.0 / 6.0,
            0.5,
            1.0,
            1.0,
        ];
        /// Beside it a number has no places behind the point: a sum with it ends in a whole number.
        const WHOLE: f64 = 6_755_399_441_055_744.0;
        /// ln 2 in two parts, the first with zeros at its end.
        const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
        Self::each(|lane| {
            let x = -(if self.0[lane] < 700.0 { self.0[lane] } else { 700.0 });
            let whole = x * std::f64::consts::LOG2_E + WHOLE;
            let halvings = whole - WHOLE;
            let rest = (x - halvings * LN_2[0]) - halvings * LN_2[1];
            let series = FACTORIALS.iter().skip(1).fold(FACTORIALS[0], |sum, factor| sum * rest + factor);
            series * f64::from_bits((whole.to_bits().wrapping_add(1023)) << 52)
        })
    }

    /// The mean of e^(−x') for x' from zero to x, (1 − e^(−x))/x, given e^(−x) and 1/x: by its series where rounding would leave
    /// little of the difference.
    #[inline(always)]
    pub fn mean_decay(self, decay: Self, inverse: Self) -> Self {
        let series = Self::ONE - self * (Self::splat(0.5) - self * (Self::splat(1.0 / 6.0) - self * (1.0 / 24.0)));
        self.above(1e-3, (Self::ONE - decay) * inverse, series)
    }
}

impl Index<usize> for Lanes {
    type Output = f64;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Lanes {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

macro_rules! operator {
    ($($name:ident $method:ident $sign:tt),*) => {$(
        impl $name for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::each(|lane| self.0[lane] $sign other.0[lane])
            }
        }

        impl $name<f64> for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Self::each(|lane| self.0[lane] $sign other)
            }
        }
    )*};
}

operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decay_is_that_of_the_library() {
        for i in 0..70_000 {
            let x = 1e-2 * f64::from(i) + 1e-3 * f64::from(i % 7);
            let (found, truth) = (Lanes::splat(x).decay()[3], (-x.min(700.0)).exp());
            assert!((found - truth).abs() <= 1e-12 * truth, "{x}: {found:e} {truth:e}");
        }
        assert_eq!(Lanes::ZERO.decay(), Lanes::ONE);
        assert!(Lanes::splat(f64::INFINITY).decay()[0] < 1e-300);
    }

    #[test]
    fn lanes_stand_apart() {
        let a = Lanes::each(|lane| lane as f64);
        let b = (a * 2.0 + a - 1.0).at_least(0.5).at_most(11.0).or_more(Lanes::splat(1.0)).or_less(a * 2.0);
        for lane in 0..LANES {
            let x = lane as f64;
            assert_eq!(b[lane], (3.0 * x - 1.0).clamp(0.5, 11.0).max(1.0).min(2.0 * x));
        }
        assert_eq!(a.above(2.0, a, Lanes::ZERO).0[2..], [0.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    }
}
