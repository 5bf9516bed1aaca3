//! Species of a gas: lines that its ions shine in, as passbands see them.

use ionisation::atoms::{Atoms, EmissionLine, LineTable};
use spectra::constants::{ATOMIC_MASS, BOLTZMANN, SPHERE};
use spectra::passband::Passband;
use spectra::spectrum::{Line, Spectrum};
use spectra::units::Velocity;

/// The part of a passband's largest response at which a line is left out.
const UNSEEN: f64 = 1e-3;
/// Lines of an ion stand together where their ratio changes by less than this over the conditions of nebulae.
const TOGETHER: f64 = 0.03;
/// Temperatures \[K\] and electron densities \[cm⁻³\] of those conditions, and where strengths are read.
const TEMPERATURES: [f64; 2] = [6500.0, 12_000.0];
const DENSITIES: [f64; 2] = [10.0, 1e4];
const USUAL: (f64, f64) = (9000.0, 100.0);
/// 1 erg s⁻¹ cm⁻³ = 0.1 W m⁻³, over the whole sphere.
const W_PER_M3_SR: f64 = 0.1 / SPHERE;

/// Lines of an ion that always shine together.
pub struct Species {
    /// The table that they are of.
    pub table: &'static LineTable,
    /// The strongest first.
    pub lines: Vec<&'static EmissionLine>,
}

impl Species {
    /// Species with a line in a passband.
    pub fn seen(bands: &[Passband]) -> Vec<Self> {
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

    /// True if a line shines as the first does.
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

    /// Its lines for an emission of one \[W m⁻³ sr⁻¹ for 1 erg cm⁻³ s⁻¹\].
    pub fn spectrum(&self) -> Spectrum {
        let at = self.table.conditions(USUAL.0, USUAL.1);
        let first = self.table.emissivity(self.lines[0], &at);
        let line =
            |line: &&EmissionLine| Line { lambda_um: line.wavelength_um, strength: W_PER_M3_SR * self.table.emissivity(line, &at) / first };
        Spectrum::of_lines(self.lines.iter().map(line).collect())
    }

    /// Thermal line width at a temperature \[K\]: √(8 ln 2 k T/m).
    pub fn thermal_fwhm(&self, kelvin: f64) -> Velocity {
        let metres_per_second = (8.0 * std::f64::consts::LN_2 * BOLTZMANN * kelvin / (self.lines[0].element.mass_u() * ATOMIC_MASS)).sqrt();
        Velocity(metres_per_second * 1e-3)
    }

    /// Transmission of its lines through a passband, relative to the strongest line.
    pub fn through(&self, band: &Passband) -> f64 {
        self.spectrum().lines().iter().map(|line| line.strength / W_PER_M3_SR * band.response(line.lambda_um) / band.largest()).sum()
    }

    /// Name that no other species has: label and vacuum wavelength of the strongest line \[µm\].
    pub fn identifier(&self) -> String {
        format!("{} {}", self.lines[0].label, self.lines[0].wavelength_um)
    }

    /// The label of the strongest.
    pub fn name(&self) -> String {
        self.lines[0].label.clone()
    }
}
