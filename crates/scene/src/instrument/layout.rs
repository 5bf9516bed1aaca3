//! Layout of a detector on a picture: pixels, solid angles, the passbands of a mosaic.

use spectra::passband::Passband;

use super::Instrument;
use super::rebinning::Squares;
use crate::error::{Error, Result};
use crate::image::{Image, PixelScale, solid_angle};

/// Pixels of a flat picture: how many in a row and a column, how wide one is in the middle \[rad\], and where the axis of view meets them,
/// from the middle to the right and upwards; under an orthographic camera all have one solid angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels {
    pub size: [usize; 2],
    pub edge_rad: f64,
    pub axis: (f64, f64),
    pub is_parallel: bool,
}

impl Pixels {
    /// Those of a picture.
    ///
    /// # Errors
    /// If it is not flat, has views of its own, or a size that is no angle.
    pub(super) fn of(image: &Image) -> Result<Self> {
        let unsupported = |feature: &str| {
            let alternative = "use a camera of kind \"perspective\", or \"orthographic\" with a distance in [observation]";
            Err(Error::unsupported(feature, "an instrument", alternative))
        };
        let (edge_rad, is_parallel) = match (image.pixel, image.observation.and_then(|observation| observation.distance_pc)) {
            (Some(PixelScale::Angle(degrees)), _) => (degrees.to_radians(), false),
            (Some(PixelScale::Length(pc)), Some(distance)) => (pc / distance, true),
            _ => return unsupported("a picture without a pixel angle in a plane"),
        };
        if image.views != (1, 1) {
            return unsupported("a picture of several views");
        }
        Ok(Self { size: [image.width, image.height], edge_rad, axis: image.axis, is_parallel })
    }

    /// Copy of the plane in pixels of another edge, as many as it holds.
    fn rebinned(&self, edge: f64) -> (Self, Squares) {
        let squares = Squares::within(self.size, edge);
        let axis = (self.axis.0 / edge, self.axis.1 / edge);
        (Self { size: squares.size, edge_rad: self.edge_rad * edge, axis, ..*self }, squares)
    }

    /// Solid angle of a pixel \[sr\].
    pub(super) fn solid_angle(&self, pixel: usize) -> f64 {
        if self.is_parallel {
            return self.edge_rad * self.edge_rad;
        }
        solid_angle(self.edge_rad, self.size, self.axis, pixel)
    }

    pub(super) fn count(&self) -> usize {
        self.size[0] * self.size[1]
    }
}

/// Largest ratio of picture pixels to detector pixels: rounding of a scale that is meant to be the same.
const SAME: f64 = 1e-6;

/// Pixels that cosmic rays may hit in all frames together.
const MOST_CHARGES: f64 = 1e8;

/// Layout of a detector on a picture.
pub(super) struct DetectorLayout {
    pub below: Pixels,
    pub pixels: Pixels,
    pub squares: Squares,
    pub mosaic: Option<[usize; 4]>,
}

impl DetectorLayout {
    pub(super) fn new(instrument: &Instrument, image: &Image, bands: &[Passband]) -> Result<Self> {
        instrument.check()?;
        instrument.check_filters(bands)?;
        for (number, band) in bands.iter().enumerate() {
            instrument.sky.radiance(band, number, bands.len())?;
        }
        let below = Pixels::of(image)?;
        let edge = instrument.pixel_rad.map_or(1.0, |pixel| pixel / below.edge_rad);
        if edge < 1.0 - SAME {
            let (pixel_rad, wanted) = (instrument.pixel_rad.unwrap_or_default(), (image.width as f64 / edge).ceil());
            let arcsec = |angle: f64| spectra::units::short((angle.to_degrees() * 3600e4).round() / 1e4);
            let problem = format!(
                "the instrument's pixels of {} arcsec are finer than the picture's of {} arcsec",
                arcsec(pixel_rad),
                arcsec(below.edge_rad)
            );
            let remedy = format!("render at least {wanted} pixels per row, narrow the field of view, or increase pixel_scale");
            return Err(Error::conflict(problem, remedy));
        }
        let (pixels, squares) = below.rebinned(edge.max(1.0));
        if pixels.count() == 0 {
            return Err(Error::conflict(
                "the instrument's pixels are wider than the picture",
                "decrease pixel_scale, or widen the field of view",
            ));
        }
        let mosaic = instrument.detector.mosaic.as_ref().map(|names| mosaic_of(names, bands)).transpose()?;
        if mosaic.is_some() && pixels.size.contains(&1) {
            let found = format!("{} x {} pixels", pixels.size[0], pixels.size[1]);
            return Err(Error::mismatch("mosaic of a detector", "2 x 2 pixels or more", found));
        }
        let charges = instrument.detector.charges(pixels.count(), instrument.exposure_s) * instrument.frames as f64;
        if charges > MOST_CHARGES {
            let problem = format!("cosmic rays hit {charges:.0e} pixels in all frames, at most {MOST_CHARGES:.0e} are supported");
            return Err(Error::conflict(problem, "use fewer frames, or cosmic_rays = \"0 /cm2/s\""));
        }
        Ok(Self { below, pixels, squares, mosaic })
    }
}

/// The numbers of the passbands that a mosaic names.
fn mosaic_of(names: &[String; 4], bands: &[Passband]) -> Result<[usize; 4]> {
    let mut square = [0; 4];
    for (row, name) in square.iter_mut().zip(names) {
        let found = bands.iter().position(|band| band.name() == name);
        *row = found.ok_or_else(|| {
            let known: Vec<&str> = bands.iter().map(Passband::name).collect();
            let problem = format!("the mosaic names \"{name}\", which is not a passband of the scene ({})", known.join(", "));
            Error::conflict(problem, "name one of these, or remove the mosaic")
        })?;
    }
    match (0..bands.len()).find(|band| !square.contains(band)) {
        Some(unseen) => {
            let problem = format!("the mosaic does not name passband {} of the scene", bands[unseen].name());
            Err(Error::conflict(problem, "name all passbands, or render the others separately"))
        }
        None => Ok(square),
    }
}
