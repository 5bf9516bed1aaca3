//! Plans: the numbers a scene comes to, made once in f64. The fast back ends read only this.
//!
//! [`Space`] holds what the places of things decide (density, star depths, empty space, step), [`Spectral`] what spectra decide (nodes, weights,
//! phase tables). A changed spectrum keeps the space, a changed camera keeps both.

mod bricks;
mod describe;
pub mod near;
mod pilot;
mod planes;
mod pyramid;
pub mod segment;
mod space;
mod spectral;
pub mod star_depth;
mod volume;

use std::sync::Arc;

pub use bricks::Bricks;
pub use describe::describe;
pub use pilot::Spatial;
pub use space::{Space, sample_functions};
pub use spectral::{BandPlan, PHASE_RANGE, PhaseTable, Spectral};
pub use volume::{Channel, MAX_CHANNELS, Volume};

use spectra::rule::Certificate;

use crate::camera::Camera;
use crate::control::Control;
use crate::error::Result;
use crate::light::Light;
use crate::scene::{Method, Scene, StarDepth};

/// What a user may decide beside the scene.
#[derive(Debug, Clone)]
pub struct Options {
    /// Spectral rule and accuracy.
    pub method: Method,
    /// Most bytes a plan may take.
    pub memory_limit: u64,
}

/// Everything a fast back end needs.
#[derive(Debug)]
pub struct Plan {
    /// From pixels to rays.
    pub camera: Camera,
    /// The lights, in the order of all tables.
    pub lights: Arc<Vec<Light>>,
    /// What places decide.
    pub space: Arc<Space>,
    /// What spectra decide.
    pub spectral: Arc<Spectral>,
    /// Steps along a ray.
    pub stepping: Stepping,
    /// Samples of a star depth that is marched again at every sample of a ray instead of being read: the deck's double integration.
    pub star_march: Option<usize>,
}

/// Samples a ray of the deck.
pub const DECK_STEPS: usize = 100;

/// How far a ray's samples are apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepping {
    /// So many samples in each voxel edge of the finest grid.
    PerVoxel(f64),
    /// So many samples on every ray.
    Fixed(usize),
}

impl Stepping {
    /// Samples along so many parsecs.
    pub fn steps(self, length_pc: f64, voxel_pc: f64) -> usize {
        match self {
            Stepping::PerVoxel(n) => (length_pc / voxel_pc * n).ceil().max(1.0) as usize,
            Stepping::Fixed(n) => n,
        }
    }
}

impl std::fmt::Display for Stepping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Stepping::PerVoxel(n) => write!(f, "{n} samples a voxel"),
            Stepping::Fixed(n) => write!(f, "{n} samples a ray"),
        }
    }
}

impl Plan {
    /// Plans `scene`.
    pub fn new(scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        let lights = Arc::new(crate::light::lights(scene)?);
        let mut space = Space::new(scene, options, control)?;
        space.check_stars(scene)?;
        let spectral = Arc::new(pilot::spectral(scene, &lights, &space, options, control)?);
        let marched = options.method.entry.star_depth == StarDepth::Marched;
        let star_march = marched.then(|| options.method.steps.unwrap_or(DECK_STEPS));
        let stepping = match star_march {
            // Nothing is baked that a step could be wrong about.
            Some(n) => Stepping::Fixed(options.method.steps.unwrap_or(n)),
            None => pilot::choose(scene, &lights, &spectral, &mut space, options, options.method.steps, control)?,
        };
        Ok(Self { camera: scene.camera.clone(), lights, space: Arc::new(space), spectral, stepping, star_march })
    }

    /// The certificate of a passband in words, a line for each light, for optical depths up to `depth`.
    pub fn certificate(&self, band: usize, depth: f64) -> Vec<String> {
        self.certificates(band, depth).iter().map(|(light, c)| format!("{}: {}", self.lights[*light].name, in_words(c))).collect()
    }

    /// The certificate of the light that a passband's rule serves worst, in words.
    pub fn worst_certificate(&self, band: usize, depth: f64) -> String {
        let certificates = self.certificates(band, depth);
        let Some((light, worst)) = certificates.iter().max_by(|a, b| a.1.absolute.total_cmp(&b.1.absolute)) else {
            return "no light shines in this band".into();
        };
        let others = match certificates.len() {
            1 => String::new(),
            count => format!(", worst of {count} lights ({})", self.lights[*light].name),
        };
        in_words(worst) + &others
    }

    /// Certificates of the lights that shine in a passband.
    fn certificates(&self, band: usize, depth: f64) -> Vec<(usize, Certificate)> {
        let shining = |light: usize| self.spectral.bands[band].sources[light].measure.total() > 0.0;
        self.spectral.certify(band, depth).into_iter().enumerate().filter(|(light, _)| shining(*light)).collect()
    }

    /// Whether the pilot rays found a larger error than was asked for.
    pub fn misses_accuracy(&self) -> bool {
        self.space.spatial.is_some_and(|s| s.error > self.spectral.accuracy)
    }

    /// The spatial error in words.
    pub fn spatial_note(&self) -> Option<(String, String)> {
        let s = self.space.spatial?;
        let words = format!(
            "measured {:.1e} (relative rms of the worst band over {} pilot rays, {}, star depths of {} a voxel)",
            s.error, s.rays, s.stepping, self.space.star_factor
        );
        let asked = self.spectral.accuracy;
        let words = if self.misses_accuracy() { format!("{words}: more than the {asked:.1e} that was asked for") } else { words };
        Some(("spatial error".into(), words))
    }

    /// Bytes of all tables and grids.
    pub fn bytes(&self) -> u64 {
        self.space.bytes() + self.spectral.bytes()
    }
}

fn in_words(c: &Certificate) -> String {
    format!("spectral error at most {:.1e} of F(0), {:.1e} of F(a), for depths up to {:.3}", c.absolute, c.relative, c.depth)
}
