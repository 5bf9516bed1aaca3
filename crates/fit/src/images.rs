//! Scenes as models of observed images.
//!
//! Each image has a scene: that of the fit, with tables of its own in place, such as `[instrument]`, `bands` and `[camera]`. Its model is
//! what the scene's instrument would record in endless frames, in the unit of the scene's `[observation]`; without an instrument it is
//! the picture. Where light scatters once, pictures are those of plates, so that spectra cost no march.

use std::path::{Path, PathBuf};

use barnard::backend::cpu;
use barnard::control::Control;
use barnard::error::{Error, Result};
use barnard::image::{Band, ERROR_SUFFIX, Image, LayerChoice, Samples};
use barnard::instrument::{Exposures, Kernels};
use barnard::plan::Choices;
use barnard::plates::{Reach, binds_dust};
use barnard::properties::Table;
use barnard::scene::{Loader, Scene};
use barnard::{Options, Plan, Plates};
use barnard_files::formats::{Observed, observed, sky_of};

use crate::Parameter;
use crate::parameter::Held;
use crate::solve::{Measured, Model, Prediction};

/// An image to be fitted.
#[derive(Debug, Clone)]
pub struct Observation {
    /// The FITS file: an image HDU for each passband by its name, with standard errors as NAME_error or ERR, and a mask as mask.NAME, DQ or
    /// MASK where there is one.
    pub file: PathBuf,
    /// Tables and keys that stand in place of those of the scene.
    pub with: Table,
}

/// How far pixels of data may lie from those of the model, in pixels.
const APART: f64 = 0.05;
/// The amounts of dust that plates serve where that is free, as parts of the one at which they are made.
const DUST: (f64, f64) = (0.6, 1.7);
/// Most plates that are kept, and the part of the memory that they may take.
const KEPT: usize = 16;
const SHARE: u64 = 4;

/// Observed images, and the scenes that are their models.
#[derive(Debug)]
pub struct Images {
    tree: Table,
    loader: Loader,
    options: Options,
    held: Vec<Held>,
    sets: Vec<Set>,
    plates: Vec<Plates>,
    start: Vec<f64>,
}

/// An image.
#[derive(Debug)]
struct Set {
    name: String,
    with: Table,
    /// For each band the pixels that count.
    good: Vec<Vec<usize>>,
    /// What pilots chose for the first picture, which all hold to: derivatives would see them change.
    choices: Option<Choices>,
    plan: Option<Plan>,
    kernels: Kernels,
    /// What plates are to reach: other amounts of dust, once there was one.
    reach: Reach,
    /// The last scene, which holds its fields for the next.
    scene: Option<Scene>,
}

