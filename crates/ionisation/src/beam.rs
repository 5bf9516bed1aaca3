//! Light on its way from a star through gas, step by step, and the gas that it leaves behind.
//!
//! Steps are as short as light asks for: none takes more than a small part of what any node has left. Light that comes
//! into a step is what the step takes of it and what leaves it, whatever its depth.
//!
//! Light that recombinations make goes in all directions, and is carried outward along the star's rays. Where its free
//! path is long beside the distance r from the star it gets away; where it is short, what the gas around takes of it is
//! what it makes, but for a part (ℓ/r)². Both are had with an opacity of κ (1 + 3 κ r), (G4) of docs/gas.md. Photons are
//! kept whatever the factor; beside a wall that a far star shines on it is as if light stayed where it is made.

use multiversion::multiversion;
use spectra::constants::SPHERE;

use crate::atoms::{ELEMENTS, HYDROGEN_EV};
use crate::balance::{Accuracy, Balance, Diffuse, Gas, Photo, State, Thermostat};
use crate::light::{ABSORBERS, ByNode, IonisingLight, NODES, OWN_NODES};

/// The first step from the star itself, in parts of the way that there is \[1\].
const NEAREST: f64 = 1e-3;
/// Passes in which what light and metals do to each other is made anew: what came before may have been neutral.
const OF_METALS: usize = 2;
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
    pub photons: ByNode,
    /// Ionising photons that there were at the star \[s⁻¹\].
    all: f64,
    /// The gas of the last step, and its light.
    near: Near,
    /// How long the next step may be \[cm\].
    next_cm: f64,
}

/// Gas that is near in what it is, whatever its density.
#[derive(Debug, Clone)]
struct Near {
    state: State,
    /// Nuclei of hydrogen \[cm⁻³\], and ionising photons \[s⁻¹ cm⁻²\].
    hydrogen: f64,
    flux: f64,
    /// Photons that it makes \[cm⁻³ s⁻¹\].
    own: [f64; OWN_NODES],
    thermostat: Thermostat,
}

impl Near {
    /// What gas of another density is under a flux, as far as these alone tell: there are as many times more electrons as
    /// it is denser, neutral parts are larger by that and by how much fainter the light is, light of recombinations is
    /// brighter by the square.
    fn at(&self, gas: &Gas, flux: f64) -> (State, [f64; OWN_NODES]) {
        let denser = gas.hydrogen / self.hydrogen;
        let fainter = if flux > 0.0 && self.flux > 0.0 { self.flux / flux } else { 1.0 };
        let mut state = self.state;
        state.electrons *= denser;
        for fractions in &mut state.fractions[..2] {
            let neutral = (fractions[0] * denser * fainter).min(0.5 + 0.5 * fractions[0]);
            let rest = (1.0 - neutral) / (1.0 - fractions[0]).max(1e-12);
            fractions.iter_mut().for_each(|part| *part *= rest);
            fractions[0] = neutral;
        }
        (state, self.own.map(|own| own * denser * denser))
    }
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
    /// The beam's flux of photons by node, its mean along the step \[s⁻¹ cm⁻²\].
    pub light: ByNode,
    /// The beam's part in what ionises hydrogen there \[1\].
    pub share: f64,
    /// By how much the last pass still moved its temperature or ionisation \[1\].
    pub moved: f64,
}

impl Step {
    /// Its volume within a solid angle \[cm³\].
    pub fn volume(&self, solid_angle: f64) -> f64 {
        let (inner, outer) = (self.inner_cm, self.inner_cm + self.thickness_cm);
        solid_angle / 3.0 * (outer * outer + outer * inner + inner * inner) * self.thickness_cm
    }
}

