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

use crate::atoms::{Atoms, BOLTZMANN_EV, ELEMENTS, Element, HYDROGEN_EV, STAGES, STRIPPED_EV, TRIPLET_EV, TWO_PHOTON_EV};

/// Bands of nodes: lower and upper energy \[eV\] and number of nodes. They start at the thresholds of Mg⁰ (the lowest, below those
/// of Si⁰, S⁰ and C⁰), H⁰, Ne⁰, He⁰ and He⁺. The thresholds of Ne⁰ and S⁺ are close to the end of hydrogen's bands: a short band
/// leaves little to interpolate there.
const BANDS: [(f64, f64, usize); 6] =
    [(7.64, 13.6, 2), (13.6, 18.0, 3), (18.0, 21.56, 2), (21.56, 24.59, 2), (24.59, 54.42, 6), (54.42, 500.0, 6)];
/// Photons of a band, in parts of all, with which it is left out \[1\].
const FAINTEST: f64 = 1e-12;
/// Samples of the spectrum in a band.
const SAMPLES: usize = 600;
/// The gas's own light: where it begins \[eV\], and whether an electron's kinetic energy comes on top. These are
/// recombinations to the ground of hydrogen and helium, helium's triplets, its two-photon decays, and recombinations of He²⁺
/// to excited levels and to the ground.
const OWN: [(f64, bool); 6] =
    [(13.6, true), (24.59, true), (TRIPLET_EV, false), (TWO_PHOTON_EV, false), (STRIPPED_EV, false), (54.42, true)];
/// That kinetic energy, where cross sections are read \[eV\]: k T at 10⁴ K.
const KINETIC_EV: f64 = 0.85;
/// Path length of diffuse light relative to the outward path, as a function of its depth κ r: κ (1 + DETOUR κ r), (G4) of
/// docs/gas.md. Found on spheres whose light goes in all directions (`Sphere::isotropic`): HII40 and PN75 have the same Hβ
/// to 0.4 % and the same temperature to 0.6 %.
pub const DETOUR: f64 = 0.5;
/// Absorbers that weaken light.
pub const ABSORBERS: [(Element, usize); 3] = [(Element::Hydrogen, 0), (Element::Helium, 0), (Element::Helium, 1)];

/// Ions by element and charge, one behind the other.
pub const IONS: usize = ELEMENTS * STAGES;

/// The place of an ion among all.
pub const fn ion(element: Element, charge: usize) -> usize {
    element as usize * STAGES + charge
}

/// Effect of a photon of a node on an ion of a metal.
#[derive(Debug, Clone, Copy)]
pub struct Absorption {
    /// The node.
    pub node: usize,
    /// The cross section \[cm²\].
    pub sigma: f64,
    /// That times the energy that an electron gets \[eV cm²\].
    pub heat: f64,
}

/// Nodes at most.
pub const NODES: usize = 27;
/// A number for each node; zeros where there is none.
pub type ByNode = [f64; NODES];

/// A star's ionising light. The first nodes are those of the gas's own, which the star has none of: recombinations to the
/// ground of hydrogen and of helium, photons of 19.8 eV, of two-photon decays, and hard ones of recombining He²⁺, to
/// excited levels and to its ground.
#[derive(Debug, Clone)]
pub struct IonisingLight {
    /// Photon energies of the nodes \[eV\].
    pub energies_ev: Vec<f64>,
    /// Photons that leave the star in each \[s⁻¹\].
    pub photons: ByNode,
    /// The cross sections of [`ABSORBERS`] \[cm²\].
    pub weakening: [ByNode; ABSORBERS.len()],
    /// Cross-sections times the energy of the electron \[eV cm²\].
    pub warming: [ByNode; ABSORBERS.len()],
    /// Those for light of recombinations that gives on what an electron had \[cm²\].
    pub thermal: [[f64; OWN_NODES]; ABSORBERS.len()],
    /// By node, the ions of metals that its photons ionise ([`ion`]), and their cross sections \[cm²\].
    pub metals: Vec<Vec<(usize, f64)>>,
    /// Variant by ion, with what photons of each node do to it.
    pub ions: Vec<(usize, Vec<Absorption>)>,
}

/// Nodes of the gas's own light.
pub const OWN_NODES: usize = OWN.len();

/// A node that is being made: its energy, samples of its band with its Lagrange polynomial at each, and their shares in its
/// photons.
struct BandNode {
    energy_ev: f64,
    samples: Vec<f64>,
    lagrange: Vec<f64>,
    shares: Vec<f64>,
    /// Where light of recombinations begins that has an electron's energy on top.
    thermal: Option<f64>,
}

