//! Parts of a scene: what caches depend on, as fingerprints.
//!
//! A cache keeps the [`Parts`] of the scene that it was made of, and is valid for every scene whose parts are equal as far as
//! it depends on them.

use glam::DVec3;
use spectra::fingerprint::{Digest, Fingerprint};

use super::{BackendOptions, Background, Dust, Emission, Method, Scene, Star};
use crate::field::fingerprint;
use crate::instrument::Instrument;
pub use crate::properties::Part;
use crate::star_catalogue::PlacedCatalogue;

/// Fingerprints of the parts of a scene, in the order of [`Part::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Parts([Fingerprint; Part::ALL.len()]);

impl Parts {
    /// The fingerprint of one part.
    pub fn get(&self, part: Part) -> Fingerprint {
        self.0[part as usize]
    }

    /// Fingerprint of several parts.
    pub fn of(&self, parts: &[Part]) -> Fingerprint {
        let mut digest = Digest::new("parts");
        for part in parts {
            digest.part(self.get(*part));
        }
        digest.finish()
    }

    /// Fingerprint of all that a plan depends on but the camera.
    pub fn physics(&self) -> Fingerprint {
        self.of(&[Part::Space, Part::Stars, Part::Spectra, Part::Amount, Part::Method])
    }

    /// The parts in which another scene differs.
    pub fn differing(&self, other: &Self) -> Vec<Part> {
        Part::ALL.into_iter().filter(|part| self.get(*part) != other.get(*part)).collect()
    }
}

fn positions(positions: impl Iterator<Item = DVec3>, digest: &mut Digest) -> &mut Digest {
    for position in positions {
        digest.numbers(&position.to_array());
    }
    digest
}

impl Scene {
    /// Fingerprints of the scene by what depends on them.
    pub fn parts(&self) -> Parts {
        let fingerprint = |part: Part| -> Fingerprint {
            let mut digest = Digest::new("part");
            match part {
                Part::Space => self.space(&mut digest),
                Part::Stars => positions(self.stars.iter().map(|star| star.position), &mut digest),
                Part::Spectra => self.lights_and_matter(&mut digest),
                Part::Amount => digest.plain(&self.dust.as_ref().map(|dust| dust.sigma_v_per_pc)),
                Part::Method => digest.plain(&Method { backends: BackendOptions::default(), ..self.method.clone() }),
                Part::Backend => digest.plain(&self.method.backends),
                Part::View => digest.plain(&self.camera),
                Part::Display => digest.plain(&self.display),
                Part::Observation => digest.plain(&self.observation).plain(&self.background.catalogue.as_ref().map(|placed| placed.axes)),
                Part::Instrument => self.instrument(&mut digest),
                Part::Output => digest.plain(&self.output),
            }
            .finish()
        };
        Parts(Part::ALL.map(fingerprint))
    }

    fn instrument<'d>(&self, digest: &'d mut Digest) -> &'d mut Digest {
        let Some(instrument) = &self.instrument else { return digest };
        for psf in &instrument.psf {
            digest.text(&psf.description());
        }
        digest.plain(&Instrument { psf: Vec::new(), ..Instrument::clone(instrument) })
    }

    fn space<'d>(&self, digest: &'d mut Digest) -> &'d mut Digest {
        digest.plain(&self.detail).plain(&self.is_rough);
        if let Some(Dust { density, phase, .. }) = &self.dust {
            phase.content(digest.text("dust").part(fingerprint(&**density)));
        }
        for gas in self.species() {
            digest.part(fingerprint(&*gas.density));
        }
        digest
    }

    fn lights_and_matter<'d>(&self, digest: &'d mut Digest) -> &'d mut Digest {
        if let Some(Dust { extinction, albedo, .. }) = &self.dust {
            digest.text("dust").part(extinction.fingerprint()).plain(albedo);
        }
        for Emission { name, spectrum, .. } in self.species() {
            digest.text("gas").text(name).part(spectrum.fingerprint());
        }
        for Star { name, spectrum, visible, .. } in &self.stars {
            digest.text("star").text(name).plain(visible).part(spectrum.fingerprint());
        }
        for band in &self.bands {
            digest.text("band").part(band.fingerprint());
        }
        let Background { spectrum, star_field, catalogue } = &self.background;
        if let Some(spectrum) = spectrum {
            digest.text("background").part(spectrum.fingerprint());
        }
        if let Some(PlacedCatalogue { catalogue, .. }) = catalogue {
            digest.part(catalogue.fingerprint());
        }
        digest.plain(star_field).plain(&self.spectrograph)
    }
}
