//! The timeline: keys that are set, moments that are shown, and frames that are composed.

use barnard::glam::DVec3;
use barnard_explorer::edit::Edit;
use barnard_viewer::app::App;
use barnard_viewer::files::Purpose;
use barnard_viewer::layout::Guide;
use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, PointerButton, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::explorer::{app, drag, folder, notice, open, settle, until, viewport};

fn place(harness: &Harness<App>) -> DVec3 {
    harness.state().model.flight.camera.position
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
    let before = harness.state().model.document.text().to_owned();
    let start = place(&harness);
    harness.key_press(Key::K);
    harness.step();
    assert!(notice(&harness).contains("begins here") && harness.state().model.layout.timeline, "{}", notice(&harness));
    // The panel has its size once it was drawn.
    harness.run_steps(3);
    seek(&mut harness, 0.5);
    assert!((harness.state().model.clock.time - 5.0).abs() < 0.1, "{}", harness.state().model.clock.time);
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(120.0, 0.0));
    settle(&mut harness);
    let aside = place(&harness);
    harness.key_press(Key::K);
    settle(&mut harness);
    let text = harness.state().model.document.text().to_owned();
    assert_eq!(text.matches("[[camera.path.key]]").count(), 2, "{text}");
    assert!(text.contains("# A small cloud.") && text.contains("# comments stay"));
    let end = harness.state().model.clock.time;
    // The path lasts until its last key now, and the bar reaches beyond it.
    seek(&mut harness, 0.0);
    assert!(place(&harness).distance(start) < 1e-3, "{} {start}", place(&harness));
    seek(&mut harness, 1.0);
    assert!(harness.state().model.clock.time > end + 1.0 && place(&harness).distance(aside) < 0.05, "{} {aside}", place(&harness));
    seek(&mut harness, 0.25);
    let between = place(&harness);
    assert!(between.distance(start) > 0.1 && between.distance(aside) > 0.1);
    // The picture is that of the moment, and a view that is only looked at changes nothing.
    let shown = harness.state().model.shown.as_ref().unwrap().pictures[0].scene.camera.position;
    assert!(shown.distance(between) < 1e-9);
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(40.0, 0.0));
    settle(&mut harness);
    assert_eq!(harness.state().model.document.text(), text);
    harness.get_by_role_and_label(Role::Button, "Play").click();
    harness.run_steps(4);
    let playing = harness.state().model.clock.clone();
    assert!(playing.playing && playing.time > 0.4 * end, "{playing:?}");
    harness.key_press(Key::Space);
    settle(&mut harness);
    assert!(!harness.state().model.clock.playing);
    // The key, and the view that was flown to before it.
    harness.state_mut().model.step(false);
    harness.state_mut().model.step(false);
    assert_eq!(harness.state().model.document.text(), before);
}

/// What changes of the scene itself is seen at its moment.
#[test]
fn stars_change_with_the_moment() {
    let (_folder, mut harness) = open();
    let text = harness.state().model.document.text().to_owned();
    let track = r#"[[animation]]
of = "star[0].luminosity"
times = ["0 s", "4 s"]
values = ["3000 Lsun", "30 Lsun"]
"#;
    harness.state_mut().model.document.replace(&format!("{text}{track}")).unwrap();
    harness.key_press(Key::T);
    settle(&mut harness);
    let mean = |h: &Harness<App>| super::explorer::means(h)[1];
    let bright = mean(&harness);
    harness.state_mut().model.clock.playing = false;
    seek(&mut harness, 0.8);
    let dark = mean(&harness);
    assert!((bright / dark / 100.0 - 1.0).abs() < 0.05, "{bright:e} {dark:e}");
}

