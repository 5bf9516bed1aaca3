//! Images: linear band radiance with everything a reader needs to use it.

pub mod convolution;
mod coordinates;
mod display;
pub(crate) mod glare;
mod layer;
mod levels;
pub mod optics;
mod output;
mod report;
mod samples;
mod spectral_axis;
mod stepping;

pub(crate) use coordinates::solid_angle;
pub use coordinates::{SkyCoordinates, Turned};
pub use display::{Display, Level, Tone};
pub use glare::Glare;
pub use layer::{FAR_AWAY, Layer, LayerContent};
pub use output::{ColourSpace, Compression, LayerChannels, LayerChoice, Output, SaveOptions};
pub use report::{BandCertificates, DetailReport, PathReport, Report, ScatteringError, SpatialError, SpatialNumbers, UnresolvedStars};
pub use samples::Samples;
pub use spectral_axis::SpectralAxis;
pub use stepping::{Stepping, SteppingNumbers};

use crate::error::{Error, Result};
use crate::keywords::Keyword;
use crate::observation::{InUnit, Observation};

/// Content of a band of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Plane {
    /// Radiances.
    #[default]
    Radiance,
    /// Standard errors of the radiances of the same name.
    StandardError,
}

/// One band of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// The name of the passband.
    pub name: String,
    /// Radiances of the passband or their standard errors.
    pub plane: Plane,
    /// Pivot wavelength \[µm\], where known.
    pub pivot_um: Option<f64>,
    /// "energy" or "photon", where known.
    pub counting: Option<&'static str>,
    /// ∫ R dλ \[µm\], to turn band radiance into mean spectral radiance.
    pub width_um: Option<f64>,
    /// How its radiances become the unit of the [observation](Image::observation), where there is one.
    pub in_unit: Option<InUnit>,
    /// Keywords of the passband.
    pub keywords: Vec<Keyword>,
}

/// Suffix of the [label](Band::label) of standard errors.
pub const ERROR_SUFFIX: &str = "_error";

/// The size of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PixelScale {
    /// Angle at the middle of the image \[deg\].
    Angle(f64),
    /// Length \[pc\], under an orthographic camera.
    Length(f64),
    /// Angle on a dome, the same along each line through the middle \[deg\].
    Equidistant(f64),
    /// Angle of longitude and of latitude \[deg\].
    PlateCarree(f64),
    /// Angle in the middle of each face of a cube \[deg\].
    OnCube(f64),
}

impl Band {
    /// A band of which only the name is known.
    pub fn bare(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            plane: Plane::Radiance,
            pivot_um: None,
            counting: None,
            width_um: None,
            in_unit: None,
            keywords: Vec::new(),
        }
    }

    /// The band of the standard errors of this one.
    pub fn of_errors(&self) -> Self {
        Self { plane: Plane::StandardError, ..self.clone() }
    }

    /// The name in files and lists: that of the passband, with [`ERROR_SUFFIX`] for standard errors.
    pub fn label(&self) -> String {
        match self.plane {
            Plane::Radiance => self.name.clone(),
            Plane::StandardError => format!("{}{ERROR_SUFFIX}", self.name),
        }
    }
}

impl PixelScale {
    /// Its number and its unit, "deg" or "pc".
    pub fn in_unit(self) -> (f64, &'static str) {
        match self {
            Self::Angle(degrees) | Self::Equidistant(degrees) | Self::PlateCarree(degrees) | Self::OnCube(degrees) => (degrees, "deg"),
            Self::Length(pc) => (pc, "pc"),
        }
    }
}

/// The place of a part in an image \[pixels\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImagePart {
    /// The first column of the part.
    pub column: usize,
    /// Its first row, the uppermost of the image being row 0.
    pub row: usize,
    /// Width and height of the whole image.
    pub whole: (usize, usize),
}

/// Matrices of a flat picture, each by rows: a place (x, y, z, 1) of the scene \[pc\] stands before them as a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// To the right, upwards and ahead of the camera \[pc\].
    pub world_to_camera: [[f64; 4]; 4],
    /// To the whole picture, (0, 0) its upper left corner and (1, 1) its lower right one, after division by the fourth number.
    pub world_to_screen: [[f64; 4]; 4],
}