impl<'a> Beam<'a> {
    /// A star's light within a solid angle \[sr\] at a distance from it \[cm\], where it meets gas first.
    pub fn new(light: &'a IonisingLight, diffuse: Diffuse, accuracy: &'a Accuracy, solid_angle: f64, radius_cm: f64) -> Self {
        let part = solid_angle / SPHERE;
        let mut state = State::neutral(&Gas::new(1.0, [1.0; ELEMENTS]));
        state.temperature = 8000.0;
        state.electrons = 1.0;
        for fractions in &mut state.fractions[..2] {
            (fractions[0], fractions[1]) = (1e-3, 0.999);
        }
        Self {
            light,
            diffuse,
            accuracy,
            solid_angle,
            radius_cm,
            photons: light.photons.map(|photons| photons * part),
            all: light.ionising() * part,
            near: Near { state, hydrogen: 1.0, flux: 0.0, own: [0.0; OWN_NODES], thermostat: Thermostat::default() },
            next_cm: f64::INFINITY,
        }
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

    /// Whether next to nothing of the light is left.
    pub fn is_used_up(&self) -> bool {
        self.light.ionising_of(&self.photons) <= self.accuracy.used_up * self.all
    }

    /// The next step through gas, of at most so many cm; `background` is the flux of photons by node of all other stars
    /// \[s⁻¹ cm⁻²\].
    pub fn step(&mut self, gas: &Gas, background: &ByNode, most_cm: f64) -> Step {
        // What is neutral goes by the square of the density.
        self.next_cm *= (self.near.hydrogen / gas.hydrogen).powi(2).clamp(1e-6, 1e6);
        loop {
            let longest = if self.radius_cm > 0.0 { self.accuracy.thickness * self.radius_cm } else { NEAREST * most_cm };
            let thickness = self.next_cm.min(most_cm).min(longest);
            let settled = self.settled(gas, background, thickness);
            let (flux, own, thermostat) = (settled.flux, settled.own, settled.thermostat);
            self.near = Near { state: settled.state, hydrogen: gas.hydrogen, flux, own, thermostat };
            let deepest = self.deepest(&settled.depths);
            if deepest > 2.0 * self.accuracy.depth {
                self.next_cm = thickness * (self.accuracy.depth / deepest).clamp(1e-2, 0.5);
                continue;
            }
            let volume = settled.area * thickness;
            for node in 0..NODES {
                let made = if node < OWN_NODES { settled.own[node] * volume * settled.means[node] } else { 0.0 };
                self.photons[node] = self.photons[node] * (1.0 - settled.depths[node] * settled.means[node]).max(0.0) + made;
            }
            let Settled { state, light, share, moved, .. } = settled;
            let step = Step { inner_cm: self.radius_cm, thickness_cm: thickness, state, light, share, moved };
            self.radius_cm += thickness;
            let longer = self.accuracy.depth / deepest.max(1e-12);
            // Where the end of the way cut it short, not its depth, the next may be as long as depth lets it be.
            self.next_cm = thickness * if thickness == most_cm { longer.max(0.5) } else { longer.clamp(0.5, 1.5) };
            return step;
        }
    }

    /// The largest depth at a node of the star's that has light.
    fn deepest(&self, depths: &ByNode) -> f64 {
        let nodes = self.light.energies_ev.iter().zip(depths).zip(&self.photons).skip(OWN_NODES);
        let counts = nodes.filter(|((e, _), photons)| **photons > self.accuracy.counts * self.all && **e > HYDROGEN_EV);
        counts.map(|((_, depth), _)| *depth).fold(0.0, f64::max)
    }

    /// The state of a step under light that its own gas weakens.
    fn settled(&self, gas: &Gas, background: &ByNode, thickness: f64) -> Settled {
        let (inner, outer) = (self.radius_cm, self.radius_cm + thickness);
        let area = self.solid_angle / 3.0 * (outer * outer + outer * inner + inner * inner);
        let flux = self.light.ionising_of(&self.photons) / area + self.light.ionising_of(background);
        let (state, own) = self.near.at(gas, flux);
        let thermostat = self.near.thermostat.elsewhere();
        let (depths, means, light) = ([0.0; NODES], [1.0; NODES], [0.0; NODES]);
        let mut settled = Settled { state, own, depths, means, area, flux, thermostat, light, share: 1.0, moved: 0.0 };
        let dust = gas.hydrogen * gas.dust_cm2;
        let mut others = [dust; NODES];
        let mut photo = Photo::new(self.light, &[0.0; NODES]);
        if let Some(temperature) = gas.isothermal {
            settled.state.temperature = temperature;
        }
        let mut coefficients = self.accuracy.coefficients(settled.state.temperature);
        let mut is_last = false;
        for pass in 0..PASSES {
            // Metals take little, and what they are follows from the light: between the first passes and the last they stay
            // as they are, but for a reference.
            let has_metals = pass < OF_METALS || is_last || self.accuracy.is_exact;
            if has_metals {
                let metals = self.light.of_metals(|element, charge| settled.state.density(gas, element, charge));
                others = metals.map(|opacity| opacity + dust);
            }
            let absorbers = ABSORBERS.map(|(element, charge)| settled.state.density(gas, element, charge));
            let way = Way { thickness, inner, others: &others };
            weaken(&self.light.weakening, absorbers, &way, [&mut settled.depths, &mut settled.means]);
            let mut flux: ByNode = std::array::from_fn(|node| self.photons[node] * settled.means[node] / area);
            // Of light that is made all along the way, and whose own is longer.
            for node in 0..OWN_NODES {
                let depth = settled.depths[node];
                let made = settled.own[node] * thickness * if depth > 1e-4 { (1.0 - settled.means[node]) / depth } else { 0.5 };
                let opacity = (self.light.opacity(absorbers, node) + others[node]).max(0.0);
                flux[node] = (flux[node] + made) * detour(opacity, inner);
            }
            let all: ByNode = std::array::from_fn(|node| flux[node] + background[node]);
            let rate = |flux: &ByNode| flux.iter().zip(&self.light.weakening[0]).map(|(flux, sigma)| flux * sigma).sum::<f64>();
            settled.share = rate(&flux) / rate(&all).max(f64::MIN_POSITIVE);
            settled.light = flux;
            if has_metals {
                photo = Photo::new(self.light, &all);
            } else {
                photo.renew(self.light, &all);
            }
            let before = settled.state;
            self.accuracy.renew(&mut coefficients, before.temperature);
            let balance = Balance { gas, photo: &photo, diffuse: self.diffuse, coefficients: &coefficients };
            let excess = balance.pass(&mut settled.state);
            // Each star's light takes its part of it along.
            settled.own = balance.own_light(&settled.state).map(|own| own * settled.share);
            if gas.isothermal.is_none() {
                settled.state.temperature = settled.thermostat.next(before.temperature, excess);
            }
            let moved = |value: fn(&State) -> f64| (value(&settled.state) / value(&before) - 1.0).abs();
            let neutral = moved(|state| state.fractions[0][0]).max(moved(|state| state.fractions[1][0]));
            let all = moved(|state| state.temperature).max(moved(|state| state.electrons)).max(neutral);
            settled.moved = all;
            if is_last || all < self.accuracy.settled && pass + 1 >= OF_METALS && has_metals {
                break;
            }
            is_last = all < self.accuracy.settled && pass + 1 >= OF_METALS;
        }
        settled
    }
}

struct Settled {
    state: State,
    /// Photons that it makes \[cm⁻³ s⁻¹\].
    own: [f64; OWN_NODES],
    /// Its depth at each node, and the mean of what is left along it \[1\].
    depths: ByNode,
    means: ByNode,
    /// Its mean cross section \[cm²\], and the ionising photons that come to it \[s⁻¹ cm⁻²\].
    area: f64,
    flux: f64,
    thermostat: Thermostat,
    /// The flux of the beam by node \[s⁻¹ cm⁻²\], and its part in what ionises hydrogen \[1\].
    light: ByNode,
    share: f64,
    /// By how much the last pass still moved anything \[1\].
    moved: f64,
}

/// A step's length, where it begins \[cm\], and the opacity of its dust and metals by node \[cm⁻¹\].
struct Way<'a> {
    thickness: f64,
    inner: f64,
    others: &'a ByNode,
}

