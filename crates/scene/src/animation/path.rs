//! The `[camera.path]` table: how the camera moves.
//!
//! A path has keys, in the scene or in a file, each with what it changes of the camera. Between the keys all of that goes by
//! the same interpolation. With constant speed, moments are fractions of the path, and all
//! that belongs to a place comes along. An eased path begins and ends at rest: within its first span e a moment t is
//! e w(t/e), w(x) = 6x³ − 8x⁴ + 3x⁵, which has neither speed nor acceleration at 0 and joins w(x) = x smoothly at 1.

use glam::{DQuat, DVec3};
use spectra::units::{Length, Time};

use super::curve::{Curve, Interpolation};
use super::keyframes::{KEY, Keyframes};
use super::track::Track;
use crate::camera::{KINDS, POSITION, TARGET};
use crate::data::{InputNote, Inputs};
use crate::error::Result;
use crate::properties::{Choice, Flag, Key, KeyRow, OrDefault, Path, Property, Section, Table, Value};

const FILE: Key<Path> =
    Key::path("file", "file of keyframes: CSV, Gaia Sky camera path (.gsc), or the first animated camera of a glTF (.gltf, .glb)")
        .excludes("key");
const UNIT: Key<Length, OrDefault> =
    Key::quantity::<Length>("unit", "unit of length of a .gltf or .glb, and of CSV columns without a unit")
        .positive()
        .default("1 pc")
        .needs("file");
const INTERPOLATION: Key<Choice<Interpolation>, OrDefault> =
    Key::choice("interpolation", "interpolation between keyframes").default("catmull_rom").of("interpolations");
const EASE: Key<Time, OrDefault> =
    Key::quantity::<Time>("ease", "time to accelerate from rest at the beginning, and to decelerate at the end").default("0 s");
const CONSTANT_SPEED: Key<Flag, OrDefault> =
    Key::flag("constant_speed", "constant speed; only the times of the first and last key are used").default(false);

/// Keys of `[camera.path]`.
pub(crate) const KEYS: &[KeyRow] = &[KEY.row, FILE.row, UNIT.row, INTERPOLATION.row, EASE.row, CONSTANT_SPEED.row];

/// Parts of the way between two keys by which its length is measured.
const LENGTH_PARTS: usize = 256;
/// Parts of the way in all.
const ALL_PARTS: usize = 1 << 20;

