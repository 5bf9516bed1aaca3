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

use crate::atoms::{Atoms, Element, STAGES, TRIPLET_EV, TWO_PHOTON_EV};

/// Where bands of nodes begin and end \[eV\], and how many nodes they have: what ionises neutral carbon and sulphur,
/// hydrogen, neon as well, helium, and He⁺. Within a few tenths of an electronvolt of where light of hydrogen's band ends
/// stand thresholds of Ne⁰ and S⁺: a short band leaves little to interpolate there.
const BANDS: [(f64, f64, usize); 6] =
    [(10.36, 13.6, 2), (13.6, 18.0, 3), (18.0, 21.56, 2), (21.56, 24.59, 2), (24.59, 54.42, 6), (54.42, 500.0, 6)];
/// The band that hydrogen absorbs first.
const IONISING: f64 = 13.6;
/// Samples of the spectrum in a band.
const SAMPLES: usize = 600;
/// The gas's own light: where it begins \[eV\], and whether an electron's kinetic energy comes on top. These are
/// recombinations to the ground of hydrogen and helium, helium's triplets, and its two-photon decays.
const OWN: [(f64, bool); 4] = [(13.6, true), (24.59, true), (TRIPLET_EV, false), (TWO_PHOTON_EV, false)];
/// That kinetic energy, where cross sections are read \[eV\]: k T at 10⁴ K.
const KINETIC_EV: f64 = 0.85;
/// Absorbers that weaken light.
pub const ABSORBERS: [(Element, usize); 3] = [(Element::Hydrogen, 0), (Element::Helium, 0), (Element::Helium, 1)];

/// What light does to one kind of ion.
#[derive(Debug, Clone)]
pub struct Absorption {
    /// The ion's element.
    pub element: Element,
    /// Its charge before.
    pub charge: usize,
    /// The cross section at each node \[cm²\].
    pub sigma: Vec<f64>,
    /// That times the energy that an electron gets \[eV cm²\].
    pub heat: Vec<f64>,
    /// The cross section where a photon has the energy beside that which a recombining electron had \[cm²\].
    pub thermal: Vec<f64>,
}

/// A star's ionising light.
#[derive(Debug, Clone)]
pub struct IonisingLight {
    /// Photon energies of the nodes \[eV\].
    pub energies_ev: Vec<f64>,
    /// Photons that leave the star in each \[s⁻¹\].
    pub photons: Vec<f64>,
    /// What ions make of a photon of each node, those of [`ABSORBERS`] first.
    pub absorptions: Vec<Absorption>,
}

impl IonisingLight {
    /// The nodes of a spectrum of photons \[s⁻¹ eV⁻¹ at an energy in eV\].
    pub fn new(spectrum: impl Fn(f64) -> f64) -> Self {
        let (mut energies_ev, mut photons) = (Vec::new(), Vec::new());
        // Of each node, the samples of its band and their shares in it.
        let mut shares: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        for (low, high, count) in BANDS {
            let step = (high / low).ln() / SAMPLES as f64;
            let x: Vec<f64> = (0..SAMPLES).map(|i| low.ln() + (i as f64 + 0.5) * step).collect();
            let mass: Vec<f64> = x.iter().map(|x| spectrum(x.exp()) * x.exp() * step).collect();
            let rule = gauss_of_measure(&x, &mass, count);
            for (j, (node, weight)) in rule.iter().enumerate() {
                let others = || rule.iter().enumerate().filter(|(i, _)| *i != j).map(|(_, (other, _))| *other);
                let lagrange = |x: f64| others().map(|other| (x - other) / (node - other)).product::<f64>();
                energies_ev.push(node.exp());
                photons.push(*weight);
                shares.push((x.iter().map(|x| x.exp()).collect(), x.iter().zip(&mass).map(|(x, m)| m * lagrange(*x) / weight).collect()));
            }
        }
        for (begins, is_thermal) in OWN {
            let energy = begins + if is_thermal { KINETIC_EV } else { 0.0 };
            energies_ev.push(energy);
            photons.push(0.0);
            shares.push((vec![energy], vec![1.0]));
        }
        let atoms = Atoms::get();
        let exact = ABSORBERS.iter().filter_map(|(element, charge)| {
            let fit = atoms.step(*element, *charge).light.as_ref()?;
            let sigma: Vec<f64> = energies_ev.iter().map(|e| fit.at(*e)).collect();
            let mut heat: Vec<f64> = energies_ev.iter().zip(&sigma).map(|(e, sigma)| sigma * (e - fit.threshold_ev)).collect();
            let mut thermal = vec![0.0; sigma.len()];
            let own = sigma.len() - OWN.len();
            for (node, (begins, is_thermal)) in (own..).zip(OWN) {
                if is_thermal {
                    heat[node] = sigma[node] * (begins - fit.threshold_ev).max(0.0);
                    thermal[node] = sigma[node];
                }
            }
            Some(Absorption { element: *element, charge: *charge, sigma, heat, thermal })
        });
        let ions = Element::METALS.into_iter().flat_map(|element| (0..STAGES).map(move |charge| (element, charge)));
        let of_metals = ions.filter_map(|(element, charge)| {
            let fit = atoms.step(element, charge).light.as_ref().filter(|_| charge < element.charges())?;
            let over = |value: &dyn Fn(f64) -> f64| {
                shares.iter().map(|(e, share)| e.iter().zip(share).map(|(e, share)| value(*e) * share).sum()).collect()
            };
            let (sigma, heat) = (over(&|e| fit.at(e)), over(&|e| fit.at(e) * (e - fit.threshold_ev)));
            let thermal = vec![0.0; energies_ev.len()];
            Some(Absorption { element, charge, sigma, heat, thermal })
        });
        let absorptions = exact.chain(of_metals).collect();
        Self { absorptions, energies_ev, photons }
    }

    /// That of a black body \[K\] with so many photons above 13.6 eV \[s⁻¹\].
    pub fn blackbody(temperature: f64, ionising: f64) -> Self {
        let photons = |energy: f64| energy * energy / (energy / (crate::atoms::BOLTZMANN_EV * temperature)).exp_m1();
        let light = Self::new(photons);
        let factor = ionising / light.ionising();
        light.scaled(factor)
    }

    /// The same spectrum with more or fewer photons.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.photons.iter_mut().for_each(|photons| *photons *= factor);
        self
    }

    /// Photons above 13.6 eV \[s⁻¹\].
    pub fn ionising(&self) -> f64 {
        self.photons.iter().zip(&self.energies_ev).filter(|(_, e)| **e > IONISING).map(|(photons, _)| photons).sum()
    }

    /// The nodes of the gas's own light, which the star has none of: recombinations to the ground of hydrogen and of
    /// helium, photons of 19.8 eV, and of two-photon decays.
    pub fn own(&self) -> std::ops::Range<usize> {
        self.photons.len() - OWN.len()..self.photons.len()
    }

    /// What absorbs, by node: Σ n σ of densities of [`ABSORBERS`] \[cm⁻¹\].
    pub fn opacity(&self, densities: [f64; ABSORBERS.len()], node: usize) -> f64 {
        densities.iter().zip(&self.absorptions).map(|(n, absorption)| n * absorption.sigma[node]).sum()
    }
}
