//! `barnard fit`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, bail};
use barnard::control::Control;
use barnard::properties::Table;
use barnard::scene::Scene;
use barnard_files::SaveImage;
use barnard_files::formats::{check_replaceable, check_writable, numbered, replace};
use barnard_fit::solve::{Model, Prediction};
use barnard_fit::{Assumed, Data, Fitted, Images, Observation, Parameter, Residuals, fit, free_parameters};
use clap::{Args, ValueEnum};

use crate::progress::{self, Note};
use crate::source::SceneArgs;

/// Fits parameters of a scene to observed images: values with standard errors, correlations, residuals.
///
/// A parameter is a scene key, whose value is the start: KEY, KEY=LOW..HIGH with bounds,
/// KEY~MEAN+-SIGMA with a prior.
///
/// Examples:
///   barnard fit my.toml --to master.fits --free "star[0].luminosity, star[0].temperature=5000..40000, dust.scale"
///   barnard fit my.toml --to a.fits --with a.toml --to b.fits --with b.toml --free "emission[0].scale" -o fit.json --residuals left_%d.fits
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Fit {
    #[command(flatten)]
    scene: SceneArgs,
    /// Observed image (FITS: one HDU per passband, by name, standard errors, masks; FILE[NAME] selects one); repeatable
    #[arg(long, value_name = "IMAGE", required = true)]
    to: Vec<PathBuf>,
    /// TOML overrides for that image: [instrument], bands, [camera], [observation]; one per --to, or none
    #[arg(long, value_name = "TOML")]
    with: Vec<PathBuf>,
    /// Missing metadata to assume from the scene: unit (BUNIT) or sky position (WCS)
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    assume: Vec<Unsaid>,
    /// Free parameters, separated by commas: KEY, KEY=LOW..HIGH with bounds, KEY~MEAN+-SIGMA with a prior
    #[arg(long, value_name = "KEYS")]
    free: String,
    /// Output file of values, covariance and errors (JSON)
    #[arg(short, long, value_name = "OUT.json")]
    output: Option<PathBuf>,
    /// Print the result as JSON on standard output, other lines on standard error
    #[arg(long)]
    json: bool,
    /// Output file of the scene with the fitted values
    #[arg(long, value_name = "OUT.toml")]
    found: Option<PathBuf>,
    /// Output file of residuals (data minus model) and standard errors: left.fits, or left_%d.fits for several images
    #[arg(long, value_name = "OUT.fits")]
    residuals: Option<PathBuf>,
    /// Output file of a histogram of residuals in standard errors, compared with noise (.svg or .png)
    #[arg(long, value_name = "OUT")]
    plot: Option<PathBuf>,
    /// Output file of a corner plot of the parameters (.svg or .png)
    #[arg(long, value_name = "OUT")]
    corner: Option<PathBuf>,
}

/// Facts that an image may not state.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Unsaid {
    /// The unit of its values
    Unit,
    /// Position on the sky
    Place,
}

