//! Probe of the pixel under the pointer: radiances in the units of the field, depth, and the whole spectrum.

use eframe::egui::{self, Ui};
use egui_plot::{Line, Plot, PlotPoints, VLine};
use spectra::passband::Passband;
use spectra::sed::{MagnitudeSystem, zero_point};

use super::{band_colour, short, wavelength_colour};
use crate::command::{Command, Commands};
use crate::model::Model;
use barnard_explorer::probe::Probed;

/// Steradians of a square arcsecond.
const SQUARE_ARCSECOND: f64 = (std::f64::consts::PI / 648_000.0) * (std::f64::consts::PI / 648_000.0);

/// Mean radiance per frequency of a band radiance, at the band's pivot [MJy sr⁻¹]: I_ν = λ_p² / c · L / ∫ R dλ.
fn megajansky(band: &Passband, radiance: f64) -> f64 {
    let (pivot, width) = (1e-6 * band.pivot().0, 1e-6 * band.integrate(|_| 1.0));
    radiance / width * pivot * pivot / spectra::constants::SPEED_OF_LIGHT / 1e-20
}

/// The surface brightness of a radiance [mag arcsec⁻²].
fn magnitude(band: &Passband, radiance: f64, system: MagnitudeSystem) -> Option<f64> {
    let zero = zero_point(band, system).ok()?;
    (radiance > 0.0).then(|| -2.5 * (radiance * SQUARE_ARCSECOND / zero).log10())
}

/// Shows the panel of the probe.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let picture = model.shown.as_ref().and_then(|s| s.pictures.first());
    let (Some(picture), Some((x, y))) = (picture, model.pointer) else {
        ui.weak("hover over the picture");
        return;
    };
    let image = &picture.image;
    let (column, row) = ((x * image.width as f64) as usize, (y * image.height as f64) as usize);
    if column >= image.width || row >= image.height {
        return;
    }
    ui.label(format!("column {column}, row {row} of {} × {}", image.width, image.height));
    egui::Grid::new("probe").num_columns(5).striped(true).spacing([6.0, 3.0]).show(ui, |ui| {
        for title in ["", "W/m²/sr", "MJy/sr", "Vega", "AB"] {
            ui.strong(title);
        }
        ui.end_row();
        for (b, band) in picture.scene.bands.iter().enumerate() {
            let radiance = image.at(b, row, column);
            ui.colored_label(band_colour(&picture.scene, b), band.name());
            ui.monospace(format!("{radiance:.3e}"));
            ui.monospace(short(megajansky(band, radiance)));
            for system in [MagnitudeSystem::Vega, MagnitudeSystem::Ab] {
                ui.monospace(magnitude(band, radiance, system).map_or_else(String::new, |m| format!("{m:.2}")));
            }
            ui.end_row();
        }
    });
    ui.weak("Vega and AB in mag/arcsec²; MJy/sr at the pivot");
    match model.probed.as_ref().filter(|probed| probed.is_of(image, (column, row))) {
        Some(probed) => spectrum(ui, probed),
        None => {
            let probed = Probed::new(picture, (column, row));
            spectrum(ui, &probed);
            commands.push(Command::Keep(probed));
        }
    }
}

fn spectrum(ui: &mut Ui, probed: &Probed) {
    let probe = match &probed.found {
        Ok(probe) => probe,
        Err(words) => {
            ui.weak(words);
            return;
        }
    };
    ui.label(format!("optical depth {} at V", short(probe.depth)));
    let plot = Plot::new("probe spectrum")
        .height(150.0)
        .allow_scroll(false)
        .x_axis_label("wavelength [nm]")
        .y_axis_label("W/m²/sr/µm")
        .y_axis_formatter(|mark, _| if mark.value == 0.0 { "0".to_owned() } else { format!("{:.0e}", mark.value) })
        .include_y(0.0);
    plot.show(ui, |plot| {
        let line: Vec<[f64; 2]> = probed.wavelengths_um.iter().zip(&probe.continuum).map(|(l, v)| [1e3 * l, *v]).collect();
        plot.line(Line::new("continuum", PlotPoints::from(line)));
        for line in &probe.lines {
            let nm = 1e3 * line.lambda_um;
            plot.vline(VLine::new(format!("{nm:.1} nm: {:.2e} W/m²/sr", line.strength), nm).color(wavelength_colour(nm)));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A radiance of 3631 Jy a square arcsecond has magnitude zero, and is 3631e-6 MJy over an arcsecond's steradians.
    #[test]
    fn units_agree() {
        let band = Passband::by_name("johnson-V").unwrap();
        let radiance = zero_point(&band, MagnitudeSystem::Ab).unwrap() / SQUARE_ARCSECOND;
        assert!(magnitude(&band, radiance, MagnitudeSystem::Ab).unwrap().abs() < 1e-9);
        assert!((megajansky(&band, radiance) / (3631e-6 / SQUARE_ARCSECOND) - 1.0).abs() < 0.01);
        // Johnson V: AB − Vega = −0.02 to 0.02 (Blanton & Roweis 2007, table 1: 0.02).
        let vega = magnitude(&band, radiance, MagnitudeSystem::Vega).unwrap();
        assert!(vega.abs() < 0.05, "{vega}");
        assert_eq!(magnitude(&band, 0.0, MagnitudeSystem::Ab), None);
    }
}
