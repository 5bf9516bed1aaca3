//! Probe position and its readings.

use barnard_explorer::comparison::With;
use barnard_explorer::edit::Edit;
use barnard_viewer::app::App;
use eframe::egui::accesskit::Role;
use eframe::egui::vec2;
use eframe::egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, TouchPhase};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::explorer::{SCENE, drag, notice, open, settle, viewport};

/// The probe shows the radiance of the pixel under the pointer.
#[test]
fn the_probe_reads_pixels() {
    let (_folder, mut harness) = open();
    assert!(harness.query_by_label("hover over the picture").is_some());
    harness.hover_at(viewport(&harness).center());
    harness.step();
    harness.step();
    let image = harness.state().model.shown.as_ref().unwrap().pictures[0].image.clone();
    let (column, row) = (image.width / 2, image.height / 2);
    assert!(harness.query_by_label(&format!("column {column}, row {row} of {} × {}", image.width, image.height)).is_some());
    assert!(harness.query_by_label(&format!("{:.3e}", image.at(1, row, column))).is_some());
    assert!(harness.query_by_label_contains("optical depth").is_some());
}

/// A drag turns the view; at rest the camera is written down, and one undo takes the whole drag back.
#[test]
fn the_view_is_dragged() {
    let (_folder, mut harness) = open();
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(120.0, 30.0));
    settle(&mut harness);
    let camera = harness.state().model.document.scene().camera.clone();
    assert!(camera.position.x < -1.0 && (camera.position.length() - 6.0).abs() < 1e-3, "{:?}", camera.position);
    assert_eq!(harness.state().model.flight.camera, camera);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().model.document.text(), SCENE);
    assert!(harness.state().model.flight.camera.position.distance(barnard::glam::DVec3::new(0.0, 0.0, 6.0)) < 1e-9);
}

/// Two sets of filters share the window; the edge between them is dragged.
#[test]
fn filters_are_compared() {
    let (_folder, mut harness) = open();
    harness.state_mut().model.comparison.with = With::Filters("2mass".into());
    settle(&mut harness);
    let names: Vec<String> = harness.state().model.shown.as_ref().unwrap().pictures.iter().map(|p| p.image.bands[0].name.clone()).collect();
    assert!(names.len() == 2 && names[0].starts_with("johnson") && names[1].starts_with("twomass"), "{names:?}");
    let rect = viewport(&harness);
    drag(&mut harness, PointerButton::Primary, rect.center(), rect.center() + vec2(100.0, 0.0));
    assert!(harness.state().model.comparison.edge.unwrap() > 0.6);
    assert_eq!(harness.state().model.document.text(), SCENE);
}

/// An instrument is chosen, and what it records stands beside the picture; its exposure is typed.
#[test]
fn pictures_are_observed() {
    let (_folder, mut harness) = open();
    harness.get_by_label("Instrument").click();
    harness.run_steps(3);
    harness.get_by_label("instrument").click();
    harness.run_steps(3);
    harness.get_by_label("lco-1m-sinistro").click();
    harness.run_steps(3);
    assert!(harness.state().model.document.scene().instrument.is_some(), "{:?}", harness.state().model.notice.as_ref().map(|n| &n.words));
    harness.get_by_label("as observed").click();
    settle(&mut harness);
    let words = |harness: &Harness<App>| harness.state().model.shown.as_ref().unwrap().pictures[1].recorded_words();
    assert!(words(&harness).starts_with("lco-1m-sinistro, 6 × 300 s"), "{}", words(&harness));
    harness.state_mut().model.apply(Edit::set("instrument", "exposure", "2 s"));
    settle(&mut harness);
    assert!(words(&harness).contains("6 × 2 s"), "{}", words(&harness));
    assert!(harness.state().model.shown.as_ref().unwrap().pictures[1].recorded_bands().len() == 3);
}

/// W flies ahead for as long as it is held, and the wheel changes how fast; what was flown to is written down.
#[test]
fn keys_fly() {
    let (_folder, mut harness) = open();
    let place = |h: &Harness<App>| h.state().model.flight.camera.position;
    let speed = harness.state().model.flight.speed;
    harness.hover_at(viewport(&harness).center());
    harness.key_down(Key::W);
    harness.run_steps(5);
    let nearer = place(&harness);
    assert!(nearer.z < 6.0 - 1e-3 && nearer.x.abs() < 1e-9, "{nearer}");
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        source: MouseWheelSource::Wheel,
        delta: vec2(0.0, 200.0),
        phase: TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(5);
    assert!(harness.state().model.flight.speed > 1.2 * speed, "{}", harness.state().model.flight.speed);
    harness.key_up(Key::W);
    harness.step();
    let there = place(&harness);
    assert!(there.z < nearer.z);
    settle(&mut harness);
    assert!(harness.state().model.document.scene().camera.position.distance(there) < 1e-3);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().model.document.text(), SCENE);
    // Ctrl+S is no flight backwards, though Ctrl is let go first.
    harness.key_down_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(5);
    settle(&mut harness);
    assert!(harness.state().model.document.text() == SCENE && !harness.state().model.document.is_changed());
    harness.key_up(Key::S);
    harness.step();
    harness.key_down(Key::S);
    harness.run_steps(5);
    assert!(place(&harness).z > 6.0 + 1e-3);
}

