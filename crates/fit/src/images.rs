//! Scenes as models of observed images.
//!
//! Each image has a scene: that of the fit, with tables of its own in place, such as `[instrument]`, `bands` and `[camera]`. Its model is
//! what the scene's instrument would record in endless frames, in the unit of the scene's `[observation]`; without an instrument it is
//! the picture. Where light scatters once, pictures are those of plates, so that spectra cost no march.

use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::error::{Error, Result};
use barnard::image::{Band, Image, LayerChoice, Samples};
use barnard::instrument::Kernels;
use barnard::plan::{Choices, Planner, Quality, RuleTarget};
use barnard::plates::{Reach, binds_dust, dust_per_pc};
use barnard::properties::Table;
use barnard::scene::{Loader, Part, Scene};
use barnard::{Options, Planned, Plates};

use crate::Parameter;
use crate::marched::Marched;
use crate::observation::Observation;
use crate::parameter::FreeParameter;
use crate::recorded::{agree, counted, header, recorded};
use crate::solve::{Measured, Model, Prediction};

/// Where the amount of dust is free, plates are made of powers of this times the one that the fit begins with, and serve those between.
const DUST_STEP: f64 = 1.6;
/// Range, relative to their own values: half of a step to both sides, and what differences need beyond.
const DUST: (f64, f64) = (0.77, 1.3);
/// Rounding of sums of plates in double precision.
const DOUBLE: f64 = 1e-13;
/// Most plates that are kept, and the part of the memory that they may take.
const KEPT: usize = 16;
const SHARE: u64 = 4;

/// Observed images, and the scenes that are their models.
#[derive(Debug, Clone)]
pub struct Images {
    tree: Table,
    loader: Loader,
    options: Options,
    free: Vec<FreeParameter>,
    sets: Vec<Set>,
    plates: Vec<Marched>,
    start: Vec<f64>,
}

/// An image.
#[derive(Debug, Clone)]
struct Set {
    name: String,
    with: Table,
    /// For each band the pixels that count.
    good: Vec<Vec<usize>>,
    /// Pixels along a row and a column.
    size: [usize; 2],
    /// Choice of the pilots for the first picture of the fit, which all hold to (derivatives would see them change), and the amount of
    /// dust there.
    choices: Option<(Choices, f64)>,
    plan: Option<Planned>,
    kernels: Kernels,
    /// Range of plates: other amounts of dust where that is free.
    reach: Reach,
    /// The last scene, which holds its fields for the next.
    scene: Option<Scene>,
}

/// Residuals of an image.
#[derive(Debug, Clone)]
pub struct Residuals {
    /// The name of its file.
    pub name: String,
    /// The bands of the image, data minus model, with standard errors; NaN where pixels do not count.
    pub image: Image,
    /// Data minus model in standard errors of each band.
    pub normalised: Vec<(String, Vec<f64>)>,
}

/// The picture of a scene, and the same with all errors that it may have at most added, where they are asked for.
struct Pictured {
    image: Image,
    worse: Option<Image>,
}

impl Images {
    /// Reads data and finds parameters in a scene that is `tree`; what the scene says of each is where the fit begins.
    ///
    /// # Errors
    /// If data cannot be read, have other pixels or passbands than the scene's, or no standard errors though the scene has no instrument,
    /// and where the scene says no number for a parameter.
    pub fn new(
        tree: Table,
        loader: Loader,
        observations: &[Observation],
        parameters: &[Parameter],
        options: Options,
        control: &Control,
    ) -> Result<(Self, Measured, Vec<f64>)> {
        if observations.is_empty() {
            return Err(Error::missing("an image", "fit one image or more"));
        }
        let (mut free, mut start) = (Vec::new(), Vec::new());
        for parameter in parameters {
            let (parameter, value) = FreeParameter::of(&tree, parameter)?;
            free.push(parameter);
            start.push(value);
        }
        // Trial scenes would fill a cache.
        let (loader, options) = (loader.with_cache(None), options.with_cache(None));
        let mut images = Self { tree, loader, options, free, sets: Vec::new(), plates: Vec::new(), start: start.clone() };
        let mut data = Measured { values: Vec::new(), sigma: Vec::new() };
        for observation in observations {
            let scene = images.scene(&observation.with, &start)?;
            let (path, file) = (observation.data.path(), observation.data.read(&scene, images.options.memory_limit)?);
            let mut kernels = Kernels::within(images.options.memory_limit / SHARE / observations.len() as u64);
            let model = header(&scene, &mut kernels, control)?;
            agree(&path, &file, &model, &scene, observation.assumed)?;
            let good = counted(&path, &file, &model, &scene, &mut data)?;
            let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            let is_free = !binds_dust(&scene) && images.moves_dust(&observation.with);
            images.sets.push(Set {
                name,
                with: observation.with.clone(),
                good,
                size: [file.width, file.height],
                choices: None,
                plan: None,
                kernels,
                reach: if is_free { Reach { dust: DUST, ..Reach::default() } } else { Reach::default() },
                scene: Some(scene),
            });
        }
        Ok((images, data, start))
    }

