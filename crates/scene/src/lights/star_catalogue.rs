//! Stars of a catalogue: at infinity, where they are on the sky, as bright as it says.
//!
//! The light of each is a mixture of two classes, black bodies of neighbouring temperatures or the spectrum of a type. Classes are as
//! bright as magnitude zero in the catalogue's first passband, so that the star has its magnitude m there whatever the mixture,
//!
//!   E = 10^(−0.4 m) [(1 − w) E_i + w E_(i+1)],
//!
//! and w is chosen for its magnitude in a second passband, or linear in the logarithm of its temperature.

use std::sync::{Arc, OnceLock};

use glam::{DMat3, DVec3};
use spectra::fingerprint::{Digest, Fingerprint};
use spectra::passband::Passband;
use spectra::sed::{BlackBody, MagnitudeSystem, zero_point};
use spectra::spectrum::{Shape, Spectrum};
use spectra::units::Temperature;

use crate::camera::Camera;
use crate::error::Result;

/// A class of stars at infinity, each as bright as magnitude zero.
#[derive(Debug, Clone)]
pub struct StarClass {
    /// The name in certificates.
    pub name: String,
    /// Irradiance of magnitude zero [W m⁻² µm⁻¹].
    pub spectrum: Spectrum,
}

/// A star of a catalogue.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueStar {
    /// The name; empty where it has none.
    pub name: String,
    /// Unit vector towards it: x to right ascension 0, z to the pole, ICRS.
    pub direction: DVec3,
    /// The numbers of its classes, and how many times their light it has.
    pub shares: [(usize, f64); 2],
}

impl CatalogueStar {
    /// All of its light, in stars of magnitude zero.
    pub(crate) fn gain(&self) -> f64 {
        self.shares[0].1 + self.shares[1].1
    }
}

/// A catalogue: its stars, the brightest first.
#[derive(Debug)]
pub struct StarCatalogue {
    /// Source.
    pub label: String,
    /// The classes, each as bright as magnitude zero.
    pub classes: Vec<StarClass>,
    /// The stars.
    pub stars: Vec<CatalogueStar>,
    /// Number of stars whose colour is outside of the black-body ladder; they have the nearest one.
    pub beyond: usize,
    hash: OnceLock<Fingerprint>,
}

/// A catalogue and how it lies around a scene.
#[derive(Debug, Clone)]
pub struct PlacedCatalogue {
    /// The stars.
    pub catalogue: Arc<StarCatalogue>,
    /// Orientation of the sky around the scene.
    pub axes: SkyAxes,
}

/// Orientation of the sky around a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SkyAxes {
    /// As whoever looks has it: directions of the sky, ICRS, ahead in the middle of the picture, to its right and upwards.
    OfPicture([DVec3; 3]),
    /// As it is, whoever looks: turns directions of the sky, ICRS, into those of the scene.
    OfScene(DMat3),
}

impl PlacedCatalogue {
    /// Rotation from ICRS to the scene for a camera.
    pub fn scene_from_sky(&self, camera: &Camera) -> DMat3 {
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        match self.axes {
            SkyAxes::OfScene(turn) => turn,
            SkyAxes::OfPicture(sky) => {
                let pairs = camera.image_axes().into_iter().zip(sky);
                pairs.fold(DMat3::ZERO, |sum, (camera_axis, sky)| sum + outer(camera_axis, sky))
            }
        }
    }
}

/// Temperatures of the black bodies between which stars are mixed \[K\].
const COOLEST: f64 = 2000.0;
const HOTTEST: f64 = 50_000.0;
const RUNGS: usize = 24;

/// The temperature of a rung \[K\].
fn rung(i: usize) -> f64 {
    COOLEST * (HOTTEST / COOLEST).powf(i as f64 / (RUNGS - 1) as f64)
}

/// Magnitudes of catalogue stars: in one passband or in two.
#[derive(Debug)]
pub struct Photometry {
    band: Passband,
    /// The irradiance of magnitude zero [W m⁻²].
    zero: f64,
    /// That of a second passband, and the irradiance that each rung has there where its magnitude is zero in the first.
    second: Option<(f64, Vec<f64>)>,
}

/// Colour information of a star.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Colour {
    /// Its temperature \[K\].
    Temperature(f64),
    /// Its magnitude in the second passband.
    Magnitude(f64),
    /// The spectrum of its type, and the type.
    Type(Arc<dyn Shape>, String),
}

