//! Values of a volume in single precision or in halves.

use crate::stored::Half;

/// Values of a volume.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// In single precision.
    Single(Vec<f32>),
    /// In half of that.
    Half(Vec<Half>),
}

/// Runs one expression on the values of a volume in either precision.
macro_rules! stored {
    ($values:expr, |$data:ident| $body:expr) => {
        match $values {
            $crate::volume::Values::Single($data) => $body,
            $crate::volume::Values::Half($data) => $body,
        }
    };
}
pub(crate) use stored;
