//! The explorer: a document, the view of it, the pictures that come, and the panels around them.

mod keys;
mod leaving;
mod moments;
mod ordering;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use barnard::image::{Display, Level};
use barnard::scene::{RayTracer, Scene};
use eframe::egui::{self, Context, Key, Modifiers, TextureHandle, TextureOptions, Ui, ViewportCommand};

use crate::clock::Clock;
use crate::comparison::Comparison;
use crate::document::{Document, Origin};
use crate::edit::Edit;
use crate::editor::Edits;
use crate::engine::Engine;
use crate::export::Export;
use crate::files::{Files, Purpose};
use crate::flight::Flight;
use crate::order::Refinement;
use crate::panels;
use crate::picture::Picture;
use crate::session::Session;
use crate::timings::{Look, Timings};
use crate::viewport::Viewport;
use leaving::Leaving;
use ordering::Ordered;

pub use ordering::first_look;

/// The pictures that are shown.
pub struct Shown {
    /// The number of their order.
    number: u64,
    /// The quality that they have reached.
    pub quality: Refinement,
    /// The scene's picture, and what it is compared with.
    pub pictures: Vec<Picture>,
    /// Their colours as textures.
    pub textures: Vec<TextureHandle>,
    /// Stars over the first of them, where it has none of its own.
    pub sparks: Option<TextureHandle>,
}

/// A message to the user.
pub struct Notice {
    /// The words of the message.
    pub words: String,
    /// True if it tells that something went wrong.
    pub error: bool,
    /// When it was first shown [s of the window's clock].
    pub since: Option<f64>,
}

/// The state of the whole window.
pub struct App {
    /// The scene that is open.
    pub document: Document,
    /// The eye from which the scene is seen.
    pub flight: Flight,
    /// The comparison, where there is one.
    pub comparison: Comparison,
    /// The last pictures.
    pub shown: Option<Shown>,
    /// The message below, where there is one.
    pub notice: Option<Notice>,
    /// The middle of the window.
    pub viewport: Viewport,
    /// The dialogs for files.
    pub files: Files,
    /// Recent files, what survives a crash.
    pub session: Session,
    /// A picture that is being written.
    pub export: Option<Export>,
    /// The moment that is shown of a scene that changes.
    pub clock: Clock,
    /// The panels that are open.
    pub layout: panels::Layout,
    /// Most bytes that a plan may take.
    pub memory_limit: u64,
    /// The spectrum that the probe saw last.
    pub probed: Option<panels::Probed>,
    /// A device that has the light of several stars go through gas, where that is faster.
    pub tracer: Option<Arc<dyn RayTracer>>,
    /// Counter of window updates, if requested.
    pub timings: Option<Timings>,
    /// The number of times that the levels of pictures were asked for anew.
    exposure: u64,
    engine: Engine,
    /// The title over the window.
    title: String,
    /// True if something was typed into in the last frame.
    typing: bool,
    /// A command that waits until what was typed is taken.
    later: Option<(Modifiers, Key)>,
    ordered: Option<Ordered>,
    /// Progress of the exact gas solution \[%\].
    refined: Arc<AtomicU32>,
    /// When something moved last [s of the context].
    moved: f64,
    /// When somebody changed something last \[s\]: gas that is known exactly now is no such change.
    changed: f64,
    /// True if what is asked for is another since gas is known exactly.
    is_refined: bool,
    /// The wish that waits for an answer about unsaved changes.
    leaving: Option<Leaving>,
}

impl App {
    /// A window with `document`, whose pictures `engine` makes.
    pub fn new(document: Document, engine: Engine, session: Session, memory_limit: u64) -> Self {
        Self {
            flight: Flight::of(document.scene()),
            document,
            comparison: Comparison::default(),
            shown: None,
            notice: None,
            viewport: Viewport::default(),
            files: Files::default(),
            session,
            export: None,
            clock: Clock::default(),
            layout: panels::Layout::default(),
            memory_limit,
            probed: None,
            tracer: None,
            timings: None,
            exposure: 0,
            engine,
            title: String::new(),
            typing: false,
            later: None,
            ordered: None,
            refined: Arc::default(),
            moved: f64::NEG_INFINITY,
            changed: f64::NEG_INFINITY,
            is_refined: false,
            leaving: None,
        }
    }

