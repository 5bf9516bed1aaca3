//! Frames of a scene that changes: each once and whole, whoever renders them and however they end.

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::desk::{Desk, barnard, listing, scene};

/// A flight of eleven frames.
fn desk() -> Desk {
    let desk = Desk::new();
    let path = r#"[[camera.path.key]]
time = "0 s"
position = "0 0 5 pc"
[[camera.path.key]]
time = "1 s"
position = "3 0 4 pc"
[sequence]
frames_per_second = 10
"#;
    let text =
        scene().replace("position = \"0 0 5 pc\"\n", "").replace("bands = \"johnson\"\n", "bands = \"johnson\"\nname = \"flight\"\n");
    desk.write("flight.toml", format!("{text}{path}").as_bytes());
    std::fs::create_dir(desk.path("out")).unwrap();
    desk
}

fn start(desk: &Desk, rest: &[&str]) -> Child {
    let arguments = ["render", "flight.toml", "-o", "out/f_%04d.npy", "--threads", "1"];
    barnard().args(arguments).args(rest).current_dir(desk.folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// What a run says of each frame: number and status.
fn statuses(child: Child) -> Vec<(i64, String)> {
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let line = |line: &str| {
        let report: serde_json::Value = serde_json::from_str(line).unwrap();
        (report["frame"].as_i64().unwrap(), report["status"].as_str().unwrap().to_owned())
    };
    String::from_utf8(output.stdout).unwrap().lines().map(line).collect()
}

fn frames(desk: &Desk) -> Vec<(String, Vec<u8>)> {
    let label =
        |path: std::path::PathBuf| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&path).unwrap_or_default());
    // The record of the scene is the same in each folder.
    listing(&desk.path("out")).into_iter().map(label).filter(|(name, _)| !name.ends_with(".scene")).collect()
}

/// Frames of another scene, or of other settings, are neither resumed nor mixed with new ones.
#[test]
fn frames_of_two_scenes_are_not_mixed() {
    let desk = desk();
    statuses(start(&desk, &["--frames", "1-2"]));
    let old = frames(&desk);
    let darker = "star[0].luminosity=1 Lsun";
    for other in [["--frames", "1-3", "--set", darker], ["--frames", "3", "--set", darker], ["--frames", "1-3", "--size", "9x9"]] {
        let output = start(&desk, &other).wait_with_output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && error.contains("f_0001.npy") && error.contains("--overwrite"), "{error}");
    }
    assert!(frames(&desk) == old);
    // One old frame would stay.
    assert!(!start(&desk, &["--frames", "1", "--overwrite", "--set", darker]).wait_with_output().unwrap().status.success());
    statuses(start(&desk, &["--frames", "1-2", "--overwrite", "--set", darker]));
    statuses(start(&desk, &["--frames", "1-3", "--set", darker]));
    assert!(frames(&desk).len() == 3 && frames(&desk)[..2].iter().zip(&old).all(|(new, old)| new.1 != old.1));
}

/// All frames are rendered, a second run finds them there, and shards and single frames are the same files.
#[test]
fn frames_are_the_same_in_whatever_order() {
    let whole = desk();
    let all = statuses(start(&whole, &["--frames", "all"]));
    assert_eq!(all.iter().map(|(number, _)| *number).collect::<Vec<_>>(), (1..=11).collect::<Vec<_>>());
    assert!(all.iter().all(|(_, status)| status == "rendered"));
    let written = frames(&whole);
    assert_eq!((written.len(), written[0].0.as_str(), written[10].0.as_str()), (11, "f_0001.npy", "f_0011.npy"));
    assert!(statuses(start(&whole, &["--frames", "all"])).iter().all(|(_, status)| status == "exists"));
    assert!(statuses(start(&whole, &["--frames", "3", "--overwrite"])) == [(3, "rendered".to_owned())]);
    let parts = desk();
    assert_eq!(statuses(start(&parts, &["--frames", "1-11", "--shard", "2/3"])).len(), 4);
    statuses(start(&parts, &["--frames", "7,1-3"]));
    statuses(start(&parts, &["--frames", "all"]));
    assert!(written == frames(&parts) && written == frames(&whole));
    assert!(written.windows(2).all(|pair| pair[0].1 != pair[1].1), "the camera moves");
}

/// A run that is killed, again and again, leaves whole frames alone; the next one brings what is missing.
#[cfg(unix)]
#[test]
fn killed_runs_are_resumed() {
    let (whole, killed) = (desk(), desk());
    statuses(start(&whole, &["--frames", "all"]));
    let expected = frames(&whole);
    for round in 0..12u64 {
        let mut child = start(&killed, &["--frames", "all"]);
        // At moments that have nothing to do with what it does.
        std::thread::sleep(Duration::from_millis(20 + 37 * round % 230));
        child.kill().unwrap();
        child.wait().unwrap();
        let visible = frames(&killed).into_iter().filter(|(name, _)| !name.starts_with('.'));
        for label in visible {
            assert!(expected.contains(&label), "{} is not whole", label.0);
        }
    }
    statuses(start(&killed, &["--frames", "all"]));
    let names = |all: &[(String, Vec<u8>)]| all.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&frames(&killed)), names(&expected));
    assert!(frames(&killed) == expected);
}

