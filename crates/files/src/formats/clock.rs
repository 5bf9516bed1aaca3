//! The time now.

use std::time::SystemTime;

/// The time now as ISO 8601 has it, in UTC: 2026-11-22T21:09:33.
pub(super) fn now() -> String {
    humantime::format_rfc3339_seconds(clock()).to_string().replace('Z', "")
}

#[cfg(not(target_family = "wasm"))]
fn clock() -> SystemTime {
    SystemTime::now()
}

#[cfg(target_family = "wasm")]
fn clock() -> SystemTime {
    SystemTime::UNIX_EPOCH + web_time::SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default()
}
