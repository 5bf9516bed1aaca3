//! A field from a file: an array of NumPy, a FITS cube, an HDF5 dataset, or an OpenVDB grid.

use std::sync::Arc;

use rayon::prelude::*;
use spectra::constants::HYDROGEN_MASS;
use spectra::units::{ExtinctionCoefficient, MassDensity, NumberDensity, Quantity};

use super::dust_map::DustMap;
use super::placement::{AXES, CENTRE, EVERY, FILE, HIGH, LOW, MEMORY, PRESET, Placement, SCALE, VOXEL, WCS};
use super::{Field, Grid};
use crate::blocks::Storage;
use crate::data::{ArrayHeader, InputNote, Inputs, Numbers};
use crate::error::{Error, Result};
use crate::geometry::Bounds;
use crate::properties::{Choice, Flag, Key, Kind, Number, OrDefault, Section, Text};
use crate::stored::too_small;

const ARRAY: Key<Text> = Key::text(
    "array",
    "name of the array in an .npz or of the grid in a .vdb, path of the dataset in an HDF5 file, number or EXTNAME of the HDU in a FITS file",
)
.otherwise("the only one");
const UNIT: Key<Text> = Key::text(
    "unit",
    "unit of the values (BUNIT of FITS, units of HDF5): number densities are converted to cm-3, extinctions per length to mag/pc; mass densities require mass_per_h; other values are unchanged",
)
.otherwise("the file's own")
.excludes("preset");
const MASS_PER_H: Key<Number> =
    mass_per_h("gas mass per hydrogen nucleus in hydrogen masses, to convert mass densities to nuclei per cm3: 1.4 for solar abundances")
        .required_for("mass densities");
const STORAGE: Key<Choice<Storage>> = Key::choice(
    "storage",
    "storage in sparse blocks of 16 x 16 x 16 voxels; half has relative errors of up to 1/2048, byte up to 1/508 of the largest value in the block",
)
.otherwise("dense; single for .vdb and arrays above half of the memory limit");
const FACTOR: Key<Number, OrDefault> = Key::number("factor", "factor of all values").range(f64::MIN..=f64::MAX).default(1.0);
const CLIP: Key<Flag> =
    Key::flag("clip", "set blank, NaN and negative cells to zero instead of an error").otherwise("false, true with preset");

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "grid",
    summary: "3-D array from .npy, .npz, FITS, HDF5 or OpenVDB, trilinear between voxel centres",
    keys: &[
        FILE.row,
        ARRAY.row,
        AXES.row,
        LOW.row,
        HIGH.row,
        VOXEL.row,
        SCALE.row,
        CENTRE.row,
        EVERY.row,
        MEMORY.row,
        PRESET.row,
        UNIT.row,
        MASS_PER_H.row,
        WCS.row,
        STORAGE.row,
        FACTOR.row,
        CLIP.row,
    ],
    build,
};

/// A grid of a file, in parsecs.
#[derive(Debug)]
pub struct Loaded {
    /// The grid.
    pub grid: Grid,
    /// Unit of its values: cm-3 or mag/pc where they are number densities or extinctions, what was said otherwise.
    pub unit: Option<String>,
}

fn build(section: &Section, inputs: &Inputs) -> Result<Arc<dyn Field>> {
    Ok(Arc::new(load(section, inputs)?.grid))
}

/// The grid that the keys of a field of kind `grid` say.
///
/// # Errors
/// If a key is wrong, the file is missing or broken, or its values are no densities.
pub fn load(section: &Section, inputs: &Inputs) -> Result<Loaded> {
    read(section, inputs).map_err(|error| {
        let Ok(Some(label)) = section.stated(&FILE).map(|file| file.map(|file| inputs.label(file))) else { return error };
        match error {
            Error::Scene { message, place } if !message.contains(&label) => Error::Scene { message: format!("{label}: {message}"), place },
            values @ Error::FieldValues { .. } => {
                section.error(&FILE, format!("{label}: {values}; clip = true sets blank, NaN and negative cells to zero"))
            }
            other => other,
        }
    })
}

/// How the array of a file becomes a grid.
struct Placing {
    placement: Placement,
    /// Multiplier of its values.
    factor: f64,
    /// True if invalid values become zero.
    clip: bool,
    /// Unit of the product.
    unit: Option<String>,
}

