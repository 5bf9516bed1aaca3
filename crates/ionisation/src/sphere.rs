//! A star in a spherical cloud, shell by shell: the reference to which the rest is held.

use spectra::constants::SPHERE;

use crate::atoms::{Atoms, Element, LineTable};
use crate::balance::{Accuracy, Diffuse, Gas, GasState};
use crate::beam::{Beam, BeamStep};
use crate::emitted::{EmittedLight, ShellSource};
use crate::known::opacity;
use crate::light::{ByNode, IonisingLight, OWN_NODES};
use crate::packet::Packet;

/// A cloud of one density and a hole in its middle, and its shells.
#[derive(Debug, Clone)]
pub struct Sphere {
    /// Composition.
    pub gas: Gas,
    /// From the inside outward.
    pub shells: Vec<BeamStep>,
    /// Photons that left the cloud, by node \[s⁻¹\].
    pub left: ByNode,
}

impl Sphere {
    /// A cloud from an inner radius outward, as far as light or the outer radius reaches \[cm\].
    pub fn new(gas: Gas, light: &IonisingLight, diffuse: Diffuse, radii_cm: [f64; 2]) -> Self {
        Self::with_accuracy(gas, light, diffuse, radii_cm, &Accuracy::REFERENCE)
    }

    /// Variant with a given accuracy.
    pub fn with_accuracy(gas: Gas, light: &IonisingLight, diffuse: Diffuse, radii_cm: [f64; 2], accuracy: &Accuracy) -> Self {
        Self::under(gas, light, diffuse, radii_cm, accuracy, None)
    }

    /// A cloud whose own light goes in all directions: solved again and again under the light of the last solution, until
    /// the ions of hydrogen, and the temperature weighted by them, move by less than 1e-4.
    pub fn isotropic(gas: Gas, light: &IonisingLight, radii_cm: [f64; 2], accuracy: &Accuracy) -> Self {
        /// Turns at most.
        const TURNS: usize = 40;
        /// See above.
        const SETTLED: f64 = 1e-4;
        let mut sphere = Self::under(gas, light, Diffuse::Outward, radii_cm, accuracy, None);
        for _ in 0..TURNS {
            let field = sphere.own_light(light);
            let mut next = Self::under(gas, light, Diffuse::Outward, radii_cm, accuracy, Some(&field));
            next.left[..OWN_NODES].copy_from_slice(&field.left);
            let pairs = |sphere: &Self| sphere.sum(|state| state.pairs(&gas));
            let moved = (pairs(&next) / pairs(&sphere) - 1.0).abs().max((next.temperature() / sphere.temperature() - 1.0).abs());
            sphere = next;
            if moved < SETTLED {
                break;
            }
        }
        sphere
    }

    /// The light that its shells make, in all directions.
    pub fn own_light(&self, light: &IonisingLight) -> EmittedLight {
        let mut edges: Vec<f64> = self.shells.iter().map(|shell| shell.inner_cm).collect();
        edges.extend(self.shells.last().map(|shell| shell.inner_cm + shell.thickness_cm));
        let shell_sum = |shell: &BeamStep| {
            let opacity = opacity(light, &self.gas, &shell.state);
            std::array::from_fn(|node| ShellSource { made: shell.emitted[node], opacity: opacity[node] })
        };
        EmittedLight::new(&edges, &self.shells.iter().map(shell_sum).collect::<Vec<_>>())
    }

    /// See [`with_accuracy`](Self::with_accuracy); the flux of its own light may be known.
    fn under(
        gas: Gas,
        light: &IonisingLight,
        diffuse: Diffuse,
        radii_cm: [f64; 2],
        accuracy: &Accuracy,
        field: Option<&EmittedLight>,
    ) -> Self {
        let mut beam = Beam::new(light, accuracy, SPHERE, radii_cm[0]);
        if let Some(field) = field {
            beam = beam.under(field);
        }
        let mut packet = Packet::new(light, diffuse, accuracy, gas);
        let mut shells = Vec::new();
        while beam.radius_cm < radii_cm[1] * (1.0 - 1e-12) && !beam.is_used_up() {
            beam.begin((&mut packet, 0), &gas, radii_cm[1] - beam.radius_cm);
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
    pub fn sum(&self, value: impl Fn(&GasState) -> f64) -> f64 {
        self.shells.iter().map(|shell| shell.volume(SPHERE) * value(&shell.state)).sum()
    }

    /// The power of a line by its label \[erg s⁻¹\]; nothing where no line is called so.
    pub fn line(&self, label: &str) -> f64 {
        let atoms = Atoms::get();
        let line_flux = |table: &LineTable| {
            let lines = table.lines.iter().filter(|line| line.label == label);
            lines.map(|line| self.sum(|state| state.emission(&self.gas, table, line))).sum::<f64>()
        };
        line_flux(&atoms.collisional) + line_flux(&atoms.recombination)
    }

    /// The temperature weighted by n_p n_e \[K\].
    pub fn temperature(&self) -> f64 {
        let weight = |s: &GasState| s.pairs(&self.gas);
        self.sum(|s| weight(s) * s.temperature) / self.sum(weight)
    }

    /// The part of helium's nuclei that are He⁺ for that of hydrogen's that are H⁺, both weighted by n_e.
    pub fn helium(&self) -> f64 {
        let element_mean =
            |element: Element| self.sum(|s| s.electrons * s.density(&self.gas, element, 1)) / self.gas.abundances[element as usize];
        element_mean(Element::Helium) / element_mean(Element::Hydrogen)
    }

    /// The radius at which an ion's part of its element is a half for the last time \[cm\].
    pub fn front_cm(&self, element: Element, charge: usize) -> Option<f64> {
        let part = |shell: &BeamStep| shell.state.fractions[element as usize][charge];
        self.shells.windows(2).rev().find_map(|pair| {
            let (a, b) = (part(&pair[0]), part(&pair[1]));
            ((a - 0.5) * (b - 0.5) <= 0.0 && a != b).then(|| {
                let middle = |shell: &BeamStep| shell.inner_cm + 0.5 * shell.thickness_cm;
                middle(&pair[0]) + (a - 0.5) / (a - b) * (middle(&pair[1]) - middle(&pair[0]))
            })
        })
    }
}
