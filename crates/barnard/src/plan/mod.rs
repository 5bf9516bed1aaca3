//! Plans: the numbers a scene comes to, made once in f64. The fast back ends read only this.
//!
//! [`SpatialPlan`] holds what the places of things decide (density, star depths, empty space, step), [`SpectralPlan`]
//! what spectra decide (nodes, weights, phase tables). A changed spectrum keeps the space, a changed camera keeps both.

mod light_field;
pub mod many_lights;
mod multiple_scattering;
pub mod near;
mod pilots;
mod probe;
mod report;
pub mod segment;
mod spatial;
mod spectral;
pub mod star_depths;

use std::sync::Arc;

pub use light_field::LightField;
pub use many_lights::ManyLights;
pub use multiple_scattering::{ErrorEstimate, FarFieldError, Fineness, MultipleScattering, ordinates};
pub use pilots::{Spatial, Unresolved};
pub use probe::Probe;
pub use report::{HALF, SINGLE};
pub use spatial::{SpatialPlan, sample_functions};
pub use spectral::closed_form::{ClosedForm, End, Extent};
pub use spectral::weights::{Emitter, Scatterer, Weights, weights as weights_of};
pub use spectral::{BandPlan, PHASE_RANGE, PhaseTable, SpectralPlan};

use spectra::rule;

use crate::camera::Camera;
use crate::control::Control;
use crate::error::Result;
use crate::light::Light;
use crate::memory;
use crate::scene::{Method, MethodEntry, Scene, StarDepth};
use crate::volume::Volume;

/// What a program may decide beside the scene.
#[derive(Debug, Clone)]
pub struct Options {
    /// Most bytes a plan may take.
    pub memory_limit: u64,
    /// What sweeps light that is scattered more than once; the processor where it is not said.
    pub sweeper: Option<Arc<dyn ordinates::Sweeper>>,
}

impl Default for Options {
    /// On the processor alone.
    fn default() -> Self {
        Self { memory_limit: memory::DEFAULT_LIMIT, sweeper: None }
    }
}

impl Options {
    /// On the processor alone, with so much memory \[bytes\].
    pub fn within(memory_limit: u64) -> Self {
        Self { memory_limit, ..Self::default() }
    }
}

/// What a plan is made by: the method that is in force, which need not be the scene's while a rule is made finer, and
/// what it may take.
#[derive(Debug, Clone)]
pub(crate) struct Settings {
    /// Spectral rule and accuracy.
    pub method: Method,
    /// Most bytes a plan may take.
    pub memory_limit: u64,
    /// What sweeps light that is scattered more than once.
    pub sweeper: Option<Arc<dyn ordinates::Sweeper>>,
}

impl Settings {
    /// The scene's own method.
    pub fn of(scene: &Scene, options: &Options) -> Self {
        Self { method: scene.method.clone(), memory_limit: options.memory_limit, sweeper: options.sweeper.clone() }
    }
}

/// Everything a fast back end needs; a copy shares all that is large.
#[derive(Debug, Clone)]
pub struct Plan {
    /// From pixels to rays.
    pub(crate) camera: Camera,
    /// The lights, in the order of all tables.
    pub(crate) lights: Arc<Vec<Light>>,
    /// What places decide.
    pub(crate) space: Arc<SpatialPlan>,
    /// What spectra decide.
    pub(crate) spectral: Arc<SpectralPlan>,
    /// Steps along a ray.
    pub(crate) stepping: Stepping,
    /// Samples of a star depth that is marched again at every sample of a ray instead of being read: Barrès & Neyret's
    /// double integration.
    pub(crate) star_march: Option<usize>,
    /// The light of all stars together, which is marched in place of star depths.
    pub(crate) light_field: Option<Arc<LightField>>,
    /// Light that was scattered before it scatters towards the eye, where more than one scattering is asked for.
    pub(crate) scattered_field: Option<Arc<MultipleScattering>>,
    /// Times that light of stars may scatter.
    pub(crate) bounces: usize,
}

