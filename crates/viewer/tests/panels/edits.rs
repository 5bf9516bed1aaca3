//! Values that are changed by their widgets: text, plan and picture follow.

use std::sync::Arc;

use barnard_viewer::app::App;
use barnard_viewer::command::Command;
use eframe::egui::accesskit::Role;
use eframe::egui::vec2;
use eframe::egui::{Key, Modifiers, PointerButton, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::explorer::{SCENE, app, drag, folder, harness, means, notice, open, settle, viewport};

/// A hotter star: the text says so, the plan has another spectrum, the picture is bluer, the comment is where it was;
/// undo brings all of it back.
#[test]
fn a_temperature_changes_plan_and_picture() {
    let (_folder, mut harness) = open();
    let before = means(&harness);
    harness.get_by_role_and_label(Role::SpinButton, "temperature").set_value_accesskit(6000.0);
    settle(&mut harness);
    let text = harness.state().model.document.text().to_owned();
    assert!(text.contains("temperature = \"6000 K\"") && text.contains("# comments stay"), "{text}");
    let after = means(&harness);
    assert!(after[0] / before[0] < 0.9 * after[2] / before[2], "{before:?} {after:?}");
    assert!(harness.state().model.document.is_changed());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().model.document.text(), SCENE);
    assert_eq!(means(&harness), before);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.step();
    assert_eq!(harness.state().model.document.text(), text);
}

/// Widgets stay in the range of their key. Other impossible values are refused as `barnard check` refuses them, and change nothing.
#[test]
fn impossible_values_are_refused() {
    let (_folder, mut harness) = open();
    harness.state_mut().model.apply(barnard_explorer::edit::Edit::set("star.0", "temperature", "-5 K"));
    harness.step();
    assert!(notice(&harness).contains("between 1 and 1e9 K") && notice(&harness).contains("cloud.toml:22"), "{}", notice(&harness));
    assert_eq!(harness.state().model.document.text(), SCENE);
    harness.get_by_role_and_label(Role::SpinButton, "temperature").set_value_accesskit(-5.0);
    harness.step();
    harness.step();
    assert!(harness.state().model.document.text().contains("temperature = \"1 K\""), "{}", harness.state().model.document.text());
}

