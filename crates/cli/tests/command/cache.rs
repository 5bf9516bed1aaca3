//! The cache of long computations: pictures are the same with it, and no process leaves it broken.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use barnard::fixtures::SMALL_GAS;

use super::desk::{Desk, barnard};

fn cached(desk: &Desk, arguments: &[&str]) -> Command {
    let mut command = barnard();
    command.args(arguments).current_dir(desk.folder.path()).env("BARNARD_CACHE", desk.path("cache"));
    command
}

fn rendering(desk: &Desk, output: &str) -> Child {
    cached(desk, &["render", "gas.toml", "-o", output]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn answer(desk: &Desk, arguments: &[&str]) -> String {
    let output = cached(desk, arguments).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn files(folder: &Path) -> usize {
    std::fs::read_dir(folder).map_or(0, Iterator::count)
}

/// Processes that run at once and processes that are killed at any time leave a cache from which the next reads the same picture.
#[test]
fn killed_and_concurrent_processes_share_the_cache() {
    let desk = Desk::new();
    desk.write("gas.toml", SMALL_GAS.as_bytes());
    assert!(barnard().args(["render", "gas.toml", "-o", "alone.npy"]).current_dir(desk.folder.path()).status().unwrap().success());
    let alone = std::fs::read(desk.path("alone.npy")).unwrap();
    for milliseconds in [20, 80, 160, 320, 640] {
        let mut child = rendering(&desk, "killed.npy");
        std::thread::sleep(Duration::from_millis(milliseconds));
        let _ = child.kill();
        child.wait().unwrap();
    }
    let mut together = ["a.npy", "b.npy", "c.npy"].map(|output| (output, rendering(&desk, output)));
    for (output, child) in &mut together {
        assert!(child.wait().unwrap().success());
        assert!(std::fs::read(desk.path(output)).unwrap() == alone, "{output}");
    }
    let info = answer(&desk, &["cache", "info"]);
    assert!(info.contains("gas") && info.contains("fields") && info.contains("limit   4.00 GiB"), "{info}");
    assert!(answer(&desk, &["cache", "clear"]).starts_with("removed "));
    assert!(answer(&desk, &["cache", "info"]).contains("used    0 B in 0 records"));
    // Without the cache nothing is stored.
    let before = files(&desk.path("cache"));
    answer(&desk, &["render", "gas.toml", "-o", "d.npy", "--no-cache"]);
    assert!(files(&desk.path("cache")) == before && std::fs::read(desk.path("d.npy")).unwrap() == alone);
}

/// A limit that is no size is an error with a remedy, and a folder that cannot be written is none.
#[test]
fn wrong_settings_of_the_cache() {
    let desk = Desk::new();
    desk.write("gas.toml", SMALL_GAS.as_bytes());
    let output = cached(&desk, &["render", "gas.toml", "-o", "x.npy"]).env("BARNARD_CACHE_SIZE", "-1").output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && message.contains("BARNARD_CACHE_SIZE=-1 is no size; give a positive number of GiB"), "{message}");
    desk.write("file", b"not a folder");
    let output = cached(&desk, &["render", "gas.toml", "-o", "x.npy"]).env("BARNARD_CACHE", desk.path("file")).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let info = barnard().args(["cache", "info"]).output().unwrap();
    assert!(String::from_utf8(info.stdout).unwrap().starts_with("no cache"));
}
