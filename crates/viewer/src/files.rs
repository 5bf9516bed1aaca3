//! The dialog for files: folders, scenes or pictures, a name.
//!
//! It is drawn by the explorer itself: it is the same everywhere, and needs no service of the desktop.

use std::path::{Path, PathBuf};

use barnard_files::bundle::EXTENSION;
use barnard_files::formats::numbered;
use eframe::egui::{self, Context, Key, ScrollArea, Ui};

use barnard_explorer::document::{Document, Origin};

/// The purpose for which a file is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A scene is to be read.
    Open,
    /// The scene is to be written.
    SaveScene,
    /// The picture is to be written.
    SavePicture,
    /// All frames are to be written.
    SaveFilm,
}

impl Purpose {
    fn title(self) -> &'static str {
        match self {
            Purpose::Open => "Open a scene",
            Purpose::SaveScene => "Save the scene",
            Purpose::SavePicture => "Save the picture",
            Purpose::SaveFilm => "Save the frames of the film",
        }
    }

    fn extensions(self) -> Vec<&'static str> {
        match self {
            Purpose::Open => vec!["toml", EXTENSION],
            Purpose::SaveScene => vec!["toml"],
            Purpose::SavePicture | Purpose::SaveFilm => barnard_files::formats::WRITERS.iter().map(|w| w.extension).collect(),
        }
    }
}

/// Sizes of pictures and films \[pixels\].
const SIZES: [(&str, (usize, usize)); 6] = [
    ("HD", (1280, 720)),
    ("Full HD", (1920, 1080)),
    ("4k UHD", (3840, 2160)),
    ("8k UHD", (7680, 4320)),
    ("square, 2k dome", (2048, 2048)),
    ("square, 4k dome", (4096, 4096)),
];

/// More entries of a folder than this are not listed.
const MAX: usize = 2000;

/// The dialog for files.
#[derive(Default)]
pub struct Files {
    asked: Option<Question>,
    /// The folder of the last file.
    folder: Option<PathBuf>,
}

struct Question {
    purpose: Purpose,
    folder: PathBuf,
    name: String,
    size: (usize, usize),
    /// Size of the scene's image \[pixels\].
    scene_size: (usize, usize),
    /// Number of the first frame of a film.
    first_frame: Option<i64>,
    entries: Vec<(String, bool)>,
    /// True if the dialog was shown yet.
    shown: bool,
    /// A file that is there already and that the user was asked about.
    replace: Option<PathBuf>,
}

impl Files {
    /// True if the dialog is open.
    pub fn is_open(&self) -> bool {
        self.asked.is_some()
    }

    /// Opens the dialog.
    pub fn ask(&mut self, purpose: Purpose, document: &Document) {
        let document_folder = match document.origin() {
            Origin::File(path) | Origin::Bundle(path) => path.parent().map(Path::to_owned),
            Origin::Builtin(_) | Origin::Text(_) => None,
        };
        let folder =
            self.folder.clone().or(document_folder).filter(|f| f.is_dir()).or_else(|| std::env::current_dir().ok()).unwrap_or_default();
        let stem = document.origin().name();
        let stem = stem.strip_suffix(".toml").or_else(|| stem.strip_suffix(".barnard")).unwrap_or(&stem);
        let name = match purpose {
            Purpose::Open => String::new(),
            Purpose::SaveScene => format!("{stem}.toml"),
            Purpose::SavePicture => format!("{stem}.png"),
            Purpose::SaveFilm => format!("{stem}_%04d.png"),
        };
        let camera = &document.scene().camera;
        let scene_size = (camera.width, camera.height);
        let frames = document.scene().timeline.as_ref().map(|timeline| timeline.frames);
        let first_frame = frames.filter(|_| purpose == Purpose::SaveFilm).map(|frames| frames.first);
        let mut asked =
            Question { purpose, folder, name, size: scene_size, scene_size, first_frame, entries: Vec::new(), shown: false, replace: None };
        asked.look();
        self.asked = Some(asked);
    }

    /// Shows it; returns the file once one is chosen, and the size of a picture.
    pub fn show(&mut self, ctx: &Context) -> Option<(Purpose, PathBuf, (usize, usize))> {
        let asked = self.asked.as_mut()?;
        let mut chosen = None;
        let modal = egui::Modal::new(egui::Id::unique("files")).show(ctx, |ui| {
            ui.set_width(520.0);
            ui.heading(asked.purpose.title());
            chosen = if asked.replace.is_some() { asked.confirm(ui) } else { asked.browse(ui) };
        });
        let done = (asked.purpose, asked.size);
        if let Some(answer) = chosen {
            let folder = asked.folder.clone();
            self.close(ctx);
            let path = answer?;
            self.folder = Some(folder);
            return Some((done.0, path, done.1));
        }
        if modal.should_close() {
            self.close(ctx);
        }
        None
    }

