//! Little-endian numbers and texts of a file, one after the other; every error says the grid and the byte.

use std::io::{BufReader, Read};
use std::path::Path;

use barnard::error::{Error, Result};

use crate::formats::{Request, Seekable};

/// The longest name or text that is read \[bytes\].
const LONGEST_TEXT: usize = 1 << 16;
/// Bytes that are read ahead.
const AHEAD: usize = 1 << 18;

/// A file, and the place in it from which the next number comes.
pub struct Bytes<'a> {
    reader: BufReader<&'a mut dyn Seekable>,
    path: &'a Path,
    length: u64,
    at: u64,
    /// The grid that is read, for messages; empty before there is one.
    pub grid: String,
}

impl<'a> Bytes<'a> {
    /// The bytes of a request, from the first on.
    pub fn new(request: &'a mut Request) -> Result<Self> {
        let (path, length) = (request.path, request.length);
        request.source.rewind().map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
        Ok(Self { reader: BufReader::with_capacity(AHEAD, &mut *request.source), path, length, at: 0, grid: String::new() })
    }

    /// The place of the next byte.
    pub fn at(&self) -> u64 {
        self.at
    }

    /// Bytes from there to the end of the file.
    pub fn left(&self) -> u64 {
        self.length - self.at
    }

    /// The error that something is wrong at a place.
    pub fn wrong_at(&self, at: u64, reason: impl std::fmt::Display) -> Error {
        let grid = if self.grid.is_empty() { String::new() } else { format!("grid \"{}\", ", self.grid) };
        Error::file(self.path, format!("{grid}byte {at}: {reason}"))
    }

    /// The error that something is wrong with what was just read.
    pub fn wrong(&self, reason: impl std::fmt::Display) -> Error {
        self.wrong_at(self.at, reason)
    }

    /// Goes to another place.
    pub fn go(&mut self, to: u64) -> Result<()> {
        if to > self.length {
            return Err(self.wrong(format!("the file points to byte {to} of {}: it is truncated or corrupt", self.length)));
        }
        // Short ways stay within what is read ahead.
        let way = i64::try_from(i128::from(to) - i128::from(self.at)).unwrap_or(i64::MAX);
        self.reader.seek_relative(way).map_err(|e| Error::file(self.path, format!("cannot be read: {e}")))?;
        self.at = to;
        Ok(())
    }

    /// Leaves out some bytes.
    pub fn skip(&mut self, count: u64) -> Result<()> {
        let to = self.at.checked_add(count).filter(|to| *to <= self.length);
        let to =
            to.ok_or_else(|| self.wrong(format!("{count} bytes are announced, {} remain: the file is truncated or corrupt", self.left())))?;
        self.go(to)
    }

    /// Fills `bytes`.
    pub fn fill(&mut self, bytes: &mut [u8]) -> Result<()> {
        if bytes.len() as u64 > self.left() {
            return Err(self.wrong(format!(
                "{} bytes are announced, {} remain: the file is truncated or corrupt",
                bytes.len(),
                self.left()
            )));
        }
        self.reader.read_exact(bytes).map_err(|e| self.wrong(format!("cannot be read: {e}")))?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// So many bytes, after a look at how many there are.
    pub fn take(&mut self, count: usize) -> Result<Vec<u8>> {
        if count as u64 > self.left() {
            return Err(self.wrong(format!("{count} bytes are announced, {} remain: the file is truncated or corrupt", self.left())));
        }
        let mut bytes = vec![0; count];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub fn i32(&mut self) -> Result<i32> {
        Ok(i32::from_le_bytes(self.array()?))
    }

    pub fn i64(&mut self) -> Result<i64> {
        Ok(i64::from_le_bytes(self.array()?))
    }

    /// So many doubles.
    pub fn doubles<const N: usize>(&mut self) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.array()?);
        }
        Ok(numbers)
    }

    /// Three whole numbers: a place among the voxels.
    pub fn place(&mut self) -> Result<[i32; 3]> {
        Ok([self.i32()?, self.i32()?, self.i32()?])
    }

    /// A text with its length before it.
    pub fn text(&mut self) -> Result<String> {
        let length = self.u32()? as usize;
        if length > LONGEST_TEXT {
            return Err(self.wrong(format!("a name of {length} bytes is announced; at most {LONGEST_TEXT} are supported")));
        }
        Ok(String::from_utf8_lossy(&self.take(length)?).into_owned())
    }

    /// A mask of a given number of bits.
    pub fn mask(&mut self, bits: usize) -> Result<Mask> {
        let bytes = self.take(bits / 8)?;
        Ok(Mask(bytes.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)).collect()))
    }
}

/// Bits, the lowest of the first word first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask(Box<[u64]>);

impl Mask {
    /// True if a bit is set.
    pub fn holds(&self, bit: usize) -> bool {
        self.0.get(bit / 64).is_some_and(|word| word >> (bit % 64) & 1 == 1)
    }

    /// Number of bits that are set.
    pub fn count(&self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The bits that are set, in order.
    pub fn set(&self) -> impl Iterator<Item = usize> + '_ {
        (0..64 * self.0.len()).filter(|bit| self.holds(*bit))
    }
}
