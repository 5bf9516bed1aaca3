//! Images that stand in a table, tile by tile, packed by gzip or Rice, as fpack, CFITSIO and astropy write them.
//!
//! Source: FITS standard 4.0, §10; Pence, White & Seaman 2010, PASP 122, 1065 (Rice coding, dithering).

use std::sync::OnceLock;

use barnard::data;
use barnard::error::{Error, Result};
use barnard::memory;
use flate2::read::MultiGzDecoder;

use super::header::Header;
use super::table::FitsTable;
use super::{stored_of, value_of};
use crate::formats::gather::{BlockRange, Gather, cut, lines};
use crate::formats::numbers::{Number, Stored};
use crate::formats::{FileFloat, Request, exactly};

/// Positions and compression of an image's tiles.
struct CompressedTiles<'h> {
    header: &'h Header,
    /// Lengths of the image's and the tiles' axes, the fastest first.
    axes: Vec<u64>,
    edges: Vec<u64>,
    table: FitsTable,
    packing: TilePacking,
    /// Number type of the image, and those that are packed where they were made whole ones.
    stored: Stored,
    dither: Dither,
}

/// Compression of a tile.
#[derive(Clone, Copy, PartialEq)]
enum TilePacking {
    None,
    Gzip { shuffled: bool },
    Rice { pixels: usize, bytes: usize },
}

/// Dithering of numbers before quantisation.
#[derive(Clone, Copy, PartialEq)]
enum Dither {
    None,
    /// An offset for each number, by a seed; and whether zero was kept as it was.
    Subtractive {
        seed: usize,
        keeps_zero: bool,
    },
}

/// Tile data in the file.
struct CompressedTile {
    bytes: Vec<u8>,
    packing: TilePacking,
    /// Scale and offset of its quantised numbers; `None` if unquantised.
    scale: Option<(f64, f64)>,
    blank: Option<f64>,
    /// Its place among the tiles.
    row: usize,
}

/// Selected part of an image of this shape, whose axes are those of `numbers` in the file, into `gather`.
pub fn gathered<T: FileFloat>(
    request: &mut Request,
    header: &Header,
    numbers: [Option<usize>; 3],
    mut gather: Gather<T>,
) -> Result<data::Numbers> {
    let (path, limit) = (request.path, request.memory_limit);
    let wrong = |reason: String| Error::file(path, reason);
    let tiles = CompressedTiles::of(header).map_err(wrong)?;
    let elements = tiles.elements();
    memory::check(&format!("a tile of {}", path.display()), elements.saturating_mul(8), limit)?;
    let cells = tiles.table.read(request, header)?;
    let edges = numbers.map(|number| number.and_then(|n| tiles.edges.get(n - 1)).map_or(1, |edge| *edge as usize));
    let whole: Vec<u64> = tiles.axes.iter().zip(&tiles.edges).map(|(axis, edge)| axis.div_ceil(*edge)).collect();
    let place = |block: &BlockRange| {
        let mut at = vec![0u64; tiles.axes.len()];
        for (i, number) in numbers.iter().enumerate() {
            if let Some(slot) = number.and_then(|n| at.get_mut(n - 1)) {
                *slot = (block[i].start / edges[i]) as u64;
            }
        }
        at
    };
    let row = |at: &[u64]| at.iter().zip(&whole).rev().fold(0, |row, (at, count)| row * count + at) as usize;
    let value = value_of::<T>(header);
    let blocks = cut(&gather.ranges, edges);
    gather.blocks(
        blocks,
        // As packed, unpacked, and what is meant of it.
        (elements.saturating_mul(24), limit),
        |block| tiles.fetch(request, &cells, row(&place(block))),
        |block, tile| {
            let at = place(block);
            let sizes: Vec<u64> = (0..at.len()).map(|i| tiles.edges[i].min(tiles.axes[i] - at[i] * tiles.edges[i])).collect();
            let count = sizes.iter().product::<u64>() as usize;
            let failed = |reason| Error::file(path, format!("tile {}: {reason}", tile.row + 1));
            let all = tiles.unpack(&tile, count).map_err(failed)?;
            let size = |i: usize| numbers[i].and_then(|n| sizes.get(n - 1)).map_or(1, |size| *size as usize);
            let mut values = Vec::with_capacity(block.iter().map(|range| range.len()).product());
            let inner: BlockRange = std::array::from_fn(|i| {
                let first = block[i].start / edges[i] * edges[i];
                block[i].start - first..block[i].end - first
            });
            for [i, j] in lines(&inner) {
                let line = &all[(i * size(1) + j) * size(2)..];
                values.extend(line[inner[2].clone()].iter().map(|v| value(*v)));
            }
            Ok(values)
        },
    )?;
    gather.finish()
}

