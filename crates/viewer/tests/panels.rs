//! The explorer without a window: every panel is shown, changed by its own widgets, and looked at.
//!
//! `UPDATE_SNAPSHOTS=1` writes the pictures of the panels anew.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use barnard::backend::cpu;
use barnard::image::Level;
use barnard_viewer::app::App;
use barnard_viewer::comparison::With;
use barnard_viewer::document::{Document, Origin};
use barnard_viewer::engine::Engine;
use barnard_viewer::export::Export;
use barnard_viewer::session::Session;
use eframe::egui::accesskit::Role;
use eframe::egui::{
    DroppedFile, Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase, ViewportEvent, ViewportId,
    vec2,
};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

const SCENE: &str = r#"# A small cloud.
bands = "johnson" # comments stay

[camera]
kind = "perspective"
position = "0 0 6 pc"
field_of_view = "24 deg"
size = [64, 48]

[field.cloud]
kind = "fbm"
radius = "1 pc"

[dust]
density = "cloud"
scale = "4 mag/pc"

[[star]]
name = "hot star"
kind = "blackbody"
position = "0.3 0.2 0.9 pc"
temperature = "20000 K"
luminosity = "3000 Lsun"

[method]
accuracy = 0.02
bake = 24
"#;

const LIMIT: u64 = 1 << 32;

/// A folder with the scene in it.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cloud.toml");
    std::fs::write(&path, SCENE).unwrap();
    (folder, path)
}

fn app(path: &Path, recovery: Option<PathBuf>) -> App {
    let document = Document::open(path, LIMIT).unwrap();
    App::new(document, Engine::start(cpu::ENTRY, || ()), Session::new(recovery), LIMIT)
}

fn harness(app: App) -> Harness<'static, App> {
    Harness::builder().with_size(vec2(1150.0, 760.0)).build_ui_state(|ui, app: &mut App| app.ui(ui), app)
}

fn open() -> (tempfile::TempDir, Harness<'static, App>) {
    let (folder, path) = folder();
    let mut harness = harness(app(&path, None));
    settle(&mut harness);
    (folder, harness)
}

/// Frames until the picture is the final one.
fn settle(harness: &mut Harness<App>) {
    let start = Instant::now();
    harness.step();
    harness.step();
    while !harness.state().is_settled() {
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
        assert!(start.elapsed() < Duration::from_secs(120), "{:?}", harness.state().notice.as_ref().map(|n| &n.words));
    }
    harness.step();
}

/// Mean radiance of each band.
fn means(harness: &Harness<App>) -> Vec<f64> {
    let shown = harness.state().shown.as_ref().unwrap();
    let image = &shown.pictures[0].image;
    (0..image.bands.len()).map(|b| image.band(b).sum::<f64>() / (image.width * image.height) as f64).collect()
}

fn notice<'a>(harness: &'a Harness<App>) -> &'a str {
    harness.state().notice.as_ref().map_or("", |n| &n.words)
}

/// The picture's place in the window.
fn viewport(harness: &Harness<App>) -> Rect {
    harness.get_by_role_and_label(Role::Image, "picture").rect()
}

fn drag(harness: &mut Harness<App>, button: PointerButton, from: Pos2, to: Pos2) {
    let press = |harness: &mut Harness<App>, pos, pressed| {
        harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
    };
    harness.hover_at(from);
    harness.step();
    press(harness, from, true);
    harness.step();
    for i in 1..=4 {
        harness.hover_at(from + (to - from) * (i as f32 / 4.0));
        harness.step();
    }
    press(harness, to, false);
    harness.step();
}

/// A hotter star: the text says so, the plan has another spectrum, the picture is bluer, the comment is where it was;
/// undo brings all of it back.
#[test]
fn a_temperature_changes_plan_and_picture() {
    let (_folder, mut harness) = open();
    let before = means(&harness);
    harness.get_by_role_and_label(Role::SpinButton, "temperature").set_value_accesskit(6000.0);
    settle(&mut harness);
    let text = harness.state().document.text().to_owned();
    assert!(text.contains("temperature = \"6000 K\"") && text.contains("# comments stay"), "{text}");
    let after = means(&harness);
    assert!(after[0] / before[0] < 0.9 * after[2] / before[2], "{before:?} {after:?}");
    assert!(harness.state().document.is_changed());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().document.text(), SCENE);
    assert_eq!(means(&harness), before);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.step();
    assert_eq!(harness.state().document.text(), text);
}

