//! Session state: recent scenes, and changes that were not saved when it ended.

use std::fs::File;
use std::path::{Path, PathBuf};

use barnard_files::formats::replace;
use eframe::Storage;

use barnard_explorer::document::{Document, Origin};

/// Most recent scenes that are remembered.
const RECENT: usize = 12;
/// The time that must pass before unsaved changes are written down again [s].
const EVERY: f64 = 2.0;
/// The first words of a file of unsaved changes.
const HEAD: &str = "# unsaved changes of ";
/// The name under which they are stored.
const RECENT_SCENES: &str = "recent";

/// Session state beyond one document.
#[derive(Default)]
pub struct Session {
    /// Scenes that were open, the last one first.
    pub recent: Vec<Origin>,
    /// The file to which unsaved changes are written; none: they are not written. No two windows share it.
    recovery: Option<PathBuf>,
    /// The lock that this window holds as long as it lives, so that others leave its changes alone.
    lock: Option<File>,
    written: Option<String>,
    when: f64,
    closed: bool,
}

/// Changes that a window left behind that did not end in order.
pub struct Recovered {
    /// The path of the file that keeps them.
    pub path: PathBuf,
    /// The place of the scene that was changed.
    pub origin: Origin,
    /// The text of the changed scene.
    pub text: String,
}

/// The lock beside a file, if nobody holds it.
fn locked(path: &Path) -> Option<File> {
    let lock = File::options().create(true).truncate(false).write(true).open(path.with_extension("lock")).ok()?;
    lock.try_lock().ok().map(|()| lock)
}

fn named(origin: &Origin) -> String {
    match origin {
        Origin::Builtin(name) => format!("built-in {name}"),
        Origin::Text(name) => name.clone(),
        Origin::File(path) | Origin::Bundle(path) => std::path::absolute(path).unwrap_or_else(|_| path.clone()).display().to_string(),
    }
}

fn origin(name: &str) -> Option<Origin> {
    match name.strip_prefix("built-in ") {
        Some(name) => barnard_files::builtin::entry(name).ok().map(|e| Origin::Builtin(e.name)),
        None => (!name.is_empty()).then(|| Origin::at(PathBuf::from(name))),
    }
}

impl Session {
    /// Unsaved changes are kept in `folder`.
    pub fn new(folder: Option<PathBuf>) -> Self {
        let path_and_lock = folder.and_then(|folder| {
            std::fs::create_dir_all(&folder).ok()?;
            let free = (0..).map(|n| folder.join(format!("unsaved-{}-{n}.toml", std::process::id())));
            free.take(100).filter(|path| !path.exists()).find_map(|path| locked(&path).map(|lock| (path, lock)))
        });
        let (recovery, lock) = path_and_lock.unzip();
        Self { recovery, lock, ..Self::default() }
    }

    /// Reads what was written down when a window closed.
    pub fn restore(&mut self, storage: &dyn Storage) {
        self.recent = storage.get_string(RECENT_SCENES).unwrap_or_default().lines().filter_map(origin).take(RECENT).collect();
    }

    /// Writes down what is remembered.
    pub fn save(&self, storage: &mut dyn Storage) {
        storage.set_string(RECENT_SCENES, self.recent.iter().map(named).collect::<Vec<_>>().join("\n"));
    }

    /// Takes note that a scene was opened.
    pub fn opened(&mut self, origin: &Origin) {
        self.recent.retain(|o| named(o) != named(origin));
        self.recent.insert(0, origin.clone());
        self.recent.truncate(RECENT);
    }

    /// Keeps the changes of a document that are not saved, now and then.
    pub fn keep(&mut self, document: &Document, now: f64) {
        let Some(path) = &self.recovery else { return };
        if !document.is_changed() {
            if self.written.is_some() {
                self.forget_recovery();
            }
            return;
        }
        if self.closed || now - self.when < EVERY || self.written.as_deref() == Some(document.text()) {
            return;
        }
        let text = format!("{HEAD}{}\n{}", named(document.origin()), document.text());
        let folder = path.parent().unwrap_or(Path::new(""));
        // Whoever has no place for it works on without.
        if std::fs::create_dir_all(folder).is_ok() && replace(path, text.as_bytes()).is_ok() {
            self.written = Some(document.text().to_owned());
        }
        self.when = now;
    }

    /// Changes that a window left behind, the last first; those of windows that live are theirs.
    pub fn recovered(&self) -> Option<Recovered> {
        let folder = self.recovery.as_ref()?.parent()?;
        let is_left = |path: &PathBuf| {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            Some(path) != self.recovery.as_ref() && name.starts_with("unsaved-") && name.ends_with(".toml") && locked(path).is_some()
        };
        let mut left: Vec<PathBuf> = std::fs::read_dir(folder).ok()?.flatten().map(|e| e.path()).filter(is_left).collect();
        left.sort_by_key(|path| std::fs::metadata(path).and_then(|m| m.modified()).ok());
        let read = |path: PathBuf| {
            let text = std::fs::read_to_string(&path).ok()?;
            let (first, text) = text.split_once('\n')?;
            Some(Recovered { origin: origin(first.strip_prefix(HEAD)?)?, text: text.to_owned(), path })
        };
        left.into_iter().rev().find_map(read)
    }

    /// Makes what was left behind this window's own.
    pub fn adopt(&mut self, lost: &Recovered) {
        if let Some(recovery) = &self.recovery {
            // Where it cannot be moved, it is written anew in a while.
            let _ = std::fs::rename(&lost.path, recovery);
            let _ = std::fs::remove_file(lost.path.with_extension("lock"));
        }
        self.written = Some(String::new());
    }

    /// Forgets unsaved changes: there is nothing left to recover.
    pub fn forget_recovery(&mut self) {
        if let Some(path) = &self.recovery {
            // It may not be there.
            let _ = std::fs::remove_file(path);
        }
        self.written = None;
    }

    /// Forgets unsaved changes and the lock, as the window closes in order.
    pub fn close(&mut self) {
        self.forget_recovery();
        if let Some(path) = self.recovery.as_ref().filter(|_| self.lock.take().is_some()) {
            // It may be gone.
            let _ = std::fs::remove_file(path.with_extension("lock"));
        }
        self.closed = true;
    }

    /// True if the window has closed in order.
    pub fn is_closed(&self) -> bool {
        self.closed
    }
}
