//! A folder with a small scene in it, in which the command is run.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use barnard::fixtures::small_cloud;

pub struct Desk {
    pub folder: tempfile::TempDir,
}

/// The small cloud, from a file.
pub fn scene() -> String {
    let grid = "kind = \"grid\"\nfile = \"cloud.npy\"\nlow = \"-1 -1 -1 pc\"\nhigh = \"1 1 1 pc\"";
    small_cloud(&[("kind = \"fbm\"\nradius = \"1 pc\"", grid)])
}

/// A version 1.0 .npy file.
pub fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(data);
    bytes
}

pub fn cloud(change: impl Fn(usize) -> f32) -> Vec<u8> {
    let data: Vec<u8> = (0..512).flat_map(|i| change(i).to_le_bytes()).collect();
    npy("<f4", "(8, 8, 8)", &data)
}

impl Desk {
    pub fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.write("cloud.npy", &cloud(|i| 0.5 + 0.4 * (i as f32).sin()));
        desk.write("scene.toml", scene().as_bytes());
        desk
    }
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
    pub fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }
    pub fn with(&self, from: &str, to: &str) -> &Self {
        let scene = scene();
        assert!(scene.contains(from), "{from}");
        self.write("scene.toml", scene.replace(from, to).as_bytes());
        self
    }
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = barnard();
        command.args(arguments).current_dir(self.folder.path());
        command
    }
    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }
    /// Renders the scene and expects that it goes well.
    pub fn renders(&self, arguments: &[&str]) {
        let output = self.run(&[&["render", "scene.toml"], arguments].concat());
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    /// Renders and expects a message with all of `words`, a failing status, no panic and no file.
    pub fn refuses(&self, arguments: &[&str], words: &[&str]) {
        let before = listing(self.folder.path());
        let output = self.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{arguments:?} went through");
        assert!(output.status.code().is_some_and(|c| c == 1 || c == 2), "{:?}: {message}", output.status);
        for word in words {
            assert!(message.contains(word), "\"{word}\" is not in: {message}");
        }
        assert!(!message.contains("panicked"), "{message}");
        assert_eq!(before, listing(self.folder.path()), "files were left behind");
    }
    pub fn refuses_scene(&self, words: &[&str]) {
        self.refuses(&["render", "scene.toml", "-o", "out.npy"], words);
    }
}

pub fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    names
}

/// The program, without a cache.
pub fn barnard() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_barnard"));
    command.env("BARNARD_CACHE", "off");
    command
}
