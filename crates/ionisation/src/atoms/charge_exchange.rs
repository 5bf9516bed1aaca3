//! Charge exchange of metals with hydrogen.
//!
//! Sources: Kingdon & Ferland 1996, ApJS 106, 205; O⁰ and O⁺, whose ratio hydrogen's own locks, Stancil et al. 1999,
//! A&AS 140, 225, in the fit of Huang et al. 2023, ApJ 951, 123, to O⁺ + H⁰, and the other way round by detailed balance; N²⁺ and O²⁺ Barragán et al. 2006,
//! ApJ 636, 544.

use spectra::embedded::with_provenance;

use super::Element;

const TABLE: &str = include_str!("../../data/charge_exchange.csv");

/// Whom an ion gives an electron to, or takes it from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Partner {
    /// X^q + H⁺ → X^(q+1) + H⁰.
    Proton,
    /// X^q + H⁰ → X^(q−1) + H⁺.
    Hydrogen,
}

/// A rate of charge exchange.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Exchange {
    /// Of Kingdon & Ferland: 10⁻⁹ a t^b (1 + c e^(d t)) e^(−dE/t), t = T/10⁴ K within a range.
    Fit {
        /// \[10⁻⁹ cm³ s⁻¹\]
        a: f64,
        /// \[1\]
        b: f64,
        /// \[1\]
        c: f64,
        /// \[1\]
        d: f64,
        /// dE \[10⁴ K\]
        energy: f64,
        /// Range of the fit \[K\].
        low: f64,
        /// \[K\]
        high: f64,
    },
    /// Sums of a t^b, times e^(−E/T).
    Powers {
        /// a and b of each.
        terms: [[f64; 2]; 2],
        /// E \[K\].
        energy: f64,
    },
    /// a + b (log₁₀ T/T₀)^p above T₀ \[K\], a (T/T₀)^q below.
    Logarithmic {
        /// \[cm³ s⁻¹\]
        a: f64,
        /// \[cm³ s⁻¹\]
        b: f64,
        /// T₀ \[K\]
        from: f64,
        /// p and q.
        powers: [f64; 2],
    },
}

impl Exchange {
    /// The rate coefficient at a temperature in K \[cm³ s⁻¹\].
    pub fn at(&self, temperature: f64) -> f64 {
        match *self {
            Self::Fit { a, b, c, d, energy, low, high } => {
                let t = 1e-4 * temperature.clamp(low, high);
                1e-9 * a * t.powf(b) * (1.0 + c * (d * t).exp()) * (-1e4 * energy / temperature).exp()
            }
            Self::Powers { terms, energy } => {
                let t = 1e-4 * temperature;
                terms.iter().map(|[a, b]| a * t.powf(*b)).sum::<f64>() * (-energy / temperature).exp()
            }
            Self::Logarithmic { a, b, from, powers: [above, below] } => {
                let ratio = temperature / from;
                if ratio > 1.0 { a + b * ratio.log10().powf(above) } else { a * ratio.powf(below) }
            }
        }
    }
}

/// Gives each rate to `put`, with the element, the charge before, and the partner.
pub(super) fn read(mut put: impl FnMut(Element, usize, Partner, &Exchange)) {
    let text = with_provenance("charge exchange", TABLE).expect("embedded");
    for line in text.lines().filter(|line| !line.starts_with('#') && !line.starts_with("kind")) {
        let (kind, numbers) = line.split_once(',').expect("embedded");
        let numbers: Vec<f64> = numbers.split(',').map(|number| number.parse().expect("embedded")).collect();
        let [nucleus, charge, a, b, c, d, energy, low, high] = numbers[..] else { panic!("embedded: {line}") };
        let partner = if kind == "ionisation" { Partner::Proton } else { Partner::Hydrogen };
        if let Some(element) = Element::of_nucleus(nucleus as usize) {
            put(element, charge as usize, partner, &Exchange::Fit { a, b, c, d, energy, low, high });
        }
    }
    put(Element::Oxygen, 2, Partner::Hydrogen, &Exchange::Logarithmic { a: 4.344e-10, b: 6.340e-10, from: 1500.0, powers: [2.06, -0.076] });
    put(Element::Nitrogen, 2, Partner::Hydrogen, &Exchange::Powers { terms: [[9.703e-10, 0.058], [0.0, 0.0]], energy: 0.0 });
    // There as many as back, in equilibrium: eight ninths by the weights of the levels, and 227 K of energy.
    let back = [[2.08e-9, 0.405], [1.11e-11, -0.458]];
    put(Element::Oxygen, 1, Partner::Hydrogen, &Exchange::Powers { terms: back, energy: 0.0 });
    put(Element::Oxygen, 0, Partner::Proton, &Exchange::Powers { terms: back.map(|[a, b]| [8.0 / 9.0 * a, b]), energy: 227.0 });
}
