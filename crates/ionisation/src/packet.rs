//! Steps of several beams that are reckoned side by side: gas under light that the gas itself weakens.
//!
//! Each lane has a step of its own, begins it and ends it when it will; what the others do is nothing to it.

use multiversion::multiversion;

use crate::atoms::Element;
use crate::balance::{Accuracy, Balance, Diffuse, Gas, GasState, Near, Photo, States, Thermostat};
use crate::coefficients::Coefficients;
use crate::lanes::{LANES, Lanes};
use crate::light::{ABSORBERS, ByNode, DETOUR, IONS, IonisingLight, NODES, OWN_NODES, ion};

/// Passes over a step, whose light depends on what it is: as many at least, so that gas which changes slowly from step to step
/// does not lag behind, and at most.
const LEAST: u32 = 2;
const PASSES: u32 = 300;
/// How much of what an absorber's change does to its own light is reckoned with before it has done it: at most \[1\].
const FORESEEN: f64 = 0.75;

/// A step of a beam, before it is known what its gas is.
#[derive(Debug, Clone, Copy)]
pub struct Trial {
    /// Nuclei of hydrogen \[cm⁻³\].
    pub hydrogen: f64,
    /// Opacity of dust \[cm⁻¹\].
    pub dust: f64,
    /// Start \[cm\].
    pub inner: f64,
    /// Its length \[cm\].
    pub thickness: f64,
    /// Its mean cross section \[cm²\].
    pub area: f64,
    /// State of the gas.
    pub state: GasState,
    /// Photons that this makes \[cm⁻³ s⁻¹\].
    pub emitted: [f64; OWN_NODES],
    /// Negative slope of heating over ln T, relative to cooling.
    pub slope: f64,
    /// The flux of the gas's own light, where it is known from elsewhere \[s⁻¹ cm⁻²\]; else it is that of the beam itself.
    pub known: Option<[f64; OWN_NODES]>,
}

/// Outcome.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Its gas.
    pub state: GasState,
    /// Photons that this makes \[cm⁻³ s⁻¹\].
    pub emitted: [f64; OWN_NODES],
    /// Negative slope of heating over ln T, relative to cooling.
    pub slope: f64,
    /// Its depth by node \[1\].
    pub depths: ByNode,
    /// Transmission \[1\].
    pub left: ByNode,
    /// The mean of that along the step, of the gas's own light \[1\].
    pub means: [f64; OWN_NODES],
    /// By how much the last pass still moved it: twice that of the temperature, or that of hydrogen and helium \[1\].
    pub moved: f64,
}

/// Steps side by side, of beams of one star.
pub struct Packet<'a> {
    light: &'a IonisingLight,
    diffuse: Diffuse,
    accuracy: &'a Accuracy,
    gas: Gas,
    near: Near,
    /// The passes that each lane's step has had; none where it has no step.
    passes: [Option<u32>; LANES],
    hydrogen: Lanes,
    /// Opacity of dust \[cm⁻¹\].
    dust: Lanes,
    inner: Lanes,
    thickness: Lanes,
    area: Lanes,
    /// Photons that come in by node \[s⁻¹\].
    photons: [Lanes; NODES],
    states: States,
    emitted: [Lanes; OWN_NODES],
    /// The flux of the gas's own light \[s⁻¹ cm⁻²\], and in which lanes (one, else zero) it is known.
    known: [Lanes; OWN_NODES],
    is_known: Lanes,
    /// The part of each of [`ABSORBERS`] that weakens the light.
    absorbing: [Lanes; ABSORBERS.len()],
    thermostat: Thermostat,
    coefficients: Coefficients,
    depths: [Lanes; NODES],
    left: [Lanes; NODES],
    means: [Lanes; OWN_NODES],
    flux: [Lanes; NODES],
    moved: Lanes,
}

