//! Pictures and films on their way into files: the radiances that `barnard render` writes, in the levels that the window shows,
//! made beside the window.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use barnard::backend::Renderer;
use barnard::backend::cpu::Cpu;
use barnard::control::Control;
use barnard::image::Display;
use barnard::plan::Options;
use barnard::scene::Scene;
use barnard::sequence::{Follower, FrameSettings, Sequence};
use barnard::{Error, Result};
use barnard_files::SaveImage;
use barnard_files::formats::{check_writable, numbered, writer};
use eframe::egui::{self, Context};

use crate::progress::Progress;

/// The work and the way to stop it.
pub struct Export {
    /// The path of the file, or of the frames.
    pub path: PathBuf,
    control: Control,
    progress: Arc<Progress>,
    /// Message about the written files.
    result: Receiver<Result<String>>,
}

impl Export {
    /// Begins to render `scene` into `path`.
    ///
    /// # Errors
    /// If the format is not known, the file cannot be written, or the picture would not fit.
    pub fn start(scene: &Scene, path: &Path, size: (usize, usize), options: Options, ctx: &Context) -> Result<Self> {
        let writer = writer(path)?;
        check_writable(path)?;
        let scene = sized(scene.clone(), size).for_files(writer.has_layers, writer.is_picture, options.memory_limit)?;
        let target = path.to_owned();
        Ok(Self::of(path, ctx, move |control| {
            barnard::render_with(&scene, &options, control)?.save(&target, &scene.save_options())?;
            Ok(format!("wrote {}", target.display()))
        }))
    }

    /// Begins to render all frames of `sequence` in one display into files whose names have a number, such as `film_%04d.png`.
    ///
    /// # Errors
    /// If the format is not known, the name has no number, or the first file cannot be written.
    pub fn film(
        sequence: Sequence,
        display: Display,
        pattern: &Path,
        size: (usize, usize),
        options: Options,
        ctx: &Context,
    ) -> Result<Self> {
        let writer = writer(pattern)?;
        let frames = sequence.frames();
        let missing = || Error::file(pattern, "has no frame number; write a name such as film_%04d.png");
        check_writable(&numbered(pattern, frames.first).ok_or_else(missing)?)?;
        let target = pattern.to_owned();
        Ok(Self::of(pattern, ctx, move |control| {
            let prepared = |scene: Scene| {
                sized(scene, size).with_display(display.clone()).for_files(writer.has_layers, writer.is_picture, options.memory_limit)
            };
            let mut follower = Follower::new(&sequence);
            let settings = FrameSettings::of(&sequence, |time| prepared(follower.scene(time, control)?), &options, control)?;
            let render = |plan: &_, control: &Control| Ok(Renderer::new(&mut Cpu).render(plan, control)?.0);
            for (done, number) in (frames.first..=frames.last()).enumerate() {
                let share = |done: usize| done as f64 / frames.count as f64;
                let control = control.part(share(done), share(done + 1));
                let frame = follower.frame(number, (&settings, &options), &control, prepared, render)?;
                frame.image.save(numbered(&target, number).unwrap_or_else(|| target.clone()), &frame.scene.save_options())?;
            }
            let (count, rate, first) = (frames.count, frames.per_second, frames.first);
            let words = format!("wrote {count} frames; ffmpeg -framerate {rate} -start_number {first} -i {} film.mp4", target.display());
            Ok(words)
        }))
    }

    /// Does `work` in a thread of its own.
    fn of(path: &Path, ctx: &Context, work: impl FnOnce(&Control) -> Result<String> + Send + 'static) -> Self {
        let (progress, repaint) = (Arc::<Progress>::default(), ctx.clone());
        let control = progress.control(move || repaint.request_repaint());
        let (sender, result) = channel();
        let (stop, repaint) = (control.clone(), ctx.clone());
        std::thread::spawn(move || {
            // The result is dropped if the window is closed.
            let _ = sender.send(work(&stop));
            repaint.request_repaint();
        });
        Self { path: path.to_owned(), control, progress, result }
    }

    /// Stops it; no further file is written.
    pub fn stop(&self) {
        self.control.interrupt();
    }

    /// True if the export was stopped.
    pub fn is_stopped(&self) -> bool {
        self.control.check().is_err()
    }

    /// Shows how far it is; returns what came of it once it is done.
    pub fn show(&mut self, ctx: &Context) -> Option<std::result::Result<String, String>> {
        match self.result.try_recv() {
            Ok(result) => return Some(result.map_err(|error| error.to_string())),
            Err(TryRecvError::Disconnected) => {
                return Some(Err("internal error while rendering; the file was not written".into()));
            }
            Err(TryRecvError::Empty) => {}
        }
        egui::Window::new("Saving").collapsible(false).resizable(false).anchor(egui::Align2::CENTER_BOTTOM, [0.0, -60.0]).show(ctx, |ui| {
            ui.label(self.path.display().to_string());
            let (stage, share) = self.progress.now().unwrap_or(("preparation", 0.0));
            ui.add(egui::ProgressBar::new(share).text(format!("{stage} {:.0} %", 100.0 * share)).desired_width(280.0));
            if ui.button("Stop").clicked() {
                self.stop();
            }
        });
        None
    }
}

impl Drop for Export {
    fn drop(&mut self) {
        self.stop();
    }
}

/// A scene whose image has another size in pixels.
fn sized(scene: Scene, (width, height): (usize, usize)) -> Scene {
    let camera = scene.camera.clone().with_size(width, height);
    scene.with_camera(camera)
}
