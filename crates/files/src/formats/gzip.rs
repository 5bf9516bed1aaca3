//! Files that gzip packed as a whole, unpacked as they are read.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use barnard::error::{Error, Result};
use flate2::read::MultiGzDecoder;

use super::{Request, Seekable};

const MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Makes a request for a packed file one for what it holds; others stay as they are. All of it is unpacked once, for its
/// length and its checksum, and none of it is kept.
pub fn unpacked(request: &mut Request) -> Result<()> {
    if request.bytes(0, MAGIC.len())?.is_none_or(|found| found != MAGIC) {
        return Ok(());
    }
    let failed = |e: io::Error| Error::file(request.path, format!("is not a readable gzip file: {e}"));
    let packed = std::mem::replace(&mut request.source, Box::new(io::empty()));
    let mut whole = Unpacked::new(packed).map_err(failed)?;
    request.length = io::copy(&mut whole.decoder, &mut io::sink()).map_err(failed)?;
    (whole.at, whole.length) = (request.length, request.length);
    request.source = Box::new(whole);
    Ok(())
}

/// Contents of a compressed file. Going back begins anew.
struct Unpacked {
    decoder: MultiGzDecoder<BufReader<Box<dyn Seekable>>>,
    at: u64,
    length: u64,
}

impl Unpacked {
    fn new(mut packed: Box<dyn Seekable>) -> io::Result<Self> {
        packed.rewind()?;
        Ok(Self { decoder: MultiGzDecoder::new(BufReader::with_capacity(1 << 16, packed)), at: 0, length: 0 })
    }
}

impl Read for Unpacked {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.decoder.read(bytes)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Unpacked {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let to = match to {
            SeekFrom::Start(to) => Some(to),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
        };
        let to = to.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "a position before the beginning"))?;
        if to < self.at {
            let empty = MultiGzDecoder::new(BufReader::new(Box::new(io::empty()) as Box<dyn Seekable>));
            let packed = std::mem::replace(&mut self.decoder, empty).into_inner().into_inner();
            *self = Self { length: self.length, ..Self::new(packed)? };
        }
        self.at += io::copy(&mut (&mut self.decoder).take(to - self.at), &mut io::sink())?;
        Ok(self.at)
    }
}
