//! Jobs of back ends.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use crate::control::Control;
use crate::error::Result;
use crate::plan::{Options, Plan, Planned, Planner};
use crate::scene::Scene;

/// A render to be done: a scene and its plan, which is made once a back end asks for it where there is none.
#[derive(Debug)]
pub struct Job<'a> {
    scene: Cow<'a, Arc<Scene>>,
    options: &'a Options,
    plan: OnceLock<Cow<'a, Plan>>,
}

impl<'a> Job<'a> {
    /// A scene that is planned when a back end asks for its plan.
    ///
    /// # Errors
    /// Errors of [`Scene::check`].
    pub fn new(scene: impl Into<Arc<Scene>>, options: &'a Options) -> Result<Self> {
        let scene = scene.into();
        scene.check()?;
        Ok(Self { scene: Cow::Owned(scene), options, plan: OnceLock::new() })
    }

    /// The scene to be rendered.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Options of the render.
    pub fn options(&self) -> &'a Options {
        self.options
    }

    /// The plan of the scene, made on the first call.
    ///
    /// # Errors
    /// Errors of [`Planner::plan`].
    pub fn plan(&self, control: &Control) -> Result<&Plan> {
        if let Some(plan) = self.plan.get() {
            return Ok(plan);
        }
        let planned = Planner::new(self.options).plan(self.scene().clone(), None, control)?;
        Ok(self.plan.get_or_init(|| Cow::Owned(planned.plan().clone())))
    }

    /// The job of another camera; a plan that is there is kept.
    pub(super) fn seen_by(&self, camera: crate::camera::Camera, control: &Control) -> Result<Self> {
        let mut plan = self.plan.get().map(|plan| Plan::clone(plan));
        if let Some(plan) = &mut plan {
            plan.look_from(camera.clone(), control)?;
        }
        let scene = Arc::new(Scene::clone(&self.scene).with_camera(camera));
        Ok(Self {
            scene: Cow::Owned(scene),
            options: self.options,
            plan: plan.map_or_else(OnceLock::new, |plan| OnceLock::from(Cow::Owned(plan))),
        })
    }

    /// This job, with `plan` in place of its plan.
    pub(super) fn by_plan(&self, plan: Plan) -> Self {
        Self { scene: self.scene.clone(), options: self.options, plan: OnceLock::from(Cow::Owned(plan)) }
    }
}

impl<'a> From<&'a Planned> for Job<'a> {
    fn from(planned: &'a Planned) -> Self {
        Self { scene: Cow::Borrowed(planned.scene()), options: planned.options(), plan: OnceLock::from(Cow::Borrowed(planned.plan())) }
    }
}