    /// Rounding of predictions, relative to the brightest: double precision where light scatters once, single where more often.
    pub fn rounding(&self) -> f64 {
        let again = self.sets.iter().filter_map(|set| set.scene.as_ref()).any(|scene| scene.method.bounces > 1);
        if again { f64::from(f32::EPSILON) } else { DOUBLE }
    }

    /// The unit of each parameter, as the scene writes it.
    pub fn units(&self) -> Vec<&str> {
        self.free.iter().map(FreeParameter::unit).collect()
    }

    /// The tree of the scene with some values of the parameters.
    ///
    /// # Errors
    /// If one cannot be set.
    pub fn tree(&self, values: &[f64]) -> Result<Table> {
        let mut tree = self.tree.clone();
        self.free.iter().zip(values).try_for_each(|(parameter, value)| parameter.set(&mut tree, *value))?;
        Ok(tree)
    }

    /// The scene of an image with some values of the parameters.
    fn scene(&self, with: &Table, values: &[f64]) -> Result<Scene> {
        let mut tree = self.tree(values)?;
        with.iter().for_each(|(key, property)| tree.insert(key, property.clone()));
        Ok(Scene::from_properties(&tree, "fit", &self.loader)?.with_layers(LayerChoice::default()))
    }

    /// True if a free parameter changes the amount of dust of an image's scene.
    fn moves_dust(&self, with: &Table) -> bool {
        with.get("dust").is_none() && self.free.iter().any(|parameter| parameter.parts.contains(&Part::Amount))
    }

    /// Choice of the pilots for an image's scene with some values of the parameters, and its amount of dust. Its plates are the latest.
    fn chosen(&mut self, number: usize, values: &[f64], control: &Control) -> Result<(Choices, f64)> {
        let scene = self.scene(&self.sets[number].with, values)?;
        let set = &mut self.sets[number];
        let plan = if scene.method.bounces > 1 {
            Planner::new(&self.options).plan(&scene, set.plan.as_ref(), control)?
        } else {
            let made = |reach| Plates::planned(&scene, reach, set.plan.as_ref(), None, &self.options, control);
            let (plates, plan) = match made(set.reach) {
                // Other amounts may take too much: each has plates of its own then.
                Err(error) if set.reach != Reach::default() && !matches!(error, Error::Interrupted) => {
                    let planned = made(Reach::default())?;
                    set.reach = Reach::default();
                    planned
                }
                made => made?,
            };
            self.plates.push(Marched::new(number, &scene, plates));
            plan
        };
        let choices = Choices::of(&plan);
        set.plan = Some(plan);
        Ok((choices, dust_per_pc(&scene)))
    }

    /// The choices that the picture of a scene holds to, which has some amount of dust.
    fn choices_for(&mut self, number: usize, amount: f64, control: &Control) -> Result<Choices> {
        let (choices, base) = match self.sets[number].choices.clone() {
            Some(known) => known,
            None => {
                let chosen = self.chosen(number, &self.start.clone(), control)?;
                self.sets[number].choices.insert(chosen).clone()
            }
        };
        // More dust is deeper.
        let more = if base > 0.0 { (amount / base).max(1.0) } else { 1.0 };
        Ok(Choices { rules: RuleTarget { depth: choices.rules.depth * more, ..choices.rules }, ..choices })
    }

