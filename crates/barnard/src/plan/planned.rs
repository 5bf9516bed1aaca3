//! Scenes with their plans.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::{Options, Plan, SpatialPlan, Stepping};
use crate::camera::Camera;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::light::LightPart;
use crate::scene::{Part, Parts, Scene};

/// Parts of a scene that its plan fixes, for any method and camera.
const FIXED: [Part; 4] = [Part::Space, Part::Stars, Part::Spectra, Part::Amount];

/// A scene with its plan, made by a [`Planner`](super::Planner); copies share all large parts.
///
/// # Examples
/// One plan renders several cameras:
///
/// ```
/// use barnard::backend::Renderer;
/// use barnard::backend::cpu::Cpu;
/// use barnard::field::Fbm;
/// use barnard::plan::Planner;
/// use barnard::prelude::*;
///
/// let camera = |x: f64| Camera::look_at(dvec3(x, 0.0, 5.0), DVec3::ZERO).with_size(8, 8);
/// let dust = Dust::new(Fbm::new(3), Extinction::by_name("draine03_rv31")?, Scale::mag_per_pc(4.0));
/// let star = Star::blackbody(Temperature(15_000.0), Luminosity::suns(2000.0)).with_position(dvec3(0.1, 0.2, -0.5));
/// let scene = SceneSpec::new(camera(0.0)).with_bands(passband::set("johnson")?).with_dust(dust).with_star(star).build()?;
/// # let scene = barnard::plan::sample_functions(&scene, &Options::default())?;
/// let control = Control::default();
/// let mut planned = Planner::new(&Options::default()).plan(scene, None, &control)?;
/// for x in [0.0, 1.0] {
///     planned.look_from(camera(x), &control)?;
///     let (image, _) = Renderer::new(&mut Cpu).render(&planned, &control)?;
///     println!("{}; brightest {:e}", image.report.summary(), image.band(0).fold(0.0, f64::max));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Planned {
    scene: Arc<Scene>,
    plan: Plan,
    options: Options,
    /// Fingerprints of the scene, computed at first use. A later change of the camera does not update them.
    parts: OnceLock<Parts>,
}

impl Planned {
    pub(super) fn new(scene: Arc<Scene>, plan: Plan, options: Options) -> Self {
        Self { scene, plan, options, parts: OnceLock::new() }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Its plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The options that it was made with.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The plan for another scene with the same densities, lights, passbands and dust: other camera, display, output, observation.
    ///
    /// # Errors
    /// Errors of [`Scene::check`] and of [`look_from`](Self::look_from), and if the plan is not valid for the scene.
    pub fn for_scene(&self, scene: impl Into<Arc<Scene>>, control: &Control) -> Result<Self> {
        let scene = scene.into();
        scene.check()?;
        let parts = self.parts.get_or_init(|| self.scene.parts());
        let differing = parts.differing(&scene.parts());
        let differing: Vec<String> = differing.iter().filter(|part| FIXED.contains(part)).map(Part::to_string).collect();
        if !differing.is_empty() {
            let problem = format!("the scene differs from that of its plan ({})", differing.join(", "));
            return Err(Error::conflict(problem, "make a new plan"));
        }
        self.with_scene(scene, control)
    }

    /// Variant of [`for_scene`](Self::for_scene) without its checks, for a scene whose [parts](Scene::parts) were compared.
    ///
    /// # Errors
    /// Errors of [`look_from`](Self::look_from).
    pub fn with_scene(&self, scene: Arc<Scene>, control: &Control) -> Result<Self> {
        let mut plan = self.plan.clone();
        if plan.camera != scene.camera {
            plan.look_from(scene.camera.clone(), control)?;
        }
        Ok(Self { scene, plan, options: self.options.clone(), parts: self.parts.clone() })
    }

    /// Looks from elsewhere; all that space and spectra decide stays.
    ///
    /// # Errors
    /// Errors of [`Camera::check`], and on interruption by the user; the plan is as before then.
    pub fn look_from(&mut self, camera: Camera, control: &Control) -> Result<()> {
        self.plan.look_from(camera.clone(), control)?;
        self.scene = Arc::new(Scene::clone(&self.scene).with_camera(camera));
        Ok(())
    }

    /// Moves a star \[pc\]: its depths alone are swept anew, nothing that spectra decide is touched. The measured spatial error and
    /// multiple scattering stay those of the positions before.
    ///
    /// # Errors
    /// If there is no such star, a light field stands in place of its depths, or on interruption by the user; the plan
    /// is as before then.
    pub fn move_star(&mut self, star: usize, position: DVec3, control: &Control) -> Result<()> {
        self.plan.move_star(star, position, control)?;
        self.scene = Arc::new(Scene::clone(&self.scene).with_moved_star(star, position));
        self.parts = OnceLock::new();
        Ok(())
    }

    /// Copy of the plan with another image size and the same camera position.
    #[must_use]
    pub fn with_size(self, width: usize, height: usize) -> Self {
        self.with_camera(|camera| camera.with_size(width, height))
    }

    /// Copy of the plan with `rays` × `rays` rays per pixel.
    #[must_use]
    pub fn with_supersampling(self, rays: usize) -> Self {
        self.with_camera(|camera| camera.with_supersampling(rays))
    }

    /// For cameras at the same position.
    fn with_camera(mut self, change: impl FnOnce(Camera) -> Camera) -> Self {
        let camera = change(self.plan.camera.clone());
        self.plan.camera = camera.clone();
        self.scene = Arc::new(Scene::clone(&self.scene).with_camera(camera));
        self
    }

    /// Copy of the plan with other steps along a ray; errors that pilot rays measured are those of the steps before.
    #[must_use]
    pub fn with_stepping(mut self, stepping: Stepping) -> Self {
        self.plan.stepping = stepping;
        self
    }

    /// Copy of the plan without the field that is marched beside single scattering: multiple scattering and aggregated stars.
    #[must_use]
    pub fn without_scattered_field(mut self) -> Self {
        self.plan.scattered_field = None;
        self
    }

    /// Copy of the plan without what many stars send to the dust near them, which is marched star by star.
    #[must_use]
    pub fn without_near_field(mut self) -> Self {
        if let Some(scattered_field) = &mut self.plan.scattered_field {
            Arc::make_mut(scattered_field).report.far_field = None;
        }
        self
    }

    /// Copy of the plan of which only some parts of the light shine.
    #[must_use]
    pub(crate) fn only(&self, shines: impl Fn(LightPart) -> bool) -> Self {
        let mut planned = self.clone();
        planned.plan.shining = Some(self.plan.lights.iter().map(|light| shines(light.route.part())).collect());
        if !shines(LightPart::Scattered) {
            (planned.plan.light_field, planned.plan.scattered_field) = (None, None);
        }
        planned
    }

    /// Copy of the plan with the depths and densities of another: for tests of back ends that sweep depths themselves.
    #[doc(hidden)]
    #[must_use]
    pub fn with_space(mut self, space: Arc<SpatialPlan>) -> Self {
        let positions = space.stars.clone();
        self.plan.space = space;
        let scene = Scene::clone(&self.scene);
        self.scene =
            Arc::new(positions.into_iter().enumerate().fold(scene, |scene, (star, position)| scene.with_moved_star(star, position)));
        self.parts = OnceLock::new();
        self
    }
}

impl Deref for Planned {
    type Target = Plan;

    fn deref(&self) -> &Plan {
        &self.plan
    }
}
