//! The bytes of a request as the crate reads them: from any place, by any thread.

use std::io::{Error, ErrorKind, SeekFrom};
use std::sync::{Arc, Mutex, PoisonError};

use hdf5_reader::storage::DynStorage;
use hdf5_reader::{Storage, StorageBuffer};

use crate::formats::Seekable;

/// A file whose readers take turns.
pub struct SharedFile {
    bytes: Mutex<Box<dyn Seekable>>,
    length: u64,
}

impl SharedFile {
    /// Bytes that have this length.
    pub fn shared(bytes: Box<dyn Seekable>, length: u64) -> DynStorage {
        Arc::new(Self { bytes: Mutex::new(bytes), length })
    }
}

impl Storage for SharedFile {
    fn len(&self) -> u64 {
        self.length
    }

    fn read_range(&self, offset: u64, length: usize) -> hdf5_reader::error::Result<StorageBuffer> {
        if offset.checked_add(length as u64).is_none_or(|end| end > self.length) {
            let message = format!(
                "it points to bytes {offset} to {} of {}: the file is truncated or corrupt",
                offset.saturating_add(length as u64),
                self.length
            );
            return Err(Error::new(ErrorKind::UnexpectedEof, message).into());
        }
        let mut data = vec![0; length];
        // What a thread that panicked left behind is only a place in the file, which is set anew.
        let mut bytes = self.bytes.lock().unwrap_or_else(PoisonError::into_inner);
        bytes.seek(SeekFrom::Start(offset))?;
        bytes.read_exact(&mut data)?;
        Ok(StorageBuffer::from_vec(data))
    }
}
