//! Light on its way from a star through gas, step by step, and the gas that it leaves behind.
//!
//! Steps are as short as light asks for: none takes more than a small part of what any node has left. Light that comes
//! into a step is what the step takes of it and what leaves it, whatever its depth.
//!
//! Light that recombinations make goes in all directions, and is carried outward along the star's rays. Where its free
//! path is long beside the distance r from the star it gets away; where it is short, what the gas around takes of it is
//! what it makes, but for a part of the order of (ℓ/r)². Both are had with an opacity of κ (1 + κ r/2), (G4) of docs/gas.md,
//! which is held to light in all directions (`Sphere::isotropic`). Photons are kept whatever the factor; beside a wall that
//! a far star shines on it is as if light stayed where it is made.

use spectra::constants::SPHERE;

use crate::atoms::{ELEMENTS, HYDROGEN_EV};
use crate::balance::{Accuracy, Gas, GasState, SLOPE};
use crate::emitted::EmittedLight;
use crate::light::{ByNode, IonisingLight, OWN_NODES};
use crate::packet::{Outcome, Packet, Trial};

/// The first step from the star itself, in parts of the way that there is \[1\].
const NEAREST: f64 = 1e-3;
/// Neutral fraction of hydrogen up to which gas counts as ionised \[1\].
const IONISED: f64 = 0.1;
/// Neutral fraction of hydrogen up to which gas is predicted to be ionised \[1\]. It is lower than [`IONISED`], so that a beam does not
/// try a block again after it has withdrawn from it.
const PREDICTED_IONISED: f64 = 0.05;
/// Fraction of the light below which neutral gas needs no voxels, as it can shine little \[1\].
const FAINT: f64 = 1e-3;

/// Light within a solid angle.
#[derive(Debug, Clone)]
pub struct Beam<'a> {
    light: &'a IonisingLight,
    accuracy: &'a Accuracy,
    /// The solid angle \[sr\].
    pub solid_angle: f64,
    /// Distance covered \[cm\].
    pub radius_cm: f64,
    /// Photons that are left, by node \[s⁻¹\].
    pub photons: ByNode,
    /// Ionising photons that there were at the star \[s⁻¹\].
    all: f64,
    /// The gas of the last step, and its light.
    near: NearGas,
    /// Length limit of the next step \[cm\].
    next_cm: f64,
    /// The step that it is at.
    attempt: Option<Attempt>,
    /// The gas's own light, where it is known already.
    field: Option<&'a EmittedLight>,
}

/// A step whose gas is not known yet.
#[derive(Debug, Clone, Copy)]
struct Attempt {
    trial: Trial,
    /// Upper limit of every step \[cm\].
    most_cm: f64,
    /// Ionising photons that come to it \[s⁻¹ cm⁻²\].
    flux: f64,
}

/// Gas that is near in what it is, whatever its density.
#[derive(Debug, Clone)]
struct NearGas {
    state: GasState,
    /// Nuclei of hydrogen \[cm⁻³\], and ionising photons \[s⁻¹ cm⁻²\].
    hydrogen: f64,
    flux: f64,
    /// Photons that it makes \[cm⁻³ s⁻¹\].
    emitted: [f64; OWN_NODES],
    /// Negative slope of heating over temperature.
    slope: f64,
}

impl NearGas {
    /// The gas of a step with a density of hydrogen \[cm⁻³\] under a flux of ionising photons \[s⁻¹ cm⁻²\].
    fn new(outcome: &Outcome, hydrogen: f64, flux: f64) -> Self {
        Self { state: outcome.state, hydrogen, flux, emitted: outcome.emitted, slope: outcome.slope }
    }

    /// Scaling of the gas to another density under a flux: there are as many times more electrons as
    /// it is denser, neutral parts are larger by that and by how much fainter the light is, light of recombinations is
    /// brighter by the square.
    fn at(&self, hydrogen: f64, flux: f64) -> (GasState, [f64; OWN_NODES]) {
        let denser = hydrogen / self.hydrogen;
        let fainter = if flux > 0.0 && self.flux > 0.0 { self.flux / flux } else { 1.0 };
        let mut state = self.state;
        state.electrons *= denser;
        for fractions in &mut state.fractions[..2] {
            let neutral = (fractions[0] * denser * fainter).min(0.5 + 0.5 * fractions[0]);
            let rest = (1.0 - neutral) / (1.0 - fractions[0]).max(1e-12);
            fractions.iter_mut().for_each(|part| *part *= rest);
            fractions[0] = neutral;
        }
        (state, self.emitted.map(|rate| rate * denser * denser))
    }
}

