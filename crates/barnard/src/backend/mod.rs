//! Back ends: the ways to turn a scene into an image. One file (or folder) and one row of [`BACKENDS`] each.

pub mod cpu;
pub mod path;
pub mod reference;

/// One row of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct BackendEntry {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
}

/// All back ends; the first is the default. `gpu` stands in a crate of its own, for its dependencies.
pub const BACKENDS: &[BackendEntry] = &[
    BackendEntry { name: "cpu", summary: "f32, SIMD, all cores, reads only the plan; the same bits on any number of threads" },
    BackendEntry {
        name: "gpu",
        summary: "f32 on a graphics processor (Vulkan, Metal, DirectX 12), reads only the plan; methods of exponentials",
    },
    BackendEntry { name: "auto", summary: "gpu where there is a real one that does the method, otherwise cpu; says which and why" },
    BackendEntry {
        name: "path",
        summary: "f64, the referee: an unbiased path tracer, any number of bounces, standard errors beside the bands",
    },
    BackendEntry { name: "reference", summary: "f64, adaptive in space and wavelength, exact star depths: slow, plain, the definition" },
];
