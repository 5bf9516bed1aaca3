//! A star in a spherical cloud, shell by shell: the reference to which the rest is held.
//!
//! Shells are as thin as light asks for: none takes more than a small part of what any node has left.

use std::f64::consts::PI;

use crate::atoms::{Atoms, Element};
use crate::balance::{Balance, Diffuse, Gas, Photo, State};
use crate::light::{ABSORBERS, IonisingLight};

/// The largest depth of a shell at a node that still has light \[1\].
const DEPTH: f64 = 0.1;
/// The largest thickness of a shell in parts of its radius \[1\].
const THICKNESS: f64 = 0.01;
/// Where light is taken to be used up, in parts of all of it \[1\].
const USED_UP: f64 = 1e-5;
/// Passes over a shell, whose light depends on what it is.
const PASSES: usize = 60;

/// A shell in balance.
#[derive(Debug, Clone)]
pub struct Shell {
    /// Its inner radius \[cm\].
    pub inner_cm: f64,
    /// Its thickness \[cm\].
    pub thickness_cm: f64,
    /// The gas in it.
    pub state: State,
}

impl Shell {
    /// \[cm³\]
    pub fn volume(&self) -> f64 {
        let outer = self.inner_cm + self.thickness_cm;
        4.0 / 3.0 * PI * (outer.powi(3) - self.inner_cm.powi(3))
    }
}

/// A cloud of one density and a hole in its middle, and its shells.
#[derive(Debug, Clone)]
pub struct Sphere {
    /// What it is made of.
    pub gas: Gas,
    /// From the inside outward.
    pub shells: Vec<Shell>,
    /// Photons that left the cloud, by node \[s⁻¹\].
    pub left: Vec<f64>,
}

impl Sphere {
    /// A cloud from an inner radius outward, as far as light or `outer_cm` reaches.
    pub fn new(gas: Gas, light: &IonisingLight, diffuse: Diffuse, [inner_cm, outer_cm]: [f64; 2]) -> Self {
        let mut photons = light.photons.clone();
        let (mut radius, mut thickness) = (inner_cm, 1e-3 * inner_cm);
        let mut near = State::neutral(&gas);
        near.temperature = 1e4;
        near.fractions[0] = [1e-3, 0.999, 0.0, 0.0, 0.0, 0.0];
        near.electrons = gas.hydrogen;
        let mut shells = Vec::new();
        let ionising =
            |photons: &[f64]| photons.iter().zip(&light.energies_ev).filter(|(_, e)| **e > 13.6).map(|(photons, _)| photons).sum::<f64>();
        let all = ionising(&photons);
        while radius < outer_cm && ionising(&photons) > USED_UP * all {
            thickness = f64::min(thickness, outer_cm - radius);
            let settled = settled(&gas, (light, diffuse), &photons, [radius, thickness], &near);
            let deepest = settled
                .depths
                .iter()
                .zip(photons.iter().zip(&light.energies_ev))
                .take(light.own().start)
                .filter(|(_, (photons, e))| **photons > 1e-6 * all && **e > 13.6)
                .map(|(depth, _)| *depth)
                .fold(0.0, f64::max);
            if deepest > 2.0 * DEPTH {
                thickness *= 0.5;
                continue;
            }
            photons.iter_mut().enumerate().for_each(|(node, photons)| *photons = settled.left(node, *photons));
            shells.push(Shell { inner_cm: radius, thickness_cm: thickness, state: settled.state });
            near = settled.state;
            radius += thickness;
            thickness = f64::min(thickness * (DEPTH / deepest.max(1e-9)).clamp(0.5, 1.5), THICKNESS * radius);
        }
        Self { gas, shells, left: photons }
    }

    /// Σ over the cloud of a density of the state \[that times cm³\].
    pub fn sum(&self, value: impl Fn(&State) -> f64) -> f64 {
        self.shells.iter().map(|shell| shell.volume() * value(&shell.state)).sum()
    }

    /// The power of a line that electrons excite, by its label \[erg s⁻¹\].
    pub fn collisional(&self, label: &str) -> f64 {
        let table = &Atoms::get().collisional;
        let lines = || table.lines.iter().filter(|line| line.label == label);
        self.sum(|state| {
            let at = table.conditions(state.temperature, state.electrons);
            lines().map(|line| state.electrons * state.density(&self.gas, line.element, line.charge) * table.emissivity(line, &at)).sum()
        })
    }

