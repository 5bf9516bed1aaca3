//! A star in a spherical cloud, shell by shell: the reference to which the rest is held.

use spectra::constants::SPHERE;

use crate::atoms::{Atoms, Element, LineTable};
use crate::balance::{Accuracy, Diffuse, Gas, State};
use crate::beam::{Beam, Step};
use crate::light::{ByNode, IonisingLight};
use crate::packet::Packet;

/// A cloud of one density and a hole in its middle, and its shells.
#[derive(Debug, Clone)]
pub struct Sphere {
    /// What it is made of.
    pub gas: Gas,
    /// From the inside outward.
    pub shells: Vec<Step>,
    /// Photons that left the cloud, by node \[s⁻¹\].
    pub left: ByNode,
}

impl Sphere {
    /// A cloud from an inner radius outward, as far as light or the outer radius reaches \[cm\].
    pub fn new(gas: Gas, light: &IonisingLight, diffuse: Diffuse, radii_cm: [f64; 2]) -> Self {
        Self::with_accuracy(gas, light, diffuse, radii_cm, &Accuracy::REFERENCE)
    }

    /// The same, as exact as is said.
    pub fn with_accuracy(gas: Gas, light: &IonisingLight, diffuse: Diffuse, radii_cm: [f64; 2], accuracy: &Accuracy) -> Self {
        let mut beam = Beam::new(light, accuracy, SPHERE, radii_cm[0]);
        let mut packet = Packet::new(light, diffuse, accuracy, gas);
        let mut shells = Vec::new();
        while beam.radius_cm < radii_cm[1] * (1.0 - 1e-12) && !beam.is_used_up() {
            beam.begin((&mut packet, 0), gas.hydrogen, radii_cm[1] - beam.radius_cm);
            shells.push(loop {
                packet.pass();
                if packet.has_settled(0)
                    && let Some(step) = beam.end((&mut packet, 0))
                {
                    break step;
                }
            });
        }
        Self { gas, shells, left: beam.photons }
    }

    /// Σ over the cloud of a density of the state \[that times cm³\].
    pub fn sum(&self, value: impl Fn(&State) -> f64) -> f64 {
        self.shells.iter().map(|shell| shell.volume(SPHERE) * value(&shell.state)).sum()
    }

    /// The power of a line by its label \[erg s⁻¹\]; nothing where no line is called so.
    pub fn line(&self, label: &str) -> f64 {
        let atoms = Atoms::get();
        let of = |table: &LineTable| {
            let lines = table.lines.iter().filter(|line| line.label == label);
            lines.map(|line| self.sum(|state| state.emission(&self.gas, table, line))).sum::<f64>()
        };
        of(&atoms.collisional) + of(&atoms.recombination)
    }

    /// The temperature weighted by n_p n_e \[K\].
    pub fn temperature(&self) -> f64 {
        let weight = |s: &State| s.pairs(&self.gas);
        self.sum(|s| weight(s) * s.temperature) / self.sum(weight)
    }

    /// The part of helium's nuclei that are He⁺ for that of hydrogen's that are H⁺, both weighted by n_e.
    pub fn helium(&self) -> f64 {
        let of = |element: Element| self.sum(|s| s.electrons * s.density(&self.gas, element, 1)) / self.gas.abundances[element as usize];
        of(Element::Helium) / of(Element::Hydrogen)
    }

    /// The radius at which an ion's part of its element is a half for the last time \[cm\].
    pub fn front_cm(&self, element: Element, charge: usize) -> Option<f64> {
        let part = |shell: &Step| shell.state.fractions[element as usize][charge];
        self.shells.windows(2).rev().find_map(|pair| {
            let (a, b) = (part(&pair[0]), part(&pair[1]));
            ((a - 0.5) * (b - 0.5) <= 0.0 && a != b).then(|| {
                let middle = |shell: &Step| shell.inner_cm + 0.5 * shell.thickness_cm;
                middle(&pair[0]) + (a - 0.5) / (a - b) * (middle(&pair[1]) - middle(&pair[0]))
            })
        })
    }
}
