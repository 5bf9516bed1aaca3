//! The timeline: keys that are set, moments that are shown, and frames that are composed.

use barnard::glam::DVec3;
use barnard_viewer::app::App;
use barnard_viewer::viewport::Guide;
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, PointerButton, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::explorer::{drag, notice, open, settle, viewport};

fn place(harness: &Harness<App>) -> DVec3 {
    harness.state().flight.camera.position
}

/// Clicks into the bar of the timeline, at a part of its width.
fn seek(harness: &mut Harness<App>, part: f32) {
    let bar = harness.get_by_role_and_label(Role::Slider, "timeline").rect();
    let at = bar.left_center() + vec2(part * bar.width(), 0.0);
    drag(harness, PointerButton::Primary, at + vec2(3.0, 0.0), at);
    settle(harness);
}

/// A flight is made with the K key: it begins where the scene is seen from, goes through each view that was made a key, is
/// scrubbed, played, and taken back.
#[test]
fn a_flight_is_made_of_views() {
    let (_folder, mut harness) = open();
    let before = harness.state().document.text().to_owned();
    let start = place(&harness);
    harness.key_press(Key::K);
    harness.step();
    assert!(notice(&harness).contains("begins here") && harness.state().layout.timeline, "{}", notice(&harness));
    // The panel has its size once it was drawn.
    harness.run_steps(3);
    seek(&mut harness, 0.5);
    assert!((harness.state().clock.time - 5.0).abs() < 0.1, "{}", harness.state().clock.time);
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(120.0, 0.0));
    settle(&mut harness);
    let aside = place(&harness);
    harness.key_press(Key::K);
    settle(&mut harness);
    let text = harness.state().document.text().to_owned();
    assert_eq!(text.matches("[[camera.path.key]]").count(), 2, "{text}");
    assert!(text.contains("# A small cloud.") && text.contains("# comments stay"));
    let end = harness.state().clock.time;
    // The path lasts until its last key now, and the bar reaches beyond it.
    seek(&mut harness, 0.0);
    assert!(place(&harness).distance(start) < 1e-3, "{} {start}", place(&harness));
    seek(&mut harness, 1.0);
    assert!(harness.state().clock.time > end + 1.0 && place(&harness).distance(aside) < 0.05, "{} {aside}", place(&harness));
    seek(&mut harness, 0.25);
    let between = place(&harness);
    assert!(between.distance(start) > 0.1 && between.distance(aside) > 0.1);
    // The picture is that of the moment, and a view that is only looked at changes nothing.
    let shown = harness.state().shown.as_ref().unwrap().pictures[0].scene.camera.position;
    assert!(shown.distance(between) < 1e-9);
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(40.0, 0.0));
    settle(&mut harness);
    assert_eq!(harness.state().document.text(), text);
    harness.get_by_role_and_label(Role::Button, "Play").click();
    harness.run_steps(4);
    let playing = harness.state().clock.clone();
    assert!(playing.playing && playing.time > 0.4 * end, "{playing:?}");
    harness.key_press(Key::Space);
    settle(&mut harness);
    assert!(!harness.state().clock.playing);
    // The key, and the view that was flown to before it.
    harness.state_mut().step(false);
    harness.state_mut().step(false);
    assert_eq!(harness.state().document.text(), before);
}

/// What changes of the scene itself is seen at its moment.
#[test]
fn stars_change_with_the_moment() {
    let (_folder, mut harness) = open();
    let text = harness.state().document.text().to_owned();
    let track = "[[animation]]\nof = \"star[0].luminosity\"\ntimes = [\"0 s\", \"4 s\"]\nvalues = [\"3000 Lsun\", \"30 Lsun\"]\n";
    harness.state_mut().document.replace(&format!("{text}{track}")).unwrap();
    harness.key_press(Key::T);
    settle(&mut harness);
    let mean = |h: &Harness<App>| super::explorer::means(h)[1];
    let bright = mean(&harness);
    harness.state_mut().clock.playing = false;
    seek(&mut harness, 0.8);
    let dark = mean(&harness);
    assert!((bright / dark / 100.0 - 1.0).abs() < 0.05, "{bright:e} {dark:e}");
}

#[test]
fn guides_take_turns() {
    let (_folder, mut harness) = open();
    for guide in Guide::ALL.into_iter().cycle().skip(1).take(Guide::ALL.len()) {
        harness.key_press(Key::G);
        harness.step();
        assert_eq!(harness.state().viewport.guide, guide);
    }
}
