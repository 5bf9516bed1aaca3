//! From band radiances to display colour: a separate last step that never touches the radiance.
//!
//! XYZ = ∫ (x̄, ȳ, z̄) I_λ dλ (CIE 1931, 2°); linear sRGB = M XYZ (IEC 61966-2-1, D65). A palette is a matrix from
//! bands to linear RGB, one row of [`PALETTES`]; a stretch a curve, one row of [`STRETCHES`].

mod palette;
mod stretch;

pub use palette::{PALETTES, Palette, PaletteEntry};
pub use stretch::{STRETCHES, Stretch, StretchEntry};

/// Linear sRGB from XYZ (IEC 61966-2-1:1999, primaries of Rec. 709, white D65).
pub const SRGB_FROM_XYZ: [[f64; 3]; 3] =
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]];

/// XYZ from linear sRGB, the inverse.
pub const XYZ_FROM_SRGB: [[f64; 3]; 3] =
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]];

/// The product of a matrix and a vector.
pub fn transform(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * v[j]).sum())
}

/// The transfer curve of sRGB: display value in [0, 1] from linear light (IEC 61966-2-1).
pub fn srgb_encode(linear: f64) -> f64 {
    let v = linear.clamp(0.0, 1.0);
    if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cie::matching_functions;
    use crate::table::Table;

    #[test]
    fn matrices_are_inverse() {
        let there = transform(&XYZ_FROM_SRGB, [0.2, 0.5, 0.9]);
        let back = transform(&SRGB_FROM_XYZ, there);
        assert!((back[0] - 0.2).abs() < 1e-6 && (back[1] - 0.5).abs() < 1e-6 && (back[2] - 0.9).abs() < 1e-6);
    }

    /// D65 is white: XYZ (0.95047, 1, 1.08883) is sRGB (1, 1, 1).
    #[test]
    fn d65_is_white() {
        let white = transform(&SRGB_FROM_XYZ, [0.95047, 1.0, 1.08883]);
        assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-4), "{white:?}");
    }

    /// The function ȳ is one at 555 nm, and the equal-energy spectrum has the chromaticity (1, 1, 1).
    #[test]
    fn matching_functions_are_normalised() {
        let [x, y, z] = matching_functions().unwrap();
        assert!((y.at(0.555) - 1.0).abs() < 1e-3);
        let sum = |t: &Table| t.y().iter().sum::<f64>();
        assert!((sum(x) / sum(y) - 1.0).abs() < 1e-3 && (sum(z) / sum(y) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn encoding_meets_the_standard() {
        assert!((srgb_encode(0.5) - 0.735357).abs() < 1e-5);
        assert_eq!(srgb_encode(-1.0), 0.0);
        assert!((srgb_encode(2.0) - 1.0).abs() < 1e-12);
    }
}
