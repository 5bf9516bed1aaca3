//! Animation: scenes that change from moment to moment.
//!
//! A scene file may let its camera follow a path (`[camera.path]`), and let any key have keyframes (`[[animation]]`);
//! `[sequence]` says which moments become frames. A [`Timeline`] holds all of that. What the scene is at a moment is the tree
//! of properties in which keys say what they say at that moment: whatever a scene file can say can change.

mod curve;
mod keyframes;
mod path;
mod track;

use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use spectra::fingerprint::{Digest, Fingerprint};
use spectra::units::{Angle, Time};

pub use curve::{INTERPOLATIONS, Interpolation};
pub(crate) use keyframes::KEYFRAME as PATH_KEYFRAME;
pub(crate) use path::KEYS as PATH;
pub use track::Track;

use self::path::CameraPath;
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::image::{Image, Moment};
use crate::keywords::{self, Keyword};
use crate::properties::places::set;
use crate::properties::{
    Choice, Entry, Integer, Key, KeyRow, Number, OrDefault, Property, Quantities, Required, Section, Table, Text, Type, Value, ValueRef,
    ValueType,
};

/// Reads a file of a camera's path as `[camera.path]` does.
pub(crate) fn check_path(section: &Section, inputs: &Inputs) -> Result<()> {
    CameraPath::build(section, "perspective", inputs).map(|_| ())
}

/// List of values of any type.
enum AnyValues {}

impl ValueType for AnyValues {
    const TYPE: Type = Type::Other("list of values");
    type Value<'a> = &'a [Property];
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<&'a [Property]> {
        match entry.value {
            ValueRef::Given(Value::List(items)) => Ok(items),
            _ => Err(entry.error("values must be a list, such as [\"5000 K\", \"9000 K\"]")),
        }
    }
}

const OF: Key<Text, Required> =
    Key::text("of", "animated key, such as \"star[0].temperature\" (of the first star) or \"display.white\"").required();
const TIMES: Key<Quantities<Time>, Required> =
    Key::quantities("times", "ascending times of `values`").required().example("[\"0 s\", \"4 s\"]");
const VALUES: Key<AnyValues, Required> =
    Key::<AnyValues>::new("values", "values at these times, written like the key itself, all in one unit")
        .required()
        .example("[\"5000 K\", \"9000 K\"]");
const INTERPOLATION: Key<Choice<Interpolation>, OrDefault> =
    Key::choice("interpolation", "interpolation between values").default("bezier").of("interpolations");
const FRAMES_PER_SECOND: Key<Number, OrDefault> =
    Key::number("frames_per_second", "frames per second").positive().at_most(FASTEST).default(30.0);
const FIRST_FRAME: Key<Integer<i64>, OrDefault> =
    Key::integer("first_frame", "number of the frame at 0 s").range(-1_000_000_000..=1_000_000_000).default(1);
const DURATION: Key<Time> = Key::quantity::<Time>("duration", "time from the first frame to the last").otherwise("until the last key");
const SHUTTER: Key<Angle, OrDefault> = Key::quantity::<Angle>("shutter", "shutter angle for motion blur; 360 deg is the whole frame time")
    .range(0.0..=TAU * (1.0 + 1e-12))
    .default("0 deg");
const SHUTTER_MOMENTS: Key<Integer<usize>, OrDefault> =
    Key::integer("shutter_moments", "number of moments averaged per frame with motion blur").range(2..=256).default(8);

/// Keys of `[[animation]]`.
pub(crate) const TRACK: &[KeyRow] = &[OF.row, TIMES.row, VALUES.row, INTERPOLATION.row];

/// Keys of `[sequence]`.
pub(crate) const SEQUENCE: &[KeyRow] = &[FRAMES_PER_SECOND.row, FIRST_FRAME.row, DURATION.row, SHUTTER.row, SHUTTER_MOMENTS.row];

/// Scene keys of an [`Animation`](Timeline).
const TABLES: [&str; 2] = ["animation", "sequence"];

/// The rate at which frames follow each other, their numbers, and how each is exposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frames {
    /// Frames a second.
    pub per_second: f64,
    /// The number of the frame that shows the first moment.
    pub first: i64,
    /// The number of frames.
    pub count: u64,
    /// The time for which the shutter is open, as a part of that of a frame \[1\].
    pub shutter: f64,
    /// Moments of which a frame with an open shutter is the mean.
    pub moments: usize,
}

/// Most frames a second, and of a sequence.
const FASTEST: f64 = 1e6;
const MOST_FRAMES: f64 = 1e6;

