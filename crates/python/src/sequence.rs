//! Sequences: frames of a scene that changes.

use std::sync::{Arc, Mutex, PoisonError};

use barnard::composite::mean;
use barnard::control::Control;
use barnard::properties::Table;
use barnard::sequence::{Follower, FrameSettings};
use barnard::{Error, Result};
use barnard_cli::backends::registry;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::image::{Image, rendered};
use crate::open;
use crate::scene::{Owner, Reader, Words, plan_options};
use crate::{tree, work};

/// Frames of a scene, what holds for all of them once one was asked for, and what the latest left for the next.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Sequence {
    sequence: barnard::sequence::Sequence,
    /// Taken while a frame is rendered: no lock is held meanwhile, since a thread that waits for others may take up another
    /// frame's work.
    followed: Mutex<Option<Follower>>,
    shared: Mutex<Option<Arc<FrameSettings>>>,
    words: Arc<Words>,
}

impl Sequence {
    pub fn new(sequence: barnard::sequence::Sequence, words: Arc<Words>) -> Self {
        Self { followed: Mutex::default(), shared: Mutex::default(), sequence, words }
    }
}

/// The frames of the scene that a tree describes, read by what reads scenes.
#[pyfunction]
pub fn sequence(py: Python, reader: &Reader, scene: &Bound<PyDict>, name: &str) -> PyResult<Sequence> {
    let table = tree::table(scene)?;
    let made = work::run(py, None, |control| {
        let scene = barnard::Scene::from_properties(&table, name, &reader.loader.under(control))?;
        barnard::sequence::Sequence::new(table.clone(), reader.loader.clone(), &scene)
    })?;
    Ok(Sequence::new(made, reader.words(table)))
}

#[pymethods]
impl Sequence {
    /// Numbers of the first and the last frame.
    #[getter]
    fn range(&self) -> (i64, i64) {
        let frames = self.sequence.frames();
        (frames.first, frames.last())
    }

    /// The moment of a frame [s].
    fn time(&self, number: i64) -> f64 {
        self.sequence.frames().time(number)
    }

    /// Renders a frame by a back end.
    #[pyo3(signature = (number, backend, options, memory_limit, progress=None))]
    fn render(
        &self,
        py: Python,
        number: i64,
        backend: &str,
        options: &Bound<PyDict>,
        memory_limit: u64,
        progress: Option<&Bound<PyAny>>,
    ) -> PyResult<Image> {
        let by = (backend, tree::table(options)?);
        work::run(py, progress, |control| self.frame(number, &by, memory_limit, control))
    }
}

impl Sequence {
    fn frame(&self, number: i64, by: &(&str, Table), memory_limit: u64, control: &Control) -> Result<Image> {
        let frames = self.sequence.frames();
        if !(frames.first..=frames.last()).contains(&number) {
            return Err(Error::out_of_range("frame", number, format!("between {} and {}", frames.first, frames.last())));
        }
        let resumed = self.followed.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut follower = resumed.unwrap_or_else(|| Follower::new(&self.sequence));
        let image = self.followed_frame(&mut follower, number, by, memory_limit, control);
        *self.followed.lock().unwrap_or_else(PoisonError::into_inner) = Some(follower);
        image
    }

    fn followed_frame(
        &self,
        follower: &mut Follower,
        number: i64,
        (backend, options_of): &(&str, Table),
        memory_limit: u64,
        control: &Control,
    ) -> Result<Image> {
        let frames = self.sequence.frames();
        let mut options = plan_options(memory_limit)?;
        let first = follower.scene(frames.time(number), control)?;
        if first.method.bounces > 1 {
            options.sweeper = open::with(backend, &first, |backend| Ok(backend.sweeper()))?;
        }
        let settings = self.shared.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let shared = match settings {
            Some(shared) => shared,
            None => {
                let shared = Arc::new(FrameSettings::of(&self.sequence, |time| follower.scene(time, control), &options, control)?);
                *self.shared.lock().unwrap_or_else(PoisonError::into_inner) = Some(shared.clone());
                shared
            }
        };
        let planned = registry().by_name(backend)?.planned;
        let mut frame: Option<Image> = None;
        let at = |time: f64| -> Result<barnard::Image> {
            let scene = follower.scene(time, control)?;
            let display = shared.display(&scene.display);
            let scene = Arc::new(scene.with_display(display));
            let plan = planned.then(|| follower.plan(&scene, &options, &shared.choices, control)).transpose()?;
            let scene = Owner { scene, words: self.words.clone() };
            let image = rendered(&scene, plan, backend, options_of, memory_limit, control)?;
            let picture = image.image.clone();
            frame.get_or_insert(image);
            Ok(picture)
        };
        let image = mean(frames.moments(number).into_iter().map(at))?;
        match (image, frame) {
            (Some(image), Some(mut frame)) => {
                frame.image = image;
                frames.stamp(number, &mut frame.image);
                Ok(frame)
            }
            _ => Err(Error::missing("a moment of the frame", "render one or more")),
        }
    }
}