impl BandNode {
    /// The cross section of one of [`ABSORBERS`] \[cm²\], and that times the energy that an electron gets \[eV cm²\]. What
    /// weakens the light is what the node's own photons do; an electron's energy on top is not reckoned here.
    fn weakened_by(&self, (element, charge): (Element, usize)) -> (f64, f64) {
        let Some(fit) = &Atoms::get().transition(element, charge).light else { return (0.0, 0.0) };
        let (sigma, begins) = (fit.at(self.energy_ev), self.thermal.unwrap_or(self.energy_ev));
        (sigma, sigma * (begins - fit.threshold_ev).max(0.0))
    }

    /// The mean cross section of an ion of a metal over its samples \[cm²\], and that of it times the energy that an electron
    /// gets \[eV cm²\]; nothing where it does not ionise it.
    fn mean_of(&self, (element, charge): (Element, usize)) -> Option<(f64, f64)> {
        let fit = Atoms::get().transition(element, charge).light.as_ref()?;
        let over = |value: &dyn Fn(f64) -> f64| self.samples.iter().zip(&self.shares).map(|(e, share)| value(*e) * share).sum::<f64>();
        let (sigma, heat) = (over(&|e| fit.at(e)), over(&|e| fit.at(e) * (e - fit.threshold_ev)));
        (sigma != 0.0).then_some((sigma, heat))
    }
}

/// Photons at an energy in eV \[s⁻¹ eV⁻¹\].
pub type Photons<'a> = &'a dyn Fn(f64) -> f64;

impl IonisingLight {
    /// The nodes of a spectrum.
    pub fn new(spectrum: impl Fn(f64) -> f64) -> Self {
        Self::several(&[&spectrum]).remove(0)
    }

    /// Several spectra in the nodes of their sum: what they do to a gas together is what the sum of their photons does.
    pub fn several(spectra: &[Photons]) -> Vec<Self> {
        let emitted = OWN.into_iter().map(|(begins, is_thermal)| {
            let energy_ev = begins + if is_thermal { KINETIC_EV } else { 0.0 };
            let thermal = is_thermal.then_some(begins);
            BandNode { energy_ev, samples: vec![energy_ev], lagrange: vec![1.0], shares: vec![1.0], thermal }
        });
        let mut nodes: Vec<BandNode> = emitted.collect();
        let mut photons = vec![[0.0; NODES]; spectra.len()];
        let bands: Vec<NodeBand> = BANDS.into_iter().map(|band| NodeBand::new(band, spectra)).collect();
        let all: f64 = bands.iter().map(|band| band.photons).sum();
        // A band that hardly has a photon takes time alone.
        for band in bands.into_iter().filter(|band| band.photons > FAINTEST * all) {
            for (photons, mass) in photons.iter_mut().zip(&band.masses) {
                band.share_out(mass, &mut photons[nodes.len()..][..band.nodes.len()]);
            }
            nodes.extend(band.nodes);
        }
        let (mut weakening, mut warming) = ([[0.0; NODES]; ABSORBERS.len()], [[0.0; NODES]; ABSORBERS.len()]);
        let mut thermal = [[0.0; OWN_NODES]; ABSORBERS.len()];
        for (number, absorber) in ABSORBERS.into_iter().enumerate() {
            for (place, node) in nodes.iter().enumerate() {
                (weakening[number][place], warming[number][place]) = node.weakened_by(absorber);
                if node.thermal.is_some() {
                    thermal[number][place] = weakening[number][place];
                }
            }
        }
        let (mut metals, mut ions) = (vec![Vec::new(); nodes.len()], Vec::new());
        for (element, charge) in Element::METALS.into_iter().flat_map(|element| (0..element.charges()).map(move |charge| (element, charge)))
        {
            let ion = ion(element, charge);
            let photons = |(place, node): (usize, &BandNode)| {
                let (sigma, heat) = node.mean_of((element, charge))?;
                metals[place].push((ion, sigma));
                Some(Absorption { node: place, sigma, heat })
            };
            ions.push((ion, nodes.iter().enumerate().filter_map(photons).collect()));
        }
        let energies_ev: Vec<f64> = nodes.iter().map(|node| node.energy_ev).collect();
        let light = |photons| Self {
            energies_ev: energies_ev.clone(),
            photons,
            weakening,
            warming,
            thermal,
            metals: metals.clone(),
            ions: ions.clone(),
        };
        photons.into_iter().map(light).collect()
    }