/// Samples between looks at whether a ray can end.
pub const END_EVERY: usize = 8;
/// What lies behind an ended ray, as a part of the accuracy.
pub const END_SHARE: f32 = 0.02;
/// Depth from which on a look is worth its price.
pub const END_DEPTH: f32 = 3.0;

/// Most voxels along an edge of a [preview](Plan::preview), and its samples along one.
pub const PREVIEW_VOXELS: usize = 64;
const PREVIEW_STEPS: f64 = 0.75;
/// At which it looks where a phase function must be asked, and where rays may end.
const PREVIEW_ACCURACY: f64 = 0.02;

/// Samples a ray of Barrès & Neyret.
pub const TALK_STEPS: usize = 100;

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
    space: SpatialPlan,
    spectral: SpectralPlan,
    light_field: Option<LightField>,
    star_march: Option<usize>,
}

impl Draft {
    fn new(
        scene: &Scene,
        lights: Vec<Light>,
        space: SpatialPlan,
        spectral: SpectralPlan,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self> {
        multiple_scattering::check(&spectral, settings)?;
        let star_depth = settings.method.entry.star_depth;
        let light_field = match star_depth {
            StarDepth::LightField => LightField::new(scene, &lights, &spectral, &space, settings, control)?,
            StarDepth::Cached | StarDepth::Marched => None,
        };
        let star_march = (star_depth == StarDepth::Marched).then(|| settings.method.steps.unwrap_or(TALK_STEPS));
        Ok(Self { lights, space, spectral, light_field, star_march })
    }

    fn plan(
        mut self,
        scene: &Scene,
        stepping: Stepping,
        settings: &Settings,
        before: Option<&MultipleScattering>,
        control: &Control,
    ) -> Result<Plan> {
        let fineness = (settings, Fineness::FULL);
        let scattered_field = MultipleScattering::new(scene, &self.lights, &self.spectral, &self.space, fineness, before, control)?;
        if self.light_field.is_some() {
            self.space.forget_star_depths(settings, control)?;
        }
        Ok(Plan {
            camera: scene.camera.clone(),
            lights: Arc::new(self.lights),
            space: Arc::new(self.space),
            spectral: Arc::new(self.spectral),
            stepping,
            star_march: self.star_march,
            light_field: self.light_field.map(Arc::new),
            scattered_field: scattered_field.map(Arc::new),
            bounces: settings.method.bounces,
        })
    }
}

impl Plan {
    /// Plans `scene`: pilot rays choose steps, star depths and rules, and measure what they cost.
    ///
    /// # Errors
    /// Those of [`Scene::check`], more memory than is allowed, what the method cannot do, and when the user wishes to
    /// stop.
    pub fn new(scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        Self::updated(None, scene, options, control)
    }

    /// The same, bit by bit, from what another plan has that still holds: densities, depths of stars that did not move,
    /// light that was scattered before.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn updated(before: Option<&Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        scene.check()?;
        let settings = &Settings::of(scene, options);
        let lights = crate::light::lights(scene)?;
        // A light field stands in place of star depths, which are gone.
        let known = before.filter(|plan| plan.light_field.is_none());
        let space = match known.map(|plan| plan.space.rebuilt(scene, settings, control)).transpose()?.flatten() {
            Some(space) => space,
            None => SpatialPlan::new(scene, settings, control)?,
        };
        space.check_stars(scene)?;
        let spectral = pilots::spectral(scene, &lights, &space, settings, control)?;
        spectral.check_strength(&lights)?;
        let mut draft = Draft::new(scene, lights, space, spectral, settings, control)?;
        let stepping = match draft.star_march {
            // Nothing is baked that a step could be wrong about.
            Some(n) => Stepping::Fixed(n),
            None => {
                let Draft { lights, space, spectral, light_field, .. } = &mut draft;
                pilots::choose(scene, lights, spectral, space, light_field.as_ref(), settings, control)?
            }
        };
        draft.plan(scene, stepping, settings, before.and_then(|plan| plan.scattered_field.as_deref()), control)
    }

