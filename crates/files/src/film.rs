//! Saved state of the path tracer: an `.npz` archive of doubles.
//!
//! | array | shape | what |
//! |---|---|---|
//! | `paths` | 4 | paths of each pixel so far, how many of all were left out, bounces, seed |
//! | `count`, `mean`, `scatter` | bands × height × width | those that count, their mean [W m⁻² sr⁻¹], Σ (x − mean)² |
//! | `first` | bands × checked pixels | what the first paths of some pixels bring: the same where scene, camera, bands, bounces and seed are |

use std::path::Path;
use std::sync::Arc;

use barnard::backend::path::{Estimate, Film, Options, first_paths};
use barnard::error::{Error, Result};
use barnard::scene::Scene;

use crate::formats::{self, Request};

/// Writes `film` down, whole or not at all.
///
/// # Errors
/// If the file cannot be written.
pub fn save(path: &Path, scene: &Scene, options: &Options, film: &Film) -> Result<()> {
    let first = first_paths(scene, options)?;
    let bands = scene.bands.len() as u64;
    let shape = [bands, scene.camera.height as u64, scene.camera.width as u64];
    let all = |value: fn(&Estimate) -> f64| film.estimates.iter().map(value).collect::<Vec<f64>>();
    let checked = [bands, first.len() as u64 / bands.max(1)];
    let bytes = formats::archive(&[
        ("paths", &[5], vec![film.samples as f64, film.bad as f64, scene.method.bounces as f64, options.seed as f64, options.first as f64]),
        ("count", &shape, all(|e| e.count as f64)),
        ("mean", &shape, all(|e| e.mean)),
        ("scatter", &shape, all(|e| e.scatter)),
        ("first", &checked, first),
    ])?;
    formats::replace(path, &bytes)
}

/// Reads what [`save`] wrote of the same scene with the same bounces and seed.
///
/// # Errors
/// If it is of another scene, or no such file.
pub fn load(path: &Path, scene: &Scene, options: &Options, memory_limit: u64) -> Result<Film> {
    let archive = FilmArchive::open(path, memory_limit)?;
    let shape = [scene.bands.len() as u64, scene.camera.height as u64, scene.camera.width as u64];
    let [count, mean, scatter] = [archive.plane("count", &shape)?, archive.plane("mean", &shape)?, archive.plane("scatter", &shape)?];
    let paths = archive.array("paths")?.1;
    if paths.len() != 5 || paths[2..] != [scene.method.bounces as f64, options.seed as f64, options.first as f64] {
        return Err(archive.of_another("number of bounces or another seed"));
    }
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<u64>>();
    if bits(archive.array("first")?.1) != bits(first_paths(scene, options)?) {
        return Err(archive.of_another("scene"));
    }
    let whole = |v: f64| v >= 0.0 && v.fract() == 0.0 && v < 2f64.powi(53);
    let sound = paths.iter().chain(&count).all(|v| whole(*v))
        && count.iter().all(|v| *v <= paths[0])
        && mean.iter().all(|v| v.is_finite())
        && scatter.iter().all(|v| v.is_finite() && *v >= 0.0);
    if !sound {
        return Err(Error::file(path, "is not a valid state of the path tracer; remove it to restart"));
    }
    let estimate = |((count, mean), scatter): ((f64, f64), f64)| Estimate { count: count as u64, mean, scatter };
    let estimates = count.into_iter().zip(mean).zip(scatter).map(estimate).collect();
    Ok(Film { estimates, samples: paths[0] as u64, bad: paths[1] as u64 })
}

/// The arrays of a file that [`save`] wrote.
struct FilmArchive<'a> {
    file: Arc<std::fs::File>,
    path: &'a Path,
    memory_limit: u64,
}

impl<'a> FilmArchive<'a> {
    fn open(path: &'a Path, memory_limit: u64) -> Result<Self> {
        let file = std::fs::File::open(path).map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
        Ok(Self { file: Arc::new(file), path, memory_limit })
    }

    /// An array, with its shape.
    fn array(&self, name: &str) -> Result<(Vec<u64>, Vec<f64>)> {
        formats::doubles(&mut Request::new(self.file.clone(), self.path, Some(name), self.memory_limit)?)
    }

    /// An array of this shape, bands × height × width.
    fn plane(&self, name: &str, shape: &[u64; 3]) -> Result<Vec<f64>> {
        let (found, values) = self.array(name)?;
        if found == shape { Ok(values) } else { Err(self.of_another("size or number of bands")) }
    }

    fn of_another(&self, what: &str) -> Error {
        Error::file(self.path, format!("is the state of another {what}; use another file, or remove this one to restart"))
    }
}
