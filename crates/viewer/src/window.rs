//! The window itself.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use barnard::backend::{BackendEntry, DeviceUse, cpu};
use barnard::cache::Cache;
use barnard::scene::RayTracer;
use barnard_gpu::{Gpu, GpuError, IonisingRays};
use eframe::Renderer;
use eframe::egui::{Context, ViewportBuilder};
use eframe::egui_wgpu::{RenderState, WgpuSetup};

use crate::app::{App, first_look};
use crate::engine::Engine;
use crate::layout::WindowLayout;
use crate::session::Session;
use crate::timings::Timings;
use barnard_explorer::document::{Document, Origin};

/// Errors at the start of the explorer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewerError {
    /// Something in the scene is wrong.
    #[error(transparent)]
    Scene(#[from] barnard::Error),
    /// There is no screen, or nothing that draws on it.
    #[error("no window can be opened: {0}; use `barnard render` instead")]
    Window(String),
}

/// The way in which the explorer begins.
#[derive(Debug, Clone)]
pub struct Start {
    /// The scene; the first built-in one, or what was not saved last time, if none.
    pub scene: Option<Origin>,
    /// The back end that renders; the window's own device takes the place of one that would be opened, where it has one.
    pub backend: BackendEntry,
    /// Most bytes that a plan may take.
    pub memory_limit: u64,
    /// Cache of results between runs, if any.
    pub cache: Option<Arc<dyn Cache>>,
    /// True if it prints the rate of window updates to standard error.
    pub timings: bool,
}

/// Name of the application: its folder of settings, and its class among windows.
const NAME: &str = "barnard";

/// Opens the window and returns when it is closed.
///
/// # Errors
/// If there is no screen.
pub fn open(start: Start) -> Result<(), ViewerError> {
    let began = Instant::now();
    // An invalid scene is reported in the terminal and in the window, which shows another one.
    let (document, wrong) = match start.scene.as_ref().map(|origin| Document::of(origin, start.memory_limit)).transpose() {
        Ok(document) => (document, None),
        Err(error) => {
            eprintln!("barnard: {error}");
            (Some(Document::builtin(barnard_files::builtin::SCENES[0].name, start.memory_limit)?), Some(error))
        }
    };
    let mut session = Session::new(eframe::storage_dir(NAME));
    let (document, words) = begun(document, &mut session, start.memory_limit)?;
    // The first picture is made while the window opens.
    let context = Arc::<OnceLock<Context>>::default();
    let of_worker = context.clone();
    // A device is there when the window is.
    let first = if start.backend.device == DeviceUse::Never { start.backend } else { cpu::ENTRY };
    let engine = Engine::start(first, start.cache.clone(), move || of_worker.get().into_iter().for_each(Context::request_repaint));
    engine.submit(first_look(&document, start.memory_limit));
    let is_real = barnard_gpu::adapters().first().is_some_and(|adapter| adapter.real);
    let app = move |creation: &eframe::CreationContext| {
        context.get_or_init(|| creation.egui_ctx.clone());
        let lent = lent(creation.wgpu_render_state.as_ref(), start.backend.device, is_real);
        creation.storage.into_iter().for_each(|storage| session.restore(storage));
        session.opened(document.origin());
        if let Ok(Some(gpu)) = &lent {
            engine.lend(gpu.clone());
        }
        // On a device of its own, so that what it complains of is not the pictures'.
        let has_device = matches!(&lent, Ok(Some(gpu)) if gpu.adapter.real);
        let tracer = has_device.then(|| Arc::new(IonisingRays::once_asked()) as Arc<dyn RayTracer>);
        let mut app = App::new(document, engine, session, start.memory_limit);
        (app.tracer, app.cache) = (tracer, start.cache.clone());
        app.model.layout = WindowLayout::stored(creation.storage);
        app.timings = start.timings.then(|| Timings::since(began));
        words.into_iter().for_each(|words| app.model.tell(words));
        lent.err().into_iter().for_each(|error| app.model.complain(error));
        wrong.into_iter().for_each(|error| app.model.complain(format!("{error} (showing a built-in scene; retry with File, Open)")));
        app
    };
    drawn_by(renderers(is_real), app)
}

