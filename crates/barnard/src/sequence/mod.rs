//! Sequences: frame after frame of a scene that changes.
//!
//! A [`Sequence`] is an animated scene, from which scenes at moments are read. A [`Follower`] goes with it from moment to moment and
//! computes again only what changed: a camera that moves keeps the plan. [`FrameSettings`] fixes choices that would flicker if each
//! frame made its own.

mod settings;
mod stored;

use std::sync::Arc;
use std::time::Instant;

use spectra::fingerprint::{Digest, Fingerprint};

pub use settings::FrameSettings;

use crate::animation::{Frames, Timeline};
use crate::camera;
use crate::composite::mean;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::plan::{Choices, Options, Planned, Planner, Quality};
use crate::properties::{Section, Table, Value};
use crate::scene::{Film, Loader, Part, Provenance, Scene};

/// Animated scene.
///
/// # Examples
/// ```
/// use barnard::scene::Loader;
/// use barnard_files::SceneFile;
///
/// let text = r#"
/// bands = "johnson"
/// camera = { kind = "perspective", position = "0 0 5 pc", field_of_view = "30 deg", size = [8, 8] }
/// [[star]]
/// kind = "blackbody"
/// position = "0 0 0 pc"
/// temperature = "9000 K"
/// luminosity = "100 Lsun"
/// [[animation]]
/// of = "star[0].temperature"
/// times = ["0 s", "2 s"]
/// values = ["9000 K", "30000 K"]
/// [sequence]
/// frames_per_second = 10
/// "#;
/// let file = SceneFile::parse("flight.toml", "flight", text.into(), Loader::default())?;
/// let frames = file.sequence()?.frames();
/// assert_eq!((frames.first, frames.last()), (1, 21));
/// # Ok::<(), barnard::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Sequence {
    tree: Table,
    name: String,
    loader: Loader,
    timeline: Arc<Timeline>,
    provenance: Option<Provenance>,
}

impl Sequence {
    /// The sequence of a scene that was read from a tree by a loader.
    ///
    /// # Errors
    /// If nothing of the scene changes, and no `[sequence]` says how long it stands still.
    pub fn new(tree: Table, loader: Loader, scene: &Scene) -> Result<Self> {
        let missing = || {
            let what = format!("a timeline of scene \"{}\"", scene.name);
            Error::missing(what, "add a [camera.path], an [[animation]] or a [sequence]; see docs/shows.md")
        };
        let timeline = scene.timeline.clone().ok_or_else(missing)?;
        Ok(Self { tree, name: scene.name.clone(), loader, timeline, provenance: scene.provenance.clone() })
    }

    /// The frames.
    pub fn frames(&self) -> Frames {
        self.timeline.frames
    }

    /// Fingerprint of all that changes; `first` is the first frame.
    fn fingerprint(&self, first: &Scene) -> Fingerprint {
        let parts = first.parts();
        let mut digest = Digest::new("sequence");
        digest.part(self.tree.fingerprint()).part(self.timeline.fingerprint()).part(parts.physics());
        digest.part(parts.of(&[Part::View, Part::Display, Part::Observation])).finish()
    }

    /// The scene at a moment \[s\].
    ///
    /// # Errors
    /// Errors of [`Scene::from_properties`]; the error states the time.
    pub fn scene(&self, time: f64) -> Result<Scene> {
        Follower::new(self).scene(time, &Control::default())
    }

    /// Scene at a moment \[s\]: a tree without animation.
    ///
    /// # Errors
    /// Errors of [`Timeline::at`].
    pub fn tree(&self, time: f64) -> Result<Table> {
        self.timeline.at(&self.tree, time)
    }

    /// What is wrong with a star of a scene of it whose light changes faster than light crosses the cloud; none where no star does.
    ///
    /// # Errors
    /// If what the scene says at a moment cannot be read.
    pub fn missing_echo(&self, scene: &Scene) -> Result<Option<String>> {
        Film { timeline: &self.timeline, tree: &self.tree, time: 0.0 }.missing_echo(scene, &self.loader)
    }

    /// The moments of frames that choose what holds for all, from the first to the last \[s\]: the same whichever frames are
    /// asked for.
    pub fn pilots(&self) -> Vec<f64> {
        let frames = self.frames();
        let count = (frames.count / FRAMES_PER_PILOT).clamp(PILOTS.0.min(frames.count), PILOTS.1);
        let pilot = |i: u64| if count > 1 { i * (frames.count - 1) / (count - 1) } else { 0 };
        (0..count).map(|i| frames.time(frames.first + pilot(i) as i64)).collect()
    }
}

/// Frames of a sequence for each pilot frame, and how many of those there are at least and at most.
const FRAMES_PER_PILOT: u64 = 16;
const PILOTS: (u64, u64) = (3, 9);

