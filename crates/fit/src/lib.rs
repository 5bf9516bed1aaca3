//! Parameters of scenes from observed images, with error bars.
//!
//! Data are images with their own passbands, instruments, errors and masks, one or several; the model of each is the scene's picture
//! as its instrument would record it in endless frames. Parameters in which all models are linear, such as luminosities, emission scales
//! and backgrounds, are solved inside (variable projection: Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413), the others by
//! Levenberg–Marquardt. [`fit()`] knows numbers alone, [`Images`] makes them of scenes and data, [`Parameter`] is what is free.

mod images;
mod marched;
mod observation;
mod parameter;
mod recorded;
pub mod solve;

pub use images::{Images, Residuals};
pub use observation::{Assumed, Data, Observation, PixelData, PixelValues, planes_of};
pub use parameter::{Parameter, free_parameters, narrowed};
pub use solve::{Fitted, fit};