/// Window renderers, best first; `is_real` says whether there is a graphics device that is not software.
///
/// Egui's shader for wgpu filters textures by hand as well, and a device of software goes through both ways in every
/// pixel: OpenGL draws a window three times as often there.
fn renderers(is_real: bool) -> [Renderer; 2] {
    if is_real { [Renderer::Wgpu, Renderer::Glow] } else { [Renderer::Glow, Renderer::Wgpu] }
}

/// Opens the window by the first renderer that this machine has, and returns when it is closed.
fn drawn_by(renderers: [Renderer; 2], app: impl FnOnce(&eframe::CreationContext) -> App) -> Result<(), ViewerError> {
    // A renderer that fails has not asked for the app.
    let app = Cell::new(Some(app));
    let mut reasons = Vec::new();
    for renderer in renderers {
        let made = |creation: &eframe::CreationContext| match app.take() {
            Some(app) => Ok(Box::new(app(creation)) as Box<dyn eframe::App>),
            None => Err("the window was closed".into()),
        };
        // Where a display has nothing that OpenGL can draw on, eframe panics.
        let run = || eframe::run_native(NAME, options(renderer), Box::new(made));
        let ended = catch_unwind(AssertUnwindSafe(run));
        let left = app.take();
        match ended {
            Ok(Ok(())) => return Ok(()),
            // There is no screen for any renderer.
            Ok(Err(eframe::Error::WinitEventLoop(_))) => {
                return Err(ViewerError::Window("no display was found; start it on a desktop, or set DISPLAY or WAYLAND_DISPLAY".into()));
            }
            Ok(Err(error)) => reasons.push(format!("{renderer}: {error}")),
            Err(panic) if left.is_none() => resume_unwind(panic),
            Err(_) => reasons.push(format!("{renderer}: no surface to draw on")),
        }
        // Who has had a window does not get another.
        let Some(left) = left else { break };
        app.set(Some(left));
    }
    Err(ViewerError::Window(reasons.join("; ")))
}

fn options(renderer: Renderer) -> eframe::NativeOptions {
    let mut options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("Barnard")
            .with_app_id(NAME)
            .with_inner_size([1280.0, 800.0])
            .with_drag_and_drop(true),
        renderer,
        ..Default::default()
    };
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        // Egui asks for little; the march wants what the device has.
        setup.device_descriptor = Arc::new(barnard_gpu::device_descriptor);
    }
    options
}

/// The scene to begin with: the requested one, else the unsaved one of last time, else a built-in one; and
/// its message, if any.
fn begun(asked: Option<Document>, session: &mut Session, memory_limit: u64) -> barnard::Result<(Document, Option<String>)> {
    let first = || Document::builtin(barnard_files::builtin::SCENES[0].name, memory_limit);
    let Some(lost) = session.recovered() else { return Ok((asked.map_or_else(first, Ok)?, None)) };
    let title = format!("unsaved changes of {}", lost.origin.name());
    if let Some(document) = asked {
        return Ok((document, Some(format!("{title} exist: the explorer restores them when opened without a scene"))));
    }
    match Document::of(&lost.origin, memory_limit).and_then(|mut d| d.replace(&lost.text).map(|()| d)) {
        Ok(document) => {
            session.adopt(&lost);
            Ok((document, Some(format!("{title} were restored; Ctrl+Z reverts them"))))
        }
        Err(error) => Ok((first()?, Some(format!("{title} are in {}: {error}", lost.path.display())))),
    }
}

/// The device that pictures are rendered on: the window's, or one beside it where the window has none; none where
/// the processor does.
fn lent(state: Option<&RenderState>, device: DeviceUse, is_real: bool) -> Result<Option<Gpu>, GpuError> {
    let is_used = match device {
        DeviceUse::Never => false,
        DeviceUse::Always => true,
        DeviceUse::IfReal => is_real,
    };
    match state.filter(|_| is_used) {
        Some(state) => {
            let shared = Gpu::shared(&state.adapter, state.device.clone(), state.queue.clone());
            Ok(shared.filter(|gpu| gpu.adapter.real || device == DeviceUse::Always))
        }
        None => is_used.then(Gpu::open).transpose(),
    }
}
