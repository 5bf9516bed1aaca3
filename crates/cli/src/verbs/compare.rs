//! `barnard compare`

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::bail;
use barnard::image::{Band, Image, relative_rms};
use barnard::memory::DEFAULT_LIMIT;
use barnard::observation::RadianceUnit;
use barnard::properties::Choices;
use barnard_files::formats::{UNIT_NOTE, read_image};
use clap::Args;

/// Compares image A with ground truth B (.npy, .fits, .exr): relative RMSE √(mean (a − b)²)/√(mean b²) and largest
/// difference, per band.
///
/// Standard errors are not compared; where A has some, the mean of ((a − b)/error)² is
/// printed, which is 1 for purely statistical differences.
#[derive(Args)]
pub struct Compare {
    /// The image
    a: PathBuf,
    /// The truth
    b: PathBuf,
    /// Exit with status 1 if the relative RMSE of a band exceeds this
    #[arg(long, value_name = "X")]
    tolerance: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The unit of images that say none.
const SI: &str = "W m-2 sr-1";

struct Difference {
    band: String,
    rmse: f64,
    largest: f64,
    /// Mean of ((a − b)/error)², where A knows its standard errors.
    chance: Option<f64>,
}

impl Compare {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if let Some(tolerance) = self.tolerance
            && !(0.0..f64::INFINITY).contains(&tolerance)
        {
            bail!("--tolerance {tolerance} is out of range; give a relative RMSE such as 1e-3");
        }
        let (a, b) = (read_image(&self.a, DEFAULT_LIMIT)?, read_image(&self.b, DEFAULT_LIMIT)?);
        let shape = |i: &Image| (i.width, i.height, i.radiances().count());
        if shape(&a) != shape(&b) {
            let shape = |i: &Image| format!("{} bands of {} x {}", i.radiances().count(), i.width, i.height);
            bail!("the images differ in shape: {} has {}, {} has {}", self.a.display(), shape(&a), self.b.display(), shape(&b));
        }
        // Other programs spell the same unit in other ways.
        let unit = |i: &Image| i.notes.iter().find(|(key, _)| key == UNIT_NOTE).map_or(SI, |(_, unit)| unit).to_owned();
        let is_own = |unit: &str| RadianceUnit::ROWS.iter().any(|(_, row)| unit.starts_with(row.fits()));
        if unit(&a) != unit(&b) && is_own(&unit(&a)) && is_own(&unit(&b)) {
            let (a_is, b_is) = (unit(&a), unit(&b));
            bail!(
                "the images differ in unit: {} has {a_is}, {} has {b_is}; render both with the same [observation] unit",
                self.a.display(),
                self.b.display()
            );
        }
        let rows: Vec<Difference> = pairs(&a, &b)?.into_iter().map(|(i, j)| difference(&a, i, &b, j)).collect();
        if self.json {
            let list: Vec<_> = rows
                .iter()
                .map(|d| serde_json::json!({ "band": d.band, "relative_rmse": d.rmse, "max": d.largest, "chi_squared": d.chance }))
                .collect();
            crate::json::print(&list.into());
        } else {
            for d in &rows {
                let chance = d.chance.map_or_else(String::new, |c| format!(", ((a - b)/error)^2 is {c:.3} in the mean"));
                say!("{}: relative RMSE {:.3e}, largest difference {:.3e} {}{chance}", d.band, d.rmse, d.largest, unit(&a));
            }
        }
        // NaN is above any tolerance.
        let worst = rows.iter().map(|d| if d.rmse.is_nan() { f64::INFINITY } else { d.rmse }).fold(0.0, f64::max);
        Ok(if self.tolerance.is_some_and(|t| worst > t) { ExitCode::FAILURE } else { ExitCode::SUCCESS })
    }
}

/// Bands by name; by position where a file knows no names.
fn pairs(a: &Image, b: &Image) -> anyhow::Result<Vec<(usize, usize)>> {
    let nameless = |i: &Image| i.bands.iter().enumerate().all(|(n, band)| band.label() == barnard_files::formats::nameless(n));
    if nameless(a) || nameless(b) {
        return Ok(a.radiances().zip(b.radiances()).collect());
    }
    let names = |i: &Image| i.bands.iter().map(Band::label).collect::<Vec<_>>().join(", ");
    let partner = |i: usize| {
        let Some(j) = b.bands.iter().position(|other| other.label() == a.bands[i].label()) else {
            bail!("the images differ in bands: {} and {}", names(a), names(b));
        };
        Ok((i, j))
    };
    a.radiances().map(partner).collect()
}

fn difference(a: &Image, i: usize, b: &Image, j: usize) -> Difference {
    // Where both have no light, their magnitudes are equal and infinite.
    let pairs = a.band(i).zip(b.band(j)).filter(|(x, y)| x != y || x.is_finite());
    let largest = pairs.clone().fold(0.0f64, |m, (x, y)| if (x - y).is_nan() { f64::NAN } else { m.max((x - y).abs()) });
    let chance = a.errors_of(i).map(|e| {
        let known = a.band(i).zip(b.band(j)).zip(a.band(e)).filter(|(_, error)| *error > 0.0);
        let (sum, count) = known.fold((0.0, 0.0), |(sum, count), ((x, y), error)| (sum + ((x - y) / error).powi(2), count + 1.0));
        sum / f64::max(count, 1.0)
    });
    Difference { band: b.bands[j].label(), rmse: relative_rms(pairs), largest, chance }
}