/// A star that is drawn as a point: its light is spread over the pixels around its place, and is in the samples already.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSource {
    /// Position from the left edge of the image \[pixels\].
    pub column: f64,
    /// Position from the upper edge \[pixels\].
    pub row: f64,
    /// Its light in each passband \[W m⁻²\]; under an orthographic camera for each square parsec of a sphere around it [W m⁻² pc²].
    pub flux: Vec<f64>,
}

/// A frame of a sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Its number.
    pub frame: i64,
    /// Its time \[s\].
    pub time_s: f64,
    /// Frames a second.
    pub per_second: f64,
}

/// A rendered image.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// The number of pixels along a row.
    pub width: usize,
    /// Rows, the first on top.
    pub height: usize,
    /// The bands, in the order of the samples.
    pub bands: Vec<Band>,
    /// The spectral axis of the first of them, where they are channels of a cube.
    pub spectral: Option<SpectralAxis>,
    /// The radiances, bands × height × width.
    pub samples: Samples,
    /// Views of their own side by side and above each other: two eyes, or the faces of a cube.
    pub views: (usize, usize),
    /// Size of a pixel, where known.
    pub pixel: Option<PixelScale>,
    /// Position of the optical axis in the image, from its middle to the right and upwards \[pixels\].
    pub axis: (f64, f64),
    /// The place of the image in a larger one of which it is a part.
    pub part: Option<ImagePart>,
    /// Radius around the axis of view beyond which the image of a dome shows nothing \[pixels\].
    pub circle: Option<f64>,
    /// Camera geometry of a flat picture.
    pub view: Option<View>,
    /// The stars that are points in it, of flat pictures of one eye.
    pub points: Vec<PointSource>,
    /// The frame of a sequence that it is.
    pub moment: Option<Moment>,
    /// Pointing on the sky, if stated.
    pub observation: Option<Observation>,
    /// How it was made and its stated errors.
    pub report: Report,
    /// Statements about the scene and the picture, each with its topic.
    pub notes: Vec<(String, String)>,
    /// Keywords of the scene and the picture.
    pub keywords: Vec<Keyword>,
    /// Origin of its light, if requested.
    pub layers: Vec<Layer>,
}