/// A key of the scene gets a track from a menu; its keys are added, dragged and taken away on its curve.
#[test]
fn curves_have_keys_to_drag() {
    let (_folder, path) = folder();
    // Each event has a frame of its own: two clicks are to be a double one.
    let builder = Harness::builder().with_size(vec2(1150.0, 760.0)).with_step_dt(0.02);
    let mut harness = builder.build_ui_state(|ui, app: &mut App| app.ui(ui), app(&path, None));
    settle(&mut harness);
    harness.key_press(Key::T);
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::Button, "Animate").click();
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::Button, "star[0].luminosity").click();
    settle(&mut harness);
    let track = |h: &Harness<App>| -> (Vec<f64>, Vec<f64>) {
        let scene = h.state().model.document.scene().clone();
        let (name, track) = scene.timeline.as_ref().unwrap().tracks().next().unwrap();
        assert_eq!((name, track.unit()), ("star[0].luminosity", "Lsun"));
        let times = track.times();
        (times.clone(), times.iter().map(|time| track.numbers(*time).unwrap()[0]).collect())
    };
    let (times, values) = track(&harness);
    assert_eq!((times, values.len()), (vec![0.0], 1));
    let strip =
        |h: &Harness<App>| h.get_by(|node| node.role() == Role::Slider && node.label().is_some_and(|l| l.starts_with("star[0]"))).rect();
    let at = |h: &Harness<App>, part: f32| strip(h).left_center() + vec2(part * strip(h).width(), 0.0);
    // A key in the middle, as high as the curve is.
    let pos = at(&harness, 0.5);
    harness.hover_at(pos);
    harness.step();
    for pressed in [true, false, true, false] {
        harness.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE });
    }
    settle(&mut harness);
    let (times, flat) = track(&harness);
    assert!(times.len() == 2 && (times[1] - 5.0).abs() < 0.2 && flat[0] == flat[1], "{times:?} {flat:?}");
    // It is dragged to the left and upwards.
    let place = at(&harness, 0.5);
    let left = -0.2 * strip(&harness).width();
    drag(&mut harness, PointerButton::Primary, place, place + vec2(left, -11.0));
    settle(&mut harness);
    let (times, higher) = track(&harness);
    assert!(times.len() == 2 && (times[1] - 3.0).abs() < 0.3, "{times:?}");
    assert!(higher[0] == flat[0] && higher[1] > 1.2 * flat[1], "{higher:?}");
    // One undo takes all of the drag back.
    harness.state_mut().model.step(false);
    settle(&mut harness);
    assert_eq!(track(&harness).1, flat);
    let place = at(&harness, 0.5);
    drag(&mut harness, PointerButton::Secondary, place, place);
    settle(&mut harness);
    assert_eq!(track(&harness).0, [0.0]);
}

#[test]
fn guides_take_turns() {
    let (_folder, mut harness) = open();
    for guide in Guide::ALL.into_iter().cycle().skip(1).take(Guide::ALL.len()) {
        harness.key_press(Key::G);
        harness.step();
        assert_eq!(harness.state().model.layout.guide, guide);
    }
}

/// A visit is a path into the cloud that plays at once and is undone in one step; all its frames are saved at a chosen size.
#[test]
fn a_visit_is_saved_as_a_film() {
    let (folder, mut harness) = open();
    let before = harness.state().model.document.text().to_owned();
    harness.key_press(Key::V);
    harness.run_steps(3);
    assert!(harness.state().model.clock.playing && harness.state().model.layout.timeline, "{}", notice(&harness));
    assert_eq!(harness.state().model.document.text().matches("[[camera.path.key]]").count(), 9);
    harness.key_press(Key::Space);
    harness.run_steps(2);
    harness.state_mut().model.apply(Edit::set("sequence", "frames_per_second", 0.15));
    settle(&mut harness);
    let app = harness.state_mut();
    app.files.ask(Purpose::SaveFilm, &app.model.document);
    harness.run_steps(3);
    harness.get_by_label("sizes").click();
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("3840 × 2160").is_some());
    harness.get_by_label_contains("the scene's own").click();
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::Button, "Save").click();
    until(&mut harness, |h| notice(h).starts_with("wrote 4 frames"));
    let frame = |number: usize| image::open(folder.path().join(format!("cloud_{number:04}.png"))).unwrap().to_rgb8();
    assert_eq!(frame(1).dimensions(), (64, 48));
    assert!(frame(1) != frame(4) && frame(4).pixels().any(|pixel| pixel.0 != [0; 3]));
    while harness.state().model.document.text() != before {
        harness.state_mut().model.step(false);
    }
}
