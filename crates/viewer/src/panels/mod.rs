//! The panels around the picture.

mod about;
mod builtins;
mod curves;
mod instrument;
mod method;
mod picture;
mod probe;
mod spectra;
mod timeline;

use barnard::scene::Scene;
use eframe::egui::{self, Color32, Frame, Panel, ScrollArea, Ui};

use crate::app::App;
use crate::editor::Edits;
use crate::files::Purpose;
use crate::viewport::Guide;

pub use about::help;
pub use probe::Probed;

/// The panels that are open.
pub struct Layout {
    /// Spectra and the scene, on the left.
    pub scene: bool,
    /// Picture, method and probe, on the right.
    pub picture: bool,
    /// The timeline, below.
    pub timeline: bool,
    /// True if the list of keys is open.
    pub help: bool,
    /// True if spectra are plotted in logarithms.
    pub logarithmic: bool,
}

impl Default for Layout {
    fn default() -> Self {
        Self { scene: true, picture: true, timeline: false, help: false, logarithmic: false }
    }
}

/// The name under which the layout is stored.
const KEY: &str = "layout";

impl Layout {
    /// The layout as it was when the last window closed.
    pub fn stored(storage: Option<&dyn eframe::Storage>) -> Self {
        let Some(text) = storage.and_then(|s| s.get_string(KEY)) else { return Self::default() };
        let on = |name: &str| text.split(' ').any(|word| word == name);
        Self { scene: on("scene"), picture: on("picture"), timeline: on("timeline"), help: false, logarithmic: on("logarithmic") }
    }

    /// Writes the layout down for the next time.
    pub fn save(&self, storage: &mut dyn eframe::Storage) {
        let open = [("scene", self.scene), ("picture", self.picture), ("timeline", self.timeline), ("logarithmic", self.logarithmic)];
        storage.set_string(KEY, open.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect::<Vec<_>>().join(" "));
    }
}

/// Shows the menus on top.
pub fn menu(ui: &mut Ui, app: &mut App) {
    Panel::top("menu").frame(unfilled(ui)).show(ui, |ui| {
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| file_menu(ui, app));
            ui.menu_button("Edit", |ui| {
                if ui.add_enabled(app.document.can_undo(), egui::Button::new("Undo").shortcut_text("Ctrl+Z")).clicked() {
                    app.step(false);
                }
                if ui.add_enabled(app.document.can_redo(), egui::Button::new("Redo").shortcut_text("Ctrl+Shift+Z")).clicked() {
                    app.step(true);
                }
            });
            ui.menu_button("View", |ui| {
                if ui.add(egui::Button::new("Frame all").shortcut_text("Home")).clicked() {
                    crate::viewport::frame(app);
                }
                let bookmarks: Vec<String> = app.document.scene().bookmarks.keys().cloned().collect();
                ui.add_enabled_ui(!bookmarks.is_empty(), |ui| {
                    ui.menu_button("Bookmarks", |ui| {
                        for name in &bookmarks {
                            if ui.button(name).clicked() {
                                app.go_to(name);
                            }
                        }
                    });
                });
                ui.checkbox(&mut app.viewport.overlay, "Stars and frame (M)");
                ui.checkbox(&mut app.layout.scene, "Scene panel");
                ui.checkbox(&mut app.layout.picture, "Picture panel");
                ui.checkbox(&mut app.layout.timeline, "Timeline (T)");
                ui.menu_button("Frame guide (G)", |ui| {
                    for guide in Guide::ALL {
                        ui.radio_value(&mut app.viewport.guide, guide, guide.name());
                    }
                });
                if ui.add(egui::Button::new("Full screen").shortcut_text("F11")).clicked() {
                    ui.ctx().send_viewport_cmd(egui::ViewportCommand::Fullscreen(true));
                }
                ui.horizontal(|ui| {
                    ui.label("Theme");
                    // Words: the embedded font has no sun and no moon.
                    let mut theme = ui.ctx().options(|o| o.theme_preference);
                    for (preference, name) in THEMES {
                        if ui.selectable_value(&mut theme, preference, name).changed() {
                            ui.ctx().set_theme(theme);
                        }
                    }
                });
            });
            if ui.button("Keys").on_hover_text("mouse and keys (F1)").clicked() {
                app.layout.help = !app.layout.help;
            }
            let mark = if app.document.is_changed() { "*" } else { "" };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(format!("{}{mark}", app.document.origin().name())).on_hover_text(&app.document.scene().description);
            });
        });
    });
}

