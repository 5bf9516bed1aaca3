//! How plans are made: in full, as a preview while things change, and with a given number of samples.

use std::sync::Arc;

use spectra::rule;

use super::draft::{Draft, detail};
use super::{Fineness, LightField, MultipleScattering, Options, Plan, Settings, SpatialPlan, SpectralPlan, Stepping};
use super::{multiple_scattering, pilots};
use crate::control::Control;
use crate::error::Result;
use crate::points::Sources;
use crate::scene::{Method, MethodEntry, Scene, StarDepthSource};

/// The most voxels along an edge of a [preview](Plan::preview).
pub const PREVIEW_VOXELS: usize = 64;
/// The samples along a voxel of a preview.
const PREVIEW_STEPS: f64 = 0.75;
/// The accuracy of a preview: of the angles at which phase functions are asked, and of what ended rays leave behind.
const PREVIEW_ACCURACY: f64 = 0.02;

/// Samples a ray of Barrès & Neyret.
pub const TALK_STEPS: usize = 100;

impl Plan {
    /// Plans `scene`: pilot rays choose steps, star depths and rules, and measure what they cost.
    ///
    /// # Errors
    /// Errors of [`Scene::check`], more memory than is allowed, what the method cannot do, and when the user wishes to
    /// stop.
    pub fn new(scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        Self::updated(None, scene, options, control)
    }

    /// Plans `scene` with the same bits from what another plan has that still holds: densities, depths of stars that
    /// did not move, light that was scattered before.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
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
        let detail = detail(scene, &space, &[]);
        let (lights, space, spectral) = (Arc::new(lights), Arc::new(space), Arc::new(spectral));
        let mut draft = Draft { scene, settings, lights, space, spectral, detail };
        let light_field = draft.light_field(control)?;
        let stepping = match draft.star_march() {
            // Nothing is baked that a step could be wrong about.
            Some(n) => Stepping::Fixed(n),
            None => pilots::choose(&mut draft, light_field.as_ref(), control)?,
        };
        draft.plan(stepping, light_field, before.and_then(|plan| plan.scattered_field.as_deref()), control)
    }

    /// Plans `scene` for a look at once, while things change, from what `before`, another preview, has that still
    /// holds: by the rule [`PREVIEW`](rule::PREVIEW) whatever the scene's method is, at [`PREVIEW_VOXELS`], and nothing
    /// is measured or stated of its error.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
    pub fn preview(before: Option<&Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        scene.check()?;
        let entry = MethodEntry {
            name: rule::PREVIEW.name,
            summary: rule::PREVIEW.summary,
            rule: &rule::PREVIEW,
            star_depth: StarDepthSource::Cached,
        };
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
        let spectral = SpectralPlan::new(scene, &lights, &space, settings, control)?;
        let detail = detail(scene, &space, &[]);
        let draft = Draft { scene, settings, lights: Arc::new(lights), space, spectral: Arc::new(spectral), detail };
        let known = before.and_then(|plan| plan.scattered_field.as_deref());
        let scattered_field = MultipleScattering::new(&draft, Fineness::PREVIEW, known, control)?;
        Ok(Self { sources: Sources::PREVIEW, ..draft.with(Stepping::PerVoxel(PREVIEW_STEPS), None, scattered_field) })
    }

    /// Plans `scene` at `steps` samples a ray, with rules as they are asked for and nothing measured: for comparisons
    /// that measure from outside.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
    pub fn sampled(scene: &Scene, options: &Options, steps: usize, control: &Control) -> Result<Self> {
        scene.check()?;
        let method = Method { steps: Some(steps), ..scene.method.clone() };
        let settings = &Settings { method, ..Settings::of(scene, options) };
        let lights = crate::light::lights(scene)?;
        let space = SpatialPlan::new(scene, settings, control)?;
        space.check_stars(scene)?;
        let spectral = SpectralPlan::new(scene, &lights, &space, settings, control)?;
        let detail = detail(scene, &space, &[]);
        let (lights, space, spectral) = (Arc::new(lights), Arc::new(space), Arc::new(spectral));
        let draft = Draft { scene, settings, lights, space, spectral, detail };
        let light_field = draft.light_field(control)?;
        draft.plan(Stepping::Fixed(steps), light_field, None, control)
    }

    /// The light of `scene` that was scattered before it scatters towards the eye, solved anew as this plan's was; none
    /// where light scatters once and no stars are gathered, or nothing scatters.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
    pub fn scattered_again(&self, scene: &Scene, options: &Options, control: &Control) -> Result<Option<MultipleScattering>> {
        scene.check()?;
        let settings = &Settings::of(scene, options);
        let Self { lights, space, spectral, detail, .. } = self.clone();
        MultipleScattering::new(&Draft { scene, settings, lights, space, spectral, detail }, Fineness::FULL, None, control)
    }
}

impl Draft<'_> {
    /// The light of all stars in one field, where the method marches that; refuses what the rules cannot do.
    pub(super) fn light_field(&self, control: &Control) -> Result<Option<LightField>> {
        multiple_scattering::check(&self.spectral, self.settings)?;
        match self.settings.method.entry.star_depth {
            StarDepthSource::LightField => LightField::new(self, control),
            StarDepthSource::Cached | StarDepthSource::Marched => Ok(None),
        }
    }

    /// Samples of a star depth, where the method marches it again at every sample of a ray.
    fn star_march(&self) -> Option<usize> {
        let method = &self.settings.method;
        (method.entry.star_depth == StarDepthSource::Marched).then(|| method.steps.unwrap_or(TALK_STEPS))
    }

    /// The plan, once light that was scattered before is solved as well, in full.
    pub(super) fn plan(
        mut self,
        stepping: Stepping,
        light_field: Option<LightField>,
        before: Option<&MultipleScattering>,
        control: &Control,
    ) -> Result<Plan> {
        let scattered_field = MultipleScattering::new(&self, Fineness::FULL, before, control)?;
        if light_field.is_some() {
            Arc::make_mut(&mut self.space).forget_star_depths(self.settings, control)?;
        }
        Ok(self.with(stepping, light_field, scattered_field))
    }

    /// The plan with these fields of light.
    fn with(self, stepping: Stepping, light_field: Option<LightField>, scattered_field: Option<MultipleScattering>) -> Plan {
        Plan {
            star_march: self.star_march(),
            detail: self.detail,
            camera: self.scene.camera.clone(),
            lights: self.lights,
            space: self.space,
            spectral: self.spectral,
            stepping,
            light_field: light_field.map(Arc::new),
            scattered_field: scattered_field.map(Arc::new),
            bounces: self.settings.method.bounces,
            sources: Sources::All,
            shining: None,
            parts: self.scene.parts(),
        }
    }
}
