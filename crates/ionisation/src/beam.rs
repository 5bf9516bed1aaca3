//! Light on its way from a star through gas, step by step, and the gas that it leaves behind.
//!
//! Steps are as short as light asks for: none takes more than a small part of what any node has left. Light that comes
//! into a step is what the step takes of it and what leaves it, whatever its depth.
//!
//! Light that recombinations make goes in all directions. Outward it comes as far as it does in the mean: photons with a
//! free path ℓ move from a distance r of the star to r + ℓ²/3r where ℓ ≪ r, and by ℓ where ℓ ≫ r, so their depth along
//! the way outward is that of κ (1 + 3 κ r).

use crate::balance::{Accuracy, Balance, Diffuse, Gas, Photo, State, Thermostat};
use crate::light::{ABSORBERS, IonisingLight};

/// Where light is taken to be used up, in parts of all of it \[1\].
const USED_UP: f64 = 1e-5;
/// Light of a node that counts for steps, in parts of all of it \[1\].
const COUNTS: f64 = 1e-6;
/// The first step from the star itself, in parts of the way that there is \[1\].
const NEAREST: f64 = 1e-3;
/// Passes over a step, whose light depends on what it is.
const PASSES: usize = 300;

/// Light within a solid angle.
#[derive(Debug, Clone)]
pub struct Beam<'a> {
    light: &'a IonisingLight,
    diffuse: Diffuse,
    accuracy: &'a Accuracy,
    /// The solid angle \[sr\].
    pub solid_angle: f64,
    /// How far it has come \[cm\].
    pub radius_cm: f64,
    /// Photons that are left, by node \[s⁻¹\].
    pub photons: Vec<f64>,
    /// Ionising photons that there were at the star \[s⁻¹\].
    all: f64,
    /// The gas of the last step.
    near: State,
    /// How long the next step may be \[cm\].
    next_cm: f64,
}

/// A step of a beam.
#[derive(Debug, Clone)]
pub struct Step {
    /// Where it begins \[cm\].
    pub inner_cm: f64,
    /// Its length \[cm\].
    pub thickness_cm: f64,
    /// The gas in it.
    pub state: State,
}

impl Step {
    /// Its volume within a solid angle \[cm³\].
    pub fn volume(&self, solid_angle: f64) -> f64 {
        let outer = self.inner_cm + self.thickness_cm;
        solid_angle / 3.0 * (outer.powi(3) - self.inner_cm.powi(3))
    }
}

impl<'a> Beam<'a> {
    /// A star's light within a solid angle \[sr\] at a distance from it \[cm\], where it meets gas first.
    pub fn new(light: &'a IonisingLight, diffuse: Diffuse, accuracy: &'a Accuracy, solid_angle: f64, radius_cm: f64) -> Self {
        let part = solid_angle / spectra::constants::SPHERE;
        let photons: Vec<f64> = light.photons.iter().map(|photons| photons * part).collect();
        let mut near = State::neutral(&Gas::new(1.0, [1.0; 7]));
        near.temperature = 8000.0;
        near.fractions[0] = [1e-3, 0.999, 0.0, 0.0, 0.0, 0.0];
        near.fractions[1] = [1e-3, 0.999, 0.0, 0.0, 0.0, 0.0];
        near.electrons = 1.0;
        Self { light, diffuse, accuracy, solid_angle, radius_cm, photons, all: light.ionising() * part, near, next_cm: f64::INFINITY }
    }

    /// A part of the beam, within a part of its solid angle.
    #[must_use]
    pub fn part(&self, part: f64) -> Self {
        let photons = self.photons.iter().map(|photons| photons * part).collect();
        Self { solid_angle: self.solid_angle * part, all: self.all * part, photons, ..self.clone() }
    }

    /// Whether next to nothing of the light is left.
    pub fn is_used_up(&self) -> bool {
        let left = self.photons.iter().zip(&self.light.energies_ev).filter(|(_, e)| **e > crate::atoms::HYDROGEN_EV);
        left.map(|(photons, _)| photons).sum::<f64>() <= USED_UP * self.all
    }