impl<'a> Packet<'a> {
    /// No steps yet, of a star's light in gas of whatever density.
    pub fn new(light: &'a IonisingLight, diffuse: Diffuse, accuracy: &'a Accuracy, gas: Gas) -> Self {
        let mut coefficients = Coefficients::default();
        let states = States::default();
        (0..LANES).for_each(|lane| coefficients.renew(lane, (states.temperature[lane], 1.0), accuracy.is_exact));
        Self {
            light,
            diffuse,
            accuracy,
            gas,
            near: Near::default(),
            passes: [None; LANES],
            hydrogen: Lanes::ONE,
            dust: Lanes::ZERO,
            inner: Lanes::ONE,
            thickness: Lanes::ONE,
            area: Lanes::ONE,
            photons: [Lanes::ZERO; NODES],
            states,
            emitted: [Lanes::ZERO; OWN_NODES],
            known: [Lanes::ZERO; OWN_NODES],
            is_known: Lanes::ZERO,
            absorbing: [Lanes::ZERO; ABSORBERS.len()],
            thermostat: Thermostat::new(accuracy.settled),
            coefficients,
            depths: [Lanes::ZERO; NODES],
            left: [Lanes::ONE; NODES],
            means: [Lanes::ONE; OWN_NODES],
            flux: [Lanes::ZERO; NODES],
            moved: Lanes::ZERO,
        }
    }

    /// Forgets what a lane's last beam has left there: the next one is what it would be alone.
    pub fn forget(&mut self, lane: usize) {
        self.coefficients.temperature[lane] = 0.0;
    }

    /// Begins a step in a lane, given the photons that come in by node \[s⁻¹\].
    pub fn begin(&mut self, lane: usize, photons: &ByNode, trial: &Trial) {
        self.photons.iter_mut().zip(photons).for_each(|(lane_photons, photons)| lane_photons[lane] = *photons);
        self.emitted.iter_mut().zip(trial.emitted).for_each(|(lane_rates, value)| lane_rates[lane] = value);
        self.is_known[lane] = if trial.known.is_some() { 1.0 } else { 0.0 };
        self.known.iter_mut().zip(trial.known.unwrap_or_default()).for_each(|(lane_known, value)| lane_known[lane] = value);
        (self.hydrogen[lane], self.dust[lane], self.inner[lane]) = (trial.hydrogen, trial.dust, trial.inner);
        (self.thickness[lane], self.area[lane]) = (trial.thickness, trial.area);
        self.states.put(lane, &trial.state);
        if let Some(temperature) = self.gas.isothermal {
            self.states.temperature[lane] = temperature;
        }
        for (absorbing, (element, charge)) in self.absorbing.iter_mut().zip(ABSORBERS) {
            absorbing[lane] = trial.state.fractions[element as usize][charge];
        }
        self.thermostat.begin(lane, trial.slope);
        self.passes[lane] = Some(0);
    }

    /// True if a lane's step has settled, or will not.
    pub fn has_settled(&self, lane: usize) -> bool {
        self.passes[lane].is_some_and(|passes| passes >= LEAST && self.moved[lane] < self.accuracy.settled || passes >= PASSES)
    }

    /// A lane's neutral fraction of hydrogen \[1\].
    pub fn neutral(&self, lane: usize) -> f64 {
        self.states.part(Element::Hydrogen, 0)[lane]
    }

    /// A lane's depths by node \[1\].
    pub fn depths(&self, lane: usize) -> ByNode {
        std::array::from_fn(|node| self.depths[node][lane])
    }

    /// Ends a lane's step.
    pub fn end(&mut self, lane: usize) -> Outcome {
        self.passes[lane] = None;
        Outcome {
            state: self.states.get(lane),
            emitted: self.emitted.map(|rates| rates[lane]),
            slope: self.thermostat.slope(lane),
            depths: self.depths(lane),
            left: std::array::from_fn(|node| self.left[node][lane]),
            means: self.means.map(|mean| mean[lane]),
            moved: self.moved[lane],
        }
    }