impl Fit {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        crate::outputs::take_stdout(self.json);
        if !self.with.is_empty() && self.with.len() != self.to.len() {
            bail!("{} --with for {} --to; give one --with per image, or none", self.with.len(), self.to.len());
        }
        self.scene.refuse_overrides("a fit reads the scene again for each evaluation")?;
        let left = self.residual_files()?;
        self.check_outputs(&left)?;
        let (file, options) = self.scene.open_for("cpu")?;
        let free = free_parameters(&self.free, file.tree())?;
        let outputs: Vec<PathBuf> =
            [&self.output, &self.found, &self.plot, &self.corner].into_iter().flatten().chain(&left).cloned().collect();
        crate::verbs::refuse_inputs(&file.scene, &outputs)?;
        let overlays = self.with.iter().map(|path| overlay(path)).collect::<anyhow::Result<Vec<Table>>>()?;
        let with = |i: usize| overlays.get(i).cloned().unwrap_or_default();
        let is_assumed = |unsaid: Unsaid| self.assume.contains(&unsaid);
        let assumed = Assumed { unit: is_assumed(Unsaid::Unit), place: is_assumed(Unsaid::Place) };
        let observation = |(i, file): (usize, &PathBuf)| Observation { data: Data::File(file.clone()), with: with(i), assumed };
        let observations: Vec<Observation> = self.to.iter().enumerate().map(observation).collect();
        let note = Note::default();
        note.set("fitting".into());
        let control = progress::control_with(&note)?;
        let start = Instant::now();
        let (mut images, data, first) = Images::new(file.tree().clone(), file.loader().clone(), &observations, &free, options, &control)?;
        let fitted = fit(&mut Noted { model: &mut images, note: &note, pictures: 0 }, &data, &free, &first, &control)?;
        let seconds = start.elapsed().as_secs_f64();
        tell(&free, &images.units(), &first, &fitted, seconds);
        let residuals = images.residuals(&data, &fitted.prediction, &fitted.sigma, &control)?;
        for of_image in &residuals {
            for (band, values) in &of_image.normalised {
                let chi2: f64 = values.iter().map(|value| value * value).sum();
                say!("{} {band}: chi2 {chi2:.1} of {} pixels", of_image.name, values.len());
            }
        }
        if self.json {
            crate::json::print(&json(&free, &images.units(), &first, &fitted));
        }
        let found = FinishedFit { free: &free, first: &first, images: &images, fitted: &fitted };
        self.write(&found, &left, &residuals, &file.scene)?;
        warn(&free, &fitted);
        Ok(ExitCode::SUCCESS)
    }

    /// Checks the names of all outputs, and that they can be written.
    fn check_outputs(&self, left: &[PathBuf]) -> anyhow::Result<()> {
        for (flag, path, ending) in
            [("-o", &self.output, "json"), ("--found", &self.found, "toml"), ("--residuals", &self.residuals, "fits")]
        {
            let is_other = |path: &&PathBuf| path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case(ending));
            if let Some(path) = path.as_ref().filter(is_other) {
                bail!("{flag} {}: the file name must end with .{ending}", path.display());
            }
        }
        self.output.iter().chain(&self.found).try_for_each(|path| check_replaceable(path))?;
        left.iter().try_for_each(|path| check_writable(path))?;
        for (flag, path) in [("--plot", &self.plot), ("--corner", &self.corner)] {
            path.iter().try_for_each(|path| check_plot(flag, path))?;
        }
        Ok(())
    }

    /// Writes the outputs, and prints their names.
    fn write(&self, found: &FinishedFit, left: &[PathBuf], residuals: &[Residuals], scene: &Scene) -> anyhow::Result<()> {
        let FinishedFit { free, first, images, fitted } = found;
        let wrote = |path: &PathBuf| say!("wrote {}", path.display());
        if let Some(path) = &self.output {
            replace(path, format!("{:#}\n", json(free, &images.units(), first, fitted)).as_bytes())?;
            wrote(path);
        }
        if let Some(path) = &self.found {
            replace(path, barnard_files::toml::text(&images.tree(&fitted.values)?).as_bytes())?;
            wrote(path);
        }
        for (path, of_image) in left.iter().zip(residuals) {
            of_image.image.save(path, &scene.save_options().without_glare())?;
            wrote(path);
        }
        if let Some(path) = &self.plot {
            plots::residuals(path, residuals)?;
            wrote(path);
        }
        if let Some(path) = &self.corner {
            let row = |i: usize| vec![free[i].key.clone(), value_words(fitted, i), images.units()[i].to_owned()];
            plots::corner(path, (0..free.len()).map(row).collect(), fitted)?;
            wrote(path);
        }
        Ok(())
    }

    /// The files of residuals, one for each image.
    fn residual_files(&self) -> anyhow::Result<Vec<PathBuf>> {
        let Some(pattern) = &self.residuals else { return Ok(Vec::new()) };
        match self.to.len() {
            1 if !pattern.to_string_lossy().contains('%') => Ok(vec![pattern.clone()]),
            count => (1..=count as i64).map(|number| numbered(pattern, number)).collect::<Option<_>>().with_context(|| {
                format!("--residuals {}: several images require a number in the name, such as left_%d.fits", pattern.display())
            }),
        }
    }
}

/// Model that shows the number of its pictures next to the progress.
struct Noted<'a> {
    model: &'a mut Images,
    note: &'a Note,
    pictures: usize,
}

