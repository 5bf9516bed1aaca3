//! Names that most programs use: `use barnard::prelude::*`.

pub use crate::backend::{Backend, Job, Registry, Renderer};
pub use crate::field::{Field, Grid};
pub use crate::geometry::Bounds;
pub use crate::glam::{DVec3, dvec3};
pub use crate::phase::{HenyeyGreenstein, Phase};
pub use crate::plan::Quality;
pub use crate::scene::{Dust, Emission, Method, Scale, Scene, SceneSpec, Star};
pub use crate::spectra::extinction::Extinction;
pub use crate::spectra::passband::{self, Passband};
pub use crate::spectra::units::{Length, Luminosity, Temperature, Wavelength};
pub use crate::{Camera, Control, Image, Options, Planned, Planner, Plates, render, render_with};