/// Bookmarks bring a view back, stand in the scene, and are taken back like any change.
#[test]
fn bookmarks_are_places() {
    let (_folder, mut harness) = open();
    harness.key_press(Key::Num3);
    harness.step();
    assert!(notice(&harness).contains("bookmark 3 is not set"), "{}", notice(&harness));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num3);
    harness.step();
    assert!(
        harness.state().model.document.text().contains("[bookmark.3]\nkind = \"perspective\"\n"),
        "{}",
        harness.state().model.document.text()
    );
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(150.0, 0.0));
    settle(&mut harness);
    assert!(harness.state().model.flight.camera.position.x.abs() > 1.0);
    harness.key_press(Key::Num3);
    settle(&mut harness);
    assert!(harness.state().model.flight.camera.position.distance(barnard::glam::DVec3::new(0.0, 0.0, 6.0)) < 1e-4);
    for _ in 0..3 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.step();
    }
    assert!(!harness.state().model.document.text().contains("bookmark"), "{}", harness.state().model.document.text());
}

/// Digits that are typed are the field's own, also where a slow frame holds them with the key that leaves it.
#[test]
fn typed_digits_are_no_bookmarks() {
    let (_folder, mut harness) = open();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num3);
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(150.0, 0.0));
    settle(&mut harness);
    let there = harness.state().model.flight.camera.position;
    harness.get_by_role_and_label(Role::SpinButton, "temperature").focus();
    harness.step();
    // All in one frame.
    let pressed = |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
    harness.input_mut().events.extend([Key::Num3, Key::Enter, Key::Num3].map(pressed));
    harness.step();
    assert_eq!(harness.state().model.flight.camera.position, there);
    harness.step();
    harness.key_press(Key::Num3);
    settle(&mut harness);
    assert!(harness.state().model.flight.camera.position.distance(there) > 1.0, "the digit is the window's again");
}

/// After "Frame all" and an undo one moves around the cloud again, and not around a place behind it.
#[test]
fn home_and_undo_keep_the_middle() {
    let (_folder, mut harness) = open();
    let before = harness.state().model.flight.clone();
    harness.key_press(Key::Home);
    settle(&mut harness);
    assert!((harness.state().model.flight.distance() / before.distance() - 1.0).abs() > 0.1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    let after = harness.state().model.flight.clone();
    assert!(after.camera.position.distance(before.camera.position) < 1e-3 * before.distance());
    assert!((after.distance() / before.distance() - 1.0).abs() < 1e-3, "{} {}", after.distance(), before.distance());
}

#[test]
fn escape_closes_help() {
    let (_folder, mut harness) = open();
    harness.key_press(Key::F1);
    harness.run_steps(2);
    assert!(harness.state().model.layout.help);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(!harness.state().model.layout.help);
}

/// A click on a star marks it and opens its keys, also in a narrow window; a click beside it marks none.
#[test]
fn stars_are_selected() {
    let (_folder, mut harness) = open();
    let place = |harness: &Harness<App>| {
        let (model, rect) = (&harness.state().model, viewport(harness));
        let camera = &model.flight.camera;
        let (column, row) = camera.project(model.document.stars()[0].position).unwrap();
        rect.min + vec2(column as f32 / camera.width as f32 * rect.width(), row as f32 / camera.height as f32 * rect.height())
    };
    let click = |harness: &mut Harness<App>, at| {
        harness.hover_at(at);
        harness.step();
        for pressed in [true, false] {
            harness.event(Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE });
        }
        harness.run_steps(3);
    };
    let star = place(&harness);
    click(&mut harness, star);
    assert_eq!(harness.state().model.selected, Some(0));
    let beside = place(&harness) + vec2(60.0, 60.0);
    click(&mut harness, beside);
    assert_eq!(harness.state().model.selected, None);
    assert_eq!(harness.state().model.document.text(), SCENE);
    harness.set_size(vec2(640.0, 480.0));
    settle(&mut harness);
    assert!(harness.query_by_label("temperature").is_none() && viewport(&harness).height() > 0.85 * 480.0);
    let star = place(&harness);
    click(&mut harness, star);
    assert!(harness.query_by_role_and_label(Role::SpinButton, "temperature").is_some());
    assert!(viewport(&harness).width() > 0.45 * 640.0, "{}", viewport(&harness).width());
}

/// Keys of glare, detail, output and sequence are added in the panels and written into their tables.
#[test]
fn every_table_is_edited() {
    let (_folder, mut harness) = open();
    harness.set_size(vec2(1150.0, 1400.0));
    for (section, key, table) in [
        ("Glare", "seeing", "display.glare"),
        ("Detail", "strength", "detail"),
        ("Output", "precision", "output"),
        ("Sequence", "shutter", "sequence"),
    ] {
        harness.get_by_label(section).click();
        harness.run_steps(20);
        let below = harness.get_by_label(section).rect().bottom();
        let menus: Vec<_> = harness.get_all_by_label("more …").filter(|menu| menu.rect().top() >= below - 1.0).collect();
        menus.into_iter().min_by(|a, b| a.rect().top().total_cmp(&b.rect().top())).unwrap().click();
        harness.run_steps(3);
        harness.get_by_role_and_label(Role::Button, key).click();
        harness.run_steps(3);
        let text = harness.state().model.document.text().to_owned();
        assert!(text.contains(&format!("[{table}]\n{key} = ")), "{section}: {} {text}", notice(&harness));
    }
}
