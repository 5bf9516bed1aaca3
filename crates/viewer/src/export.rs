//! A picture on its way into a file: the radiances that `barnard render` writes, in the levels that the window shows,
//! made beside the window.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use barnard::control::Control;
use barnard::plan::Options;
use barnard::scene::Scene;
use barnard_files::SaveImage;
use barnard_files::formats::{check_writable, writer};
use eframe::egui::{self, Context};

use crate::progress::Progress;

/// The work and the way to stop it.
pub struct Export {
    /// The path of the file.
    pub path: PathBuf,
    control: Control,
    progress: Arc<Progress>,
    result: Receiver<barnard::Result<()>>,
}

impl Export {
    /// Begins to render `scene` into `path`.
    ///
    /// # Errors
    /// If the format is not known, the file cannot be written, or the picture would not fit.
    pub fn start(scene: &Scene, path: &Path, size: (usize, usize), options: Options, ctx: &Context) -> barnard::Result<Self> {
        let writer = writer(path)?;
        check_writable(path)?;
        let scene = scene.clone().with_camera(scene.camera.clone().with_size(size.0, size.1));
        let scene = scene.for_files(writer.has_layers, writer.is_picture, options.memory_limit)?;
        let (progress, repaint) = (Arc::<Progress>::default(), ctx.clone());
        let control = progress.control(move || repaint.request_repaint());
        let (sender, result) = channel();
        let (target, stop, repaint) = (path.to_owned(), control.clone(), ctx.clone());
        std::thread::spawn(move || {
            let work = || barnard::render_with(&scene, &options, &stop)?.save(&target, &scene.save_options());
            // Nobody listens any more where the window is gone.
            let _ = sender.send(work());
            repaint.request_repaint();
        });
        Ok(Self { path: path.to_owned(), control, progress, result })
    }

    /// Stops it; nothing is written then.
    pub fn stop(&self) {
        self.control.interrupt();
    }

    /// True if the export was stopped.
    pub fn is_stopped(&self) -> bool {
        self.control.check().is_err()
    }

    /// Shows how far it is; returns what came of it once it is done.
    pub fn show(&mut self, ctx: &Context) -> Option<Result<String, String>> {
        match self.result.try_recv() {
            Ok(result) => return Some(result.map(|()| format!("wrote {}", self.path.display())).map_err(|e| e.to_string())),
            Err(TryRecvError::Disconnected) => {
                return Some(Err("internal error while rendering; nothing was written".into()));
            }
            Err(TryRecvError::Empty) => {}
        }
        egui::Window::new("Saving the picture").collapsible(false).resizable(false).anchor(egui::Align2::CENTER_BOTTOM, [0.0, -60.0]).show(
            ctx,
            |ui| {
                let (stage, share) = self.progress.now().unwrap_or(("preparation", 0.0));
                ui.add(egui::ProgressBar::new(share).text(stage).desired_width(280.0));
                if ui.button("Stop").clicked() {
                    self.stop();
                }
            },
        );
        None
    }
}

impl Drop for Export {
    fn drop(&mut self) {
        self.stop();
    }
}
