//! Jobs of back ends.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use crate::control::Control;
use crate::error::Result;
use crate::plan::{Options, Planned, Planner};
use crate::scene::Scene;

/// A render to be done: a scene and its plan, which is made once a back end asks for it where there is none.
#[derive(Debug)]
pub struct Job<'a> {
    scene: Cow<'a, Arc<Scene>>,
    options: &'a Options,
    planned: OnceLock<Cow<'a, Planned>>,
}

impl<'a> Job<'a> {
    /// A scene that is planned when a back end asks for its plan.
    ///
    /// # Errors
    /// Errors of [`Scene::check`].
    pub fn new(scene: impl Into<Arc<Scene>>, options: &'a Options) -> Result<Self> {
        let scene = scene.into();
        scene.check()?;
        Ok(Self { scene: Cow::Owned(scene), options, planned: OnceLock::new() })
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
    pub fn plan(&self, control: &Control) -> Result<&Planned> {
        if let Some(planned) = self.planned.get() {
            return Ok(planned);
        }
        let planned = Planner::new(self.options).plan(self.scene().clone(), None, control)?;
        Ok(self.planned.get_or_init(|| Cow::Owned(planned)))
    }

    /// The job of another camera; a plan that is there is kept.
    pub(super) fn seen_by(&self, camera: crate::camera::Camera, control: &Control) -> Result<Self> {
        match self.planned.get() {
            Some(planned) => {
                let mut planned = Planned::clone(planned);
                planned.look_from(camera, control)?;
                Ok(Self::of(planned, self.options))
            }
            None => Self::new(Scene::clone(&self.scene).with_camera(camera), self.options),
        }
    }

    /// A job whose plan is made.
    pub(super) fn of(planned: Planned, options: &'a Options) -> Self {
        Self { scene: Cow::Owned(planned.scene().clone()), options, planned: OnceLock::from(Cow::Owned(planned)) }
    }
}

impl<'a> From<&'a Planned> for Job<'a> {
    fn from(planned: &'a Planned) -> Self {
        Self { scene: Cow::Borrowed(planned.scene()), options: planned.options(), planned: OnceLock::from(Cow::Borrowed(planned)) }
    }
}
