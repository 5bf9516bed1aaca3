//! `barnard plates`

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::bail;
use barnard::Plates;
use barnard::plates::Reach;
use barnard::spectra::units::{Wavelength, short};
use barnard_files::formats::check_replaceable;
use clap::Args;

use crate::progress;
use crate::source::SceneArgs;

/// Stores a picture per light; `barnard expose` then changes spectra without rendering again.
///
/// Examples:
///   barnard plates my.toml -o my.plates
///   barnard plates my.toml -o my.plates --range "380 nm" "1000 nm" --dust 0.5 2
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct MakePlates {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file, .plates (an .npz archive for NumPy)
    #[arg(short, long, value_name = "OUT", required = true)]
    output: PathBuf,
    /// Wavelength range of later passbands (default: those of the scene, extended by a tenth)
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"])]
    range: Vec<Wavelength>,
    /// Range of later amounts of dust relative to the scene's (default: 1 1)
    #[arg(long, num_args = 2, value_names = ["LEAST", "MOST"])]
    dust: Vec<f64>,
}

impl MakePlates {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if self.output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("plates")) {
            bail!("-o {}: the file name of plates must end with .plates", self.output.display());
        }
        check_replaceable(&self.output)?;
        let (scene, options) = self.scene.load()?;
        crate::verbs::refuse_inputs(&scene, std::slice::from_ref(&self.output))?;
        let mut reach = Reach::default();
        if let [from, to] = self.range[..] {
            reach.range_um = Some((from.0, to.0));
        }
        if let [least, most] = self.dust[..] {
            reach.dust = (least, most);
        }
        let start = Instant::now();
        let plates = Plates::new(&scene, reach, None, &options, &progress::control()?)?;
        let seconds = start.elapsed().as_secs_f64();
        barnard_files::plates::save(&self.output, &plates)?;
        let record = plates.record();
        let nm = |um: f64| short((um * 1e4).round() / 10.0);
        let (from, to) = plates.range_um();
        let most = record.plates.iter().map(|plate| 1 + plate.coordinates.len()).max().unwrap_or(0);
        say!(
            "{} x {} px, {} lights of at most {most} numbers per pixel, {} to {} nm, {seconds:.2} s, {:.1} MiB",
            record.size[0],
            record.size[1],
            record.plates.len(),
            nm(from),
            nm(to),
            plates.bytes() as f64 / f64::from(1 << 20)
        );
        for (key, value) in &record.notes {
            say!("{key}: {value}");
        }
        say!("wrote {}", self.output.display());
        Ok(ExitCode::SUCCESS)
    }
}
