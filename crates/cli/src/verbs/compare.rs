//! `barnard compare`

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::bail;
use barnard::formats::read_image;
use barnard::image::Image;
use barnard::scene::DEFAULT_MEMORY;
use clap::Args;

/// Compares two images (.npy, .fits, .exr), B being the truth: relative RMSE √(mean (a − b)²)/√(mean b²) and largest difference, per band.
#[derive(Args)]
pub struct Compare {
    /// The image
    a: PathBuf,
    /// The truth
    b: PathBuf,
    /// Exit with status 1 if a band's relative RMSE is above this
    #[arg(long, value_name = "X")]
    tolerance: Option<f64>,
    /// As JSON, for programs
    #[arg(long)]
    json: bool,
}

struct Difference {
    band: String,
    rmse: f64,
    largest: f64,
}

impl Compare {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if let Some(tolerance) = self.tolerance
            && !(0.0..f64::INFINITY).contains(&tolerance)
        {
            bail!("--tolerance {tolerance} is no relative RMSE; give a number such as 1e-3");
        }
        let (a, b) = (read_image(&self.a, DEFAULT_MEMORY)?, read_image(&self.b, DEFAULT_MEMORY)?);
        if (a.width, a.height, a.bands.len()) != (b.width, b.height, b.bands.len()) {
            let shape = |i: &Image| format!("{} bands of {} x {}", i.bands.len(), i.width, i.height);
            bail!("the images differ in shape: {} has {}, {} has {}", self.a.display(), shape(&a), self.b.display(), shape(&b));
        }
        let rows: Vec<Difference> = pairs(&a, &b)?.into_iter().map(|(i, j)| difference(&a, i, &b, j)).collect();
        if self.json {
            let list: Vec<_> =
                rows.iter().map(|d| serde_json::json!({ "band": d.band, "relative_rmse": d.rmse, "max": d.largest })).collect();
            say!("{}", serde_json::to_string_pretty(&list)?);
        } else {
            for d in &rows {
                say!("{}: relative RMSE {:.3e}, largest difference {:.3e} W m-2 sr-1", d.band, d.rmse, d.largest);
            }
        }
        // NaN is above any tolerance.
        let worst = rows.iter().map(|d| if d.rmse.is_nan() { f64::INFINITY } else { d.rmse }).fold(0.0, f64::max);
        Ok(if self.tolerance.is_some_and(|t| worst > t) { ExitCode::FAILURE } else { ExitCode::SUCCESS })
    }
}

/// Bands by name; by position where a file knows no names.
fn pairs(a: &Image, b: &Image) -> anyhow::Result<Vec<(usize, usize)>> {
    let nameless = |i: &Image| i.bands.iter().enumerate().all(|(n, band)| band.name == barnard::formats::nameless(n));
    if nameless(a) || nameless(b) {
        return Ok((0..a.bands.len()).map(|i| (i, i)).collect());
    }
    let names = |i: &Image| i.bands.iter().map(|band| band.name.as_str()).collect::<Vec<_>>().join(", ");
    let partner = |(i, band): (usize, &barnard::image::Band)| {
        let Some(j) = b.bands.iter().position(|other| other.name == band.name) else {
            bail!("the images have different bands: {} against {}", names(a), names(b));
        };
        Ok((i, j))
    };
    a.bands.iter().enumerate().map(partner).collect()
}

fn difference(a: &Image, i: usize, b: &Image, j: usize) -> Difference {
    let largest = a.band(i).zip(b.band(j)).fold(0.0f64, |m, (x, y)| if (x - y).is_nan() { f64::NAN } else { m.max((x - y).abs()) });
    Difference { band: b.bands[j].name.clone(), rmse: a.relative_rmse(i, b, j), largest }
}
