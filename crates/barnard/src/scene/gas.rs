//! The `[gas]` table: gas that the scene's stars ionise, as the species that shine in its passbands.

use std::sync::Arc;

use ionisation::atoms::{Atoms, Element, EmissionLine, LineTable};
use ionisation::balance::{Gas, State};
use ionisation::benchmarks::BENCHMARKS;
use ionisation::cloud::{Cloud, Quantity, Settings, Star as Source};
use ionisation::light::{IonisingLight, Photons};
use spectra::constants::{ELECTRONVOLT, PLANCK, SPEED_OF_LIGHT, SPHERE};
use spectra::nebular::recombination_continuum;
use spectra::passband::Passband;
use spectra::spectrum::{Line, Spectrum};
use spectra::units::{NumberDensity, Temperature};

use super::loader::Glow;
use super::{Fields, Loader, Star};
use crate::error::Result;
use crate::field::{Field, Grid, Lattice};
use crate::memory;
use crate::properties::{Key, Section};

/// Nuclei of H, He, C, N, O, Ne and S for one of hydrogen, by name.
struct Abundances {
    name: &'static str,
    values: [f64; 7],
}

const ABUNDANCES: &[Abundances] = &[
    // Baldwin et al. 1991, ApJ 374, 580; Rubin et al. 1991, ApJ 374, 564; Osterbrock, Tran & Veilleux 1992, ApJ 389, 305.
    Abundances { name: "orion", values: [1.0, 0.095, 3.0e-4, 7.0e-5, 4.0e-4, 6.0e-5, 1.0e-5] },
    // Asplund et al. 2009, ARA&A 47, 481.
    Abundances { name: "solar", values: [1.0, 0.0851, 2.69e-4, 6.76e-5, 4.90e-4, 8.51e-5, 1.32e-5] },
    // The benchmark of Lexington.
    Abundances { name: "hii40", values: BENCHMARKS[0].gas.abundances },
];

pub(super) const KEYS: &[Key] = &[
    Key::required("density", "expression", "nuclei of hydrogen in cm-3, of the fields, such as \"n_H\""),
    Key::optional("abundances", "text or list", "orion", "orion, solar or hii40, or He, C, N, O, Ne and S for one nucleus of hydrogen"),
    Key::optional("voxels", "whole number", "96", "voxels along the longest edge where the density is a function; a grid's own otherwise"),
    Key::optional(
        "dust_absorption",
        "number",
        "0",
        "cross section that dust absorbs ionising light with, in cm2 for a nucleus of hydrogen, such as 1e-21",
    ),
];

/// Photons of a star, in parts of those of all, with which it is left out.
const FAINTEST: f64 = 1e-6;
/// Stars that ionise a gas at most.
const MOST_STARS: usize = 64;
/// Energies at which a star's photons are looked at \[eV\], before it is known whether it has any.
const LOOKED_AT: [f64; 8] = [14.0, 16.0, 19.0, 23.0, 28.0, 36.0, 50.0, 80.0];
/// Quantities that are asked for beside the species.
const BESIDE: usize = 3;
/// The part of a passband's largest response at which a line is left out.
const UNSEEN: f64 = 1e-3;
/// Lines of an ion stand together where their ratio changes by less than this over the conditions of nebulae.
const TOGETHER: f64 = 0.03;
/// Temperatures \[K\] and electron densities \[cm⁻³\] of those conditions, and where strengths are read.
const TEMPERATURES: [f64; 2] = [6500.0, 12_000.0];
const DENSITIES: [f64; 2] = [10.0, 1e4];
const USUAL: (f64, f64) = (9000.0, 100.0);
/// What gives every passband less than this part of its light is left out.
const DARK: f64 = 1e-3;
/// 1 erg s⁻¹ cm⁻³ = 0.1 W m⁻³, over the whole sphere.
const W_PER_M3_SR: f64 = 0.1 / SPHERE;
/// The energy of a photon of 1 µm \[eV\].
const EV_UM: f64 = 1e6 * PLANCK * SPEED_OF_LIGHT / ELECTRONVOLT;

