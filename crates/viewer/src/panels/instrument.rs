//! Instrument and exposure time.

use barnard::instrument::PRESETS;
use eframe::egui::{self, Slider, SliderClamping, Ui};

use super::short;
use crate::command::{Command, Commands};
use crate::editor;
use crate::model::Model;
use barnard_explorer::comparison::With;
use barnard_explorer::edit::{Edit, significant};

/// Exposures of the slider \[s\].
const EXPOSURES: std::ops::RangeInclusive<f64> = 0.01..=36_000.0;

/// Shows the panel of the instrument.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let instrument = model.document.scene().instrument.clone();
    ui.horizontal(|ui| {
        let label = ui.label("instrument");
        let now = instrument.as_ref().map_or("none", |known| known.name.as_str());
        let combo = egui::ComboBox::from_id_salt("instrument").selected_text(now).width(180.0).show_ui(ui, |ui| {
            if ui.selectable_label(instrument.is_none(), "none").clicked() {
                commands.push(Edit::remove("", "instrument").with_name("instrument"));
            }
            for row in PRESETS {
                let hover = format!("{}\n{}", row.summary, row.source);
                if ui.selectable_label(row.name == now, row.name).on_hover_text(hover).clicked() {
                    commands.push(Edit::remove("", "instrument").and(Edit::set("instrument", "preset", row.name)).with_name("instrument"));
                }
            }
        });
        combo.response.labelled_by(label.id);
    });
    let Some(instrument) = instrument else { return };
    let mut recorded = model.comparison.with == With::Recorded;
    if ui.checkbox(&mut recorded, "as observed").on_hover_text("recorded image next to the original").changed() {
        commands.push(Command::Compare(if recorded { With::Recorded } else { With::Nothing }));
    }
    let mut exposure = instrument.exposure_s;
    let slider =
        ui.add(Slider::new(&mut exposure, EXPOSURES).logarithmic(true).clamping(SliderClamping::Never).suffix(" s").text("exposure"));
    if slider.changed() {
        commands.push(Edit::set("instrument", "exposure", format!("{} s", significant(exposure))).with_name("exposure time"));
    }
    let mut frames = instrument.frames as i64;
    let slider = ui.add(Slider::new(&mut frames, 1..=200).logarithmic(true).clamping(SliderClamping::Never).text("frames"));
    if slider.changed() {
        commands.push(Edit::set("instrument", "frames", frames).with_name("frames"));
    }
    if let Some(picture) = model.shown.as_ref().and_then(|shown| shown.pictures.get(1)).filter(|_| recorded) {
        for words in picture.recorded_bands() {
            ui.label(words);
        }
    }
    ui.weak(format!("{} m, {} m² of light gathered", short(instrument.aperture_m), short(instrument.area_m2())));
    editor::keys_but(ui, &model.document, "instrument", &["preset", "exposure", "frames", "psf"], commands);
}
