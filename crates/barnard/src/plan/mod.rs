//! Plans: the numbers a scene comes to, made once in f64. The fast back ends read only this.
//!
//! [`SpatialPlan`] holds what the places of things decide (density, star depths, empty space, step), [`SpectralPlan`]
//! what spectra decide (nodes, weights, phase tables). A changed spectrum keeps the space, a changed camera keeps both.

mod choices;
mod draft;
mod inverse_square;
mod light_field;
pub mod many_lights;
mod multiple_scattering;
pub mod near;
mod options;
mod pilots;
mod planned;
mod planner;
mod probe;
mod report;
pub mod segment;
mod spatial;
mod spectral;
pub mod star_depths;

use std::sync::Arc;

pub use choices::Choices;
pub use light_field::LightField;
pub use many_lights::ManyLights;
pub use multiple_scattering::{FarFieldReport, Fineness, MultipleScattering, ordinates};
pub use options::Options;
pub use planned::Planned;
pub use planner::{PREVIEW_VOXELS, Planner, Quality, TALK_STEPS};
pub use probe::Probe;
pub use report::{HALF, SINGLE};
pub(crate) use spatial::sampled_densities;
pub use spatial::{BrickFields, SpatialPlan, densities, sample_functions};
pub use spectral::closed_form::{ClosedForm, End, Extent};
pub(crate) use spectral::source;
pub use spectral::weights::{Emitter, Scatterer, Weights, weights as weights_of};
pub use spectral::{BandPlan, PHASE_RANGE, PhaseEntry, PhaseTable, RuleTarget, SpectralPlan};

use crate::camera::Camera;
use crate::control::Control;
use crate::detail::FineDetail;
use crate::error::Result;
pub use crate::image::Stepping;
use crate::light::Light;
use crate::points::Sources;
use crate::volume::{Bricks, Volume};

/// Precomputed data of a scene for the fast back ends; copies share all large parts.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The camera that turns pixels into rays.
    pub(crate) camera: Camera,
    /// The lights, in the order of all tables.
    pub(crate) lights: Arc<Vec<Light>>,
    /// Spatial part of the plan.
    pub(crate) space: Arc<SpatialPlan>,
    /// Spectral part of the plan.
    pub(crate) spectral: Arc<SpectralPlan>,
    /// The steps along a ray.
    pub(crate) stepping: Stepping,
    /// Samples of a star depth that is marched again at every sample of a ray instead of being read: Barrès & Neyret's
    /// double integration.
    pub(crate) star_march: Option<usize>,
    /// The light of all stars together, which is marched in place of star depths.
    pub(crate) light_field: Option<Arc<LightField>>,
    /// The field of light that is marched as one: light that was scattered before it scatters towards the eye, where more
    /// than one scattering is asked for, and that of the gathered stars from afar.
    pub(crate) scattered_field: Option<Arc<MultipleScattering>>,
    /// Detail below the voxel size, as seen by the eyes.
    pub(crate) detail: Option<Arc<FineDetail>>,
    /// Times that light of stars may scatter.
    pub(crate) bounces: usize,
    /// The unresolved sources that a picture of it shows.
    pub(crate) sources: Sources,
    /// For each light whether it shines; none where all do.
    pub(crate) shining: Option<Arc<[bool]>>,
}

/// Angle that a camera may turn around the scene before scattered light is seen anew in a preview \[rad\].
const PREVIEW_ANGLE: f64 = 0.04;
/// Samples between looks at whether a ray can end.
pub const END_EVERY: usize = 8;
/// The light that an ended ray may leave behind it, as a part of the accuracy.
pub const END_SHARE: f32 = 0.02;
/// Depth from which on a look is worth its price.
pub const END_DEPTH: f32 = 3.0;

impl Plan {
    /// True if another is the same plan, seen by the same camera. Its parts are shared and do not change, so addresses tell plans
    /// apart that were changed by hand, which no fingerprint of a scene does.
    pub fn is(&self, other: &Self) -> bool {
        fn same<T: ?Sized>(a: &Option<Arc<T>>, b: &Option<Arc<T>>) -> bool {
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
            && same(&self.shining, &other.shining)
            && self.camera == other.camera
            && self.stepping == other.stepping
            && self.star_march == other.star_march
            && self.detail == other.detail
            && self.bounces == other.bounces
    }

    /// The camera that turns pixels into rays.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The lights, in the order of all tables.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Spatial part of the plan.
    pub fn space(&self) -> &Arc<SpatialPlan> {
        &self.space
    }

    /// Spectral part of the plan.
    pub fn spectral(&self) -> &Arc<SpectralPlan> {
        &self.spectral
    }

    /// The steps along a ray.
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

    /// The field of light that is marched as one: light that was scattered before it scatters towards the eye, and that
    /// of the gathered stars from afar.
    pub fn scattered_field(&self) -> Option<&Arc<MultipleScattering>> {
        self.scattered_field.as_ref()
    }

    /// Density detail below the voxel size, as seen by the eyes.
    pub fn detail(&self) -> Option<&Arc<FineDetail>> {
        self.detail.as_ref()
    }

    /// Number of bricks from which detail may displace densities into an empty one.
    pub fn displaced_bricks(&self, bricks: &Bricks) -> usize {
        let edge = bricks.lattice.voxel_pc().min_element();
        self.detail.as_ref().map_or(0, |detail| (detail.reach_pc() / edge).ceil() as usize)
    }

    /// The largest values of the grids, the dust first.
    pub fn largest_densities(&self) -> Vec<f32> {
        self.space.bricks.iter().map(Bricks::largest).collect()
    }

    /// Times that light of stars may scatter.
    pub fn bounces(&self) -> usize {
        self.bounces
    }

    /// True if a light shines.
    pub(crate) fn shines(&self, light: usize) -> bool {
        self.shining.as_ref().is_none_or(|shining| shining[light])
    }

    /// Looks from elsewhere; all that space and spectra decide stays.
    ///
    /// # Errors
    /// Errors of [`Camera::check`], and on interruption by the user; the plan is as before then.
    pub(crate) fn look_from(&mut self, camera: Camera, control: &Control) -> Result<()> {
        camera.check()?;
        if let Some(scattered_field) = &self.scattered_field {
            let angle = if self.sources == Sources::PREVIEW { PREVIEW_ANGLE } else { 0.0 };
            self.scattered_field = Some(scattered_field.seen_by(&camera, angle, control)?);
        }
        self.camera = camera;
        Ok(())
    }

    /// Puts a star elsewhere \[pc\]: its depths alone are swept anew, nothing that spectra decide is touched. The
    /// measured spatial error stays that of the places before, and so does light that was scattered before.
    ///
    /// # Errors
    /// If there is no such star, a light field stands in place of its depths, or on interruption by the user; the plan
    /// is as before then.
    pub(crate) fn move_star(&mut self, star: usize, place: glam::DVec3, control: &Control) -> Result<()> {
        Arc::make_mut(&mut self.space).move_star(star, place, control)
    }

    /// All volumes that the march reads.
    pub fn volumes(&self) -> impl Iterator<Item = &Volume> {
        let fields = self.light_field.iter().flat_map(|f| &f.volumes);
        self.space.volumes.iter().map(|volume| &**volume).chain(fields).chain(self.scattered_field.iter().flat_map(|f| &f.volumes))
    }

    /// The bytes that all tables and grids take.
    pub fn bytes(&self) -> u64 {
        let fields = self.light_field.as_ref().map_or(0, |f| f.bytes()) + self.scattered_field.as_ref().map_or(0, |f| f.bytes());
        self.space.bytes() + self.spectral.bytes() + fields
    }
}
