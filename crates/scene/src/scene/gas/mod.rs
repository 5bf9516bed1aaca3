//! The `[gas]` table: gas that the scene's stars ionise, as the species that shine in its passbands.

mod cloud;
pub(super) mod ionised;
mod species;

use std::sync::Arc;

use ionisation::atoms::ELEMENTS;
use ionisation::balance::{Accuracy, COLDEST, Diffuse, Gas, HOTTEST, State};
use ionisation::benchmarks::BENCHMARKS;
use ionisation::cloud::Quantity;
use ionisation::error::IonisationError;
use spectra::nebular::recombination_continuum;
use spectra::passband::Passband;
use spectra::units::{NumberDensity, Temperature, Velocity};

pub use cloud::{GasCloud, IonisingStar};
pub use ionised::IonisedGas;
use species::Species;

use super::{Fields, Loader, Star, emission, fields, motion, star};
use crate::error::{Error, Result};
use crate::field::{Field, Grid, Lattice};
use crate::memory;
use crate::properties::{
    Choice, Choices, Entry, Formula, Integer, Key, KeyRow, Number, Numbers, OrDefault, Range, Required, Section, Text, Type, ValueType,
};

/// Nuclei of H, He, C, N, O, Ne, Mg, Si and S for one of hydrogen, by name.
struct Abundances {
    name: &'static str,
    values: [f64; ELEMENTS],
}

const ABUNDANCE_SETS: &[Abundances] = &[
    // Baldwin et al. 1991, ApJ 374, 580; Rubin et al. 1991, ApJ 374, 564; Osterbrock, Tran & Veilleux 1992, ApJ 389, 305. Gas phase:
    // most magnesium and silicon is in grains.
    Abundances { name: "orion", values: [1.0, 0.095, 3.0e-4, 7.0e-5, 4.0e-4, 6.0e-5, 3.0e-6, 4.0e-6, 1.0e-5] },
    // Asplund et al. 2009, ARA&A 47, 481. Solar photosphere, without depletion.
    Abundances { name: "solar", values: [1.0, 0.0851, 2.69e-4, 6.76e-5, 4.90e-4, 8.51e-5, 3.98e-5, 3.24e-5, 1.32e-5] },
    // Russell & Dopita 1992, ApJ 384, 508: 10.94, 8.04, 7.14, 8.35, 7.61 and 6.70 as 12 + lg N/H; magnesium
    // and silicon are assumed to be in grains.
    Abundances { name: "lmc", values: [1.0, 0.0871, 1.10e-4, 1.38e-5, 2.24e-4, 4.07e-5, 0.0, 0.0, 5.01e-6] },
    // The benchmark of Lexington.
    Abundances { name: "hii40", values: BENCHMARKS[0].gas.abundances },
];

const DENSITY: Key<Formula, Required> =
    Key::formula("density", "hydrogen nuclei in cm-3, an expression of fields such as \"n_H\"").required();
const ABUNDANCES: Key<AbundanceValue, OrDefault> = Key::<AbundanceValue>::new(
    "abundances",
    "orion, solar, lmc or hii40, or He, C, N, O, Ne, Mg, Si and S per hydrogen nucleus; six numbers omit Mg and Si",
)
.or("orion");
const VOXELS: Key<Integer<usize>> = Key::integer("voxels", "voxels along the longest edge; more than those of the grid make fronts finer")
    .range(8..=2048)
    .otherwise("those of the grid; 96 for a function");
const DUST_ABSORPTION: Key<Number, OrDefault> =
    Key::number("dust_absorption", "cross section of dust for ionising light in cm2 per hydrogen nucleus, such as 1e-21")
        .range(0.0..=1e-15)
        .default(0.0);
const TEMPERATURE: Key<Temperature> = Key::quantity::<Temperature>("temperature", "fixed electron temperature")
    .range(COLDEST..=HOTTEST)
    .otherwise("thermal equilibrium")
    .example("\"8000 K\"");
const DIFFUSE: Key<Choice<Diffuse>, OrDefault> = Key::choice(
    "diffuse",
    "treatment of recombination light: outward (transported along the stars' rays) or on_the_spot (absorbed where it is emitted)",
)
.default("outward");
const DOPPLER_FWHM: Key<Velocity, OrDefault> = emission::doppler_fwhm(
    "turbulent full width at half maximum of the lines; the thermal width, 19 km/s for hydrogen at 8000 K, is added in quadrature",
)
.default("0 km/s");

pub(super) const KEYS: &[KeyRow] = &[
    DENSITY.row,
    ABUNDANCES.row,
    VOXELS.row,
    DUST_ABSORPTION.row,
    TEMPERATURE.row,
    DIFFUSE.row,
    DOPPLER_FWHM.row,
    fields::VELOCITY.row,
    motion::STEP.row,
];

