//! Kernels of glare, and those of the last pictures.

use std::cell::OnceCell;
use std::sync::{Arc, Mutex, PoisonError};

use super::super::Band;
use super::super::convolution::{Kernel, Spread, reach};
use super::Glare;

/// Parameters of a kernel.
#[derive(PartialEq)]
pub(super) struct KernelKey {
    pub(super) glare: Glare,
    pub(super) longer: usize,
    pub(super) pivot_um: Option<f64>,
    pub(super) width_um: Option<f64>,
}

/// Kernels that are kept, and what each is of.
pub(super) type KernelCache = Mutex<Vec<(KernelKey, Arc<Kernel>)>>;

/// Kernels of the last picture: each frame of a film, and each look at a picture in other colours, asks for the same. They take longer
/// than the convolution.
pub(super) static LAST: KernelCache = Mutex::new(Vec::new());
/// Bytes of them at most: four of the largest.
pub(super) const KEPT_BYTES: u64 = 640 << 20;

/// Keeps a kernel, and earlier ones of the same picture within the memory limit.
pub(super) fn keep(last: &mut Vec<(KernelKey, Arc<Kernel>)>, one: (KernelKey, Arc<Kernel>), bytes: u64) {
    last.retain(|(known, _)| known.glare == one.0.glare && known.longer == one.0.longer);
    last.push(one);
    while last.iter().map(|(_, kernel)| kernel.bytes()).sum::<u64>() > bytes {
        last.remove(0);
    }
}

/// Achromatic blur: halo and seeing.
pub(super) struct Haze {
    pub(super) halo: Option<Kernel>,
    pub(super) air: Option<Spread>,
}

/// Air that spreads light less is still \[pixels\].
const STILL_AIR: f64 = 1e-3;

/// The exponent of Moffat's profile.
const BETA: f64 = 4.765;

impl Glare {
    /// Where the light of a point of a band goes, from a picture before where that asked for the same.
    pub(super) fn cached_kernel(&self, band: &Band, longer: usize, haze: &OnceCell<Haze>, last: &KernelCache) -> Arc<Kernel> {
        let asked = KernelKey { glare: *self, longer, pivot_um: band.pivot_um, width_um: band.width_um };
        let last = || last.lock().unwrap_or_else(PoisonError::into_inner);
        let known = last().iter().find(|(known, _)| *known == asked).map(|(_, kernel)| kernel.clone());
        known.unwrap_or_else(|| {
            let kernel = Arc::new(self.kernel(band, longer, haze.get_or_init(|| self.haze(longer))));
            keep(&mut last(), (asked, kernel.clone()), KEPT_BYTES);
            kernel
        })
    }

    /// Band-independent part for a picture with the given longer edge.
    pub(super) fn haze(&self, longer: usize) -> Haze {
        let (reach, pixels) = (reach(longer), longer as f64 / 1000.0);
        let least = (self.size * pixels).max(1.0).powi(2);
        let halo = (self.halo > 0.0).then(|| Kernel::round(reach, |square| 1.0 / (square + least)));
        let width = 0.5 * self.seeing * pixels / (2f64.powf(1.0 / BETA) - 1.0).sqrt();
        let air = (width > STILL_AIR).then(|| {
            let moffat = Kernel::round(reach, |square| (1.0 + square / width.powi(2)).powf(-BETA));
            Spread::new(&moffat, 2 * reach + 1, 2 * reach + 1)
        });
        Haze { halo, air }
    }

    /// Kernel of a point in a picture with the given longer edge.
    pub(super) fn kernel(&self, band: &Band, longer: usize, haze: &Haze) -> Kernel {
        let mut kernel =
            Kernel::of_optics(&(self.optics.pattern)(), self.rotation, band, reach(longer), self.size * longer as f64 / 1000.0);
        if let Some(halo) = &haze.halo {
            kernel.values.iter_mut().zip(&halo.values).for_each(|(value, halo)| *value += self.halo * (halo - *value));
        }
        if let Some(air) = &haze.air {
            // Its own even picture is all of it: nothing comes in from beyond its edges.
            air.within(&mut kernel.values);
        }
        kernel.fade();
        kernel
    }
}
