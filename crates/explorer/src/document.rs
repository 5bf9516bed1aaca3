//! The scene that is open: the text of its file, what that says, and what it said before.
//!
//! The text is the truth. Every edit changes keys of it and reads it again as `barnard check` would, so nothing can be
//! set that a file could not say, comments stay, and what is saved is what was seen.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use barnard::Result;
use barnard::cache::Cache;
use barnard::control::Control;
use barnard::scene::{Loader, RayTracer, Scene, Star};
use barnard::sequence::{Follower, Sequence};
use barnard_files::bundle::Bundle;
use barnard_files::{SceneFiles, builtin, toml};
use spectra::fingerprint::Fingerprint;
use toml_edit::DocumentMut;

use crate::edit::{Edit, count};
pub use crate::origin::Origin;
use crate::reading::{Reading, edited, physics, read};

/// Texts that can be gone back to, at most; and their bytes.
const PAST: (usize, usize) = (1000, 64 << 20);

/// A scene that is open: its text, and what the text means.
pub struct Document {
    origin: Origin,
    files: Arc<SceneFiles>,
    loader: Loader,
    text: String,
    saved: String,
    toml: DocumentMut,
    scene: Arc<Scene>,
    physics: Fingerprint,
    /// Sets equal texts of two openings apart: their files may be others.
    opening: u64,
    /// The moment that is shown of a scene that changes [s].
    moment: f64,
    /// Timeline; `None` for static scenes.
    followed: Option<Follower>,
    past: Vec<String>,
    future: Vec<String>,
    /// The edit that the next of the same name goes on with.
    going_on: Option<String>,
    refining: Option<Refining>,
}

/// Background refinement of rough results.
struct Refining {
    /// Initial text without camera and display.
    physics: Fingerprint,
    control: Control,
    /// The exact scene once it is done; what went wrong, where it failed.
    done: Receiver<Result<Arc<Scene>>>,
    failure: Option<String>,
}

impl Drop for Refining {
    fn drop(&mut self) {
        self.control.interrupt();
    }
}

impl Document {
    /// The scene of that origin.
    ///
    /// # Errors
    /// Errors of [`builtin`](Self::builtin) and [`open`](Self::open).
    pub fn of(origin: &Origin, memory_limit: u64) -> Result<Self> {
        match origin {
            Origin::Builtin(name) => Self::builtin(name, memory_limit),
            Origin::File(path) => Self::open(path, memory_limit),
            Origin::Bundle(path) => Self::from_bundle(origin.clone(), &Bundle::open(path, memory_limit)?, memory_limit),
            Origin::Text(name) => Err(barnard::Error::missing(format!("the text of {name}"), "paste it again")),
        }
    }