    /// Moves all steps on towards what they will be.
    pub fn pass(&mut self) {
        for lane in (0..LANES).filter(|lane| self.passes[*lane].is_some()) {
            let at = (self.states.temperature[lane], self.states.electrons[lane]);
            self.coefficients.keep_up(lane, at, self.accuracy.is_exact, self.accuracy.settled);
        }
        together(self);
        self.passes.iter_mut().flatten().for_each(|passes| *passes += 1);
    }

    /// Light along the steps, given what they are; by absorber, by how much its ionisations fall where ln of it rises \[s⁻¹\].
    #[inline(always)]
    fn weaken(&mut self) -> [Lanes; ABSORBERS.len()] {
        let nodes = self.light.energies_ev.len();
        let nuclei = |element: Element| self.hydrogen * self.gas.abundances[element as usize];
        let mut metals = [Lanes::ZERO; IONS];
        for element in Element::METALS {
            for charge in 0..element.charges() {
                metals[ion(element, charge)] = nuclei(element) * self.states.part(element, charge);
            }
        }
        let mut absorbers = [Lanes::ZERO; ABSORBERS.len()];
        for (number, (element, _)) in ABSORBERS.into_iter().enumerate() {
            absorbers[number] = nuclei(element) * self.absorbing[number];
        }
        let mut falls = [Lanes::ZERO; ABSORBERS.len()];
        let per_area = Lanes::ONE / self.area;
        let distance = self.inner + self.thickness * 0.5;
        for node in 0..nodes {
            let mut opacity = self.dust;
            for (ion, sigma) in &self.light.metals[node] {
                opacity += metals[*ion] * *sigma;
            }
            for (density, sigma) in absorbers.iter().zip(&self.light.weakening) {
                opacity += *density * sigma[node];
            }
            let opacity = opacity.at_least(0.0);
            let is_own = node < OWN_NODES;
            // How much longer the ways of the gas's own light are than the way outward.
            let detour = if is_own { opacity * distance * DETOUR + 1.0 } else { Lanes::ONE };
            let depth = opacity * self.thickness * detour;
            let left = depth.decay();
            let inverse = Lanes::ONE / depth.at_least(f64::MIN_POSITIVE);
            let mean = depth.mean_decay(left, inverse);
            // How the mean falls with the depth.
            let falling = depth.above(1e-3, (mean - left) * inverse, Lanes::splat(0.5));
            let incoming = self.photons[node] * per_area;
            let (mut flux, mut steep) = (incoming * mean, incoming * falling * self.thickness);
            if is_own {
                // Of light that is made all along the way, and whose own is longer: what is left of it, and how that falls.
                let part = depth.above(1e-4, (Lanes::ONE - mean) * inverse, Lanes::splat(0.5));
                let parting = depth.above(1e-2, (part - falling) * inverse, Lanes::splat(1.0 / 6.0));
                let made = self.emitted[node] * self.thickness;
                flux += made * part;
                steep = (incoming * falling + made * parting) * self.thickness * (detour * 2.0 - 1.0) * detour - flux * distance * DETOUR;
                flux = self.is_known.above(0.5, self.known[node], flux * detour);
                steep = self.is_known.above(0.5, Lanes::ZERO, steep);
                self.means[node] = mean;
            }
            for number in 0..ABSORBERS.len() {
                let sigma = self.light.weakening[number][node];
                falls[number] += steep * absorbers[number] * (sigma * sigma);
            }
            (self.depths[node], self.left[node], self.flux[node]) = (depth, left, flux);
        }
        falls
    }

