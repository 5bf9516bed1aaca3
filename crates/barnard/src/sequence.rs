//! Sequences: frame after frame of a scene that changes.
//!
//! A [`Sequence`] is an animated scene, from which scenes at moments are read. A [`Follower`] goes with it from moment to moment and
//! computes again only what changed: a camera that moves keeps the plan. [`FrameSettings`] fixes choices that would flicker if each
//! frame made its own.

use std::sync::Arc;

use spectra::colour::Palette;
use spectra::fingerprint::Fingerprint;

use crate::animation::{Frames, Timeline};
use crate::backend::Renderer;
use crate::backend::cpu::Cpu;
use crate::camera;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::image::{Display, LayerChoice, Level, Tone};
use crate::plan::{Choices, Options, Planned, Planner, Quality};
use crate::properties::{Section, Table, Value};
use crate::scene::{Film, Loader, Provenance, Scene};

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
/// Pixels along the longer edge of a pilot frame's picture: enough for the levels of a display.
const PILOT_EDGE: usize = 320;

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
                let planner = Planner::new(options).with_quality(Quality::Chosen(choices.clone()));
                planner.plan(scene, before.as_ref().map(|(_, planned)| planned), control)?
            }
        };
        Ok(&self.planned.insert((inputs, plan)).1)
    }
}

/// Fingerprint of a tree without its camera.
fn but_for_camera(tree: &Table) -> Fingerprint {
    let mut rest = tree.clone();
    rest.remove("camera");
    rest.fingerprint()
}

/// Settings shared by all frames of a sequence, so that none differs from its neighbours by more than what it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameSettings {
    /// Choices of the pilot rays of some frames.
    pub choices: Choices,
    /// The display of all frames where they leave levels to be found: the median of those that these frames ask for.
    pub display: Display,
}

impl FrameSettings {
    /// Settings measured on the pilot frames of a sequence; `scene` makes each of them from its moment \[s\].
    ///
    /// # Errors
    /// Errors of [`Planner::plan`] and of `scene`, and on interruption by the user.
    pub fn measured<E: From<Error>>(
        pilots: &[f64],
        mut scene: impl FnMut(f64) -> std::result::Result<Scene, E>,
        options: &Options,
        control: &Control,
    ) -> std::result::Result<Self, E> {
        let mut choices: Option<Choices> = None;
        // One scene and one plan at a time are in memory, and what the next shares with them.
        let mut before: Option<Planned> = None;
        let mut display: Option<Display> = None;
        let mut tones: Vec<Tone> = Vec::new();
        for (i, time) in pilots.iter().enumerate() {
            let share = |i: usize| i as f64 / pilots.len() as f64;
            let control = control.part(share(i), share(i + 1));
            let scene = &scene(*time)?;
            let plan = Planner::new(options).plan(scene, before.as_ref(), &control)?;
            display.get_or_insert_with(|| scene.display.clone());
            let choices_here = Choices::of(&plan);
            choices = Some(choices.map_or_else(|| choices_here.clone(), |all| all.and(&choices_here)));
            if is_open(&scene.display) {
                let (width, height) = (scene.camera.width, scene.camera.height);
                let scale = PILOT_EDGE as f64 / width.max(height).max(PILOT_EDGE) as f64;
                let edge = |n: usize| ((n as f64 * scale).round() as usize).max(1);
                let camera = scene.camera.clone().with_size(edge(width), edge(height)).with_supersampling(1);
                let small = scene.clone().with_camera(camera).with_layers(LayerChoice::default());
                let (image, _) = Renderer::new(&mut Cpu).render(&plan.with_scene(small.into(), &control)?, &control)?;
                // A frame without light asks for nothing.
                if image.radiances().any(|band| image.band(band).any(|v| v > 0.0)) {
                    tones.push(scene.display.tone(&image));
                }
            }
            before = Some(plan);
        }
        let (Some(choices), Some(first)) = (choices, display) else {
            return Err(Error::missing("a pilot frame", "render one frame or more").into());
        };
        let display = if tones.is_empty() { first } else { found(&first, &tones) };
        Ok(Self { choices, display })
    }

    /// A display of one frame, with the levels that hold where it leaves them to be found.
    pub fn display(&self, stated: &Display) -> Display {
        let shared = &self.display;
        Display {
            palette: if stated.balance { shared.palette.clone() } else { stated.palette.clone() },
            balance: false,
            stretch: stated.stretch,
            black: stated.black,
            white: if stated.white == Level::Auto { shared.white } else { stated.white },
            bits: stated.bits,
            glare: stated.glare,
        }
    }
}

/// True if a display leaves levels to be found from the picture.
fn is_open(display: &Display) -> bool {
    display.balance || display.white == Level::Auto
}

/// A display with the levels that some pictures ask for, the median of each: one that flies past a star asks for far too much.
fn found(display: &Display, tones: &[Tone]) -> Display {
    let median = |quantity: &dyn Fn(&Tone) -> f64| {
        let mut order: Vec<usize> = (0..tones.len()).collect();
        order.sort_by(|a, b| quantity(&tones[*a]).total_cmp(&quantity(&tones[*b])));
        order[(order.len() - 1) / 2]
    };
    // Columns of a band differ by how much it is brightened alone.
    let size = |tone: &Tone, band: usize| tone.palette.columns[band].iter().map(|v| v.abs()).sum::<f64>();
    let column = |band: usize| tones[median(&|tone| size(tone, band))].palette.columns[band];
    let columns = (0..display.palette.columns.len()).map(column).collect();
    let white = tones[median(&|tone| tone.white)].white;
    Display { palette: Palette { columns }, balance: false, white: Level::Radiance(white), ..display.clone() }
}
