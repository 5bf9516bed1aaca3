//! Probe of the pixel under the pointer: radiances in the units of the field, depth, and the whole spectrum.

use std::sync::Arc;

use barnard::image::Image;
use barnard::plan::Probe;
use eframe::egui::{self, Ui};
use egui_plot::{Line, Plot, PlotPoints, VLine};
use spectra::passband::Passband;
use spectra::sed::{MagnitudeSystem, zero_point};

use super::{band_colour, short, wavelength_colour};
use crate::app::App;
use crate::picture::Picture;

/// The number of wavelengths of the spectrum.
const SAMPLES: usize = 120;
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

/// The spectrum at a pixel of a picture, kept until the pointer or the picture moves.
pub struct Probed {
    image: Arc<Image>,
    pixel: (usize, usize),
    wavelengths_um: Vec<f64>,
    found: Result<Probe, String>,
}

/// Shows the panel of the probe.
pub fn show(ui: &mut Ui, app: &mut App) {
    let picture = app.shown.as_ref().and_then(|s| s.pictures.first());
    let (Some(picture), Some((x, y))) = (picture, app.viewport.pointer) else {
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
    let known = |p: &Probed| Arc::ptr_eq(&p.image, image) && p.pixel == (column, row);
    let probed = app.probed.take().filter(known).unwrap_or_else(|| probe(picture, (column, row)));
    spectrum(ui, &probed);
    app.probed = Some(probed);
}

/// The spectrum that reaches the eye there, without that of stars.
fn probe(picture: &Picture, pixel: (usize, usize)) -> Probed {
    let ends = picture.scene.bands.iter().map(Passband::support_um).fold((f64::MAX, 0.0f64), |(l, h), (a, b)| (l.min(a), h.max(b)));
    let wavelengths_um: Vec<f64> = (0..SAMPLES).map(|i| ends.0 + (ends.1 - ends.0) * i as f64 / (SAMPLES - 1) as f64).collect();
    let (column, row) = pixel;
    let ray = picture.plan.camera().ray(column as f64 + 0.5, row as f64 + 0.5);
    let found = picture.plan.probe(&picture.scene, &ray, &wavelengths_um).map_err(|e| e.to_string());
    Probed { image: picture.image.clone(), pixel, wavelengths_um, found }
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