    /// A pass over all lanes.
    #[inline(always)]
    fn pass_all(&mut self) {
        let falls = self.weaken();
        let photo = Photo::new(self.light, &self.flux);
        let of_all = ABSORBERS.map(|(element, charge)| photo.rates[ion(element, charge)].at_least(f64::MIN_POSITIVE));
        let (temperature, electrons) = (self.states.temperature, self.states.electrons);
        let balance = Balance {
            hydrogen: self.hydrogen,
            abundances: &self.gas.abundances,
            photo: &photo,
            diffuse: self.diffuse,
            coefficients: &self.coefficients,
            near: &self.near,
        };
        let excess = balance.pass(&mut self.states);
        self.emitted = balance.own_light(&self.states);
        if self.gas.isothermal.is_none() {
            self.states.temperature = self.thermostat.next(temperature, excess);
        }
        let moved = |now: Lanes, before: Lanes| (now / before - 1.0).abs();
        // Lines rise steeply with temperature.
        let mut most = (moved(self.states.temperature, temperature) * 2.0).or_more(moved(self.states.electrons, electrons));
        for (number, (element, charge)) in ABSORBERS.into_iter().enumerate() {
            let (now, before) = (self.states.part(element, charge), self.absorbing[number]);
            if number < 2 {
                most = most.or_more(moved(now, before));
            }
            // More of an absorber leaves less light, which leaves more of it: what it comes to in the end is foreseen.
            let (part, reached) = ((falls[number] / of_all[number]).at_least(0.0).at_most(FORESEEN), Lanes::ONE - now);
            let factor = Lanes::ONE / (Lanes::ONE - part * reached);
            let more = (before + (now - before) * factor).at_most(1.0);
            let less = before / ((before / now.at_least(f64::MIN_POSITIVE) - 1.0).at_least(0.0) * factor + 1.0);
            self.absorbing[number] = (now - before).above(0.0, more, less);
        }
        self.moved = most;
    }
}

#[multiversion(targets = "simd")]
fn together(packet: &mut Packet) {
    packet.pass_all();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::{Beam, BeamStep};
    use crate::benchmarks::BENCHMARKS;

    /// Three parsecs of a beam's steps in a lane, while other lanes have gas of other densities, or nothing.
    fn steps(lane: usize, others: &[usize], light: &IonisingLight) -> Vec<BeamStep> {
        let accuracy = Accuracy::FAST;
        let mut packet = Packet::new(light, Diffuse::Outward, &accuracy, BENCHMARKS[0].gas);
        let mut beams: Vec<Beam> = (0..LANES).map(|_| Beam::new(light, &accuracy, 0.01, 3e18)).collect();
        let density = |other: usize| if other == lane { 100.0 } else { 10.0 + 70.0 * other as f64 };
        let begin = |packet: &mut Packet, beams: &mut [Beam], lane: usize| {
            packet.forget(lane);
            beams[lane].begin((packet, lane), &Gas::new(density(lane), BENCHMARKS[0].gas.abundances), 1e17);
        };
        others.iter().chain([&lane]).for_each(|lane| begin(&mut packet, &mut beams, *lane));
        let mut found = Vec::new();
        while found.len() < 90 {
            packet.pass();
            for other in others.iter().copied().chain([lane]).filter(|lane| packet.has_settled(*lane)).collect::<Vec<_>>() {
                let Some(step) = beams[other].end((&mut packet, other)) else { continue };
                if other == lane {
                    found.push(step);
                }
                begin(&mut packet, &mut beams, other);
            }
        }
        found
    }

    /// A beam is the same, bit by bit, in whatever lane and beside whatever others.
    #[test]
    fn lanes_stand_apart() {
        let light = IonisingLight::blackbody(40_000.0, 4.26e49);
        let alone = steps(0, &[], &light);
        let beside = steps(5, &[0, 1, 2, 3, 4, 6, 7], &light);
        for (a, b) in alone.iter().zip(&beside) {
            assert!(a.state == b.state && a.depths == b.depths && a.thickness_cm == b.thickness_cm, "{a:?} {b:?}");
        }
        let differs = |a: &BeamStep, b: &BeamStep| a.state != b.state;
        assert!(differs(&alone[0], &alone[80]), "gas is the same everywhere");
    }
}
