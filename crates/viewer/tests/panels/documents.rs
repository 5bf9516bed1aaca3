//! Scenes that are opened, saved, dropped and kept through a crash.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use barnard::plan::Options;
use barnard_explorer::document::{Document, Origin};
use barnard_viewer::app::App;
use barnard_viewer::export::Export;
use barnard_viewer::session::Session;
use eframe::egui::accesskit::Role;
use eframe::egui::{DroppedFile, Key, Modifiers, ViewportEvent, ViewportId};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::explorer::{LIMIT, SCENE, app, folder, harness, means, notice, open, settle, until};

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
    assert!(harness.state().model.layout.overlay);
    assert!(expected.contains("unknown field \"fog\"") && expected.contains("broken.toml:11"), "{expected}");
    assert_eq!(*harness.state().model.document.origin(), Origin::File(folder.path().join("cloud.toml")));
    assert_eq!(harness.state().model.document.text(), SCENE);
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
    assert!(!harness.state().model.document.is_changed());
    let mut builtin = Document::builtin("pillars", LIMIT).unwrap();
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
    until(&mut harness, |h| notice(h).starts_with("wrote"));
    let image = barnard_files::formats::read_image(&folder.path().join("out.fits"), LIMIT).unwrap();
    let scene = harness.state().model.document.scene();
    let options = barnard::plan::Options::within(LIMIT);
    let control = barnard::control::Control::default();
    let plan = barnard::plan::Planner::new(&options).plan(scene.clone(), None, &control).unwrap();
    let rendered = barnard::backend::Renderer::new(&mut barnard::backend::cpu::Cpu).render(&plan, &control).unwrap().0;
    assert_eq!(image.samples, rendered.samples);
}

/// A picture that is being saved can be stopped, and is asked about before the window closes; nothing is written then.
#[test]
fn saving_is_stopped() {
    let (folder, mut harness) = open();
    let export = |harness: &mut Harness<App>, name: &str| {
        let (ctx, path) = (harness.ctx.clone(), folder.path().join(name));
        let app = harness.state_mut();
        app.export = Some(Export::start(app.model.document.scene(), &path, (6000, 6000), Options::within(LIMIT), &ctx).unwrap());
        harness.run_steps(3);
    };
    export(&mut harness, "one.fits");
    harness.get_by_role_and_label(Role::Button, "Stop").click();
    until(&mut harness, |h| h.state().export.is_none());
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
    until(&mut harness, |h| h.state().session.is_closed());
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
        (harness.state().model.document.origin().clone(), notice(&harness).to_owned(), means(&harness))
    };
    let (origin, words, means) = drop(&other);
    assert!(origin == Origin::File(other.clone()) && words.is_empty() && means.iter().all(|m| *m > 0.0));
    let (origin, words, _) = drop(&broken);
    assert!(origin == Origin::File(other) && words.contains("unknown field \"fog\""), "{words}");
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
    assert!(first.state().model.document.text().contains("7000 K"));
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
    document.apply(barnard_explorer::edit::Edit::set("star.0", "temperature", "7000 K")).unwrap();
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
    let gas = r#"[[emission]]
kind = "lines"
density = "cloud"
scale = "1e-24 W/m3/sr"
lines = [{ wavelength = "550 nm", strength = 1 }]

"#;
    std::fs::write(&path, format!("{}{gas}{}", &SCENE[..from], &SCENE[to..])).unwrap();
    let mut harness = harness(app(&path, None));
    settle(&mut harness);
    let before = means(&harness);
    harness.state_mut().model.apply(barnard_explorer::edit::Edit::set("star.0", "position", "0.5 0.2 0.9 pc"));
    settle(&mut harness);
    assert_eq!(notice(&harness), "");
    assert!(means(&harness) != before && before[1] > 0.0);
}

/// A text with another file next to it is another scene.
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
    Document::builtin("pillars", LIMIT).unwrap().save(&one.join("region.toml")).unwrap();
    let mut document = Document::open(&one.join("region.toml"), LIMIT).unwrap();
    document.apply(barnard_explorer::edit::Edit::set("method", "accuracy", 0.02)).unwrap();
    document.save(&two.join("region.toml")).unwrap();
    document.undo().unwrap();
    assert!(document.scene().method.accuracy != 0.02 && document.is_changed());
}

/// Turbulence is known roughly at once, exactly once it was refined, and stays so while something else changes.
#[test]
fn turbulence_is_refined() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cloud.toml");
    let text = r#"[camera]
kind = "perspective"
position = "0 0 30 pc"
field_of_view = "25 deg"
size = [8, 8]
[field.t]
kind = "turbulence"
voxels = 80
[dust]
density = "2 * t"
scale = "1 /pc"
law = "gordon23"
"#;
    std::fs::write(&path, text).unwrap();
    let mut document = Document::open(&path, LIMIT).unwrap();
    let edge = |document: &Document| document.scene().dust.as_ref().unwrap().density.grid().unwrap().lattice().dims[0];
    assert!(document.is_rough() && edge(&document) == 64);
    document.refine(None, None, |_| ());
    while !document.take_refined().unwrap() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(!document.is_rough() && edge(&document) == 80);
    document.apply(barnard_explorer::edit::Edit::set("dust", "albedo", 0.4)).unwrap();
    assert!(!document.is_rough() && edge(&document) == 80);
    document.apply(barnard_explorer::edit::Edit::set("field.t", "mach", 3.0)).unwrap();
    assert!(document.is_rough() && edge(&document) == 64);
}

/// Gas that stars ionise is known roughly at once, exactly once it was refined; another text is refined anew.
#[test]
fn gas_is_refined() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gas.toml");
    let text = r#"bands = ["hst-wfc3-f656n"]
[camera]
kind = "perspective"
position = "0 0 30 pc"
field_of_view = "25 deg"
size = [8, 8]
[field.ball]
kind = "sphere"
radius = "2 pc"
[gas]
density = "300 * ball"
voxels = 52
[[star]]
kind = "blackbody"
position = "0 0 0 pc"
temperature = "40000 K"
luminosity = "1e4 Lsun"
"#;
    std::fs::write(&path, text).unwrap();
    let mut document = Document::open(&path, LIMIT).unwrap();
    let edge = |document: &Document| document.scene().species()[0].density.grid().unwrap().lattice().dims[0];
    assert!(document.is_rough() && edge(&document) == 48);
    let settle = |document: &mut Document| {
        let heard = Arc::new(AtomicBool::new(false));
        let ears = heard.clone();
        document.refine(None, None, move |part| ears.store(ears.load(Ordering::Relaxed) || part.is_some(), Ordering::Relaxed));
        while !document.take_refined().unwrap() {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        assert!(heard.load(Ordering::Relaxed));
    };
    let rough = document.physics();
    settle(&mut document);
    assert!(!document.is_rough() && edge(&document) == 52 && document.physics() != rough);
    document.apply(barnard_explorer::edit::Edit::set("star.0", "temperature", "35000 K")).unwrap();
    assert!(document.is_rough() && edge(&document) == 48);
    settle(&mut document);
    assert!(!document.is_rough() && edge(&document) == 52);
    // What is known is not made again.
    document.undo().unwrap();
    assert!(!document.is_rough() && !document.take_refined().unwrap());
}
