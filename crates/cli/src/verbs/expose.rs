//! `barnard expose`

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use barnard_files::formats::check_writable;
use clap::Args;

use crate::source::SceneArgs;
use crate::{outputs, progress};

/// Makes pictures of plates: of a scene that differs from theirs in spectra, luminosities, passbands or albedo alone.
///
/// Examples:
///   barnard expose my.plates my.toml -o my.png
///   barnard expose my.plates my.toml -o hot.fits --set "star.0.temperature=30000 K" --set bands=hst-wfc3-broad
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Expose {
    /// The plates, which `barnard plates` wrote
    plates: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    /// Output path: .exr, .fits, .npy (radiance), .png, .tif or .jpg (picture); as often as there are files to write
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
        say!("{} x {}, {} bands, {:.3} s", image.width, image.height, image.bands.len(), start.elapsed().as_secs_f64());
        for band in &image.bands {
            for words in &band.certificate {
                say!("{}: {words}", band.name);
            }
        }
        for path in &self.output {
            for file in outputs::save(&image, path, &scene.camera)? {
                say!("wrote {}", file.display());
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
