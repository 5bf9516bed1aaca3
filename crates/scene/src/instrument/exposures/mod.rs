//! Exposures: what falls on a detector, and the frames that are read of it.

use std::sync::Arc;

use rayon::prelude::*;
use spectra::passband::Passband;

use super::cosmic_rays::{charge, tracks};
use super::layout::{DetectorLayout, Pixels};
use super::points::Points;
use super::{Instrument, Kernels};
use crate::camera::Camera;
use crate::control::{Control, Stage};
use crate::error::Result;
use crate::image::{Image, PixelScale, Samples};
use crate::keywords::{self, Keyword};
use crate::observation::{InUnit, Observation, RadianceUnit};
use crate::random::Counter;

/// Instrument response to a picture, for all of its frames.
#[derive(Debug, Clone)]
pub struct Exposures {
    pub(super) instrument: Arc<Instrument>,
    /// Metadata of all pictures of the detector; it has no samples.
    pub(super) header: Image,
    pub(super) pixels: Pixels,
    pub(super) bands: Vec<BandLight>,
    /// The bands of a square of two by two pixels, where the detector is a mosaic.
    pub(super) mosaic: Option<[usize; 4]>,
}

/// Light on the detector in a band.
#[derive(Debug, Clone)]
pub(super) struct BandLight {
    /// The electrons of a band irradiance of 1 W m⁻² [e s⁻¹ W⁻¹ m²].
    pub per_watt: f64,
    /// The radiance of the sky [W m⁻² sr⁻¹].
    pub sky: f64,
    /// The electrons of the picture by pixel [e s⁻¹].
    pub source: Vec<f64>,
}

/// The counts of a frame.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The number of the frame, from 0.
    pub number: usize,
    /// When it begins, after the first \[s\]: frames follow each other without a pause.
    pub begun_s: f64,
    /// Target: the bands, or one mosaic of all of them.
    pub planes: Vec<String>,
    /// The counts of each plane, row by row, the first on top \[ADU\].
    pub counts: Vec<Vec<u16>>,
    /// Keywords of the frame.
    pub keywords: Vec<Keyword>,
    /// The picture that it is of, without samples: its size, bands and place on the sky.
    pub header: Image,
}

impl Exposures {
    /// Refuses pictures of a camera through passbands that an instrument cannot see, before they are rendered.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
    pub fn check(instrument: &Instrument, camera: &Camera, observation: Option<Observation>, bands: &[Passband]) -> Result<()> {
        let names = bands.iter().map(|band| band.name().to_owned()).collect();
        let bare = Image::bare(camera.width, camera.height, names, Samples::Single(Vec::new()));
        let views = if camera.stereo.is_some() { (2, 1) } else { (1, 1) };
        DetectorLayout::new(
            instrument,
            &Image { pixel: Some(camera.pixel_scale()), axis: camera.axis(), observation, views, ..bare },
            bands,
        )
        .map(|_| ())
    }

    /// Instrument response to a picture through passbands, in the order of its bands.
    ///
    /// # Errors
    /// If the picture is not flat or has coarser pixels than the detector, the sky or the mosaic do not fit its bands, or the user wishes
    /// to stop.
    pub fn new(instrument: Arc<Instrument>, image: &Image, bands: &[Passband], control: &Control) -> Result<Self> {
        Self::by(&mut Kernels::default(), instrument, image, bands, control)
    }

    /// Variant by kernels of pictures before, where they are those of this one.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
    pub fn by(kernels: &mut Kernels, instrument: Arc<Instrument>, image: &Image, bands: &[Passband], control: &Control) -> Result<Self> {
        let DetectorLayout { below, pixels, squares, mosaic } = DetectorLayout::new(&instrument, image, bands)?;
        let radiances: Vec<usize> = image.radiances().collect();
        let mut light = Vec::with_capacity(bands.len());
        let points = Points::of(image, &below, squares.edge);
        for (number, (band, radiances)) in bands.iter().zip(&radiances).enumerate() {
            control.report(Stage::Frames, number as u64, bands.len() as u64);
            control.check()?;
            let per_watt = instrument.electrons(band.pivot().0);
            let mut rates: Vec<f64> =
                image.band(*radiances).enumerate().map(|(i, radiance)| radiance.max(0.0) * below.solid_angle(i) * per_watt).collect();
            let mut spread = |light: &mut [f64], finer: usize| {
                let size = below.size.map(|pixels| pixels * finer);
                instrument.psf.iter().try_for_each(|psf| {
                    control.check()?;
                    kernels.apply(&**psf, &instrument, &image.bands[*radiances], below.edge_rad / finer as f64, size, light)
                })
            };
            // Points are sharper than the discs by which they are drawn.
            if let Some(points) = &points {
                points.take_discs(number, per_watt, &mut rates);
            }
            spread(&mut rates, 1)?;
            if let Some(points) = &points {
                let mut sharp = points.light(number, per_watt);
                spread(&mut sharp, points.finer)?;
                points.gather(&sharp, &mut rates);
            }
            // Transforms leave a little below zero where there is no light, and points between fine pixels do in those beside them.
            let mut source = squares.gathered(&rates, below.size);
            source.par_iter_mut().for_each(|rate| *rate = rate.max(0.0));
            let sky = instrument.sky.radiance(band, number, bands.len())?;
            light.push(BandLight { per_watt, sky, source });
        }
        kernels.keep(bands.len() * instrument.psf.len() * if points.is_some() { 2 } else { 1 });
        let header = header(&instrument, image, &radiances, &pixels, &light);
        Ok(Self { instrument, header, pixels, bands: light, mosaic })
    }

