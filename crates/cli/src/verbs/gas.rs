//! `barnard gas`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::bail;
use barnard::scene::IonisedGas;
use clap::Args;

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
        self.output.map_or(Ok(()), |folder| report(&scene.name, gas, &folder))?;
        Ok(ExitCode::SUCCESS)
    }
}

#[cfg(feature = "study")]
fn report(name: &str, gas: &IonisedGas, folder: &Path) -> anyhow::Result<()> {
    barnard_study::gas::write(name, gas, folder, &crate::progress::control()?)?;
    say!("wrote {}", folder.join("gas.md").display());
    Ok(())
}

#[cfg(not(feature = "study"))]
fn report(_: &str, _: &IonisedGas, _: &Path) -> anyhow::Result<()> {
    bail!("this program was built without reports; build it with: cargo run --release -F study -- gas")
}
