//! Certificates of pictures of plates: of bands as wholes, and of each pixel.
//!
//! A light is off by what nodes, components and stored numbers cost, all of which are parts of what it leaves at the least extinction,
//! G(k_0), or less: with ε the largest of them over all depths, no pixel of it is off by more than ε G(k_0), which its plate has. Light that
//! scatters again is no sum of exponentials: of it both are estimates.

use spectra::components::Components;
use spectra::rule::{Certificate, Measure, Node};

use super::mixture::{self, Share};
use super::{LEVELS, Mixture, Plate, PlateLight, Plates, times};
use crate::light::Route;

/// Depths at which the change by rounded depths is looked at, and what it may be more between them.
const SAMPLES: usize = 128;
const MARGIN: f64 = 1.05;

/// A light in a band behind depths, as its plate has it.
struct Behind<'a> {
    plate: &'a Plate,
    nodes: &'a [Node],
    part: &'a PlateLight,
    /// Weights of the mean and of each component.
    of_mean: f64,
    shares: Vec<f64>,
    /// The largest depth \[1\].
    depth: f64,
    scatters_again: bool,
}

/// Light under an angle, and the phase function by node, in parts of that of the first.
struct Angle<'a> {
    measure: Measure,
    factor: Box<dyn Fn(&Node) -> f64 + 'a>,
}

impl Behind<'_> {
    /// Behind a depth, in parts of what is left at k_0; `factor` is that of the phase function by node, one at the first.
    fn in_parts(&self, a: f64, factor: &dyn Fn(&Node) -> f64) -> f64 {
        let parts = self.nodes.iter().map(|node| factor(node) * (-a * (node.k - self.nodes[0].k)).exp());
        if self.scatters_again {
            return self.part.weights.iter().zip(parts).map(|(w, left)| w * left).sum();
        }
        let coordinates = self.plate.components.coordinates(&parts.collect::<Vec<f64>>());
        self.of_mean + self.shares.iter().zip(coordinates).map(|(share, c)| share * c).sum::<f64>()
    }

    /// Storage error relative to G(k_0).
    fn stored(&self) -> f64 {
        let Plate { components, .. } = self.plate;
        // Of light that scatters again components are those of the picture itself, and their error was measured at the nodes.
        let again = if self.scatters_again { components.error * self.part.weights.iter().map(|w| w.abs()).sum::<f64>() } else { 0.0 };
        steps(components, &self.shares) + again
    }

    /// Its light under each angle of scattering.
    fn under_angles<'b>(&'b self, mixture: &'b Mixture) -> impl Iterator<Item = Angle<'b>> {
        let measure = &self.part.source.measure;
        let plain = Angle { measure: measure.clone(), factor: Box::new(|_| 1.0) };
        let scattered = matches!(self.plate.route, Route::Scattered { .. }) && !self.scatters_again;
        let under = move |factor: &'b super::PhaseFactor| {
            let first = factor(self.nodes[0].lambda_um);
            Angle {
                measure: measure.reweighted(|lambda| factor(lambda) / first),
                factor: Box::new(move |node| factor(node.lambda_um) / first),
            }
        };
        std::iter::once(plain).chain(mixture.phases.iter().filter(move |_| scattered).map(under))
    }

    /// The certificate of the light.
    fn certified(&self, mixture: &Mixture) -> Certificate {
        let (measure, k_0) = (&self.part.source.measure, self.nodes[0].k);
        let errors = self.under_angles(mixture).map(|Angle { measure, factor }| {
            Certificate::measured(&measure, |a| (-a * k_0).exp() * self.in_parts(a, &*factor), self.depth)
        });
        let none = Certificate { absolute: 0.0, relative: 0.0, depth: self.depth };
        let worst = errors.fold(none, Certificate::or_worse).rounded(measure, self.plate.rounding, |_| 0.0);
        let parts = |a: f64, total: f64| self.stored() * (-k_0 * a).exp() / total.max(f64::MIN_POSITIVE);
        Certificate {
            absolute: worst.absolute + parts(0.0, measure.total()),
            // k_0 is the least extinction: light falls faster than the error.
            relative: worst.relative + parts(worst.depth, measure.at(worst.depth)),
            ..worst
        }
    }

    /// ε: by how much it may be wrong in any pixel, in parts of G(k_0).
    fn error(&self, mixture: &Mixture) -> f64 {
        let k_0 = self.nodes[0].k;
        let errors = self.under_angles(mixture).map(|Angle { measure, factor }| {
            // F(a) e^(a k_0), which is F of extinctions less k_0.
            let beyond = Measure { k: measure.k.iter().map(|k| k - k_0).collect(), ..measure };
            beyond.total() * Certificate::measured(&beyond, |a| self.in_parts(a, &*factor), self.depth).absolute
        });
        // A relative error of the depth changes F(a) by a |F′(a)|.
        let measure = self.part.source.measure.condensed(self.depth);
        let change = |a: f64| measure.k.iter().zip(&measure.mass).map(|(k, mass)| mass * a * k * (-a * (k - k_0)).exp()).sum::<f64>();
        let depths = (0..=SAMPLES).map(|i| self.depth * (i as f64 / SAMPLES as f64).powi(2));
        let rounding =
            self.plate.rounding.light * measure.total() + self.plate.rounding.depth * MARGIN * depths.map(change).fold(0.0, f64::max);
        errors.fold(0.0, f64::max) + self.stored() + rounding
    }
}

