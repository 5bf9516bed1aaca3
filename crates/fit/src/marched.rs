//! Plates that a fit keeps.

use barnard::Plates;
use barnard::field::fingerprint;
use barnard::scene::Scene;
use barnard::spectra::fingerprint::{Digest, Fingerprint};

/// Plates of an image by its number, and the fingerprint of the densities that they are of.
#[derive(Debug, Clone)]
pub(crate) struct Marched {
    pub image: usize,
    densities: Fingerprint,
    pub plates: Plates,
}

impl Marched {
    pub fn new(image: usize, scene: &Scene, plates: Plates) -> Self {
        Self { image, densities: densities(scene), plates }
    }

    /// True if they are of an image's scene, of some amount of dust; spectra may be others.
    pub fn are_of(&self, image: usize, scene: &Scene, amount: f64) -> bool {
        self.image == image && self.plates.record().dust_per_pc == amount && self.densities == densities(scene)
    }
}

fn densities(scene: &Scene) -> Fingerprint {
    let mut digest = Digest::new("densities");
    for density in scene.densities() {
        digest.part(fingerprint(&**density));
    }
    digest.finish()
}
