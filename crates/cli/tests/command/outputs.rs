//! Outputs that cannot be, and renders that are stopped: no file is left behind.

use std::process::Command;

use super::desk::{Desk, barnard, listing};

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
    let mut child = barnard()
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
    desk.refuses(&["render", "scene.toml", "-o", "/proc/out.npy"], &["/proc", "not writable"]);
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
    let output = Command::new("sh").env("BARNARD_CACHE", "off").args(["-c", &script]).current_dir(desk.folder.path()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("out.npy") && message.contains("cannot be written"), "{message}");
    assert_eq!(before, listing(desk.folder.path()));
}

/// A scene comes from the standard input and a picture goes to the standard output, without a word in between.
#[test]
#[cfg(unix)]
fn scenes_and_pictures_go_through_pipes() {
    use std::io::Write;
    use std::process::Stdio;
    let desk = Desk::new();
    let through = |arguments: &[&str]| {
        let mut command = barnard();
        let mut child = command
            .args(arguments)
            .current_dir(desk.folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(super::desk::scene().as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    };
    for name in ["-", "/dev/stdin"] {
        let output = through(&["render", name, "-o", "png:-"]);
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && words.contains("relative error"), "{words}");
        assert!(output.stdout.starts_with(b"\x89PNG") && output.stdout.ends_with(b"IEND\xaeB`\x82"));
    }
    desk.refuses(&["render", "scene.toml", "-o", "-"], &["-o png:-"]);
    desk.refuses(&["render", "scene.toml", "-o", "gif:-"], &[".gif"]);
}

/// What a text alone says wrong is said before fields are made, and a star that flashes is warned of.
#[test]
fn texts_are_read_before_fields_are_made() {
    let desk = Desk::new();
    // Turbulence that memory does not hold: what is wrong with the formula is said first.
    let slow = r#"
[field.t]
kind = "turbulence"
seed = 1
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
voxels = 2048
mach = 5
"#;
    let glow = r#"[[emission]]
kind = "lines"
density = "DENSITY"
scale = "1e-25 W/m3/sr"
lines = [{ wavelength = "656.46 nm", strength = 1 }]
"#;
    for (density, words) in [("t * missing", "missing"), ("t * (1 +", "emission"), ("nosuch(t)", "nosuch")] {
        desk.write("slow.toml", format!("{}{slow}{}", super::desk::scene(), glow.replace("DENSITY", density)).as_bytes());
        desk.refuses(&["check", "slow.toml"], &[words]);
    }
    let flash = r#"
[[animation]]
of = "star[0].luminosity"
times = ["0 s", "1 s"]
values = ["1 Lsun", "500 Lsun"]
[sequence]
frames_per_second = 2
"#;
    desk.write("flash.toml", format!("{}{flash}", super::desk::scene()).as_bytes());
    let output = desk.run(&["render", "flash.toml", "--frames", "1", "-o", "frame_%02d.npy"]);
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && words.contains("light echo"), "{words}");
    desk.write("slow.toml", format!("{}{}", super::desk::scene(), flash.replace("1 Lsun", "480 Lsun")).as_bytes());
    let output = desk.run(&["render", "slow.toml", "--frames", "1", "-o", "calm_%02d.npy"]);
    assert!(output.status.success() && !String::from_utf8_lossy(&output.stderr).contains("light echo"));
}
