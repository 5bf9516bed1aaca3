//! Geometry of plates: places, densities and angles, as numbers that a scene of other spectra must share.

use spectra::fingerprint::{Digest, Fingerprint};
use spectra::rule::Node;

use crate::error::{Error, Result};
use crate::field::fingerprint;
use crate::light::law;
use crate::scene::{Part, Scene};

/// Numbers that tell one thing of a scene, and what that is.
#[derive(Debug, Clone, PartialEq)]
pub struct Trait {
    /// Name of the quantity.
    pub name: String,
    /// The numbers, in units of their own.
    pub values: Vec<f64>,
}

/// All that a picture hangs on besides spectra.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// Each thing, in an order of its own.
    pub traits: Vec<Trait>,
}

/// Rounding of numbers that are the same, of the largest of them.
const SAME: f64 = 1e-9;

impl Geometry {
    /// That of a scene, for plates whose nodes are `nodes`.
    ///
    /// # Errors
    /// If the scene's extinction law cannot be.
    pub fn of(scene: &Scene, nodes: &[Node]) -> Result<Self> {
        let mut geometry = Self::default();
        let camera = &scene.camera;
        geometry.add("pixels of the camera", [camera.width, camera.height, camera.supersampling].map(|count| count as f64));
        geometry.add("camera", integers(scene.parts().get(Part::View)));
        geometry.add("positions of stars", scene.stars.iter().flat_map(|star| star.position.to_array()));
        geometry.add("visible stars", scene.stars.iter().map(|star| f64::from(u8::from(star.visible))));
        geometry.add("bounces", [scene.method.bounces as f64]);
        if let Some(dust) = &scene.dust {
            if binds_dust(scene) {
                geometry.add("amount of dust", [dust.sigma_v_per_pc]);
            }
            geometry.add("density of dust", integers(fingerprint(&*dust.density)));
            let mut phase = Digest::new("phase");
            dust.phase.content(&mut phase);
            geometry.add("phase function", integers(phase.finish()));
            let again = scene.method.bounces > 1;
            if again || dust.phase.is_spectral() {
                let law = law(scene)?;
                geometry.add("extinction law of scattered light", nodes.iter().map(|node| law.k(node.lambda_um)));
            }
            if again {
                geometry.add("albedo of multiple scattering", nodes.iter().map(|node| dust.albedo.at(node.lambda_um)));
            }
        }
        for (number, species) in scene.species().iter().enumerate() {
            geometry.add(format!("density of gas number {}", number + 1), integers(fingerprint(&*species.density)));
        }
        if let Some(detail) = &scene.detail {
            let numbers = [f64::from(detail.seed), detail.octaves as f64, detail.strength];
            geometry.add("detail", numbers);
        }
        Ok(geometry)
    }

    fn add(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = f64>) {
        self.traits.push(Trait { name: name.into(), values: values.into_iter().collect() });
    }

    /// Refuses another geometry than this one.
    ///
    /// # Errors
    /// Says what of it is another.
    pub fn check(&self, other: &Self) -> Result<()> {
        let largest = |one_trait: &Trait| one_trait.values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        for known in &self.traits {
            let same = |theirs: &Trait| {
                let room = SAME * largest(known);
                theirs.values.len() == known.values.len() && theirs.values.iter().zip(&known.values).all(|(a, b)| (a - b).abs() <= room)
            };
            match other.traits.iter().find(|theirs| theirs.name == known.name) {
                Some(theirs) if same(theirs) => {}
                found => {
                    let relation = if found.is_some() { "differs from that of" } else { "is not in the scene, but in" };
                    return Err(Error::conflict(format!("{} {relation} the plates", known.name), REMEDY));
                }
            }
        }
        match other.traits.iter().find(|theirs| self.traits.iter().all(|known| known.name != theirs.name)) {
            Some(new) => Err(Error::conflict(format!("the plates have no {}", new.name), REMEDY)),
            None => Ok(()),
        }
    }
}

/// Whether plates of a scene are bound to its amount of dust: where a node is a wavelength, and not an extinction alone, since light scatters
/// more than once or the phase function changes with wavelength.
pub fn binds_dust(scene: &Scene) -> bool {
    scene.dust.as_ref().is_some_and(|dust| scene.method.bounces > 1 || dust.phase.is_spectral())
}

const REMEDY: &str = "change only spectra, luminosities, passbands, albedo and the amount of dust, or make new plates";

/// A fingerprint as numbers.
fn integers(fingerprint: Fingerprint) -> [f64; 8] {
    fingerprint.to_integers().map(f64::from)
}
