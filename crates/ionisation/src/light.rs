//! Ionising light in a few nodes of photon energy.
//!
//! Between the thresholds of hydrogen and helium the nodes are those of the Gauss rule of the star's photons in ln E, so
//! that what hydrogen and helium take of the light is what it lost. What metals take, whose thresholds lie elsewhere, has
//! weights of its own: with ℓ_j the Lagrange polynomials of a band's nodes
//!
//!   Γ_X = Σ_j F_j σ_Xj,    σ_Xj = ∫ S σ_X ℓ_j dE / ∫ S ℓ_j dE
//!
//! so the attenuation alone is interpolated, and a threshold is where it is.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | S | photons of the star per second and energy | s⁻¹ eV⁻¹ |
//! | F | flux of photons at a node | s⁻¹ cm⁻² |
//! | σ_X | cross section of an ion | cm² |

use spectra::quadrature::gauss_of_measure;

use crate::atoms::{Atoms, BOLTZMANN_EV, ELEMENTS, Element, HYDROGEN_EV, STAGES, TRIPLET_EV, TWO_PHOTON_EV};

/// Where bands of nodes begin and end \[eV\], and how many nodes they have: what ionises neutral carbon and sulphur,
/// hydrogen, neon as well, helium, and He⁺. Within a few tenths of an electronvolt of where light of hydrogen's band ends
/// stand thresholds of Ne⁰ and S⁺: a short band leaves little to interpolate there.
const BANDS: [(f64, f64, usize); 6] =
    [(10.36, 13.6, 2), (13.6, 18.0, 3), (18.0, 21.56, 2), (21.56, 24.59, 2), (24.59, 54.42, 6), (54.42, 500.0, 6)];
/// Photons of a band, in parts of all, with which it is left out \[1\].
const FAINTEST: f64 = 1e-12;
/// Samples of the spectrum in a band.
const SAMPLES: usize = 600;
/// The gas's own light: where it begins \[eV\], and whether an electron's kinetic energy comes on top. These are
/// recombinations to the ground of hydrogen and helium, helium's triplets, and its two-photon decays.
const OWN: [(f64, bool); 4] = [(13.6, true), (24.59, true), (TRIPLET_EV, false), (TWO_PHOTON_EV, false)];
/// That kinetic energy, where cross sections are read \[eV\]: k T at 10⁴ K.
const KINETIC_EV: f64 = 0.85;
/// Absorbers that weaken light.
pub const ABSORBERS: [(Element, usize); 3] = [(Element::Hydrogen, 0), (Element::Helium, 0), (Element::Helium, 1)];

/// Ions by element and charge, one behind the other.
pub const IONS: usize = ELEMENTS * STAGES;

/// The place of an ion among all.
pub const fn ion(element: Element, charge: usize) -> usize {
    element as usize * STAGES + charge
}

/// What a photon of a node does to each ion.
#[derive(Debug, Clone)]
pub struct Absorption {
    /// The cross section \[cm²\].
    pub sigma: [f64; IONS],
    /// That times the energy that an electron gets \[eV cm²\].
    pub heat: [f64; IONS],
    /// The cross section, where a photon has the energy beside that which a recombining electron had; none for the star's.
    pub thermal: Option<[f64; ABSORBERS.len()]>,
}

/// Nodes at most.
pub const NODES: usize = 32;
/// A number for each node; zeros where there is none.
pub type ByNode = [f64; NODES];

/// A star's ionising light. The first nodes are those of the gas's own, which the star has none of: recombinations to the
/// ground of hydrogen and of helium, photons of 19.8 eV, and of two-photon decays.
#[derive(Debug, Clone)]
pub struct IonisingLight {
    /// Photon energies of the nodes \[eV\].
    pub energies_ev: Vec<f64>,
    /// Photons that leave the star in each \[s⁻¹\].
    pub photons: ByNode,
    /// The cross sections of [`ABSORBERS`] \[cm²\].
    pub weakening: [ByNode; ABSORBERS.len()],
    /// What a photon of each node does.
    pub absorptions: Vec<Absorption>,
}

/// Nodes of the gas's own light.
pub const OWN_NODES: usize = OWN.len();

/// A node that is being made: its energy and photons, and samples of its band with their shares in it.
struct Node {
    energy_ev: f64,
    photons: f64,
    samples: Vec<f64>,
    shares: Vec<f64>,
    /// Where light of recombinations begins that has an electron's energy on top.
    thermal: Option<f64>,
}

impl IonisingLight {
    /// The nodes of a spectrum of photons \[s⁻¹ eV⁻¹ at an energy in eV\].
    pub fn new(spectrum: impl Fn(f64) -> f64) -> Self {
        let own = OWN.into_iter().map(|(begins, is_thermal)| {
            let energy_ev = begins + if is_thermal { KINETIC_EV } else { 0.0 };
            Node { energy_ev, photons: 0.0, samples: vec![energy_ev], shares: vec![1.0], thermal: is_thermal.then_some(begins) }
        });
        let mut nodes: Vec<Node> = own.collect();
        let bands: Vec<Vec<Node>> = BANDS.into_iter().map(|band| of_band(band, &spectrum)).collect();
        let photons = |band: &[Node]| band.iter().map(|node| node.photons).sum::<f64>();
        let all: f64 = bands.iter().map(|band| photons(band)).sum();
        // A band that hardly has a photon takes time alone.
        nodes.extend(bands.into_iter().filter(|band| photons(band) > FAINTEST * all).flatten());
        let absorptions: Vec<Absorption> = nodes.iter().map(absorption).collect();
        let mut light = Self {
            energies_ev: nodes.iter().map(|node| node.energy_ev).collect(),
            photons: [0.0; NODES],
            weakening: [[0.0; NODES]; 3],
            absorptions,
        };
        for (number, node) in nodes.iter().enumerate() {
            light.photons[number] = node.photons;
            for (weakening, (element, charge)) in light.weakening.iter_mut().zip(ABSORBERS) {
                weakening[number] = light.absorptions[number].sigma[ion(element, charge)];
            }
        }
        light
    }

