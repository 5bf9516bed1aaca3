//! `barnard bake`

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::bail;
use barnard_files::bundle::{Baking, Bundle, Errors, PictureErrors, bake};
use barnard_files::formats::check_replaceable;
use clap::Args;

use crate::progress;
use crate::source::SceneArgs;

/// Packs a scene into one .barnard file that opens at once: densities on fewer voxels, the solved gas, all files.
///
/// Programs, Python and browsers open the file as a scene. Its errors relative to the scene are printed and stored.
///
/// Examples:
///   barnard bake my.toml -o my.barnard
///   barnard bake --builtin eagle -o eagle.barnard --limit 8
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Bake {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file, .barnard
    #[arg(short, long, value_name = "OUT", required = true)]
    output: PathBuf,
    #[command(flatten)]
    limit: Limit,
}

/// Limit of a bundle.
#[derive(Args)]
pub struct Limit {
    /// Largest size of the packed scene [MB]
    #[arg(long, value_name = "MB", default_value_t = 4.0)]
    limit: f64,
}

impl Limit {
    /// Bundle of a scene within the limit; prints its errors.
    pub fn bake(&self, scene: &SceneArgs) -> anyhow::Result<Bundle> {
        if !(self.limit > 0.0 && self.limit < 4000.0) {
            bail!("--limit {} is out of range; give a number of MB such as 4", self.limit);
        }
        scene.refuse_overrides("a bundle has the view of the scene")?;
        let (file, options) = scene.open_for("cpu")?;
        let bytes = (1e6 * self.limit) as usize;
        let start = Instant::now();
        let bundle = bake(&file, &Baking { bytes, options, compares: true }, &progress::control()?)?;
        let Errors { voxels, source_voxels, picture } = bundle.errors;
        if source_voxels > 0 {
            say!("{voxels} of {source_voxels} voxels along the longest edge, {:.1} s", start.elapsed().as_secs_f64());
        }
        if let Some(PictureErrors { size: [width, height], rms, total }) = picture {
            let (rms, total) = (100.0 * rms, 100.0 * total);
            say!("error relative to the scene at {width} x {height}: {rms:.2} % rms, {total:.2} % of the total light");
        }
        Ok(bundle)
    }
}

impl Bake {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if !Bundle::is_named_by(&self.output) {
            bail!("-o {}: the file name of a packed scene must end with .barnard", self.output.display());
        }
        check_replaceable(&self.output)?;
        let bundle = self.limit.bake(&self.scene)?;
        bundle.save(&self.output)?;
        let size = std::fs::metadata(&self.output)?.len();
        say!("wrote {} ({:.2} MB)", self.output.display(), size as f64 / 1e6);
        Ok(ExitCode::SUCCESS)
    }
}