    /// Plans `scene` for a look at once, while things change, from what `before`, another preview, has that still
    /// holds: by the rule [`PREVIEW`](rule::PREVIEW) whatever the scene's method is, at [`PREVIEW_VOXELS`], and nothing
    /// is measured or stated of its error.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn preview(before: Option<&Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        scene.check()?;
        let entry =
            MethodEntry { name: rule::PREVIEW.name, summary: rule::PREVIEW.summary, rule: &rule::PREVIEW, star_depth: StarDepth::Cached };
        let kept = &scene.method;
        let method = Method {
            entry,
            accuracy: PREVIEW_ACCURACY,
            bake: kept.bake,
            bounces: kept.bounces,
            exact_stars: kept.exact_stars,
            ..Method::default()
        };
        let settings = &Settings { method, ..Settings::of(scene, options) };
        let space = match before.map(|plan| plan.space.updated(scene, settings, control)).transpose()?.flatten() {
            Some(space) => space,
            None => Arc::new(SpatialPlan::coarse(scene, settings, PREVIEW_VOXELS, control)?),
        };
        let lights = crate::light::lights(scene)?;
        let spectral = SpectralPlan::new(scene, &lights, space.many_lights.as_deref(), settings, space.reach(&scene.camera), control)?;
        let known = before.and_then(|plan| plan.scattered_field.as_deref());
        let scattered_field = MultipleScattering::new(scene, &lights, &spectral, &space, (settings, Fineness::PREVIEW), known, control)?;
        Ok(Self {
            camera: scene.camera.clone(),
            lights: Arc::new(lights),
            space,
            spectral: Arc::new(spectral),
            stepping: Stepping::PerVoxel(PREVIEW_STEPS),
            star_march: None,
            light_field: None,
            scattered_field: scattered_field.map(Arc::new),
            bounces: settings.method.bounces,
        })
    }

    /// The light of `scene` that was scattered before it scatters towards the eye, solved anew as this plan's was; none
    /// where light scatters once, or nothing scatters.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn scattered_again(&self, scene: &Scene, options: &Options, control: &Control) -> Result<Option<MultipleScattering>> {
        let settings = &Settings::of(scene, options);
        MultipleScattering::new(scene, &self.lights, &self.spectral, &self.space, (settings, Fineness::FULL), None, control)
    }

    /// Whether another is the same plan, seen by the same camera: whatever is large is shared, not equal.
    pub fn is(&self, other: &Self) -> bool {
        fn same<T>(a: &Option<Arc<T>>, b: &Option<Arc<T>>) -> bool {
            match (a, b) {
                (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                (None, None) => true,
                _ => false,
            }
        }
        Arc::ptr_eq(&self.space, &other.space)
            && Arc::ptr_eq(&self.spectral, &other.spectral)
            && Arc::ptr_eq(&self.lights, &other.lights)
            && same(&self.light_field, &other.light_field)
            && same(&self.scattered_field, &other.scattered_field)
            && self.camera == other.camera
            && self.stepping == other.stepping
            && self.star_march == other.star_march
            && self.bounces == other.bounces
    }

    /// From pixels to rays.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The lights, in the order of all tables.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// What places decide.
    pub fn space(&self) -> &Arc<SpatialPlan> {
        &self.space
    }

    /// What spectra decide.
    pub fn spectral(&self) -> &Arc<SpectralPlan> {
        &self.spectral
    }

    /// Steps along a ray.
    pub fn stepping(&self) -> Stepping {
        self.stepping
    }

    /// Samples of a star depth that is marched again at every sample of a ray instead of being read.
    pub fn star_march(&self) -> Option<usize> {
        self.star_march
    }

    /// The light of all stars together, which is marched in place of star depths.
    pub fn light_field(&self) -> Option<&Arc<LightField>> {
        self.light_field.as_ref()
    }

    /// Light that was scattered before it scatters towards the eye.
    pub fn scattered_field(&self) -> Option<&Arc<MultipleScattering>> {
        self.scattered_field.as_ref()
    }

    /// Times that light of stars may scatter.
    pub fn bounces(&self) -> usize {
        self.bounces
    }

    /// The same with other steps along a ray; what pilots measured is of those before.
    #[must_use]
    pub fn with_stepping(self, stepping: Stepping) -> Self {
        Self { stepping, ..self }
    }

    /// The same with an image of so many pixels, from the same place.
    #[must_use]
    pub fn with_size(self, width: usize, height: usize) -> Self {
        Self { camera: self.camera.size(width, height), ..self }
    }

    /// The same with so many rays along each side of a pixel.
    #[must_use]
    pub fn with_supersampling(self, rays: usize) -> Self {
        Self { camera: self.camera.supersampling(rays), ..self }
    }

    /// The same without what is marched as a field beside starlight that scatters once: light of more scatterings, and
    /// that of many stars together from afar.
    #[must_use]
    pub fn without_scattered_field(self) -> Self {
        Self { scattered_field: None, ..self }
    }

    /// The same without what many stars send to the dust near them, which is marched star by star.
    #[must_use]
    pub fn without_near_field(mut self) -> Self {
        if let Some(scattered_field) = &mut self.scattered_field {
            Arc::make_mut(scattered_field).report.gathered = None;
        }
        self
    }

    /// The same with the depths and densities of another plan.
    #[must_use]
    pub fn with_space(self, space: Arc<SpatialPlan>) -> Self {
        Self { space, ..self }
    }

    /// Looks from elsewhere; all that space and spectra decide stays.
    ///
    /// # Errors
    /// When the user wishes to stop; the plan is as before then.
    pub fn look_from(&mut self, camera: Camera, control: &Control) -> Result<()> {
        if let Some(scattered_field) = &self.scattered_field {
            self.scattered_field = Some(scattered_field.seen_by(&camera, control)?);
        }
        self.camera = camera;
        Ok(())
    }

    /// Plans `scene` at `steps` samples a ray, with rules as they are asked for and nothing measured: for comparisons
    /// that measure from outside.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn sampled(scene: &Scene, options: &Options, steps: usize, control: &Control) -> Result<Self> {
        scene.check()?;
        let method = Method { steps: Some(steps), ..scene.method.clone() };
        let settings = &Settings { method, ..Settings::of(scene, options) };
        let lights = crate::light::lights(scene)?;
        let space = SpatialPlan::new(scene, settings, control)?;
        space.check_stars(scene)?;
        let spectral = SpectralPlan::new(scene, &lights, space.many_lights.as_deref(), settings, space.reach(&scene.camera), control)?;
        Draft::new(scene, lights, space, spectral, settings, control)?.plan(scene, Stepping::Fixed(steps), settings, None, control)
    }

    /// Puts a star elsewhere \[pc\]: its depths alone are swept anew, nothing that spectra decide is touched. The
    /// measured spatial error stays that of the places before, and so does light that was scattered before.
    ///
    /// # Errors
    /// Where there is no such star, a light field stands in place of its depths, or the user wishes to stop; the plan
    /// is as before then.
    pub fn move_star(&mut self, star: usize, place: glam::DVec3, control: &Control) -> Result<()> {
        Arc::make_mut(&mut self.space).move_star(star, place, control)
    }

    /// Everything the march reads.
    pub fn volumes(&self) -> impl Iterator<Item = &Volume> {
        let fields = self.light_field.iter().flat_map(|f| &f.volumes);
        self.space.volumes.iter().chain(fields).chain(self.scattered_field.iter().flat_map(|d| &d.volumes))
    }

    /// Bytes of all tables and grids.
    pub fn bytes(&self) -> u64 {
        let fields = self.light_field.as_ref().map_or(0, |f| f.bytes()) + self.scattered_field.as_ref().map_or(0, |d| d.bytes());
        self.space.bytes() + self.spectral.bytes() + fields
    }
}