/// What is left of an image.
#[derive(Debug, Clone)]
pub struct Residuals {
    /// The name of its file.
    pub name: String,
    /// The bands of the image, data less model, with standard errors; NaN where pixels do not count.
    pub image: Image,
    /// Data less model in standard errors of each band.
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
    /// Where data cannot be read, have other pixels or passbands than the scene's, or no standard errors though the scene has no instrument,
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
            return Err(Error::value("data of a fit", "none", "one image or more"));
        }
        let (mut held, mut start) = (Vec::new(), Vec::new());
        for parameter in parameters {
            let (own, value) = Held::of(&tree, parameter)?;
            held.push(own);
            start.push(value);
        }
        let mut images = Self { tree, loader, options, held, sets: Vec::new(), plates: Vec::new(), start: start.clone() };
        let mut data = Measured { values: Vec::new(), sigma: Vec::new() };
        for observation in observations {
            let scene = images.scene(&observation.with, &start)?;
            let file = observed(&observation.file, images.options.memory_limit)?;
            let mut kernels = Kernels::default();
            let model = header(&scene, &mut kernels, control)?;
            agree(&observation.file, &file, &model, &scene)?;
            let mut good = Vec::new();
            for (number, band) in scene.bands.iter().enumerate() {
                let plane = file.plane(band.name(), scene.bands.len()).ok_or_else(|| {
                    let known: Vec<&str> = file.planes.iter().map(|plane| plane.name.as_str()).collect();
                    Error::file(&observation.file, format!("has no image of passband {}; it has {}", band.name(), known.join(", ")))
                })?;
                let (sigma, mask) = (file.errors_of(&plane.name), file.mask_of(&plane.name));
                if sigma.is_none() && scene.instrument.is_none() {
                    let wanted = format!(
                        "has no standard errors of {0}: an HDU {0}{ERROR_SUFFIX} or ERR, or [instrument] in the scene, whose noise is known",
                        plane.name
                    );
                    return Err(Error::file(&observation.file, wanted));
                }
                let counts = |pixel: &usize| {
                    let unmasked = mask.is_none_or(|mask| mask.values[*pixel] == 0.0);
                    let certain = sigma.is_none_or(|sigma| sigma.values[*pixel] > 0.0 && sigma.values[*pixel].is_finite());
                    unmasked && certain && plane.values[*pixel].is_finite() && model.sees(number, *pixel)
                };
                let own: Vec<usize> = (0..plane.values.len()).filter(counts).collect();
                data.values.extend(own.iter().map(|pixel| plane.values[*pixel]));
                data.sigma.extend(own.iter().map(|pixel| sigma.map_or(1.0, |sigma| sigma.values[*pixel])));
                good.push(own);
            }
            if good.iter().all(Vec::is_empty) {
                return Err(Error::file(&observation.file, "has no pixel that counts: all are masked, or no numbers"));
            }
            let name = observation.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            images.sets.push(Set {
                name,
                with: observation.with.clone(),
                good,
                choices: None,
                plan: None,
                kernels,
                reach: Reach::default(),
                scene: Some(scene),
            });
        }
        Ok((images, data, start))
    }

    /// The unit of each parameter, as the scene writes it.
    pub fn units(&self) -> Vec<&str> {
        self.held.iter().map(Held::unit).collect()
    }

    /// The tree of the scene with some values of the parameters.
    ///
    /// # Errors
    /// Where one cannot be set.
    pub fn tree(&self, values: &[f64]) -> Result<Table> {
        let mut tree = self.tree.clone();
        self.held.iter().zip(values).try_for_each(|(held, value)| held.set(&mut tree, *value))?;
        Ok(tree)
    }

    /// The scene of an image with some values of the parameters.
    fn scene(&self, with: &Table, values: &[f64]) -> Result<Scene> {
        let mut tree = self.tree(values)?;
        with.iter().for_each(|(key, property)| tree.insert(key, property.clone()));
        let mut scene = Scene::from_properties(&tree, "fit", &self.loader)?;
        scene.output.layers = LayerChoice::default();
        Ok(scene)
    }

    /// The picture of an image's scene.
    fn pictured(&mut self, number: usize, scene: &Scene, with_floor: bool, control: &Control) -> Result<Pictured> {
        let spatial = |set: &Set| set.choices.and_then(|choices| choices.spatial).map_or(0.0, |spatial| spatial.error);
        if scene.method.bounces > 1 {
            let set = &mut self.sets[number];
            let plan = match &set.choices {
                Some(choices) => Plan::holding(set.plan.as_ref(), scene, &self.options, choices, control)?,
                None => Plan::new(scene, &self.options, control)?,
            };
            set.choices.get_or_insert_with(|| Choices::of(&plan));
            let (image, stats) = cpu::render(scene, &plan, control)?;
            let worst = |band: usize| plan.certificates(band, &stats).into_iter().map(|(_, c)| c.relative).fold(0.0, f64::max);
            let relative: Vec<f64> = (0..scene.bands.len()).map(|band| worst(band) + spatial(set)).collect();
            let worse = with_floor.then(|| with_errors(&image, &relative, &[]));
            set.plan = Some(plan);
            return Ok(Pictured { image, worse });
        }
        // The latest are the last.
        let known = (0..self.plates.len()).rev().find_map(|i| self.plates[i].mixture(scene).ok().map(|mixture| (i, mixture)));
        let (plates, mixture) = match known {
            Some((i, mixture)) => (self.plates.remove(i), mixture),
            None => {
                let set = &mut self.sets[number];
                let dust = |of: &Scene| of.dust.as_ref().map(|dust| dust.sigma_v_per_pc);
                if set.scene.as_ref().is_some_and(|last| dust(last) != dust(scene)) && !binds_dust(scene) {
                    set.reach.dust = DUST;
                }
                let (plates, plan) = Plates::held(scene, set.reach, set.plan.as_ref(), set.choices.as_ref(), &self.options, control)?;
                set.choices.get_or_insert_with(|| Choices::of(&plan));
                set.plan = Some(plan);
                let mixture = plates.mixture(scene)?;
                (plates, mixture)
            }
        };
        let image = plates.pictured(scene, &mixture, control)?;
        let worse = with_floor.then(|| {
            let relative = vec![spatial(&self.sets[number]); scene.bands.len()];
            with_errors(&image, &relative, &plates.errors(&mixture))
        });
        self.plates.push(plates);
        let room = self.options.memory_limit / SHARE;
        while self.plates.len() > KEPT || (self.plates.len() > 1 && self.plates.iter().map(Plates::bytes).sum::<u64>() > room) {
            self.plates.remove(0);
        }
        Ok(Pictured { image, worse })
    }

    /// What the model says of all data, and by how much that may be wrong at most.
    fn predicted(&mut self, values: &[f64], with_floor: bool, control: &Control) -> Result<(Prediction, Vec<f64>)> {
        let (mut mean, mut sigma, mut floor) = (Vec::new(), Vec::new(), Vec::new());
        let mut knows = true;
        for number in 0..self.sets.len() {
            let scene = self.scene(&self.sets[number].with, values)?;
            let pictured = self.pictured(number, &scene, with_floor, control)?;
            let kernels = &mut self.sets[number].kernels;
            let ideal = recorded(&scene, pictured.image, kernels, control)?;
            let worse = pictured.worse.map(|worse| recorded(&scene, worse, kernels, control)).transpose()?;
            knows &= scene.instrument.is_some();
            self.sets[number].scene = Some(scene);
            for (band, good) in self.sets[number].good.iter().enumerate() {
                let own: Vec<f64> = ideal.in_unit(band).collect();
                mean.extend(good.iter().map(|pixel| own[*pixel]));
                if let Some(errors) = ideal.errors_of(band) {
                    let errors: Vec<f64> = ideal.in_unit(errors).collect();
                    sigma.extend(good.iter().map(|pixel| errors[*pixel]));
                }
                if let Some(worse) = &worse {
                    let worse: Vec<f64> = worse.in_unit(band).collect();
                    floor.extend(good.iter().map(|pixel| (worse[*pixel] - own[*pixel]).abs()));
                }
            }
        }
        let sigma = Some(sigma).filter(|_| knows);
        Ok((Prediction { mean, sigma }, floor))
    }

    /// What is left of each image at values that were found.
    ///
    /// # Errors
    /// Those of the model.
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
                let mut own = Vec::new();
                for pixel in good {
                    let left = data.values[at] - prediction.mean[at];
                    samples[band * pixels + pixel] = left as f32;
                    samples[(set.good.len() + band) * pixels + pixel] = sigma[at] as f32;
                    own.push(left / sigma[at]);
                    at += 1;
                }
                normalised.push((scene.bands[band].name().to_owned(), own));
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
}

