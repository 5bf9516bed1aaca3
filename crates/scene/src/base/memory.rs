//! The limit of what one array, grid or image may take.

use crate::error::{Error, Result};

/// Memory that a scene may use by default \[bytes\].
pub const DEFAULT_LIMIT: u64 = 16 << 30;

/// Refuses what would not fit before it is allocated.
///
/// # Errors
/// If `bytes` is more than `limit`; `what` is named.
pub fn check(what: &str, bytes: u64, limit: u64) -> Result<()> {
    if bytes > limit {
        return Err(Error::Memory { what: what.to_owned(), needed_mib: bytes.div_ceil(1 << 20), limit_mib: limit >> 20 });
    }
    Ok(())
}