/// The species of a `[gas]` table: one for each line, or some that always shine together, and one for the continuum.
pub(super) fn build(section: &Section, loader: &Loader, fields: &Fields, stars: &[Star], bands: &[Passband]) -> Result<Vec<Glow>> {
    section.check_keys(&KEYS.iter().map(|key| key.name).collect::<Vec<_>>())?;
    let density = fields.expression(section, "density", loader)?;
    let abundances = abundances(section)?;
    let voxels = section.integer("voxels", 8..=2048)?.unwrap_or(96) as usize;
    let dust_cm2 = section.number("dust_absorption", 0.0..=1e-15)?.unwrap_or(0.0);
    let stars = ionising(stars);
    if stars.len() > MOST_STARS {
        let message =
            format!("{} stars ionise it, at most {MOST_STARS} are followed: take fainter ones out, or put some into one", stars.len());
        return Err(section.error("density", message));
    }
    let spectra: Vec<_> = stars.iter().map(|star| photons(star)).collect();
    let known: Vec<Photons> = spectra.iter().map(|spectrum| spectrum as Photons).collect();
    let lights = IonisingLight::several(&known);
    let sources: Vec<Source> = stars.iter().zip(&lights).map(|(star, light)| Source { place: star.position, light }).collect();
    let species = Species::seen(bands);
    let lattice = density.grid().map_or_else(|| Lattice::along(density.bounds(), voxels), |grid| grid.lattice().clone());
    let nodes = lights.first().map_or(0, |light| light.energies_ev.len());
    let bytes = Cloud::bytes(lattice.cells(), stars.len(), nodes, species.len() + BESIDE);
    section.wrap("density", memory::check("the gas that stars ionise", bytes, loader.inputs.memory_limit))?;
    let grid = match density.grid() {
        Some(grid) => grid.clone(),
        None => Grid::of_function(&density, lattice, 1.0, &loader.control)?,
    };
    let Lattice { dims, bounds } = *grid.lattice();
    let values = grid.values();
    let voxel = grid.lattice().voxel_pc();
    let cloud = Cloud { dims, low: bounds.low, voxel, hydrogen: &values, abundances, dust_cm2 };
    let densest = values.iter().fold(0.0f32, |most, n| most.max(*n)).into();
    let functions: Vec<_> =
        species.iter().map(|species| move |gas: &Gas, state: &State| state.emission(gas, species.table, species.lines[0])).collect();
    let pairs = |gas: &Gas, state: &State| state.electrons * state.density(gas, Element::Hydrogen, 1);
    let mut quantities: Vec<Quantity> =
        species.iter().zip(&functions).map(|(species, value)| Quantity { most: species.most(densest, &abundances), value }).collect();
    let most = 2.0 * densest * densest;
    let warm = |gas: &Gas, state: &State| pairs(gas, state) * state.temperature;
    let thick = |gas: &Gas, state: &State| pairs(gas, state) * state.electrons;
    quantities.push(Quantity { most, value: &pairs });
    quantities.push(Quantity { most: 6e4 * most, value: &warm });
    quantities.push(Quantity { most: 2.0 * densest * most, value: &thick });
    let settings = Settings { memory_limit: loader.inputs.memory_limit, ..Settings::default() };
    let found = cloud.ionised(&sources, &settings, &quantities).map_err(|e| section.error("density", e.to_string()))?;
    let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
    let mut quantities = found.quantities;
    let [thick, warm, pairs] = std::array::from_fn(|_| quantities.pop().unwrap_or_default());
    let through = |band: &Passband| species.iter().zip(&quantities).map(|(species, values)| species.through(band) * sum(values)).collect();
    let by_band: Vec<Vec<f64>> = bands.iter().map(through).collect();
    let counts = |i: usize| by_band.iter().any(|light| light[i] > DARK * light.iter().sum::<f64>());
    let counts: Vec<bool> = (0..species.len()).map(counts).collect();
    let gridded = |values: Vec<f32>| Arc::new(Grid::of(Lattice { dims, bounds }, values)) as Arc<dyn Field>;
    let mut emission = Vec::new();
    for ((species, values), counts) in species.iter().zip(quantities).zip(counts) {
        if counts {
            emission.push((species.name(), gridded(values), species.spectrum()));
        }
    }
    let all = sum(&pairs);
    if all > 0.0 {
        let temperature = Temperature((sum(&warm) / all).clamp(6000.0, 15_000.0));
        let electrons = NumberDensity((sum(&thick) / all).clamp(100.0, 1e4));
        let spectrum = section.wrap("density", recombination_continuum(temperature, electrons))?;
        emission.push(("hydrogen's continuum".into(), gridded(pairs), spectrum));
    }
    Ok(emission)
}

