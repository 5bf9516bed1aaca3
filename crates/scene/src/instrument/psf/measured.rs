//! A point-spread function that was measured or modelled elsewhere: an image of a point.

use std::sync::Arc;

use sha2::{Digest, Sha256};
use spectra::units::Angle;

use super::super::rebinning::Squares;
use super::{OpticsView, PointSpread};
use crate::data::InputNote;
use crate::error::{Error, Result};
use crate::image::convolution::Kernel;
use crate::properties::{Key, Kind, Path, Required, Text};

const FILE: Key<Path, Required> = Key::path("file", "image file; by default its first HDU or band").required();
const HDU: Key<Text> = Key::text("hdu", "name or number of the HDU of a FITS file, such as \"OVERDIST\"").otherwise("the first image");
const PIXEL_SCALE: Key<Angle, Required> = Key::quantity::<Angle>("pixel_scale", "the angle of a pixel of the image").positive().required();

pub(super) const KIND: Kind<Arc<dyn PointSpread>> = Kind {
    name: "kernel",
    summary: "image of a point source, such as those of WebbPSF or Tiny Tim: .fits, .npy or .exr, with the source at its centre",
    keys: &[FILE.row, HDU.row, PIXEL_SCALE.row],
    build: |section, inputs| {
        let file = section.read(&FILE)?;
        let hdu = section.read(&HDU)?;
        let (size, values) = section.wrap(&FILE, inputs.picture(file, hdu))?;
        let which = hdu.map_or_else(|| "the first image".to_owned(), |hdu| format!("HDU {hdu}"));
        inputs.note(InputNote {
            file: file.to_owned(),
            text: format!("kernel: {which}, {} x {} pixels", size[0], size[1]),
            is_inferred: false,
        });
        let scale = section.read(&PIXEL_SCALE)?.0;
        Ok(Arc::new(section.wrap(&FILE, MeasuredPsf::new(file, size, values, scale))?))
    },
};

/// An image of a point.
#[derive(Clone, PartialEq)]
pub struct MeasuredPsf {
    name: String,
    size: [usize; 2],
    values: Vec<f64>,
    pixel_rad: f64,
    /// The beginning of the digest of its values.
    digest: String,
}

/// Most pixels along an edge.
const MAX_EDGE: usize = 4097;

impl MeasuredPsf {
    /// An image of a given number of columns and rows, in rows, and the angle of its pixels \[rad\].
    ///
    /// # Errors
    /// If it is no image of a point: empty, too large, negative in sum, or with values that are no numbers.
    pub fn new(name: &str, size: [usize; 2], values: Vec<f64>, pixel_rad: f64) -> Result<Self> {
        let wrong = |found: String, expected: &str| Err(Error::mismatch("kernel", expected, format!("{found} in {name}")));
        if size.iter().any(|edge| !(1..=MAX_EDGE).contains(edge)) || values.len() != size[0] * size[1] {
            return wrong(format!("{} x {} pixels", size[0], size[1]), "1 to 4097 pixels per edge");
        }
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let place = format!("{} in column {}, row {}", values[at], at % size[0] + 1, at / size[0] + 1);
            return wrong(place, "finite numbers");
        }
        let (sum, most) = (values.iter().sum::<f64>(), values.iter().copied().fold(0.0, f64::max));
        if !(sum > 0.0 && most > 0.0) {
            return wrong(format!("a sum of {sum}"), "an image of a point with a sum above zero");
        }
        if let Some(least) = values.iter().copied().find(|v| *v < -0.01 * most) {
            return wrong(format!("{least} at a peak of {most}"), "values of at least zero, without background");
        }
        if !(pixel_rad > 0.0 && pixel_rad.is_finite()) {
            return wrong(format!("pixels of {pixel_rad} rad"), "a pixel angle above zero");
        }
        // Noise around zero would be light where none is.
        let values: Vec<f64> = values.into_iter().map(|v| v.max(0.0)).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let digest = Sha256::digest(bytes)[..8].iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { name: name.to_owned(), size, values, pixel_rad, digest })
    }
}

impl std::fmt::Debug for MeasuredPsf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Measured({}, {:?}, {:e} rad)", self.name, self.size, self.pixel_rad)
    }
}

impl PointSpread for MeasuredPsf {
    fn kernel(&self, view: &OpticsView) -> Result<Option<Kernel>> {
        let edge = view.pixel_rad / self.pixel_rad;
        let count = 2 * view.reach + 1;
        let first = self.size.map(|pixels| 0.5 * (pixels as f64 - count as f64 * edge));
        let values = Squares { size: [count; 2], first, edge }.gathered(&self.values, self.size);
        let sum: f64 = values.iter().sum();
        if !(sum > 0.0 && sum.is_finite()) {
            let problem = format!("the kernel has no light within {} pixels of its middle", view.reach);
            return Err(Error::conflict(problem, "centre the point in the image"));
        }
        let mut kernel = Kernel { reach: view.reach, values };
        kernel.normalise();
        Ok(Some(kernel))
    }

    fn description(&self) -> String {
        let [width, height] = self.size;
        format!("{} of {width} x {height} pixels of {}, SHA-256 {}", self.name, Angle(self.pixel_rad), self.digest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::Instrument;

    /// Taken at its own scale an image stays what it is; at twice that four pixels become one, and beside them nothing is.
    #[test]
    fn images_of_points_are_rebinned() {
        let values: Vec<f64> = (0..25).map(f64::from).collect();
        let psf = MeasuredPsf::new("p", [5, 5], values.clone(), 1e-6).unwrap();
        let instrument = Instrument::of_aperture(1.0);
        let band = super::super::tests::band(0.5);
        let view = OpticsView { instrument: &instrument, band: &band, pixel_rad: 1e-6, reach: 3 };
        let kernel = psf.kernel(&view).unwrap().unwrap().values;
        assert!((0..49).all(|i| {
            let (x, y) = (i % 7, i / 7);
            let inside = (1..6).contains(&x) && (1..6).contains(&y);
            (kernel[i] - if inside { values[(y - 1) * 5 + x - 1] / 300.0 } else { 0.0 }).abs() < 1e-12
        }));
        let coarse = psf.kernel(&OpticsView { pixel_rad: 5e-6, reach: 1, ..view }).unwrap().unwrap().values;
        assert!((coarse[4] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_kernel_is_refused() {
        let refused = |values: Vec<f64>| MeasuredPsf::new("p", [2, 2], values, 1e-6).map(|_| ()).unwrap_err().to_string();
        assert!(refused(vec![0.0; 4]).contains("above zero"));
        assert!(refused(vec![1.0, f64::NAN, 1.0, 1.0]).contains("column 2, row 1"));
        assert!(refused(vec![4.0, -1.0, 1.0, 1.0]).contains("background"));
        assert!(refused(vec![1.0; 3]).contains("2 x 2"));
        assert!(MeasuredPsf::new("p", [1, 1], vec![1.0], f64::NAN).is_err());
    }
}
