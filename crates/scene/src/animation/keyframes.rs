//! Keyframes of a camera: what it is at some moments, in tables of the scene or in a file.

use std::collections::BTreeMap;

use spectra::error::nearest;
use spectra::units::{Angle, Length, Quantity, Time};

use crate::data::{Inputs, TextTable};
use crate::error::{Error, Result};
use crate::properties::{Key, KeyRow, Numbers, Origin, Place, Position, Required, Section, Tables, Value};

pub(super) const KEY: Key<Tables> = Key::tables("key", "two or more keyframes, [[camera.path.key]], unless a file is given");
const TIME: Key<Time, Required> = Key::quantity::<Time>("time", "time of the keyframe").required();
const POSITION: Key<Position> = Key::position("position", "position of the observer").otherwise("interpolated");
const TARGET: Key<Position> = Key::position("target", "target of the view").otherwise("interpolated");
const DIRECTION: Key<Numbers> =
    Key::numbers("direction", "viewing direction, instead of a target").example("[0.0, 0.0, 1.0]").otherwise("towards the target");
const ORIENTATION: Key<Numbers> =
    Key::numbers("orientation", "quaternion [x, y, z, w] that rotates a camera looking along -z with y up, instead of target and up")
        .example("[0.0, 0.0, 0.0, 1.0]")
        .otherwise("towards the target");
const UP: Key<Numbers> = Key::numbers("up", "up direction of the image").example("[0.0, 1.0, 0.0]").otherwise("interpolated");
const FIELD_OF_VIEW: Key<Angle> =
    Key::quantity::<Angle>("field_of_view", "horizontal field of view, of a perspective camera").otherwise("interpolated");
const WIDTH: Key<Length> = Key::quantity::<Length>("width", "width of the image, of an orthographic camera").otherwise("interpolated");
const APERTURE: Key<Angle> = Key::quantity::<Angle>("aperture", "angle across the circle, of a fisheye").otherwise("interpolated");
const TILT: Key<Angle> = Key::quantity::<Angle>("tilt", "tilt of a fisheye's centre from up towards the target").otherwise("interpolated");

/// Keys of `[[camera.path.key]]`: what is the camera's whatever its kind, and the numbers of all kinds.
pub(crate) const KEYFRAME: &[KeyRow] =
    &[TIME.row, POSITION.row, TARGET.row, DIRECTION.row, ORIENTATION.row, UP.row, FIELD_OF_VIEW.row, WIDTH.row, APERTURE.row, TILT.row];

/// Most keyframes of a file: ten hours at 30 a second.
const MAX_ROWS: usize = 1 << 20;

/// Numbers that belong together.
pub(super) struct Vector {
    /// The key of a keyframe.
    pub name: &'static str,
    /// Columns of a file.
    columns: &'static [&'static str],
    /// True if it is a place, with a unit of length.
    is_place: bool,
    /// Components of the vector in a keyframe.
    read: fn(&Section) -> Result<Option<Vec<f64>>>,
}

impl Vector {
    /// Rejects columns of a file that are incomplete or of several units.
    fn check(&self, found: &[PathColumn]) -> std::result::Result<(), String> {
        let names = self.columns.join(", ");
        match found {
            _ if found.len() < self.columns.len() => Err(format!("a {} has columns {names}", self.name)),
            [first, others @ ..] if others.iter().any(|column| column.unit != first.unit) => {
                Err(format!("{names} have different units; use one, such as x [pc], y [pc], z [pc]"))
            }
            _ => Ok(()),
        }
    }
}

