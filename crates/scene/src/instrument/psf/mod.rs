//! Point-spread functions: where a telescope and the air above it send the light of a point.

mod airy;
mod gaussian;
mod measured;
mod moffat;

use std::sync::Arc;

pub use airy::Airy;
pub use gaussian::Gaussian;
pub use measured::MeasuredPsf;
pub use moffat::Moffat;

use super::Instrument;
use crate::error::Result;
use crate::image::Band;
use crate::image::convolution::Kernel;
use crate::properties::Kind;

/// Optics in front of a point.
#[derive(Debug, Clone, Copy)]
pub struct OpticsView<'a> {
    /// The instrument.
    pub instrument: &'a Instrument,
    /// The passband.
    pub band: &'a Band,
    /// The angle of a pixel of the picture that is spread \[rad\].
    pub pixel_rad: f64,
    /// Radius of the point-spread function \[pixels\].
    pub reach: usize,
}

/// Point-spread function. It can be implemented outside of this crate.
pub trait PointSpread: std::fmt::Debug + Send + Sync {
    /// The light by pixel, all together one; none where pixels are too wide to tell.
    ///
    /// # Errors
    /// If it spreads no light at all.
    fn kernel(&self, view: &OpticsView) -> Result<Option<Kernel>>;

    /// Description: equal texts mean equal values.
    fn description(&self) -> String;
}

impl PartialEq for dyn PointSpread {
    fn eq(&self, other: &Self) -> bool {
        self.description() == other.description()
    }
}

/// All kinds.
pub const KINDS: &[Kind<Arc<dyn PointSpread>>] = &[airy::KIND, moffat::KIND, gaussian::KIND, measured::KIND];

/// A profile narrower than this part of a pixel, full width at half maximum, spreads nothing that one could tell.
const UNRESOLVED: f64 = 0.2;

/// A round profile of a full width at half maximum \[rad\], by the square of the distance in such widths.
fn round(view: &OpticsView, fwhm: f64, profile: impl Fn(f64) -> f64 + Sync) -> Option<Kernel> {
    let width = fwhm / view.pixel_rad;
    (width > UNRESOLVED).then(|| Kernel::round(view.reach, |square| profile(square / width.powi(2))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, Samples};

    pub(super) fn band(pivot_um: f64) -> Band {
        let image = Image::bare(1, 1, vec!["V".into()], Samples::Double(vec![0.0]));
        Band { pivot_um: Some(pivot_um), width_um: Some(1e-4), ..image.bands[0].clone() }
    }

    /// Every kind keeps the light of a point, at any size of a pixel.
    #[test]
    fn light_is_kept() {
        let instrument = Instrument::of_aperture(0.5);
        let arcsec = std::f64::consts::PI / 648_000.0;
        let all: [Arc<dyn PointSpread>; 4] = [
            Arc::new(Airy { vanes: 4, ..Airy::default() }),
            Arc::new(Moffat { fwhm_rad: arcsec, ..Moffat::default() }),
            Arc::new(Gaussian { fwhm_rad: 0.6 * arcsec, ..Gaussian::default() }),
            Arc::new(MeasuredPsf::new("K", [3, 3], vec![0.0, 1.0, 0.0, 1.0, 4.0, 1.0, 0.0, 1.0, 0.0], 0.5 * arcsec).unwrap()),
        ];
        for psf in &all {
            for pixel in [0.05, 0.3, 1.0] {
                let view = OpticsView { instrument: &instrument, band: &band(0.55), pixel_rad: pixel * arcsec, reach: 50 };
                let kernel = psf.kernel(&view).unwrap().unwrap();
                assert!((kernel.values.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{psf:?} {pixel}");
                assert!(kernel.values.iter().all(|v| *v >= 0.0), "{psf:?} {pixel}");
            }
            // A pixel of a degree holds all of it: the PSF is not stated, or it is narrower.
            let view = OpticsView { instrument: &instrument, band: &band(0.55), pixel_rad: 3600.0 * arcsec, reach: 5 };
            assert!(psf.kernel(&view).unwrap().is_none_or(|kernel| kernel.values[60] > 0.99), "{psf:?}");
        }
    }

    /// Widths are what was asked for, and change with wavelength as they should.
    #[test]
    fn widths_are_widths() {
        let instrument = Instrument::of_aperture(1.0);
        let fwhm = |psf: &dyn PointSpread, pivot: f64| {
            let view = OpticsView { instrument: &instrument, band: &band(pivot), pixel_rad: 1e-8, reach: 600 };
            let kernel = psf.kernel(&view).unwrap().unwrap();
            let row = &kernel.values[600 * 1201 + 600..][..600];
            let half = row.iter().position(|v| *v < 0.5 * row[0]).unwrap();
            2e-8 * (half as f64 - 1.0 + (row[half - 1] - 0.5 * row[0]) / (row[half - 1] - row[half]))
        };
        // The core of Airy's pattern: 1.029 λ/D.
        assert!((fwhm(&Airy::default(), 0.5) / (1.029 * 0.5e-6) - 1.0).abs() < 0.02);
        let air = Moffat { fwhm_rad: 2e-6, ..Moffat::default() };
        assert!((fwhm(&air, 0.5) / 2e-6 - 1.0).abs() < 0.01);
        assert!((fwhm(&air, 1.0) / (2e-6 * 2f64.powf(-0.2)) - 1.0).abs() < 0.01);
        assert!((fwhm(&Gaussian { fwhm_rad: 1e-6, ..Gaussian::default() }, 0.8) / 1e-6 - 1.0).abs() < 0.01);
    }
}
