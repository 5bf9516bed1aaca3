//! `barnard info`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use barnard::data::{Array, ArrayHeader, InputNote, Inputs, Numbers};
use barnard::scene::inspect;
use barnard_files::SceneFiles;
use barnard_files::formats::{Contents, Member, READERS, Writer, members, read_file, read_image, read_picture, unreadable, writer};
use clap::Args;

use crate::source::memory_limit;

/// Shows processors and graphics adapters, or the contents of a file.
#[derive(Args)]
pub struct Info {
    /// Input file: volume (.vdb, .h5, .fits, .npy), filter, spectrum, albedo, phase function, catalogue, star table, camera path or image (.fits, .exr, .npy)
    file: Option<PathBuf>,
    /// Also read the values of grids: range, mean and number of blanks
    #[arg(long, requires = "file")]
    values: bool,
    /// Memory limit of the values of one grid [GiB]
    #[arg(long, default_value_t = 16.0, value_name = "GIB")]
    memory: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Info {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if let Some(path) = &self.file {
            return self.contents(path);
        }
        let threads = rayon::current_num_threads();
        if self.json {
            let info = serde_json::json!({ "version": env!("CARGO_PKG_VERSION"), "threads": threads, "adapters": json() });
            crate::json::print(&info);
            return Ok(ExitCode::SUCCESS);
        }
        say!("barnard {}", env!("CARGO_PKG_VERSION"));
        say!("cpu        {threads} threads, {}", std::env::consts::ARCH);
        adapters();
        Ok(ExitCode::SUCCESS)
    }
}

impl Info {
    /// Contents of the file.
    fn contents(&self, path: &Path) -> anyhow::Result<ExitCode> {
        let limit = memory_limit(self.memory)?;
        if !READERS.iter().any(|reader| reader.members.is_some() && reader.is_for(path)) {
            return self.understood(path, limit);
        }
        let (format, mut members) = members(path, limit)?;
        if holds_tables_alone(&members) {
            return self.understood(path, limit);
        }
        let has_data = |member: &&mut Member| !member.facts.contains(&("kind", "no data".to_owned()));
        for member in members.iter_mut().filter(|_| self.values).filter(has_data) {
            member.facts.extend(summary(path, member, limit));
        }
        if self.json {
            let arrays: Vec<serde_json::Value> = members
                .iter()
                .map(|member| {
                    let facts = member.facts.iter().map(|(what, fact)| ((*what).to_owned(), fact.as_str().into()));
                    serde_json::json!({ "array": member.name, "facts": serde_json::Map::from_iter(facts) })
                })
                .collect();
            let info = serde_json::json!({ "file": path.display().to_string(), "format": format, "arrays": arrays });
            crate::json::print(&info);
            return Ok(ExitCode::SUCCESS);
        }
        say!("{}: {format}", path.display());
        for member in &members {
            if !member.name.is_empty() {
                say!("array = \"{}\"", member.name);
            }
            member.facts.iter().for_each(|(what, fact)| say!("  {what:<12}{fact}"));
        }
        Ok(ExitCode::SUCCESS)
    }
}

impl Info {
    /// Interpretation of a text file, table or picture by a scene.
    fn understood(&self, path: &Path, limit: u64) -> anyhow::Result<ExitCode> {
        std::fs::metadata(path).map_err(|error| unreadable(path, &error))?;
        if let Ok(Writer { extension, is_picture: true, .. }) = writer(path) {
            anyhow::bail!("{}: pictures (.{extension}) have no radiances; give a .fits, .exr or .npy file", path.display());
        }
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let files = SceneFiles::in_folder(path.parent().unwrap_or(Path::new("")));
        let (notes, refused) = match read_image(path, limit) {
            Ok(image) => {
                let bands: Vec<String> = image.bands.iter().map(barnard::image::Band::label).collect();
                let text = format!("picture: {} x {} pixels, bands {}", image.width, image.height, bands.join(", "));
                (vec![InputNote { file: name, text, is_inferred: false }], Vec::new())
            }
            Err(_) => inspect(&name, &Inputs::new(Arc::new(files), limit)),
        };
        if self.json {
            let notes: Vec<&str> = notes.iter().map(|note| note.text.as_str()).collect();
            let refused: serde_json::Map<String, serde_json::Value> =
                refused.into_iter().map(|(way, why)| (way.to_owned(), why.into())).collect();
            let info = serde_json::json!({ "file": path.display().to_string(), "understood": notes, "refused": refused });
            crate::json::print(&info);
            return Ok(ExitCode::SUCCESS);
        }
        if notes.is_empty() {
            let reasons: Vec<String> = refused.iter().map(|(way, why)| format!("  as a {way}: {why}")).collect();
            anyhow::bail!("{} cannot be read:\n{}", path.display(), reasons.join("\n"));
        }
        say!("{}", path.display());
        notes.iter().for_each(|note| say!("  {}", note.text));
        Ok(ExitCode::SUCCESS)
    }
}

