//! The spectrum under the pointer.

use std::sync::Arc;

use barnard::image::Image;
use barnard::plan::Probe;
use spectra::passband::Passband;

use crate::picture::Picture;

/// Wavelengths of the spectrum.
const SAMPLES: usize = 120;

/// The spectrum at a pixel of a picture, kept until the pointer or the picture moves.
pub struct Probed {
    image: Arc<Image>,
    pixel: (usize, usize),
    /// Wavelengths of the spectrum \[µm\].
    pub wavelengths_um: Vec<f64>,
    /// The spectrum, or the reason why there is none.
    pub found: Result<Probe, String>,
}

impl Probed {
    /// The spectrum at a pixel (column, row), without light of stars seen directly.
    pub fn new(picture: &Picture, pixel: (usize, usize)) -> Self {
        let ends = picture.scene.bands.iter().map(Passband::support_um).fold((f64::MAX, 0.0f64), |(l, h), (a, b)| (l.min(a), h.max(b)));
        let wavelengths_um: Vec<f64> = (0..SAMPLES).map(|i| ends.0 + (ends.1 - ends.0) * i as f64 / (SAMPLES - 1) as f64).collect();
        let (column, row) = pixel;
        let ray = picture.plan.camera().ray(column as f64 + 0.5, row as f64 + 0.5);
        let found = picture.plan.probe(&ray, &wavelengths_um).map_err(|e| e.to_string());
        Self { image: picture.image.clone(), pixel, wavelengths_um, found }
    }

    /// True if it is the spectrum of this picture and pixel.
    pub fn is_of(&self, image: &Arc<Image>, pixel: (usize, usize)) -> bool {
        Arc::ptr_eq(&self.image, image) && self.pixel == pixel
    }
}
