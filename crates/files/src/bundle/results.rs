//! Results of long computations in a bundle.

use std::collections::HashMap;
use std::io::Write;
use std::sync::{Arc, Mutex};

use barnard::cache::{Cache, PAIRS, Record};
use flate2::Compression;
use flate2::write::DeflateEncoder;
use rayon::prelude::*;
use spectra::fingerprint::Fingerprint;

use super::volume::Volume;

/// Largest sum of errors that a ratio may have, relative to the sum of the values \[1\].
const RATIO_ERROR: f64 = 0.01;

/// Result with arrays in rounded form.
#[derive(Debug, Clone)]
pub(super) struct GivenResult {
    /// Kind and fingerprint of the inputs, as [`key`] joins them.
    pub key: String,
    pub text: String,
    pub numbers: Vec<f64>,
    pub volumes: Vec<Volume>,
}

/// Name of a result.
fn key(kind: &str, inputs: Fingerprint) -> String {
    format!("{kind}-{inputs}")
}

/// Cache that has the results of a bundle and stores nothing.
#[derive(Debug)]
struct Given {
    results: HashMap<String, GivenResult>,
    /// Volumes by which others are multiplied, by their names.
    factors: HashMap<String, Volume>,
}

/// Cache of the results of a bundle with some volumes.
pub(super) fn cache(results: &[GivenResult], volumes: &[Volume]) -> Arc<dyn Cache> {
    let all = volumes.iter().chain(results.iter().flat_map(|result| &result.volumes));
    Arc::new(Given {
        results: results.iter().map(|result| (result.key.clone(), result.clone())).collect(),
        factors: all.map(|volume| (volume.name.clone(), volume.clone())).collect(),
    })
}

impl Given {
    /// Values of a volume times those of others; `None` where one has another shape.
    fn values(&self, volume: &Volume) -> Option<Vec<f32>> {
        let mut values = volume.values();
        for name in &volume.times {
            // An archive names volumes that stand before this one, so this ends.
            let factors = self.values(self.factors.get(name)?).filter(|factors| factors.len() == values.len())?;
            values.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
        }
        Some(values)
    }
}

impl Cache for Given {
    fn get(&self, kind: &str, inputs: Fingerprint) -> Option<Record> {
        let GivenResult { text, numbers, volumes, .. } = self.results.get(&key(kind, inputs))?;
        let arrays = volumes.iter().map(|volume| Some(self.values(volume)?.into())).collect::<Option<_>>()?;
        Some(Record { text: text.clone(), numbers: numbers.clone(), arrays })
    }

    fn put(&self, _kind: &str, _inputs: Fingerprint, _record: &Record) {}
}

/// Cache that records what is stored of one kind, and answers with nothing.
#[derive(Debug)]
pub(super) struct Recorder {
    kind: &'static str,
    records: Mutex<Vec<(String, Record)>>,
}

impl Recorder {
    pub fn new(kind: &'static str) -> Self {
        Self { kind, records: Mutex::default() }
    }

    /// Records of a gas on voxels, whose `density` is a volume. Quantities are stored as ratios where these take fewer bytes.
    pub fn gas(&self, dims: [usize; 3], density: Option<&Volume>) -> Vec<GivenResult> {
        let mut records = self.records.lock().map(|records| records.clone()).unwrap_or_default();
        // n_p n_e changes with the square of the density, and lines change with n_p n_e.
        records.sort_by_key(|(_, record)| record.text != PAIRS);
        let hydrogen = density.filter(|density| density.shape == [dims[2], dims[1], dims[0]]).map(|density| {
            let squares = density.values().into_iter().map(|value| value * value).collect::<Vec<f32>>();
            (vec![density.name.as_str(), density.name.as_str()], squares)
        });
        let mut results: Vec<GivenResult> = Vec::new();
        let pairs = records.first().filter(|(_, record)| record.text == PAIRS).cloned();
        let mut reference = hydrogen;
        let name_of_pairs = "0";
        if let Some((key, record)) = pairs {
            let volume = smallest(name_of_pairs, dims, &record.arrays[0], reference.as_ref());
            let mut values = volume.values();
            if let Some((_, squares)) = reference.filter(|_| !volume.times.is_empty()) {
                values.iter_mut().zip(squares).for_each(|(value, square)| *value *= square);
            }
            reference = Some((vec![name_of_pairs], values));
            results.push(GivenResult { key, text: record.text, numbers: record.numbers, volumes: vec![volume] });
        }
        let rest = records.into_par_iter().enumerate().skip(results.len()).map(|(number, (key, record))| {
            let array = |array| smallest(&number.to_string(), dims, array, reference.as_ref());
            GivenResult { key, text: record.text, numbers: record.numbers, volumes: record.arrays.iter().map(|a| array(a)).collect() }
        });
        results.extend(rest.collect::<Vec<_>>());
        results
    }
}

/// Volume of values: as they are, or relative to a product of named volumes, whichever takes fewer bytes.
fn smallest(name: &str, dims: [usize; 3], values: &[f32], reference: Option<&(Vec<&str>, Vec<f32>)>) -> Volume {
    let plain = Volume::new(name, dims, values);
    let Some((names, product)) = reference else { return plain };
    let ratio = Volume::relative(name, dims, values, names, product);
    // A value is lost where the product is rounded to zero.
    let (mut errors, mut sum) = (0.0, 0.0);
    for ((value, ratio), product) in values.iter().zip(ratio.values()).zip(product) {
        errors += f64::from((value - ratio * product).max(0.0));
        sum += f64::from(*value);
    }
    let is_exact = errors <= RATIO_ERROR * sum;
    if is_exact && packed_bytes(&ratio) < packed_bytes(&plain) { ratio } else { plain }
}

/// Bytes of a volume in an archive.
fn packed_bytes(volume: &Volume) -> usize {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
    // Writing to memory does not fail.
    let _ = encoder.write_all(&volume.encoded());
    encoder.finish().map_or(usize::MAX, |bytes| bytes.len())
}

impl Cache for Recorder {
    fn get(&self, _kind: &str, _inputs: Fingerprint) -> Option<Record> {
        None
    }

    fn put(&self, kind: &str, inputs: Fingerprint, record: &Record) {
        if let (true, Ok(mut records)) = (kind == self.kind, self.records.lock()) {
            records.push((key(kind, inputs), record.clone()));
        }
    }
}
