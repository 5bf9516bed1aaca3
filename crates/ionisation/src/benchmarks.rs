//! The benchmarks of Lexington: black bodies in uniform spheres, and what nine codes found.
//!
//! Source: Wood, Mathis & Ercolano 2004, MNRAS 348, 1337 (tables), Ferland et al. 1995 (the clouds).

use spectra::embedded::with_provenance;

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
    /// Composition of the cloud.
    pub gas: Gas,
    /// The hole in its middle, and where it ends at the latest \[cm\].
    pub radii_cm: [f64; 2],
}

const HII: [f64; ELEMENTS] = [1.0, 0.1, 2.2e-4, 4e-5, 3.3e-4, 5e-5, 0.0, 0.0, 9e-6];

const PN75: [f64; ELEMENTS] = [1.0, 0.1, 2e-4, 6e-5, 3e-4, 6e-5, 1e-5, 1e-5, 1e-5];
const PN150: [f64; ELEMENTS] = [1.0, 0.1, 3e-4, 1e-4, 6e-4, 1.5e-4, 3e-5, 3e-5, 1.5e-5];

/// The H II regions, and the planetary nebulae.
pub const BENCHMARKS: [Benchmark; 4] = [
    Benchmark { name: "HII40", temperature: 40_000.0, photons: 4.26e49, gas: Gas::new(100.0, HII), radii_cm: [3e18, 3e19] },
    Benchmark { name: "HII20", temperature: 20_000.0, photons: 1e49, gas: Gas::new(100.0, HII), radii_cm: [3e18, 3e19] },
    Benchmark { name: "PN75", temperature: 75_000.0, photons: 3.85e47, gas: Gas::new(500.0, PN75), radii_cm: [1.5e17, 7.5e17] },
    Benchmark { name: "PN150", temperature: 150_000.0, photons: 5.42e47, gas: Gas::new(3000.0, PN150), radii_cm: [1e17, 1e18] },
];

/// A quantity: what the codes found, and what we find.
#[derive(Debug, Clone)]
pub struct BenchmarkRow {
    /// Quantity and unit; lines are relative to Hβ.
    pub quantity: &'static str,
    /// Published results of the codes, if given.
    pub codes: Vec<f64>,
    /// Result of this crate.
    pub found: f64,
}

impl BenchmarkRow {
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

    /// True if ours lies within the range, that much wider on both sides \[1\].
    pub fn is_within(&self, wider: f64) -> bool {
        let [low, high] = self.range();
        (low * (1.0 - wider)..=high * (1.0 + wider)).contains(&self.found)
    }
}

impl Benchmark {
    /// The cloud in balance.
    pub fn sphere(&self, diffuse: Diffuse, accuracy: &Accuracy) -> Sphere {
        let light = IonisingLight::blackbody(self.temperature, self.photons);
        Sphere::with_accuracy(self.gas, &light, diffuse, self.radii_cm, accuracy)
    }

    /// The cloud in balance with its own light in all directions: what [`sphere`](Self::sphere) is held to.
    pub fn isotropic(&self, accuracy: &Accuracy) -> Sphere {
        let light = IonisingLight::blackbody(self.temperature, self.photons);
        Sphere::isotropic(self.gas, &light, self.radii_cm, accuracy)
    }

    /// The table of the benchmark, with what a sphere has.
    pub fn rows(&self, sphere: &Sphere) -> Vec<BenchmarkRow> {
        self.rows_of(&Found {
            line: &|label| sphere.line(label),
            radius_cm: sphere.front_cm(Element::Hydrogen, 0).unwrap_or(f64::NAN),
            helium: sphere.helium(),
            temperature: sphere.temperature(),
            inner_temperature: sphere.shells.first().map_or(f64::NAN, |shell| shell.state.temperature),
        })
    }

    /// The table of the benchmark, with what a cloud has.
    ///
    /// # Panics
    /// Where the embedded table is broken; a test reads it.
    pub fn rows_of(&self, found: &Found) -> Vec<BenchmarkRow> {
        let beta = (found.line)("Ba4-2");
        let row = |cells: Vec<&'static str>| {
            let quantity = cells[1];
            // A unit with a factor begins with its number.
            let unit: f64 =
                quantity.split_once("[1e").and_then(|(_, rest)| format!("1e{}", rest.split(' ').next()?).parse().ok()).unwrap_or(1.0);
            let unit = match quantity.split(' ').next() {
                Some("L(Hb)") => beta / unit,
                Some("R") => found.radius_cm / unit,
                Some("<He+>/<H+>") => found.helium,
                Some("T") if quantity.contains("n_e") => found.temperature,
                Some("T") => found.inner_temperature,
                _ => cells[2].split('+').map(found.line).sum::<f64>() / beta,
            };
            BenchmarkRow { quantity, codes: cells[3..].iter().filter_map(|cell| cell.parse().ok()).collect(), found: unit }
        };
        table().filter(|cells| cells[0] == self.name).map(row).collect()
    }
}

/// The rows of the embedded table.
fn table() -> impl Iterator<Item = Vec<&'static str>> {
    let body = with_provenance("lexington", TABLE).expect("embedded");
    body.lines().filter(|line| !line.starts_with('#')).skip(1).map(|line| line.split(',').collect())
}

/// The labels of the lines that benchmarks ask for.
pub fn labels() -> Vec<&'static str> {
    let mut labels: Vec<&str> = table().flat_map(|cells| cells[2].split('+')).filter(|label| !label.is_empty()).collect();
    labels.sort_unstable();
    labels.dedup();
    labels
}

/// Benchmark quantities of a cloud.
pub struct Found<'a> {
    /// The power of a line by its label \[erg s⁻¹\].
    pub line: &'a dyn Fn(&str) -> f64,
    /// Radius of hydrogen's ionisation front \[cm\].
    pub radius_cm: f64,
    /// The part of helium's nuclei that are He⁺ for that of hydrogen's that are H⁺.
    pub helium: f64,
    /// The temperature, weighted by n_p n_e, and that at the inner edge \[K\].
    pub temperature: f64,
    /// See [`temperature`](Self::temperature).
    pub inner_temperature: f64,
}