/// What cannot be is told as `barnard check` tells it, and nothing is changed.
#[test]
fn impossible_values_are_refused() {
    let (_folder, mut harness) = open();
    harness.get_by_role_and_label(Role::SpinButton, "temperature").set_value_accesskit(-5.0);
    harness.step();
    harness.step();
    assert!(notice(&harness).contains("not above zero") && notice(&harness).contains("cloud.toml:22"), "{}", notice(&harness));
    assert_eq!(harness.state().document.text(), SCENE);
}

/// Another set of filters has bands and colours of its own; another palette colours the same radiances anew.
#[test]
fn filters_and_palettes_change_what_is_seen() {
    let (_folder, mut harness) = open();
    harness.state_mut().apply(barnard_viewer::comparison::filters("sho-3nm"));
    settle(&mut harness);
    let bands =
        |h: &Harness<App>| h.state().shown.as_ref().unwrap().pictures[0].image.bands.iter().map(|b| b.name.clone()).collect::<Vec<_>>();
    assert_eq!(bands(&harness).len(), 3);
    let (image, colours) = {
        let picture = &harness.state().shown.as_ref().unwrap().pictures[0];
        (picture.image.clone(), picture.colours.clone())
    };
    harness.get_by_role_and_label(Role::Button, "SHO").click();
    settle(&mut harness);
    let picture = &harness.state().shown.as_ref().unwrap().pictures[0];
    assert!(Arc::ptr_eq(&picture.image, &image) && picture.colours != colours);
    assert!(harness.state().document.text().contains("palette = \"sho\""));
    harness.get_by_role_and_label(Role::Button, "Matrix").click();
    harness.step();
    harness.step();
    assert!(harness.state().document.text().contains("matrix = ["), "{}", notice(&harness));
}

/// Brighter is a lower white; automatic takes it away again.
#[test]
fn exposure_is_written() {
    let (_folder, mut harness) = open();
    let white = harness.state().shown.as_ref().unwrap().pictures[0].tone.white;
    harness.key_press(Key::Plus);
    settle(&mut harness);
    let tone = &harness.state().shown.as_ref().unwrap().pictures[0].tone;
    assert!((tone.white / white - 0.5f64.sqrt()).abs() < 1e-4, "{} {white}", tone.white);
    harness.get_by_role_and_label(Role::Button, "Auto").click();
    settle(&mut harness);
    assert!(!harness.state().document.text().contains("white"));
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
        let pictures = &h.state().shown.as_ref().unwrap().pictures;
        pictures[0].image.relative_rmse(0, &pictures[1].image, 0)
    };
    let fine = difference(&harness);
    assert!(harness.query_by_label_contains("johnson-B: differs by").is_some());
    harness.state_mut().apply(barnard_viewer::edit::Edit::set("method", "name", "fixed_wavelength"));
    settle(&mut harness);
    assert!(fine < 0.03 && difference(&harness) > fine, "{fine} {}", difference(&harness));
    assert_eq!(harness.state().shown.as_ref().unwrap().pictures[0].plan.spectral().method, "fixed_wavelength");
}

/// The probe shows the radiance of the pixel under the pointer.
#[test]
fn the_probe_reads_pixels() {
    let (_folder, mut harness) = open();
    assert!(harness.query_by_label("point at the picture").is_some());
    harness.hover_at(viewport(&harness).center());
    harness.step();
    harness.step();
    let image = harness.state().shown.as_ref().unwrap().pictures[0].image.clone();
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
    let camera = harness.state().document.scene().camera.clone();
    assert!(camera.position.x < -1.0 && (camera.position.length() - 6.0).abs() < 1e-3, "{:?}", camera.position);
    assert_eq!(harness.state().flight.camera, camera);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().document.text(), SCENE);
    assert!(harness.state().flight.camera.position.distance(barnard::glam::DVec3::new(0.0, 0.0, 6.0)) < 1e-9);
}

