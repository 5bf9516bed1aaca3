//! Files of plates: an `.npz` archive under the name `.plates`, which NumPy reads as it is.
//!
//! | array | shape | what |
//! |---|---|---|
//! | `facts` | 9 | width, height, number of plates, whether light scatters again, accuracy, largest optical depth, amount of dust \[pc⁻¹\], shortest and longest wavelength \[µm\] |
//! | `nodes` | nodes × 2 | wavelength \[µm\] and extinction of each |
//! | `depths` | sources | optical depths in front of stars that are points |
//! | `notes`, `geometry` | bytes | lines: what notes are about, a tab, what they say; names of what a scene may not change |
//! | `geometry_I` | | its numbers |
//! | `plate_I_light` | 5 | its way (0 scattered, 1 emitted, 2 background), number of its star or species, rounding of depth and light, error of components |
//! | `plate_I_mean`, `_axes`, `_ranges` | nodes, components × nodes, components × 2 | its components |
//! | `plate_I_level` | height × width, f4 | G(k_0) |
//! | `plate_I_coordinates` | components × height × width, u2 | coordinates, in 65535 steps of their ranges |

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use barnard::error::{Error, Result};
use barnard::light::Route;
use barnard::plates::{Geometry, Plate, Plates, Record, Trait};
use barnard::spectra::components::Components;
use barnard::spectra::rule::{Node, Rounding};

use crate::formats::{self, FileFloat, Request, Written, put, replace_by};

/// Most plates, and most things that a scene may not change.
const MOST: f64 = 1024.0;

/// Writes plates down, whole or not at all.
///
/// # Errors
/// If the file cannot be written.
pub fn save(path: &Path, plates: &Plates) -> Result<()> {
    replace_by(path, |out| {
        let mut zip = zip::ZipWriter::new(std::io::BufWriter::new(out));
        write(&mut zip, plates.record())?;
        zip.finish().map_err(std::io::Error::other)?.flush()
    })
}

fn write(zip: &mut zip::ZipWriter<impl Write + std::io::Seek>, record: &Record) -> std::io::Result<()> {
    let mut array = |name: &str, shape: &[usize], values: Written| {
        let shape: Vec<u64> = shape.iter().map(|edge| *edge as u64).collect();
        put(zip, name, &shape, &values, false)
    };
    let [width, height] = record.size;
    let facts = [
        width as f64,
        height as f64,
        record.plates.len() as f64,
        f64::from(u8::from(record.scatters_again)),
        record.accuracy,
        record.depth,
        record.dust_per_pc,
        record.range_um.0,
        record.range_um.1,
    ];
    array("facts", &[facts.len()], Written::Doubles(&facts))?;
    let nodes: Vec<f64> = record.nodes.iter().flat_map(|node| [node.lambda_um, node.k]).collect();
    array("nodes", &[record.nodes.len(), 2], Written::Doubles(&nodes))?;
    array("depths", &[record.depths.len()], Written::Doubles(&record.depths))?;
    let plain = |text: &str| text.replace(['\n', '\t'], " ");
    let notes: String = record.notes.iter().map(|(about, words)| format!("{}\t{}\n", plain(about), plain(words))).collect();
    let names: String = record.geometry.traits.iter().map(|one_trait| format!("{}\n", plain(&one_trait.name))).collect();
    for (name, text) in [("notes", notes), ("geometry", names)] {
        array(name, &[text.len()], Written::Bytes(text.as_bytes()))?;
    }
    for (number, one_trait) in record.geometry.traits.iter().enumerate() {
        array(&format!("geometry_{number}"), &[one_trait.values.len()], Written::Doubles(&one_trait.values))?;
    }
    for (number, plate) in record.plates.iter().enumerate() {
        let Plate { route, components, level, coordinates, rounding } = plate;
        let (way, index) = match route {
            Route::Scattered { star } | Route::Direct { star } => (0.0, *star),
            Route::Emitted { species } => (1.0, *species),
            Route::Background | Route::FieldStar { .. } => (2.0, 0),
        };
        let count = components.axes.len();
        let named = |what: &str| format!("plate_{number}_{what}");
        let light = [way, index as f64, rounding.depth, rounding.light, components.error];
        array(&named("light"), &[light.len()], Written::Doubles(&light))?;
        array(&named("mean"), &[components.mean.len()], Written::Doubles(&components.mean))?;
        array(&named("axes"), &[count, record.nodes.len()], Written::Doubles(&components.axes.concat()))?;
        array(&named("ranges"), &[count, 2], Written::Doubles(components.ranges.as_flattened()))?;
        array(&named("level"), &[height, width], Written::Singles(level))?;
        array(&named("coordinates"), &[count, height, width], Written::Words(&coordinates.concat()))?;
    }
    Ok(())
}

