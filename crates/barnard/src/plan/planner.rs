//! How plans are made: in full, as a preview while things change, with a given number of samples, or by earlier choices.

use std::sync::Arc;

use spectra::rule;

use super::draft::{Draft, detail};
use super::multiple_scattering::{self, Effort, Fineness, MultipleScattering};
use super::{Choices, LightField, Options, Plan, Planned, SpatialPlan, SpectralPlan, Stepping, pilots};
use crate::control::Control;
use crate::error::Result;
use crate::light::lights;
use crate::points::Sources;
use crate::scene::{Method, MethodEntry, Scene, StarDepthSource};

/// Samples of a ray of Barrès & Neyret.
pub const TALK_STEPS: usize = 100;

/// The most voxels along an edge of a [preview](Quality::Preview).
pub const PREVIEW_VOXELS: usize = 64;
/// The samples along a voxel of a preview.
const PREVIEW_STEPS: f64 = 0.75;
/// The accuracy of a preview: of the angles at which phase functions are asked, and of what ended rays leave behind.
const PREVIEW_ACCURACY: f64 = 0.02;

/// Effort of a plan: which steps, star depths and rules it has, and whether their errors are measured.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub enum Quality {
    /// Pilot rays choose steps, star depths and rules, and measure their errors.
    #[default]
    Full,
    /// Choices of full quality, but multiple scattering in coarse cells alone, whose error is stated: for reports before a picture.
    Estimate,
    /// The rule [`PREVIEW`](rule::PREVIEW) for any method, on at most [`PREVIEW_VOXELS`]; errors are unknown. For pictures while
    /// things change.
    Preview,
    /// A number of samples for each ray, with the rules of the scene's method; errors are unknown. For comparisons that measure from
    /// outside.
    Fixed(usize),
    /// Choices of earlier plans, with the errors that those state.
    Chosen(Box<Choices>),
}

/// Maker of [plans](Planned).
///
/// # Examples
/// ```
/// use barnard::plan::{Planner, Quality};
/// use barnard::prelude::*;
///
/// let scene = SceneSpec::new(Camera::look_at(dvec3(0.0, 0.0, 5.0), DVec3::ZERO).with_size(8, 8)).with_bands(passband::set("johnson")?).build()?;
/// let (options, control) = (Options::default(), Control::default());
/// let preview = Planner::new(&options).with_quality(Quality::Preview).plan(&scene, None, &control)?;
/// assert_eq!(preview.scene().camera.width, 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Planner<'a> {
    options: &'a Options,
    quality: Quality,
}

impl<'a> Planner<'a> {
    /// A planner of [full](Quality::Full) quality.
    pub fn new(options: &'a Options) -> Self {
        Self { options, quality: Quality::Full }
    }

    /// Copy of the planner with another quality.
    #[must_use]
    pub fn with_quality(self, quality: Quality) -> Self {
        Self { quality, ..self }
    }

    /// Plans `scene`. Parts of `before`, a plan of the same quality, that are still valid are reused; the result has the same bits
    /// as without.
    ///
    /// # Errors
    /// Errors of [`Scene::check`], [`Error::Memory`](crate::Error::Memory), unsupported features of the scene's method, and
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn plan(&self, scene: impl Into<Arc<Scene>>, before: Option<&Planned>, control: &Control) -> Result<Planned> {
        let scene = scene.into();
        scene.check()?;
        let before = before.map(Planned::plan);
        let plan = match &self.quality {
            Quality::Full | Quality::Estimate => self.full(&scene, before, control),
            Quality::Preview => self.preview(&scene, before, control),
            Quality::Fixed(steps) => self.fixed(&scene, *steps, control),
            Quality::Chosen(choices) => self.chosen(&scene, choices, before, control),
        }?;
        Ok(Planned::new(scene, plan, self.options.clone()))
    }

