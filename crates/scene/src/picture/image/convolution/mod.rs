//! Convolutions of pictures with the light of a point.

mod kernel;
mod sphere;
mod spread;

pub use kernel::Kernel;
pub(crate) use sphere::Sphere;
pub(crate) use spread::Spread;

/// The farthest that light is spread \[pixels\].
const MAX_REACH: usize = 2048;

/// Radius of the glare in a picture with the given longer edge \[pixels\].
pub(crate) fn reach(longer: usize) -> usize {
    (longer / 2).clamp(1, MAX_REACH)
}
