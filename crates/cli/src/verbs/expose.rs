//! `barnard expose`

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use barnard_files::formats::check_writable;
use clap::Args;

use crate::source::SceneArgs;
use crate::{outputs, progress};

/// Makes a picture from plates of a scene with other spectra, luminosities, passbands or albedo.
///
/// Examples:
///   barnard expose my.plates my.toml -o my.png
///   barnard expose my.plates my.toml -o hot.fits --set "star[0].temperature=30000 K" --set bands=hst-wfc3-broad
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Expose {
    /// Plates written by `barnard plates`
    plates: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file: .exr, .fits, .npy (radiance), .png, .tif or .jpg (picture); repeatable
    #[arg(short, long, value_name = "OUT", required = true)]
    output: Vec<PathBuf>,
}

impl Expose {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        self.output.iter().try_for_each(|path| check_writable(path))?;
        let (scene, options) = self.scene.load()?;
        crate::verbs::refuse_inputs(&scene, &self.output)?;
        let control = progress::control()?;
        let plates = barnard_files::plates::load(&self.plates, options.memory_limit)?;
        let start = Instant::now();
        let image = plates.expose(&scene, &control)?;
        say!("{} x {} px, {} bands, {:.3} s", image.width, image.height, image.bands.len(), start.elapsed().as_secs_f64());
        for (number, band) in image.bands.iter().enumerate() {
            for words in image.band_words(number) {
                detail!("{}: {words}", band.name);
            }
        }
        for path in &self.output {
            for file in outputs::save(&image, path, &scene)? {
                say!("wrote {}", file.display());
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