fn file_menu(ui: &mut Ui, app: &mut App) {
    let button = |ui: &mut Ui, text: &str, keys: &str| ui.add(egui::Button::new(text).shortcut_text(keys)).clicked();
    if button(ui, "Open …", "Ctrl+O") {
        app.files.ask(Purpose::Open, &app.document);
    }
    ui.menu_button("Open recent", |ui| {
        for origin in app.session.recent.clone() {
            if ui.button(origin.name()).clicked() {
                app.open(&origin);
            }
        }
    });
    ui.menu_button("Built-in scenes", |ui| builtins::show(ui, app));
    ui.separator();
    if button(ui, "Save", "Ctrl+S") {
        app.save();
    }
    if button(ui, "Save as …", "Ctrl+Shift+S") {
        app.files.ask(Purpose::SaveScene, &app.document);
    }
    if button(ui, "Save picture …", "Ctrl+E") {
        app.files.ask(Purpose::SavePicture, &app.document);
    }
    ui.separator();
    if button(ui, "Quit", "Ctrl+Q") {
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

/// The looks that the window may have.
const THEMES: [(egui::ThemePreference, &str); 3] =
    [(egui::ThemePreference::System, "system"), (egui::ThemePreference::Dark, "dark"), (egui::ThemePreference::Light, "light")];

/// The time for which a message stays that is no error [s].
const NOTICE_SECONDS: f64 = 8.0;

/// Shows one line below: a message, for a while where it is no error, or how the picture came about.
pub fn status(ui: &mut Ui, app: &mut App) {
    let now = ui.input(|i| i.time);
    if let Some(notice) = app.notice.as_mut().filter(|notice| !notice.error) {
        let left = notice.since.get_or_insert(now).to_owned() + NOTICE_SECONDS - now;
        match left > 0.0 {
            true => ui.ctx().request_repaint_after_secs(left as f32),
            false => app.notice = None,
        }
    }
    Panel::bottom("status").frame(unfilled(ui)).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| match &app.notice {
            Some(notice) => {
                let colour = if notice.error { ui.visuals().error_fg_color } else { ui.visuals().text_color() };
                let close = ui.small_button("×").on_hover_text("close the message");
                ui.colored_label(colour, &notice.words);
                if close.clicked() {
                    app.notice = None;
                }
            }
            None => {
                let words = app.shown.as_ref().and_then(|s| s.pictures.first()).map_or_else(String::new, |p| {
                    let (w, h) = (p.image.width, p.image.height);
                    format!("{w} × {h} · {:.0} ms · {} · {}", 1e3 * p.times.all(), p.plan.spectral().method, p.backend)
                });
                ui.label(words);
                if let Some(words) = app.refining() {
                    ui.label(format!("· {words}"));
                }
            }
        });
    });
}

/// Shows the timeline, where it is open.
pub fn bottom(ui: &mut Ui, app: &mut App) {
    if app.layout.timeline {
        Panel::bottom("timeline").frame(unfilled(ui)).show(ui, |ui| timeline::show(ui, app));
    }
}

/// Spectra, and the tables of the scene.
pub fn left(ui: &mut Ui, app: &mut App, edits: &mut Edits) {
    if app.layout.scene {
        Panel::left("scene").default_size(330.0).frame(unfilled(ui)).show(ui, |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| spectra::show(ui, app, edits));
        });
    }
}

/// Shows the panels at the right: picture, method, probe.
pub fn right(ui: &mut Ui, app: &mut App, edits: &mut Edits) {
    if app.layout.picture {
        Panel::right("picture").default_size(330.0).frame(unfilled(ui)).show(ui, |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| {
                section(ui, "Picture", true, |ui| picture::show(ui, app, edits));
                section(ui, "Instrument", false, |ui| instrument::show(ui, app, edits));
                section(ui, "Method", true, |ui| method::show(ui, app, edits));
                section(ui, "Probe", true, |ui| probe::show(ui, app));
            });
        });
    }
}

/// The frame of a panel, whose ground stays as the window was cleared: each layer is shaded pixel by pixel.
fn unfilled(ui: &Ui) -> Frame {
    Frame::side_top_panel(ui.style()).fill(Color32::TRANSPARENT)
}

/// A part of a panel that can be closed.
fn section(ui: &mut Ui, title: &str, open: bool, contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(open).show(ui, contents);
}

/// Hues of wavelengths [nm], as curves are drawn in them: a plain ramp from violet to red.
const HUES: [(f64, f64); 7] = [(380.0, 0.78), (450.0, 0.64), (490.0, 0.5), (530.0, 0.36), (575.0, 0.17), (610.0, 0.07), (660.0, 0.0)];

/// The colour of a wavelength [nm] in plots.
fn wavelength_colour(nm: f64) -> egui::Color32 {
    let i = HUES.iter().rposition(|h| h.0 <= nm).unwrap_or(0).min(HUES.len() - 2);
    let (a, b) = (HUES[i], HUES[i + 1]);
    let hue = a.1 + ((nm - a.0) / (b.0 - a.0)).clamp(0.0, 1.0) * (b.1 - a.1);
    egui::ecolor::Hsva::new(hue as f32, 0.7, 0.95, 1.0).into()
}

/// The colour that a band has in the picture, as bright as a plot needs it.
fn band_colour(scene: &Scene, band: usize) -> egui::Color32 {
    let column = scene.display.palette.columns.get(band).copied().unwrap_or([1.0; 3]).map(|v| v.max(0.0));
    let brightest = column.into_iter().fold(0.0, f64::max);
    if brightest == 0.0 {
        return egui::Color32::GRAY;
    }
    let [r, g, b] = column.map(|v| (255.0 * ::spectra::colour::srgb_encode(v / brightest)).max(70.0) as u8);
    egui::Color32::from_rgb(r, g, b)
}

/// A number in the digits that a reader needs.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-2..1e5).contains(&value.abs()) { crate::edit::rounded(value, 4) } else { format!("{value:.3e}") }
}