impl Frames {
    /// Frames from 0 s to `duration` \[s\], numbered from 1, with a shutter that shuts at once.
    ///
    /// # Errors
    /// If there are no frames, or more than a million.
    pub fn new(per_second: f64, duration: f64) -> Result<Self> {
        // Rounding does not take the last frame away.
        let count = (duration * per_second + 1e-6).floor() + 1.0;
        if !(per_second > 0.0 && (1.0..=MOST_FRAMES).contains(&count)) {
            let value = format!("{duration} s at {per_second} frames per second");
            return Err(Error::out_of_range("duration of a sequence", value, format!("1 to {MOST_FRAMES:e} frames")));
        }
        Ok(Self { per_second, first: 1, count: count as u64, shutter: 0.0, moments: 1 })
    }

    /// Frame keywords of an image, such as FRAME and FRAMTIME of FITS.
    pub fn stamp(&self, frame: i64, image: &mut Image) {
        let time_s = self.time(frame);
        image.moment = Some(Moment { frame, time_s, per_second: self.per_second });
        let number = keywords::Value::Integer(frame);
        image.keywords.push(Keyword { name: "FRAME", value: number, comment: "number of the frame" });
        image.keywords.extend(keywords::number("FRAMTIME", time_s, "[s] time of the frame"));
    }

    /// The number of the last frame.
    pub fn last(&self) -> i64 {
        self.first + self.count as i64 - 1
    }

    /// The moment of a frame \[s\].
    pub fn time(&self, number: i64) -> f64 {
        (number - self.first) as f64 / self.per_second
    }

    /// The moments of which a frame is the mean \[s\]: its own where the shutter is shut at once.
    pub fn moments(&self, number: i64) -> Vec<f64> {
        if self.shutter == 0.0 {
            return vec![self.time(number)];
        }
        let part = |i: usize| (i as f64 + 0.5) / self.moments as f64 - 0.5;
        (0..self.moments).map(|i| self.time(number) + self.shutter / self.per_second * part(i)).collect()
    }
}

/// All that changes in a scene, and the frames that show it.
#[derive(Debug, Clone)]
pub struct Timeline {
    path: Option<CameraPath>,
    /// Places in the tree, and what stands there.
    tracks: Vec<(String, Track, Property)>,
    /// The frames.
    pub frames: Frames,
    /// Frames from one solution of the gas to the next, once known.
    pub(crate) solved_every: Arc<OnceLock<f64>>,
}

impl Timeline {
    /// Fingerprint of all changes and frames.
    pub fn fingerprint(&self) -> Fingerprint {
        let Self { path, tracks, frames, solved_every: _ } = self;
        Digest::new("timeline").plain(path).plain(tracks).plain(frames).finish()
    }

    /// Timeline without changes.
    pub fn new(frames: Frames) -> Self {
        Self { path: None, tracks: Vec::new(), frames, solved_every: Arc::default() }
    }

    /// Adds the values of a key of the scene, such as `star[0].temperature`, over time.
    ///
    /// # Errors
    /// If the key defines the animation itself.
    pub fn with_track(mut self, key: &str, track: Track) -> Result<Self> {
        let property = Property { value: Value::Text(key.into()), origin: None };
        check_target(key).map_err(|message| wrong(self.tracks.len(), &property, message))?;
        self.tracks.push((key.to_owned(), track, property));
        Ok(self)
    }

    /// Animation of a scene, if any.
    ///
    /// # Errors
    /// If a key is unknown, missing or wrong, or a file cannot be read; the error states its place.
    pub(crate) fn build(root: &Section, inputs: &Inputs) -> Result<Option<Self>> {
        let camera = root.table("camera")?;
        let kind = camera.as_ref().and_then(Section::kind).unwrap_or_default();
        let path = camera.as_ref().map(|camera| camera.table("path")).transpose()?.flatten();
        if path.is_none() && TABLES.iter().all(|name| !root.has(*name)) {
            return Ok(None);
        }
        let path = path.map(|section| CameraPath::build(&section, kind, inputs)).transpose()?;
        let tracks = root.tables("animation")?.iter().map(track).collect::<Result<Vec<_>>>()?;
        let end = tracks.iter().map(|(_, track, _)| track.end()).chain(path.as_ref().map(CameraPath::end)).fold(0.0, f64::max);
        let frames = frames(root.table("sequence")?.as_ref(), end)?;
        Ok(Some(Self { path, tracks, frames, solved_every: Arc::default() }))
    }