/// Goes with a sequence from moment to moment.
#[derive(Debug)]
pub struct Follower {
    sequence: Sequence,
    /// The latest scene, and the fingerprint of its tree without the camera.
    read: Option<(Fingerprint, Scene)>,
    /// The latest plan, and what it depends on but the camera.
    planned: Option<(PlanInputs, Planned)>,
}

/// Inputs of a plan but the camera.
#[derive(Debug, Clone, PartialEq)]
struct PlanInputs {
    physics: Fingerprint,
    choices: Choices,
    memory_limit: u64,
    star_depth_voxels: usize,
}

impl Follower {
    /// Starts at no moment yet.
    pub fn new(sequence: &Sequence) -> Self {
        Self { sequence: sequence.clone(), read: None, planned: None }
    }

    /// The scene at a moment \[s\].
    ///
    /// # Errors
    /// Errors of [`Scene::from_properties`]; the error states the time. And on interruption by the user.
    pub fn scene(&mut self, time: f64, control: &Control) -> Result<Scene> {
        let Sequence { tree, name, loader, timeline, provenance } = &self.sequence;
        let loader = &loader.under(control);
        let at_moment = |error: Error| match error {
            Error::Scene { message, place } => Error::Scene { message: format!("{message} (at {time:.4} s)"), place },
            other => other,
        };
        let still = timeline.at(tree, time).map_err(at_moment)?;
        let content = but_for_camera(&still);
        let known = self.read.as_ref().filter(|(known, _)| *known == content).map(|(_, scene)| scene.clone());
        let scene = match (known, still.get("camera").map(|property| &property.value)) {
            (Some(scene), Some(Value::Table(table))) => {
                let camera = camera::build(&Section::new(table, "camera"), &loader.inputs).map_err(at_moment)?;
                scene.edited_within(loader.inputs.memory_limit, control, |spec| spec.camera = camera).map_err(at_moment)?
            }
            _ => {
                let scene = Scene::still(&still, name, loader, Some(Film { timeline, tree, time })).map_err(at_moment)?;
                scene.with_provenance(provenance.clone()).with_timeline(timeline.clone())
            }
        };
        self.read = Some((content, scene.clone()));
        Ok(scene)
    }

    /// The plan of the latest scene, which may have another camera, display or method by now, made by choices of earlier plans.
    ///
    /// # Errors
    /// Errors of [`Planner::plan`].
    pub fn plan(&mut self, scene: &Scene, options: &Options, choices: &Choices, control: &Control) -> Result<&Planned> {
        let Options { memory_limit, star_depth_voxels, .. } = *options;
        let inputs = PlanInputs { physics: scene.parts().physics(), choices: choices.clone(), memory_limit, star_depth_voxels };
        let plan = match self.planned.take() {
            Some((known, planned)) if known == inputs => planned.with_scene(scene.into(), control)?,
            before => {
                let planner = Planner::new(options).with_quality(Quality::Chosen(Box::new(choices.clone())));
                planner.plan(scene, before.as_ref().map(|(_, planned)| planned), control)?
            }
        };
        Ok(&self.planned.insert((inputs, plan)).1)
    }

    /// A frame, the mean over the moments of its shutter: `prepared` changes the scene of a moment, `render` renders its plan.
    ///
    /// # Errors
    /// Errors of [`scene`](Self::scene) and [`plan`](Self::plan), of `prepared` and of `render`.
    pub fn frame<E: From<Error>>(
        &mut self,
        number: i64,
        (settings, options): (&FrameSettings, &Options),
        control: &Control,
        mut prepared: impl FnMut(Scene) -> std::result::Result<Scene, E>,
        mut render: impl FnMut(&Planned, &Control) -> std::result::Result<Image, E>,
    ) -> std::result::Result<FrameImage, E> {
        let frames = self.sequence.frames();
        let (mut first, mut planning_s) = (None, 0.0);
        let at = |time: f64| {
            let scene = prepared(self.scene(time, control)?)?;
            let display = settings.display(&scene.display);
            let scene = scene.with_display(display);
            let start = Instant::now();
            let plan = self.plan(&scene, options, &settings.choices, control)?;
            planning_s += start.elapsed().as_secs_f64();
            first.get_or_insert(scene);
            render(plan, control)
        };
        let image = mean(frames.moments(number).into_iter().map(at))?;
        let (Some(mut image), Some(scene)) = (image, first) else {
            return Err(Error::missing("a moment of the frame", "render one or more").into());
        };
        frames.stamp(number, &mut image);
        Ok(FrameImage { image, scene, planning_s })
    }
}

/// A rendered frame.
#[derive(Debug)]
pub struct FrameImage {
    /// Its mean image.
    pub image: Image,
    /// The scene of its first moment.
    pub scene: Scene,
    /// Time that its plans took \[s\].
    pub planning_s: f64,
}

/// Fingerprint of a tree without its camera.
fn but_for_camera(tree: &Table) -> Fingerprint {
    let mut rest = tree.clone();
    rest.remove("camera");
    rest.fingerprint()
}
