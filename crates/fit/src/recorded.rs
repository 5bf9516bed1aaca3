//! Recorded model and the pixel match of data.

use std::path::Path;

use barnard::control::Control;
use barnard::error::{Error, Result};
use barnard::image::{ERROR_SUFFIX, Image, Samples};
use barnard::instrument::{Exposures, Kernels};
use barnard::scene::Scene;
use barnard_files::formats::{ImagePlane, Observed, Sky, sky_of};

use crate::observation::Assumed;
use crate::solve::Measured;

/// Position tolerance between pixels of data and model, in pixels.
const APART: f64 = 0.05;

/// Expected exposure of a scene's instrument; the picture where it has none.
pub(crate) fn recorded(scene: &Scene, image: Image, kernels: &mut Kernels, control: &Control) -> Result<Image> {
    match &scene.instrument {
        Some(instrument) => Ok(Exposures::by(kernels, instrument.clone(), &image, &scene.bands, control)?.ideal()),
        None => Ok(image),
    }
}

/// The picture of a scene without its light: what its pixels are.
pub(crate) struct Header {
    pub image: Image,
    exposures: Option<Exposures>,
}

impl Header {
    /// True if a pixel is one of a band, and not one between those of a mosaic.
    pub fn sees(&self, band: usize, pixel: usize) -> bool {
        self.exposures.as_ref().is_none_or(|exposures| exposures.sees(band, pixel))
    }
}

pub(crate) fn header(scene: &Scene, kernels: &mut Kernels, control: &Control) -> Result<Header> {
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

/// Refuses data whose pixels, units or place on the sky are others than those of the model, or are not said and not `assumed`.
pub(crate) fn agree(path: &Path, file: &Observed, model: &Header, scene: &Scene, assumed: Assumed) -> Result<()> {
    let image = &model.image;
    if [file.width, file.height] != [image.width, image.height] {
        let reason = format!(
            "has {} x {} pixels, the scene's picture {} x {}; give the scene the camera{} of the image",
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
        return Err(Error::unsupported(
            format!("unit {}", unit.fits()),
            "a fit",
            "use a linear unit such as MJy/sr, because errors of magnitudes are not Gaussian",
        ));
    }
    let used = || scene.bands.iter().filter_map(|band| file.plane(band.name(), scene.bands.len()).ok());
    let named = |plane: &ImagePlane| if plane.name.is_empty() { "its image".to_owned() } else { plane.name.clone() };
    for plane in used().flat_map(|plane| [Some(plane), file.errors_of(&plane.name)]).flatten() {
        if let Some(unit_text) = plane.unit.as_deref().filter(|unit_text| !unit.is_spelled(unit_text)) {
            let name = named(plane);
            let reason = format!("{name} is in {unit_text}, the scene's pictures are in {}; set unit in [observation]", unit.fits());
            return Err(Error::file(path, reason));
        }
    }
    if let Some(plane) = used().find(|plane| plane.unit.is_none() && !assumed.unit) {
        let reason = format!(
            "{} has no unit (BUNIT); add it to the header, or assume {} with --assume unit (Python: assume=\"unit\")",
            named(plane),
            unit.fits()
        );
        return Err(Error::file(path, reason));
    }
    let Some(sky) = sky_of(image)? else { return Ok(()) };
    if let Some(plane) = used().find(|plane| plane.sky.is_none() && !assumed.place) {
        let reason = format!(
            "{} has no sky coordinates (CTYPE, CRVAL, CRPIX, CD); add them to the header, or assume those of the scene with --assume place (Python: assume=\"place\")",
            named(plane)
        );
        return Err(Error::file(path, reason));
    }
    used().filter_map(|plane| plane.sky.as_ref()).try_for_each(|theirs| lies_there(path, image, &sky, theirs))
}

/// Refuses pixels that lie elsewhere on the sky than those of the model.
fn lies_there(path: &Path, image: &Image, sky: &Sky, theirs: &Sky) -> Result<()> {
    if let Some(reason) = sky.differs(theirs) {
        return Err(Error::file(path, format!("{reason}; use its frame in [observation], or reproject the image to a tangent plane")));
    }
    let (width, height) = (image.width as f64, image.height as f64);
    for (x, y) in [(0.5, 0.5), (width - 0.5, 0.5), (0.5, height - 0.5), (width - 0.5, height - 0.5)] {
        let apart = sky.pixels_apart(theirs, x, y);
        if apart.is_nan() || apart > APART {
            let reason = format!(
                "has another sky position: pixel ({x}, {y}) is {apart:.2} pixels from that of the scene; set target and position_angle of [observation], and the pixel scale of the camera or instrument, to those of the image"
            );
            return Err(Error::file(path, reason));
        }
    }
    Ok(())
}

/// For each band of a scene the pixels that count; their values and standard errors are added to `data`.
pub(crate) fn counted(path: &Path, file: &Observed, model: &Header, scene: &Scene, data: &mut Measured) -> Result<Vec<Vec<usize>>> {
    let mut good = Vec::new();
    for (number, band) in scene.bands.iter().enumerate() {
        let plane = file.plane(band.name(), scene.bands.len()).map_err(|reason| Error::file(path, reason))?;
        let (sigma, mask) = (file.errors_of(&plane.name), file.mask_of(&plane.name));
        if sigma.is_none() && scene.instrument.is_none() {
            let wanted =
                format!("has no standard errors of {0}; add an HDU {0}{ERROR_SUFFIX} or ERR, or [instrument] to the scene", plane.name);
            return Err(Error::file(path, wanted));
        }
        let counts = |pixel: &usize| {
            let unmasked = mask.is_none_or(|mask| mask.values[*pixel] == 0.0);
            let certain = sigma.is_none_or(|sigma| sigma.values[*pixel] > 0.0 && sigma.values[*pixel].is_finite());
            unmasked && certain && plane.values[*pixel].is_finite() && model.sees(number, *pixel)
        };
        let counted: Vec<usize> = (0..plane.values.len()).filter(counts).collect();
        data.values.extend(counted.iter().map(|pixel| plane.values[*pixel]));
        data.sigma.extend(counted.iter().map(|pixel| sigma.map_or(1.0, |sigma| sigma.values[*pixel])));
        good.push(counted);
    }
    match good.iter().all(Vec::is_empty) {
        true => Err(Error::file(path, "has no valid pixel: all are masked or not finite")),
        false => Ok(good),
    }
}
