//! The moment that is shown of a scene that changes.

use crate::flight::Flight;

/// The moment that is shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clock {
    /// The moment \[s\], in whole milliseconds.
    pub time: f64,
    /// True if it goes on by itself.
    pub playing: bool,
    /// The view in which a flight begins that has no second key yet.
    pub first: Option<Flight>,
}
