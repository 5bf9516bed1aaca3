//! Numbers in messages.

/// A number in all its digits, or with an exponent where those would be mostly zeros.
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-6..1e16).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}
