//! Photo-ionisation from the ground state.
//!
//! Source: Verner, Ferland, Korista & Yakovlev 1996, ApJ 465, 487: fits to the valence shells, within which resonances
//! are averaged. Inner shells, from 170 eV on at the earliest (sulphur), are left out.

use spectra::embedded::embedded_columns;

use super::Element;

const TABLE: &str = include_str!("../../data/photoionisation.csv");

/// A cross section for light.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSection {
    /// Lower edge \[eV\].
    pub threshold_ev: f64,
    /// Upper limit of the fit \[eV\].
    pub end_ev: f64,
    e_0: f64,
    sigma_0: f64,
    y_a: f64,
    p: f64,
    y_w: f64,
    y_0: f64,
    y_1: f64,
}

impl CrossSection {
    /// The cross section at a photon energy \[cm²\].
    pub fn at(&self, energy_ev: f64) -> f64 {
        if !(self.threshold_ev..=self.end_ev).contains(&energy_ev) {
            return 0.0;
        }
        let x = energy_ev / self.e_0 - self.y_0;
        let y = x.hypot(self.y_1);
        let f = ((x - 1.0).powi(2) + self.y_w.powi(2)) * y.powf(0.5 * self.p - 5.5) * (1.0 + (y / self.y_a).sqrt()).powf(-self.p);
        1e-18 * self.sigma_0 * f
    }
}

/// Gives each fit of the table to `put`, with the element and the charge of the ion that is ionised.
pub(super) fn read(mut put: impl FnMut(Element, usize, &CrossSection)) {
    let columns = embedded_columns("photo-ionisation", TABLE, 11).expect("embedded");
    for i in 0..columns[0].len() {
        let at = |column: usize| columns[column][i];
        if let Some(element) = Element::of_nucleus(at(0) as usize) {
            let fit = CrossSection {
                threshold_ev: at(2),
                end_ev: at(3),
                e_0: at(4),
                sigma_0: at(5),
                y_a: at(6),
                p: at(7),
                y_w: at(8),
                y_0: at(9),
                y_1: at(10),
            };
            put(element, (at(0) - at(1)) as usize, &fit);
        }
    }
}