/// Vectors of a keyframe.
pub(super) const VECTORS: [Vector; 5] = [
    Vector { name: POSITION.row.name, columns: &["x", "y", "z"], is_place: true, read: |key| place(key, &POSITION) },
    Vector { name: TARGET.row.name, columns: &["target_x", "target_y", "target_z"], is_place: true, read: |key| place(key, &TARGET) },
    Vector {
        name: DIRECTION.row.name,
        columns: &["direction_x", "direction_y", "direction_z"],
        is_place: false,
        read: |key| key.read(&DIRECTION),
    },
    Vector { name: UP.row.name, columns: &["up_x", "up_y", "up_z"], is_place: false, read: |key| key.read(&UP) },
    Vector {
        name: ORIENTATION.row.name,
        columns: &["orientation_x", "orientation_y", "orientation_z", "orientation_w"],
        is_place: false,
        read: |key| key.read(&ORIENTATION),
    },
];

fn place(section: &Section, key: &Key<Position>) -> Result<Option<Vec<f64>>> {
    Ok(section.read(key)?.map(|place| place.to_array().to_vec()))
}

/// Those of which a camera follows one.
const LOOKS: [&str; 3] = ["target", "direction", "orientation"];

/// A vector at the keys that say it: times \[s\], and components, key × component.
type Keyed = (Vec<f64>, Vec<f64>);

/// Camera keyframes.
#[derive(Debug, Default)]
pub(super) struct Keyframes {
    /// The moments \[s\], ascending.
    pub times: Vec<f64>,
    /// Places \[pc\], directions and quaternions, by the names of [`VECTORS`].
    pub vectors: Vec<(&'static str, Keyed)>,
    /// Other numbers of the camera by their keys, as the scene would say them.
    pub others: BTreeMap<String, Vec<(f64, Value)>>,
}

/// Scalar camera parameters: the numbers that some kind of camera has.
fn of_camera() -> impl Iterator<Item = &'static KeyRow> {
    KEYFRAME.iter().filter(|key| key.name != TIME.row.name && VECTORS.iter().all(|vector| vector.name != key.name))
}

impl Keyframes {
    /// Those of the tables `[[camera.path.key]]`.
    pub fn of_tables(section: &Section) -> Result<Self> {
        let names: Vec<&str> = VECTORS.iter().map(|vector| vector.name).collect();
        let mut keyframes = Self::default();
        for key in section.read(&KEY)?.unwrap_or_default() {
            key.check(KEYFRAME)?;
            let time = key.read(&TIME)?.0;
            keyframes.begin(time).map_err(|message| key.error(&TIME, message))?;
            for vector in &VECTORS {
                let Some(values) = (vector.read)(&key)? else { continue };
                keyframes.add(vector, &values).map_err(|message| key.error(vector.name, message))?;
            }
            for (name, property) in key.properties().iter().filter(|(name, _)| *name != TIME.row.name && !names.contains(name)) {
                keyframes.others.entry(name.to_owned()).or_default().push((time, property.value.clone()));
            }
        }
        keyframes.finished().map_err(|message| section.error("key", message))
    }

    /// Keyframes of a file; `unit_pc` is the default unit of length \[pc\].
    pub fn of_file(section: &Section, file: &str, unit_pc: f64, inputs: &Inputs) -> Result<Self> {
        let table = section.wrap("file", inputs.table(file, MAX_ROWS))?;
        let columns = PathColumns::of(&table, &inputs.label(file))?;
        let mut keyframes = Self::default();
        for (line, cells) in &table.rows {
            let number = |column: &PathColumn| columns.number(cells, column, *line);
            let time = number(&columns.time)?;
            keyframes.begin(time).map_err(|message| columns.wrong(*line, "time", message))?;
            for (vector, vector_columns) in &columns.vectors {
                let scale = |column: &PathColumn| if vector.is_place { column.size.unwrap_or(unit_pc) } else { 1.0 };
                // Empty cells say nothing.
                if vector_columns.iter().all(|column| columns.is_empty(cells, column)) {
                    continue;
                }
                let values = vector_columns.iter().map(|column| Ok(scale(column) * number(column)?)).collect::<Result<Vec<f64>>>()?;
                keyframes.add(vector, &values).map_err(|message| columns.wrong(*line, vector.name, message))?;
            }
            for (key, column) in columns.others.iter().filter(|(_, column)| !columns.is_empty(cells, column)) {
                let value = match column.unit.as_deref().or(usual_unit(key)) {
                    Some(unit) => Value::Quantity(vec![number(column)?], unit.to_owned()),
                    None => Value::Number(number(column)?),
                };
                keyframes.others.entry(key.name.to_owned()).or_default().push((time, value));
            }
        }
        keyframes.finished().map_err(|message| section.error("file", message))
    }

