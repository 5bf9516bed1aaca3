//! Blocks of values: which of them are stored, and how they are packed.
//!
//! A block begins with a byte that says which values its inactive places have; they may follow, of full width even where
//! the others are stored as half. Under mask compression the active values alone come next, packed by zlib or by Blosc,
//! whose buffers OpenVDB always makes with LZ4 and byte shuffle.
//!
//! Source: OpenVDB, io/Compression.h (`readCompressedValues`, `HalfReader`); c-blosc, README_HEADER.rst.

use barnard::error::Result;
use flate2::read::ZlibDecoder;
use half::f16;

use super::bytes::{Bytes, Mask};
use crate::formats::{FileFloat, exactly};

/// Flags of a grid's compression.
const ZIP: u32 = 1;
pub const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;
/// All flags that there are.
pub const COMPRESSIONS: u32 = ZIP | ACTIVE_MASK | BLOSC;

/// Number format of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coding {
    /// Flags of its compression.
    pub compression: u32,
    /// Bytes of a number that stands alone: the background, a tile of the root, an inactive value.
    pub full: usize,
    /// Bytes of a number in a block.
    pub packed: usize,
    /// The value of all that is nowhere else.
    pub background: f64,
}

/// Inactive-value code in the first byte of a block.
pub mod inactive {
    pub const BACKGROUND: u8 = 0;
    pub const ONE: u8 = 2;
    pub const MASK_OF_SIGN: u8 = 3;
    pub const MASK_AND_ONE: u8 = 4;
    pub const MASK_AND_TWO: u8 = 5;
    pub const STORED: u8 = 6;
}

/// A block as the file has it.
pub struct StoredBlock {
    /// The values of inactive places: where the selection is not set, and where it is.
    inactive: [f64; 2],
    selection: Option<Mask>,
    /// True if active values alone are stored.
    only_active: bool,
    /// Values that are stored.
    count: usize,
    packed: Packed,
    /// The place at which the packed values begin.
    pub at: u64,
}

enum Packed {
    Plain(Vec<u8>),
    Zip(Vec<u8>),
    Blosc(Vec<u8>),
}

impl Coding {
    /// True if numbers are of double precision.
    pub fn is_double(&self) -> bool {
        self.full == 8
    }

    /// Description of the compression.
    pub fn packing(&self) -> String {
        let packed = match self.compression & (ZIP | BLOSC) {
            0 => "plain",
            ZIP => "packed by zlib",
            _ => "packed by Blosc",
        };
        format!("{packed}, {}", if self.compression & ACTIVE_MASK != 0 { "active values alone" } else { "all values" })
    }

    /// A number that stands alone.
    pub fn number(&self, bytes: &mut Bytes) -> Result<f64> {
        let stored = bytes.take(self.full)?;
        let mut value = [0.0];
        unpack(&stored, self.full, &mut value);
        Ok(value[0])
    }

    /// Reads the block of a node with a number of places, of which those of `active` are stored.
    pub fn block(&self, bytes: &mut Bytes, active: &Mask, places: usize) -> Result<StoredBlock> {
        let kind = bytes.u8()?;
        if kind > inactive::STORED {
            return Err(bytes.wrong(format!("a block has kind {kind} of 0 to {}: the file is corrupt", inactive::STORED)));
        }
        let mut fill = [if kind == inactive::BACKGROUND { self.background } else { -self.background }, self.background];
        if matches!(kind, inactive::ONE | inactive::MASK_AND_ONE | inactive::MASK_AND_TWO) {
            fill[0] = self.number(bytes)?;
        }
        if kind == inactive::MASK_AND_TWO {
            fill[1] = self.number(bytes)?;
        }
        let masked = matches!(kind, inactive::MASK_OF_SIGN | inactive::MASK_AND_ONE | inactive::MASK_AND_TWO);
        let selection = masked.then(|| bytes.mask(places)).transpose()?;
        let only_active = self.compression & ACTIVE_MASK != 0 && kind != inactive::STORED;
        let count = if only_active { active.count() } else { places };
        let packed = self.packed(bytes, count)?;
        Ok(StoredBlock { inactive: fill, selection, only_active, count, at: bytes.at(), packed })
    }

    fn packed(&self, bytes: &mut Bytes, count: usize) -> Result<Packed> {
        let size = count * self.packed;
        // Half values that are none are not written at all, others as an empty buffer with its length.
        let is_half = self.packed < self.full;
        if (is_half && count == 0) || self.compression & (ZIP | BLOSC) == 0 {
            return Ok(Packed::Plain(bytes.take(size)?));
        }
        let length = bytes.i64()?;
        if length <= 0 {
            if length.unsigned_abs() != size as u64 {
                return Err(bytes.wrong(format!(
                    "{} uncompressed bytes are announced for {count} values of {} bytes",
                    length.unsigned_abs(),
                    self.packed
                )));
            }
            return Ok(Packed::Plain(bytes.take(size)?));
        }
        let coded = bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?;
        Ok(if self.compression & BLOSC != 0 { Packed::Blosc(coded) } else { Packed::Zip(coded) })
    }