/// Another set of filters has bands and colours of its own; another palette colours the same radiances anew.
#[test]
fn filters_and_palettes_change_what_is_seen() {
    let (_folder, mut harness) = open();
    harness.state_mut().model.apply(barnard_explorer::comparison::filters("sho-3nm"));
    settle(&mut harness);
    let bands = |h: &Harness<App>| {
        h.state().model.shown.as_ref().unwrap().pictures[0].image.bands.iter().map(|b| b.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(bands(&harness).len(), 3);
    let (image, colours) = {
        let picture = &harness.state().model.shown.as_ref().unwrap().pictures[0];
        (picture.image.clone(), picture.colours.clone())
    };
    harness.get_by_role_and_label(Role::Button, "SHO").click();
    settle(&mut harness);
    let picture = &harness.state().model.shown.as_ref().unwrap().pictures[0];
    assert!(Arc::ptr_eq(&picture.image, &image) && picture.colours != colours);
    assert!(harness.state().model.document.text().contains("palette = \"sho\""));
    harness.get_by_role_and_label(Role::Button, "Matrix").click();
    harness.step();
    harness.step();
    assert!(harness.state().model.document.text().contains("matrix = ["), "{}", notice(&harness));
}

/// Another method makes the picture and states its error; the difference from a finer one is small, and that of a poor
/// one is larger.
#[test]
fn methods_state_their_errors() {
    let (_folder, mut harness) = open();
    assert!(harness.query_by_label_contains("johnson-B: spectral error at most").is_some());
    harness.get_by_role_and_label(Role::CheckBox, "difference × 16").click();
    settle(&mut harness);
    let difference = |h: &Harness<App>| {
        let pictures = &h.state().model.shown.as_ref().unwrap().pictures;
        pictures[0].image.relative_rmse(0, &pictures[1].image, 0)
    };
    let fine = difference(&harness);
    assert!(harness.query_by_label_contains("johnson-B: differs by").is_some());
    harness.state_mut().model.apply(barnard_explorer::edit::Edit::set("method", "name", "fixed_wavelength"));
    settle(&mut harness);
    assert!(fine < 0.03 && difference(&harness) > fine, "{fine} {}", difference(&harness));
    assert_eq!(harness.state().model.shown.as_ref().unwrap().pictures[0].plan.spectral().method, "fixed_wavelength");
}

/// A star follows the pointer; the camera stays.
#[test]
fn a_star_is_dragged() {
    let (_folder, mut harness) = open();
    let rect = viewport(&harness);
    let (column, row, width) = {
        let state = harness.state();
        let camera = state.model.flight.seen(state.viewport.pixels.unwrap());
        let (column, row) = camera.project(state.model.document.scene().stars[0].position).unwrap();
        (column, row, camera.width)
    };
    let scale = rect.width() / width as f32;
    let star = rect.min + vec2(column as f32, row as f32) * scale;
    let target = star + vec2(-80.0, 40.0);
    drag(&mut harness, PointerButton::Primary, star, target);
    settle(&mut harness);
    let state = harness.state();
    let moved = state.model.document.scene().stars[0].position;
    let camera = state.model.flight.seen(state.viewport.pixels.unwrap());
    let (column, row) = camera.project(moved).unwrap();
    let seen = rect.min + vec2(column as f32, row as f32) * scale;
    assert!(seen.distance(target) < 3.0 && (moved.z - 0.9).abs() < 1e-4, "{seen:?} {target:?} {moved}");
    assert_eq!(camera.position, barnard::glam::DVec3::new(0.0, 0.0, 6.0));
}

/// The picture has the frame of the scene's own, and fills the middle of the window on request.
#[test]
fn the_frame_is_the_scenes() {
    let (_folder, mut harness) = open();
    let shape = |harness: &Harness<App>| {
        let (rect, pixels) = (viewport(harness), harness.state().viewport.pixels.unwrap());
        assert!((rect.aspect_ratio() - pixels.0 as f32 / pixels.1 as f32).abs() < 0.01, "{rect} {pixels:?}");
        rect.aspect_ratio()
    };
    let expected = barnard_viewer::viewport::aspect(&harness.state().model.document.scene().camera);
    assert!((shape(&harness) - expected).abs() < 0.01, "{} {expected}", shape(&harness));
    harness.state_mut().perform(Command::Layout(Box::new(|layout| layout.fills = true)));
    settle(&mut harness);
    assert!((shape(&harness) - expected).abs() > 0.1, "{} {expected}", shape(&harness));
}

/// Filters become points, and a point of a curve that is dragged down lets less light through.
#[test]
fn curves_are_dragged() {
    let (_folder, mut harness) = open();
    harness.get_by_role_and_label(Role::Button, "Curves to drag").click();
    settle(&mut harness);
    let text = harness.state().model.document.text().to_owned();
    assert!(text.matches("kind = \"points\"").count() == 3 && !text.contains("bands ="), "{text}");
    let before = means(&harness);
    let throughput = |h: &Harness<App>| h.state().model.document.scene().bands[1].response(0.547);
    let high = throughput(&harness);
    // The middle of the second filter: wherever it is drawn, a short way down from the top of the plot.
    let header = harness.get_by_label("Spectra").rect();
    let plot = Rect::from_min_max(header.left_bottom() + vec2(30.0, 24.0), header.left_bottom() + vec2(310.0, 200.0));
    let mut dragged = false;
    'search: for row in 0..8 {
        for column in 0..28 {
            let from = plot.min + vec2(10.0 * column as f32, 8.0 * row as f32);
            drag(&mut harness, PointerButton::Primary, from, from + vec2(0.0, 60.0));
            if harness.state().model.document.text() != text {
                dragged = true;
                break 'search;
            }
        }
    }
    assert!(dragged);
    settle(&mut harness);
    let after = means(&harness);
    assert!(before.iter().zip(&after).any(|(b, a)| (a / b - 1.0).abs() > 1e-3), "{before:?} {after:?} {high} {}", throughput(&harness));
}

/// A star is added in the middle of the view and taken away again; another kind of spectrum brings the keys it needs.
#[test]
fn stars_come_and_go() {
    let (_folder, mut harness) = open();
    let before = means(&harness);
    harness.get_by_role_and_label(Role::Button, "Add a star").click();
    settle(&mut harness);
    assert_eq!(harness.state().model.document.scene().stars.len(), 2);
    // It stands before the cloud's middle in the middle of the view, lights the cloud, and its keys are open.
    let (scene, flight) = (harness.state().model.document.scene().clone(), harness.state().model.flight.clone());
    let place = flight.camera.project(scene.stars[1].position).unwrap();
    assert!((place.0 - 0.5 * flight.camera.width as f64).abs() < 1.0 && scene.stars[1].visible, "{place:?}");
    assert!((scene.stars[1].position - flight.camera.position).length() < flight.distance());
    assert!(means(&harness)[1] > 1.2 * before[1], "{:?} {before:?}", means(&harness));
    assert_eq!(harness.get_all_by_role_and_label(Role::ComboBox, "kind").count(), 2);
    harness.get_all_by_role_and_label(Role::ComboBox, "kind").next().unwrap().click();
    harness.step();
    harness.step();
    harness.get_by_label("stellar").click();
    settle(&mut harness);
    let text = harness.state().model.document.text().to_owned();
    assert!(text.contains("kind = \"stellar\"") && text.contains("type = ") && !text.contains("20000 K"), "{text}");
    harness.get_all_by_role_and_label(Role::Button, "Remove").next().unwrap().click();
    settle(&mut harness);
    assert_eq!(harness.state().model.document.scene().stars.len(), 1);
}

/// Stars of a table shine and have a panel, but cannot be taken hold of: only their table says where they are.
#[test]
fn stars_of_a_table_are_seen() {
    let (folder, path) = folder();
    std::fs::write(folder.path().join("more.csv"), "x,y,z,temperature,luminosity\n-0.3,-0.2,0.9,4000,9000\n").unwrap();
    let mut bare = harness(app(&path, None));
    settle(&mut bare);
    std::fs::write(&path, format!("{SCENE}[[star_table]]\nfile = \"more.csv\"\n")).unwrap();
    let mut harness = harness(app(&path, None));
    settle(&mut harness);
    let (state, before) = (harness.state(), means(&bare));
    assert_eq!((state.model.document.scene().stars.len(), state.model.document.stars().len()), (2, 1));
    assert!(means(&harness)[2] > 1.5 * before[2], "{:?} {before:?}", means(&harness));
    assert!(harness.query_by_label_contains("Table of stars 1").is_some() && bare.query_by_label_contains("Table of stars 1").is_none());
    let camera = state.model.flight.seen(state.viewport.pixels.unwrap());
    let (column, row) = camera.project(state.model.document.scene().stars[1].position).unwrap();
    let rect = viewport(&harness);
    let star = rect.min + vec2(column as f32, row as f32) * (rect.width() / camera.width as f32);
    drag(&mut harness, PointerButton::Primary, star, star + vec2(80.0, 0.0));
    settle(&mut harness);
    let scene = harness.state().model.document.scene();
    assert!(scene.stars[1].position == barnard::glam::DVec3::new(-0.3, -0.2, 0.9) && scene.camera.position.x < -1.0, "{:?}", scene.camera);
}

/// Numbers of many digits stay within their panel.
#[test]
fn long_numbers_stay_in_their_panel() {
    let (_folder, path) = folder();
    let long = SCENE
        .replace("0.3 0.2 0.9 pc", "0.312345678901234 -0.212345678901234 0.912345678901234 pc")
        .replace("3000 Lsun", "3000.12345678901234567 Lsun")
        .replace("4 mag/pc", "4.12345678901234567 mag/pc")
        .replace("accuracy = 0.02", "accuracy = 0.02000000000012345");
    std::fs::write(&path, long).unwrap();
    let mut harness = harness(app(&path, None));
    settle(&mut harness);
    let panel = viewport(&harness).left();
    for label in ["position", "luminosity", "temperature", "scale", "accuracy", "bake"] {
        for number in harness.get_all_by_role_and_label(Role::SpinButton, label) {
            let (low, high) = if number.rect().left() < panel { (0.0, panel) } else { (viewport(&harness).right(), 1150.0) };
            assert!(number.rect().left() >= low && number.rect().right() <= high, "{label}: {:?}", number.rect());
        }
    }
}