impl Model for Noted<'_> {
    fn predict(&mut self, values: &[f64], control: &Control) -> barnard::error::Result<Prediction> {
        self.pictures += 1;
        self.note.set(format!("fitting, picture {}", self.pictures));
        self.model.predict(values, control)
    }

    fn floor(&mut self, values: &[f64], control: &Control) -> barnard::error::Result<Vec<f64>> {
        self.model.floor(values, control)
    }

    fn renew(&mut self, values: &[f64], control: &Control) -> barnard::error::Result<bool> {
        self.model.renew(values, control)
    }
}

/// The tables of a file.
fn overlay(path: &Path) -> anyhow::Result<Table> {
    let text = barnard_files::read_text(path)?;
    Ok(barnard_files::toml::properties(&path.display().to_string(), &text)?)
}

/// Says what was found.
fn tell(free: &[Parameter], units: &[&str], first: &[f64], fitted: &Fitted, seconds: f64) {
    let (chi2, count) = fitted.chi2;
    let degrees = count.saturating_sub(free.len());
    say!(
        "{} free ({} linear), {count} pixels, chi2 {chi2:.1} for {degrees} degrees of freedom, {} pictures, {seconds:.1} s",
        free.len(),
        fitted.linear.iter().filter(|linear| **linear).count(),
        fitted.evaluations
    );
    for (i, parameter) in free.iter().enumerate() {
        if fitted.degenerate.contains(&i) {
            say!("{} is not determined by these data (start {})", parameter.key, barnard::spectra::units::short(first[i]));
            continue;
        }
        say!(
            "{} = {} {} (start {}; model error {:.1e})",
            parameter.key,
            value_words(fitted, i),
            units[i],
            barnard::spectra::units::short(first[i]),
            fitted.floor[i]
        );
    }
    for a in 0..free.len() {
        for b in (0..a).filter(|b| fitted.correlation(a, *b).abs() > 0.5) {
            say!("correlation of {} and {}: {:.2}", free[b].key, free[a].key, fitted.correlation(a, b));
        }
    }
}

/// A value with its standard error, to two digits of that.
fn value_words(fitted: &Fitted, i: usize) -> String {
    let (value, sigma) = (fitted.values[i], fitted.sigma_of(i));
    if !sigma.is_finite() {
        return format!("{} +- unknown", barnard::spectra::units::short(value));
    }
    let digits = (1.0 - sigma.abs().log10().floor()).clamp(0.0, 12.0);
    let digits = if digits.is_finite() { digits as usize } else { 6 };
    let written = |v: f64, many: usize| match v != 0.0 && (v.abs() < 1e-3 || v.abs() >= 1e7) {
        true => format!("{v:.many$e}"),
        false => format!("{v:.digits$}"),
    };
    // As many digits of the value as reach those of the error.
    let reaching = (value / sigma).abs().log10().floor().clamp(0.0, 12.0) as usize + 1;
    format!("{} +- {}", written(value, reaching), written(sigma, 1))
}

/// A finished fit, with its free keys and images.
struct FinishedFit<'a> {
    free: &'a [Parameter],
    first: &'a [f64],
    images: &'a Images,
    fitted: &'a Fitted,
}

/// Warnings of a fit.
fn warn(free: &[Parameter], fitted: &Fitted) {
    if !fitted.degenerate.is_empty() {
        let names: Vec<&str> = fitted.degenerate.iter().map(|i| free[*i].key.as_str()).collect();
        complain!(
            "warning: the data do not distinguish {}; add an image in another passband, free fewer keys, or give one a prior: KEY~MEAN+-SIGMA",
            names.join(", ")
        );
    }
    for i in &fitted.bounded {
        complain!("warning: {} is at its bound; its standard error is unreliable", free[*i].key);
    }
    if let Some(warning) = fitted.chi2_warning() {
        complain!("warning: {warning}");
    }
    if !fitted.converged {
        complain!("warning: the fit did not converge; use a better start, or bounds");
    }
}

