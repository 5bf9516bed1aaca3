//! Display levels of the picture.

use std::sync::Arc;

use barnard::image::Level;
use barnard_viewer::app::App;
use eframe::egui::accesskit::Role;
use eframe::egui::vec2;
use eframe::egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::explorer::{drag, open, settle, viewport};

/// Brighter is a lower white; automatic takes it away again.
#[test]
fn exposure_is_written() {
    let (_folder, mut harness) = open();
    let white = harness.state().model.shown.as_ref().unwrap().pictures[0].tone.white;
    harness.key_press(Key::Plus);
    settle(&mut harness);
    let tone = &harness.state().model.shown.as_ref().unwrap().pictures[0].tone;
    assert!((tone.white / white - 0.5f64.sqrt()).abs() < 1e-4, "{} {white}", tone.white);
    harness.get_by_role_and_label(Role::Button, "Auto").click();
    settle(&mut harness);
    assert!(!harness.state().model.document.text().contains("white"));
}

/// White is dragged on the histogram, black with Shift; the picture follows without a new march.
#[test]
fn levels_are_dragged() {
    let (_folder, mut harness) = open();
    let picture = |h: &Harness<App>| h.state().model.shown.as_ref().unwrap().pictures[0].clone();
    let before = picture(&harness);
    let (white, below) = (before.tone.white, harness.get_by_label_contains("black 0, white").rect());
    let place = |part: f32| below.left_top() + vec2(310.0 * part, -60.0);
    drag(&mut harness, PointerButton::Primary, place(0.3), place(0.5));
    settle(&mut harness);
    let after = picture(&harness);
    assert!(Arc::ptr_eq(&after.image, &before.image) && after.tone.white < 0.5 * white && after.colours != before.colours);
    assert_eq!(harness.state().model.document.scene().display.white, Level::Radiance(after.tone.white));
    harness.event(Event::ModifiersChanged(Modifiers::SHIFT));
    drag(&mut harness, PointerButton::Primary, place(0.3), place(0.2));
    settle(&mut harness);
    let darker = picture(&harness);
    assert!(darker.tone.black > 0.0 && darker.tone.black < darker.tone.white, "{:?}", darker.tone);
}

/// Levels stay where the first settled picture had them while the view turns and a star grows brighter: what changes is
/// what is seen.
#[test]
fn levels_are_held() {
    let (_folder, mut harness) = open();
    let white = |harness: &Harness<App>| harness.state().model.shown.as_ref().unwrap().pictures[0].tone.white;
    let white_of = |harness: &Harness<App>| {
        let picture = &harness.state().model.shown.as_ref().unwrap().pictures[0];
        picture.scene.display.tone(&picture.image).white
    };
    let first = white(&harness);
    assert_eq!(first, white_of(&harness));
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(150.0, 0.0));
    assert_eq!(white(&harness), first);
    settle(&mut harness);
    assert_eq!(white(&harness), first);
    harness.get_by_role_and_label(Role::SpinButton, "luminosity").set_value_accesskit(6000.0);
    settle(&mut harness);
    assert!(white(&harness) == first && white_of(&harness) > 1.2 * first, "{} {}", white_of(&harness), first);
    harness.key_press(Key::Num0);
    settle(&mut harness);
    assert_eq!(white(&harness), white_of(&harness));
}