    /// The power of a line of recombination, by its label \[erg s⁻¹\].
    pub fn recombination(&self, label: &str) -> f64 {
        let table = &Atoms::get().recombination;
        let lines = || table.lines.iter().filter(|line| line.label == label);
        self.sum(|state| {
            let at = table.conditions(state.temperature, state.electrons);
            lines()
                .map(|line| state.electrons * state.density(&self.gas, line.element, line.charge + 1) * table.emissivity(line, &at))
                .sum()
        })
    }

    /// The radius at which an ion's part of its element is a half for the last time \[cm\].
    pub fn front_cm(&self, element: Element, charge: usize) -> Option<f64> {
        let part = |shell: &Shell| shell.state.fractions[element as usize][charge];
        self.shells.windows(2).rev().find_map(|pair| {
            let (a, b) = (part(&pair[0]), part(&pair[1]));
            ((a - 0.5) * (b - 0.5) <= 0.0 && a != b).then(|| {
                let middle = |shell: &Shell| shell.inner_cm + 0.5 * shell.thickness_cm;
                middle(&pair[0]) + (a - 0.5) / (a - b) * (middle(&pair[1]) - middle(&pair[0]))
            })
        })
    }
}

/// The state of a shell, its depth at each node, and the photons that it makes itself \[s⁻¹\], under light that its own
/// gas weakens.
fn settled(gas: &Gas, (light, diffuse): (&IonisingLight, Diffuse), photons: &[f64], shell: [f64; 2], near: &State) -> Settled {
    let [inner, thickness] = shell;
    let outer = inner + thickness;
    let area = 4.0 / 3.0 * PI * (outer * outer + outer * inner + inner * inner);
    let mut settled = Settled { state: *near, depths: vec![0.0; photons.len()], own: vec![0.0; photons.len()] };
    for _ in 0..PASSES {
        let state = &settled.state;
        let absorbers = ABSORBERS.map(|(element, charge)| state.density(gas, element, charge));
        let opacity = |node: usize| light.opacity(absorbers, node) + gas.hydrogen * gas.dust_cm2;
        // How much longer ways are than the way outward.
        let detour = |node: usize| if light.own().contains(&node) { 1.0 + 3.0 * opacity(node) * inner } else { 1.0 };
        let depths: Vec<f64> = (0..photons.len()).map(|node| thickness * opacity(node) * detour(node)).collect();
        // Of light that comes, and of light that is made all along the way.
        let flux = |node: usize| detour(node) * (photons[node] * mean(depths[node]) + settled.own[node] * mean_of_own(depths[node])) / area;
        let flux: Vec<f64> = (0..photons.len()).map(flux).collect();
        let mut photo = Photo::default();
        photo.add(light, &flux);
        let balance = Balance { gas, photo: &photo, diffuse };
        let (before, state) = (state.fractions[0][0], balance.state(state));
        let mut own = vec![0.0; photons.len()];
        light.own().zip(balance.own_light(&state)).for_each(|(node, made)| own[node] = made * area * thickness);
        settled = Settled { state, depths, own };
        if (settled.state.fractions[0][0] / before - 1.0).abs() < 1e-7 {
            break;
        }
    }
    settled
}

struct Settled {
    state: State,
    depths: Vec<f64>,
    own: Vec<f64>,
}

impl Settled {
    /// Photons that leave the shell, of those that came to it.
    fn left(&self, node: usize, came: f64) -> f64 {
        came * (-self.depths[node]).exp() + self.own[node] * mean(self.depths[node])
    }
}

/// The mean of e^(−x) from zero to a depth.
fn mean(depth: f64) -> f64 {
    if depth > 1e-8 { -(-depth).exp_m1() / depth } else { 1.0 - 0.5 * depth }
}

/// The mean along the way of light that is made evenly along it, in parts of all of it.
fn mean_of_own(depth: f64) -> f64 {
    if depth > 1e-4 { (1.0 - mean(depth)) / depth } else { 0.5 - depth / 6.0 }
}