/// A picture with errors added: parts of each band, and those of its pixels where they are known.
fn with_errors(image: &Image, relative: &[f64], of_pixels: &[f32]) -> Image {
    let light = (0..relative.len()).flat_map(|band| image.band(band).map(move |value| value * (1.0 + relative[band])));
    let errors = of_pixels.iter().map(|error| f64::from(*error)).chain(std::iter::repeat(0.0));
    Image { samples: Samples::Double(light.zip(errors).map(|(light, error)| light + error).collect()), ..image.clone() }
}

/// What a scene's instrument makes of its picture in endless frames; the picture where it has none.
fn recorded(scene: &Scene, image: Image, kernels: &mut Kernels, control: &Control) -> Result<Image> {
    match &scene.instrument {
        Some(instrument) => Ok(Exposures::by(kernels, instrument.clone(), &image, &scene.bands, control)?.ideal()),
        None => Ok(image),
    }
}

/// The picture of a scene without its light: what its pixels are.
struct Header {
    image: Image,
    exposures: Option<Exposures>,
}

impl Header {
    /// Whether a pixel is one of a band, and not one between those of a mosaic.
    fn sees(&self, band: usize, pixel: usize) -> bool {
        self.exposures.as_ref().is_none_or(|exposures| exposures.sees(band, pixel))
    }
}

