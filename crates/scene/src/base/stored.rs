//! Numbers as volumes and blocks store them: in single precision, or in half of its memory.
//!
//! A half is a number of IEEE 754's binary16 that is never subnormal: sign, five bits of exponent, ten of mantissa.
//! Values stand in parts of a channel's unit, a power of two, so that the largest is near 2¹⁵; the relative error is at
//! most 2⁻¹¹, and what is less than 2⁻²⁹ of the largest is nothing. Source: IEEE 754-2019, table 3.5.

/// A number as it is stored, in parts of its channel's unit.
pub trait Stored: Copy + Send + Sync {
    /// The stored number that is nearest to a value.
    fn of(value: f32) -> Self;
    /// The value that is stored.
    fn value(self) -> f32;
}

impl Stored for f32 {
    #[inline(always)]
    fn of(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f32 {
        self
    }
}

/// A number of sixteen bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Half(u16);

/// Bits of a single's mantissa that a half has not, the distance of the exponents' biases, and the largest half.
const CUT: u32 = 13;
const BIAS: u32 = 112;
const LARGEST: u32 = 0x7bff;
/// 2¹¹²: from a single with the exponent of a half to its value.
const RAISE: f32 = f32::from_bits((127 + BIAS) << 23);

impl Stored for Half {
    #[inline(always)]
    fn of(value: f32) -> Self {
        let magnitude = value.abs().to_bits();
        // To the nearest, and to the even one of two that are as near.
        let rounded = (magnitude + ((1 << (CUT - 1)) - 1) + (magnitude >> CUT & 1)) >> CUT;
        let half = rounded.saturating_sub(BIAS << 10).min(LARGEST);
        let half = if half < 1 << 10 { 0 } else { half };
        Self((half | value.to_bits() >> 31 << 15) as u16)
    }

    #[inline(always)]
    fn value(self) -> f32 {
        // The sign fills the bits above, of which all but the highest go.
        let bits = ((i32::from(self.0 as i16) << CUT) as u32) & 0x8fff_e000;
        f32::from_bits(bits) * RAISE
    }
}

/// Error of values with the given maximum that exceed single precision.
pub fn too_small(largest: f64) -> Option<String> {
    (largest > 0.0 && largest < f64::from(f32::MIN_POSITIVE)).then(|| {
        format!(
            "its values reach {largest:e} after unit and factor, which exceeds single precision; use another unit, and adjust the scale of dust or gas"
        )
    })
}

/// The unit of a channel whose largest value is this: nearly as much again is left above it.
pub fn unit(largest: f32) -> f32 {
    let exponent = (f64::from(largest).log2().ceil() as i32).saturating_sub(15);
    // A unit is a normal number, and so is what one is of it.
    if largest > 0.0 { 2f32.powi(exponent.clamp(-120, 120)) } else { 1.0 }
}

/// Storage precision of a volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// Four bytes a value.
    #[default]
    Single,
    /// Two bytes a value.
    Half,
}

impl Precision {
    /// The bytes of a value.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Single => 4,
            Self::Half => 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves are right to 2⁻¹¹, nearest to what they stand for, and even where two are as near; what is too small is
    /// nothing, what is too large the largest.
    #[test]
    fn halves_are_the_nearest() {
        let stored = |value: f32| Half::of(value).value();
        for i in 0..4000 {
            let value = 1.03f32.powi(i % 700 - 300) * (1.0 + 0.37 * (i as f32).sin());
            let known = (2f32.powi(-14)..65504.0).contains(&value);
            for value in [value, -value] {
                let error = (stored(value) - value).abs();
                if known {
                    assert!(error <= value.abs() * 2f32.powi(-11), "{value} {}", stored(value));
                }
                let next = [1i16, -1].map(|step| Half((Half::of(value).0 as i16 + step) as u16).value());
                assert!(!known || next.iter().all(|n| (n - value).abs() >= error), "{value}");
            }
        }
        assert_eq!([0.0, -0.0, 1.0, 2048.0, 2049.0, 2051.0].map(stored), [0.0, -0.0, 1.0, 2048.0, 2048.0, 2052.0]);
        assert_eq!([1e-6, -1e-6, 1e9, -1e9, f32::INFINITY].map(stored), [0.0, 0.0, 65504.0, -65504.0, 65504.0]);
    }

    /// In its unit, the largest value of a channel leaves room for as much again.
    #[test]
    fn units_leave_room() {
        for largest in [1e-30, 3e-7, 0.99, 1.0, 1.01, 7e4, 1e30] {
            let part = largest / unit(largest);
            assert!((2f32.powi(14)..=2f32.powi(15)).contains(&part) && unit(largest).log2().fract() == 0.0, "{largest}: {part}");
        }
        assert_eq!(unit(0.0), 1.0);
    }
}
