//! The explorer: a document, the view of it, the pictures that come, and the panels around them.

mod keys;
mod leaving;
mod ordering;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use barnard::cache::Cache;
use barnard::plan::Options;
use barnard::scene::RayTracer;
use eframe::egui::{self, Context, Key, Modifiers, TextureOptions, Ui, ViewportCommand};

use crate::command::{Command, Commands};
use crate::engine::Engine;
use crate::export::Export;
use crate::files::{Files, Purpose};
use crate::model::{Model, Shown};
use crate::panels;
use crate::session::Session;
use crate::timings::{Look, Timings};
use crate::viewport::{self, Viewport};
use barnard_explorer::document::{Document, Origin};
use leaving::Leaving;
use ordering::Ordered;

pub use ordering::first_look;

/// The window: its model, the engine that makes its pictures, and its dialogs.
pub struct App {
    /// The state that panels read.
    pub model: Model,
    /// The middle of the window.
    pub viewport: Viewport,
    /// The dialogs for files.
    pub files: Files,
    /// Recent files, what survives a crash.
    pub session: Session,
    /// A picture that is being written.
    pub export: Option<Export>,
    /// Most bytes that a plan may take.
    pub memory_limit: u64,
    /// A device that has the light of several stars go through gas, where that is faster.
    pub tracer: Option<Arc<dyn RayTracer>>,
    /// Cache of results between runs, if any.
    pub cache: Option<Arc<dyn Cache>>,
    /// Counter of window updates, if requested.
    pub timings: Option<Timings>,
    engine: Engine,
    /// The title over the window.
    title: String,
    /// True if something was typed into in the last frame.
    typing: bool,
    /// A command that waits until what was typed is taken.
    later: Option<(Modifiers, Key)>,
    ordered: Option<Ordered>,
    /// When something moved last [s of the context].
    moved: f64,
    /// When somebody changed something last \[s\]: gas that is known exactly now is no such change.
    changed: f64,
    /// True if what is asked for is another since gas is known exactly.
    has_exact_gas: bool,
    /// The wish that waits for an answer about unsaved changes.
    leaving: Option<Leaving>,
}

impl App {
    /// A window with `document`, whose pictures `engine` makes.
    pub fn new(document: Document, engine: Engine, session: Session, memory_limit: u64) -> Self {
        Self {
            model: Model::new(document),
            viewport: Viewport::default(),
            files: Files::default(),
            session,
            export: None,
            memory_limit,
            tracer: None,
            cache: None,
            timings: None,
            engine,
            title: String::new(),
            typing: false,
            later: None,
            ordered: None,
            moved: f64::NEG_INFINITY,
            changed: f64::NEG_INFINITY,
            has_exact_gas: false,
            leaving: None,
        }
    }

    /// True if the last picture is that of `barnard render`, of all that was asked for.
    pub fn is_settled(&self) -> bool {
        self.is_refined() && !self.model.document.is_rough()
    }

    /// True if the shown picture is the finest one of the last order.
    fn is_refined(&self) -> bool {
        let refined = |(o, s): (&Ordered, &Shown)| !o.moving && s.number == o.number && s.quality >= o.finest();
        self.ordered.as_ref().zip(self.model.shown.as_ref()).is_some_and(refined)
    }

    /// Opens another scene, if it is one; asks first where changes would be lost.
    pub fn open(&mut self, origin: &Origin) {
        match Document::of(origin, self.memory_limit) {
            Ok(document) if self.model.document.is_changed() => self.leaving = Some(Leaving::For(Box::new(document))),
            Ok(document) => self.take(document),
            Err(error) => self.model.complain(error),
        }
    }

    /// Puts another scene in place of this one.
    fn take(&mut self, document: Document) {
        self.model.take(document);
        self.session.opened(self.model.document.origin());
        self.session.forget_recovery();
    }

    /// Does a command.
    pub fn perform(&mut self, command: Command) {
        let model = &mut self.model;
        match command {
            Command::Edit(edit) => {
                model.apply(edit);
            }
            Command::Undo => model.step(false),
            Command::Redo => model.step(true),
            Command::Open(origin) => self.open(&origin),
            Command::Save => self.save(),
            Command::Ask(purpose) => self.files.ask(purpose, &model.document),
            Command::Compare(with) => model.comparison.with = with,
            Command::Arrange(arrangement) => model.comparison.arrangement = arrangement,
            Command::MoveEdge(edge) => model.comparison.edge = Some(edge),
            Command::Expose(stops) => model.expose(stops),
            Command::ExposeAutomatically => model.expose_automatically(),
            Command::Fly(change) => change(&mut model.flight),
            Command::FrameAll => model.frame_all(),
            Command::Visit => model.visit(),
            Command::Select(star) => model.selected = star,
            Command::SetBookmark(name) => model.set_bookmark(&name),
            Command::GoTo(name) => model.go_to(&name),
            Command::Seek(time) => model.seek(time),
            Command::Play => model.play(),
            Command::SetKey => model.set_key(),
            Command::DropKey => model.drop_key(),
            Command::KeysOfBookmarks => model.keys_of_bookmarks(),
            Command::Layout(change) => change(&mut model.layout),
            Command::Point(pointer) => model.pointer = pointer,
            Command::Keep(probed) => model.probed = Some(probed),
            Command::Tell(words) => model.tell(words),
            Command::CloseMessage => model.notice = None,
        }
    }