impl Placing {
    fn of(section: &Section, map: Option<&DustMap>, header: &ArrayHeader, memory_limit: u64) -> Result<Self> {
        let clip = section.read(&CLIP)?.unwrap_or(map.is_some());
        let scale = section.read(&FACTOR)?;
        let mut placement = match map {
            Some(map) => Placement::of(section, &map.laid_out(header))?,
            None => Placement::of(section, header)?,
        };
        // An array that is turned is in memory twice for a while; blocks are filled in any order.
        let twice = placement.part.shape().iter().fold(8u64, |bytes, n| bytes.saturating_mul(*n as u64));
        let is_blocked = twice > memory_limit || header.frame.as_ref().is_some_and(|frame| frame.is_sparse);
        let storage = section.read(&STORAGE)?.or(is_blocked.then_some(Storage::Single));
        // Means are clipped while they are made, other arrays once they are read.
        placement.part.clip = clip && placement.part.every > 1;
        if placement.part.clip && scale < 0.0 {
            return Err(section.error(&FACTOR, "with every and clip, factor must not be negative"));
        }
        let file_unit = header.frame.as_ref().and_then(|frame| frame.unit.as_deref());
        let (size, unit) = match map {
            Some(map) => (map.extinction(section, file_unit)?, Some(EXTINCTION.to_owned())),
            None => unit(section, file_unit)?,
        };
        let factor = scale * size;
        placement.part.blocking = storage.map(|storage| placement.blocking(factor, clip, storage));
        Ok(Self { placement, factor, clip, unit })
    }
}

fn read(section: &Section, inputs: &Inputs) -> Result<Loaded> {
    section.check_kind(KIND.keys)?;
    let file = section.read(&FILE)?;
    let map = section.read(&PRESET)?;
    let mut placed = None;
    let member = section.read(&ARRAY)?.or(map.and_then(|map| map.array));
    let array = inputs.array(file, member, &mut |header| {
        let placing = Placing::of(section, map, header, inputs.memory_limit)?;
        let part = placing.placement.part.clone();
        placed = Some(placing);
        Ok(part)
    });
    let array = array.map_err(|e| match (map, &placed) {
        (Some(map), None) if matches!(e, Error::File { .. }) => {
            let (file, at) = map.source;
            section.error(&FILE, format!("{e}; the map {} is {file} from {at}", map.name))
        }
        _ => e,
    });
    let array = section.wrap(&FILE, array)?;
    let Placing { placement, factor, clip, unit } = placed.ok_or_else(|| section.error(&FILE, "nothing of it was read"))?;
    inputs.note(volume_note(file, &placement, unit.as_deref(), factor));
    let lattice = placement.lattice.clone();
    let strides = placement.strides(&array);
    let checked = |largest: f64| match too_small(largest) {
        Some(message) => Err(section.error(if section.has(&FACTOR) { &FACTOR.row } else { &FILE.row }, message)),
        None => Ok(()),
    };
    let [nx, ny, _] = lattice.dims.map(|n| n as isize);
    let as_it_is = factor == 1.0 && !clip && strides == (0, [1, nx, nx * ny]);
    let grid = match array.data {
        Numbers::Blocks(blocks) => Grid::in_blocks(lattice, blocks),
        Numbers::Single(data) => {
            checked(largest(&data, factor))?;
            // Numbers that are as a grid has them stay in the memory in which they are.
            if as_it_is {
                Grid::sharing(lattice, data)
            } else {
                Grid::from_lattice(lattice, arranged(&data, strides, (factor, clip), &placement))
            }
        }
        Numbers::Double(data) => {
            checked(largest(&data, factor))?;
            Grid::from_lattice(lattice, arranged(&data, strides, (factor, clip), &placement))
        }
    };
    grid.check(section.name())?;
    Ok(Loaded { grid, unit })
}