/// Reads what [`save`] wrote; each array may take `memory_limit` bytes.
///
/// # Errors
/// If the file is no such, or its numbers cannot be.
pub fn load(path: &Path, memory_limit: u64) -> Result<Plates> {
    let file = std::fs::File::open(path).map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    let archive = PlateArchive { file: Arc::new(file), path, memory_limit };
    let wrong = |what: &str| archive.wrong(what);
    let facts = archive.array::<f64>("facts", &[9])?;
    let edge = barnard::camera::MAX_EDGE as f64;
    let (Some(width), Some(height), Some(count)) = (whole(facts[0], edge), whole(facts[1], edge), whole(facts[2], MOST)) else {
        return Err(wrong("its size is invalid"));
    };
    let nodes: Vec<Node> = archive.rows("nodes", 2)?.into_iter().map(|row| Node { lambda_um: row[0], k: row[1] }).collect();
    let text = |name: &str| {
        let bytes = archive.any::<f32>(name)?.1.iter().map(|byte| *byte as u8).collect();
        String::from_utf8(bytes).map_err(|_| wrong("its text is invalid"))
    };
    let notes = text("notes")?;
    let notes = notes.lines().filter_map(|line| line.split_once('\t')).map(|(about, words)| (about.to_owned(), words.to_owned())).collect();
    let names = text("geometry")?;
    if names.lines().count() > MOST as usize {
        return Err(wrong("its fixed values are too many"));
    }
    let bound = |(number, name): (usize, &str)| Ok(Trait { name: name.to_owned(), values: archive.any(&format!("geometry_{number}"))?.1 });
    let traits = names.lines().enumerate().map(bound).collect::<Result<_>>()?;
    let record = Record {
        size: [width, height],
        plates: (0..count).map(|number| archive.plate(number, nodes.len(), [width, height])).collect::<Result<_>>()?,
        depths: archive.any("depths")?.1,
        geometry: Geometry { traits },
        scatters_again: facts[3] != 0.0,
        accuracy: facts[4],
        depth: facts[5],
        dust_per_pc: facts[6],
        range_um: (facts[7], facts[8]),
        notes,
        nodes,
    };
    Plates::of(record).map_err(|error| Error::file(path, error.to_string()))
}

/// The arrays of a file that [`save`] wrote.
struct PlateArchive<'a> {
    file: Arc<std::fs::File>,
    path: &'a Path,
    memory_limit: u64,
}

/// A number that is whole, and at most so large.
fn whole(value: f64, most: f64) -> Option<usize> {
    (value >= 0.0 && value <= most && value.fract() == 0.0).then_some(value as usize)
}

impl PlateArchive<'_> {
    fn wrong(&self, what: &str) -> Error {
        Error::file(self.path, format!("is not a valid plates file: {what}; write it again with `barnard plates`"))
    }

    /// A plate by its number, of `nodes` wavelengths.
    fn plate(&self, number: usize, nodes: usize, [width, height]: [usize; 2]) -> Result<Plate> {
        let named = |what: &str| format!("plate_{number}_{what}");
        let light = self.array::<f64>(&named("light"), &[5])?;
        let Some(index) = whole(light[1], 1e6) else { return Err(self.wrong("a light cannot be")) };
        let route = match light[0] {
            0.0 => Route::Scattered { star: index },
            1.0 => Route::Emitted { species: index },
            2.0 => Route::Background,
            _ => return Err(self.wrong("the kind of a light is unknown")),
        };
        let axes = self.rows(&named("axes"), nodes)?;
        let ranges = self.rows(&named("ranges"), 2)?.into_iter().map(|row| [row[0], row[1]]).collect();
        let mean = self.array(&named("mean"), &[nodes])?;
        let coordinates: Vec<f32> = self.array(&named("coordinates"), &[axes.len(), height, width])?;
        let coordinates = match width * height {
            0 => Vec::new(),
            pixels => coordinates.chunks_exact(pixels).map(|plane| plane.iter().map(|number| *number as u16).collect()).collect(),
        };
        Ok(Plate {
            route,
            components: Components { mean, axes, ranges, error: light[4] },
            level: self.array(&named("level"), &[height, width])?,
            coordinates,
            rounding: Rounding { depth: light[2], light: light[3] },
        })
    }

    fn any<T: FileFloat>(&self, name: &str) -> Result<(Vec<u64>, Vec<T>)> {
        formats::values(&mut Request::new(self.file.clone(), self.path, Some(name), self.memory_limit)?)
    }

    /// An array of a shape.
    fn array<T: FileFloat>(&self, name: &str, shape: &[usize]) -> Result<Vec<T>> {
        let (found_shape, values) = self.any(name)?;
        let wanted: Vec<u64> = shape.iter().map(|edge| *edge as u64).collect();
        if found_shape != wanted {
            return Err(Error::file(self.path, format!("array {name} has shape {found_shape:?}, expected {wanted:?}")));
        }
        Ok(values)
    }

    /// Rows of a given number of numbers.
    fn rows(&self, name: &str, length: usize) -> Result<Vec<Vec<f64>>> {
        let (shape, values) = self.any::<f64>(name)?;
        if shape.len() != 2 || shape[1] != length as u64 || length == 0 {
            return Err(Error::file(self.path, format!("array {name} has shape {shape:?}, expected rows of {length}")));
        }
        Ok(values.chunks_exact(length).map(<[f64]>::to_vec).collect())
    }
}