    /// Tells the user of an error.
    pub fn complain(&mut self, error: impl std::fmt::Display) {
        self.notice = Some(Notice { words: error.to_string(), error: true, since: None });
    }

    /// Shows a message to the user.
    pub fn tell(&mut self, words: impl Into<String>) {
        self.notice = Some(Notice { words: words.into(), error: false, since: None });
    }

    /// True if the last picture is that of `barnard render`, of all that was asked for.
    pub fn is_settled(&self) -> bool {
        let settled = |(o, s): (&Ordered, &Shown)| !o.moving && s.number == o.number && s.quality == Refinement::Settled;
        self.ordered.as_ref().zip(self.shown.as_ref()).is_some_and(settled) && !self.document.is_rough()
    }

    /// Changes the document, and tells what is wrong with the change; false where it was not made.
    pub fn apply(&mut self, edit: Edit) -> bool {
        let before = self.document.scene().clone();
        match self.document.apply(edit) {
            Ok(()) => {
                self.after_change(&before);
                true
            }
            Err(error) => {
                self.complain(error);
                false
            }
        }
    }

    fn after_change(&mut self, before: &barnard::scene::Scene) {
        let scene = self.document.scene();
        if scene.camera != before.camera {
            self.flight.take(scene, &scene.camera);
        }
        if self.notice.as_ref().is_some_and(|n| n.error) {
            self.notice = None;
        }
    }

    /// Goes to a bookmark of the scene; false where there is none.
    pub fn go_to(&mut self, bookmark: &str) -> bool {
        let scene = self.document.scene().clone();
        let Some(camera) = scene.bookmarks.get(bookmark) else { return false };
        self.flight.take(&scene, camera);
        true
    }

    /// Takes the last edit back, or does it again.
    pub fn step(&mut self, again: bool) {
        let before = self.document.scene().clone();
        match if again { self.document.redo() } else { self.document.undo() } {
            Ok(()) => self.after_change(&before),
            Err(error) => self.complain(error),
        }
    }

    /// Opens another scene, if it is one; asks first where changes would be lost.
    pub fn open(&mut self, origin: &Origin) {
        match Document::of(origin, self.memory_limit) {
            Ok(document) if self.document.is_changed() => self.leaving = Some(Leaving::For(Box::new(document))),
            Ok(document) => self.take(document),
            Err(error) => self.complain(error),
        }
    }

    /// Puts another scene in place of this one.
    fn take(&mut self, document: Document) {
        self.flight = Flight::of(document.scene());
        self.clock = Clock::default();
        self.document = document;
        self.exposure += 1;
        self.comparison = Comparison::default();
        self.shown = None;
        self.notice = None;
        self.session.opened(self.document.origin());
        self.session.forget_recovery();
    }

    /// Saves to the document's own file, or asks for one.
    pub fn save(&mut self) {
        match self.document.origin().clone() {
            Origin::File(path) => self.save_to(path),
            Origin::Builtin(_) => self.files.ask(Purpose::SaveScene, &self.document),
        }
    }

    /// Saves the scene to `path`.
    pub fn save_to(&mut self, path: PathBuf) {
        match self.document.save(&path) {
            Ok(()) => {
                self.session.opened(self.document.origin());
                self.session.forget_recovery();
                self.tell(format!("wrote {}", path.display()));
            }
            Err(error) => self.complain(error),
        }
    }

    /// Makes the picture brighter by `stops`, from the white it has now.
    pub fn expose(&mut self, stops: f64) {
        let Some(white) = self.shown.as_ref().and_then(|s| s.pictures.first()).map(|p| p.tone.white) else { return };
        let white = match self.document.scene().display.white {
            Level::Radiance(white) => white,
            Level::Auto => white,
        };
        self.apply(Edit::set("display", "white", crate::edit::significant(white * (-stops).exp2())).with_name("exposure"));
    }

