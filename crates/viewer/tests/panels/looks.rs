//! The panels as pictures.

use barnard_viewer::app::App;
use eframe::egui::accesskit::Role;
use eframe::egui::{Rect, Visuals, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::explorer::{open, settle, viewport};

/// One part of the window as it looked before, and how it looks now; and whether it can be read.
fn looks(harness: &mut Harness<App>, name: &str, rect: Rect) {
    let window = harness.render().unwrap();
    let part = image::imageops::crop_imm(&window, rect.left() as u32, rect.top() as u32, rect.width() as u32, rect.height() as u32);
    let part = part.to_image();
    is_legible(harness, name, rect, &part);
    egui_kittest::image_snapshot(&part, name);
}

/// Texts stand within the window, none over another, and are light enough on their ground (a contrast of 4.5, WCAG 2.1, 1.4.3).
fn is_legible(harness: &Harness<App>, name: &str, rect: Rect, part: &image::RgbaImage) {
    let window = harness.ctx.content_rect();
    let roles = [Role::Button, Role::CheckBox, Role::ComboBox, Role::DisclosureTriangle, Role::Label];
    let of_role = |role| {
        harness.query_all_by_role(role).map(|text| (text.accesskit_node().label().or(text.value()).unwrap_or_default(), text.rect()))
    };
    let texts: Vec<(String, Rect)> = roles.into_iter().flat_map(of_role).filter(|text| rect.intersects(text.1)).collect();
    assert!(texts.len() > 2, "{name}: {texts:?}");
    for (number, (text, place)) in texts.iter().enumerate() {
        assert!(window.contains_rect(*place), "{name}: {text} at {place} leaves the window");
        for (other, there) in &texts[number + 1..] {
            let shared = place.intersect(*there);
            assert!(shared.width() < 1.0 || shared.height() < 1.0, "{name}: {text} at {place} covers {other} at {there}");
        }
    }
    let luminance = |pixel: &image::Rgba<u8>| {
        let linear = [0, 1, 2].map(|i| (f64::from(pixel[i]) / 255.0).powf(2.2));
        0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    };
    let (dark, light) = part.pixels().map(luminance).fold((1.0f64, 0.0f64), |(dark, light), value| (dark.min(value), light.max(value)));
    assert!((light + 0.05) / (dark + 0.05) > 4.5, "{name}: {dark} {light}");
}

/// The panels, as they look: but for what a clock says.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn panels_are_legible_and_look_as_they_did() {
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
