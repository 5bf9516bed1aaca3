//! Filters of chunks that the crate does not have: LZF, and the names of those that nobody here reads.

use hdf5_reader::FilterRegistry;
use hdf5_reader::error::{Error, Result};

/// The filter of h5py. Source: h5py, lzf/lzf_filter.c.
const LZF: u16 = 32_000;
/// Filters that are met in the wild and need a library of their own, by name. Source: HDF5 registered filter plugins.
const FOREIGN: [(u16, &str); 9] = [
    (305, "LZO"),
    (307, "bzip2"),
    (32_001, "Blosc"),
    (32_004, "LZ4"),
    (32_008, "bitshuffle"),
    (32_013, "ZFP"),
    (32_015, "Zstandard"),
    (32_017, "SZ"),
    (32_026, "Blosc2"),
];

/// The filters by number; an unpacked chunk has at most `most` bytes.
pub fn registry(most: usize) -> FilterRegistry {
    let mut registry = FilterRegistry::new();
    registry.register(
        LZF,
        Box::new(move |filter, packed, _| {
            // Its third number is the size of a chunk.
            let stated = filter.client_data.get(2).map_or(0, |size| *size as usize);
            lzf(packed, if stated == 0 { most } else { stated.min(most) })
        }),
    );
    for (number, name) in FOREIGN {
        let message = format!("its chunks are compressed with {name} (filter {number}), which is unsupported; run h5repack -f GZIP=4");
        registry.register(number, Box::new(move |_, _, _| Err(Error::UnsupportedFilter(message.clone()))));
    }
    registry
}

/// Unpacks LZF: runs of bytes as they are, and copies of what was there up to 8 KiB before. Source: liblzf, lzf_d.c.
fn lzf(packed: &[u8], most: usize) -> Result<Vec<u8>> {
    let broken = || Error::InvalidData("an LZF chunk is corrupt".into());
    let mut out = Vec::with_capacity(most.min(packed.len().saturating_mul(4)));
    let mut at = 0;
    let mut next = || {
        at += 1;
        packed.get(at - 1).copied().map(usize::from)
    };
    while let Some(control) = next() {
        if control < 32 {
            for _ in 0..=control {
                out.push(next().ok_or_else(broken)? as u8);
            }
        } else {
            let length = match control >> 5 {
                7 => 7 + next().ok_or_else(broken)?,
                length => length,
            } + 2;
            let back = ((control & 31) << 8 | next().ok_or_else(broken)?) + 1;
            let from = out.len().checked_sub(back).ok_or_else(broken)?;
            // A copy may reach into itself.
            (from..from + length).for_each(|at| out.push(out[at]));
        }
        if out.len() > most {
            return Err(broken());
        }
    }
    Ok(out)
}
