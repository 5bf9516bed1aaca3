//! The benchmarks of Lexington: black bodies in uniform spheres, and what nine codes found.
//!
//! Source: Wood, Mathis & Ercolano 2004, MNRAS 348, 1337 (tables), Ferland et al. 1995 (the clouds).

use spectra::table::with_provenance;

use crate::atoms::{ELEMENTS, Element};
use crate::balance::{Accuracy, Diffuse, Gas};
use crate::light::IonisingLight;
use crate::sphere::Sphere;

const TABLE: &str = include_str!("../data/lexington.csv");

/// A cloud, and the star in it.
#[derive(Debug, Clone, Copy)]
pub struct Benchmark {
    /// Its name, as "HII40".
    pub name: &'static str,
    /// The black body's temperature \[K\].
    pub temperature: f64,
    /// Photons above 13.6 eV \[s⁻¹\].
    pub photons: f64,
    /// What the cloud is made of.
    pub gas: Gas,
    /// The hole in its middle, and where it ends at the latest \[cm\].
    pub radii_cm: [f64; 2],
}

const HII: [f64; ELEMENTS] = [1.0, 0.1, 2.2e-4, 4e-5, 3.3e-4, 5e-5, 9e-6];

/// The H II regions.
pub const BENCHMARKS: [Benchmark; 2] = [
    Benchmark { name: "HII40", temperature: 40_000.0, photons: 4.26e49, gas: Gas::new(100.0, HII), radii_cm: [3e18, 3e19] },
    Benchmark { name: "HII20", temperature: 20_000.0, photons: 1e49, gas: Gas::new(100.0, HII), radii_cm: [3e18, 3e19] },
];

/// A quantity: what the codes found, and what we find.
#[derive(Debug, Clone)]
pub struct Row {
    /// What it is, with its unit; lines are in parts of Hβ.
    pub quantity: &'static str,
    /// What the codes found, those that give it.
    pub codes: Vec<f64>,
    /// What we find.
    pub own: f64,
}

impl Row {
    /// The least and the largest of the codes.
    pub fn range(&self) -> [f64; 2] {
        self.codes.iter().fold([f64::INFINITY, 0.0], |[low, high], value| [value.min(low), value.max(high)])
    }

    /// The median of the codes.
    pub fn median(&self) -> f64 {
        let mut codes = self.codes.clone();
        codes.sort_by(f64::total_cmp);
        0.5 * (codes[(codes.len() - 1) / 2] + codes[codes.len() / 2])
    }

    /// Whether ours lies within the range, that much wider on both sides \[1\].
    pub fn is_within(&self, wider: f64) -> bool {
        let [low, high] = self.range();
        (low * (1.0 - wider)..=high * (1.0 + wider)).contains(&self.own)
    }
}

impl Benchmark {
    /// The cloud in balance.
    pub fn sphere(&self, diffuse: Diffuse, accuracy: &Accuracy) -> Sphere {
        let light = IonisingLight::blackbody(self.temperature, self.photons);
        Sphere::with_accuracy(self.gas, &light, diffuse, self.radii_cm, accuracy)
    }

    /// The table of the benchmark, with what a sphere has.
    ///
    /// # Panics
    /// Where the embedded table is broken; a test reads it.
    pub fn rows(&self, sphere: &Sphere) -> Vec<Row> {
        let body = with_provenance("lexington", TABLE).expect("embedded");
        let beta = sphere.line("Ba4-2");
        let lines = body.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
        let rows = lines.filter(|cells| cells[0] == self.name);
        let row = |cells: Vec<&'static str>| {
            let quantity = cells[1];
            // A unit of so many begins with its number.
            let unit: f64 =
                quantity.split_once("[1e").and_then(|(_, rest)| format!("1e{}", rest.split(' ').next()?).parse().ok()).unwrap_or(1.0);
            let own = match quantity.split(' ').next() {
                Some("L(Hb)") => beta / unit,
                Some("R") => sphere.front_cm(Element::Hydrogen, 0).unwrap_or(f64::NAN) / unit,
                Some("<He+>/<H+>") => sphere.helium(),
                Some("T") if quantity.contains("n_e") => sphere.temperature(),
                Some("T") => sphere.shells.first().map_or(f64::NAN, |shell| shell.state.temperature),
                _ => cells[2].split('+').map(|label| sphere.line(label)).sum::<f64>() / beta,
            };
            Row { quantity, codes: cells[3..].iter().filter_map(|cell| cell.parse().ok()).collect(), own }
        };
        rows.map(row).collect()
    }
}
