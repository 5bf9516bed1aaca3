//! Method panel: spectral integrals, error estimates, timing.

use eframe::egui::{self, Ui};

use super::short;
use crate::command::{Command, Commands};
use crate::editor;
use crate::model::Model;
use barnard_explorer::comparison::With;
use barnard_explorer::order::Refinement;

/// Shows the panel of the method.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    editor::keys(ui, &model.document, "method", commands);
    let mut finer = model.comparison.with == With::Finer;
    if ui.checkbox(&mut finer, "difference × 16").on_hover_text("error of the method against one twenty times finer, amplified").changed()
    {
        commands.push(Command::Compare(if finer { With::Finer } else { With::Nothing }));
    }
    let Some(shown) = &model.shown else { return };
    let Some(picture) = shown.pictures.first() else { return };
    if shown.quality < Refinement::Settled {
        ui.weak("preview: the error is measured when nothing changes");
    } else {
        for (b, band) in picture.image.bands.iter().enumerate() {
            let worst = picture.image.report.worst_words(&band.name);
            ui.label(format!("{}: {worst}", band.name)).on_hover_text(picture.image.band_words(b).join("\n"));
        }
        for (key, words) in picture.image.report.statements() {
            ui.label(format!("{key}: {words}"));
        }
    }
    if let (With::Finer, [picture, truth]) = (&model.comparison.with, &shown.pictures[..]) {
        for (b, band) in picture.image.bands.iter().enumerate() {
            ui.label(format!("{}: differs by {:.1e} (relative rms)", band.name, picture.image.relative_rmse(b, &truth.image, b)));
        }
    }
    let t = picture.times;
    let rays = (picture.image.width * picture.image.height) as f64;
    egui::Grid::new("times").num_columns(2).show(ui, |ui| {
        let rows = [("plan", t.plan), ("march", t.march), ("stars, certificates", t.stars), ("colours", t.colours), ("frame", t.all())];
        for (what, seconds) in rows {
            ui.label(what);
            ui.label(format!("{:.1} ms", 1e3 * seconds));
            ui.end_row();
        }
        ui.label("rays");
        ui.label(format!("{} /s, {} terms per sample", short(rays / t.march.max(1e-9)), picture.plan.spectral().terms()));
        ui.end_row();
        ui.label("plan's size");
        ui.label(format!("{} MiB", picture.plan.bytes() >> 20));
        ui.end_row();
        ui.label("back end");
        ui.label(&picture.backend);
        ui.end_row();
    });
}
