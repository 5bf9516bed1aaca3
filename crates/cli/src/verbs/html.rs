//! `barnard html`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use barnard_files::bundle::Bundle;
use barnard_files::formats::{check_replaceable, replace};
use clap::Args;

use super::bake::Limit;
use crate::source::SceneArgs;

/// Name of the page of the explorer.
const PAGE: &str = "barnard.html";
/// Environment variable with the path of the page.
const PAGE_VARIABLE: &str = "BARNARD_PAGE";

/// Writes a scene and the explorer into one HTML file: it opens by a double click and works offline.
///
/// A .barnard file is used as it is; other scenes are packed first (see `barnard bake`).
///
/// Examples:
///   barnard html my.toml -o my.html
///   barnard html my.barnard -o my.html
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Html {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file, .html
    #[arg(short, long, value_name = "OUT", required = true)]
    output: PathBuf,
    #[command(flatten)]
    limit: Limit,
    /// The explorer's page, barnard.html as `.ci/web` makes it (default: next to the program, or $BARNARD_PAGE)
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
}

impl Html {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if self.output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("html")) {
            bail!("-o {}: the file name of a page must end with .html", self.output.display());
        }
        check_replaceable(&self.output)?;
        let path = self.page.clone().or_else(page).with_context(|| {
            format!("the page of the explorer is not installed; make it with .ci/web, and give it with --page target/web/{PAGE}")
        })?;
        let page = std::fs::read_to_string(&path).with_context(|| format!("--page {}: cannot be read", path.display()))?;
        let bundle = match &self.scene.scene {
            Some(path) if Bundle::is_named_by(path) => {
                if !self.scene.set.is_empty() {
                    bail!("--set: a bundle is used as it is; change the scene, and pack it with `barnard bake`");
                }
                Bundle::open(path, self.scene.memory_limit()?)?
            }
            _ => self.limit.bake(&self.scene)?,
        };
        let html = bundle.html(&page)?;
        replace(&self.output, html.as_bytes())?;
        say!("wrote {} ({:.2} MB)", self.output.display(), html.len() as f64 / 1e6);
        Ok(ExitCode::SUCCESS)
    }
}

/// Page of the explorer: that of the environment, next to the program, in the share folder of its prefix, or in the build folder.
fn page() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os(PAGE_VARIABLE).filter(|path| !path.is_empty()) {
        return Some(path.into());
    }
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?;
    let places = [folder.join(PAGE), folder.join("../share/barnard").join(PAGE), folder.join("../web").join(PAGE)];
    places.into_iter().find(|path: &PathBuf| Path::is_file(path))
}
