//! `barnard check`

use std::process::ExitCode;

use barnard::backend::Job;
use barnard::control::Control;
use barnard::image::Report;
use barnard::plan::{Options, Plan, Planner, Quality};
use barnard::points;
use barnard::scene::{Parameter, Scene, parameters};
use clap::Args;
use spectra::rule::Node;

use crate::backends::registry;
use crate::json::{self, json_of};
use crate::source::SceneArgs;
use crate::{counted, outputs, progress};

/// Validates a scene and prints its contents and plan.
#[derive(Args)]
pub struct Check {
    #[command(flatten)]
    scene: SceneArgs,
    /// List the scene's parameters with value, type and range, without a plan
    #[arg(long)]
    parameters: bool,
    /// Print the expected report as JSON on standard output, other lines on standard error
    #[arg(long, conflicts_with = "parameters")]
    json: bool,
}

impl Check {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if self.parameters {
            parameters(self.scene.open_for("cpu")?.0.tree()).iter().for_each(list);
            return Ok(ExitCode::SUCCESS);
        }
        outputs::take_stdout(self.json);
        let (scene, options) = self.scene.load()?;
        describe(&scene);
        points::catalogue_note(&scene, &scene.camera).iter().for_each(|note| say!("catalogue {note}"));
        barnard::backend::left_out(&scene).iter().for_each(|note| say!("left out  {note}"));
        scene.inputs.iter().for_each(|input| say!("input     {}: {}", input.file, input.text));
        describe_bounces(&scene, &options)?;
        let plan = Planner::new(&options).with_quality(Quality::Estimate).plan(&scene, None, &progress::control()?)?;
        let report = plan.expected_report();
        describe_plan(&plan, &report);
        say!("ok");
        if self.json {
            json::print(&serde_json::json!({ "report": json_of(&report.tree()) }));
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Prints a parameter as a scene writes it, with its type.
fn list(parameter: &Parameter) {
    let default = if parameter.is_stated { "" } else { ", default" };
    let stated = format!("{} = {}", parameter.path, parameter.value);
    say!("{stated:<56} # {}{default}", parameter.key.type_words());
}

/// Optical depth at V beyond which the scale of the dust is likely to be wrong.
const OPAQUE: f64 = 200.0;

/// Stars listed one by one.
const MAX_STARS: usize = 12;

fn describe(scene: &Scene) {
    let camera = &scene.camera;
    say!("scene     {}{}", scene.name, if scene.description.is_empty() { String::new() } else { format!(": {}", scene.description) });
    say!("camera    {} x {} pixels, {} per pixel", camera.width, camera.height, counted(camera.supersampling.pow(2), "ray"));
    match &scene.dust {
        None => say!("dust      none"),
        Some(dust) => {
            say!("dust      law {}, box {}, {}", dust.extinction.name, size(dust.density.bounds().size()), lattice(&*dust.density))
        }
    }
    for star in scene.stars.iter().take(MAX_STARS) {
        say!("star      {} at {}, L_lambda(550 nm) {:.3e} W/um", star.name, place(star.position), star.spectrum.continuum(0.55));
    }
    if scene.stars.len() > MAX_STARS {
        say!("star      and {} more", scene.stars.len() - MAX_STARS);
    }
    for gas in scene.species() {
        say!("emission  {}: {} lines, {}", gas.name, gas.spectrum.lines().len(), lattice(&*gas.density));
    }
    for note in scene.ionised().iter().flat_map(|gas| gas.notes()) {
        say!("gas       {note}");
    }
    for band in &scene.bands {
        let (low, high) = band.support_um();
        say!(
            "band      {}: pivot {:.2} nm, width {:.2} nm, {:.1} to {:.1} nm, {}-counting",
            band.name(),
            band.pivot().nm(),
            band.width().nm(),
            low * 1e3,
            high * 1e3,
            band.counting().name()
        );
    }
}

/// Tells what one scattering leaves out, or which of the exact back ends refuse more, in their words.
fn describe_bounces(scene: &Scene, options: &Options) -> anyhow::Result<()> {
    let scatters = scene.dust.is_some() && !(scene.stars.is_empty() && scene.species().is_empty() && scene.background.spectrum.is_none());
    match scene.method.bounces {
        _ if !scatters => {}
        1 => say!(
            "bounces   1, single scattering; in clouds of depth 1 and more, multiple scattering adds a third of the light (--bounces 1000)"
        ),
        many => say!("bounces   at most {many}"),
    }
    for entry in registry().entries().iter().filter(|entry| !entry.planned) {
        let unsupported = (entry.open)(scene)?.unsupported(&Job::new(scene, options)?, &Control::default())?;
        if let Some(why) = unsupported {
            say!("          unsupported by --backend {}: {why}", entry.name);
        }
    }
    Ok(())
}

fn lattice(field: &dyn barnard::field::Field) -> String {
    field.grid().map_or("a function".into(), |grid| {
        let [x, y, z] = grid.lattice().dims;
        format!("grid of {x} x {y} x {z}")
    })
}

fn size(v: barnard::glam::DVec3) -> String {
    format!("{:.4} x {:.4} x {:.4} pc", v.x, v.y, v.z)
}

fn place(v: barnard::glam::DVec3) -> String {
    format!("({:.4}, {:.4}, {:.4}) pc", v.x, v.y, v.z)
}

fn describe_plan(plan: &Plan, report: &Report) {
    let (spectral, depth) = (plan.spectral(), plan.spectral().depth);
    say!("method    {}, {} per sample, depths at V up to {depth:.3}", spectral.method, counted(spectral.terms(), "term"));
    if depth > OPAQUE {
        say!("note: an optical depth of {depth:.0} is opaque; hydrogen densities in cm-3 need a dust scale like \"5.32e-22 mag cm2\"");
    }
    let list = |nodes: &[Node]| {
        let words: Vec<String> = nodes.iter().map(|n| format!("{:.1} nm (k {:.4})", n.lambda_um * 1e3, n.k)).collect();
        words.join(", ")
    };
    if let Some(common) = plan.spectral().common_nodes() {
        say!("nodes     of all passbands: {}", list(common));
    }
    for band in &plan.spectral().bands {
        match band.nodes() {
            Some(nodes) => say!("nodes     {}: {}", band.band.name(), list(nodes)),
            None => say!("band      {}", band.band.name()),
        }
        say!("          {}", report.worst_words(band.band.name()));
    }
    say!("steps     {}", plan.stepping());
    for (key, value) in report.statements() {
        say!("{key}: {value}");
    }
    crate::verbs::warn_of_accuracy(report);
    say!("memory    {:.1} MiB of grids and tables", plan.bytes() as f64 / f64::from(1 << 20));
}