    /// Black and white as the picture that is shown asks for.
    pub fn expose_automatically(&mut self) {
        self.exposure += 1;
        self.apply(Edit::remove("display", "white").and(Edit::remove("display", "black")).with_name("automatic exposure"));
    }

    /// The scene with the levels that its picture has in the window.
    fn scene_as_shown(&self) -> Scene {
        let scene = self.document.scene();
        let tone = self.shown.as_ref().and_then(|s| s.pictures.first()).map(|picture| &picture.tone);
        let display = tone.map_or_else(
            || scene.display.clone(),
            |tone| Display {
                palette: tone.palette.clone(),
                balance: false,
                stretch: tone.stretch,
                black: Level::Radiance(tone.black),
                white: Level::Radiance(tone.white),
                ..scene.display.clone()
            },
        );
        // A view that no text says is one of the window alone.
        let camera = if self.document.moves_camera() { self.flight.camera.clone() } else { scene.camera.clone() };
        Scene { display, camera, ..(**scene).clone() }
    }

    /// Draws one frame of the window.
    pub fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.take_frames(&ctx);
        self.take_drops(&ctx);
        self.tick(&ctx);
        let mut edits = Edits::new();
        let full = self.is_full(&ctx);
        if !full || self.notice.is_some() {
            panels::status(ui, self);
        }
        if !full {
            panels::menu(ui, self);
            panels::bottom(ui, self);
            panels::left(ui, self, &mut edits);
            panels::right(ui, self, &mut edits);
        }
        egui::CentralPanel::no_frame().show(ui, |ui| crate::viewport::show(ui, self, &mut edits));
        self.dialogs(&ctx);
        let asking = self.leaving.is_some() || self.files.is_open();
        self.clock.playing &= !asking;
        // In a slow frame something can be typed, taken and followed by more: keys of the frame in which a field is
        // left are its own.
        let typing = ctx.egui_wants_keyboard_input();
        if asking || std::mem::replace(&mut self.typing, typing) || typing {
            self.viewport.land();
        } else {
            self.keys(&ctx);
        }
        for edit in edits {
            self.apply(edit);
        }
        if !asking {
            self.commands(&ctx);
        }
        let busy = ctx.input(|i| i.pointer.any_down() || i.key_down(Key::E) || i.smooth_scroll_delta() != egui::Vec2::ZERO);
        let is_quiet = !busy && !self.viewport.is_moving() && !self.clock.playing;
        if is_quiet {
            self.document.rest();
        }
        self.refine(&ctx, is_quiet);
        self.order(&ctx);
        self.time(&ctx);
        self.session.keep(&self.document, ctx.input(|i| i.time));
        let title = format!("{}{} · Barnard", self.document.origin().name(), if self.document.is_changed() { "*" } else { "" });
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        self.close(&ctx);
    }

    /// Writes the picture as it is shown into the working folder, under a name that is not taken.
    fn screenshot(&mut self) {
        let Some(picture) = self.shown.as_ref().and_then(|shown| shown.pictures.first()) else { return };
        let name = self.document.scene().name.replace(|c: char| !c.is_alphanumeric(), "_");
        let free = (1..10_000).map(|n| PathBuf::from(format!("{name}_{n:04}.png"))).find(|path| !path.exists());
        let Some(path) = free else { return self.complain("this folder has ten thousand screenshots; move some away") };
        let pixels: Vec<u8> = picture.colours.iter().flat_map(|c| [c.r(), c.g(), c.b()]).collect();
        let size = (picture.image.width, picture.image.height);
        let written = barnard_files::formats::encode_png(size, &pixels, &picture.image.statements())
            .and_then(|bytes| barnard_files::formats::replace(&path, &bytes));
        match written {
            Ok(()) => self.tell(format!("wrote {}", std::path::absolute(&path).unwrap_or(path).display())),
            Err(error) => self.complain(error),
        }
    }

    /// True if the picture fills the screen, and no panel is shown.
    fn is_full(&self, ctx: &Context) -> bool {
        ctx.input(|i| i.viewport().fullscreen.unwrap_or(false))
    }

    /// Has a scene that is known roughly found out exactly, once it was seen and nothing moves any more.
    fn refine(&mut self, ctx: &Context, is_quiet: bool) {
        let before = self.document.scene().clone();
        match self.document.take_refined() {
            Ok(true) => {
                self.is_refined = true;
                self.after_change(&before);
            }
            Ok(false) => {}
            Err(error) => self.complain(error),
        }
        // The first picture does not share its processors: it shows the rough cloud, or that there is none.
        let has_looked = self.shown.is_some() || self.notice.as_ref().is_some_and(|notice| notice.error);
        if is_quiet && has_looked && self.document.is_rough() {
            let (ctx, refined) = (ctx.clone(), self.refined.clone());
            self.document.refine(self.tracer.clone(), move |part| {
                let percent = part.map_or(0, |part| (100.0 * part.clamp(0.0, 1.0)) as u32);
                if refined.swap(percent, Ordering::Relaxed) != percent || part.is_none() {
                    ctx.request_repaint();
                }
            });
        }
    }

    /// Notes of a rough scene.
    pub fn refining(&self) -> Option<String> {
        self.document.is_rough().then(|| match self.document.failure() {
            Some(_) => "coarse cloud".into(),
            None => format!("coarse cloud, {} % of the exact one done", self.refined.load(Ordering::Relaxed)),
        })
    }

    /// Tells how often the window changes.
    fn time(&mut self, ctx: &Context) {
        let look = Look {
            shown: self.shown.as_ref().map(|shown| (shown.number, shown.quality)),
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
                    let (mut textures, mut sparks) = self.shown.take().map_or_else(Default::default, |s| (s.textures, s.sparks));
                    textures.truncate(pictures.len());
                    for (i, picture) in pictures.iter().enumerate() {
                        let size = [picture.image.width, picture.image.height];
                        let image = egui::ColorImage::new(size, picture.colours.to_vec());
                        match textures.get_mut(i) {
                            Some(texture) => texture.set(image, TextureOptions::LINEAR),
                            None => textures.push(ctx.load_texture(format!("picture {i}"), image, TextureOptions::LINEAR)),
                        }
                    }
                    let over = pictures.first().and_then(|picture| picture.sparks.clone());
                    match (over, &mut sparks) {
                        (Some(image), Some(texture)) => texture.set(image, TextureOptions::NEAREST),
                        (over, sparks) => *sparks = over.map(|image| ctx.load_texture("sparks", image, TextureOptions::NEAREST)),
                    }
                    self.shown = Some(Shown { number: frame.number, quality: frame.quality, pictures, textures, sparks });
                }
                Err(words) => self.complain(words),
            }
        }
    }

    fn take_drops(&mut self, ctx: &Context) {
        let dropped = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).next());
        if let Some(path) = dropped {
            self.open(&Origin::File(path));
        }
    }

    fn dialogs(&mut self, ctx: &Context) {
        if let Some((purpose, path, size)) = self.files.show(ctx) {
            match purpose {
                Purpose::Open => self.open(&Origin::File(path)),
                Purpose::SaveScene => self.save_to(path),
                Purpose::SavePicture if self.document.is_rough() => {
                    let words = match self.document.failure() {
                        Some(failure) => format!("only a coarse cloud is available: {failure}"),
                        None => "the cloud is still coarse; save the picture once the status line no longer says so".into(),
                    };
                    self.complain(words);
                }
                Purpose::SavePicture if self.export.is_some() => self.complain("a picture is being saved; wait, or stop it"),
                Purpose::SavePicture => match Export::start(&self.scene_as_shown(), &path, size, self.memory_limit, ctx) {
                    Ok(export) => self.export = Some(export),
                    Err(error) => self.complain(error),
                },
            }
        }
        if let Some(export) = &mut self.export
            && let Some(done) = export.show(ctx)
        {
            let stopped = export.is_stopped();
            self.export = None;
            match done {
                Ok(words) => self.tell(words),
                Err(words) => {
                    // Whoever waited for the picture must hear that there is none.
                    if !stopped {
                        self.leaving = None;
                    }
                    self.complain(words);
                }
            }
        }
        panels::help(ctx, &mut self.layout.help);
        self.ask_before_leaving(ctx);
    }
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
        self.layout.save(storage);
    }
}
