//! Back ends: the ways to turn a scene into an image. One file (or folder) and one row of [`BACKENDS`] each.

pub mod cpu;
pub mod reference;

/// One row of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct BackendEntry {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
}

/// All back ends; the first is the default.
pub const BACKENDS: &[BackendEntry] = &[
    BackendEntry { name: "cpu", summary: "f32, SIMD, all cores, reads only the plan; the same bits on any number of threads" },
    BackendEntry { name: "reference", summary: "f64, adaptive in space and wavelength, exact star depths: slow, plain, the definition" },
];