    /// The instrument.
    pub fn instrument(&self) -> &Instrument {
        &self.instrument
    }

    /// Copy of the light, recorded in other exposures, frames or by another detector; an instrument of the same optics and sky.
    #[must_use]
    pub fn recorded_by(&self, instrument: Arc<Instrument>) -> Self {
        Self { instrument, ..self.clone() }
    }

    /// Pixels along a row and a column of the detector.
    pub fn size(&self) -> [usize; 2] {
        self.pixels.size
    }

    /// The electrons that a pixel gathers of the picture in a band, without sky and dark [e s⁻¹].
    pub fn source(&self, band: usize, pixel: usize) -> f64 {
        self.bands[band].source[pixel]
    }

    /// The electrons that a pixel gathers of the sky in a band [e s⁻¹].
    pub fn sky(&self, band: usize, pixel: usize) -> f64 {
        self.bands[band].sky * self.bands[band].per_watt * self.pixels.solid_angle(pixel)
    }

    /// The electrons that a pixel gathers in a frame on the average, without hits \[e\].
    pub fn mean(&self, band: usize, pixel: usize) -> f64 {
        let rate = self.source(band, pixel) + self.sky(band, pixel) + self.instrument.detector.dark_current;
        rate * self.instrument.exposure_s
    }

    /// The band that a pixel of a plane sees.
    pub(super) fn band_of(&self, plane: usize, pixel: usize) -> usize {
        let Some(square) = self.mosaic else { return plane };
        let (column, row) = (pixel % self.pixels.size[0], pixel / self.pixels.size[0]);
        square[2 * (row % 2) + column % 2]
    }

    /// Target of each exposure: the bands, or one mosaic.
    pub(super) fn planes(&self) -> Vec<String> {
        match self.mosaic {
            Some(_) => vec!["mosaic".into()],
            None => self.header.bands[..self.bands.len()].iter().map(|band| band.name.clone()).collect(),
        }
    }

    /// The charge of cosmic rays on a plane of a frame, by pixel.
    pub(super) fn hits(&self, plane: usize, frame: usize) -> Vec<(usize, f64)> {
        let instrument = &self.instrument;
        let mut random = Counter::nested(instrument.seed ^ HITS, frame as u64, plane as u64);
        tracks(&instrument.detector, self.pixels.size, instrument.exposure_s, &mut random)
    }

    /// The count of a pixel in a frame, with the charge that hits brought.
    pub(super) fn count(&self, plane: usize, frame: usize, pixel: usize, hits: f64) -> u16 {
        let cell = (frame * self.bands.len() + plane) as u64;
        let mut random = Counter::nested(self.instrument.seed, cell, pixel as u64);
        self.instrument.detector.read(self.mean(self.band_of(plane, pixel), pixel), hits, &mut random)
    }