    /// A keyframe at a moment \[s\].
    fn begin(&mut self, time: f64) -> std::result::Result<(), String> {
        if !(time >= 0.0 && time.is_finite()) {
            return Err(format!("time {time} s is out of range; a path must begin at 0 s or later"));
        }
        if let Some(before) = self.times.last().filter(|before| time <= **before) {
            return Err(format!("{time} s follows a key at {before} s; sort keys by time"));
        }
        self.times.push(time);
        Ok(())
    }

    /// What the latest keyframe says of a vector.
    fn add(&mut self, vector: &Vector, values: &[f64]) -> std::result::Result<(), String> {
        let (dims, time) = (vector.columns.len(), self.times.last().copied().unwrap_or(0.0));
        if values.len() != dims {
            return Err(format!("{} must have {dims} numbers, not {}", vector.name, values.len()));
        }
        let square: f64 = values.iter().map(|v| v * v).sum();
        let points = square > 0.0 && square.is_finite();
        if !vector.is_place && !points {
            return Err(format!("{values:?} points nowhere"));
        }
        // Directions of any length are meant alike.
        let size = if vector.is_place { 1.0 } else { square.sqrt() };
        let index = match self.vectors.iter().position(|(name, _)| *name == vector.name) {
            Some(index) => index,
            None => {
                self.vectors.push((vector.name, Keyed::default()));
                self.vectors.len() - 1
            }
        };
        let (times, all) = &mut self.vectors[index].1;
        // A quaternion and its negative are one orientation: the nearer one is meant.
        let before = all.len().checked_sub(dims).map_or(&[][..], |from| &all[from..]);
        let turned = dims == 4 && before.iter().zip(values).map(|(a, b)| a * b).sum::<f64>() < 0.0;
        let size = if turned { -size } else { size };
        times.push(time);
        all.extend(values.iter().map(|v| v / size));
        Ok(())
    }

    /// All of them, where they can be followed.
    fn finished(self) -> std::result::Result<Self, String> {
        let looks: Vec<&str> = LOOKS.into_iter().filter(|name| self.vectors.iter().any(|(known, _)| known == name)).collect();
        if let [a, b, ..] = looks[..] {
            return Err(format!("keys have both {a} and {b}; use one of them along the whole path"));
        }
        if looks == ["orientation"] && self.vectors.iter().any(|(name, _)| *name == "up") {
            return Err("keys have both orientation and up; an orientation includes up".into());
        }
        Ok(self)
    }
}

/// A column that is read.
struct PathColumn {
    index: usize,
    name: String,
    unit: Option<String>,
    /// The size of its unit in the internal one, where it says a unit.
    size: Option<f64>,
}