    /// The amount of dust whose plates serve one.
    fn amount_of_plates(&self, number: usize, amount: f64) -> f64 {
        match self.sets[number].choices {
            Some((_, base)) if base > 0.0 && amount > 0.0 && self.sets[number].reach.dust == DUST => {
                base * DUST_STEP.powf(((amount / base).ln() / DUST_STEP.ln()).round())
            }
            _ => amount,
        }
    }

    /// The picture of an image's scene.
    fn pictured(&mut self, number: usize, scene: &Scene, with_floor: bool, control: &Control) -> Result<Pictured> {
        let choices = self.choices_for(number, dust_per_pc(scene), control)?;
        let spatial = choices.spatial.map_or(0.0, |spatial| spatial.error);
        if scene.method.bounces > 1 {
            let planner = Planner::new(&self.options).with_quality(Quality::Chosen(Box::new(choices)));
            let plan = planner.plan(scene, self.sets[number].plan.as_ref(), control)?;
            let (image, _) = Renderer::new(&mut cpu::Cpu).render(&plan, control)?;
            let worst =
                |band: usize| image.report.certificates_of(scene.bands[band].name()).iter().map(|(_, c)| c.relative).fold(0.0, f64::max);
            let relative: Vec<f64> = (0..scene.bands.len()).map(|band| worst(band) + spatial).collect();
            let worse = with_floor.then(|| with_errors(&image, &relative, &[]));
            self.sets[number].plan = Some(plan);
            return Ok(Pictured { image, worse });
        }
        let amount = self.amount_of_plates(number, dust_per_pc(scene));
        let served = |known: &Marched| known.are_of(number, scene, amount).then(|| known.plates.mixture(scene).ok()).flatten();
        // The latest are the last.
        let known = (0..self.plates.len()).rev().find_map(|i| served(&self.plates[i]).map(|mixture| (i, mixture)));
        let (plates, mixture) = match known {
            Some((i, mixture)) => (self.plates.remove(i).plates, mixture),
            None => {
                let of_amount = scene.edited_within(self.options.memory_limit, control, |spec| {
                    spec.dust.iter_mut().for_each(|dust| dust.sigma_v_per_pc = amount);
                })?;
                let choices = self.choices_for(number, amount, control)?;
                let set = &mut self.sets[number];
                let (plates, plan) = Plates::planned(&of_amount, set.reach, set.plan.as_ref(), Some(&choices), &self.options, control)?;
                set.plan = Some(plan);
                let mixture = plates.mixture(scene)?;
                (plates, mixture)
            }
        };
        let image = plates.pictured_in_double(scene, &mixture, control)?;
        let worse = with_floor.then(|| with_errors(&image, &vec![spatial; scene.bands.len()], &plates.errors(&mixture)));
        self.plates.push(Marched::new(number, scene, plates));
        let room = self.options.memory_limit / SHARE;
        let bytes = |all: &[Marched]| all.iter().map(|known| known.plates.bytes()).sum::<u64>();
        while self.plates.len() > KEPT || (self.plates.len() > 1 && bytes(&self.plates) > room) {
            self.plates.remove(0);
        }
        Ok(Pictured { image, worse })
    }

    /// Predictions for all data and their maximum error.
    fn predicted(&mut self, values: &[f64], with_floor: bool, control: &Control) -> Result<(Prediction, Vec<f64>)> {
        let (mut mean, mut sigma, mut floor) = (Vec::new(), Vec::new(), Vec::new());
        let mut knows = true;
        for number in 0..self.sets.len() {
            let scene = self.scene(&self.sets[number].with, values)?;
            let pictured = self.pictured(number, &scene, with_floor, control)?;
            let kernels = &mut self.sets[number].kernels;
            let ideal = recorded(&scene, pictured.image, kernels, control)?;
            let worse = pictured.worse.map(|worse| recorded(&scene, worse, kernels, control)).transpose()?;
            if [ideal.width, ideal.height] != self.sets[number].size {
                let problem = format!("a free parameter changes the size of a picture to {} x {} pixels", ideal.width, ideal.height);
                return Err(Error::conflict(problem, "do not free keys of the camera or the pixel scale"));
            }
            knows &= scene.instrument.is_some();
            self.sets[number].scene = Some(scene);
            for (band, good) in self.sets[number].good.iter().enumerate() {
                let values: Vec<f64> = ideal.in_unit(band).collect();
                mean.extend(good.iter().map(|pixel| values[*pixel]));
                if let Some(errors) = ideal.errors_of(band) {
                    let errors: Vec<f64> = ideal.in_unit(errors).collect();
                    sigma.extend(good.iter().map(|pixel| errors[*pixel]));
                }
                if let Some(worse) = &worse {
                    let worse: Vec<f64> = worse.in_unit(band).collect();
                    floor.extend(good.iter().map(|pixel| (worse[*pixel] - values[*pixel]).abs()));
                }
            }
        }
        let sigma = Some(sigma).filter(|_| knows);
        Ok((Prediction { mean, sigma }, floor))
    }

