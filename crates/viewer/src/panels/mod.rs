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

use crate::command::{Command, Commands};
use crate::files::Purpose;
use crate::layout::{Guide, Side, WindowLayout};
use crate::model::Model;
use barnard_explorer::document::Origin;

pub use about::help;
pub use spectra::reveal;

/// Shows the menus on top.
pub fn menu(ui: &mut Ui, model: &Model, recent: &[Origin], commands: &mut Commands) {
    Panel::top("menu").frame(unfilled(ui)).show(ui, |ui| {
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| file_menu(ui, model, recent, commands));
            ui.menu_button("Edit", |ui| edit_menu(ui, model, commands));
            ui.menu_button("View", |ui| view_menu(ui, model, commands));
            if ui.button("Keys").on_hover_text("mouse and keys (F1)").clicked() {
                commands.lay_out(|layout| layout.help = !layout.help);
            }
            let mark = if model.document.is_changed() { "*" } else { "" };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                sides(ui, model, commands);
                ui.separator();
                ui.label(format!("{}{mark}", model.document.origin().name())).on_hover_text(&model.document.scene().description);
            });
        });
    });
}

/// Opens and closes the panels around the picture, the rightmost first.
fn sides(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let width = ui.ctx().content_rect().width();
    for (side, name) in [(Side::Picture, "Picture panel"), (Side::Scene, "Scene panel")] {
        if ui.selectable_label(model.layout.shows(side, width), name).clicked() {
            commands.lay_out(move |layout| layout.toggle(side, width));
        }
    }
    if ui.selectable_label(model.layout.timeline, "Timeline").on_hover_text("T").clicked() {
        commands.lay_out(|layout| layout.timeline = !layout.timeline);
    }
}

fn edit_menu(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    if ui.add_enabled(model.document.can_undo(), egui::Button::new("Undo").shortcut_text("Ctrl+Z")).clicked() {
        commands.push(Command::Undo);
    }
    if ui.add_enabled(model.document.can_redo(), egui::Button::new("Redo").shortcut_text("Ctrl+Shift+Z")).clicked() {
        commands.push(Command::Redo);
    }
}

fn view_menu(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    if ui.add(egui::Button::new("Frame all").shortcut_text("Home")).clicked() {
        commands.push(Command::FrameAll);
    }
    if ui.add(egui::Button::new("Visit").shortcut_text("V")).on_hover_text("play a flight into the cloud").clicked() {
        commands.push(Command::Visit);
    }
    let bookmarks: Vec<String> = model.document.scene().bookmarks.keys().cloned().collect();
    ui.add_enabled_ui(!bookmarks.is_empty(), |ui| {
        ui.menu_button("Bookmarks", |ui| {
            for name in &bookmarks {
                if ui.button(name).clicked() {
                    commands.push(Command::GoTo(name.clone()));
                }
            }
        });
    });
    let mut layout = model.layout.clone();
    let mut checkbox = |label: &str, field: fn(&mut WindowLayout) -> &mut bool| {
        if ui.checkbox(field(&mut layout), label).changed() {
            commands.lay_out(move |layout| *field(layout) = !*field(layout));
        }
    };
    checkbox("Stars and frame (M)", |layout| &mut layout.overlay);
    checkbox("Fill the window", |layout| &mut layout.fills);
    ui.menu_button("Frame guide (G)", |ui| {
        for guide in Guide::ALL {
            if ui.radio(model.layout.guide == guide, guide.name()).clicked() {
                commands.lay_out(move |layout| layout.guide = guide);
            }
        }
    });
    if ui.add(egui::Button::new("Full screen").shortcut_text("F11")).clicked() {
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::Fullscreen(true));
    }
    ui.horizontal(theme);
}

/// Choice of the theme.
fn theme(ui: &mut Ui) {
    ui.label("Theme");
    // Words: the embedded font has no sun and no moon.
    let mut theme = ui.ctx().options(|o| o.theme_preference);
    for (preference, name) in THEMES {
        if ui.selectable_value(&mut theme, preference, name).changed() {
            ui.ctx().set_theme(theme);
        }
    }
}

