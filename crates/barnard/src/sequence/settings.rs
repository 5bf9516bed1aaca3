//! Settings shared by all frames of a sequence.

use spectra::colour::Palette;

use super::{Sequence, stored};
use crate::backend::Renderer;
use crate::backend::cpu::Cpu;
use crate::control::Control;
use crate::error::Error;
use crate::image::{Display, LayerChoice, Level, Tone};
use crate::plan::{Choices, Options, Planned, Planner};
use crate::scene::Scene;

/// Pixels along the longer edge of a pilot frame's picture: enough for the levels of a display.
const PILOT_EDGE: usize = 320;

/// Settings shared by all frames of a sequence, so that none differs from its neighbours by more than what it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameSettings {
    /// Choices of the pilot rays of some frames.
    pub choices: Choices,
    /// The display of all frames where they leave levels to be found: the median of those that these frames ask for.
    pub display: Display,
}

impl FrameSettings {
    /// Settings of a sequence: those of the cache, or measured on its pilot frames and stored; `scene` makes each frame from its
    /// moment \[s\].
    ///
    /// # Errors
    /// Errors of [`measured`](Self::measured).
    pub fn of<E: From<Error>>(
        sequence: &Sequence,
        mut scene: impl FnMut(f64) -> std::result::Result<Scene, E>,
        options: &Options,
        control: &Control,
    ) -> std::result::Result<Self, E> {
        let pilots = sequence.pilots();
        let Some(cache) = &options.cache else { return Self::measured(&pilots, scene, options, control) };
        let frames = sequence.frames();
        let first = scene(frames.time(frames.first))?;
        let content = sequence.fingerprint(&first);
        if let Some((choices, display)) = cache.get(stored::KIND, content).and_then(|record| stored::settings(&record, &first.display)) {
            return Ok(Self { choices, display });
        }
        let settings = Self::measured(&pilots, scene, options, control)?;
        cache.put(stored::KIND, content, &stored::record(&settings.choices, &settings.display));
        Ok(settings)
    }

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