fn json(free: &[Parameter], units: &[&str], first: &[f64], fitted: &Fitted) -> serde_json::Value {
    let parameter = |i: usize| {
        serde_json::json!({
            "key": free[i].key,
            "unit": units[i],
            "value": fitted.values[i],
            "sigma": fitted.sigma_of(i),
            "model_error": fitted.floor[i],
            "start": first[i],
            "linear": fitted.linear[i],
            "at_bound": fitted.bounded.contains(&i),
            "degenerate": fitted.degenerate.contains(&i),
        })
    };
    let row = |i: usize| (0..free.len()).map(|j| fitted.covariance[(i, j)]).collect::<Vec<f64>>();
    serde_json::json!({
        "parameters": (0..free.len()).map(parameter).collect::<Vec<_>>(),
        "covariance": (0..free.len()).map(row).collect::<Vec<_>>(),
        "chi2": fitted.chi2.0,
        "pixels": fitted.chi2.1,
        "converged": fitted.converged,
        "pictures": fitted.evaluations,
    })
}

#[cfg(feature = "study")]
fn check_plot(flag: &str, path: &Path) -> anyhow::Result<()> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("svg" | "png") => Ok(check_replaceable(path)?),
        _ => bail!("{flag} {}: the file name of a plot must end with .svg or .png", path.display()),
    }
}

#[cfg(not(feature = "study"))]
fn check_plot(flag: &str, path: &Path) -> anyhow::Result<()> {
    bail!("{flag} {}: this build has no plots; build it with --features study", path.display())
}

#[cfg(feature = "study")]
mod plots {
    use std::path::Path;

    use barnard_files::formats::replace;
    use barnard_fit::{Fitted, Residuals};
    use barnard_study::{Axis, Corner, Figure, Series};

    const REACH: f64 = 5.0;
    const BINS: usize = 50;

    /// Residuals in standard errors: how many there are of each size, and how many noise makes.
    pub fn residuals(path: &Path, residuals: &[Residuals]) -> anyhow::Result<()> {
        let middle = |bin: usize| REACH * (2.0 * (bin as f64 + 0.5) / BINS as f64 - 1.0);
        let width = 2.0 * REACH / BINS as f64;
        let normal = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
        let expected = Series { name: "noise".into(), points: (0..BINS).map(|bin| (middle(bin), normal(middle(bin)))).collect() };
        let of_band = |of_image: &Residuals, band: &str, values: &[f64]| {
            let mut counts = vec![0.0; BINS];
            for value in values {
                let bin = ((value + REACH) / width).floor();
                if (0.0..BINS as f64).contains(&bin) {
                    counts[bin as usize] += 1.0 / (values.len() as f64 * width);
                }
            }
            let points = counts.iter().enumerate().filter(|(_, count)| **count > 0.0).map(|(bin, count)| (middle(bin), *count)).collect();
            Series { name: format!("{} {band}", of_image.name), points }
        };
        let series =
            residuals.iter().flat_map(|of_image| of_image.normalised.iter().map(move |(band, values)| of_band(of_image, band, values)));
        let figure = Figure {
            name: "residuals".into(),
            title: "Data minus model".into(),
            x: Axis::linear("residual [standard errors]"),
            y: Axis::log("density of pixels"),
            series: std::iter::once(expected).chain(series).collect(),
        };
        written(path, || figure.svg(), || figure.png())
    }

    /// Certainty of each parameter with its lines, and how any two go together.
    pub fn corner(path: &Path, parameters: Vec<Vec<String>>, fitted: &Fitted) -> anyhow::Result<()> {
        let count = parameters.len();
        let correlation = (0..count).map(|a| (0..count).map(|b| fitted.correlation(a, b)).collect()).collect();
        let corner = Corner { title: "68 and 95 %, standard errors".into(), parameters, correlation };
        written(path, || corner.svg(), || corner.png())
    }

    fn written(
        path: &Path,
        svg: impl FnOnce() -> barnard_study::Result<String>,
        png: impl FnOnce() -> barnard_study::Result<Vec<u8>>,
    ) -> anyhow::Result<()> {
        let is_svg = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
        let bytes = if is_svg { svg()?.into_bytes() } else { png()? };
        Ok(replace(path, &bytes)?)
    }
}

/// A program without plots has none to write: they are refused before.
#[cfg(not(feature = "study"))]
mod plots {
    use std::path::Path;

    use barnard_fit::{Fitted, Residuals};

    pub fn residuals(_: &Path, _: &[Residuals]) -> anyhow::Result<()> {
        Ok(())
    }

    pub fn corner(_: &Path, _: Vec<Vec<String>>, _: &Fitted) -> anyhow::Result<()> {
        Ok(())
    }
}
