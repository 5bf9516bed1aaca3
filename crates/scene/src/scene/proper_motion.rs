//! Proper motions of the stars of a catalogue, from its epoch to another.

use std::ops::RangeInclusive;

use glam::DVec3;

use crate::data::TextTable;
use crate::observation::SkyPlace;

/// Names of columns of proper motions, μ_α cos δ and μ_δ [mas yr⁻¹], and of the year of the positions.
const EAST: [&str; 2] = ["pmra", "pm_ra"];
const NORTH: [&str; 3] = ["pmdec", "pmde", "pm_dec"];
const EPOCHS: [&str; 2] = ["ref_epoch", "refepoch"];
/// The units in which proper motions are read.
const MAS_PER_YEAR: [&str; 4] = ["mas/yr", "mas/a", "mas.yr**-1", "mas yr-1"];
/// Years of epochs: straight motion over more of them is of no use.
pub(super) const YEARS: RangeInclusive<f64> = 1700.0..=2300.0;

/// Proper motions by the columns of a catalogue.
pub(super) struct Motion {
    /// Columns of μ_α cos δ and μ_δ.
    columns: [usize; 2],
    /// The year to which stars are moved.
    pub to: f64,
    /// The year of the positions, or the column that states it.
    from: Result<f64, usize>,
}

impl Motion {
    /// The motion to the year `to`, from the year `from` or that of a column.
    ///
    /// # Errors
    /// The missing column, or the unit that is not read.
    pub fn new(table: &TextTable, to: f64, from: Option<f64>) -> Result<Self, String> {
        let columns = columns(table).ok_or("has no columns pmra and pmdec, which epoch requires; remove epoch")?;
        let units = columns.map(|column| TextTable::parted(&table.columns[column]).1);
        if let Some(unit) = units.into_iter().flatten().find(|unit| !MAS_PER_YEAR.contains(unit)) {
            return Err(format!("has proper motions in the unsupported unit \"{unit}\"; convert them to mas/yr"));
        }
        let stated = || find(table, &EPOCHS).ok_or("has no column ref_epoch; set catalogue_epoch, the year of its positions, such as 2000");
        Ok(Self { columns, to, from: from.map_or_else(|| stated().map(Err), |year| Ok(Ok(year)))? })
    }

    /// The direction of a star at the wanted epoch: motion along a great circle, without radial velocity (ESA SP-1200,
    /// vol. 1, §1.5.5). `cell` gives the number in a column of its row; an empty cell is no motion.
    ///
    /// # Errors
    /// A cell that is not a number, or an epoch out of range.
    pub fn direction(&self, place: &SkyPlace, cell: impl Fn(usize) -> Result<Option<f64>, String>) -> Result<DVec3, String> {
        let [direction, east, north] = place.axes();
        let from = self.from.map_or_else(|column| Ok(cell(column)?.unwrap_or(0.0)), Ok::<f64, String>)?;
        if !YEARS.contains(&from) {
            return Err(format!("epoch {from} is out of range; years must be between {} and {}", YEARS.start(), YEARS.end()));
        }
        let moved = |column: usize| Ok::<f64, String>((cell(column)?.unwrap_or(0.0) * (self.to - from) / 3.6e6).to_radians());
        Ok((direction + moved(self.columns[0])? * east + moved(self.columns[1])? * north).normalize())
    }
}

/// The columns of proper motions.
pub(super) fn columns(table: &TextTable) -> Option<[usize; 2]> {
    Some([find(table, &EAST)?, find(table, &NORTH)?])
}

fn find(table: &TextTable, known: &[&str]) -> Option<usize> {
    table.columns.iter().position(|name| known.contains(&TextTable::parted(name).0.as_str()))
}