    fn full(&self, scene: &Scene, before: Option<&Plan>, control: &Control) -> Result<Plan> {
        let options = self.options;
        let lights = lights(scene)?;
        // A light field stands in place of star depths, which are gone.
        let known = before.filter(|plan| plan.light_field.is_none());
        let space = match known.map(|plan| plan.space.rebuilt(scene, options, control)).transpose()?.flatten() {
            Some(space) => space,
            None => SpatialPlan::new(scene, options, control)?,
        };
        space.check_stars(scene)?;
        let spectral = pilots::spectral(scene, &lights, &space, control)?;
        spectral.check_strength(&lights)?;
        let detail = detail(scene, &space);
        let (lights, space, spectral) = (Arc::new(lights), Arc::new(space), Arc::new(spectral));
        let mut draft = Draft { scene, options, lights, space, spectral, detail };
        let light_field = draft.light_field(control)?;
        let (stepping, seen) = match draft.star_march() {
            // Nothing is baked that a step could be wrong about.
            Some(n) => (Stepping::Fixed(n), None),
            None => {
                let (stepping, seen) = pilots::choose(&mut draft, light_field.as_ref(), control)?;
                (stepping, Some(seen))
            }
        };
        let effort = match &seen {
            None => Effort::Chosen(Fineness::UNMEASURED),
            Some(seen) if self.quality == Quality::Estimate => Effort::Estimated(seen),
            Some(seen) => Effort::Measured(seen),
        };
        draft.plan((stepping, effort), light_field, before.and_then(|plan| plan.scattered_field.as_deref()), control)
    }

    fn preview(&self, scene: &Scene, before: Option<&Plan>, control: &Control) -> Result<Plan> {
        let options = self.options;
        let entry = MethodEntry {
            name: rule::PREVIEW.name,
            summary: rule::PREVIEW.summary,
            rule: &rule::PREVIEW,
            star_depth: StarDepthSource::Cached,
        };
        let Method { bake, bounces, exact_stars, .. } = scene.method;
        let scene =
            &scene.clone().with_method(Method { entry, accuracy: PREVIEW_ACCURACY, bake, bounces, exact_stars, ..Method::default() });
        let space = match before.map(|plan| plan.space.updated(scene, options, control)).transpose()?.flatten() {
            Some(space) => space,
            None => Arc::new(SpatialPlan::coarse(scene, options, PREVIEW_VOXELS, control)?),
        };
        let lights = lights(scene)?;
        let spectral = SpectralPlan::new(scene, &lights, &space, control)?;
        let detail = detail(scene, &space);
        let draft = Draft { scene, options, lights: Arc::new(lights), space, spectral: Arc::new(spectral), detail };
        let known = before.and_then(|plan| plan.scattered_field.as_deref());
        let scattered_field = MultipleScattering::new(&draft, Effort::Preview, known, control)?;
        Ok(Plan { sources: Sources::PREVIEW, ..draft.with(Stepping::PerVoxel(PREVIEW_STEPS), None, scattered_field) })
    }

    fn fixed(&self, scene: &Scene, steps: usize, control: &Control) -> Result<Plan> {
        let options = self.options;
        let scene = &scene.clone().with_method(Method { steps: Some(steps), ..scene.method.clone() });
        let lights = lights(scene)?;
        let space = SpatialPlan::new(scene, options, control)?;
        space.check_stars(scene)?;
        let spectral = SpectralPlan::new(scene, &lights, &space, control)?;
        let detail = detail(scene, &space);
        let (lights, space, spectral) = (Arc::new(lights), Arc::new(space), Arc::new(spectral));
        let draft = Draft { scene, options, lights, space, spectral, detail };
        let light_field = draft.light_field(control)?;
        draft.plan((Stepping::Fixed(steps), Effort::Chosen(Fineness::UNMEASURED)), light_field, None, control)
    }