fn header(scene: &Scene, kernels: &mut Kernels, control: &Control) -> Result<Header> {
    let count = scene.bands.len() * scene.camera.width * scene.camera.height;
    let dark = barnard::backend::describe(scene, &scene.camera, Samples::Single(vec![0.0; count]));
    match &scene.instrument {
        Some(instrument) => {
            let exposures = Exposures::by(kernels, instrument.clone(), &dark, &scene.bands, control)?;
            Ok(Header { image: exposures.ideal(), exposures: Some(exposures) })
        }
        None => Ok(Header { image: dark, exposures: None }),
    }
}

/// Refuses data whose pixels or units are others than those of the model.
fn agree(path: &Path, file: &Observed, model: &Header, scene: &Scene) -> Result<()> {
    let image = &model.image;
    if [file.width, file.height] != [image.width, image.height] {
        let reason = format!(
            "has {} x {} pixels, and the scene's picture {} x {}; give the scene the camera{} of the image",
            file.width,
            file.height,
            image.width,
            image.height,
            if scene.instrument.is_some() { " and pixel_scale" } else { "" }
        );
        return Err(Error::file(path, reason));
    }
    let unit = scene.observation.map(|observation| observation.unit).unwrap_or_default();
    if unit.magnitude_system().is_some() {
        return Err(Error::value(
            "unit of data to be fitted",
            unit.fits(),
            "a linear one, such as MJy/sr: magnitudes have no errors that are normal",
        ));
    }
    for plane in file.planes.iter().filter(|plane| scene.bands.iter().any(|band| band.name() == plane.name)) {
        if let Some(own) = plane.unit.as_deref().filter(|own| *own != unit.fits()) {
            let reason = format!("is in {own}, and the scene's pictures in {}; write unit in [observation]", unit.fits());
            return Err(Error::file(path, reason));
        }
    }
    let (Some(own), Some(theirs)) = (sky_of(image)?, file.planes.iter().find_map(|plane| plane.sky.as_ref())) else { return Ok(()) };
    if let Some(reason) = own.differs(theirs) {
        return Err(Error::file(
            path,
            format!("{reason}; give [observation] its frame, or project the image on a plane first (reproject)"),
        ));
    }
    let (width, height) = (image.width as f64, image.height as f64);
    for (x, y) in [(0.5, 0.5), (width - 0.5, 0.5), (0.5, height - 0.5), (width - 0.5, height - 0.5)] {
        let apart = own.pixels_apart(theirs, x, y);
        if apart.is_nan() || apart > APART {
            let reason = format!(
                "lies elsewhere on the sky: pixel ({x}, {y}) is {apart:.2} pixels away from where the scene has it; give [observation] the target and position_angle of the image, and the camera or instrument its pixel scale"
            );
            return Err(Error::file(path, reason));
        }
    }
    Ok(())
}

/// An image whose scene is the common one.
impl From<&Path> for Observation {
    fn from(file: &Path) -> Self {
        Self { file: file.to_owned(), with: Table::default() }
    }
}