/// The columns of a file.
struct PathColumns {
    file: String,
    time: PathColumn,
    vectors: Vec<(&'static Vector, Vec<PathColumn>)>,
    others: Vec<(&'static KeyRow, PathColumn)>,
}

impl PathColumns {
    fn of(table: &TextTable, file: &str) -> Result<Self> {
        let wrong = |key: &str, message: String| wrong(file, table.line, key, message);
        let all: Vec<(String, Option<&str>)> = table.columns.iter().map(|column| TextTable::parted(column)).collect();
        let column = |name: &str| {
            let index = all.iter().position(|(known, _)| known == name)?;
            Some(PathColumn { index, name: name.to_owned(), unit: all[index].1.map(str::to_owned), size: None })
        };
        let sized = |column: PathColumn, size: fn(&str) -> Option<f64>, example: &str| {
            let Some(unit) = column.unit.clone() else { return Ok(column) };
            let size = size(&unit).ok_or_else(|| wrong(&column.name, format!("unknown unit \"{unit}\"; write it like \"{example}\"")))?;
            Ok::<_, Error>(PathColumn { size: Some(size), ..column })
        };
        let missing = || wrong("time", format!("has no column \"time [s]\", only {}", table.columns.join(", ")));
        let time = sized(column("time").ok_or_else(missing)?, Time::unit_size, "time [s]")?;
        let mut vectors = Vec::new();
        for vector in &VECTORS {
            let found: Vec<PathColumn> = vector.columns.iter().filter_map(|name| column(name)).collect();
            if found.is_empty() {
                continue;
            }
            vector.check(&found).map_err(|message| wrong(vector.name, message))?;
            let sized = |found| if vector.is_place { sized(found, Length::unit_size, "x [pc]") } else { Ok(found) };
            vectors.push((vector, found.into_iter().map(sized).collect::<Result<_>>()?));
        }
        let mut others = Vec::new();
        for key in of_camera() {
            if let Some(column) =
                column(key.name).filter(|_| !others.iter().any(|(known, _): &(&KeyRow, PathColumn)| known.name == key.name))
            {
                others.push((key, column));
            }
        }
        let known: Vec<&str> = ["time"]
            .into_iter()
            .chain(VECTORS.iter().flat_map(|vector| vector.columns).copied())
            .chain(of_camera().map(|key| key.name))
            .collect();
        if let Some((unknown, _)) = all.iter().find(|(key, _)| !known.contains(&key.as_str())) {
            let hint = nearest(unknown, known.iter().copied()).map(|near| format!(", did you mean \"{near}\"?")).unwrap_or_default();
            return Err(wrong(unknown, format!("unknown column \"{unknown}\"{hint}; known: {}", known.join(", "))));
        }
        if vectors.is_empty() && others.is_empty() {
            return Err(wrong(
                "columns",
                format!("{} are not columns of a camera path; add columns such as x [pc], y [pc] and z [pc]", table.columns.join(", ")),
            ));
        }
        Ok(Self { file: file.to_owned(), time, vectors, others })
    }

    fn wrong(&self, line: usize, key: &str, message: String) -> Error {
        wrong(&self.file, line, key, message)
    }

    /// True if the cell says nothing.
    fn is_empty(&self, cells: &[String], column: &PathColumn) -> bool {
        cells.get(column.index).is_none_or(String::is_empty)
    }

    /// The number in a cell; a time in seconds.
    fn number(&self, cells: &[String], column: &PathColumn, line: usize) -> Result<f64> {
        let cell = cells.get(column.index).map_or("", String::as_str);
        let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
        let number = number.ok_or_else(|| self.wrong(line, &column.name, format!("\"{cell}\" is not a number")))?;
        let size = if column.index == self.time.index { self.time.size.unwrap_or(1.0) } else { 1.0 };
        Ok(number * size)
    }
}

fn wrong(file: &str, line: usize, key: &str, message: String) -> Error {
    let origin = Some(Origin { source: file.into(), line });
    Error::Scene { message, place: Place { origin, path: String::new(), key: key.to_owned() } }
}

/// The unit in which numbers of a key stand in a file that says none.
fn usual_unit(key: &KeyRow) -> Option<&'static str> {
    key.value.quantity().map(|quantity| quantity.units[0].0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::KINDS;

    /// Every number that a kind of camera has can stand in a keyframe, as the same quantity.
    #[test]
    fn all_numbers_of_cameras_have_keys() {
        let keys: Vec<&KeyRow> = KINDS.iter().flat_map(|kind| kind.keys).collect();
        assert!(keys.len() >= 4);
        for key in keys {
            assert!(of_camera().any(|row| row.name == key.name && row.value.to_string() == key.value.to_string()), "{}", key.name);
        }
    }
}