/// A star follows the pointer; the camera stays.
#[test]
fn a_star_is_dragged() {
    let (_folder, mut harness) = open();
    let rect = viewport(&harness);
    let (column, row, width) = {
        let state = harness.state();
        let camera = state.flight.seen(state.viewport.pixels.unwrap());
        let (column, row) = camera.project(state.document.scene().stars[0].position).unwrap();
        (column, row, camera.width)
    };
    let scale = rect.width() / width as f32;
    let star = rect.min + vec2(column as f32, row as f32) * scale;
    let target = star + vec2(-80.0, 40.0);
    drag(&mut harness, PointerButton::Primary, star, target);
    settle(&mut harness);
    let state = harness.state();
    let moved = state.document.scene().stars[0].position;
    let camera = state.flight.seen(state.viewport.pixels.unwrap());
    let (column, row) = camera.project(moved).unwrap();
    let seen = rect.min + vec2(column as f32, row as f32) * scale;
    assert!(seen.distance(target) < 3.0 && (moved.z - 0.9).abs() < 1e-4, "{seen:?} {target:?} {moved}");
    assert_eq!(camera.position, barnard::glam::DVec3::new(0.0, 0.0, 6.0));
}

/// Two sets of filters share the window; the edge between them is dragged.
#[test]
fn filters_are_compared() {
    let (_folder, mut harness) = open();
    harness.state_mut().comparison.with = With::Filters("2mass".into());
    settle(&mut harness);
    let names: Vec<String> = harness.state().shown.as_ref().unwrap().pictures.iter().map(|p| p.image.bands[0].name.clone()).collect();
    assert!(names.len() == 2 && names[0].starts_with("johnson") && names[1].starts_with("twomass"), "{names:?}");
    let rect = viewport(&harness);
    drag(&mut harness, PointerButton::Primary, rect.center(), rect.center() + vec2(100.0, 0.0));
    assert!(harness.state().comparison.edge.unwrap() > 0.6);
    assert_eq!(harness.state().document.text(), SCENE);
}

