//! Volumes of a bundle: floats of a few bits in an archive.
//!
//! A value is v = 2^e f Π t, where e is an exponent of the volume, f a float of 16 bits, and t the values of other volumes that
//! change in a similar way. The largest f are between 1 and 2. A float has [`MANTISSA_BITS`] bits behind its leading one: its
//! relative error is at most [`ROUNDING`] above 2⁻¹⁴ of the largest, and its error at most 2⁻²⁰ of the largest below.

use std::sync::Arc;

use half::f16;
use npyz::WriterBuilder;

use super::predictor::{folded, unfolded};

/// Bits of a mantissa behind its leading one.
const MANTISSA_BITS: u32 = 5;
/// Largest relative error of a value, which is rounded to 16 bits first \[1\].
pub(super) const ROUNDING: f64 = 1.0 / (2u32 << MANTISSA_BITS) as f64 + 1.0 / 2048.0;
/// Bits of a 16-bit float that are left out.
const LEFT_OUT: u32 = 10 - MANTISSA_BITS;
/// Range of exponents of normal values in single precision.
const EXPONENTS: std::ops::RangeInclusive<i32> = -126..=126;

/// Rounded values of a volume; x runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Volume {
    /// Name in the archive.
    pub name: String,
    /// Voxels along z, y and x.
    pub shape: [usize; 3],
    /// Binary exponent of the unit of the values.
    pub exponent: i32,
    /// Names of the volumes by which values are multiplied.
    pub times: Vec<String>,
    /// Leading bits of 16-bit floats.
    bits: Arc<[u16]>,
}

impl Volume {
    /// Rounds values, none of which is negative.
    pub fn new(name: &str, [nx, ny, nz]: [usize; 3], values: &[f32]) -> Self {
        let largest = values.iter().fold(0.0f32, |most, value| most.max(*value));
        let exponent = if largest > 0.0 { f64::from(largest).log2().floor() as i32 } else { 0 };
        let exponent = exponent.clamp(*EXPONENTS.start(), *EXPONENTS.end());
        let unit = f64::from(exponent).exp2();
        let half = 1 << (LEFT_OUT - 1);
        let bits = values.iter().map(|value| (f16::from_f64(f64::from(*value) / unit).to_bits() + half) >> LEFT_OUT).collect();
        Self { name: name.to_owned(), shape: [nz, ny, nx], exponent, times: Vec::new(), bits }
    }

    /// Variant that stores the ratio of the values to the product of others; `product` has their values.
    pub fn relative(name: &str, dims: [usize; 3], values: &[f32], times: &[&str], product: &[f32]) -> Self {
        let ratio = values.iter().zip(product).map(|(value, product)| if *product > 0.0 { value / product } else { 0.0 });
        let times = times.iter().map(|name| (*name).to_owned()).collect();
        Self { times, ..Self::new(name, dims, &ratio.collect::<Vec<f32>>()) }
    }

    /// Bytes of the volume in an archive.
    pub fn encoded(&self) -> Vec<u8> {
        folded(&self.bits, self.shape)
    }

    /// Volume from its bytes; `None` where their number is not that of the shape, or the exponent is out of range.
    pub fn decoded(name: &str, shape: [usize; 3], exponent: i32, times: Vec<String>, planes: &[u8]) -> Option<Self> {
        let cells = shape.iter().try_fold(1usize, |cells, edge| cells.checked_mul(*edge)).filter(|cells| *cells > 0)?;
        if cells.checked_mul(2) != Some(planes.len()) || !EXPONENTS.contains(&exponent) {
            return None;
        }
        let bits: Vec<u16> = unfolded(planes, shape);
        // Infinite floats and those that are no numbers have all exponent bits, negative ones the sign bit.
        let is_float = bits.iter().all(|bits| *bits < f16::INFINITY.to_bits() >> LEFT_OUT);
        is_float.then(|| Self { name: name.to_owned(), shape, exponent, times, bits: bits.into() })
    }

    fn floats(&self) -> impl Iterator<Item = f16> + '_ {
        self.bits.iter().map(|bits| f16::from_bits(bits << LEFT_OUT))
    }

    /// Values in units of 2^exponent, without the product, as a `.npy` array along z, y and x.
    pub fn npy(&self) -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::with_capacity(128 + 2 * self.bits.len());
        let shape = self.shape.map(|edge| edge as u64);
        let mut writer = npyz::WriteOptions::<f16>::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd()?;
        writer.extend(self.floats())?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Values without the product.
    pub fn values(&self) -> Vec<f32> {
        let unit = f64::from(self.exponent).exp2();
        self.floats().map(|value| (f64::from(value.to_f32()) * unit) as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values have the stated errors, zeros stay zeros, and the bytes give the volume back.
    #[test]
    fn values_are_rounded_as_stated() {
        for unit in [1e-30f32, 1.0, 3e30] {
            let values: Vec<f32> = (0..1000).map(|i| if i % 10 == 0 { 0.0 } else { unit * 0.979_f32.powi(i) }).collect();
            let volume = Volume::new("a", [10, 20, 5], &values);
            let (mut relative, mut faint) = (0.0f64, 0.0f64);
            for (found, value) in volume.values().iter().map(|v| f64::from(*v)).zip(values.iter().map(|v| f64::from(*v))) {
                assert!(value > 0.0 || found == 0.0);
                let largest = 2.0f64.powi(volume.exponent);
                if value > largest * 2.0f64.powi(-14) {
                    relative = relative.max((found / value - 1.0).abs());
                } else {
                    faint = faint.max((found - value).abs() / largest);
                }
            }
            assert!(relative <= ROUNDING && relative > 0.8 * ROUNDING, "{relative}");
            assert!(faint <= 1.05 * 2.0f64.powi(-20) && faint > 0.9 * 2.0f64.powi(-20), "{faint}");
            assert_eq!(Volume::decoded("a", volume.shape, volume.exponent, Vec::new(), &volume.encoded()).unwrap(), volume);
        }
    }

    /// Ratios times their product are the values.
    #[test]
    fn ratios_are_restored() {
        let product: Vec<f32> = (0..24).map(|i| if i == 3 { 0.0 } else { 1.5f32.powi(i) }).collect();
        let values: Vec<f32> = product.iter().map(|value| 1.25 * value).collect();
        let volume = Volume::relative("a", [2, 3, 4], &values, &["b"], &product);
        assert_eq!(volume.times, ["b"]);
        assert!(volume.values().iter().zip(&product).all(|(ratio, product)| *ratio == if *product > 0.0 { 1.25 } else { 0.0 }));
    }

    /// Bytes that are no volume are refused, also those of negative and infinite values.
    #[test]
    fn damaged_volumes_are_refused() {
        let decoded = |shape, exponent, planes: &[u8]| Volume::decoded("a", shape, exponent, Vec::new(), planes);
        let planes = [0; 16];
        assert!(decoded([2, 2, 2], 0, &planes).is_some());
        for (shape, exponent) in [([2, 2, 3], 0), ([0, 2, 2], 0), ([usize::MAX, 2, 2], 0), ([2, 2, 2], 1000), ([2, 2, 2], -1000)] {
            assert!(decoded(shape, exponent, &planes).is_none(), "{shape:?} {exponent}");
        }
        for high in [0x08, 0xff] {
            let mut planes = planes;
            planes[0] = high;
            assert!(decoded([2, 2, 2], 0, &planes).is_none(), "{high}");
        }
    }
}