/// The voxels, the box, the unit and the factor of a volume.
fn volume_note(file: &str, placement: &Placement, unit: Option<&str>, factor: f64) -> InputNote {
    let [x, y, z] = placement.lattice.dims;
    let Bounds { low, high } = placement.lattice.bounds;
    let unit = unit.map_or_else(|| "values without a unit, unchanged".to_owned(), |unit| format!("values in {unit}"));
    let times = if factor == 1.0 { String::new() } else { format!(" (file times {factor:e})") };
    let text = format!(
        "volume: {x} x {y} x {z} voxels from {:.6} {:.6} {:.6} to {:.6} {:.6} {:.6} pc, {unit}{times}",
        low.x, low.y, low.z, high.x, high.y, high.z
    );
    InputNote { file: file.to_owned(), text, is_inferred: false }
}

/// The units that number densities and extinctions are turned into.
const DENSITY: &str = "cm-3";
const EXTINCTION: &str = "mag/pc";

/// The key of the mean mass of gas per hydrogen nucleus [hydrogen atoms], from pure hydrogen to gas almost without.
pub(crate) const fn mass_per_h(summary: &'static str) -> Key<Number> {
    Key::number("mass_per_h", summary).range(1.0..=1000.0).example("1.4")
}

/// The mass of gas per hydrogen nucleus \[g\] of a mass in hydrogen atoms.
pub(crate) fn grams_per_h(atoms: f64) -> f64 {
    atoms * HYDROGEN_MASS * 1e3
}

/// Unit of the values: in cm-3 where it is a number density, in mag/pc where it is an extinction; and in what values
/// are then.
fn unit(section: &Section, file_unit: Option<&str>) -> Result<(f64, Option<String>)> {
    let grams = section.read(&MASS_PER_H)?.map(grams_per_h);
    let stated = section.read(&UNIT)?;
    let mass = [stated, file_unit].into_iter().flatten().find(|unit| MassDensity::unit_size(unit).is_some());
    match (mass, grams) {
        (Some(mass), None) => {
            let message = format!(
                "values in \"{mass}\" are a mass density; add mass_per_h = 1.4, the gas mass per hydrogen nucleus in hydrogen masses, to convert them to n_H in cm-3"
            );
            return Err(section.error(&UNIT, message));
        }
        (None, Some(_)) => return Err(section.error(&MASS_PER_H, "requires a unit of mass per volume, such as unit = \"g/cm3\"")),
        _ => {}
    }
    let extinction = |unit: &str| Some(ExtinctionCoefficient::unit_size(unit)? / ExtinctionCoefficient::unit_size(EXTINCTION)?);
    let size = |unit: &str| {
        let density = NumberDensity::unit_size(unit).map(|size| (size, Some(DENSITY.to_owned())));
        let of_mass = || Some((MassDensity::unit_size(unit)? / grams?, Some(DENSITY.to_owned())));
        density.or_else(of_mass).or_else(|| extinction(unit).map(|size| (size, Some(EXTINCTION.to_owned()))))
    };
    match (stated, file_unit) {
        (None, None) => Ok((1.0, None)),
        (None, Some(file_unit)) => size(file_unit).ok_or_else(|| {
            let message = format!(
                "the file's unit is \"{file_unit}\", which is neither a density nor an extinction; write unit = \"{file_unit}\" to use the values unchanged, and choose the scale of dust or gas accordingly"
            );
            section.error(&FILE, message)
        }),
        (Some(stated), None) => size(stated).ok_or_else(|| {
            let known: Vec<&str> = NumberDensity::UNITS.iter().chain(MassDensity::UNITS).chain(ExtinctionCoefficient::UNITS).map(|(name, _)| *name).collect();
            let message = format!("\"{stated}\" is not a known unit of number density, mass density or extinction ({}); remove `unit` to use the values unchanged", known.join(", "));
            section.error(&UNIT, message)
        }),
        (Some(stated), Some(file_unit)) if stated.trim() == file_unit.trim() => Ok(size(stated).unwrap_or_else(|| (1.0, Some(stated.trim().to_owned())))),
        (Some(stated), Some(file_unit)) => match (size(stated), size(file_unit)) {
            (Some(a), Some(b)) if a.0 == b.0 => Ok(a),
            _ => Err(section.error(&UNIT, format!("the scene's unit is \"{stated}\", the file's is \"{file_unit}\"; correct or remove one"))),
        },
    }
}

/// Planes of a grid that are arranged together.
const PLANES: usize = 16;