    /// The next step through gas, of at most so many cm.
    pub fn step(&mut self, gas: &Gas, most_cm: f64) -> Step {
        // From gas of another density the state is taken over as it is, but for the electrons.
        self.near.electrons = gas.hydrogen * self.near.fractions[0][1].max(1e-6);
        loop {
            let longest = if self.radius_cm > 0.0 { self.accuracy.thickness * self.radius_cm } else { NEAREST * most_cm };
            let thickness = self.next_cm.min(most_cm).min(longest);
            let settled = self.settled(gas, thickness);
            let deepest = settled.deepest(self);
            if deepest > 2.0 * self.accuracy.depth {
                self.next_cm = 0.5 * thickness;
                self.near = settled.state;
                continue;
            }
            let left = |node: usize, came: f64| came * (-settled.depths[node]).exp() + settled.own[node] * mean(settled.depths[node]);
            self.photons.iter_mut().enumerate().for_each(|(node, photons)| *photons = left(node, *photons));
            let step = Step { inner_cm: self.radius_cm, thickness_cm: thickness, state: settled.state };
            self.near = step.state;
            self.radius_cm += thickness;
            self.next_cm = thickness * (self.accuracy.depth / deepest.max(1e-12)).clamp(0.5, 1.5);
            if thickness == most_cm && deepest < self.accuracy.depth {
                // The end of the way cut it short, not its depth.
                self.next_cm = self.next_cm.max(thickness * self.accuracy.depth / deepest.max(1e-12));
            }
            return step;
        }
    }

    /// The state of a step, its depth at each node, and the photons that it makes itself \[s⁻¹\], under light that its own
    /// gas weakens.
    fn settled(&self, gas: &Gas, thickness: f64) -> Settled {
        let (inner, outer, nodes) = (self.radius_cm, self.radius_cm + thickness, self.photons.len());
        let area = self.solid_angle / 3.0 * (outer * outer + outer * inner + inner * inner);
        let mut settled = Settled { state: self.near, depths: vec![0.0; nodes], own: vec![0.0; nodes] };
        let mut flux = vec![0.0; nodes];
        let mut thermostat = Thermostat::default();
        if let Some(temperature) = gas.isothermal {
            settled.state.temperature = temperature;
        }
        for _ in 0..PASSES {
            let absorbers = ABSORBERS.map(|(element, charge)| settled.state.density(gas, element, charge));
            for node in 0..nodes {
                let opacity = self.light.opacity(absorbers, node) + gas.hydrogen * gas.dust_cm2;
                // How much longer ways are than the way outward.
                let detour = if self.light.own().contains(&node) { 1.0 + 3.0 * opacity * inner } else { 1.0 };
                let depth = thickness * opacity * detour;
                // Of light that comes, and of light that is made all along the way.
                flux[node] = detour * (self.photons[node] * mean(depth) + settled.own[node] * mean_of_own(depth)) / area;
                settled.depths[node] = depth;
            }
            let (photo, before) = (Photo::new(self.light, &flux), settled.state);
            let coefficients = self.accuracy.coefficients(before.temperature);
            let balance = Balance { gas, photo: &photo, diffuse: self.diffuse, coefficients: &coefficients };
            let excess = balance.pass(&mut settled.state);
            let made = balance.own_light(&settled.state);
            self.light.own().zip(made).for_each(|(node, made)| settled.own[node] = made * area * thickness);
            if gas.isothermal.is_none() {
                settled.state.temperature = thermostat.next(before.temperature, excess);
            }
            let moved = |value: fn(&State) -> f64| (value(&settled.state) / value(&before) - 1.0).abs();
            // Where hardly any light is taken the gas does not change it.
            let neutral = moved(|state| state.fractions[0][0]).max(moved(|state| state.fractions[1][0]));
            let all = moved(|state| state.temperature).max(moved(|state| state.electrons)).max(neutral);
            if all < self.accuracy.settled {
                break;
            }
        }
        settled
    }
}

struct Settled {
    state: State,
    depths: Vec<f64>,
    own: Vec<f64>,
}

impl Settled {
    /// The largest depth at a node of the star's that has light.
    fn deepest(&self, beam: &Beam) -> f64 {
        let nodes = (0..beam.light.own().start)
            .filter(|node| beam.photons[*node] > COUNTS * beam.all && beam.light.energies_ev[*node] > crate::atoms::HYDROGEN_EV);
        nodes.map(|node| self.depths[node]).fold(0.0, f64::max)
    }
}

/// The mean of e^(−x) from zero to a depth.
fn mean(depth: f64) -> f64 {
    if depth > 0.1 {
        -(-depth).exp_m1() / depth
    } else {
        // Its series, right to 1e-10.
        1.0 - depth / 2.0 * (1.0 - depth / 3.0 * (1.0 - depth / 4.0 * (1.0 - depth / 5.0 * (1.0 - depth / 6.0 * (1.0 - depth / 7.0)))))
    }
}

/// The mean along the way of light that is made evenly along it, in parts of all of it.
fn mean_of_own(depth: f64) -> f64 {
    if depth > 1e-4 { (1.0 - mean(depth)) / depth } else { 0.5 - depth / 6.0 }
}