impl Plates {
    /// A light of a mixture's band, where it has a plate.
    fn behind<'a>(&'a self, mixture: &'a Mixture, part: &'a PlateLight) -> Option<Behind<'a>> {
        let plate = &self.0.plates[part.plate?];
        let (of_mean, shares) = plate.components.shares(&part.weights);
        let (depth, scatters_again) = (self.0.depth * mixture.amount, self.0.scatters_again);
        Some(Behind { plate, nodes: &mixture.nodes, part, of_mean, shares, depth, scatters_again })
    }

    /// The certificates of a mixture's band, by the numbers of the lights that shine in it: nodes, components, and numbers as they
    /// are stored.
    pub fn certificates(&self, mixture: &Mixture, band: usize) -> Vec<(usize, Certificate)> {
        let certified = |part: &PlateLight| {
            let of_point = || {
                let left = |a: f64| mixture.nodes.iter().map(move |node| (-a * node.k).exp());
                let interpolated = |a: f64| part.weights.iter().zip(left(a)).map(|(w, left)| w * left).sum();
                Certificate::measured(&part.source.measure, interpolated, self.0.depth * mixture.amount)
            };
            (part.light, self.behind(mixture, part).map_or_else(of_point, |mixed| mixed.certified(mixture)))
        };
        mixture.parts[band].iter().filter(|part| part.source.measure.total() > 0.0).map(certified).collect()
    }

    /// By how much the extended light of a mixture may be wrong at most in each pixel, bands × height × width [W m⁻² sr⁻¹]: far less
    /// than a [certificate](Self::certificates) says of the darkest of all depths, of which a pixel may have none.
    pub fn errors(&self, mixture: &Mixture) -> Vec<f32> {
        let of_plate = |plate: usize, parts: &[PlateLight]| {
            let behind = parts.iter().find(|part| part.plate == Some(plate)).and_then(|part| self.behind(mixture, part));
            let of_mean = behind.map_or(0.0, |mixed| mixed.error(mixture) * times(mixture.amount, mixed.plate.route));
            Share { of_mean, of_coordinate: vec![0.0; self.0.plates[plate].components.axes.len()] }
        };
        let shares: Vec<Vec<Share>> =
            (0..self.0.plates.len()).map(|plate| mixture.parts.iter().map(|parts| of_plate(plate, parts)).collect()).collect();
        let pixels = self.0.size[0] * self.0.size[1];
        let mut errors = vec![0.0; pixels * mixture.parts.len()];
        mixture::add(&self.0.plates, &shares, pixels, &mut errors);
        errors
    }
}

/// Half a step of each coordinate, times what a light takes of it.
fn steps(components: &Components, shares: &[f64]) -> f64 {
    shares.iter().zip(&components.ranges).map(|(share, [low, high])| 0.5 * share.abs() * (high - low) / f64::from(LEVELS)).sum()
}