/// How much longer the ways of the gas's own light are than the way outward.
#[inline(always)]
fn detour(opacity: f64, radius: f64) -> f64 {
    1.0 + 3.0 * opacity * radius
}

/// Depths along a way, and the means of e^(−x) from zero to them.
#[multiversion(targets = "simd")]
fn weaken(weakening: &[ByNode; ABSORBERS.len()], densities: [f64; ABSORBERS.len()], way: &Way, [depths, means]: [&mut ByNode; 2]) {
    let [hydrogen, helium, once] = weakening;
    for node in 0..NODES {
        let opacity = (densities[0] * hydrogen[node] + densities[1] * helium[node] + densities[2] * once[node] + way.others[node]).max(0.0);
        let longer = if node < OWN_NODES { detour(opacity, way.inner) } else { 1.0 };
        depths[node] = opacity * way.thickness * longer;
    }
    for node in 0..NODES {
        // (1 − e^(−x))/x, by its series up to one, right to 1e-10.
        let depth = depths[node].min(1.0);
        let mut sum = 1.0;
        for k in (2..14).rev() {
            sum = 1.0 - depth / k as f64 * sum;
        }
        means[node] = sum;
    }
    for node in 0..NODES {
        if depths[node] > 1.0 {
            means[node] = -(-depths[node]).exp_m1() / depths[node];
        }
    }
}
