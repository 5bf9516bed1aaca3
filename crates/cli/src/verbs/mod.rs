//! The verbs: one file each.

mod bake;
#[cfg(feature = "study")]
mod bench;
mod cache;
mod check;
mod compare;
mod completions;
mod convert;
mod expose;
mod fit;
mod frames;
mod gas;
mod html;
mod info;
mod list;
mod observe;
mod plates;
mod referee;
mod render;
#[cfg(feature = "study")]
mod study;
#[cfg(feature = "view")]
mod view;

use std::process::ExitCode;

use clap::Subcommand;

#[cfg(not(all(feature = "view", feature = "study")))]
use crate::missing::Missing;

/// The verbs of the command.
#[derive(Subcommand)]
pub enum Verb {
    /// Open the explorer: fly through a scene and edit it interactively
    #[cfg(feature = "view")]
    View(view::View),
    /// Open the explorer (feature view)
    #[cfg(not(feature = "view"))]
    #[command(hide = true)]
    View(Missing),
    /// Render a scene to .exr, .fits, .npy, .png, .tif or .jpg
    Render(render::Render),
    /// Simulate an observation: frames of counts, and a master with errors and a mask
    Observe(Box<observe::Observe>),
    /// Store a picture per light, to change spectra without rendering again
    Plates(Box<plates::MakePlates>),
    /// Make a picture from plates, with other spectra, passbands or albedo
    Expose(Box<expose::Expose>),
    /// Pack a scene into one .barnard file that opens at once
    #[command(alias = "bake-plan")]
    Bake(Box<bake::Bake>),
    /// Write a scene and the explorer into one HTML file
    Html(Box<html::Html>),
    /// Fit parameters of a scene to observed images, with error bars
    Fit(Box<fit::Fit>),
    /// Validate a scene and print its plan: nodes, certificate, memory
    Check(check::Check),
    /// Print a catalogue: passbands, scenes, laws, methods, ...
    List(list::List),
    /// Show processors and graphics adapters, or the contents of a file
    Info(info::Info),
    /// Convert a grid between .vdb, .fits, .h5 and .npy
    Convert(Box<convert::Convert>),
    /// Compute the ionisation of a scene's gas, and write a report: profiles, lines, maps
    Gas(gas::Gas),
    /// Compare two images band by band
    Compare(compare::Compare),
    /// Time the methods on this machine, with their errors
    #[cfg(feature = "study")]
    Bench(bench::Bench),
    /// Time the methods (feature study)
    #[cfg(not(feature = "study"))]
    #[command(hide = true)]
    Bench(Missing),
    /// Compare all methods: figures and tables
    #[cfg(feature = "study")]
    Study(study::Study),
    /// Compare all methods (feature study)
    #[cfg(not(feature = "study"))]
    #[command(hide = true)]
    Study(Missing),
    /// Show or clear the cache of long computations
    Cache(cache::CacheVerb),
    /// Print shell completions
    Completions(completions::Completions),
}

impl Verb {
    /// The verb where none was given: the explorer, where there is a screen.
    pub fn unsaid() -> Option<Self> {
        #[cfg(feature = "view")]
        if view::View::is_possible() {
            return Some(Verb::View(view::View::plain()));
        }
        None
    }

    /// Does what the verb says.
    pub fn run(self) -> anyhow::Result<ExitCode> {
        match self {
            #[cfg(feature = "view")]
            Verb::View(verb) => verb.run(),
            #[cfg(not(feature = "view"))]
            Verb::View(verb) => verb.run("view", "view"),
            Verb::Render(verb) => verb.run(),
            Verb::Observe(verb) => verb.run(),
            Verb::Plates(verb) => verb.run(),
            Verb::Expose(verb) => verb.run(),
            Verb::Bake(verb) => verb.run(),
            Verb::Html(verb) => verb.run(),
            Verb::Fit(verb) => verb.run(),
            Verb::Check(verb) => verb.run(),
            Verb::Convert(verb) => verb.run(),
            Verb::List(verb) => verb.run(),
            Verb::Info(verb) => verb.run(),
            Verb::Gas(verb) => verb.run(),
            Verb::Compare(verb) => verb.run(),
            #[cfg(feature = "study")]
            Verb::Bench(verb) => verb.run(),
            #[cfg(not(feature = "study"))]
            Verb::Bench(verb) => verb.run("bench", "study"),
            #[cfg(feature = "study")]
            Verb::Study(verb) => verb.run(),
            #[cfg(not(feature = "study"))]
            Verb::Study(verb) => verb.run("study", "study"),
            Verb::Cache(verb) => verb.run(),
            Verb::Completions(verb) => verb.run(),
        }
    }
}

/// Warns if a picture is less exact than requested.
fn warn_of_accuracy(report: &barnard::image::Report) {
    let wanted = report.accuracy.unwrap_or_default();
    if report.misses_accuracy() {
        let sampling = report.spatial.and_then(|s| {
            let stars = s.unresolved.is_some_and(|stars| stars.error > wanted);
            s.sampling.filter(|(error, _)| stars || *error > 0.5 * s.error)
        });
        let remedy = match sampling {
            Some((_, edge)) => {
                format!("functions are sampled to {edge} voxels per edge; set bake = {} in [method], which takes longer", 2 * edge)
            }
            None => "use a finer grid or more samples".into(),
        };
        complain!(
            "warning: the spatial error exceeds the requested accuracy of {wanted:.1e}; {remedy}, or accept it with a larger accuracy"
        );
    }
}

/// Refuses outputs that the scene reads.
fn refuse_inputs(scene: &barnard::Scene, outputs: &[std::path::PathBuf]) -> anyhow::Result<()> {
    for path in outputs {
        let same = |file: &&std::path::PathBuf| file.canonicalize().is_ok_and(|f| path.canonicalize().is_ok_and(|p| p == f));
        if let Some(input) = scene.provenance.iter().flat_map(|from| &from.files).find(same) {
            anyhow::bail!("{}: the output is an input of the scene ({}); choose another name", path.display(), input.display());
        }
    }
    Ok(())
}