    /// Keys are the window's again from the next frame on, which comes at once.
    fn close(&mut self, ctx: &Context) {
        self.asked = None;
        ctx.memory_mut(egui::Memory::stop_text_input);
        ctx.request_repaint();
    }
}

/// A file; nothing where the user gave up.
type ChosenFile = Option<PathBuf>;

impl Question {
    /// Lists the folder: folders, then files that can be meant.
    fn look(&mut self) {
        let extensions = self.purpose.extensions();
        let known = |name: &str| Path::new(name).extension().is_some_and(|e| extensions.iter().any(|x| e.eq_ignore_ascii_case(x)));
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten().take(MAX);
        let mut entries: Vec<(String, bool)> = entries
            .map(|e| (e.file_name().to_string_lossy().into_owned(), e.path().is_dir()))
            .filter(|(name, folder)| !name.starts_with('.') && (*folder || known(name)))
            .collect();
        entries.sort_by_key(|(name, folder)| (!folder, name.to_lowercase()));
        self.entries = entries;
    }

    fn browse(&mut self, ui: &mut Ui) -> Option<ChosenFile> {
        let mut into = None;
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("the folder above").clicked() {
                into = self.folder.parent().map(Path::to_owned);
            }
            ui.label(self.folder.display().to_string());
        });
        let mut picked = false;
        ScrollArea::vertical().max_height(260.0).auto_shrink(false).show(ui, |ui| {
            for (name, folder) in &self.entries {
                let label = if *folder { format!("{name}/") } else { name.clone() };
                let entry = ui.selectable_label(*name == self.name, label);
                if *folder && entry.clicked() {
                    into = Some(self.folder.join(name));
                } else if entry.clicked() {
                    self.name.clone_from(name);
                }
                picked |= !folder && entry.double_clicked();
            }
        });
        if let Some(folder) = into {
            self.folder = folder;
            self.look();
        }
        ui.horizontal(|ui| {
            let label = ui.label("file");
            let edit = ui.add(egui::TextEdit::singleline(&mut self.name).desired_width(360.0)).labelled_by(label.id);
            if !std::mem::replace(&mut self.shown, true) {
                edit.request_focus();
            }
            picked |= edit.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        });
        if matches!(self.purpose, Purpose::SavePicture | Purpose::SaveFilm) {
            self.picture(ui);
        }
        let mut answer = None;
        ui.horizontal(|ui| {
            let verb = if self.purpose == Purpose::Open { "Open" } else { "Save" };
            picked |= ui.add_enabled(!self.name.is_empty(), egui::Button::new(verb)).clicked();
            if ui.button("Cancel").clicked() {
                answer = Some(None);
            }
        });
        if picked && !self.name.is_empty() {
            answer = self.pick();
        }
        answer
    }

    /// The size of a picture.
    fn picture(&mut self, ui: &mut Ui) {
        let most = barnard::camera::MAX_EDGE;
        ui.horizontal(|ui| {
            let label = ui.label("size");
            ui.add(egui::DragValue::new(&mut self.size.0).range(1..=most).suffix(" px")).labelled_by(label.id);
            ui.label("×");
            ui.add(egui::DragValue::new(&mut self.size.1).range(1..=most).suffix(" px")).labelled_by(label.id);
            ui.menu_button("sizes", |ui| {
                let scene = [("the scene's own", self.scene_size)];
                for (name, size) in scene.into_iter().chain(SIZES) {
                    if ui.button(format!("{} × {} {name}", size.0, size.1)).clicked() {
                        self.size = size;
                        ui.close();
                    }
                }
            });
        });
        ui.weak(format!("formats: .{}", self.purpose.extensions().join(", .")));
        if self.first_frame.is_some() {
            ui.weak("one file per frame; %04d stands for its number");
        }
    }

    /// The file that is named; a folder is gone into, a file that would be lost is asked about.
    fn pick(&mut self) -> Option<ChosenFile> {
        let mut path = self.folder.join(self.name.trim());
        if path.is_dir() {
            self.folder = path;
            self.name.clear();
            self.look();
            return None;
        }
        if self.purpose == Purpose::SaveScene && path.extension().is_none() {
            path.set_extension("toml");
        }
        let written = self.first_frame.and_then(|first| numbered(&path, first)).unwrap_or_else(|| path.clone());
        if self.purpose != Purpose::Open && written.exists() {
            self.replace = Some(path);
            return None;
        }
        Some(Some(path))
    }

    fn confirm(&mut self, ui: &mut Ui) -> Option<ChosenFile> {
        let path = self.replace.clone()?;
        ui.label(format!("{} is there already.", path.display()));
        let mut answer = None;
        ui.horizontal(|ui| {
            if ui.button("Replace").clicked() {
                answer = Some(Some(path));
            }
            if ui.button("Back").clicked() {
                self.replace = None;
            }
        });
        answer
    }
}
