//! Plans: the numbers a scene comes to, made once in f64. The fast back ends read only this.
//!
//! [`Space`] holds what the places of things decide (density, star depths, empty space, step), [`Spectral`] what spectra decide (nodes, weights,
//! phase tables). A changed spectrum keeps the space, a changed camera keeps both.

mod bake;
mod bricks;
mod closed_form;
pub mod cone;
pub mod crowd;
mod describe;
mod diffuse;
mod light_field;
pub mod near;
mod pilot;
mod planes;
mod probe;
pub mod pyramid;
mod report;
mod sampled_pixels;
pub mod segment;
mod space;
mod spectral;
pub mod star_depth;
mod unresolved;
mod volume;
mod walk;
mod weights;
pub mod window;

use std::sync::Arc;

pub use bake::sample_functions;
pub use bricks::Bricks;
pub use closed_form::{ClosedForm, End, Extent};
pub use crowd::Crowd;
pub use describe::describe;
pub use diffuse::{Diffuse, Doubt, Fineness, Gathered, ordinates};
pub use light_field::LightField;
pub use pilot::Spatial;
pub use probe::Probe;
pub use report::{HALF, SINGLE};
pub use space::Space;
pub use spectral::{BandPlan, PHASE_RANGE, PhaseTable, Spectral};
pub use unresolved::Unresolved;
pub use volume::{Channel, MAX_CHANNELS, Volume};
pub use weights::{Emitter, Scatterer, Weights, weights as weights_of};

use spectra::rule;

use crate::camera::Camera;
use crate::control::Control;
use crate::error::Result;
use crate::light::Light;
use crate::scene::{Method, MethodEntry, Scene, StarDepth};

/// What a user may decide beside the scene.
#[derive(Debug, Clone)]
pub struct Options {
    /// Spectral rule and accuracy.
    pub method: Method,
    /// Most bytes a plan may take.
    pub memory_limit: u64,
    /// What sweeps light that is scattered more than once; the processor where it is not said.
    pub sweeper: Option<Arc<dyn ordinates::Sweeper>>,
}

impl Options {
    /// On the processor alone.
    pub fn new(method: Method, memory_limit: u64) -> Self {
        Self { method, memory_limit, sweeper: None }
    }
}

/// Everything a fast back end needs; a copy shares all that is large.
#[derive(Debug, Clone)]
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
    /// The light of all stars together, which is marched in place of star depths.
    pub light_field: Option<Arc<LightField>>,
    /// Light that was scattered before it scatters towards the eye, where more than one scattering is asked for.
    pub diffuse: Option<Arc<Diffuse>>,
    /// Times that light of stars may scatter.
    pub bounces: usize,
}

/// Samples between looks at whether a ray can end.
pub const END_EVERY: usize = 8;
/// What lies behind an ended ray, as a part of the accuracy.
pub const END_SHARE: f32 = 0.02;
/// Depth from which on a look is worth its price.
pub const END_DEPTH: f32 = 3.0;

/// Most voxels along an edge of a [glance](Plan::glance), and its samples along one.
pub const GLANCE_VOXELS: usize = 64;
const GLANCE_STEPS: f64 = 0.75;
/// At which it looks where a phase function must be asked, and where rays may end.
const GLANCE_ACCURACY: f64 = 0.02;

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

/// A plan before its steps are known.
struct Draft {
    lights: Vec<Light>,
    space: Space,
    spectral: Spectral,
    light_field: Option<LightField>,
    star_march: Option<usize>,
}

impl Draft {
    fn new(scene: &Scene, lights: Vec<Light>, space: Space, spectral: Spectral, options: &Options, control: &Control) -> Result<Self> {
        diffuse::check(&spectral, options)?;
        let star_depth = options.method.entry.star_depth;
        let light_field = match star_depth {
            StarDepth::Gathered => LightField::new(scene, &lights, &spectral, &space, options, control)?,
            StarDepth::Cached | StarDepth::Marched => None,
        };
        let star_march = (star_depth == StarDepth::Marched).then(|| options.method.steps.unwrap_or(DECK_STEPS));
        Ok(Self { lights, space, spectral, light_field, star_march })
    }

    fn plan(mut self, scene: &Scene, stepping: Stepping, options: &Options, before: Option<&Diffuse>, control: &Control) -> Result<Plan> {
        let fineness = (options, Fineness::FULL);
        let diffuse = Diffuse::new(scene, &self.lights, &self.spectral, &self.space, fineness, before, control)?;
        if self.light_field.is_some() {
            self.space.forget_star_depths(options, control)?;
        }
        Ok(Plan {
            camera: scene.camera.clone(),
            lights: Arc::new(self.lights),
            space: Arc::new(self.space),
            spectral: Arc::new(self.spectral),
            stepping,
            star_march: self.star_march,
            light_field: self.light_field.map(Arc::new),
            diffuse: diffuse.map(Arc::new),
            bounces: options.method.bounces,
        })
    }
}

impl Plan {
    /// Plans `scene`: pilot rays choose steps, star depths and rules, and measure what they cost.
    pub fn new(scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        Self::renewed(None, scene, options, control)
    }

