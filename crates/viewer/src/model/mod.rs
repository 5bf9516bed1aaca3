//! The model of the window: a document, the view of it and its pictures, which panels read and commands change.

mod moments;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use barnard::image::{Display, Level};
use barnard::scene::Scene;
use eframe::egui::TextureHandle;

use crate::layout::WindowLayout;
use barnard_explorer::clock::Clock;
use barnard_explorer::comparison::Comparison;
use barnard_explorer::document::Document;
use barnard_explorer::edit::Edit;
use barnard_explorer::flight::Flight;
use barnard_explorer::order::Refinement;
use barnard_explorer::picture::Picture;
use barnard_explorer::probe::Probed;

/// The time for which a message stays that is no error [s].
const NOTICE_SECONDS: f64 = 8.0;

/// The pictures that are shown.
pub struct Shown {
    /// The number of their order.
    pub number: u64,
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
    /// True if it reports an error.
    pub error: bool,
    /// When it was first shown [s of the window's clock].
    pub since: Option<f64>,
}

/// The state that panels read.
pub struct Model {
    /// The scene that is open.
    pub document: Document,
    /// The eye from which the scene is seen.
    pub flight: Flight,
    /// The moment that is shown of a scene that changes.
    pub clock: Clock,
    /// The comparison, where there is one.
    pub comparison: Comparison,
    /// The last pictures.
    pub shown: Option<Shown>,
    /// The message below, where there is one.
    pub notice: Option<Notice>,
    /// Open panels, and marks over the picture.
    pub layout: WindowLayout,
    /// The marked star, by its number in the scene.
    pub selected: Option<usize>,
    /// The place of the pointer in the picture, in parts of its width and height.
    pub pointer: Option<(f64, f64)>,
    /// The last spectrum of the probe.
    pub probed: Option<Probed>,
    /// The number of times that the levels of pictures were requested anew.
    pub exposure: u64,
    /// Progress of the exact gas solution \[%\].
    pub refined: Arc<AtomicU32>,
    /// Stage of the picture that is being refined, and its finished share \[1\].
    pub progress: Option<(&'static str, f32)>,
}

impl Model {
    /// The model of a document.
    pub fn new(document: Document) -> Self {
        Self {
            flight: Flight::of(document.scene()),
            document,
            clock: Clock::default(),
            comparison: Comparison::default(),
            shown: None,
            notice: None,
            layout: WindowLayout::default(),
            selected: None,
            pointer: None,
            probed: None,
            exposure: 0,
            refined: Arc::default(),
            progress: None,
        }
    }

    /// Puts another document in place of this one.
    pub fn take(&mut self, document: Document) {
        let (layout, exposure) = (self.layout.clone(), self.exposure + 1);
        *self = Self { layout, exposure, refined: self.refined.clone(), ..Self::new(document) };
    }

    /// Tells the user of an error.
    pub fn complain(&mut self, error: impl std::fmt::Display) {
        self.notice = Some(Notice { words: error.to_string(), error: true, since: None });
    }

    /// Shows a message to the user.
    pub fn tell(&mut self, words: impl Into<String>) {
        self.notice = Some(Notice { words: words.into(), error: false, since: None });
    }

    /// Removes a message that is no error once it was shown for a while; the time for which it stays \[s\].
    pub fn age_notice(&mut self, now: f64) -> Option<f64> {
        let notice = self.notice.as_mut().filter(|notice| !notice.error)?;
        let left = *notice.since.get_or_insert(now) + NOTICE_SECONDS - now;
        if left <= 0.0 {
            self.notice = None;
        }
        (left > 0.0).then_some(left)
    }

    /// Changes the document and reports errors; false if the change was rejected.
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

    /// Follows a change of the document.
    pub fn after_change(&mut self, before: &Scene) {
        let scene = self.document.scene();
        if scene.camera != before.camera {
            self.flight.take(scene, &scene.camera);
        }
        if self.notice.as_ref().is_some_and(|n| n.error) {
            self.notice = None;
        }
    }

    /// Goes to a bookmark of the scene.
    pub fn go_to(&mut self, name: &str) {
        let scene = self.document.scene().clone();
        match scene.bookmarks.get(name) {
            Some(camera) => self.flight.take(&scene, camera),
            None => self.tell(format!("bookmark {name} is not set; Ctrl+{name} sets it")),
        }
    }

    /// Sets a bookmark to the view.
    pub fn set_bookmark(&mut self, name: &str) {
        self.apply(self.flight.bookmark(name));
        self.tell(format!("bookmark {name} is set; it is saved with the scene"));
    }

    /// Takes the last edit back, or does it again.
    pub fn step(&mut self, again: bool) {
        let before = self.document.scene().clone();
        match if again { self.document.redo() } else { self.document.undo() } {
            Ok(()) => self.after_change(&before),
            Err(error) => self.complain(error),
        }
    }

    /// Shows the whole cloud.
    pub fn frame_all(&mut self) {
        let bounds = self.document.scene().densities().map(|density| density.bounds());
        if let Some(bounds) = bounds.reduce(|a, b| a.union(&b)) {
            self.flight.frame(&bounds);
        }
    }

    /// Makes the picture brighter by `stops`, from the white it has now.
    pub fn expose(&mut self, stops: f64) {
        let Some(white) = self.shown.as_ref().and_then(|s| s.pictures.first()).map(|p| p.tone.white) else { return };
        let white = match self.document.scene().display.white {
            Level::Radiance(white) => white,
            Level::Auto => white,
        };
        self.apply(Edit::set("display", "white", barnard_explorer::edit::significant(white * (-stops).exp2())).with_name("exposure"));
    }

    /// Black and white as the picture that is shown asks for.
    pub fn expose_automatically(&mut self) {
        self.exposure += 1;
        self.apply(Edit::remove("display", "white").and(Edit::remove("display", "black")).with_name("automatic exposure"));
    }

    /// The scene with the levels that its picture has in the window.
    pub fn scene_as_shown(&self) -> Scene {
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
        Scene::clone(scene).with_display(display).with_camera(camera)
    }

    /// Writes the picture as it is shown into the working folder, under a name that is not taken.
    pub fn screenshot(&mut self) {
        let Some(picture) = self.shown.as_ref().and_then(|shown| shown.pictures.first()) else { return };
        let name = self.document.scene().name.replace(|c: char| !c.is_alphanumeric(), "_");
        let free = (1..10_000).map(|n| PathBuf::from(format!("{name}_{n:04}.png"))).find(|path| !path.exists());
        let Some(path) = free else { return self.complain("this folder has ten thousand screenshots; move some away") };
        let pixels: Vec<u8> = picture.colours.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
        let size = (picture.image.width, picture.image.height);
        let written = barnard_files::formats::encode_png(size, &pixels, &picture.image.statements())
            .and_then(|bytes| barnard_files::formats::replace(&path, &bytes));
        match written {
            Ok(()) => self.tell(format!("wrote {}", std::path::absolute(&path).unwrap_or(path).display())),
            Err(error) => self.complain(error),
        }
    }

    /// Notes of a rough scene.
    pub fn refining(&self) -> Option<String> {
        self.document.is_rough().then(|| match self.document.failure() {
            Some(_) => "coarse cloud".into(),
            None => format!("coarse cloud, {} % of the exact one done", self.refined.load(Ordering::Relaxed)),
        })
    }
}
