//! `barnard gas`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::bail;
use barnard::scene::IonisedGas;
use clap::Args;

use crate::source::SceneArgs;

/// Computes ionisation, temperature and lines of a scene's [gas].
///
/// With -o, writes a report: gas.md with tables of stars and lines next to the Lexington benchmarks, profiles
/// (ions and temperature as CSV, SVG, PNG), and maps of a plane through the
/// stars (maps.png).
#[derive(Args)]
pub struct Gas {
    #[command(flatten)]
    scene: SceneArgs,
    /// Folder of the report, created if missing
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

impl Gas {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let (scene, _) = self.scene.load()?;
        let Some(gas) = scene.ionised() else { bail!("the scene has no [gas]; add one such as  [gas]  density = \"n_H\"  (docs/gas.md)") };
        gas.notes().iter().for_each(|note| say!("{note}"));
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
    bail!("this build has no reports; build it with: cargo run --release -F study -- gas")
}
