//! Numbers as files store them: a type, its size, and the order of its bytes.

use half::f16;

use super::FileFloat;

/// A type of stored numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stored {
    /// Number type.
    pub kind: Number,
    /// True if the highest byte comes first.
    pub big_endian: bool,
}

/// Meaning of stored numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Number {
    /// Signed integers of a number of bytes.
    Int(usize),
    /// Whole numbers without one.
    Uint(usize),
    /// Numbers with a point.
    Float(usize),
    /// Unsigned integers of 8 bytes that are stored less 2⁶³.
    Biased,
}

impl Stored {
    /// A type by what it is and how many bytes it has; none where there is no such number.
    pub fn new(kind: Number, big_endian: bool) -> Option<Self> {
        let known = match kind {
            Number::Int(size) | Number::Uint(size) => [1, 2, 4, 8].contains(&size),
            Number::Float(size) => [2, 4, 8].contains(&size),
            Number::Biased => true,
        };
        known.then_some(Self { kind, big_endian })
    }

    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self.kind {
            Number::Int(size) | Number::Uint(size) | Number::Float(size) => size,
            Number::Biased => 8,
        }
    }

    /// True if single precision holds every number of the type.
    pub fn is_single(self) -> bool {
        match self.kind {
            Number::Int(size) | Number::Uint(size) => size <= 2,
            Number::Float(size) => size <= 4,
            Number::Biased => false,
        }
    }

    /// The numbers in some bytes, one after the other.
    pub fn decode<T: FileFloat>(self, bytes: &[u8], mut take: impl FnMut(T)) {
        macro_rules! each {
            ($type:ty, $to:expr) => {{
                let whole = bytes.as_chunks::<{ size_of::<$type>() }>().0;
                if self.big_endian {
                    whole.iter().for_each(|b| take($to(<$type>::from_be_bytes(*b))));
                } else {
                    whole.iter().for_each(|b| take($to(<$type>::from_le_bytes(*b))));
                }
            }};
        }
        match self.kind {
            Number::Float(2) => each!(f16, |v: f16| T::of(v.to_f64())),
            Number::Float(4) => each!(f32, |v| T::of(f64::from(v))),
            Number::Float(_) => each!(f64, T::of),
            Number::Int(1) => each!(i8, |v| T::of(f64::from(v))),
            Number::Int(2) => each!(i16, |v| T::of(f64::from(v))),
            Number::Int(4) => each!(i32, |v| T::of(f64::from(v))),
            Number::Int(_) => each!(i64, |v| T::of(v as f64)),
            Number::Uint(1) => each!(u8, |v| T::of(f64::from(v))),
            Number::Uint(2) => each!(u16, |v| T::of(f64::from(v))),
            Number::Uint(4) => each!(u32, |v| T::of(f64::from(v))),
            Number::Uint(_) => each!(u64, |v| T::of(v as f64)),
            Number::Biased => each!(u64, |v: u64| T::of((v ^ (1 << 63)) as f64)),
        }
    }
}

impl std::fmt::Display for Stored {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (name, size) = match self.kind {
            Number::Int(size) => ("int", size),
            Number::Uint(size) => ("uint", size),
            Number::Float(size) => ("float", size),
            Number::Biased => ("uint", 8),
        };
        let order = if self.big_endian && size > 1 { ", big-endian" } else { "" };
        write!(f, "{name}{}{order}", 8 * size)
    }
}