impl<'h> CompressedTiles<'h> {
    fn of(header: &'h Header) -> Result<Self, String> {
        let axes = header.axes().ok_or("ZNAXIS is missing or invalid")?;
        let stored = stored_of(header.bitpix())?;
        let edge = |i: usize| match header.integer(&format!("ZTILE{i}")) {
            Some(edge) if edge > 0 => Ok((edge as u64).min(axes[i - 1])),
            Some(edge) => Err(format!("ZTILE{i} = {edge} is not a valid tile length")),
            // Without a word a tile is a row.
            None => Ok(if i == 1 { axes[0] } else { 1 }),
        };
        let edges = (1..=axes.len()).map(edge).collect::<Result<Vec<u64>, String>>()?;
        let option = |name: &str| {
            let number = (1..).map_while(|i| header.text(&format!("ZNAME{i}"))).position(|known| known == name)?;
            header.integer(&format!("ZVAL{}", number + 1))
        };
        let packing = match header.text("ZCMPTYPE").unwrap_or("none") {
            "NOCOMPRESS" => TilePacking::None,
            "GZIP_1" => TilePacking::Gzip { shuffled: false },
            "GZIP_2" => TilePacking::Gzip { shuffled: true },
            "RICE_1" | "RICE_ONE" => TilePacking::Rice {
                pixels: option("BLOCKSIZE").and_then(|n| usize::try_from(n).ok()).unwrap_or(32),
                bytes: option("BYTEPIX").and_then(|n| usize::try_from(n).ok()).unwrap_or(4),
            },
            other => return Err(format!("its tiles are compressed with {other}, which is unsupported; run funpack first")),
        };
        if let TilePacking::Rice { pixels, bytes } = packing
            && !([1, 2, 4].contains(&bytes) && (1..=MOST_PIXELS).contains(&pixels))
        {
            return Err(format!("BYTEPIX = {bytes} must be 1, 2 or 4, and BLOCKSIZE = {pixels} between 1 and {MOST_PIXELS}"));
        }
        let seed = header.integer("ZDITHER0").and_then(|n| usize::try_from(n).ok()).unwrap_or(1).max(1);
        let dither = match header.text("ZQUANTIZ").unwrap_or("NO_DITHER") {
            "SUBTRACTIVE_DITHER_1" => Dither::Subtractive { seed, keeps_zero: false },
            "SUBTRACTIVE_DITHER_2" => Dither::Subtractive { seed, keeps_zero: true },
            _ => Dither::None,
        };
        Ok(Self { header, axes, edges, table: FitsTable::of(header)?, packing, stored, dither })
    }

    /// Elements of a whole tile.
    fn elements(&self) -> u64 {
        self.edges.iter().fold(1, |elements, edge| elements.saturating_mul(*edge))
    }