impl Choices for Diffuse {
    const ROWS: &'static [(&'static str, Self)] = &[("outward", Self::Outward), ("on_the_spot", Self::OnTheSpot)];
}

/// Stars that ionise a gas at most.
const MOST_STARS: usize = 64;
/// Voxels along the longest edge of a function that does not say how many.
const VOXELS_OF_FUNCTION: usize = 96;
/// Quantities that are asked for beside the species.
const BESIDE: usize = 3;
/// What gives every passband less than this part of its light is left out.
const DARK: f64 = 1e-3;
/// Voxels along the longest edge for a first look.
const ROUGH: usize = 48;

/// Reads a `[gas]` table, and has the stars ionise it.
pub(super) fn build(section: &Section, loader: &Loader, fields: &Fields, stars: &[Star], bands: &[Passband]) -> Result<IonisedGas> {
    let mut cloud = read(section, loader, fields, stars)?;
    if loader.is_rough {
        cloud = cloud.coarser(ROUGH);
    }
    let turbulent = section.read(&DOPPLER_FWHM)?;
    let species = Species::seen(bands);
    let bytes = cloud.bytes(species.len() + BESIDE);
    section.wrap(&DENSITY, memory::check("gas ionised by the stars", bytes, loader.inputs.memory_limit))?;
    let densest = cloud.densest();
    let functions: Vec<_> =
        species.iter().map(|species| move |gas: &Gas, state: &State| state.emission(gas, species.table, species.lines[0])).collect();
    let mut quantities: Vec<Quantity> =
        species.iter().zip(&functions).map(|(of, value)| Quantity { most: cloud.most(of.table, of.lines[0]), value }).collect();
    let pairs = |gas: &Gas, state: &State| state.pairs(gas);
    let most = cloud.electrons() * densest * densest;
    let warm = |gas: &Gas, state: &State| pairs(gas, state) * state.temperature;
    let thick = |gas: &Gas, state: &State| pairs(gas, state) * state.electrons;
    quantities.push(Quantity { most, value: &pairs });
    quantities.push(Quantity { most: 6e4 * most, value: &warm });
    quantities.push(Quantity { most: cloud.electrons() * densest * most, value: &thick });
    let accuracy = if loader.is_rough { Accuracy::COARSE } else { Accuracy::FAST };
    let found = cloud.ionised(&quantities, accuracy, loader.tracer.as_deref(), &loader.control).map_err(|error| match error {
        IonisationError::Stopped => Error::Interrupted,
        error => section.error(&DENSITY, error.to_string()),
    })?;
    let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
    let mut quantities = found.quantities;
    let [thick, warm, pairs] = std::array::from_fn(|_| quantities.pop().unwrap_or_default());
    let through = |band: &Passband| species.iter().zip(&quantities).map(|(species, values)| species.through(band) * sum(values)).collect();
    let by_band: Vec<Vec<f64>> = bands.iter().map(through).collect();
    let counts = |i: usize| by_band.iter().any(|light| light[i] > DARK * light.iter().sum::<f64>());
    let counts: Vec<bool> = (0..species.len()).map(counts).collect();
    let gridded = |values: Vec<f32>| {
        Arc::new(Grid::from_lattice(cloud.lattice.clone(), ionised::softened(cloud.lattice.dims, values))) as Arc<dyn Field>
    };
    let all = sum(&pairs);
    let mean = |values: &[f32]| (all > 0.0).then(|| sum(values) / all);
    let (temperature, electrons) = (mean(&warm), mean(&thick));
    let mut glow = Vec::new();
    for ((species, values), counts) in species.iter().zip(quantities).zip(counts) {
        if counts {
            let thermal = species.thermal_fwhm(temperature.unwrap_or_default());
            glow.push((species.name(), gridded(values), species.spectrum().broadened(thermal).broadened(turbulent)));
        }
    }
    if let (Some(temperature), Some(electrons)) = (temperature, electrons) {
        let at = (Temperature(temperature.clamp(6000.0, 15_000.0)), NumberDensity(electrons.clamp(100.0, 1e4)));
        let spectrum = section.wrap(&DENSITY, recombination_continuum(at.0, at.1))?;
        glow.push(("hydrogen's continuum".into(), gridded(pairs), spectrum));
    }
    let unsettled = found.unsettled as f64 / found.steps.max(1) as f64;
    let (escaped, passes, change, by) = (found.escaped, found.passes, found.change, found.by);
    Ok(IonisedGas { cloud, temperature, electrons, escaped, passes, change, by, unsettled, is_rough: loader.is_rough, species: glow })
}

