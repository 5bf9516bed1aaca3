//! Images to be fitted: where they come from, and what is taken for granted of them.

use std::path::{Path, PathBuf};

use barnard::error::{Error, Result};
use barnard::image::{ERROR_SUFFIX, Image, LayerContent};
use barnard::properties::Table;
use barnard::scene::Scene;
use barnard_files::formats::{ImagePlane, MASK_PREFIX, Observed, observed, sky_of};

/// An image to be fitted.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Its pixels.
    pub data: Data,
    /// Tables and keys that stand in place of those of the scene.
    pub with: Table,
    /// Assumed metadata.
    pub assumed: Assumed,
}

/// The pixels of an image.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Data {
    /// A FITS file: an image HDU for each passband by its name, with standard errors as NAME_error or ERR, and a mask as mask.NAME, DQ or
    /// MASK where there is one. One HDU of several is chosen as in `name.fits[SCI]`, `name.fits[SCI,2]` or `name.fits[1]`.
    File(PathBuf),
    /// Pixels in memory.
    Pixels(PixelData),
}

/// Pixels in memory, the first row on top.
#[derive(Debug, Clone)]
pub struct PixelData {
    /// Names in messages.
    pub name: String,
    /// The values.
    pub values: PixelValues,
    /// Standard errors, bands × height × width in the unit of the values; those of the values where there are none.
    pub sigma: Option<Vec<f64>>,
    /// Pixels that do not count, bands × height × width.
    pub mask: Option<Vec<bool>>,
}

/// Values of pixels in memory.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum PixelValues {
    /// Planes of a picture, which know their unit and place.
    Planes(Observed),
    /// An array of all bands of a scene, bands × height × width, in the unit of its pictures and where it has them.
    Array([usize; 3], Vec<f64>),
}

impl PixelData {
    /// The planes that they are of a scene.
    fn planes(&self, scene: &Scene) -> Result<Observed> {
        let wrong = |found: String, expected: String| Error::mismatch("image to fit", expected, format!("{found} in {}", self.name));
        let plane = |name: String, values: &[f64]| ImagePlane { hdu: 0, name, version: 1, unit: None, values: values.to_vec(), sky: None };
        let mut observed = match &self.values {
            PixelValues::Planes(planes) => planes.clone(),
            PixelValues::Array([bands, height, width], values) => {
                if *bands != scene.bands.len() {
                    return Err(wrong(format!("{bands} bands"), format!("{} bands, those of the scene", scene.bands.len())));
                }
                let names = scene.bands.iter().map(|band| band.name().to_owned());
                let planes = names.zip(values.chunks_exact((height * width).max(1))).map(|(name, pixels)| plane(name, pixels)).collect();
                Observed { width: *width, height: *height, planes }
            }
        };
        let names: Vec<String> = observed.images().map(|plane| plane.name.clone()).collect();
        let count = observed.width * observed.height;
        let fits = |length: usize| length == names.len() * count;
        if !self.sigma.as_ref().is_none_or(|array| fits(array.len())) || !self.mask.as_ref().is_none_or(|array| fits(array.len())) {
            let wanted = format!("{} bands of {} x {} pixels", names.len(), observed.width, observed.height);
            return Err(wrong("standard errors or a mask of another size".into(), wanted));
        }
        let mut add = |name: String, values: Vec<f64>| {
            observed.planes.retain(|plane| plane.name != name);
            observed.planes.push(plane(name, &values));
        };
        for (band, name) in names.iter().enumerate() {
            let range = band * count..(band + 1) * count;
            if let Some(sigma) = &self.sigma {
                add(format!("{name}{ERROR_SUFFIX}"), sigma[range.clone()].to_vec());
            }
            if let Some(mask) = &self.mask {
                add(format!("{MASK_PREFIX}{name}"), mask[range].iter().map(|masked| f64::from(u8::from(*masked))).collect());
            }
        }
        Ok(observed)
    }
}

/// Optional metadata of an image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Assumed {
    /// It is in the unit of the scene's pictures.
    pub unit: bool,
    /// It lies on the sky where the scene has it.
    pub place: bool,
}

/// An image whose scene is the common one.
impl From<&Path> for Observation {
    fn from(file: &Path) -> Self {
        Self { data: Data::File(file.to_owned()), with: Table::default(), assumed: Assumed::default() }
    }
}

impl Data {
    /// Name in messages.
    pub(crate) fn path(&self) -> PathBuf {
        match self {
            Self::File(path) => path.clone(),
            Self::Pixels(pixels) => PathBuf::from(&pixels.name),
        }
    }

    /// Its planes, for a scene; each array of a file may take `memory_limit` bytes.
    pub(crate) fn read(&self, scene: &Scene, memory_limit: u64) -> Result<Observed> {
        match self {
            Self::Pixels(pixels) => pixels.planes(scene),
            Self::File(path) if path.exists() => observed(path, memory_limit),
            Self::File(path) => {
                let text = path.to_string_lossy();
                match text.strip_suffix(']').and_then(|text| text.rsplit_once('[')) {
                    Some((file, hdu)) => observed(Path::new(file), memory_limit)?.chosen(hdu).map_err(|reason| Error::file(path, reason)),
                    None => observed(path, memory_limit),
                }
            }
        }
    }
}

/// The planes of a picture in the unit of its observation, its standard errors and masks among them, as its file would have them.
///
/// # Errors
/// If it cannot be written as FITS.
pub fn planes_of(image: &Image) -> Result<Observed> {
    let (sky, unit) = (sky_of(image)?, image.observation.map(|observation| observation.unit).unwrap_or_default());
    let plane =
        |name: String, unit: Option<String>, values: Vec<f64>| ImagePlane { hdu: 0, name, version: 1, unit, values, sky: sky.clone() };
    let bands = image.bands.iter().enumerate();
    let values = bands.map(|(band, label_of)| plane(label_of.label(), Some(unit.fits().to_owned()), image.in_unit(band).collect()));
    let pixels = image.width * image.height;
    let masks = image.layers.iter().filter(|layer| layer.content == LayerContent::Mask).flat_map(|layer| {
        let channel = |(number, band): (usize, usize)| {
            plane(format!("{MASK_PREFIX}{}", image.bands[band].name), None, layer.channel(number, pixels).collect())
        };
        image.radiances().enumerate().map(channel)
    });
    Ok(Observed { width: image.width, height: image.height, planes: values.chain(masks).collect() })
}