    /// The same, bit by bit, from what another plan has that still holds: densities, depths of stars that did not move, light that was scattered before.
    pub fn renewed(before: Option<&Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        let lights = crate::light::lights(scene)?;
        // A light field stands in place of star depths, which are gone.
        let known = before.filter(|plan| plan.light_field.is_none());
        let space = match known.map(|plan| plan.space.again(scene, options, control)).transpose()?.flatten() {
            Some(space) => space,
            None => Space::new(scene, options, control)?,
        };
        space.check_stars(scene)?;
        let spectral = pilot::spectral(scene, &lights, &space, options, control)?;
        spectral.check_strength(&lights)?;
        let mut draft = Draft::new(scene, lights, space, spectral, options, control)?;
        let stepping = match draft.star_march {
            // Nothing is baked that a step could be wrong about.
            Some(n) => Stepping::Fixed(n),
            None => {
                let Draft { lights, space, spectral, light_field, .. } = &mut draft;
                pilot::choose(scene, lights, spectral, space, light_field.as_ref(), options, control)?
            }
        };
        draft.plan(scene, stepping, options, before.and_then(|plan| plan.diffuse.as_deref()), control)
    }

    /// Plans `scene` for a look at once, while things change, from what `before`, another glance, has that still holds: by the rule
    /// [`GLANCE`](rule::GLANCE) whatever the scene's method is, at [`GLANCE_VOXELS`], and nothing is measured or stated of its error.
    pub fn glance(before: Option<&Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        let entry =
            MethodEntry { name: rule::GLANCE.name, summary: rule::GLANCE.summary, rule: &rule::GLANCE, star_depth: StarDepth::Cached };
        let kept = &options.method;
        let method = Method {
            entry,
            accuracy: GLANCE_ACCURACY,
            bake: kept.bake,
            bounces: kept.bounces,
            exact_stars: kept.exact_stars,
            ..Method::default()
        };
        let options = &Options { method, ..options.clone() };
        let space = match before.map(|plan| plan.space.follow(scene, options, control)).transpose()?.flatten() {
            Some(space) => space,
            None => Arc::new(Space::coarse(scene, options, GLANCE_VOXELS, control)?),
        };
        let lights = crate::light::lights(scene)?;
        let spectral = Spectral::new(scene, &lights, space.crowd.as_deref(), options, space.reach(&scene.camera), control)?;
        let known = before.and_then(|plan| plan.diffuse.as_deref());
        let diffuse = Diffuse::new(scene, &lights, &spectral, &space, (options, Fineness::GLANCE), known, control)?;
        Ok(Self {
            camera: scene.camera.clone(),
            lights: Arc::new(lights),
            space,
            spectral: Arc::new(spectral),
            stepping: Stepping::PerVoxel(GLANCE_STEPS),
            star_march: None,
            light_field: None,
            diffuse: diffuse.map(Arc::new),
            bounces: options.method.bounces,
        })
    }

    /// Looks from elsewhere; all that space and spectra decide stays.
    ///
    /// # Errors
    /// When the user wishes to stop; the plan is as before then.
    pub fn look_from(&mut self, camera: Camera, control: &Control) -> Result<()> {
        if let Some(diffuse) = &self.diffuse {
            self.diffuse = Some(diffuse.seen_by(&camera, control)?);
        }
        self.camera = camera;
        Ok(())
    }

    /// Plans `scene` at `steps` samples a ray, with rules as they are asked for and nothing measured: for comparisons that measure from outside.
    pub fn sampled(scene: &Scene, options: &Options, steps: usize, control: &Control) -> Result<Self> {
        let method = Method { steps: Some(steps), ..options.method.clone() };
        let options = &Options { method, ..options.clone() };
        let lights = crate::light::lights(scene)?;
        let space = Space::new(scene, options, control)?;
        space.check_stars(scene)?;
        let spectral = Spectral::new(scene, &lights, space.crowd.as_deref(), options, space.reach(&scene.camera), control)?;
        Draft::new(scene, lights, space, spectral, options, control)?.plan(scene, Stepping::Fixed(steps), options, None, control)
    }

    /// Puts a star elsewhere [pc]: its depths alone are swept anew, nothing that spectra decide is touched. The measured spatial error stays that of the
    /// places before, and so does light that was scattered before.
    ///
    /// # Errors
    /// Where there is no such star, a light field stands in place of its depths, or the user wishes to stop; the plan is as before then.
    pub fn move_star(&mut self, star: usize, place: glam::DVec3, control: &Control) -> Result<()> {
        Arc::make_mut(&mut self.space).move_star(star, place, control)
    }

    /// Everything the march reads.
    pub fn volumes(&self) -> impl Iterator<Item = &Volume> {
        let fields = self.light_field.iter().flat_map(|f| &f.volumes);
        self.space.volumes.iter().chain(fields).chain(self.diffuse.iter().flat_map(|d| &d.volumes))
    }

    /// Bytes of all tables and grids.
    pub fn bytes(&self) -> u64 {
        let fields = self.light_field.as_ref().map_or(0, |f| f.bytes()) + self.diffuse.as_ref().map_or(0, |d| d.bytes());
        self.space.bytes() + self.spectral.bytes() + fields
    }
}