    /// That of a black body \[K\] with so many photons above 13.6 eV \[s⁻¹\].
    pub fn blackbody(temperature: f64, ionising: f64) -> Self {
        let photons = |energy: f64| energy * energy / (energy / (BOLTZMANN_EV * temperature)).exp_m1();
        let light = Self::new(photons);
        let all = light.ionising();
        // So cold a body has none to be scaled.
        light.scaled(if all > 0.0 { ionising / all } else { 0.0 })
    }

    /// The same spectrum with more or fewer photons.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.photons.iter_mut().for_each(|photons| *photons *= factor);
        self
    }

    /// Of numbers by node, the sum over those above 13.6 eV.
    pub fn ionising_of(&self, values: &ByNode) -> f64 {
        values.iter().zip(&self.energies_ev).filter(|(_, e)| **e > HYDROGEN_EV).map(|(value, _)| value).sum()
    }

    /// Photons above 13.6 eV \[s⁻¹\].
    pub fn ionising(&self) -> f64 {
        self.ionising_of(&self.photons)
    }

    /// What metals absorb, by node: Σ n σ of their ions \[cm⁻¹\]; as weights between nodes are, it may be negative at one
    /// where it is the more at another.
    pub fn of_metals(&self, density: impl Fn(Element, usize) -> f64) -> ByNode {
        let mut densities = [0.0; IONS];
        for element in Element::METALS {
            (0..element.charges()).for_each(|charge| densities[ion(element, charge)] = density(element, charge));
        }
        let first = ion(Element::METALS[0], 0);
        let mut opacity = [0.0; NODES];
        for (own, absorption) in opacity.iter_mut().zip(&self.absorptions) {
            *own = densities[first..].iter().zip(&absorption.sigma[first..]).map(|(n, sigma)| n * sigma).sum();
        }
        opacity
    }

    /// What absorbs, by node: Σ n σ of densities of [`ABSORBERS`] \[cm⁻¹\].
    #[inline(always)]
    pub fn opacity(&self, densities: [f64; ABSORBERS.len()], node: usize) -> f64 {
        densities.iter().zip(&self.weakening).map(|(n, sigma)| n * sigma[node]).sum()
    }
}

/// The nodes of a band: the Gauss rule of its photons in ln E, with the shares that each sample has in each by the
/// Lagrange polynomials of the rule.
fn of_band((low, high, count): (f64, f64, usize), spectrum: &impl Fn(f64) -> f64) -> Vec<Node> {
    let step = (high / low).ln() / SAMPLES as f64;
    let x: Vec<f64> = (0..SAMPLES).map(|i| low.ln() + (i as f64 + 0.5) * step).collect();
    let mass: Vec<f64> = x.iter().map(|x| spectrum(x.exp()) * x.exp() * step).collect();
    let rule = gauss_of_measure(&x, &mass, count);
    let node = |(j, (own, photons)): (usize, &(f64, f64))| {
        let others: Vec<f64> = rule.iter().enumerate().filter(|(i, _)| *i != j).map(|(_, (other, _))| *other).collect();
        let lagrange = |x: f64| others.iter().map(|other| (x - other) / (own - other)).product::<f64>();
        let shares = x.iter().zip(&mass).map(|(x, m)| m * lagrange(*x) / photons).collect();
        Node { energy_ev: own.exp(), photons: *photons, samples: x.iter().map(|x| x.exp()).collect(), shares, thermal: None }
    };
    rule.iter().enumerate().map(node).collect()
}

/// What a photon of a node does.
fn absorption(node: &Node) -> Absorption {
    let mut all = Absorption { sigma: [0.0; IONS], heat: [0.0; IONS], thermal: None };
    let ions = Element::ALL.into_iter().flat_map(|element| (0..element.charges()).map(move |charge| (element, charge)));
    for (element, charge) in ions {
        let Some(fit) = &Atoms::get().transition(element, charge).light else { continue };
        let over = |value: &dyn Fn(f64) -> f64| node.samples.iter().zip(&node.shares).map(|(e, share)| value(*e) * share).sum::<f64>();
        let above = |e: f64| fit.at(e) * (e - fit.threshold_ev);
        // What weakens the light is what the node's own photons do.
        let weakens = ABSORBERS.contains(&(element, charge));
        let own = if weakens { [fit.at(node.energy_ev), above(node.energy_ev)] } else { [over(&|e| fit.at(e)), over(&above)] };
        [all.sigma[ion(element, charge)], all.heat[ion(element, charge)]] = own;
    }
    all.thermal = node.thermal.map(|begins| {
        ABSORBERS.map(|(element, charge)| {
            let threshold = Atoms::get().transition(element, charge).light.as_ref().map_or(0.0, |fit| fit.threshold_ev);
            let sigma = all.sigma[ion(element, charge)];
            all.heat[ion(element, charge)] = sigma * (begins - threshold).max(0.0);
            sigma
        })
    });
    all
}