    /// True if the camera follows a path.
    pub fn has_path(&self) -> bool {
        self.path.is_some()
    }

    /// True if anything of the camera changes, by a path or by tracks.
    pub fn moves_camera(&self) -> bool {
        self.has_path() || self.tracks.iter().any(|(place, ..)| place.split(['.', '[']).next() == Some("camera"))
    }

    /// The keys that change, in the order in which the scene says them: what each is called there, and its track.
    pub fn tracks(&self) -> impl Iterator<Item = (&str, &Track)> {
        self.tracks.iter().map(|(place, track, _)| (place.as_str(), track))
    }

    /// Camera position on its path at a moment \[s\], in pc; `None` without a path.
    pub fn position(&self, time: f64) -> Option<DVec3> {
        self.path.as_ref()?.position(time)
    }

    /// Scene `tree` at a moment \[s\]: a tree without changes.
    ///
    /// # Errors
    /// If a track is of a key that cannot be, or a camera looks nowhere; the error states its place.
    pub fn at(&self, tree: &Table, time: f64) -> Result<Table> {
        let mut still = tree.clone();
        TABLES.iter().for_each(|name| still.remove(name));
        let section = Section::root(tree).table("camera")?;
        let section = section.map(|camera| camera.table("path")).transpose()?.flatten();
        if let (Some(Value::Table(camera)), Some(section)) = (still.get_mut("camera").map(|p| &mut p.value), section) {
            camera.remove("path");
            if let Some(path) = &self.path {
                path.set(camera, time, &section)?;
            }
        }
        for (i, (place, track, written)) in self.tracks.iter().enumerate() {
            let property = Property { value: track.at(time), origin: written.origin.clone() };
            set(&mut still, place, property).map_err(|message| wrong(i, written, message))?;
        }
        Ok(still)
    }
}

/// The error about the place of a track.
fn wrong(number: usize, property: &Property, message: String) -> Error {
    let place = crate::properties::Place { origin: property.origin.clone(), path: format!("animation[{number}]"), key: "of".into() };
    Error::Scene { message, place }
}

/// # Errors
/// In words, if a key defines the animation and cannot be animated.
fn check_target(key: &str) -> std::result::Result<(), String> {
    let names: Vec<&str> = key.split(['.', '[']).collect();
    let defines = TABLES.contains(&names[0]) || names[..names.len().min(2)] == ["camera", "path"];
    if defines { Err(format!("\"{key}\" defines the animation and cannot be animated")) } else { Ok(()) }
}

/// Reads `[[animation]]`.
fn track(section: &Section) -> Result<(String, Track, Property)> {
    section.check(TRACK)?;
    let target = section.read(&OF)?;
    check_target(target).map_err(|message| section.error(&OF, message))?;
    let (times, values) = (section.read(&TIMES)?, section.read(&VALUES)?);
    if times.len() != values.len() || times.is_empty() {
        let message = format!("{} times have {} values; give one value per time", times.len(), values.len());
        return Err(section.error(&VALUES, message));
    }
    let mut keys: Vec<(f64, Value)> = Vec::new();
    for (time, value) in times.iter().zip(values) {
        let moment = time.0;
        if moment < 0.0 || keys.last().is_some_and(|(before, _)| moment <= *before) {
            return Err(section.error(&TIMES, format!("{time} is not later than the previous time; times must ascend from 0 s or later")));
        }
        keys.push((moment, value.value.clone()));
    }
    let track = Track::new(keys, section.read(&INTERPOLATION)?).map_err(|message| section.error(&VALUES, message))?;
    let property = section.properties().get(OF.name).cloned().unwrap_or(Property { value: Value::Flag(true), origin: None });
    Ok((target.to_owned(), track, property))
}

/// Reads `[sequence]` of a scene whose last key is at `end` \[s\].
fn frames(section: Option<&Section>, end: f64) -> Result<Frames> {
    let nothing = Table::default();
    let defaults = Section::new(&nothing, "sequence");
    let section = section.unwrap_or(&defaults);
    section.check(SEQUENCE)?;
    let per_second = section.read(&FRAMES_PER_SECOND)?;
    let duration = section.read(&DURATION)?.map_or(end, |time| time.0);
    let shutter = section.read(&SHUTTER)?.0 / TAU;
    Ok(Frames {
        first: section.read(&FIRST_FRAME)?,
        shutter: shutter.min(1.0),
        moments: section.read(&SHUTTER_MOMENTS)?,
        ..section.wrap(&DURATION, Frames::new(per_second, duration))?
    })
}