    /// The values of all places of a node. The message says what is wrong with its bytes.
    pub fn values<T: FileFloat>(&self, block: &StoredBlock, active: &Mask, values: &mut [T]) -> std::result::Result<(), String> {
        let unpacked;
        let stored = match &block.packed {
            Packed::Plain(bytes_of_values) => bytes_of_values,
            Packed::Zip(packed) => {
                unpacked = exactly(ZlibDecoder::new(&packed[..]), block.count * self.packed, "zlib")?;
                &unpacked
            }
            Packed::Blosc(packed) => {
                unpacked = unblosc(packed, block.count * self.packed)?;
                &unpacked
            }
        };
        unpack(stored, self.packed, &mut values[..block.count]);
        if block.only_active && block.count < values.len() {
            let inactive = block.inactive.map(T::of);
            // From the last on, so that nothing is overwritten before it is moved.
            let mut next = block.count;
            for place in (0..values.len()).rev() {
                values[place] = if active.holds(place) {
                    next -= 1;
                    values[next]
                } else {
                    inactive[usize::from(block.selection.as_ref().is_some_and(|s| s.holds(place)))]
                };
            }
        }
        Ok(())
    }
}

/// Numbers of a given number of bytes each.
fn unpack<T: FileFloat>(bytes: &[u8], size: usize, values: &mut [T]) {
    match size {
        2 => values.iter_mut().zip(bytes.as_chunks::<2>().0).for_each(|(v, b)| *v = T::of(f64::from(f16::from_le_bytes(*b)))),
        4 => values.iter_mut().zip(bytes.as_chunks::<4>().0).for_each(|(v, b)| *v = T::of(f64::from(f32::from_le_bytes(*b)))),
        _ => values.iter_mut().zip(bytes.as_chunks::<8>().0).for_each(|(v, b)| *v = T::of(f64::from_le_bytes(*b))),
    }
}

/// Bytes of a Blosc buffer before its blocks.
const HEADER: usize = 16;
/// Flags of a Blosc buffer.
const SHUFFLED: u8 = 1;
const PLAIN: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const NOT_SPLIT: u8 = 16;
/// The number by which Blosc knows LZ4, in the three highest bits of the flags.
const LZ4: u8 = 1;
/// Blocks of fewer numbers are not split into streams.
const LEAST_SPLIT: usize = 128;
/// The largest number whose bytes have streams of their own.
const MOST_STREAMS: usize = 16;

/// Unpacks a Blosc buffer of version 1 that holds `size` bytes.
fn unblosc(coded: &[u8], size: usize) -> std::result::Result<Vec<u8>, String> {
    let short = || format!("its Blosc buffer of {} bytes is truncated", coded.len());
    let header: &[u8; HEADER] = coded.first_chunk().ok_or_else(short)?;
    let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]) as usize;
    let (flags, type_size) = (header[2], usize::from(header[3]).max(1));
    let (bytes, block, length) = (word(4), word(8), word(12));
    if bytes != size {
        return Err(format!("its Blosc buffer has {bytes} bytes, expected {size}"));
    }
    if length > coded.len() {
        return Err(short());
    }
    let body = &coded[..length.max(HEADER)];
    if flags & PLAIN != 0 {
        return body.get(HEADER..HEADER + size).map(<[u8]>::to_vec).ok_or_else(short);
    }
    if flags >> 5 != LZ4 || flags & BITS_SHUFFLED != 0 {
        return Err("its Blosc buffer is not LZ4 with byte shuffle, as OpenVDB writes it".into());
    }
    if size > 0 && (block == 0 || block > size) {
        return Err(format!("its Blosc buffer has blocks of {block} bytes in {size}"));
    }
    let mut out = vec![0; size];
    let word_of = |at: usize| body.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b) as usize);
    for (i, out) in out.chunks_mut(block.max(1)).enumerate() {
        let mut at = word_of(HEADER + 4 * i).ok_or_else(short)?;
        let is_split = flags & NOT_SPLIT == 0 && type_size <= MOST_STREAMS && block / type_size >= LEAST_SPLIT && out.len() == block;
        let streams = if is_split { type_size } else { 1 };
        if !out.len().is_multiple_of(streams) {
            return Err(format!("its Blosc buffer splits {} bytes into {streams} streams", out.len()));
        }
        let mut unpacked = vec![0; out.len()];
        for stream in unpacked.chunks_mut(out.len() / streams) {
            let length = word_of(at).ok_or_else(short)?;
            let packed = at.checked_add(4).and_then(|from| body.get(from..from.checked_add(length)?)).ok_or_else(short)?;
            at += 4 + length;
            if length == stream.len() {
                stream.copy_from_slice(packed);
            } else if lz4_flex::block::decompress_into(packed, stream).ok() != Some(stream.len()) {
                return Err("the LZ4 stream of its Blosc buffer is corrupt".into());
            }
        }
        if flags & SHUFFLED != 0 && type_size > 1 { unshuffle(&unpacked, type_size, out) } else { out.copy_from_slice(&unpacked) }
    }
    Ok(out)
}

/// Puts bytes back that stand together by their place in a number; what is less than a number stays.
fn unshuffle(shuffled: &[u8], size: usize, out: &mut [u8]) {
    let numbers = shuffled.len() / size;
    let whole = numbers * size;
    for (byte, column) in shuffled[..whole].chunks(numbers.max(1)).enumerate() {
        column.iter().enumerate().for_each(|(i, v)| out[i * size + byte] = *v);
    }
    out[whole..].copy_from_slice(&shuffled[whole..]);
}