    /// Light of a black body \[K\] with the given rate of photons above 13.6 eV \[s⁻¹\].
    pub fn blackbody(temperature: f64, ionising: f64) -> Self {
        let photons = |energy: f64| energy * energy / (energy / (BOLTZMANN_EV * temperature)).exp_m1();
        let light = Self::new(photons);
        let all = light.ionising();
        // So cold a body has none to be scaled.
        light.scaled(if all > 0.0 { ionising / all } else { 0.0 })
    }

    /// Copy of the spectrum with more or fewer photons.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.photons.iter_mut().for_each(|photons| *photons *= factor);
        self
    }

    /// Of numbers by node, the sum over those above 13.6 eV.
    pub fn ionising_of(&self, values: &ByNode) -> f64 {
        values.iter().zip(&self.energies_ev).filter(|(_, e)| **e > HYDROGEN_EV).map(|(value, _)| value).sum()
    }

    /// Photons of each node in parts of all; zeros of a star that has none.
    pub fn parts(&self) -> ByNode {
        let all = self.photons.iter().sum::<f64>();
        self.photons.map(|photons| if all > 0.0 { photons / all } else { 0.0 })
    }

    /// One for each node above 13.6 eV, zero for the others.
    pub fn ionises(&self) -> ByNode {
        std::array::from_fn(|node| if self.energies_ev.get(node).is_some_and(|e| *e > HYDROGEN_EV) { 1.0 } else { 0.0 })
    }

    /// Photons above 13.6 eV \[s⁻¹\].
    pub fn ionising(&self) -> f64 {
        self.ionising_of(&self.photons)
    }

    /// Opacity per node: Σ n σ of densities of [`ABSORBERS`] \[cm⁻¹\].
    pub fn opacity(&self, densities: [f64; ABSORBERS.len()], node: usize) -> f64 {
        densities.iter().zip(&self.weakening).map(|(n, sigma)| n * sigma[node]).sum()
    }
}

/// A band of nodes: the Gauss rule in ln E of the photons of all spectra.
struct NodeBand {
    nodes: Vec<BandNode>,
    /// Photons of all spectra, and of each at the samples.
    photons: f64,
    masses: Vec<Vec<f64>>,
}

impl NodeBand {
    fn new((low, high, count): (f64, f64, usize), spectra: &[Photons]) -> Self {
        let step = (high / low).ln() / SAMPLES as f64;
        let x: Vec<f64> = (0..SAMPLES).map(|i| low.ln() + (i as f64 + 0.5) * step).collect();
        let integrand = |spectrum: &Photons| x.iter().map(|x| spectrum(x.exp()) * x.exp() * step).collect();
        let masses: Vec<Vec<f64>> = spectra.iter().map(integrand).collect();
        let mass: Vec<f64> = (0..SAMPLES).map(|i| masses.iter().map(|mass| mass[i]).sum()).collect();
        let rule = gauss_of_measure(&x, &mass, count);
        let node = |(j, (emission, photons)): (usize, &(f64, f64))| {
            let others: Vec<f64> = rule.iter().enumerate().filter(|(i, _)| *i != j).map(|(_, (other, _))| *other).collect();
            let lagrange: Vec<f64> = x.iter().map(|x| others.iter().map(|other| (x - other) / (emission - other)).product()).collect();
            let shares = lagrange.iter().zip(&mass).map(|(lagrange, m)| m * lagrange / photons).collect();
            BandNode { energy_ev: emission.exp(), samples: x.iter().map(|x| x.exp()).collect(), lagrange, shares, thermal: None }
        };
        Self { nodes: rule.iter().enumerate().map(node).collect(), photons: mass.iter().sum(), masses }
    }

    /// The photons that a spectrum has at each node: as many in all as it has in the band, and nowhere less than none.
    fn share_out(&self, mass: &[f64], photons: &mut [f64]) {
        for (photons, node) in photons.iter_mut().zip(&self.nodes) {
            *photons = mass.iter().zip(&node.lagrange).map(|(m, lagrange)| m * lagrange).sum::<f64>().max(0.0);
        }
        let (all, shared): (f64, f64) = (mass.iter().sum(), photons.iter().sum());
        if shared > 0.0 {
            photons.iter_mut().for_each(|photons| *photons *= all / shared);
        }
    }
}