    /// Residuals of each image at the fitted values.
    ///
    /// # Errors
    /// Errors of the model.
    pub fn residuals(&self, data: &Measured, prediction: &Prediction, sigma: &[f64], control: &Control) -> Result<Vec<Residuals>> {
        let mut at = 0;
        let mut all = Vec::new();
        for set in &self.sets {
            let scene = self.scene(&set.with, &self.start)?;
            let header = header(&scene, &mut set.kernels.clone(), control)?.image;
            let pixels = header.width * header.height;
            let mut samples = vec![f32::NAN; 2 * set.good.len() * pixels];
            let mut normalised = Vec::new();
            for (band, good) in set.good.iter().enumerate() {
                let mut errors = Vec::new();
                for pixel in good {
                    let left = data.values[at] - prediction.mean[at];
                    samples[band * pixels + pixel] = left as f32;
                    samples[(set.good.len() + band) * pixels + pixel] = sigma[at] as f32;
                    errors.push(left / sigma[at]);
                    at += 1;
                }
                normalised.push((scene.bands[band].name().to_owned(), errors));
            }
            // Values are in the unit already.
            let bare = |band: &Band| Band { in_unit: None, ..band.clone() };
            let radiances: Vec<Band> = header.radiances().map(|band| bare(&header.bands[band])).collect();
            let bands = radiances.iter().cloned().chain(radiances.iter().map(Band::of_errors)).collect();
            let image = Image { bands, samples: Samples::Single(samples), layers: Vec::new(), ..header };
            all.push(Residuals { name: set.name.clone(), image, normalised });
        }
        Ok(all)
    }
}

impl Model for Images {
    fn predict(&mut self, values: &[f64], control: &Control) -> Result<Prediction> {
        Ok(self.predicted(values, false, control)?.0)
    }

    fn floor(&mut self, values: &[f64], control: &Control) -> Result<Vec<f64>> {
        Ok(self.predicted(values, true, control)?.1)
    }

    /// Steps, star depths and samples that pilots choose for the values, where they are finer than those of before.
    fn renew(&mut self, values: &[f64], control: &Control) -> Result<bool> {
        let mut is_other = false;
        for number in 0..self.sets.len() {
            let Some((before, base)) = self.sets[number].choices.clone() else { continue };
            let (now, amount) = self.chosen(number, values, control)?;
            let both = before.and(&now);
            let is_finer =
                (both.stepping, both.star_factor, both.sampled_edge) != (before.stepping, before.star_factor, before.sampled_edge);
            self.sets[number].choices = Some(match is_finer {
                true => (Choices { spatial: now.spatial, rules: now.rules, scattered: now.scattered, ..both }, amount),
                false => (Choices { spatial: now.spatial, scattered: now.scattered, ..before }, base),
            });
            // Those that pilots were sent for are of other choices.
            let of_pilots = self.plates.len().checked_sub(1);
            let is_stale = |at: usize, image: usize| image == number && (is_finer || Some(at) == of_pilots);
            let mut at = 0..;
            self.plates.retain(|known| at.next().is_some_and(|at| !is_stale(at, known.image)));
            is_other |= is_finer;
        }
        Ok(is_other)
    }
}

/// A picture with errors added: parts of each band, and those of its pixels where they are known.
fn with_errors(image: &Image, relative: &[f64], of_pixels: &[f32]) -> Image {
    let light = (0..relative.len()).flat_map(|band| image.band(band).map(move |value| value * (1.0 + relative[band])));
    let errors = of_pixels.iter().map(|error| f64::from(*error)).chain(std::iter::repeat(0.0));
    Image { samples: Samples::Double(light.zip(errors).map(|(light, error)| light + error).collect()), ..image.clone() }
}