/// A step of a beam.
#[derive(Debug, Clone)]
pub struct BeamStep {
    /// Start \[cm\].
    pub inner_cm: f64,
    /// Its length \[cm\].
    pub thickness_cm: f64,
    /// The gas in it.
    pub state: GasState,
    /// Its depth by node \[1\].
    pub depths: ByNode,
    /// Photons that the gas makes \[cm⁻³ s⁻¹\].
    pub emitted: [f64; OWN_NODES],
    /// By how much the last pass still moved its temperature or ionisation \[1\].
    pub moved: f64,
}

impl BeamStep {
    /// Its volume within a solid angle \[cm³\].
    pub fn volume(&self, solid_angle: f64) -> f64 {
        shell(solid_angle, self.inner_cm, self.thickness_cm)
    }
}

/// The volume \[cm³\] of a part of a shell, given its solid angle, where it begins and how thick it is \[cm\].
pub fn shell(solid_angle: f64, inner: f64, thickness: f64) -> f64 {
    solid_angle * mean_square(inner, thickness) * thickness
}

/// The mean of the square of the radius over the way through a shell \[cm²\].
pub fn mean_square(inner: f64, thickness: f64) -> f64 {
    let outer = inner + thickness;
    (outer * outer + outer * inner + inner * inner) / 3.0
}

impl<'a> Beam<'a> {
    /// A star's light within a solid angle \[sr\] at a distance from it \[cm\], where it meets gas first.
    pub fn new(light: &'a IonisingLight, accuracy: &'a Accuracy, solid_angle: f64, radius_cm: f64) -> Self {
        let part = solid_angle / SPHERE;
        Self::bringing(light.photons.map(|photons| photons * part), light, accuracy, (solid_angle, radius_cm))
    }

    /// Photons by node \[s⁻¹\] within a solid angle \[sr\], at a distance from where they come from \[cm\].
    pub fn bringing(photons: ByNode, light: &'a IonisingLight, accuracy: &'a Accuracy, (solid_angle, radius_cm): (f64, f64)) -> Self {
        let mut state = GasState::neutral(&Gas::new(1.0, [1.0; ELEMENTS]));
        state.temperature = 8000.0;
        state.electrons = 1.0;
        for fractions in &mut state.fractions[..2] {
            (fractions[0], fractions[1]) = (1e-3, 0.999);
        }
        Self {
            light,
            accuracy,
            solid_angle,
            radius_cm,
            photons,
            all: light.ionising_of(&photons),
            near: NearGas { state, hydrogen: 1.0, flux: 0.0, emitted: [0.0; OWN_NODES], slope: SLOPE },
            next_cm: f64::INFINITY,
            attempt: None,
            field: None,
        }
    }

    /// Has the gas's own light be one that is known, in place of what the beam carries outward.
    #[must_use]
    pub fn under(mut self, field: &'a EmittedLight) -> Self {
        self.field = Some(field);
        self
    }

    /// Has the beam meet first what another one met last, or gas like it.
    pub fn near_to(&mut self, other: &Self) {
        self.near = other.near.clone();
    }

    /// A part of the beam, within a part of its solid angle.
    #[must_use]
    pub fn part(&self, part: f64) -> Self {
        let photons = self.photons.map(|photons| photons * part);
        Self { solid_angle: self.solid_angle * part, all: self.all * part, photons, ..self.clone() }
    }

    /// The part of its ionising photons that is left \[1\].
    pub fn left(&self) -> f64 {
        if self.all > 0.0 { self.light.ionising_of(&self.photons) / self.all } else { 0.0 }
    }

    /// True if the beam has met no gas yet.
    pub fn is_fresh(&self) -> bool {
        self.near.flux <= 0.0
    }

    /// True if next to nothing of the light is left.
    pub fn is_used_up(&self) -> bool {
        self.light.ionising_of(&self.photons) <= self.accuracy.used_up * self.all
    }

    /// True if a length \[cm\] of gas with a density of hydrogen \[cm⁻³\] is expected to need no voxels: it is transparent, and almost
    /// completely ionised or, where the beam crosses a whole block, faint. A beam that has met no gas yet expects this of any gas that is
    /// not too near to the star.
    pub fn expects_thin(&self, hydrogen: f64, length_cm: f64, is_whole: bool) -> bool {
        if length_cm > self.accuracy.thickness * self.radius_cm {
            return false;
        }
        if self.is_fresh() || hydrogen <= 0.0 {
            return true;
        }
        let flux = self.light.ionising_of(&self.photons) / (self.solid_angle * mean_square(self.radius_cm, length_cm));
        let denser = hydrogen / self.near.hydrogen;
        let is_ionised = self.near.state.fractions[0][0] * denser * self.near.flux <= PREDICTED_IONISED * flux;
        (is_ionised || is_whole && self.left() <= FAINT) && length_cm * denser * denser <= self.next_cm
    }