    /// Opens a built-in scene.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn builtin(name: &str, memory_limit: u64) -> Result<Self> {
        let entry = builtin::entry(name)?;
        Self::new(Origin::Builtin(entry.name), entry.text.to_owned(), builtin::files(), memory_limit)
    }

    /// The scene file at `path`.
    ///
    /// # Errors
    /// Errors of `barnard check`.
    pub fn open(path: &Path, memory_limit: u64) -> Result<Self> {
        let text = barnard_files::read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::new(Origin::File(path.to_owned()), text, Arc::new(SceneFiles::in_folder(folder)), memory_limit)
    }

    /// A text without a file, with the files that it names.
    ///
    /// # Errors
    /// Errors of `barnard check`.
    pub fn from_text(name: &str, text: String, files: Arc<SceneFiles>, memory_limit: u64) -> Result<Self> {
        Self::new(Origin::Text(name.to_owned()), text, files, memory_limit)
    }

    /// The scene of a bundle, whose gas is known exactly.
    ///
    /// # Errors
    /// Errors of `barnard check`.
    pub fn from_bundle(origin: Origin, bundle: &Bundle, memory_limit: u64) -> Result<Self> {
        let files = bundle.files()?;
        let loader = Loader::new(files.clone(), memory_limit).with_given(bundle.results());
        Self::by(origin, bundle.text.clone(), files, loader.clone(), &loader)
    }

    fn new(origin: Origin, text: String, files: Arc<SceneFiles>, memory_limit: u64) -> Result<Self> {
        let loader = Loader::new(files.clone(), memory_limit);
        let roughly = loader.roughly();
        Self::by(origin, text, files, loader, &roughly)
    }

    /// A text, which `first` reads at first.
    fn by(origin: Origin, text: String, files: Arc<SceneFiles>, loader: Loader, first: &Loader) -> Result<Self> {
        static OPENINGS: AtomicU64 = AtomicU64::new(0);
        let opening = OPENINGS.fetch_add(1, Ordering::Relaxed);
        let Reading { toml, scene, physics, followed } = read(&origin, &text, first, opening)?;
        Ok(Self {
            opening,
            moment: 0.0,
            followed,
            saved: text.clone(),
            origin,
            files,
            loader,
            text,
            toml,
            scene,
            physics,
            past: Vec::new(),
            future: Vec::new(),
            going_on: None,
            refining: None,
        })
    }

    /// The place that the document is from.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// The scene that the text means.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The stars that have tables of their own, which can be taken hold of; those of a CSV cannot.
    pub fn stars(&self) -> &[Star] {
        let stars = &self.scene.stars;
        &stars[..count(self.toml.as_table(), "star").min(stars.len())]
    }

    /// Fingerprint of all that a plan depends on but the camera: where that is equal, a plan holds.
    pub fn physics(&self) -> Fingerprint {
        self.physics
    }

    /// True if the scene is known roughly: the document is to be refined.
    pub fn is_rough(&self) -> bool {
        self.scene.is_rough
    }

    /// True if no finer scene is to come: it is known exactly, or cannot be.
    pub fn is_final(&self) -> bool {
        !self.is_rough() || self.failure().is_some()
    }

    /// Begins to compute exactly what is known roughly, unless that is under way or has failed: with a device that traces light and a
    /// cache, if any. `heard` receives the finished share \[1\], and `None` at the end. Work for other gas is cancelled.
    pub fn refine(
        &mut self,
        tracer: Option<Arc<dyn RayTracer>>,
        cache: Option<Arc<dyn Cache>>,
        heard: impl Fn(Option<f64>) + Send + Sync + 'static,
    ) {
        if !self.is_rough() || self.refining.as_ref().is_some_and(|refining| refining.physics == self.physics) {
            return;
        }
        let heard = Arc::new(heard);
        let of_part = heard.clone();
        let control = Control::with_listener(move |_, done, all| of_part(Some(done as f64 / all.max(1) as f64)));
        let loader = self.loader.under(&control).traced_by(tracer).with_cache(cache).at(self.moment);
        let (origin, text, opening) = (self.origin.clone(), self.text.clone(), self.opening);
        let (sender, done) = channel();
        std::thread::spawn(move || {
            // In threads of its own: the window's and the pictures' work does not wait behind it.
            let read = || read(&origin, &text, &loader, opening).map(|reading| reading.scene);
            let made = rayon::ThreadPoolBuilder::new().build().map_or_else(|_| read(), |pool| pool.install(read));
            // The result is dropped if other gas is refined by now.
            let _ = sender.send(made);
            heard(None);
        });
        self.refining = Some(Refining { physics: self.physics, control, done, failure: None });
    }

    /// Computes exactly what is known roughly, before it returns.
    ///
    /// # Errors
    /// If it cannot be computed, or `control` stops it.
    pub fn refine_now(&mut self, control: &Control) -> Result<()> {
        let reading = read(&self.origin, &self.text, &self.loader.under(control).at(self.moment), self.opening)?;
        self.take(reading);
        Ok(())
    }

    /// Takes what was refined, where it is there; true where the scene has changed.
    ///
    /// # Errors
    /// Once, where what is known roughly cannot be found out exactly; [`failure`](Self::failure) says it from then on.
    pub fn take_refined(&mut self) -> Result<bool> {
        let Some(refining) = self.refining.as_mut().filter(|refining| refining.failure.is_none()) else { return Ok(false) };
        match refining.done.try_recv() {
            Err(TryRecvError::Empty) => Ok(false),
            Err(TryRecvError::Disconnected) => {
                refining.failure = Some("it ended without a message".into());
                Ok(false)
            }
            Ok(Err(error)) => {
                refining.failure = Some(error.to_string());
                Err(error)
            }
            Ok(Ok(_found)) => {
                // What was found is kept as long as its scene is held, so that the text of now, which may have another camera,
                // has it at once.
                let reading = read(&self.origin, &self.text, &self.loader.roughly().at(self.moment), self.opening)?;
                self.refining = None;
                self.take(reading);
                Ok(true)
            }
        }
    }

    /// Shows another moment of a scene that changes \[s\].
    ///
    /// # Errors
    /// If the scene cannot be at that moment; what was shown stays.
    pub fn show_moment(&mut self, moment: f64) -> Result<()> {
        if let Some(followed) = self.followed.as_mut().filter(|_| self.moment != moment) {
            let scene = followed.scene(moment, &Control::default())?;
            self.physics = physics(&scene, self.opening);
            self.scene = Arc::new(scene);
        }
        self.moment = moment;
        Ok(())
    }

    /// The frames of the scene, with exact gas; a device traces light and a cache keeps results, if any.
    ///
    /// # Errors
    /// If nothing of the scene changes.
    pub fn sequence(&self, tracer: Option<Arc<dyn RayTracer>>, cache: Option<Arc<dyn Cache>>) -> Result<Sequence> {
        let loader = self.loader.traced_by(tracer).with_cache(cache);
        Sequence::new(toml::properties(&self.origin.names().0, &self.text)?, loader, &self.scene)
    }

    /// True if the camera follows keys or a file.
    pub fn has_path(&self) -> bool {
        crate::edit::table(self.toml.as_table(), "camera.path").is_some()
    }

    /// True if the moment says anything of the camera, so that it is not flown by hand alone.
    pub fn moves_camera(&self) -> bool {
        self.scene.timeline.as_ref().is_some_and(|timeline| timeline.moves_camera())
    }

    /// Why what is known roughly cannot be found out exactly, where that is so.
    pub fn failure(&self) -> Option<&str> {
        self.refining.as_ref().and_then(|refining| refining.failure.as_deref())
    }

    /// The text as it would be saved.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The tables of the text.
    pub fn toml(&self) -> &DocumentMut {
        &self.toml
    }

    /// True if there is something to save.
    pub fn is_changed(&self) -> bool {
        self.text != self.saved
    }

    /// Changes the text, if what it then says is a scene. Edits of one name that follow each other are undone together,
    /// until [`rest`](Self::rest).
    ///
    /// # Errors
    /// Errors of `barnard check`; nothing is changed then.
    pub fn apply(&mut self, edit: Edit) -> Result<()> {
        let mut toml = self.toml.clone();
        let name = edit.name.clone();
        edit.apply(&mut toml);
        let text = toml.to_string();
        if text == self.text {
            return Ok(());
        }
        let reading = read(&self.origin, &text, &self.loader.roughly().at(self.moment), self.opening)?;
        let before = std::mem::replace(&mut self.text, text);
        if self.going_on.as_ref() != Some(&name) {
            self.past.push(before);
            self.going_on = Some(name);
        }
        self.future.clear();
        while self.past.len() > PAST.0 || self.past.iter().map(String::len).sum::<usize>() > PAST.1 {
            self.past.remove(0);
        }
        self.take(reading);
        Ok(())
    }

    /// The scene after `edit`, which is not kept, and what its text then says beside camera and display.
    ///
    /// # Errors
    /// Errors of `barnard check`.
    pub fn variant(&self, edit: Edit) -> Result<(Arc<Scene>, Fingerprint)> {
        let mut toml = self.toml.clone();
        edit.apply(&mut toml);
        let reading = read(&self.origin, &toml.to_string(), &self.loader.roughly().at(self.moment), self.opening)?;
        Ok((reading.scene, reading.physics))
    }

    /// The next edit is one of its own.
    pub fn rest(&mut self) {
        self.going_on = None;
    }

    /// True if there is an edit to take back.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// True if there is an edit to do again.
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Takes the last edit back.
    ///
    /// # Errors
    /// If a file that the scene names has gone since.
    pub fn undo(&mut self) -> Result<()> {
        self.step(|d| (&mut d.past, &mut d.future))
    }

    /// Does the last edit again that was taken back.
    ///
    /// # Errors
    /// As [`undo`](Self::undo).
    pub fn redo(&mut self) -> Result<()> {
        self.step(|d| (&mut d.future, &mut d.past))
    }

    fn step(&mut self, stacks: impl Fn(&mut Self) -> (&mut Vec<String>, &mut Vec<String>)) -> Result<()> {
        let Some(text) = stacks(self).0.last().cloned() else { return Ok(()) };
        let reading = read(&self.origin, &text, &self.loader.roughly().at(self.moment), self.opening)?;
        let before = std::mem::replace(&mut self.text, text);
        let (from, to) = stacks(self);
        from.pop();
        to.push(before);
        self.going_on = None;
        self.take(reading);
        Ok(())
    }

    fn take(&mut self, reading: Reading) {
        if reading.physics != self.physics {
            self.refining = None;
        }
        (self.toml, self.scene, self.physics) = (reading.toml, reading.scene, reading.physics);
        self.followed = reading.followed;
    }

    /// Puts another text in place of this one, as one edit: a recovered one.
    ///
    /// # Errors
    /// Errors of `barnard check`; nothing is changed then.
    pub fn replace(&mut self, text: &str) -> Result<()> {
        let toml = edited(text)?;
        self.rest();
        self.apply(Edit::new("recover", move |document| *document = toml))
    }

    /// Writes the scene to `path`, whole or not at all; it then is that file's. Files that it names stay where they
    /// are: their names are mended, and those of a built-in scene are written beside it.
    ///
    /// # Errors
    /// If something cannot be written.
    pub fn save(&mut self, path: &Path) -> Result<()> {
        let folder = |path: &Path| std::path::absolute(path).ok().and_then(|p| p.parent().map(Path::to_owned)).unwrap_or_default();
        let moved = match &self.origin {
            Origin::File(before) => folder(before) != folder(path),
            Origin::Builtin(_) | Origin::Bundle(_) | Origin::Text(_) => {
                self.files.write_embedded(&folder(path))?;
                false
            }
        };
        let text = if moved { self.rebased(&self.text) } else { self.text.clone() };
        barnard_files::formats::replace(path, text.as_bytes())?;
        if self.origin != Origin::File(path.to_owned()) {
            let saved = Self::open(path, self.loader.inputs.memory_limit)?;
            if moved {
                self.past = self.past.iter().map(|text| self.rebased(text)).collect();
                self.future = self.future.iter().map(|text| self.rebased(text)).collect();
            }
            self.refining = None;
            (self.origin, self.files, self.loader, self.opening) = (saved.origin, saved.files, saved.loader, saved.opening);
            let reading = read(&self.origin, &saved.text, &self.loader.roughly().at(self.moment), self.opening)?;
            self.take(reading);
        }
        self.text = text;
        self.saved = self.text.clone();
        self.rest();
        Ok(())
    }

    /// A text whose files are named where they are, wherever it is read from.
    fn rebased(&self, text: &str) -> String {
        let Ok(mut toml) = text.parse::<DocumentMut>() else { return text.to_owned() };
        crate::edit::rebase_files(toml.as_table_mut(), &|file| self.files.path(file));
        toml.to_string()
    }
}
