//! Outputs that cannot be, and renders that are stopped: no file is left behind.

use std::process::Command;

use super::desk::{Desk, listing};

#[test]
fn impossible_sizes_and_outputs_are_refused_at_once() {
    let desk = Desk::new();
    let render = |rest: &[&'static str]| [&["render", "scene.toml"], rest].concat();
    desk.refuses(&render(&["-o", "missing/out.npy"]), &["missing", "does not exist"]);
    desk.refuses(&render(&["-o", "out.gif"]), &["gif", ".png"]);
    desk.refuses(&render(&["-o", "out.npy", "--size", "0x5"]), &["1920x1080"]);
    desk.refuses(&render(&["-o", "out.npy", "--size", "60000x60000"]), &["MiB", "the image"]);
    desk.refuses(&render(&["-o", "out.npy", "--memory", "0.000001"]), &["MiB"]);
    desk.refuses(&render(&["-o", "out.npy", "--accuracy", "0"]), &["accuracy"]);
    desk.refuses(&render(&["-o", "out.npy", "--method", "midpont"]), &["midpont", "midpoint"]);
    desk.refuses(&["render", "nowhere.toml", "-o", "out.npy"], &["nowhere.toml"]);
    desk.refuses(&["render", "--builtin", "pilars", "-o", "out.npy"], &["pilars", "pillars"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_leaves_nothing() {
    let desk = Desk::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_barnard"))
        .args(["render", "scene.toml", "-o", "out.npy", "--size", "6000x6000", "--backend", "reference"])
        .current_dir(desk.folder.path())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(800));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait().unwrap();
    assert_eq!(output.code(), Some(1));
    assert_eq!(listing(desk.folder.path()).len(), 2, "files were left behind");
}

/// A folder that takes no file, not even from root.
#[cfg(target_os = "linux")]
#[test]
fn an_unwritable_folder_is_refused() {
    let desk = Desk::new();
    desk.refuses(&["render", "scene.toml", "-o", "/proc/out.npy"], &["/proc", "cannot be written"]);
}

#[test]
fn inputs_are_not_overwritten() {
    let desk = Desk::new();
    let before = std::fs::read(desk.path("cloud.npy")).unwrap();
    desk.refuses(&["render", "scene.toml", "-o", "cloud.npy"], &["cloud.npy", "another name"]);
    desk.refuses(&["render", "scene.toml", "-o", "./../../nowhere/../cloud.npy"], &["cloud.npy"]);
    std::fs::rename(desk.path("scene.toml"), desk.path("scene.png")).unwrap();
    desk.refuses(&["render", "scene.png", "-o", "scene.png"], &["another name"]);
    assert_eq!(before, std::fs::read(desk.path("cloud.npy")).unwrap());
}

/// A disk that is full: a file size limit makes the system refuse the bytes, as a full disk does.
#[cfg(unix)]
#[test]
fn a_refused_write_leaves_nothing() {
    let desk = Desk::new();
    let before = listing(desk.folder.path());
    let script = format!("trap '' XFSZ; ulimit -f 1; exec {} render scene.toml -o out.npy --size 64x64", env!("CARGO_BIN_EXE_barnard"));
    let output = Command::new("sh").args(["-c", &script]).current_dir(desk.folder.path()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("out.npy") && message.contains("cannot be written"), "{message}");
    assert_eq!(before, listing(desk.folder.path()));
}