    /// Reads what the file has of a tile, by the rows of its table.
    fn fetch(&self, request: &mut Request, rows: &[u8], row: usize) -> Result<CompressedTile> {
        let path = request.path;
        let wrong = |reason: &str| Error::file(path, format!("tile {}: {reason}", row + 1));
        let missing = || wrong("it is beyond the end of the file: the file is truncated or corrupt");
        let cells = rows.chunks_exact(self.table.row.max(1)).nth(row).ok_or_else(missing)?;
        let packings = [
            ("COMPRESSED_DATA", self.packing),
            ("GZIP_COMPRESSED_DATA", TilePacking::Gzip { shuffled: false }),
            ("UNCOMPRESSED_DATA", TilePacking::None),
        ];
        let found = packings.into_iter().find_map(|(name, packing)| {
            let (from, bytes) = self.table.list(name, cells).filter(|(_, bytes)| *bytes > 0)?;
            Some((name, packing, from, bytes))
        });
        let (name, packing, from, bytes) = found.ok_or_else(|| wrong("it holds nothing"))?;
        // No compression expands numbers by more.
        if bytes > self.elements().saturating_mul(16).saturating_add(1 << 16) {
            return Err(wrong("it is longer than its numbers: the file is corrupt"));
        }
        let from = self.header.data.checked_add(self.table.heap).and_then(|heap| heap.checked_add(from)).ok_or_else(missing)?;
        let bytes = request.bytes(from, usize::try_from(bytes).unwrap_or(usize::MAX))?.ok_or_else(missing)?;
        let number = |name: &str| self.table.number(name, cells).or_else(|| self.header.number(name));
        // Numbers that no quantum fits are packed as they are.
        let scale = number("ZSCALE").zip(number("ZZERO")).filter(|_| name == "COMPRESSED_DATA");
        Ok(CompressedTile { bytes, packing, scale, blank: number("ZBLANK"), row })
    }

    /// The numbers of a tile, `count` of them.
    fn unpack(&self, tile: &CompressedTile, count: usize) -> Result<Vec<f64>, String> {
        let scale = tile.scale.filter(|_| matches!(self.stored.kind, Number::Float(_)));
        // Numbers that were made whole have four bytes.
        let stored = if scale.is_some() { Stored { kind: Number::Int(4), big_endian: true } } else { self.stored };
        let mut values: Vec<f64> = match tile.packing {
            TilePacking::None => decoded(stored, &tile.bytes, count)?,
            TilePacking::Gzip { shuffled } => {
                let mut bytes = exactly(MultiGzDecoder::new(&tile.bytes[..]), count.saturating_mul(stored.size()), "gzip")?;
                if shuffled {
                    bytes = (0..bytes.len()).map(|i| bytes[i % stored.size() * count + i / stored.size()]).collect();
                }
                decoded(stored, &bytes, count)?
            }
            TilePacking::Rice { .. } if matches!(stored.kind, Number::Float(_)) => {
                return Err("Rice compression of floats requires ZSCALE".into());
            }
            TilePacking::Rice { pixels, bytes } => rice(&tile.bytes, count, pixels, bytes)?,
        };
        if let Some((scale, zero)) = scale {
            let mut offsets = self.dither.offsets(tile.row);
            for value in &mut values {
                let offset = offsets.as_mut().and_then(Iterator::next);
                *value = match (Some(*value) == tile.blank, self.dither) {
                    (true, _) => f64::NAN,
                    (_, Dither::Subtractive { keeps_zero: true, .. }) if *value == ZERO => 0.0,
                    _ => (*value - offset.map_or(0.0, |r| f64::from(r) - 0.5)) * scale + zero,
                };
            }
        } else if let Some(blank) = tile.blank.filter(|_| !matches!(self.stored.kind, Number::Float(_))) {
            values.iter_mut().filter(|v| **v == blank).for_each(|v| *v = f64::NAN);
        }
        Ok(values)
    }
}

/// Most pixels of a block of Rice coding; packers take 16 or 32.
const MOST_PIXELS: usize = 1024;
/// The whole number that stands for zero where it was kept.
const ZERO: f64 = -2_147_483_646.0;
/// Number of random numbers, used cyclically.
const RANDOM: usize = 10_000;