    /// Saves to the document's own file, or asks for one.
    pub fn save(&mut self) {
        match self.model.document.origin().clone() {
            Origin::File(path) => self.save_to(path),
            Origin::Builtin(_) | Origin::Bundle(_) | Origin::Text(_) => self.files.ask(Purpose::SaveScene, &self.model.document),
        }
    }

    /// Saves the scene to `path`.
    pub fn save_to(&mut self, path: PathBuf) {
        match self.model.document.save(&path) {
            Ok(()) => {
                self.session.opened(self.model.document.origin());
                self.session.forget_recovery();
                self.model.tell(format!("wrote {}", path.display()));
            }
            Err(error) => self.model.complain(error),
        }
    }

    /// Draws one frame of the window.
    pub fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.take_frames(&ctx);
        self.model.progress = self.engine.progress().filter(|_| !self.is_refined());
        self.take_drops(&ctx);
        self.tick(&ctx);
        let mut commands = Commands::default();
        if let Some(left) = self.model.age_notice(ctx.input(|i| i.time)) {
            ctx.request_repaint_after_secs(left as f32);
        }
        let full = is_full(&ctx);
        let model = &self.model;
        if !full || model.notice.is_some() {
            panels::status(ui, model, &mut commands);
        }
        if !full {
            panels::menu(ui, model, &self.session.recent, &mut commands);
            panels::bottom(ui, model, &mut commands);
            panels::left(ui, model, &mut commands);
            panels::right(ui, model, &mut commands);
        }
        egui::CentralPanel::no_frame().show(ui, |ui| viewport::show(ui, &mut self.viewport, &self.model, &mut commands));
        self.dialogs(&ctx);
        let asking = self.leaving.is_some() || self.files.is_open();
        self.model.clock.playing &= !asking;
        // In a slow frame something can be typed, taken and followed by more: keys of the frame in which a field is
        // left are its own.
        let typing = ctx.egui_wants_keyboard_input();
        if asking || std::mem::replace(&mut self.typing, typing) || typing {
            self.viewport.land();
        } else {
            self.keys(&ctx, &mut commands);
        }
        if !asking {
            self.menu_keys(&ctx, &mut commands);
        }
        for command in commands {
            self.perform(command);
        }
        let busy = ctx.input(|i| i.pointer.any_down() || i.key_down(Key::E) || i.smooth_scroll_delta() != egui::Vec2::ZERO);
        let is_quiet = !busy && !self.viewport.is_moving() && !self.model.clock.playing;
        if is_quiet {
            self.model.document.rest();
        }
        self.refine(&ctx, is_quiet);
        self.order(&ctx);
        self.time(&ctx);
        self.session.keep(&self.model.document, ctx.input(|i| i.time));
        let title = format!("{}{} · Barnard", self.model.document.origin().name(), if self.model.document.is_changed() { "*" } else { "" });
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        self.close(&ctx);
    }

    /// Has a scene that is known roughly found out exactly, once it was seen and nothing moves any more.
    fn refine(&mut self, ctx: &Context, is_quiet: bool) {
        let before = self.model.document.scene().clone();
        match self.model.document.take_refined() {
            Ok(true) => {
                self.has_exact_gas = true;
                self.model.after_change(&before);
            }
            Ok(false) => {}
            Err(error) => self.model.complain(error),
        }
        // The first picture does not share its processors: it shows the rough cloud, or that there is none.
        let has_looked = self.model.shown.is_some() || self.model.notice.as_ref().is_some_and(|notice| notice.error);
        if is_quiet && has_looked && self.model.document.is_rough() {
            let (ctx, refined) = (ctx.clone(), self.model.refined.clone());
            self.model.document.refine(self.tracer.clone(), self.cache.clone(), move |part| {
                let percent = part.map_or(0, |part| (100.0 * part.clamp(0.0, 1.0)) as u32);
                if refined.swap(percent, Ordering::Relaxed) != percent || part.is_none() {
                    ctx.request_repaint();
                }
            });
        }
    }

    /// Tells how often the window changes.
    fn time(&mut self, ctx: &Context) {
        let look = Look {
            shown: self.model.shown.as_ref().map(|shown| (shown.number, shown.quality)),
            size: self.viewport.pixels.unwrap_or_default(),
            moving: self.ordered.as_ref().is_none_or(|ordered| ordered.moving),
            settled: self.is_settled(),
            changed: self.changed,
        };
        let Some(timings) = &mut self.timings else { return };
        if let Some(words) = timings.frame(ctx.input(|i| i.time), look) {
            eprintln!("{words}");
        }
    }

    fn take_frames(&mut self, ctx: &Context) {
        let frames: Vec<_> = self.engine.frames().collect();
        for frame in frames {
            match frame.pictures {
                Ok(pictures) => {
                    let (mut textures, mut sparks) = self.model.shown.take().map_or_else(Default::default, |s| (s.textures, s.sparks));
                    textures.truncate(pictures.len());
                    for (i, picture) in pictures.iter().enumerate() {
                        let size = [picture.image.width, picture.image.height];
                        let image = egui::ColorImage::from_rgba_premultiplied(size, picture.colours.as_flattened());
                        match textures.get_mut(i) {
                            Some(texture) => texture.set(image, TextureOptions::LINEAR),
                            None => textures.push(ctx.load_texture(format!("picture {i}"), image, TextureOptions::LINEAR)),
                        }
                    }
                    let over = pictures.first().and_then(|picture| picture.sparks.as_ref());
                    let over = over.map(|sparks| egui::ColorImage::from_rgba_premultiplied(sparks.size, sparks.colours.as_flattened()));
                    match (over, &mut sparks) {
                        (Some(image), Some(texture)) => texture.set(image, TextureOptions::NEAREST),
                        (over, sparks) => *sparks = over.map(|image| ctx.load_texture("sparks", image, TextureOptions::NEAREST)),
                    }
                    self.model.shown = Some(Shown { number: frame.number, quality: frame.quality, pictures, textures, sparks });
                }
                Err(words) => self.model.complain(words),
            }
        }
    }

    /// Begins to save all frames of the scene.
    fn film(&self, path: &Path, size: (usize, usize), ctx: &Context) -> barnard::Result<Export> {
        let sequence = self.model.document.sequence(self.tracer.clone(), self.cache.clone())?;
        let options = Options::within(self.memory_limit).with_cache(self.cache.clone());
        Export::film(sequence, self.model.scene_as_shown().display.clone(), path, size, options, ctx)
    }

    fn take_drops(&mut self, ctx: &Context) {
        let dropped = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).next());
        if let Some(path) = dropped {
            self.open(&Origin::at(path));
        }
    }

    fn dialogs(&mut self, ctx: &Context) {
        if let Some((purpose, path, size)) = self.files.show(ctx) {
            match purpose {
                Purpose::Open => self.open(&Origin::at(path)),
                Purpose::SaveScene => self.save_to(path),
                Purpose::SavePicture | Purpose::SaveFilm if self.export.is_some() => {
                    self.model.complain("a picture or film is being saved; wait, or stop it");
                }
                Purpose::SaveFilm => match self.film(&path, size, ctx) {
                    Ok(export) => self.export = Some(export),
                    Err(error) => self.model.complain(error),
                },
                Purpose::SavePicture if self.model.document.is_rough() => {
                    let words = match self.model.document.failure() {
                        Some(failure) => format!("only a coarse cloud is available: {failure}"),
                        None => "the cloud is still coarse; save the picture once the status line no longer says so".into(),
                    };
                    self.model.complain(words);
                }
                Purpose::SavePicture => match Export::start(
                    &self.model.scene_as_shown(),
                    &path,
                    size,
                    Options::within(self.memory_limit).with_cache(self.cache.clone()),
                    ctx,
                ) {
                    Ok(export) => self.export = Some(export),
                    Err(error) => self.model.complain(error),
                },
            }
        }
        if let Some(export) = &mut self.export
            && let Some(done) = export.show(ctx)
        {
            let stopped = export.is_stopped();
            self.export = None;
            match done {
                Ok(words) => self.model.tell(words),
                Err(words) => {
                    // Whoever waited for the picture must hear that there is none.
                    if !stopped {
                        self.leaving = None;
                    }
                    self.model.complain(words);
                }
            }
        }
        panels::help(ctx, &mut self.model.layout.help);
        self.ask_before_leaving(ctx);
    }
}

/// True if the picture fills the screen, and no panel is shown.
fn is_full(ctx: &Context) -> bool {
    ctx.input(|i| i.viewport().fullscreen.unwrap_or(false))
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.ui(ui);
    }

    /// The ground of the panels, which do not fill it again.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.session.save(storage);
        self.model.layout.save(storage);
    }
}