impl Image {
    /// An image of which only the [labels](Band::label) of its bands and the values are known.
    pub fn bare(width: usize, height: usize, labels: Vec<String>, samples: Samples) -> Self {
        let mut bands: Vec<Band> = labels.into_iter().map(Band::bare).collect();
        for i in 0..bands.len() {
            let name = bands[i].name.strip_suffix(ERROR_SUFFIX).map(str::to_owned);
            if let Some(name) = name.filter(|name| bands.iter().any(|other| other.name == *name)) {
                bands[i] = Band::bare(name).of_errors();
            }
        }
        let (notes, keywords, layers) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            width,
            height,
            bands,
            spectral: None,
            samples,
            views: (1, 1),
            pixel: None,
            axis: (0.0, 0.0),
            part: None,
            circle: None,
            view: None,
            points: Vec::new(),
            moment: None,
            observation: None,
            report: Report::default(),
            notes,
            keywords,
            layers,
        }
    }

    /// Copy of the image without samples, layers and points.
    pub(crate) fn header(&self) -> Self {
        Self {
            samples: Samples::Single(Vec::new()),
            layers: Vec::new(),
            points: Vec::new(),
            bands: self.bands.clone(),
            report: self.report.clone(),
            notes: self.notes.clone(),
            keywords: self.keywords.clone(),
            ..*self
        }
    }

    /// Radiance of a pixel in a band [W m⁻² sr⁻¹].
    pub fn at(&self, band: usize, row: usize, column: usize) -> f64 {
        self.samples.at((band * self.height + row) * self.width + column)
    }

    /// Refuses values that are no numbers: sums that went past the range of f32.
    ///
    /// # Errors
    /// If there are some, with their number and band.
    pub fn check(&self) -> Result<()> {
        for (b, band) in self.bands.iter().enumerate() {
            let count = self.band(b).filter(|v| !v.is_finite()).count();
            if count > 0 {
                let reason = format!(
                    "{count} pixels of band {} are NaN or infinite: densities or spectra are too large for single precision",
                    band.name
                );
                return Err(Error::Strength(reason));
            }
        }
        Ok(())
    }

    /// Relative rms difference of a band from one of `truth`, √Σ(a − b)² / √Σb²; zero where they are equal.
    pub fn relative_rmse(&self, band: usize, truth: &Self, truth_band: usize) -> f64 {
        relative_rms(self.band(band).zip(truth.band(truth_band)))
    }

    /// The band of the standard errors of a band of radiances, where there is one.
    pub fn errors_of(&self, radiances: usize) -> Option<usize> {
        let is_error = |band: &Band| band.plane == Plane::StandardError && band.name == self.bands[radiances].name;
        self.bands.iter().position(is_error).filter(|_| !self.is_error(radiances))
    }

    /// True if a band holds standard errors.
    pub fn is_error(&self, band: usize) -> bool {
        self.bands[band].plane == Plane::StandardError
    }

    /// The bands that are radiances, without those of standard errors.
    pub fn radiances(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.bands.len()).filter(|band| !self.is_error(*band))
    }

    /// All statements about the image in words, each with its topic: those about the scene, then those of the [report](Self::report).
    pub fn statements(&self) -> Vec<(String, String)> {
        self.notes.iter().cloned().chain(self.report.words()).collect()
    }

    /// All keywords of the image: those of the scene, then those of the [report](Self::report).
    pub fn cards(&self) -> Vec<Keyword> {
        self.keywords.iter().cloned().chain(self.report.cards()).collect()
    }

    /// Keywords of a band: of its passband, and its spectral errors.
    pub fn band_cards(&self, band: usize) -> Vec<Keyword> {
        let Band { name, plane, keywords, .. } = &self.bands[band];
        let errors = if *plane == Plane::Radiance { self.report.band_cards(name) } else { Vec::new() };
        keywords.iter().cloned().chain(errors).collect()
    }

    /// Statements about the spectral errors of a band, a sentence for each light.
    pub fn band_words(&self, band: usize) -> Vec<String> {
        let Band { name, plane, .. } = &self.bands[band];
        if *plane == Plane::Radiance { self.report.band_words(name) } else { Vec::new() }
    }

    /// Position of the optical axis in the image, as FITS counts: the middle of the lower left pixel is (1, 1).
    pub fn reference_pixel(&self) -> [f64; 2] {
        [0.5 * (self.width as f64 + 1.0) + self.axis.0, 0.5 * (self.height as f64 + 1.0) + self.axis.1]
    }

    /// The values of one band, row by row.
    pub fn band(&self, band: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        let size = self.width * self.height;
        (band * size..(band + 1) * size).map(|i| self.samples.at(i))
    }

    /// The values of a band in the unit that was asked for; standard errors beside the radiances that they are of.
    pub fn in_unit(&self, band: usize) -> Box<dyn Iterator<Item = f64> + '_> {
        let values = self.band(band);
        let radiance_band = (0..self.bands.len()).find(|index| self.errors_of(*index) == Some(band));
        match (self.bands[radiance_band.unwrap_or(band)].in_unit, radiance_band) {
            (Some(unit), Some(radiance_band)) => {
                Box::new(values.zip(self.band(radiance_band)).map(move |(error, radiance)| unit.error(error, radiance)))
            }
            (Some(unit), None) => Box::new(values.map(move |radiance| unit.value(radiance))),
            (None, _) => Box::new(values),
        }
    }
}

/// Relative rms difference of pairs (a, b), √Σ(a − b)² / √Σb²; zero where they are equal, NaN where one is no number.
pub fn relative_rms(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (squares, size) = pairs.fold((0.0, 0.0), |(squares, size), (a, b)| (squares + (a - b).powi(2), size + b * b));
    if squares == 0.0 { 0.0 } else { (squares / size).sqrt() }
}

/// The largest of some errors; NaN where one is NaN.
pub fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |worst, error| if error <= worst || worst.is_nan() { worst } else { error })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard errors are those of a band that is there; a filter of one's own may be called like them.
    #[test]
    fn errors_have_a_band() {
        let image =
            |names: &[&str]| Image::bare(1, 1, names.iter().map(|n| (*n).to_owned()).collect(), Samples::Double(vec![0.0; names.len()]));
        let radiances = |names: &[&str]| image(names).radiances().collect::<Vec<_>>();
        assert_eq!(radiances(&["V", "V_error", "tracking_error"]), [0, 2]);
        assert_eq!(radiances(&["V_error"]), [0]);
        assert_eq!(image(&["B", "V", "B_error", "V_error"]).errors_of(1), Some(3));
        assert_eq!(image(&["B", "V_error"]).errors_of(0), None);
    }
}
