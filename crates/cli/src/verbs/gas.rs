//! `barnard gas`

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::bail;
use clap::Args;

use crate::progress;
use crate::source::SceneArgs;

/// Tells what a scene's stars make of its [gas]: temperature, ions, lines.
///
/// With -o, a report goes into a folder: gas.md with tables of stars and lines beside the benchmarks of Lexington, profiles
/// (ions and temperature as CSV, SVG, PNG), and maps of a plane through the middle of the
/// stars (maps.png).
#[derive(Args)]
pub struct Gas {
    #[command(flatten)]
    scene: SceneArgs,
    /// The folder of the report, made where it is missing
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

impl Gas {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let (scene, _) = self.scene.load()?;
        let Some(gas) = &scene.gas else { bail!("the scene has no [gas]; write one such as  [gas]  density = \"n_H\"  (docs/gas.md)") };
        gas.told().iter().for_each(|told| say!("{told}"));
        if let Some(folder) = &self.output {
            barnard_study::gas::write(&scene.name, gas, folder, &progress::control()?)?;
            say!("wrote {}", folder.join("gas.md").display());
        }
        Ok(ExitCode::SUCCESS)
    }
}