/// Filters become points, and a point of a curve that is dragged down lets less light through.
#[test]
fn curves_are_dragged() {
    let (_folder, mut harness) = open();
    harness.get_by_role_and_label(Role::Button, "Curves to drag").click();
    settle(&mut harness);
    let text = harness.state().document.text().to_owned();
    assert!(text.matches("kind = \"points\"").count() == 3 && !text.contains("bands ="), "{text}");
    let before = means(&harness);
    let throughput = |h: &Harness<App>| h.state().document.scene().bands[1].response(0.547);
    let high = throughput(&harness);
    // The middle of the second filter: wherever it is drawn, a short way down from the top of the plot.
    let header = harness.get_by_label("Spectra").rect();
    let plot = Rect::from_min_max(header.left_bottom() + vec2(30.0, 24.0), header.left_bottom() + vec2(310.0, 200.0));
    let mut dragged = false;
    'search: for row in 0..8 {
        for column in 0..28 {
            let from = plot.min + vec2(10.0 * column as f32, 8.0 * row as f32);
            drag(&mut harness, PointerButton::Primary, from, from + vec2(0.0, 60.0));
            if harness.state().document.text() != text {
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
    assert_eq!(harness.state().document.scene().stars.len(), 2);
    assert!(means(&harness)[1] > before[1]);
    harness.get_by_role_and_label(Role::ComboBox, "kind").click();
    harness.step();
    harness.step();
    harness.get_by_label("stellar").click();
    settle(&mut harness);
    let text = harness.state().document.text().to_owned();
    assert!(text.contains("kind = \"stellar\"") && text.contains("type = ") && !text.contains("20000 K"), "{text}");
    harness.get_by_role_and_label(Role::Button, "Remove").click();
    settle(&mut harness);
    assert_eq!(harness.state().document.scene().stars.len(), 1);
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
    assert_eq!((state.document.scene().stars.len(), state.document.stars().len()), (2, 1));
    assert!(means(&harness)[2] > 1.5 * before[2], "{:?} {before:?}", means(&harness));
    assert!(harness.query_by_label_contains("Table of stars 1").is_some() && bare.query_by_label_contains("Table of stars 1").is_none());
    let camera = state.flight.seen(state.viewport.pixels.unwrap());
    let (column, row) = camera.project(state.document.scene().stars[1].position).unwrap();
    let rect = viewport(&harness);
    let star = rect.min + vec2(column as f32, row as f32) * (rect.width() / camera.width as f32);
    drag(&mut harness, PointerButton::Primary, star, star + vec2(80.0, 0.0));
    settle(&mut harness);
    let scene = harness.state().document.scene();
    assert!(scene.stars[1].position == barnard::glam::DVec3::new(-0.3, -0.2, 0.9) && scene.camera.position.x < -1.0, "{:?}", scene.camera);
}

/// A broken scene from the dialog tells what `barnard check` tells, and the scene that was open stays.
#[test]
fn a_broken_scene_is_refused() {
    let (folder, mut harness) = open();
    let broken = folder.path().join("broken.toml");
    std::fs::write(&broken, SCENE.replace("fbm", "fog")).unwrap();
    let expected = Document::open(&broken, LIMIT).err().unwrap().to_string();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    harness.step();
    harness.get_by_label("broken.toml").click();
    harness.step();
    harness.get_by_role_and_label(Role::Button, "Open").click();
    harness.step();
    harness.step();
    assert_eq!(notice(&harness), expected);
    // The keys are the window's again at once.
    harness.key_press(Key::M);
    harness.step();
    assert!(harness.state().viewport.overlay);
    assert!(expected.contains("unknown field \"fog\"") && expected.contains("broken.toml:11"), "{expected}");
    assert_eq!(*harness.state().document.origin(), Origin::File(folder.path().join("cloud.toml")));
    assert_eq!(harness.state().document.text(), SCENE);
}

/// A scene that is saved says, byte by byte, what was open; a built-in one brings its volumes along.
#[test]
fn scenes_are_saved() {
    let (folder, mut harness) = open();
    harness.get_by_role_and_label(Role::SpinButton, "temperature").set_value_accesskit(9000.0);
    harness.step();
    harness.step();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    let saved = std::fs::read_to_string(folder.path().join("cloud.toml")).unwrap();
    assert_eq!(saved, SCENE.replace("20000 K", "9000 K"));
    assert!(!harness.state().document.is_changed());
    let mut builtin = Document::builtin("hii_region", LIMIT).unwrap();
    let text = builtin.text().to_owned();
    let path = folder.path().join("own/region.toml");
    std::fs::create_dir(folder.path().join("own")).unwrap();
    builtin.save(&path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    assert!(folder.path().join("own/volumes").is_dir());
    // Elsewhere, its files are named where they are.
    let mut again = Document::open(&path, LIMIT).unwrap();
    again.save(&folder.path().join("region.toml")).unwrap();
    assert!(Document::open(&folder.path().join("region.toml"), LIMIT).is_ok());
}

/// The picture that is saved is the one that `barnard render` makes.
#[test]
fn pictures_are_saved() {
    let (folder, mut harness) = open();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::E);
    harness.step();
    harness.get_by_role_and_label(Role::TextInput, "file").focus();
    harness.step();
    harness.key_combination_modifiers(Modifiers::COMMAND, &[Key::A]);
    harness.get_by_role_and_label(Role::TextInput, "file").type_text("out.fits");
    harness.step();
    harness.get_by_role_and_label(Role::Button, "Save").click();
    let start = Instant::now();
    while !notice(&harness).starts_with("wrote") {
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
        assert!(start.elapsed() < Duration::from_secs(60), "{}", notice(&harness));
    }
    let image = barnard_files::formats::read_image(&folder.path().join("out.fits"), LIMIT).unwrap();
    let scene = harness.state().document.scene();
    let options = barnard::plan::Options::within(LIMIT);
    let control = barnard::control::Control::default();
    let plan = barnard::plan::Plan::new(scene, &options, &control).unwrap();
    let rendered = barnard::backend::cpu::render(scene, &plan, &control).unwrap().0;
    assert_eq!(image.samples, rendered.samples);
}

/// A picture that is being saved can be stopped, and is asked about before the window closes; nothing is written then.
#[test]
fn saving_is_stopped() {
    let (folder, mut harness) = open();
    let export = |harness: &mut Harness<App>, name: &str| {
        let (ctx, path) = (harness.ctx.clone(), folder.path().join(name));
        let app = harness.state_mut();
        app.export = Some(Export::start(app.document.scene(), &path, (6000, 6000), LIMIT, &ctx).unwrap());
        harness.run_steps(3);
    };
    let until = |harness: &mut Harness<App>, so: &dyn Fn(&Harness<App>) -> bool| {
        let start = Instant::now();
        while !so(harness) {
            harness.step();
            std::thread::sleep(Duration::from_millis(5));
            assert!(start.elapsed() < Duration::from_secs(60), "{}", notice(harness));
        }
    };
    export(&mut harness, "one.fits");
    harness.get_by_role_and_label(Role::Button, "Stop").click();
    until(&mut harness, &|h| h.state().export.is_none());
    assert!(notice(&harness).contains("interrupted"), "{}", notice(&harness));
    export(&mut harness, "two.fits");
    let close = |harness: &mut Harness<App>| {
        harness.input_mut().viewports.entry(ViewportId::ROOT).or_default().events.push(ViewportEvent::Close);
        harness.run_steps(3);
    };
    close(&mut harness);
    harness.get_by_role_and_label(Role::Button, "Wait").click();
    harness.step();
    harness.step();
    assert!(harness.state().export.is_some() && !harness.state().session.is_closed());
    close(&mut harness);
    harness.get_by_role_and_label(Role::Button, "Stop it").click();
    until(&mut harness, &|h| h.state().session.is_closed());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A file that is dropped.
#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

/// Scenes that are dropped are opened; broken ones are told.
#[test]
fn scenes_are_dropped() {
    let (folder, mut harness) = open();
    let (other, broken) = (folder.path().join("other.toml"), folder.path().join("broken.toml"));
    std::fs::write(&other, SCENE.replace("johnson", "2mass")).unwrap();
    std::fs::write(&broken, SCENE.replace("fbm", "fog")).unwrap();
    let mut drop = |path: &Path| {
        harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
        settle(&mut harness);
        (harness.state().document.origin().clone(), notice(&harness).to_owned(), means(&harness))
    };
    let (origin, words, means) = drop(&other);
    assert!(origin == Origin::File(other.clone()) && words.is_empty() && means.iter().all(|m| *m > 0.0));
    let (origin, words, _) = drop(&broken);
    assert!(origin == Origin::File(other) && words.contains("unknown field \"fog\""), "{words}");
}

/// White is dragged on the histogram, black with Shift; the picture follows without a new march.
#[test]
fn levels_are_dragged() {
    let (_folder, mut harness) = open();
    let picture = |h: &Harness<App>| h.state().shown.as_ref().unwrap().pictures[0].clone();
    let before = picture(&harness);
    let (white, below) = (before.tone.white, harness.get_by_label_contains("black 0, white").rect());
    let place = |part: f32| below.left_top() + vec2(310.0 * part, -60.0);
    drag(&mut harness, PointerButton::Primary, place(0.3), place(0.5));
    settle(&mut harness);
    let after = picture(&harness);
    assert!(Arc::ptr_eq(&after.image, &before.image) && after.tone.white < 0.5 * white && after.colours != before.colours);
    assert_eq!(harness.state().document.scene().display.white, Level::Radiance(after.tone.white));
    harness.event(Event::ModifiersChanged(Modifiers::SHIFT));
    drag(&mut harness, PointerButton::Primary, place(0.3), place(0.2));
    settle(&mut harness);
    let darker = picture(&harness);
    assert!(darker.tone.black > 0.0 && darker.tone.black < darker.tone.white, "{:?}", darker.tone);
}

/// W flies ahead for as long as it is held, and the wheel changes how fast; what was flown to is written down.
#[test]
fn keys_fly() {
    let (_folder, mut harness) = open();
    let place = |h: &Harness<App>| h.state().flight.camera.position;
    let speed = harness.state().flight.speed;
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
    assert!(harness.state().flight.speed > 1.2 * speed, "{}", harness.state().flight.speed);
    harness.key_up(Key::W);
    harness.step();
    let there = place(&harness);
    assert!(there.z < nearer.z);
    settle(&mut harness);
    assert!(harness.state().document.scene().camera.position.distance(there) < 1e-3);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().document.text(), SCENE);
    // Ctrl+S is no flight backwards, though Ctrl is let go first.
    harness.key_down_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(5);
    settle(&mut harness);
    assert!(harness.state().document.text() == SCENE && !harness.state().document.is_changed());
    harness.key_up(Key::S);
    harness.step();
    harness.key_down(Key::S);
    harness.run_steps(5);
    assert!(place(&harness).z > 6.0 + 1e-3);
}

/// Changes that are not saved are asked about, and come back after a crash.
#[test]
fn changes_are_not_lost() {
    let (folder, path) = folder();
    let recovery = folder.path().join("data");
    let mut first = harness(app(&path, Some(recovery.clone())));
    settle(&mut first);
    first.get_by_role_and_label(Role::SpinButton, "temperature").set_value_accesskit(7000.0);
    for _ in 0..12 {
        first.step();
    }
    first.state_mut().open(&Origin::Builtin("barres_neyret"));
    first.step();
    first.step();
    assert!(first.query_by_label("Save the changes of cloud.toml?").is_some());
    first.get_by_role_and_label(Role::Button, "Cancel").click();
    first.step();
    first.step();
    assert!(first.state().document.text().contains("7000 K"));
    // A crash: nothing is closed in order.
    drop(first);
    let lost = Session::new(Some(recovery)).recovered().unwrap();
    assert_eq!(lost.origin, Origin::File(path.clone()));
    let mut document = Document::open(&path, LIMIT).unwrap();
    document.replace(&lost.text).unwrap();
    assert!(document.is_changed() && document.text() == SCENE.replace("20000 K", "7000 K"));
    document.undo().unwrap();
    assert_eq!(document.text(), SCENE);
}

/// Windows keep their changes apart: what belongs to one that lives is left alone; once it is gone without a word,
/// another takes it.
#[test]
fn windows_do_not_share_changes() {
    let (folder, path) = folder();
    let data = Some(folder.path().join("data"));
    let mut document = Document::open(&path, LIMIT).unwrap();
    document.apply(barnard_viewer::edit::Edit::set("star.0", "temperature", "7000 K")).unwrap();
    let (mut first, mut second) = (Session::new(data.clone()), Session::new(data.clone()));
    first.keep(&document, 10.0);
    assert!(second.recovered().is_none());
    second.close();
    drop(first);
    let mut third = Session::new(data.clone());
    let lost = third.recovered().unwrap();
    third.adopt(&lost);
    assert!(lost.text.contains("7000 K") && third.recovered().is_none() && Session::new(data.clone()).recovered().is_none());
    third.close();
    assert!(Session::new(data).recovered().is_none());
}

/// A scene without dust has stars that move; a thick one is looked at although its voxels are merged.
#[test]
fn scenes_without_dust_are_explored() {
    let (folder, _) = folder();
    let path = folder.path().join("gas.toml");
    let from = SCENE.find("[dust]").unwrap();
    let to = SCENE.find("[[star]]").unwrap();
    let gas = "[[emission]]\nkind = \"lines\"\ndensity = \"cloud\"\nscale = \"1e-24 W/m3/sr\"\nlines = [{ wavelength = \"550 nm\", strength = 1 }]\n\n";
    std::fs::write(&path, format!("{}{gas}{}", &SCENE[..from], &SCENE[to..])).unwrap();
    let mut harness = harness(app(&path, None));
    settle(&mut harness);
    let before = means(&harness);
    harness.state_mut().apply(barnard_viewer::edit::Edit::set("star.0", "position", "0.5 0.2 0.9 pc"));
    settle(&mut harness);
    assert_eq!(notice(&harness), "");
    assert!(means(&harness) != before && before[1] > 0.0);
}

/// The same text with another file beside it is another scene.
#[test]
fn equal_texts_of_other_folders_are_other_scenes() {
    let (folder, path) = folder();
    let document = Document::open(&path, LIMIT).unwrap();
    let other = folder.path().join("other.toml");
    std::fs::write(&other, SCENE).unwrap();
    assert!(document.physics() != Document::open(&other, LIMIT).unwrap().physics());
}

/// Undo goes on working behind a scene that was saved elsewhere.
#[test]
fn undo_outlives_saving_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (folder.path().join("one"), folder.path().join("two"));
    std::fs::create_dir_all(&one).unwrap();
    std::fs::create_dir_all(&two).unwrap();
    Document::builtin("hii_region", LIMIT).unwrap().save(&one.join("region.toml")).unwrap();
    let mut document = Document::open(&one.join("region.toml"), LIMIT).unwrap();
    document.apply(barnard_viewer::edit::Edit::set("method", "accuracy", 0.02)).unwrap();
    document.save(&two.join("region.toml")).unwrap();
    document.undo().unwrap();
    assert!(document.scene().method.accuracy != 0.02 && document.is_changed());
}

/// Bookmarks bring a view back, stand in the scene, and are taken back like any change.
#[test]
fn bookmarks_are_places() {
    let (_folder, mut harness) = open();
    harness.key_press(Key::Num3);
    harness.step();
    assert!(notice(&harness).contains("no bookmark 3"), "{}", notice(&harness));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num3);
    harness.step();
    assert!(harness.state().document.text().contains("[bookmark.3]\nkind = \"perspective\"\n"), "{}", harness.state().document.text());
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(150.0, 0.0));
    settle(&mut harness);
    assert!(harness.state().flight.camera.position.x.abs() > 1.0);
    harness.key_press(Key::Num3);
    settle(&mut harness);
    assert!(harness.state().flight.camera.position.distance(barnard::glam::DVec3::new(0.0, 0.0, 6.0)) < 1e-4);
    for _ in 0..3 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.step();
    }
    assert!(!harness.state().document.text().contains("bookmark"), "{}", harness.state().document.text());
}

