//! The panels as pictures.

use barnard_viewer::app::App;
use eframe::egui::{Rect, Visuals, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::explorer::{open, settle, viewport};

/// One part of the window as it looked before, and how it looks now.
fn looks(harness: &mut Harness<App>, name: &str, rect: Rect) {
    let window = harness.render().unwrap();
    let part = image::imageops::crop_imm(&window, rect.left() as u32, rect.top() as u32, rect.width() as u32, rect.height() as u32);
    egui_kittest::image_snapshot(&part.to_image(), name);
}

/// The panels, as they look: but for what a clock says.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn panels_look_as_they_did() {
    let (_folder, mut harness) = open();
    let centre = viewport(&harness).center();
    harness.hover_at(centre);
    harness.step();
    harness.step();
    let from = |harness: &Harness<App>, label: &str| harness.get_by_label(label).rect().left_top() - vec2(20.0, 4.0);
    let left = Rect::from_min_size(from(&harness, "Spectra"), vec2(330.0, 240.0));
    looks(&mut harness, "spectra", left);
    let right = Rect::from_min_size(from(&harness, "Picture"), vec2(320.0, 105.0));
    looks(&mut harness, "picture", right);
    let method = Rect::from_min_size(from(&harness, "Method"), vec2(320.0, 116.0));
    looks(&mut harness, "method", method);
    // The probe stands further down.
    harness.set_size(vec2(1150.0, 1160.0));
    settle(&mut harness);
    let centre = viewport(&harness).center();
    harness.hover_at(centre);
    harness.run_steps(4);
    let probe = Rect::from_min_size(from(&harness, "Probe"), vec2(340.0, 290.0));
    looks(&mut harness, "probe", probe);
}

/// The window is cleared to the ground of its theme: panels do not fill it, and snapshots cannot see it.
#[test]
fn the_ground_is_that_of_the_theme() {
    let (_folder, harness) = open();
    for (visuals, grey) in [(Visuals::dark(), 27.0), (Visuals::light(), 248.0)] {
        let [red, green, blue, alpha] = eframe::App::clear_color(harness.state(), &visuals);
        assert!([red, green, blue].iter().all(|v| (v * 255.0 - grey).abs() < 0.01) && alpha == 1.0);
    }
}
