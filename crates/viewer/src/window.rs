//! The window itself.

use std::sync::Arc;

use barnard::Error;
use barnard_gpu::Gpu;
use eframe::egui::ViewportBuilder;
use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup};

use crate::app::App;
use crate::document::{Document, Origin};
use crate::engine::Engine;
use crate::panels::Layout;
use crate::session::Session;

/// What marches the rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backend {
    /// The processor.
    Cpu,
    /// The device that draws the window, whatever it is.
    Gpu,
    /// That device where it is a real one, otherwise the processor.
    Auto,
}

/// How the explorer begins.
#[derive(Debug, Clone)]
pub struct Start {
    /// The scene; the first built-in one, or what was not saved last time, if none.
    pub scene: Option<Origin>,
    /// What marches the rays.
    pub backend: Backend,
    /// Most bytes that a plan may take.
    pub memory_limit: u64,
}

/// Name of the application: its folder of settings, and its class among windows.
const NAME: &str = "barnard";

/// Opens the window and returns when it is closed.
///
/// # Errors
/// Where the scene cannot be read, and where there is no screen.
pub fn open(start: Start) -> barnard::Result<()> {
    // A scene that is wrong is told where the command was given.
    let document = start.scene.as_ref().map(|origin| Document::of(origin, start.memory_limit)).transpose()?;
    let mut options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("Barnard")
            .with_app_id(NAME)
            .with_inner_size([1280.0, 800.0])
            .with_drag_and_drop(true),
        wgpu_options: WgpuConfiguration::default(),
        ..Default::default()
    };
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        // Egui asks for little; the march wants what the device has.
        setup.device_descriptor = Arc::new(barnard_gpu::device_descriptor);
    }
    let made = eframe::run_native(NAME, options, Box::new(move |context| Ok(Box::new(app(context, document, &start)?))));
    made.map_err(|e| Error::Render(format!("no window can be opened: {e}; barnard render makes pictures without one")))
}

fn app(context: &eframe::CreationContext, document: Option<Document>, start: &Start) -> barnard::Result<App> {
    let mut session = Session::new(context.storage, eframe::storage_dir(NAME));
    let first = || Document::builtin(barnard::builtin::SCENES[0].name, start.memory_limit);
    let mut words = None;
    let document = match (document, session.recovered()) {
        (Some(document), None) => document,
        (Some(document), Some(lost)) => {
            words = Some(format!("changes of {} were not saved: barnard view without a scene brings them back", lost.origin.name()));
            document
        }
        (None, Some(lost)) => match Document::of(&lost.origin, start.memory_limit).and_then(|mut d| d.replace(&lost.text).map(|()| d)) {
            Ok(document) => {
                session.adopt(&lost);
                words = Some(format!("changes of {} that were not saved are back; Ctrl+Z takes them away", lost.origin.name()));
                document
            }
            Err(error) => {
                words = Some(format!("changes of {} that were not saved are in {}: {error}", lost.origin.name(), lost.path.display()));
                first()?
            }
        },
        (None, None) => first()?,
    };
    session.opened(document.origin());
    let gpu = context.wgpu_render_state.as_ref().and_then(|state| shared(state, start.backend));
    let wake = context.egui_ctx.clone();
    let engine = Engine::start(gpu, move || wake.request_repaint());
    let mut app = App::new(document, engine, session, start.memory_limit);
    app.layout = Layout::stored(context.storage);
    if let Some(words) = words {
        app.tell(words);
    }
    Ok(app)
}

/// The window's device, where it is to march.
fn shared(state: &RenderState, backend: Backend) -> Option<Gpu> {
    let gpu = Gpu::shared(&state.adapter, state.device.clone(), state.queue.clone())?;
    match backend {
        Backend::Cpu => None,
        Backend::Gpu => Some(gpu),
        Backend::Auto => gpu.adapter.real.then_some(gpu),
    }
}