/// True if the members of a FITS file are tables of columns, and none is an image.
fn holds_tables_alone(members: &[Member]) -> bool {
    let any = |contents: Contents| members.iter().any(|member| member.contents == contents);
    any(Contents::Columns) && !any(Contents::Numbers)
}

/// Statistics of the values of a grid or of a picture; otherwise the reason why there are none.
fn summary(path: &Path, member: &Member, limit: u64) -> Vec<(&'static str, String)> {
    let name = Some(member.name.as_str()).filter(|name| !name.is_empty());
    let (cells, [low, high, sum, blank]) = match read_file(path, name, &mut |layout: &ArrayHeader| Ok(layout.whole()), limit) {
        Ok(array) => (array.shape.iter().product::<usize>(), folded(&array)),
        Err(error) => match read_picture(path, name, limit) {
            Ok((_, values)) => (values.len(), statistics(values.into_iter())),
            Err(_) => return vec![("no grid", error.to_string())],
        },
    };
    let known = cells as f64 - blank;
    let mut facts = vec![("memory", format!("{:.1} MiB in single precision", 4.0 * cells as f64 / f64::from(1 << 20)))];
    if known > 0.0 {
        facts.extend([("range", format!("{low:e} to {high:e}")), ("mean", format!("{:.6e}", sum / known))]);
    }
    facts.push(("blank", format!("{blank} of {cells}")));
    facts
}

/// The least, the largest and the sum of the finite values, and how many are not finite.
fn statistics(values: impl Iterator<Item = f64>) -> [f64; 4] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0], |[low, high, sum, blank], v| {
        if v.is_finite() { [low.min(v), high.max(v), sum + v, blank] } else { [low, high, sum, blank + 1.0] }
    })
}

/// Statistics of an array.
fn folded(array: &Array) -> [f64; 4] {
    match &array.data {
        Numbers::Single(values) => statistics(values.iter().map(|v| f64::from(*v))),
        Numbers::Double(values) => statistics(values.iter().copied()),
        Numbers::Blocks(_) => statistics(array.data.doubles().into_iter()),
    }
}

/// The graphics adapters, in words.
#[cfg(feature = "gpu")]
fn adapters() {
    let adapters = barnard_gpu::adapters();
    for adapter in &adapters {
        say!("gpu        {} ({}{})", adapter.name, adapter.api, if adapter.real { "" } else { ", software: slower than cpu" });
        say!("           driver {}", adapter.driver);
        say!(
            "           volumes of at most {} voxels per edge, {} textures of four channels, buffers of {:.0} MiB",
            adapter.volume_edge,
            adapter.textures,
            adapter.buffer as f64 / f64::from(1 << 20)
        );
    }
    if adapters.is_empty() {
        say!("gpu        none: no Vulkan, Metal or DirectX 12 driver was found");
    }
    let choice = if adapters.first().is_some_and(|a| a.real) { "gpu" } else { "cpu" };
    say!("--backend auto selects {choice}");
}

#[cfg(not(feature = "gpu"))]
fn adapters() {
    say!("gpu        not in this build; build it with: cargo build --release -F gpu");
}

#[cfg(not(feature = "gpu"))]
fn json() -> Vec<serde_json::Value> {
    Vec::new()
}

#[cfg(feature = "gpu")]
fn json() -> Vec<serde_json::Value> {
    barnard_gpu::adapters().iter().map(json_of).collect()
}

#[cfg(feature = "gpu")]
fn json_of(adapter: &barnard_gpu::Adapter) -> serde_json::Value {
    serde_json::json!({
        "name": adapter.name,
        "api": adapter.api,
        "real": adapter.real,
        "driver": adapter.driver,
        "volume_edge_voxels": adapter.volume_edge,
        "textures": adapter.textures,
        "buffer_bytes": adapter.buffer,
    })
}