impl Photometry {
    /// Magnitudes of a system in one passband or two.
    ///
    /// # Errors
    /// If Vega's spectrum does not reach over one of them.
    pub fn new(band: Passband, second: Option<&Passband>, system: MagnitudeSystem) -> Result<Self> {
        let zero = zero_point(&band, system)?;
        let of_second = |other: &Passband| -> Result<_> {
            let through = |i: usize| {
                let body = BlackBody(Temperature(rung(i)));
                zero * other.integrate(|l| body.at(l)) / band.integrate(|l| body.at(l))
            };
            Ok((zero_point(other, system)?, (0..RUNGS).map(through).collect::<Vec<f64>>()))
        };
        let second = second.map(of_second).transpose()?;
        Ok(Self { band, zero, second })
    }
}

/// Makes a catalogue, star after star.
#[derive(Debug)]
pub struct Builder {
    photometry: Photometry,
    types: Vec<(String, Arc<dyn Shape>)>,
    stars: Vec<CatalogueStar>,
    beyond: usize,
}

impl Builder {
    /// A catalogue of such magnitudes.
    pub fn new(photometry: Photometry) -> Self {
        Self { photometry, types: Vec::new(), stars: Vec::new(), beyond: 0 }
    }

    /// Adds a star in a direction, ICRS, by its magnitude in the first passband and its colour.
    pub fn add(&mut self, name: String, direction: DVec3, magnitude: f64, colour: Colour) {
        let (first, weight) = match colour {
            Colour::Temperature(kelvin) => {
                let place = (kelvin / COOLEST).ln() / (HOTTEST / COOLEST).ln() * (RUNGS - 1) as f64;
                self.between(place)
            }
            Colour::Magnitude(second) => self.by_colour(second - magnitude),
            Colour::Type(shape, name) => {
                let known = self.types.iter().position(|(known, _)| *known == name);
                let number = known.unwrap_or_else(|| {
                    self.types.push((name, shape));
                    self.types.len() - 1
                });
                (RUNGS + number, 0.0)
            }
        };
        let gain = 10f64.powf(-0.4 * magnitude);
        let next = if weight > 0.0 { first + 1 } else { first };
        self.stars.push(CatalogueStar { name, direction, shares: [(first, (1.0 - weight) * gain), (next, weight * gain)] });
    }

    /// A place on the ladder as a rung and a part of the way to the next; beyond its ends they are taken.
    fn between(&mut self, place: f64) -> (usize, f64) {
        let last = (RUNGS - 1) as f64;
        if !(0.0..=last).contains(&place) {
            self.beyond += 1;
        }
        let place = place.clamp(0.0, last);
        let first = (place as usize).min(RUNGS - 2);
        (first, place - first as f64)
    }

    /// The mixture whose second magnitude is fainter than the first by a number.
    fn by_colour(&mut self, fainter: f64) -> (usize, f64) {
        let Some((zero, rungs)) = &self.photometry.second else { return (0, 0.0) };
        let wanted = zero * 10f64.powf(-0.4 * fainter);
        // Hotter bodies are brighter on the blue side: one way along the ladder or the other.
        let between = |pair: &[f64]| (pair[0] - wanted) * (pair[1] - wanted) <= 0.0 && pair[0] != pair[1];
        match rungs.windows(2).position(between) {
            Some(i) => (i, (wanted - rungs[i]) / (rungs[i + 1] - rungs[i])),
            None => {
                let distance = |i: usize| (rungs[i] / wanted).ln().abs();
                let coolest = distance(0) < distance(RUNGS - 1);
                self.beyond += 1;
                if coolest { (0, 0.0) } else { (RUNGS - 2, 1.0) }
            }
        }
    }