/// Two runs on the same frames: each frame is rendered by one of them.
#[test]
fn runs_share_their_frames() {
    let desk = desk();
    let (a, b) = (start(&desk, &["--frames", "all"]), start(&desk, &["--frames", "all"]));
    let all = [statuses(a), statuses(b)].concat();
    let rendered = |number: i64| all.iter().filter(|(rendered_number, status)| *rendered_number == number && status == "rendered").count();
    assert!((1..=11).all(|number| rendered(number) == 1), "{all:?}");
    assert_eq!(frames(&desk).len(), 11);
}

#[test]
fn impossible_frames_are_refused() {
    let desk = desk();
    let render = |rest: &[&'static str]| [&["render", "flight.toml", "-o", "out/f_%04d.npy"], rest].concat();
    desk.refuses(&render(&["--frames", "5-1"]), &["5-1", "1-5"]);
    desk.refuses(&render(&["--frames", "1-12"]), &["frame 12 does not exist", "1 to 11"]);
    desk.refuses(&render(&["--frames", "some"]), &["\"some\"", "all"]);
    desk.refuses(&render(&["--frames", "1", "--shard", "3/2"]), &["3/8"]);
    desk.refuses(&render(&["--shard", "1/2"]), &["--frames"]);
    desk.refuses(&render(&["--frames", "all", "--backend", "path"]), &["--frames", "cpu or gpu"]);
    desk.refuses(&["render", "flight.toml", "-o", "out/f.npy", "--frames", "all"], &["f.npy", "%06d"]);
    desk.refuses(&["render", "flight.toml", "-o", "out/f.npy", "--frames", "1-3", "--shard", "1/3"], &["f.npy", "%06d"]);
    desk.refuses(&["render", "flight.toml", "-o", "no/f_%d.npy", "--frames", "all"], &["does not exist"]);
    desk.refuses(&["render", "flight.toml", "-o", "out/f_%d.gif", "--frames", "all"], &["gif"]);
    desk.refuses(&["render", "scene.toml", "-o", "out/f_%d.npy", "--frames", "all"], &["timeline", "[camera.path]"]);
    let folder = listing(&desk.path("out"));
    assert!(folder.is_empty(), "{folder:?}");
}

/// A disk that becomes full in the middle: what is written is whole, what is not is not there.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_whole_frames() {
    let desk = desk();
    let program = env!("CARGO_BIN_EXE_barnard");
    let script = format!("trap '' XFSZ; ulimit -f 1; exec {program} render flight.toml -o out/f_%d.npy --size 64x64 --frames all");
    let output = Command::new("sh").env("BARNARD_CACHE", "off").args(["-c", &script]).current_dir(desk.folder.path()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("frame 1") && message.contains("cannot be written"), "{message}");
    assert!(frames(&desk).is_empty(), "{:?}", listing(&desk.path("out")));
}

/// Two eyes are one image, or a file each, of a still and of frames.
#[test]
fn eyes_have_files_of_their_own() {
    let desk = desk();
    let flight = std::fs::read_to_string(desk.path("flight.toml")).unwrap();
    desk.write("flight.toml", format!("{flight}[camera.stereo]\neye_distance = \"0.4 pc\"\n").as_bytes());
    statuses(start(&desk, &["-o", "out/%V_%03d.npy", "--frames", "4"]));
    let read = |name: &str| barnard_files::formats::read_image(&desk.path("out").join(name), 1 << 30).unwrap();
    let (both, left, right) = (read("f_0004.npy"), read("left_004.npy"), read("right_004.npy"));
    assert_eq!((both.width, both.height, left.width, left.height), (16, 24, 16, 12));
    for (row, column, band) in [(0, 0, 0), (5, 9, 1), (11, 15, 2)] {
        assert_eq!(both.at(band, row, column), left.at(band, row, column));
        assert_eq!(both.at(band, row + 12, column), right.at(band, row, column));
    }
    assert!(left.samples != right.samples);
    desk.refuses(&["render", "scene.toml", "-o", "out/%V.npy"], &["%V", "[camera.stereo]"]);
}

/// A frame has the same file whether others were rendered before it or not, with all that it says of itself but the time at which
/// it was written.
#[test]
#[ignore = "long"]
fn files_do_not_depend_on_frames_before() {
    let desk = desk();
    let write = |rest: &[&str]| {
        drop(statuses(start(&desk, &[&["-o", "out/f_%02d.png", "--bounces", "4", "--overwrite", "--frames"], rest].concat())))
    };
    write(&["3,6"]);
    let after = std::fs::read(desk.path("out/f_06.png")).unwrap();
    write(&["6"]);
    assert!(after == std::fs::read(desk.path("out/f_06.png")).unwrap());
    assert!(after != std::fs::read(desk.path("out/f_03.png")).unwrap());
    // One name without a number is that of the frame that was asked for last.
    write(&["3", "-o", "out/still.png"]);
    let first = std::fs::read(desk.path("out/still.png")).unwrap();
    write(&["6", "-o", "out/still.png"]);
    assert!(first != std::fs::read(desk.path("out/still.png")).unwrap());
}
