//! The `[gas]` table: gas that the scene's stars ionise, as the species that shine in its passbands.

mod cloud;
mod front;
pub(super) mod ionised;
mod model;
mod solution;
mod species;
pub(super) mod voxel_gas;

use ionisation::atoms::ELEMENTS;
use ionisation::balance::{COLDEST, Diffuse, HOTTEST};
use ionisation::benchmarks::BENCHMARKS;
use spectra::passband::Passband;
use spectra::units::{Temperature, Velocity};

pub use cloud::{GasCloud, IonisingStar};
pub use ionised::IonisedGas;
pub use model::Gas;
pub(super) use model::sources;
pub(super) use solution::Solver;
pub(super) use voxel_gas::{VoxelGas, mean};

use super::{Fields, Loader, Star, emission, fields};
use crate::error::Result;
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
    fields::VELOCITY_STEP.row,
];

impl Choices for Diffuse {
    const ROWS: &'static [(&'static str, Self)] = &[("outward", Self::Outward), ("on_the_spot", Self::OnTheSpot)];
}

/// Reads a `[gas]` table.
pub(super) fn build(section: &Section, fields: &Fields) -> Result<Gas> {
    section.check(KEYS)?;
    Ok(Gas {
        density: fields.expression(section, &DENSITY)?,
        abundances: section.read(&ABUNDANCES)?,
        voxels: section.read(&VOXELS)?,
        dust_cm2: section.read(&DUST_ABSORPTION)?,
        temperature: section.read(&TEMPERATURE)?,
        diffuse: section.read(&DIFFUSE)?,
        doppler_fwhm: section.read(&DOPPLER_FWHM)?,
        motion: fields.motion(section)?,
    })
}

/// Has the stars ionise the gas of a table.
pub(super) fn solve(section: &Section, loader: &Loader, fields: &Fields, stars: &[Star], bands: &[Passband]) -> Result<VoxelGas> {
    let Loader { is_rough, tracer, control, inputs, .. } = loader;
    let (tracer, cache) = (tracer.as_deref(), inputs.cache.as_deref());
    let solver = Solver { is_rough: *is_rough, memory_limit: inputs.memory_limit, tracer, cache, control };
    section.wrap(&DENSITY, build(section, fields)?.ionised_by(stars, bands, &solver))
}

/// The edge of a voxel of the gas of a table \[pc\].
pub(super) fn voxel_pc(section: &Section, fields: &Fields) -> Result<f64> {
    Ok(build(section, fields)?.voxel_pc())
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
