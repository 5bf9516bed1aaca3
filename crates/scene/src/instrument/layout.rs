//! Layout of a detector on a picture: pixels, solid angles, the passbands of a mosaic.

use spectra::passband::Passband;

use super::Instrument;
use super::rebinning::Squares;
use crate::error::{Error, Result};
use crate::image::{Image, PixelScale};

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
    /// Where it is not flat, has views of its own, or a size that is no angle.
    pub(super) fn of(image: &Image) -> Result<Self> {
        let wanted = "a picture by a camera of kind \"perspective\", or \"orthographic\" with the distance in [observation]";
        let (edge_rad, is_parallel) = match (image.pixel, image.observation.and_then(|observation| observation.distance_pc)) {
            (Some(PixelScale::Angle(degrees)), _) => (degrees.to_radians(), false),
            (Some(PixelScale::Length(pc)), Some(distance)) => (pc / distance, true),
            _ => return Err(Error::value("picture for an instrument", "one whose pixels have no angle in a plane", wanted)),
        };
        if image.views != (1, 1) {
            return Err(Error::value("picture for an instrument", "one of several views", wanted));
        }
        Ok(Self { size: [image.width, image.height], edge_rad, axis: image.axis, is_parallel })
    }

    /// Copy of the plane in pixels of another edge, as many as it holds.
    fn rebinned(&self, edge: f64) -> (Self, Squares) {
        let squares = Squares::within(self.size, edge);
        let axis = (self.axis.0 / edge, self.axis.1 / edge);
        (Self { size: squares.size, edge_rad: self.edge_rad * edge, axis, ..*self }, squares)
    }

    /// The solid angle of a pixel \[sr\]: Ω = p² cos³θ, tan θ the distance from the axis.
    pub(super) fn solid_angle(&self, pixel: usize) -> f64 {
        let square = self.edge_rad * self.edge_rad;
        if self.is_parallel {
            return square;
        }
        let (column, row) = ((pixel % self.size[0]) as f64, (pixel / self.size[0]) as f64);
        let right = column + 0.5 - 0.5 * self.size[0] as f64 - self.axis.0;
        let up = 0.5 * self.size[1] as f64 - row - 0.5 - self.axis.1;
        square * (1.0 + square * (right * right + up * up)).powf(-1.5)
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
pub(super) struct Layout {
    pub below: Pixels,
    pub pixels: Pixels,
    pub squares: Squares,
    pub mosaic: Option<[usize; 4]>,
}

impl Layout {
    pub(super) fn new(instrument: &Instrument, image: &Image, bands: &[Passband]) -> Result<Self> {
        instrument.check()?;
        instrument.check_filters(bands)?;
        for (number, band) in bands.iter().enumerate() {
            instrument.sky.radiance(band, number, bands.len())?;
        }
        let below = Pixels::of(image)?;
        let edge = instrument.pixel_rad.map_or(1.0, |pixel| pixel / below.edge_rad);
        if edge < 1.0 - SAME {
            let (own, wanted) = (instrument.pixel_rad.unwrap_or_default(), (image.width as f64 / edge).ceil());
            let arcsec = |angle: f64| spectra::units::short((angle.to_degrees() * 3600e4).round() / 1e4);
            return Err(Error::value(
                "pixel scale of an instrument",
                format!("{} arcsec, finer than the picture's pixels of {} arcsec", arcsec(own), arcsec(below.edge_rad)),
                format!("what it tells; take {wanted} pixels or more along a row of the camera, a narrower view, or a larger pixel_scale"),
            ));
        }
        let (pixels, squares) = below.rebinned(edge.max(1.0));
        if pixels.count() == 0 {
            return Err(Error::value("pixel scale of an instrument", "wider than the picture", "an angle that it holds more than once"));
        }
        let mosaic = instrument.detector.mosaic.as_ref().map(|names| mosaic_of(names, bands)).transpose()?;
        if mosaic.is_some() && pixels.size.contains(&1) {
            return Err(Error::value(
                "mosaic of a detector",
                format!("{} x {} pixels", pixels.size[0], pixels.size[1]),
                "one of two by two or more",
            ));
        }
        let charges = instrument.detector.charges(pixels.count(), instrument.exposure_s) * instrument.frames as f64;
        if charges > MOST_CHARGES {
            let said = format!("{charges:.0e} pixels hit in all frames");
            return Err(Error::value(
                "cosmic rays of a detector",
                said,
                format!("at most {MOST_CHARGES:.0e}; take fewer frames, or cosmic_rays = \"0 /cm2/s\""),
            ));
        }
        Ok(Self { below, pixels, squares, mosaic })
    }
}

/// The numbers of the passbands that a mosaic names.
fn mosaic_of(names: &[String; 4], bands: &[Passband]) -> Result<[usize; 4]> {
    let mut square = [0; 4];
    for (own, name) in square.iter_mut().zip(names) {
        let found = bands.iter().position(|band| band.name() == name);
        *own = found.ok_or_else(|| {
            let known: Vec<&str> = bands.iter().map(Passband::name).collect();
            Error::value(
                "mosaic of a detector",
                format!("\"{name}\""),
                format!("a passband of the scene ({}), or no mosaic", known.join(", ")),
            )
        })?;
    }
    match (0..bands.len()).find(|band| !square.contains(band)) {
        Some(unseen) => {
            let said = format!("without {}, a passband of the scene", bands[unseen].name());
            Err(Error::value("mosaic of a detector", said, "one that names all passbands; render the others for themselves"))
        }
        None => Ok(square),
    }
}
