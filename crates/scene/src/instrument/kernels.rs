//! Kernels of point-spread functions, ready to spread light, and kept from picture to picture.

use std::sync::Arc;

use super::psf::OpticsView;
use super::{Detector, Instrument, PointSpread, Sky};
use crate::error::Result;
use crate::image::Band;
use crate::image::convolution::{Spread, reach};

/// Point-spread functions of one instrument: worked out once for each passband, and again where optics or pixels change.
#[derive(Debug, Clone, Default)]
pub struct Kernels {
    known: Vec<CachedKernel>,
    limit: u64,
}

/// A kernel, and what it is of; none where pixels are too wide to tell.
#[derive(Debug, Clone)]
struct CachedKernel {
    inputs: KernelInputs,
    spread: Option<Arc<Spread>>,
}

/// All that a kernel hangs on.
#[derive(Debug, Clone, PartialEq)]
struct KernelInputs {
    /// Description of the point-spread function.
    psf: String,
    optics: Instrument,
    band: (String, Option<f64>, Option<f64>),
    pixel_rad: f64,
    size: [usize; 2],
}

impl Kernels {
    /// The latest kernels within a number of bytes; by default none.
    pub fn within(limit: u64) -> Self {
        Self { known: Vec::new(), limit }
    }

    /// Spreads the light of a picture of a given number of pixels along a row and a column as a point-spread function of an instrument does.
    pub(super) fn apply(
        &mut self,
        psf: &dyn PointSpread,
        instrument: &Instrument,
        band: &Band,
        pixel_rad: f64,
        size: [usize; 2],
        light: &mut [f64],
    ) -> Result<()> {
        let key = (band.name.clone(), band.pivot_um, band.width_um);
        let inputs = KernelInputs { psf: psf.description(), optics: optics(instrument), band: key, pixel_rad, size };
        let entry = match self.known.iter().position(|known| known.inputs == inputs) {
            Some(known) => self.known.remove(known),
            None => {
                let kernel = psf.kernel(&OpticsView { instrument, band, pixel_rad, reach: reach(size[0].max(size[1])) })?;
                CachedKernel { inputs, spread: kernel.map(|kernel| Arc::new(Spread::new(&kernel, size[0], size[1]))) }
            }
        };
        if let Some(spread) = &entry.spread {
            spread.apply(light, size[0]);
        }
        self.known.push(entry);
        while self.known.iter().filter_map(|entry| entry.spread.as_ref()).map(|spread| spread.bytes()).sum::<u64>() > self.limit {
            self.known.remove(0);
        }
        Ok(())
    }

    /// Forgets all but the latest.
    pub(super) fn keep(&mut self, latest: usize) {
        let old = self.known.len().saturating_sub(latest);
        self.known.drain(..old);
    }
}

/// The instrument without what spreads no light.
fn optics(instrument: &Instrument) -> Instrument {
    Instrument {
        name: String::new(),
        collecting_area_m2: None,
        throughput: 1.0,
        psf: Vec::new(),
        pixel_rad: None,
        sky: Sky::default(),
        subtract_sky: true,
        detector: Detector::default(),
        exposure_s: 1.0,
        frames: 1,
        seed: 0,
        ..*instrument
    }
}
