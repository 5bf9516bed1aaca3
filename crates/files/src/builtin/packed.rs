//! Volumes that are compiled in, a third smaller than as `.npz`.
//!
//! Stored is what the neighbours at lower indices do not predict (the Lorenzo predictor of Ibarria, Lindstrom,
//! Rossignac & Szymczak 2003, Computer Graphics Forum 22, 343),
//!
//! r = Δx Δy Δz v (mod 2¹⁶),
//!
//! where v are the bits of 16-bit floats and Δ the difference to the neighbour along an axis (0 before the first), as
//! (r << 1) ^ (r >> 15), so that small differences of both signs are small numbers. An archive has an array of bytes
//! for each volume: all high bytes, then all low ones. `scenes/volumes/pack.py` writes it.

use std::io::{Cursor, Read};

use half::f16;
use zip::{ZipArchive, ZipWriter};

use crate::bundle::predictor::residuals;
use crate::formats::{Written, put};

/// The volumes of a packed archive as an uncompressed `.npz` of 16-bit floats.
///
/// # Errors
/// If the archive is damaged.
pub(super) fn unpacked(packed: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut archive = ZipArchive::new(Cursor::new(packed))?;
    let mut whole = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index)?;
        let name = entry.name()?.trim_end_matches(".npy").to_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        let planes = npyz::NpyFile::new(&bytes[..])?;
        let shape = planes.shape()[1..].to_vec();
        let values = predicted(&planes.into_vec::<u8>()?, &shape);
        put(&mut whole, &name, &shape, &Written::Halves(&values), false)?;
    }
    Ok(whole.finish()?.into_inner())
}

/// Values of a volume from planes of high and low bytes of what was not predicted.
fn predicted(planes: &[u8], shape: &[u64]) -> Vec<f16> {
    let mut values: Vec<u16> = residuals(planes).collect();
    // Sums along an axis undo its differences.
    let mut stride = 1;
    for edge in shape.iter().rev().map(|edge| *edge as usize) {
        for line in values.chunks_exact_mut(stride * edge) {
            for at in stride..line.len() {
                line[at] = line[at].wrapping_add(line[at - stride]);
            }
        }
        stride *= edge;
    }
    values.into_iter().map(f16::from_bits).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step along the second axis, packed by hand: the value stays behind it, whatever the first and last index.
    #[test]
    fn a_step_is_unpacked() {
        let (before, step) = (f16::from_f32(1.0).to_bits(), 0xfffe_u16);
        let mut folded = [0_u16; 12];
        // The first value, and the difference -2 that begins the third row of three.
        folded[0] = before << 1;
        folded[4] = 3;
        let planes: Vec<u8> = folded.iter().map(|z| (z >> 8) as u8).chain(folded.iter().map(|z| *z as u8)).collect();
        let expected = [before, before, before, before, before.wrapping_add(step), before.wrapping_add(step)];
        let values: Vec<u16> = predicted(&planes, &[2, 3, 2]).into_iter().map(f16::to_bits).collect();
        assert_eq!(values, expected.repeat(2));
    }
}