/// Digits that are typed are the field's own, also where a slow frame holds them with the key that leaves it.
#[test]
fn typed_digits_are_no_bookmarks() {
    let (_folder, mut harness) = open();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num3);
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(150.0, 0.0));
    settle(&mut harness);
    let there = harness.state().flight.camera.position;
    harness.get_by_role_and_label(Role::SpinButton, "temperature").focus();
    harness.step();
    // All in one frame.
    let pressed = |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
    harness.input_mut().events.extend([Key::Num3, Key::Enter, Key::Num3].map(pressed));
    harness.step();
    assert_eq!(harness.state().flight.camera.position, there);
    harness.step();
    harness.key_press(Key::Num3);
    settle(&mut harness);
    assert!(harness.state().flight.camera.position.distance(there) > 1.0, "the digit is the window's again");
}

/// Levels stay where the first settled picture had them while the view turns and a star grows brighter: what changes is
/// what is seen.
#[test]
fn levels_are_held() {
    let (_folder, mut harness) = open();
    let white = |harness: &Harness<App>| harness.state().shown.as_ref().unwrap().pictures[0].tone.white;
    let own = |harness: &Harness<App>| {
        let picture = &harness.state().shown.as_ref().unwrap().pictures[0];
        picture.scene.display.tone(&picture.image).white
    };
    let first = white(&harness);
    assert_eq!(first, own(&harness));
    let centre = viewport(&harness).center();
    drag(&mut harness, PointerButton::Primary, centre, centre + vec2(150.0, 0.0));
    assert_eq!(white(&harness), first);
    settle(&mut harness);
    assert_eq!(white(&harness), first);
    harness.get_by_role_and_label(Role::SpinButton, "luminosity").set_value_accesskit(6000.0);
    settle(&mut harness);
    assert!(white(&harness) == first && own(&harness) > 1.2 * first, "{} {}", own(&harness), first);
    harness.key_press(Key::Num0);
    settle(&mut harness);
    assert_eq!(white(&harness), own(&harness));
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
    harness.set_size(vec2(1150.0, 1120.0));
    settle(&mut harness);
    let centre = viewport(&harness).center();
    harness.hover_at(centre);
    harness.run_steps(2);
    let probe = Rect::from_min_size(from(&harness, "Probe"), vec2(340.0, 290.0));
    looks(&mut harness, "probe", probe);
}