fn file_menu(ui: &mut Ui, model: &Model, recent: &[Origin], commands: &mut Commands) {
    let button = |ui: &mut Ui, text: &str, keys: &str| ui.add(egui::Button::new(text).shortcut_text(keys)).clicked();
    let is_film = model.document.scene().timeline.is_some();
    if button(ui, "Open …", "Ctrl+O") {
        commands.push(Command::Ask(Purpose::Open));
    }
    ui.menu_button("Open recent", |ui| {
        for origin in recent {
            if ui.button(origin.name()).clicked() {
                commands.push(Command::Open(origin.clone()));
            }
        }
    });
    ui.menu_button("Built-in scenes", |ui| builtins::show(ui, commands));
    ui.separator();
    if button(ui, "Save", "Ctrl+S") {
        commands.push(Command::Save);
    }
    if button(ui, "Save as …", "Ctrl+Shift+S") {
        commands.push(Command::Ask(Purpose::SaveScene));
    }
    if button(ui, "Save picture …", "Ctrl+E") {
        commands.push(Command::Ask(Purpose::SavePicture));
    }
    let film = ui.add_enabled(is_film, egui::Button::new("Save film …"));
    let film = film.on_hover_text("all frames of the timeline").on_disabled_hover_text("nothing changes yet: View, Visit makes a flight");
    if film.clicked() {
        commands.push(Command::Ask(Purpose::SaveFilm));
    }
    ui.separator();
    if button(ui, "Quit", "Ctrl+Q") {
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

/// The looks that the window may have.
const THEMES: [(egui::ThemePreference, &str); 3] =
    [(egui::ThemePreference::System, "system"), (egui::ThemePreference::Dark, "dark"), (egui::ThemePreference::Light, "light")];

/// Shows one line below: a message, for a while where it is no error, or how the picture came about.
pub fn status(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    Panel::bottom("status").frame(unfilled(ui)).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| match &model.notice {
            Some(notice) => {
                let colour = if notice.error { ui.visuals().error_fg_color } else { ui.visuals().text_color() };
                let close = ui.small_button("×").on_hover_text("close the message");
                ui.colored_label(colour, &notice.words);
                if close.clicked() {
                    commands.push(Command::CloseMessage);
                }
            }
            None => {
                let words = model.shown.as_ref().and_then(|s| s.pictures.first()).map_or_else(String::new, |p| {
                    let (w, h) = (p.image.width, p.image.height);
                    format!("{w} × {h} · {:.0} ms · {} · {}", 1e3 * p.times.all(), p.plan.spectral().method, p.backend)
                });
                ui.label(words);
                if let Some(words) = model.refining() {
                    ui.label(format!("· {words}"));
                }
                if let Some((stage, share)) = model.progress {
                    ui.label(format!("· {stage} {:.0} %", 100.0 * share));
                }
            }
        });
    });
}

/// Shows the timeline, where it is open.
pub fn bottom(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    if model.layout.timeline {
        Panel::bottom("timeline").frame(unfilled(ui)).show(ui, |ui| timeline::show(ui, model, commands));
    }
}

/// Spectra, and the tables of the scene.
pub fn left(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    if let Some(panel) = side(ui, model, Side::Scene, Panel::left("scene")) {
        panel.show(ui, |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| spectra::show(ui, model, commands));
        });
    }
}

/// Shows the panels at the right: picture, method, probe.
pub fn right(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    if let Some(panel) = side(ui, model, Side::Picture, Panel::right("picture")) {
        panel.show(ui, |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| {
                section(ui, "Picture", true, |ui| picture::show(ui, model, commands));
                section(ui, "Instrument", false, |ui| instrument::show(ui, model, commands));
                section(ui, "Method", true, |ui| method::show(ui, model, commands));
                section(ui, "Probe", true, |ui| probe::show(ui, model, commands));
            });
        });
    }
}

/// A panel beside the picture as wide as the window allows; none where it is closed.
fn side(ui: &Ui, model: &Model, side: Side, panel: Panel) -> Option<Panel> {
    let width = ui.ctx().content_rect().width();
    let (first, largest) = WindowLayout::widths(width);
    model.layout.shows(side, width).then(|| panel.default_size(first).max_size(largest).frame(unfilled(ui)))
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
    if value == 0.0 || (1e-2..1e5).contains(&value.abs()) { barnard_explorer::edit::rounded(value, 4) } else { format!("{value:.3e}") }
}
