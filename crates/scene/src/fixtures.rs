//! Parts of the small scenes that unit tests render.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use glam::DVec3;
use spectra::extinction::Extinction;
use spectra::fingerprint::Fingerprint;
use spectra::passband::Passband;
use spectra::units::{Luminosity, Temperature};

use crate::cache::{Cache, Record};
use crate::camera::Camera;
use crate::data::{Array, ArrayHeader, Choose, DataSource, Inputs, NoData, Numbers, TextTable};
use crate::error::Result;
use crate::field::{IntoField, Sphere};
use crate::properties::{KeyRow, Section, Table, Type, Value};
use crate::scene::{Dust, Method, Scale, SceneSpec, Star};

/// The text of a scene: a cloud of dust with a star in it, 16 × 12 pixels of johnson.
const SMALL_CLOUD: &str = r#"
bands = "johnson"
[camera]
kind = "perspective"
position = "0 0 5 pc"
field_of_view = "30 deg"
size = [16, 12]
[field.cloud]
kind = "fbm"
radius = "1 pc"
[dust]
density = "cloud"
scale = "2 mag/pc"
law = "fitzpatrick99"
albedo = 0.6
[[star]]
kind = "blackbody"
position = "0.3 0.3 0.3 pc"
temperature = "12000 K"
luminosity = "500 Lsun"
"#;

/// The text of a scene: turbulent gas that a star ionises, 16 × 16 pixels of three narrow bands.
pub const SMALL_GAS: &str = r#"bands = ["hst-wfc3-f502n", "hst-wfc3-f656n", "hst-wfc3-f673n"]
[camera]
kind = "perspective"
position = "0 0 8 pc"
field_of_view = "25 deg"
size = [16, 16]
[field.cloud]
kind = "turbulence"
voxels = 72
[gas]
density = "60 * cloud"
voxels = 16
[[star]]
position = "0.1 0 0 pc"
kind = "blackbody"
temperature = "40000 K"
luminosity = "1e5 Lsun"
"#;

/// The text of a scene: a cloud of dust with a star in it, 16 × 12 pixels of johnson, with other words in place of some.
pub fn small_cloud(changes: &[(&str, &str)]) -> String {
    let changed = |text: String, (from, to): &(&str, &str)| {
        assert!(text.contains(from), "the small cloud has no {from}");
        text.replace(from, to)
    };
    changes.iter().fold(SMALL_CLOUD.to_owned(), changed)
}

/// A ball of density one around the origin.
pub fn ball(radius_pc: f64) -> Sphere {
    Sphere::new(DVec3::ZERO, radius_pc).unwrap()
}

/// Dust of a law by name, albedo one half, of a given extinction for unit density [pc⁻¹].
pub fn dust(density: impl IntoField, law: &str, per_pc: f64) -> Dust {
    Dust::new(density, Extinction::by_name(law).unwrap(), Scale::per_pc(per_pc)).with_albedo(0.5)
}

/// A black body of a luminosity in solar units.
pub fn star(kelvin: f64, suns: f64, position: DVec3) -> Star {
    Star::blackbody(Temperature(kelvin), Luminosity::suns(suns)).with_position(position)
}

/// A scene seen through johnson-V along z, with functions sampled to `bake` voxels an edge.
pub fn scene(camera: Camera, bake: usize) -> SceneSpec {
    let method = Method { bake: Some(bake), ..Method::default() };
    SceneSpec::new(camera).with_bands(vec![Passband::by_name("johnson-V").unwrap()]).with_method(method)
}

/// A camera on the z axis that looks at the origin.
pub fn on_axis(distance_pc: f64, degrees: f64, size: (usize, usize)) -> Camera {
    Camera::look_at(DVec3::new(0.0, 0.0, distance_pc), DVec3::ZERO).with_field_of_view_deg(degrees).with_size(size.0, size.1)
}

/// Files of tests: one table of text, one array of 4 × 4 × 4 ones.
#[derive(Debug)]
struct TestData(&'static str);

impl DataSource for TestData {
    fn label(&self, name: &str) -> String {
        name.to_owned()
    }
    fn text(&self, _: &str, _: u64) -> Result<Cow<'static, str>> {
        Ok(Cow::Borrowed(self.0))
    }
    fn table(&self, name: &str, most_rows: usize, limit: u64) -> Result<TextTable> {
        NoData.table(name, most_rows, limit)
    }
    fn array(&self, _: &str, _: Option<&str>, choose: Choose, _: u64) -> Result<Array> {
        choose(&ArrayHeader { shape: [4; 3], frame: None })?;
        Ok(Array { shape: [4; 3], data: Numbers::Single(vec![1.0; 64].into()), fortran: false })
    }
}

/// Every kind of a catalogue, made from a table that says no more than it must: lengths of half a parsec, a cube of 2
/// pc, files of tests.
pub fn of_every_kind<K, T>(
    kinds: &[K],
    row: impl Fn(&K) -> (&'static str, &'static [KeyRow]),
    text: &'static str,
    build: impl Fn(&Section, &Inputs) -> Result<T>,
) -> Vec<(&'static str, T)> {
    let inputs = Inputs::new(Arc::new(TestData(text)), 1 << 26);
    let value = |key: &KeyRow| match (key.name, key.value) {
        ("low", _) => Value::Text("-1 -1 -1 pc".into()),
        ("high", _) => Value::Text("1 1 1 pc".into()),
        (_, Type::Quantity("length", _)) => Value::Quantity(vec![0.5], "pc".into()),
        (_, Type::Path | Type::Text) => Value::Text("file.csv".into()),
        other => panic!("no value is defined for {other:?}"),
    };
    let made = |kind: &K| {
        let (name, keys) = row(kind);
        let mut table = Table::new(None);
        table.insert("kind", Value::Text(name.into()));
        for key in keys.iter().filter(|key| key.is_required() || ["low", "high"].contains(&key.name)) {
            table.insert(key.name, value(key));
        }
        // The law of these tests brings no mean cosine of its own.
        if keys.iter().any(|key| key.name == "g") {
            table.insert("g", Value::Number(0.6));
        }
        (name, build(&Section::root(&table), &inputs).unwrap_or_else(|e| panic!("{name}: {e}")))
    };
    kinds.iter().map(made).collect()
}

/// Records in memory, and how many were found.
#[derive(Debug, Default)]
pub struct MemoryCache {
    records: Mutex<HashMap<(String, Fingerprint), Record>>,
    hits: AtomicUsize,
    misses: AtomicUsize,
}

impl MemoryCache {
    /// Hits and misses since the last call.
    pub fn counts(&self) -> (usize, usize) {
        (self.hits.swap(0, Ordering::Relaxed), self.misses.swap(0, Ordering::Relaxed))
    }

    /// Doubles every array of a kind.
    pub fn falsify(&self, kind: &str) {
        for ((known, _), record) in &mut *self.records.lock().unwrap() {
            if known == kind {
                record.arrays.iter_mut().for_each(|array| *array = array.iter().map(|value| 2.0 * value).collect::<Vec<f32>>().into());
            }
        }
    }
}

impl Cache for MemoryCache {
    fn get(&self, kind: &str, inputs: Fingerprint) -> Option<Record> {
        let record = self.records.lock().unwrap().get(&(kind.to_owned(), inputs)).cloned();
        (if record.is_some() { &self.hits } else { &self.misses }).fetch_add(1, Ordering::Relaxed);
        record
    }
    fn put(&self, kind: &str, inputs: Fingerprint, record: &Record) {
        self.records.lock().unwrap().insert((kind.to_owned(), inputs), record.clone());
    }
}
