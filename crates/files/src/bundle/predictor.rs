//! Compression of volumes by prediction.
//!
//! Stored are differences to a prediction from the neighbours at lower indices: the Lorenzo predictor
//!
//! p = a + b + c − d − e − f + g,
//!
//! of the neighbours across a face (a, b, c), an edge (d, e, f) and the corner (g) of a voxel, limited to the range of a, b and c so
//! that noise does not add up (Ibarria, Lindstrom, Rossignac & Szymczak 2003, Computer Graphics Forum 22, 343; the limit as in the
//! median predictor of Weinberger, Seroussi & Sapiro 2000, IEEE Trans. Image Process. 9, 1309). Neighbours outside are 0. A
//! difference r (mod 2¹⁶) is stored as (r << 1) ^ (r >> 15), so that small ones of both signs are small numbers: all high bytes
//! first, then all low ones.

/// High and low bytes of the differences of a volume, x fastest.
pub(super) fn folded(values: &[u16], [nz, ny, nx]: [usize; 3]) -> Vec<u8> {
    let mut folded = vec![0u8; 2 * values.len()];
    let (high, low) = folded.split_at_mut(values.len());
    let mut at = 0;
    for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
        for x in 0..nx {
            let difference = values[at].wrapping_sub(predicted(values, at, [z, y, x], [ny, nx]));
            let code = (difference << 1) ^ (difference.cast_signed() >> 15).cast_unsigned();
            [high[at], low[at]] = code.to_be_bytes();
            at += 1;
        }
    }
    folded
}

/// Volume from the bytes of [`folded`].
pub(super) fn unfolded(planes: &[u8], [nz, ny, nx]: [usize; 3]) -> Vec<u16> {
    let mut values: Vec<u16> = residuals(planes).collect();
    let mut at = 0;
    for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
        for x in 0..nx {
            values[at] = values[at].wrapping_add(predicted(&values, at, [z, y, x], [ny, nx]));
            at += 1;
        }
    }
    values
}

/// Differences from planes of high and low bytes.
pub(crate) fn residuals(planes: &[u8]) -> impl Iterator<Item = u16> + '_ {
    let (high, low) = planes.split_at(planes.len() / 2);
    let codes = high.iter().zip(low).map(|(high, low)| u16::from_be_bytes([*high, *low]));
    codes.map(|code| (code >> 1) ^ (code & 1).wrapping_neg())
}

/// Prediction of the voxel at an index from those before it.
#[inline]
fn predicted(values: &[u16], at: usize, [z, y, x]: [usize; 3], [ny, nx]: [usize; 2]) -> u16 {
    let (row, slice) = (nx, nx * ny);
    let value = |is_inside: bool, back: usize| if is_inside { i32::from(values[at - back]) } else { 0 };
    let (has_x, has_y, has_z) = (x > 0, y > 0, z > 0);
    let faces = [value(has_x, 1), value(has_y, row), value(has_z, slice)];
    let edges = value(has_x && has_y, 1 + row) + value(has_x && has_z, 1 + slice) + value(has_y && has_z, row + slice);
    let corner = value(has_x && has_y && has_z, 1 + row + slice);
    let [a, b, c] = faces;
    (a + b + c - edges + corner).clamp(a.min(b).min(c), a.max(b).max(c)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step along the second axis, folded by hand: the prediction follows it but for its first row.
    #[test]
    fn a_step_is_folded() {
        let values = [7, 7, 5, 5, 7, 7, 5, 5];
        let planes = folded(&values, [2, 2, 2]);
        // First voxel 7; the faces at the border are 0, so that the limit takes the nearest of them.
        assert_eq!(residuals(&planes).map(u16::cast_signed).collect::<Vec<_>>(), [7, 0, -2, 0, 0, 0, 0, 0]);
        assert_eq!(unfolded(&planes, [2, 2, 2]), values);
    }

    /// Any integers are restored, also those whose differences overflow.
    #[test]
    fn all_volumes_are_restored() {
        let values: Vec<u16> = (0..60_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as u16).collect();
        for shape in [[3, 4, 5], [60, 1, 1], [1, 1, 60], [2, 30, 1]] {
            assert_eq!(unfolded(&folded(&values, shape), shape), values);
        }
    }
}