/// The abundances by name, or as a list.
fn abundances(section: &Section) -> Result<[f64; 7]> {
    if let Ok(Some(values)) = section.numbers("abundances") {
        let [helium, carbon, nitrogen, oxygen, neon, sulphur] = values[..] else {
            return Err(section.error("abundances", "six numbers: He, C, N, O, Ne and S for one nucleus of hydrogen"));
        };
        return Ok([1.0, helium, carbon, nitrogen, oxygen, neon, sulphur]);
    }
    let names: Vec<&'static str> = ABUNDANCES.iter().map(|row| row.name).collect();
    let name = section.choice("abundances", &names)?.unwrap_or(ABUNDANCES[0].name);
    Ok(ABUNDANCES.iter().find(|row| row.name == name).map_or(ABUNDANCES[0].values, |row| row.values))
}

/// The stars that have ionising photons.
fn ionising(stars: &[Star]) -> Vec<&Star> {
    let most = |star: &Star| LOOKED_AT.into_iter().map(photons(star)).fold(0.0, f64::max);
    let all: f64 = stars.iter().map(most).sum();
    stars.iter().filter(|star| most(star) > FAINTEST * all).collect()
}

/// A star's photons at an energy in eV \[s⁻¹ eV⁻¹\].
fn photons(star: &Star) -> impl Fn(f64) -> f64 + use<'_> {
    |energy| {
        let per_um = star.spectrum.continuum(EV_UM / energy);
        // |dλ/dE| = λ/E.
        per_um * EV_UM / (energy * energy) / (energy * ELECTRONVOLT)
    }
}

/// Lines of an ion that always shine together.
struct Species {
    table: &'static LineTable,
    /// The strongest first.
    lines: Vec<&'static EmissionLine>,
}

impl Species {
    /// Those of which a line is seen through a passband.
    fn seen(bands: &[Passband]) -> Vec<Self> {
        let atoms = Atoms::get();
        let is_seen = |line: &&EmissionLine| bands.iter().any(|band| band.response(line.wavelength_um) > UNSEEN * band.largest());
        let mut species: Vec<Self> = Vec::new();
        for table in [&atoms.recombination, &atoms.collisional] {
            let usual = table.conditions(USUAL.0, USUAL.1);
            let mut lines: Vec<&'static EmissionLine> = table.lines.iter().filter(is_seen).collect();
            lines.sort_by(|a, b| table.emissivity(b, &usual).total_cmp(&table.emissivity(a, &usual)));
            for line in lines {
                match species.iter_mut().find(|species| std::ptr::eq(species.table, table) && species.has_like(line)) {
                    Some(species) => species.lines.push(line),
                    None => species.push(Self { table, lines: vec![line] }),
                }
            }
        }
        species
    }

    /// Whether a line shines as the first does.
    fn has_like(&self, line: &EmissionLine) -> bool {
        let first = self.lines[0];
        if (first.element, first.charge) != (line.element, line.charge) {
            return false;
        }
        let ratio = |temperature: f64, electrons: f64| {
            let at = self.table.conditions(temperature, electrons);
            self.table.emissivity(line, &at) / self.table.emissivity(first, &at)
        };
        let ratios = TEMPERATURES.into_iter().flat_map(|t| DENSITIES.map(|n| ratio(t, n)));
        let (low, high) = ratios.fold((f64::INFINITY, 0.0f64), |(low, high), ratio| (low.min(ratio), high.max(ratio)));
        high - low < TOGETHER * high
    }

    /// The most that it can be in gas of at most this density.
    fn most(&self, densest: f64, abundances: &[f64; 7]) -> f64 {
        let emissivity = |t: f64| self.table.emissivity(self.lines[0], &self.table.conditions(t, 1.0));
        let most = (1..=30).map(|t| emissivity(1000.0 * f64::from(t))).fold(0.0, f64::max);
        2.0 * densest * densest * abundances[self.lines[0].element as usize] * most
    }

    /// Its lines for an emission of one \[W m⁻³ sr⁻¹ for 1 erg cm⁻³ s⁻¹\].
    fn spectrum(&self) -> Spectrum {
        let at = self.table.conditions(USUAL.0, USUAL.1);
        let first = self.table.emissivity(self.lines[0], &at);
        let line =
            |line: &&EmissionLine| Line { lambda_um: line.wavelength_um, strength: W_PER_M3_SR * self.table.emissivity(line, &at) / first };
        Spectrum::of_lines(self.lines.iter().map(line).collect())
    }

    /// What of its light a passband lets through, in parts of the strongest line.
    fn through(&self, band: &Passband) -> f64 {
        self.spectrum().lines().iter().map(|line| line.strength / W_PER_M3_SR * band.response(line.lambda_um) / band.largest()).sum()
    }

    fn name(&self) -> String {
        self.lines[0].label.clone()
    }
}
