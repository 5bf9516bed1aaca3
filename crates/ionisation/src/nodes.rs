//! Numbers by node in single precision, side by side in the registers of the processor.

use std::ops::{Add, Mul};

use crate::light::{ByNode, NODES};

/// Places for nodes: as many as registers hold of whole.
pub const PLACES: usize = NODES.next_multiple_of(16);

/// A number for each node, zeros behind the last.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Nodes(pub [f32; PLACES]);

impl Nodes {
    /// Numbers by node times a factor.
    pub fn of(values: &ByNode, factor: f64) -> Self {
        Self::each(|place| values.get(place).map_or(0.0, |value| (value * factor) as f32))
    }

    /// A number for each, by its place.
    #[inline(always)]
    pub fn each(value: impl Fn(usize) -> f32) -> Self {
        let mut all = [0.0; PLACES];
        for place in 0..PLACES {
            all[place] = value(place);
        }
        Self(all)
    }

    /// The sum of all, in an order of its own.
    #[inline(always)]
    pub fn sum(self) -> f32 {
        const STRIDE: usize = 8;
        let mut sums = [0.0; STRIDE];
        for group in 0..PLACES / STRIDE {
            for place in 0..STRIDE {
                sums[place] += self.0[group * STRIDE + place];
            }
        }
        sums.iter().sum()
    }

    /// e^(−x) for x from zero up, right to 3e-7; what lies beyond 87 counts as that.
    #[inline(always)]
    pub fn decay(self) -> Self {
        /// 1/k! from the seventh down.
        const FACTORIALS: [f32; 8] = [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
        /// Beside it a number has no places behind the point: a sum with it ends in a whole number.
        const WHOLE: f32 = 12_582_912.0;
        /// ln 2 in two parts, the first with zeros at its end.
        const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
        Self::each(|place| {
            let x = -(if self.0[place] < 87.0 { self.0[place] } else { 87.0 });
            let whole = x * std::f32::consts::LOG2_E + WHOLE;
            let halvings = whole - WHOLE;
            let rest = (x - halvings * LN_2[0]) - halvings * LN_2[1];
            let series = FACTORIALS.iter().skip(1).fold(FACTORIALS[0], |sum, factor| sum * rest + factor);
            series * f32::from_bits((whole.to_bits().wrapping_add(127)) << 23)
        })
    }

    /// The mean of e^(−x') for x' from zero to x, given e^(−x): by its series where rounding would leave little of the difference.
    #[inline(always)]
    pub fn mean_decay(self, decay: Self) -> Self {
        Self::each(|place| {
            let x = self.0[place];
            let series = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0)));
            if x > 0.03 { (1.0 - decay.0[place]) / x } else { series }
        })
    }
}

macro_rules! operator {
    ($($name:ident $method:ident $sign:tt),*) => {$(
        impl $name for Nodes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::each(|place| self.0[place] $sign other.0[place])
            }
        }
    )*};
}

operator!(Add add +, Mul mul *);

impl Mul<f32> for Nodes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        Self::each(|place| self.0[place] * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(value: f32) -> Nodes {
        Nodes::each(|_| value)
    }

    #[test]
    fn decay_is_that_of_the_library() {
        for i in 0..90_000 {
            let x = 1e-3 * i as f32 + 1e-4 * (i % 7) as f32;
            let (found, truth) = (f64::from(all(x).decay().0[3]), (-f64::from(x.min(87.0))).exp());
            assert!((found - truth).abs() <= 3e-7 * truth, "{x}: {found:e} {truth:e}");
            let mean = f64::from(all(x).mean_decay(all(x).decay()).0[3]);
            let truth = if x > 0.0 { -(-f64::from(x)).exp_m1() / f64::from(x) } else { 1.0 };
            assert!((mean - truth).abs() <= 4e-6 * truth, "{x}: {mean:e} {truth:e}");
        }
        assert_eq!(all(0.0).decay(), all(1.0));
        assert!(all(f32::INFINITY).decay().0[0] < 1e-37);
    }

    #[test]
    fn sums_have_all_places() {
        let places = Nodes::each(|place| place as f32);
        assert_eq!(places.sum() as usize, PLACES * (PLACES - 1) / 2);
        assert_eq!((places * 2.0 + places * places).0[5], 35.0);
    }
}
