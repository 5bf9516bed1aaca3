//! Display of the picture: palette, stretch, black and white on the histogram, and what it is compared with.

use eframe::egui::{self, Color32, Ui};
use egui_plot::{Line, Plot, PlotPoints, VLine};

use super::{band_colour, short};
use crate::command::{Command, Commands};
use crate::editor;
use crate::model::Model;
use barnard_explorer::comparison::{Arrangement, With};
use barnard_explorer::edit::{Edit, numbers, significant};

/// Palettes that have a button of their own.
const BUTTONS: [(&str, &str); 3] = [("Natural", "natural"), ("SHO", "sho"), ("HOO", "hoo")];

/// Shows the panel of the picture.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    palettes(ui, model, commands);
    editor::keys_but(ui, &model.document, "display", &["matrix"], commands);
    matrix(ui, model, commands);
    ui.horizontal(|ui| {
        ui.label("exposure");
        if ui.button("−").on_hover_text("half a stop darker (-)").clicked() {
            commands.push(Command::Expose(-0.5));
        }
        if ui.button("+").on_hover_text("half a stop brighter (+)").clicked() {
            commands.push(Command::Expose(0.5));
        }
        if ui.button("Auto").on_hover_text("set black and white from this picture and keep them (0)").clicked() {
            commands.push(Command::ExposeAutomatically);
        }
    });
    histogram(ui, model, commands);
    super::section(ui, "Glare", false, |ui| editor::keys(ui, &model.document, "display.glare", commands));
    comparison(ui, model, commands);
}

fn palettes(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let bands = &model.document.scene().bands;
    ui.horizontal(|ui| {
        for (title, name) in BUTTONS {
            let palette = spectra::colour::Palette::by_name(name, bands);
            let words = match &palette {
                Ok(_) => spectra::colour::PALETTES.iter().find(|p| p.name == name).map_or("", |p| p.summary).to_owned(),
                Err(error) => error.to_string(),
            };
            let button = ui.add_enabled(palette.is_ok(), egui::Button::new(title));
            if button.on_hover_text(&words).on_disabled_hover_text(&words).clicked() {
                commands.push(Edit::remove("display", "matrix").and(Edit::set("display", "palette", name)).with_name("palette"));
            }
        }
        if ui.button("Matrix").on_hover_text("custom palette: red, green and blue of each band").clicked() {
            let columns = model.document.scene().display.palette.columns.iter().flatten().copied();
            commands.push(Edit::set("display", "matrix", numbers(columns)).and(Edit::remove("display", "palette")).with_name("palette"));
        }
    });
}

/// Red, green and blue of each band, where the palette is one's own.
fn matrix(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let scene = model.document.scene();
    if barnard_explorer::edit::table(model.document.toml().as_table(), "display").is_none_or(|t| !t.contains_key("matrix")) {
        return;
    }
    let mut columns = scene.display.palette.columns.clone();
    let mut changed = false;
    egui::Grid::new("matrix").num_columns(4).show(ui, |ui| {
        for (band, column) in scene.bands.iter().zip(&mut columns) {
            let label = ui.label(band.name());
            for (value, colour) in column.iter_mut().zip(["red", "green", "blue"]) {
                let before = *value;
                let drag = ui.add(editor::drag(value, 0.01)).labelled_by(label.id);
                changed |= editor::is_changed(&drag, before, *value);
                drag.on_hover_text(format!("{colour} of {}", band.name()));
            }
            ui.end_row();
        }
    });
    if changed {
        commands.push(Edit::set("display", "matrix", numbers(columns.into_iter().flatten())));
    }
}

/// Pixels of each band by radiance; black and white are dragged.
fn histogram(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let Some(picture) = model.shown.as_ref().and_then(|s| s.pictures.first()) else { return };
    let balanced = model.document.scene().display.balance;
    let (black, white) = (picture.tone.black, picture.tone.white);
    let plot = Plot::new("histogram")
        .height(110.0)
        .show_axes([true, false])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .x_axis_label("log10 radiance [W/m²/sr]")
        .include_y(0.0);
    let shown = plot.show(ui, |plot| {
        for (b, (band, histogram)) in picture.scene.bands.iter().zip(&picture.histograms).enumerate() {
            let (low, high) = histogram.range;
            let step = (high - low) / histogram.counts.len() as f64;
            let points = histogram.counts.iter().enumerate().map(|(i, n)| [low + (i as f64 + 0.5) * step, f64::from(*n).sqrt()]);
            let colour = band_colour(&picture.scene, b);
            plot.line(Line::new(band.name(), PlotPoints::from(points.collect::<Vec<_>>())).color(colour).fill(0.0).fill_alpha(0.1));
        }
        if !balanced {
            plot.vline(VLine::new("white", white.max(f64::MIN_POSITIVE).log10()).color(Color32::WHITE));
            if black > 0.0 {
                plot.vline(VLine::new("black", black.log10()).color(Color32::GRAY));
            }
        }
        plot.pointer_coordinate()
    });
    if balanced {
        ui.label(format!("white at {} of each band's", short(white)));
    } else {
        ui.label(format!("black {}, white {} W/m²/sr", short(black), short(white)))
            .on_hover_text("kept during changes; drag in the histogram for white, with Shift for black");
    }
    let (Some(at), true) = (shown.inner, shown.response.dragged() && !balanced) else { return };
    let level = significant(10f64.powf(at.x));
    let as_black = ui.input(|i| i.modifiers.shift);
    let edit = if as_black {
        Edit::set("display", "black", level.min(0.99 * white)).and(Edit::set("display", "white", significant(white)))
    } else {
        Edit::set("display", "white", level.max(significant(1.01 * black)))
    };
    commands.push(edit.with_name(if as_black { "black dragged" } else { "white dragged" }));
}

/// Shows what the picture is compared with.
fn comparison(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let now = match &model.comparison.with {
        With::Nothing => "nothing".to_owned(),
        With::Recorded => "as observed".to_owned(),
        With::Filters(set) => set.clone(),
        With::Finer => "a finer method".to_owned(),
    };
    let mut chosen = model.comparison.with.clone();
    ui.horizontal(|ui| {
        let label = ui.label("compare with");
        let combo = egui::ComboBox::from_id_salt("compare").selected_text(&now).width(150.0).show_ui(ui, |ui| {
            ui.selectable_value(&mut chosen, With::Nothing, "nothing");
            ui.selectable_value(&mut chosen, With::Recorded, "as observed").on_hover_text("image recorded by the scene's instrument");
            ui.selectable_value(&mut chosen, With::Finer, "a finer method").on_hover_text("error of the current method, amplified");
            for set in spectra::passband::SETS {
                ui.selectable_value(&mut chosen, With::Filters(set.name.to_owned()), set.name).on_hover_text(set.summary);
            }
        });
        combo.response.labelled_by(label.id);
    });
    if chosen != model.comparison.with {
        commands.push(Command::Compare(chosen));
    }
    if model.comparison.is_of_pictures() {
        ui.horizontal(|ui| {
            for (arrangement, name) in [(Arrangement::Wipe, "wipe"), (Arrangement::SideBySide, "side by side")] {
                if ui.radio(model.comparison.arrangement == arrangement, name).clicked() {
                    commands.push(Command::Arrange(arrangement));
                }
            }
        });
    }
}
