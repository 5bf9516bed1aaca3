//! Plates that a fit keeps.

use std::sync::Arc;

use barnard::Plates;
use barnard::field::Field;
use barnard::scene::Scene;

/// Plates of an image by its number, and the densities that they are of, which are held so that they can be told from others.
#[derive(Debug, Clone)]
pub(crate) struct Marched {
    pub image: usize,
    densities: Vec<Arc<dyn Field>>,
    pub plates: Plates,
}

impl Marched {
    pub fn new(image: usize, scene: &Scene, plates: Plates) -> Self {
        Self { image, densities: densities(scene), plates }
    }

    /// True if they are of an image's scene, of some amount of dust; spectra may be others.
    pub fn are_of(&self, image: usize, scene: &Scene, amount: f64) -> bool {
        let (ours, theirs) = (&self.densities, densities(scene));
        let same = ours.len() == theirs.len() && ours.iter().zip(&theirs).all(|(our, theirs)| Arc::ptr_eq(our, theirs));
        self.image == image && self.plates.record().dust_per_pc == amount && same
    }
}

/// The densities of a scene: the same fields where it is read again with nothing of them changed.
fn densities(scene: &Scene) -> Vec<Arc<dyn Field>> {
    let of_gas = scene.species().iter().map(|species| species.density.clone());
    scene.dust.iter().map(|dust| dust.density.clone()).chain(of_gas).collect()
}