    /// The catalogue: classes that no star has are left out.
    pub fn build(self, label: String) -> StarCatalogue {
        let Self { photometry, types, mut stars, beyond } = self;
        let ladder = (0..RUNGS).map(|i| (format!("{:.0} K", rung(i)), Arc::new(BlackBody(Temperature(rung(i)))) as Arc<dyn Shape>));
        let all: Vec<(String, Arc<dyn Shape>)> = ladder.chain(types).collect();
        let mut numbers: Vec<Option<usize>> = vec![None; all.len()];
        let mut classes = Vec::new();
        for (class, gain) in stars.iter_mut().flat_map(|star| &mut star.shares) {
            if *gain == 0.0 {
                *class = usize::MAX;
                continue;
            }
            let number = *numbers[*class].get_or_insert_with(|| {
                let (name, shape) = &all[*class];
                let scale = photometry.zero / photometry.band.integrate(|l| shape.at(l));
                classes
                    .push(StarClass { name: format!("catalogue stars of {name}"), spectrum: Spectrum::continuous(scale, shape.clone()) });
                classes.len() - 1
            });
            *class = number;
        }
        // A share of nothing is of any class.
        stars.iter_mut().flat_map(|star| &mut star.shares).filter(|(class, _)| *class == usize::MAX).for_each(|(class, _)| *class = 0);
        stars.sort_by(|a, b| b.gain().total_cmp(&a.gain()));
        StarCatalogue { label, classes, stars, beyond, hash: OnceLock::new() }
    }
}

impl StarCatalogue {
    /// Fingerprint of all stars, computed once.
    pub fn fingerprint(&self) -> Fingerprint {
        let computed = || {
            let mut digest = Digest::new("catalogue");
            digest.plain(&self.stars);
            for class in &self.classes {
                digest.part(class.spectrum.fingerprint());
            }
            digest.finish()
        };
        *self.hash.get_or_init(computed)
    }

    /// Notes in a picture.
    pub(crate) fn note(&self) -> String {
        let beyond = match self.beyond {
            0 => String::new(),
            some => format!("; {some} have colours outside of black bodies of {COOLEST} to {HOTTEST} K and use the nearest"),
        };
        format!("{} stars of {}{beyond}", self.stars.len(), self.label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flux(catalogue: &StarCatalogue, star: usize, band: &Passband) -> f64 {
        let flux = |(class, gain): &(usize, f64)| gain * band.integrate(|l| catalogue.classes[*class].spectrum.continuum(l));
        catalogue.stars[star].shares.iter().map(flux).sum()
    }

    /// Stars have the magnitudes that were said in both passbands, and black bodies of a temperature between two rungs nearly their colours.
    #[test]
    fn stars_have_their_magnitudes() {
        let named = |name: &str| Passband::by_name(name).unwrap();
        let (v, b) = (named("johnson-V"), named("johnson-B"));
        let system = MagnitudeSystem::Vega;
        let mut two = Builder::new(Photometry::new(named("johnson-V"), Some(&b), system).unwrap());
        for (magnitude, colour) in [(3.0, -0.1), (5.0, 0.0), (7.0, 0.65), (9.0, 1.5)] {
            two.add(String::new(), DVec3::X, magnitude, Colour::Magnitude(magnitude + colour));
        }
        // No black body is so blue.
        two.add("impossible".into(), DVec3::X, 12.0, Colour::Magnitude(10.0));
        let two = two.build("test".into());
        let magnitude = |flux: f64, band: &Passband| -2.5 * (flux / zero_point(band, system).unwrap()).log10();
        for (star, (wanted, colour)) in [(3.0, -0.1), (5.0, 0.0), (7.0, 0.65), (9.0, 1.5)].into_iter().enumerate() {
            assert!((magnitude(flux(&two, star, &v), &v) - wanted).abs() < 1e-9, "{star}");
            assert!((magnitude(flux(&two, star, &b), &b) - wanted - colour).abs() < 1e-9, "{star}");
        }
        assert_eq!((two.beyond, two.stars[4].name.as_str()), (1, "impossible"));
        assert!((magnitude(flux(&two, 4, &v), &v) - 12.0).abs() < 1e-9 && two.note().contains("1 have colours"));
        let mut warm = Builder::new(Photometry::new(named("johnson-V"), None, system).unwrap());
        warm.add(String::new(), DVec3::X, 4.0, Colour::Temperature(5772.0));
        let warm = warm.build("test".into());
        let sun = BlackBody(Temperature(5772.0));
        let wanted = b.integrate(|l| sun.at(l)) / v.integrate(|l| sun.at(l));
        assert!((flux(&warm, 0, &b) / flux(&warm, 0, &v) / wanted - 1.0).abs() < 5e-3);
        assert!(two.classes.len() <= 9 && warm.classes.len() == 2);
    }
}