/// The largest of some numbers times `factor`, without its sign.
fn largest(data: &[impl Copy + Into<f64> + Sync], factor: f64) -> f64 {
    let largest_of = |part: &[_]| part.iter().fold(0.0, |most: f64, v| most.max((Into::<f64>::into(*v) * factor).abs()));
    data.par_chunks(1 << 16).map(largest_of).reduce(|| 0.0, f64::max)
}

/// An array's numbers times `factor`, with x running fastest; those that are negative or no numbers are zero if `clip`.
fn arranged(
    data: &[impl Copy + Into<f64> + Sync],
    (first, [sx, sy, sz]): (usize, [isize; 3]),
    (factor, clip): (f64, bool),
    placement: &Placement,
) -> Vec<f32> {
    let [nx, ny, _] = placement.lattice.dims;
    let mut values = vec![0.0; placement.lattice.cells()];
    // Some planes together: where z runs fastest in the array, a line of memory is read once for all of them.
    values.par_chunks_mut(nx * ny * PLANES).enumerate().for_each(|(block, out)| {
        let planes = out.len() / (nx * ny);
        for y in 0..ny {
            for x in 0..nx {
                let line = first as isize + x as isize * sx + y as isize * sy + (block * PLANES) as isize * sz;
                (0..planes).for_each(|z| out[(z * ny + y) * nx + x] = (factor * data[(line + z as isize * sz) as usize].into()) as f32);
            }
        }
        if clip {
            out.iter_mut().filter(|v| v.is_nan() || **v < 0.0).for_each(|v| *v = 0.0);
        }
    });
    values
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use glam::DVec3;

    use super::*;
    use crate::data::{Array, ArrayHeader, Choose, DataSource, Shared, TextTable};
    use crate::properties::{Table, Value};

    /// One array in memory, and nothing else.
    #[derive(Debug)]
    struct One {
        numbers: Shared<f32>,
        fortran: bool,
    }

    impl DataSource for One {
        fn label(&self, name: &str) -> String {
            name.to_owned()
        }
        fn text(&self, name: &str, _: u64) -> Result<Cow<'static, str>> {
            Err(Error::file(name, "is not there"))
        }
        fn table(&self, name: &str, _: usize, _: u64) -> Result<TextTable> {
            Err(Error::file(name, "is not there"))
        }
        fn array(&self, _: &str, _: Option<&str>, choose: Choose, _: u64) -> Result<Array> {
            let part = choose(&ArrayHeader { shape: [2, 3, 4], frame: None })?;
            assert!(part.is_whole([2, 3, 4]), "{part:?}");
            Ok(Array { shape: [2, 3, 4], data: Numbers::Single(self.numbers.clone()), fortran: self.fortran })
        }
    }

    /// An array whose x runs fastest is the grid's own memory; in another order, scaled or clipped it is not, and what
    /// is read is the same.
    #[test]
    fn arrays_are_shared_where_they_lie_as_a_grid_has_them() {
        let numbers: Shared<f32> = (0..24).map(|i| i as f32).collect::<Vec<_>>().into();
        let grid = |fortran: bool, more: &[(&str, Value)]| {
            let mut table = Table::default();
            let keys = [("file", "a"), ("low", "0 0 0 pc"), ("high", "2 3 4 pc")];
            keys.iter().for_each(|(key, text)| table.insert(*key, Value::Text((*text).into())));
            more.iter().for_each(|(key, value)| table.insert(*key, value.clone()));
            let inputs = Inputs::new(Arc::new(One { numbers: numbers.clone(), fortran }), 1 << 20);
            build(&Section::new(&table, "field.a"), &inputs).unwrap()
        };
        let shares = |field: &Arc<dyn Field>| std::ptr::eq(field.grid().unwrap().values().as_ptr(), numbers.as_ptr());
        let field = grid(true, &[]);
        assert!(shares(&field));
        assert_eq!(field.at(DVec3::new(1.5, 0.5, 2.5)), 1.0 + 2.0 * 6.0);
        for (fortran, more) in [(false, vec![]), (true, vec![("factor", Value::Number(2.0))]), (true, vec![("clip", Value::Flag(true))])] {
            assert!(!shares(&grid(fortran, &more)), "{fortran} {more:?}");
        }
        assert_eq!(grid(false, &[]).at(DVec3::new(1.5, 0.5, 2.5)), 12.0 + 2.0);
    }
}
