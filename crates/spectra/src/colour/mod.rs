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

/// ACEScg (AP1, white of ACES, S-2014-004) from linear sRGB, whites adapted by Bradford's matrix (Lindbloom).
pub const ACESCG_FROM_SRGB: [[f64; 3]; 3] =
    [[0.6130974, 0.3395231, 0.0473795], [0.0701937, 0.9163539, 0.0134524], [0.0206156, 0.1095698, 0.8698147]];

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

    /// The matrix to ACEScg is what the chromaticities of both spaces and Bradford's adaptation come to.
    #[test]
    fn acescg_is_that_of_its_primaries() {
        use nalgebra::{Matrix3, Vector3};
        let at = |(x, y): (f64, f64)| Vector3::new(x / y, 1.0, (1.0 - x - y) / y);
        let inverse = |matrix: Matrix3<f64>| matrix.try_inverse().unwrap();
        let to_xyz = |red, green, blue, white| {
            let primaries = Matrix3::from_columns(&[at(red), at(green), at(blue)]);
            primaries * Matrix3::from_diagonal(&(inverse(primaries) * at(white)))
        };
        let (d65, d60) = ((0.3127, 0.3290), (0.32168, 0.33767));
        let srgb = to_xyz((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), d65);
        let ap1 = to_xyz((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), d60);
        let bradford = Matrix3::new(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296);
        let gains = (bradford * at(d60)).component_div(&(bradford * at(d65)));
        let adapted = inverse(bradford) * Matrix3::from_diagonal(&gains) * bradford;
        let matrix = inverse(ap1) * adapted * srgb;
        for (i, row) in ACESCG_FROM_SRGB.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((matrix[(i, j)] - value).abs() < 2e-5, "{matrix}");
            }
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-6);
        }
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
