//! `barnard cache`

use std::process::ExitCode;

use barnard_files::cache::{DiskCache, FOLDER, LIMIT};
use clap::{Args, Subcommand};
use indicatif::BinaryBytes;

use crate::counted;

/// Shows or clears the cache of long computations: solved gas, sampled fields, multiple scattering and settings of films.
///
/// A later run with the same inputs reads them instead of computing them again, with the same bits; a new version of the
/// program computes them anew. Records used least recently are removed beyond the limit.
///
/// Environment:
///   BARNARD_CACHE       folder of the cache (default: that of the platform), or "off"
///   BARNARD_CACHE_SIZE  limit in GiB (default: 4)
///
/// Examples:
///   barnard cache info
///   barnard cache clear
///   barnard render --no-cache --builtin eagle -o eagle.png
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct CacheVerb {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    /// Print folder, limit, and records by kind
    Info,
    /// Remove all records
    Clear,
}

impl CacheVerb {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let Some(cache) = DiskCache::of_user()? else {
            say!("no cache; set {FOLDER} to a folder to use one");
            return Ok(ExitCode::SUCCESS);
        };
        let usage = cache.usage();
        let (records, bytes) = usage.iter().fold((0, 0), |(records, bytes), kind| (records + kind.records, bytes + kind.bytes));
        match self.action {
            Action::Info => {
                say!("folder  {} ({FOLDER})", cache.folder().display());
                say!("limit   {} ({LIMIT})", BinaryBytes(cache.limit()));
                say!("used    {} in {}", BinaryBytes(bytes), counted(records, "record"));
                let width = usage.iter().map(|kind| kind.kind.len()).max().unwrap_or_default();
                for kind in usage {
                    say!("  {:width$}  {:>12}  {}", kind.kind, BinaryBytes(kind.bytes).to_string(), counted(kind.records, "record"));
                }
            }
            Action::Clear => {
                cache.clear()?;
                say!("removed {} ({})", counted(records, "record"), BinaryBytes(bytes));
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
