//! Moments of a scene that changes: which is shown, and views that become keys of the camera.

use super::Model;
use barnard_explorer::edit::{Edit, table};
use barnard_explorer::flight::Flight;
use barnard_explorer::keyframes::{SAME, dropped, keyed, moments};
use barnard_explorer::visit::route;

/// Duration of a scene without keyframes [s].
const DURATION: f64 = 10.0;
/// The time between keys that are made of bookmarks [s].
const BETWEEN: f64 = 3.0;
/// The time that the bar reaches beyond the last key, for another one [s].
const BEYOND: f64 = 5.0;

impl Model {
    /// Duration of the scene \[s\]; `None` if nothing changes.
    pub fn duration(&self) -> Option<f64> {
        let frames = self.document.scene().timeline.as_ref()?.frames;
        Some(frames.time(frames.last()))
    }

    /// The latest moment that can be gone to \[s\].
    pub fn reach(&self) -> f64 {
        self.duration().map_or(DURATION, |duration| (duration + BEYOND).max(DURATION))
    }

    /// The number of the frame that shows the moment, where frames are counted.
    pub fn frame_shown(&self) -> Option<i64> {
        let frames = self.document.scene().timeline.as_ref()?.frames;
        Some(frames.first + (self.clock.time * frames.per_second + 1e-6).floor() as i64)
    }

    /// The moments of the camera's keys \[s\], where they stand in the scene.
    pub fn keyframes(&self) -> Vec<f64> {
        moments(self.document.toml().as_table())
    }

    /// The moment nearest to a time \[s\] that one would write: that of a frame where the scene has frames, else a tenth of a second.
    pub fn nearest_frame(&self, time: f64) -> f64 {
        let frames = self.document.scene().timeline.as_ref().map(|timeline| timeline.frames);
        let per_second = frames.map_or(10.0, |frames| frames.per_second);
        (time * per_second).round() / per_second
    }

    /// Shows another moment.
    pub fn seek(&mut self, time: f64) {
        let time = (1e3 * time.clamp(0.0, self.reach())).round() / 1e3;
        match self.document.show_moment(time) {
            Ok(()) => {
                self.clock.time = time;
                if self.document.moves_camera() {
                    let scene = self.document.scene().clone();
                    self.flight.take(&scene, &scene.camera);
                }
            }
            Err(error) => {
                self.clock.playing = false;
                self.complain(error);
            }
        }
    }

    /// Begins to play, from the start where the end was reached, or stands still.
    pub fn play(&mut self) {
        self.clock.playing = !self.clock.playing;
        if self.clock.playing && self.duration().is_none_or(|end| self.clock.time >= end) {
            self.seek(0.0);
        }
    }

    /// Plays the camera's path from its beginning; a scene without one gets a flight into its cloud.
    pub fn visit(&mut self) {
        if !self.document.has_path() {
            let Some(keys) = route(self.document.scene(), &self.flight) else {
                return self.complain("a visit needs a cloud and a camera of kind perspective, fisheye, equirectangular or cubemap");
            };
            let edit = keys.iter().fold(Edit::remove("camera", "crop"), |edit, (time, flight)| edit.and(keyed(flight, *time)));
            if !self.apply(edit.with_name("visit")) {
                return;
            }
            self.tell("a flight of 20 s; Ctrl+Z removes it, File, Save film renders it");
        }
        self.layout.timeline = true;
        self.seek(0.0);
        self.clock.playing = true;
    }

    /// Makes the view a key of the camera at the moment that is shown.
    pub fn set_key(&mut self) {
        let time = self.clock.time;
        if !self.document.has_path() && time < SAME {
            self.clock.first = Some(self.flight.clone());
            self.tell("the path begins here; go to a later time and press K again");
            return;
        }
        if table(self.document.toml().as_table(), "camera.path").is_some_and(|path| path.contains_key("file")) {
            self.complain("the camera path is a file; remove `file` from [camera.path] to set keys");
            return;
        }
        let mut edit = keyed(&self.flight, time);
        if !self.document.has_path() {
            // Where no beginning was chosen it is what the scene shows.
            let first = self.clock.first.take().unwrap_or_else(|| Flight::of(self.document.scene()));
            // Keys are of the whole image.
            edit = Edit::remove("camera", "crop").and(keyed(&first, 0.0)).and(edit);
        }
        if self.apply(edit.with_name("key")) {
            self.tell(format!("key at {time} s"));
        }
    }

    /// Takes the key nearest to the moment away, where three or more are there.
    pub fn drop_key(&mut self) {
        let keys = self.keyframes();
        let Some(nearest) =
            (0..keys.len()).min_by(|a, b| (keys[*a] - self.clock.time).abs().total_cmp(&(keys[*b] - self.clock.time).abs()))
        else {
            return;
        };
        if keys.len() < 3 {
            if self.apply(Edit::remove("camera", "path").with_name("path removed")) {
                self.tell("a path needs two keys: it was removed");
            }
            return;
        }
        self.apply(dropped(nearest));
    }

    /// Makes keys of all bookmarks, one after the other.
    pub fn keys_of_bookmarks(&mut self) {
        let scene = self.document.scene().clone();
        let mut edit = Edit::remove("camera", "path").and(Edit::remove("camera", "crop"));
        for (i, camera) in scene.bookmarks.values().enumerate() {
            let mut flight = self.flight.clone();
            flight.take(&scene, camera);
            edit = edit.and(keyed(&flight, BETWEEN * i as f64));
        }
        if scene.bookmarks.len() < 2 {
            self.complain("a path needs two or more bookmarks; set them with Ctrl + 1 to 9");
            return;
        }
        self.apply(edit.with_name("keys of bookmarks"));
        self.seek(0.0);
    }
}