    /// Withdraws from a step in a block whose gas needs voxels, given the block's largest density relative to that of the step, and its
    /// longest chord \[cm\]; true then. The beam remembers the gas.
    pub fn withdraws(&mut self, (packet, lane): (&mut Packet, usize), contrast: f64, length_cm: f64) -> bool {
        let Some(Attempt { trial, flux, .. }) = self.attempt else { return false };
        let deepest = self.deepest(&packet.depths(lane));
        let is_ionised = packet.neutral(lane) * contrast <= IONISED;
        if (is_ionised || self.left() <= FAINT) && deepest * length_cm <= self.accuracy.depth * trial.thickness {
            return false;
        }
        let outcome = packet.end(lane);
        self.near = NearGas::new(&outcome, trial.hydrogen, flux);
        self.next_cm = trial.thickness * self.accuracy.depth / deepest.max(1e-12);
        self.attempt = None;
        true
    }

    /// Begins the next step in a lane: at most a given length \[cm\] through a gas.
    pub fn begin(&mut self, (packet, lane): (&mut Packet, usize), gas: &Gas, most_cm: f64) {
        // What is neutral goes by the square of the density.
        self.next_cm *= (self.near.hydrogen / gas.hydrogen).powi(2).clamp(1e-6, 1e6);
        self.attempt((packet, lane), (gas.hydrogen, gas.hydrogen * gas.dust_cm2), most_cm);
    }

    fn attempt(&mut self, (packet, lane): (&mut Packet, usize), (hydrogen, dust): (f64, f64), most_cm: f64) {
        let longest = if self.radius_cm > 0.0 { self.accuracy.thickness * self.radius_cm } else { NEAREST * most_cm };
        let thickness = self.next_cm.min(most_cm).min(longest);
        let inner = self.radius_cm;
        let area = self.solid_angle * mean_square(inner, thickness);
        let flux = self.light.ionising_of(&self.photons) / area;
        let (state, rates) = self.near.at(hydrogen, flux);
        let known = self.field.map(|field| field.at(inner + 0.5 * thickness));
        let trial = Trial { hydrogen, dust, inner, thickness, area, state, emitted: rates, slope: self.near.slope, known };
        packet.begin(lane, &self.photons, &trial);
        self.attempt = Some(Attempt { trial, most_cm, flux });
    }

    /// Ends a step that has settled, and has its light go on; where it was too deep it has begun anew, shorter, and there is
    /// none yet.
    pub fn end(&mut self, (packet, lane): (&mut Packet, usize)) -> Option<BeamStep> {
        let Attempt { trial, most_cm, flux } = self.attempt.take()?;
        let Trial { hydrogen, dust, thickness, area, .. } = trial;
        let outcome = packet.end(lane);
        self.near = NearGas::new(&outcome, hydrogen, flux);
        let deepest = self.deepest(&outcome.depths);
        if deepest > 2.0 * self.accuracy.depth {
            self.next_cm = thickness * (self.accuracy.depth / deepest).clamp(1e-2, 0.5);
            self.attempt((packet, lane), (hydrogen, dust), most_cm);
            return None;
        }
        for (node, photons) in self.photons.iter_mut().enumerate() {
            let made =
                if node < OWN_NODES && self.field.is_none() { outcome.emitted[node] * area * thickness * outcome.means[node] } else { 0.0 };
            *photons = *photons * outcome.left[node] + made;
        }
        let step = BeamStep {
            inner_cm: self.radius_cm,
            thickness_cm: thickness,
            state: outcome.state,
            depths: outcome.depths,
            emitted: outcome.emitted,
            moved: outcome.moved,
        };
        self.radius_cm += thickness;
        let longer = self.accuracy.depth / deepest.max(1e-12);
        // Where the end of the way cut it short, not its depth, the next may be as long as depth lets it be.
        self.next_cm = thickness * if thickness == most_cm { longer.max(0.5) } else { longer.clamp(0.5, 1.5) };
        Some(step)
    }

    /// The largest depth at a node of the star's that has light.
    fn deepest(&self, depths: &ByNode) -> f64 {
        let nodes = self.light.energies_ev.iter().zip(depths).zip(&self.photons).skip(OWN_NODES);
        let counts = nodes.filter(|((e, _), photons)| **photons > self.accuracy.counts * self.all && **e > HYDROGEN_EV);
        counts.map(|((_, depth), _)| *depth).fold(0.0, f64::max)
    }
}