/// Mean of the gas over the stars of several moments. Equal stars in a row are solved once.
pub(super) fn mean(moments: &[&[Star]], build: impl Fn(&[Star]) -> Result<IonisedGas>) -> Result<IonisedGas> {
    let mut latest = build(moments[0])?;
    let mut mean = latest.clone();
    for (number, pair) in moments.windows(2).enumerate() {
        if star::fingerprint(pair[0]) != star::fingerprint(pair[1]) {
            latest = build(pair[1])?;
        }
        mean = mean.mixed(&latest, 1.0 / (number as f64 + 2.0));
    }
    Ok(mean)
}

/// The edge of a voxel of the gas of a table \[pc\].
pub(super) fn voxel_pc(section: &Section, fields: &Fields) -> Result<f64> {
    let density = fields.expression(section, &DENSITY)?;
    let voxels = section.read(&VOXELS)?;
    Ok(match (density.grid(), voxels) {
        (Some(grid), None) => grid.lattice().voxel_pc().min_element(),
        (_, voxels) => density.bounds().size().max_element() / voxels.unwrap_or(VOXELS_OF_FUNCTION) as f64,
    })
}

/// The gas of a table, and the stars that ionise it.
fn read(section: &Section, loader: &Loader, fields: &Fields, stars: &[Star]) -> Result<GasCloud> {
    section.check(KEYS)?;
    let density = fields.expression(section, &DENSITY)?;
    let abundances = section.read(&ABUNDANCES)?;
    let voxels = section.read(&VOXELS)?;
    let dust_cm2 = section.read(&DUST_ABSORPTION)?;
    let isothermal = section.read(&TEMPERATURE)?.map(|temperature| temperature.0);
    let diffuse = section.read(&DIFFUSE)?;
    let stars = IonisingStar::of(stars);
    if stars.len() > MOST_STARS {
        let message = format!("{} stars ionise the gas, at most {MOST_STARS} are supported; remove faint stars or merge some", stars.len());
        return Err(section.error(&DENSITY, message));
    }
    // For a first look a grid is taken as it is, to be made coarser, and a function is not asked at more places than needed.
    let is_own = |grid: &&Grid| loader.is_rough || voxels.is_none_or(|voxels| grid.lattice().dims.into_iter().max() == Some(voxels));
    let voxels = voxels.unwrap_or(VOXELS_OF_FUNCTION).min(if loader.is_rough { ROUGH } else { usize::MAX });
    let own = density.grid().filter(is_own);
    let lattice = own.map_or_else(|| Lattice::along(density.bounds(), voxels), |grid| grid.lattice().clone());
    let (hydrogen, memory_limit) = (Vec::new(), loader.inputs.memory_limit);
    let mut cloud = GasCloud { lattice, hydrogen, abundances, dust_cm2, isothermal, diffuse, stars, memory_limit };
    section.wrap(&DENSITY, memory::check("gas ionised by the stars", cloud.bytes(BESIDE), loader.inputs.memory_limit))?;
    cloud.hydrogen = match own {
        Some(grid) => grid.values().into_owned(),
        None => Grid::from_function(&density, cloud.lattice.clone(), 1.0, &loader.control)?.values().into_owned(),
    };
    Ok(cloud)
}

/// Abundances by name, or as a list of numbers.
enum AbundanceValue {}

impl ValueType for AbundanceValue {
    const TYPE: Type = Type::Other("text or list of numbers");
    const RANGE: Range = Range { low: 0.0, ..Range::ALL };
    type Value<'a> = [f64; ELEMENTS];
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<[f64; ELEMENTS]> {
        let Ok(values) = Numbers::read(entry) else {
            let name = Text::read(entry)?;
            let known: Vec<&str> = ABUNDANCE_SETS.iter().map(|set| set.name).collect();
            let set = ABUNDANCE_SETS.iter().find(|set| set.name == name);
            return set.map(|set| set.values).ok_or_else(|| entry.wrong(&format!("one of {}", known.join(", "))));
        };
        let heavier: [f64; ELEMENTS - 1] = match values[..] {
            [helium, carbon, nitrogen, oxygen, neon, sulphur] => [helium, carbon, nitrogen, oxygen, neon, 0.0, 0.0, sulphur],
            _ => values
                .try_into()
                .map_err(|_| entry.error("eight numbers, He, C, N, O, Ne, Mg, Si and S per hydrogen nucleus, or six without Mg and Si"))?,
        };
        let mut abundances = [1.0; ELEMENTS];
        abundances[1..].copy_from_slice(&heavier);
        Ok(abundances)
    }
}
