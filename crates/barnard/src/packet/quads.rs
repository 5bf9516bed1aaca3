//! Four values side by side, as rows of tables and volumes hold them.

use wide::f32x4;

use crate::stored::Stored;

use super::lane::fma;

/// The first four of some values.
#[inline(always)]
pub fn four<S: Stored>(values: &[S], at: usize) -> f32x4 {
    let four: &[S; 4] = values[at..at + 4].try_into().expect("four values");
    f32x4::new([four[0].value(), four[1].value(), four[2].value(), four[3].value()])
}

/// a b + c, the product and the sum in one instruction where there is one: `wide` knows of none before the machine is
/// known.
#[inline(always)]
fn fused(a: f32x4, b: f32x4, c: f32x4) -> f32x4 {
    let (a, b, c) = (a.to_array(), b.to_array(), c.to_array());
    f32x4::new(std::array::from_fn(|i| fma(a[i], b[i], c[i])))
}

/// a + t (b − a).
#[inline(always)]
pub fn lerp(a: f32x4, b: f32x4, t: f32x4) -> f32x4 {
    fused(b - a, t, a)
}