/// Camera motion.
#[derive(Debug, Clone)]
pub(super) struct CameraPath {
    /// Places \[pc\], directions and quaternions, by the names of the keys.
    vectors: Vec<(&'static str, Curve)>,
    /// Other numbers of the camera, by the names of their keys.
    others: Vec<(String, Track)>,
    /// When it begins and ends \[s\].
    span: (f64, f64),
    ease: f64,
    /// The way that is behind the camera at moments of its keys' time, where it goes at one speed.
    way: Option<Vec<(f64, f64)>>,
}

/// The names of what a path changes.
fn names_of(vectors: &[(&'static str, Curve)], others: &[(String, Track)]) -> String {
    vectors.iter().map(|(name, _)| *name).chain(others.iter().map(|(name, _)| name.as_str())).collect::<Vec<_>>().join(", ")
}

impl CameraPath {
    /// Reads `[camera.path]` of a camera of a kind.
    pub fn build(section: &Section, kind: &str, inputs: &Inputs) -> Result<Self> {
        section.check(KEYS)?;
        let interpolation = section.read(&INTERPOLATION)?;
        let keyframes = match section.read(&FILE)? {
            Some(file) => {
                let unit_pc = section.read(&UNIT)?.0;
                Keyframes::of_file(section, file, unit_pc, inputs)?
            }
            None => Keyframes::of_tables(section)?,
        };
        let Keyframes { times, vectors, others } = keyframes;
        let (Some(first), Some(last)) = (times.first().copied(), times.last().copied().filter(|_| times.len() > 1)) else {
            let has = if times.is_empty() { "no keys" } else { "one key" };
            return Err(section.error(&KEY, format!("the path has {has}; give two or more [[camera.path.key]], or a file")));
        };
        let vectors: Vec<(&'static str, Curve)> =
            vectors.into_iter().map(|(name, (times, values))| (name, Curve::new(times, values, interpolation))).collect();
        let track = |(name, keys): (String, Vec<(f64, Value)>)| {
            let owners: Vec<&str> =
                KINDS.iter().filter(|kind| kind.keys.iter().any(|key| key.name == name)).map(|kind| kind.name).collect();
            if !owners.contains(&kind) {
                let message = format!("\"{name}\" requires kind {}, but this camera is {kind}; remove it", owners.join(" or "));
                return Err(section.error(&KEY, message));
            }
            Ok((name.clone(), Track::new(keys, interpolation).map_err(|e| section.error(&KEY, format!("{name}: {e}")))?))
        };
        let others: Vec<(String, Track)> = others.into_iter().map(track).collect::<Result<_>>()?;
        let ease = section.read(&EASE)?.0;
        if !(0.0..=0.5 * (last - first)).contains(&ease) {
            let message = format!("an ease of {ease} s is too long for a path of {} s; use at most half of the path", last - first);
            return Err(section.error(&EASE, message));
        }
        if let Some(file) = section.read(&FILE)? {
            let text = format!("camera path: {} keys from {first} to {last} s, of {}", times.len(), names_of(&vectors, &others));
            inputs.note(InputNote { file: file.to_owned(), text, is_inferred: false });
        }
        let mut path = Self { vectors, others, span: (first, last), ease, way: None };
        if section.read(&CONSTANT_SPEED)? {
            path.way = Some(path.measured(&times).ok_or_else(|| {
                section.error(&CONSTANT_SPEED, "the camera does not move between its keys; remove constant_speed, or give two positions")
            })?);
        }
        Ok(path)
    }

    /// The moment of the last key \[s\].
    pub fn end(&self) -> f64 {
        self.span.1
    }

    /// Camera position at a moment \[s\], in pc; `None` for a static camera.
    pub fn position(&self, time: f64) -> Option<DVec3> {
        let (_, curve) = self.vectors.iter().find(|(known, _)| *known == "position")?;
        Some(DVec3::from_slice(&curve.at(self.on_way(self.eased(time)))))
    }

    /// Says in `camera` what the path does of it at a moment \[s\].
    pub fn set(&self, camera: &mut Table, time: f64, section: &Section) -> Result<()> {
        let time = self.on_way(self.eased(time));
        let origin = section.properties().origin().cloned();
        let property = |value| Property { value, origin: origin.clone() };
        let vector = |name: &str| self.vectors.iter().find(|(known, _)| *known == name).map(|(_, curve)| curve.at(time));
        let triple = |name: &str| vector(name).map(|v| DVec3::new(v[0], v[1], v[2]));
        let place = |p: DVec3| Value::Quantity(p.to_array().to_vec(), "pc".into());
        let direction = |d: DVec3| Value::List([d.x, d.y, d.z].map(|v| Value::Number(v).into()).to_vec());
        if let Some(position) = triple("position") {
            camera.insert("position", property(place(position)));
        }
        let mut looks = triple("direction");
        if let Some(q) = vector("orientation") {
            // Between quaternions of length one a mean is shorter.
            let q = DQuat::from_xyzw(q[0], q[1], q[2], q[3]);
            if q.length() < 1e-6 {
                return Err(section.error(&KEY, "orientations of adjacent keys are opposite; insert a key between them"));
            }
            looks = Some(q.normalize() * DVec3::NEG_Z);
            camera.insert("up", property(direction(q.normalize() * DVec3::Y)));
        }
        if let Some(target) = triple("target") {
            camera.insert("target", property(place(target)));
        } else if let Some(looks) = looks {
            let Some(looks) = looks.try_normalize() else {
                return Err(section.error(&KEY, "directions of adjacent keys are opposite; insert a key between them"));
            };
            // As far as the scene's own target is: the default target lies there.
            let section_of = Section::new(camera, "camera");
            let (position, before) = (section_of.read(&POSITION)?, section_of.read(&TARGET)?);
            let distance = position.distance(before);
            camera.insert("target", property(place(position + if distance > 0.0 { distance } else { 1.0 } * looks)));
        }
        if let Some(up) = triple("up") {
            camera.insert("up", property(direction(up)));
        }
        self.others.iter().for_each(|(name, track)| camera.insert(name.as_str(), property(track.at(time))));
        Ok(())
    }

    /// A moment as an eased path has it.
    fn eased(&self, time: f64) -> f64 {
        let warp = |x: f64| x * x * x * (6.0 - x * (8.0 - 3.0 * x));
        let (first, last) = self.span;
        let time = time.clamp(first, last);
        if self.ease > 0.0 && time < first + self.ease {
            first + self.ease * warp((time - first) / self.ease)
        } else if self.ease > 0.0 && time > last - self.ease {
            last - self.ease * warp((last - time) / self.ease)
        } else {
            time
        }
    }

    /// The moment of the keys' time at which the camera is where it is at a moment at one speed.
    fn on_way(&self, time: f64) -> f64 {
        let Some(way) = &self.way else { return time };
        let (first, last) = self.span;
        let gone = way.last().map_or(0.0, |(_, gone)| *gone) * (time - first) / (last - first);
        if time >= last {
            return last;
        }
        let after = way.partition_point(|(_, behind)| *behind <= gone).clamp(1, way.len() - 1);
        let ((t0, s0), (t1, s1)) = (way[after - 1], way[after]);
        if s1 > s0 { t0 + (t1 - t0) * ((gone - s0) / (s1 - s0)).clamp(0.0, 1.0) } else { t0 }
    }

    /// The way that is behind the camera at moments of its keys' time; none where it goes none.
    fn measured(&self, times: &[f64]) -> Option<Vec<(f64, f64)>> {
        let (_, curve) = self.vectors.iter().find(|(name, _)| *name == "position")?;
        let place = |time: f64| DVec3::from_slice(&curve.at(time));
        let parts = (ALL_PARTS / times.len()).clamp(1, LENGTH_PARTS);
        let mut way = vec![(times[0], 0.0)];
        let (mut before, mut gone) = (place(times[0]), 0.0);
        for pair in times.windows(2) {
            for part in 1..=parts {
                let time = if part == parts { pair[1] } else { pair[0] + (pair[1] - pair[0]) * part as f64 / parts as f64 };
                let here = place(time);
                gone += here.distance(before);
                before = here;
                way.push((time, gone));
            }
        }
        (gone > 0.0).then_some(way)
    }
}
