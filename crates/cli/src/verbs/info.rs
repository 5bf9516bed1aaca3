//! `barnard info`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use barnard::memory::DEFAULT_LIMIT;
use barnard_files::formats::members;
use clap::Args;

/// Shows what this machine renders on, or what a file of arrays holds.
#[derive(Args)]
pub struct Info {
    /// A file of arrays (.vdb, .fits, .npy, .npz): its grids with names, sizes, types, units and places
    file: Option<PathBuf>,
    /// As JSON, for programs
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
            say!("{}", serde_json::to_string_pretty(&info)?);
            return Ok(ExitCode::SUCCESS);
        }
        say!("barnard {}", env!("CARGO_PKG_VERSION"));
        say!("cpu        {threads} threads, {}", std::env::consts::ARCH);
        adapters();
        Ok(ExitCode::SUCCESS)
    }
}

impl Info {
    /// What the file holds.
    fn contents(&self, path: &Path) -> anyhow::Result<ExitCode> {
        let (format, members) = members(path, DEFAULT_LIMIT)?;
        if self.json {
            let arrays: Vec<serde_json::Value> = members
                .iter()
                .map(|member| {
                    let facts = member.facts.iter().map(|(what, fact)| ((*what).to_owned(), fact.as_str().into()));
                    serde_json::json!({ "array": member.name, "facts": serde_json::Map::from_iter(facts) })
                })
                .collect();
            let info = serde_json::json!({ "file": path.display().to_string(), "format": format, "arrays": arrays });
            say!("{}", serde_json::to_string_pretty(&info)?);
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

/// The graphics adapters, in words.
#[cfg(feature = "gpu")]
fn adapters() {
    let adapters = barnard_gpu::adapters();
    for adapter in &adapters {
        say!("gpu        {} ({}{})", adapter.name, adapter.api, if adapter.real { "" } else { ", software: slower than cpu" });
        say!("           driver {}", adapter.driver);
        say!(
            "           volumes of at most {} voxels along an edge, {} textures of four channels, buffers of {:.0} MiB",
            adapter.volume_edge,
            adapter.textures,
            adapter.buffer as f64 / f64::from(1 << 20)
        );
    }
    if adapters.is_empty() {
        say!("gpu        none: no Vulkan, Metal or DirectX 12 driver was found");
    }
    let choice = if adapters.first().is_some_and(|a| a.real) { "gpu" } else { "cpu" };
    say!("--backend auto takes {choice}");
}

#[cfg(not(feature = "gpu"))]
fn adapters() {
    say!("gpu        this program was built without it; build it with: cargo build --release -F gpu");
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
