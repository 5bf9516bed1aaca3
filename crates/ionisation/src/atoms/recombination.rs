//! Recombination with electrons, from the ground level to all levels.
//!
//! Sources: Badnell 2006, ApJS 167, 334 (radiative); Badnell et al. 2003, A&A 406, 1151 and the papers of its series
//! (dielectronic). Below some 5000 K dielectronic rates of low ions are known within a factor of two.

use spectra::embedded::embedded_columns;

use super::Element;

const RADIATIVE: &str = include_str!("../../data/radiative_recombination.csv");
const DIELECTRONIC: &str = include_str!("../../data/dielectronic_recombination.csv");
/// Terms of a dielectronic fit at most.
const TERMS: usize = 9;

/// A fit to radiative recombination.
#[derive(Debug, Clone, PartialEq)]
pub struct Radiative {
    a: f64,
    b: f64,
    t_0: f64,
    t_1: f64,
    c: f64,
    t_2: f64,
}

impl Radiative {
    /// The rate coefficient at a temperature in K \[cm³ s⁻¹\].
    pub fn at(&self, temperature: f64) -> f64 {
        let b = self.b + self.c * (-self.t_2 / temperature).exp();
        let (u, v) = ((temperature / self.t_0).sqrt(), (temperature / self.t_1).sqrt());
        self.a / (u * (1.0 + u).powf(1.0 - b) * (1.0 + v).powf(1.0 + b))
    }
}

/// A fit to dielectronic recombination.
#[derive(Debug, Clone, PartialEq)]
pub struct Dielectronic(Vec<[f64; 2]>);

impl Dielectronic {
    /// The rate coefficient at a temperature in K \[cm³ s⁻¹\].
    pub fn at(&self, temperature: f64) -> f64 {
        self.0.iter().map(|[c, e]| c * (-e / temperature).exp()).sum::<f64>().max(0.0) * temperature.powf(-1.5)
    }
}

/// Gives each radiative fit to `put`, with the element and the charge of the ion that recombines.
pub(super) fn radiative(mut put: impl FnMut(Element, usize, &Radiative)) {
    let columns = embedded_columns("radiative recombination", RADIATIVE, 8).expect("embedded");
    for i in 0..columns[0].len() {
        let at = |column: usize| columns[column][i];
        if let Some(element) = Element::of_nucleus(at(0) as usize) {
            let fit = Radiative { a: at(2), b: at(3), t_0: at(4), t_1: at(5), c: at(6), t_2: at(7) };
            put(element, (at(0) - at(1)) as usize, &fit);
        }
    }
}

/// Variant of dielectronic fits.
pub(super) fn dielectronic(mut put: impl FnMut(Element, usize, &Dielectronic)) {
    let columns = embedded_columns("dielectronic recombination", DIELECTRONIC, 2 + 2 * TERMS).expect("embedded");
    for i in 0..columns[0].len() {
        let at = |column: usize| columns[column][i];
        if let Some(element) = Element::of_nucleus(at(0) as usize) {
            let terms = (0..TERMS).map(|term| [at(2 + term), at(2 + TERMS + term)]).filter(|[c, _]| *c != 0.0);
            put(element, (at(0) - at(1)) as usize, &Dielectronic(terms.collect()));
        }
    }
}