    /// Plans by choices that are made already.
    fn chosen(&self, scene: &Scene, choices: &Choices, before: Option<&Plan>, control: &Control) -> Result<Plan> {
        let options = self.options;
        let lights = lights(scene)?;
        // A light field stands in place of star depths, which are gone; dust that became more by a ratio is rounded otherwise
        // than dust that was sampled so.
        let known = before.filter(|plan| plan.light_field.is_none() && plan.space.has_as_much_dust_as(scene));
        let reused = known.map(|plan| plan.space.updated(scene, options, control)).transpose()?.flatten();
        let reused_detail = before.filter(|_| reused.is_some()).and_then(|plan| plan.detail.clone());
        let mut space = reused.map_or_else(|| SpatialPlan::new(scene, options, control).map(Arc::new), Ok)?;
        let detail = reused_detail.filter(|reused| Some(&reused.settings) == scene.detail.as_ref()).or_else(|| detail(scene, &space));
        if let Some(edge) = choices.sampled_edge.filter(|edge| space.sampled_edge().is_some_and(|coarser| coarser < *edge))
            && let Some(finer) = space.resampled(scene, edge, options, control)?
        {
            space = Arc::new(finer);
        }
        if space.star_factor != choices.star_factor {
            Arc::make_mut(&mut space).refine_stars(choices.star_factor, scene, options, control)?;
        }
        if space.spatial != choices.spatial {
            Arc::make_mut(&mut space).spatial = choices.spatial;
        }
        space.check_stars(scene)?;
        let spectral = SpectralPlan::with_rules(scene, &lights, &space, choices.rules, control)?;
        spectral.check_strength(&lights)?;
        let draft = Draft { scene, options, lights: Arc::new(lights), space, spectral: Arc::new(spectral), detail };
        let light_field = draft.light_field(control)?;
        let effort = Effort::Chosen(choices.scattered_fineness.unwrap_or(Fineness::UNMEASURED));
        let mut plan =
            draft.plan((choices.stepping, effort), light_field, before.and_then(|plan| plan.scattered_field.as_deref()), control)?;
        if let Some(field) = &mut plan.scattered_field {
            // What was measured of one camera's picture is not said of another's.
            let report = &mut Arc::make_mut(field).report;
            report.error_estimate = choices.scattered.0;
            if let Some(far_field) = &mut report.far_field {
                far_field.error = choices.scattered.1;
            }
        }
        Ok(plan)
    }
}

impl Draft<'_> {
    /// The light of all stars in one field, where the method marches that; refuses what the rules cannot do.
    fn light_field(&self, control: &Control) -> Result<Option<LightField>> {
        multiple_scattering::check(&self.spectral, &self.scene.method)?;
        match self.scene.method.entry.star_depth {
            StarDepthSource::LightField => LightField::new(self, control),
            StarDepthSource::Cached | StarDepthSource::Marched => Ok(None),
        }
    }

    /// Samples of a star depth, where the method marches it again at every sample of a ray.
    fn star_march(&self) -> Option<usize> {
        let method = &self.scene.method;
        (method.entry.star_depth == StarDepthSource::Marched).then(|| method.steps.unwrap_or(TALK_STEPS))
    }

    /// The plan, once multiple scattering is solved as well, with this effort.
    fn plan(
        mut self,
        (stepping, effort): (Stepping, Effort),
        light_field: Option<LightField>,
        before: Option<&MultipleScattering>,
        control: &Control,
    ) -> Result<Plan> {
        let scattered_field = MultipleScattering::new(&self, effort, before, control)?;
        if light_field.is_some() {
            Arc::make_mut(&mut self.space).forget_star_depths(self.scene, self.options, control)?;
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
            bounces: self.scene.method.bounces,
            sources: Sources::All,
            shining: None,
        }
    }
}

impl Planned {
    /// Multiple scattering of the scene, solved again as this plan's was; none where light scatters once and no stars are aggregated,
    /// or nothing scatters.
    ///
    /// # Errors
    /// Errors of [`Planner::plan`].
    pub fn scattered_again(&self, options: &Options, control: &Control) -> Result<Option<MultipleScattering>> {
        let Plan { lights, space, spectral, detail, scattered_field, .. } = self.plan().clone();
        let effort = Effort::Chosen(scattered_field.map_or(Fineness::UNMEASURED, |field| field.fineness()));
        MultipleScattering::new(&Draft { scene: self.scene(), options, lights, space, spectral, detail }, effort, None, control)
    }
}