    /// The counts of a frame, from 0 to below the instrument's number of frames; the same whenever it is asked for.
    pub fn frame(&self, number: usize) -> Frame {
        let planes = self.planes();
        let counts = (0..planes.len()).map(|plane| {
            let hits = self.hits(plane, number);
            (0..self.pixels.count()).into_par_iter().map(|pixel| self.count(plane, number, pixel, charge(&hits, pixel))).collect()
        });
        let counts = counts.collect();
        let mut keywords = self.keywords(1);
        let detector = &self.instrument.detector;
        let numbers = [
            ("GAIN", detector.gain, "[e/adu]"),
            ("EGAIN", detector.gain, "[e/adu]"),
            ("FOCALLEN", 1e-3 * detector.pixel_um / self.pixels.edge_rad, "[mm] from pixel size and pixel angle"),
            ("RDNOISE", detector.read_noise, "[e] read noise"),
            ("DARKCUR", detector.dark_current, "[e/s] of a pixel"),
            ("BIASLVL", detector.bias, "[adu] counts of an empty pixel"),
            ("SATURATE", f64::from(detector.saturation()), "[adu] counts of a full pixel"),
        ];
        keywords.extend(numbers.into_iter().filter_map(|(name, value, comment)| keywords::number(name, value, comment)));
        keywords.push(keywords::text("IMAGETYP", "Light Frame", ""));
        keywords.push(keywords::text("TELESCOP", self.instrument.name.clone(), ""));
        keywords.push(keywords::integer("FRAME", number + 1, "number of the frame"));
        if let Some(pattern) = self.pattern() {
            keywords.push(keywords::text("BAYERPAT", pattern, "colours of 2 x 2 pixels, upper left first"));
            keywords.push(keywords::text("ROWORDER", "BOTTOM-UP", "pattern starts at the top of the displayed image"));
        }
        Frame { number, begun_s: number as f64 * self.instrument.exposure_s, planes, counts, keywords, header: self.header.clone() }
    }

    /// The mosaic as programs for amateurs name it, where it is one that they know: two pixels across a corner of one band, green, and of
    /// the others that of longer waves is red.
    fn pattern(&self) -> Option<&'static str> {
        let square = self.mosaic?;
        let pivot = |pixel: usize| self.header.bands[square[pixel]].pivot_um.unwrap_or(0.55);
        let red = |a: usize, b: usize| pivot(a) > pivot(b);
        match square {
            [a, b, c, d] if b == c && a != d => Some(if red(0, 3) { "RGGB" } else { "BGGR" }),
            [a, b, c, d] if a == d && b != c => Some(if red(1, 2) { "GRBG" } else { "GBRG" }),
            _ => None,
        }
    }

    /// Metadata of combined frames.
    pub(super) fn keywords(&self, frames: usize) -> Vec<Keyword> {
        let (instrument, detector) = (&self.instrument, &self.instrument.detector);
        let arcsec = self.pixels.edge_rad.to_degrees() * 3600.0;
        let numbers = [
            ("EXPTIME", instrument.exposure_s * frames as f64, "[s] of all frames together"),
            ("APTDIA", instrument.aperture_m * 1e3, "[mm] diameter of the aperture"),
            ("APTAREA", instrument.area_m2() * 1e6, "[mm2] collecting area"),
            ("PIXSCALE", arcsec, "[arcsec] angle of a pixel"),
            ("XPIXSZ", detector.pixel_um, "[um] edge of a pixel"),
            ("YPIXSZ", detector.pixel_um, "[um] edge of a pixel"),
        ];
        let mut all = vec![keywords::text("INSTRUME", instrument.name.clone(), "")];
        all.extend(numbers.into_iter().filter_map(|(name, value, comment)| keywords::number(name, value, comment)));
        all.push(keywords::integer("NCOMBINE", frames, "number of frames"));
        all.push(keywords::integer("SEED", instrument.seed as usize, "of all noise"));
        all
    }
}

/// Keeps hits apart from the noise of pixels.
const HITS: u64 = 0x636f_736d_6963;

/// Metadata of the detector's pictures.
fn header(instrument: &Instrument, image: &Image, radiances: &[usize], pixels: &Pixels, light: &[BandLight]) -> Image {
    let pixel = match image.observation.and_then(|observation| observation.distance_pc).filter(|_| pixels.is_parallel) {
        Some(distance_pc) => PixelScale::Length(pixels.edge_rad * distance_pc),
        None => PixelScale::Angle(pixels.edge_rad.to_degrees()),
    };
    let in_electrons = image.observation.is_some_and(|observation| observation.unit == RadianceUnit::Electrons);
    let mut bands: Vec<_> = radiances.iter().map(|band| image.bands[*band].clone()).collect();
    for (band, light) in bands.iter_mut().zip(light) {
        if in_electrons {
            band.in_unit = Some(InUnit::Times(light.per_watt * pixels.edge_rad.powi(2)));
        }
    }
    let mut notes = image.notes.clone();
    notes.push((
        "instrument".into(),
        format!("{}: {}", instrument.name, instrument.psf.iter().map(|psf| psf.description()).collect::<Vec<_>>().join(", ")),
    ));
    Image {
        width: pixels.size[0],
        height: pixels.size[1],
        bands,
        pixel: Some(pixel),
        axis: pixels.axis,
        notes,
        // The detector's edges are its own, and its points are spread.
        view: None,
        ..image.header()
    }
}

#[cfg(test)]
mod tests;