impl Dither {
    /// Dither offset of each number of a tile, from 0 to 1. Source: FITS standard 4.0, §10.2.1 and appendix I.
    fn offsets(self, row: usize) -> Option<impl Iterator<Item = f32>> {
        static NUMBERS: OnceLock<Vec<f32>> = OnceLock::new();
        let Self::Subtractive { seed, .. } = self else { return None };
        let numbers = NUMBERS.get_or_init(|| {
            // Park & Miller 1988, CACM 31, 1192.
            let next = |seed: &u64| Some(seed * 16_807 % 2_147_483_647);
            std::iter::successors(next(&1), next).take(RANDOM).map(|seed| (seed as f64 / 2_147_483_647.0) as f32).collect()
        });
        let first = move |index: usize| (numbers[index] * 500.0) as usize;
        let mut outer = (row + seed - 1) % RANDOM;
        let mut inner = first(outer);
        Some(std::iter::from_fn(move || {
            let number = numbers[inner];
            inner += 1;
            if inner == RANDOM {
                outer = (outer + 1) % RANDOM;
                inner = first(outer);
            }
            Some(number)
        }))
    }
}

fn decoded(stored: Stored, bytes: &[u8], count: usize) -> Result<Vec<f64>, String> {
    let mut values = Vec::with_capacity(count.min(bytes.len()));
    stored.decode(bytes, |v| values.push(v));
    if values.len() == count { Ok(values) } else { Err(format!("it has {} numbers, expected {count}", values.len())) }
}

/// Integers of a number of bytes that Rice coding packed, in blocks of `pixels`.
fn rice(packed: &[u8], count: usize, pixels: usize, bytes: usize) -> Result<Vec<f64>, String> {
    let broken = || "its Rice data are truncated".to_owned();
    let width = 8 * bytes as u32;
    // Bits that say how many low bits follow, and the most of them.
    let (bits_of_split, most_split) = match bytes {
        1 => (3, 6),
        2 => (4, 14),
        _ => (5, 25),
    };
    let mut bits = BitReader { bytes: packed, at: 0 };
    let mut last = bits.take(width).ok_or_else(broken)?;
    let mut values = Vec::with_capacity(count);
    while values.len() < count {
        let split = bits.take(bits_of_split).ok_or_else(broken)?;
        for _ in 0..pixels.min(count - values.len()) {
            let difference = match split {
                0 => 0,
                // Differences that do not pack stand as they are.
                split if split > most_split => bits.take(width).ok_or_else(broken)?,
                split => {
                    let high = bits.zeros().ok_or_else(broken)?;
                    let low = bits.take(split - 1).ok_or_else(broken)?;
                    high.wrapping_shl(split - 1) | low
                }
            };
            // Signs alternate: 0, -1, 1, -2, ...
            let signed = if difference & 1 == 1 { !(difference >> 1) } else { difference >> 1 };
            last = last.wrapping_add(signed);
            values.push(match bytes {
                1 => f64::from(last as u8),
                2 => f64::from(last as i16),
                _ => f64::from(last as i32),
            });
        }
    }
    Ok(values)
}

/// Bits of bytes, the highest first.
struct BitReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl BitReader<'_> {
    /// The next 32 bits, and how many of them there are.
    fn window(&self) -> (u32, usize) {
        let first = self.at / 8;
        let byte = |i: usize| u64::from(self.bytes.get(first + i).copied().unwrap_or(0));
        let five = (0..5).fold(0u64, |bits, i| bits << 8 | byte(i));
        ((five >> (8 - self.at % 8)) as u32, (8 * self.bytes.len()).saturating_sub(self.at))
    }

    /// A number of some bits, 32 at most.
    fn take(&mut self, count: u32) -> Option<u32> {
        let (window, left) = self.window();
        if left < count as usize {
            return None;
        }
        self.at += count as usize;
        Some(window.checked_shr(32 - count).unwrap_or(0))
    }

    /// The number of zeros before the next one, which is passed over.
    fn zeros(&mut self) -> Option<u32> {
        let mut zeros = 0;
        loop {
            let (window, left) = self.window();
            let here = window.leading_zeros() as usize;
            if here < 32.min(left) {
                self.at += here + 1;
                return Some(zeros + here as u32);
            }
            if left <= 32 {
                return None;
            }
            self.at += 32;
            zeros += 32;
        }
    }
}
