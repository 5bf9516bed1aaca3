//! Manifest of a bundle.

use barnard::error::{Error, Result};
use barnard::properties::{Property, Table, Value};

use super::results::GivenResult;
use super::volume::{ROUNDING, Volume};

/// Name of the format in a manifest.
const FORMAT: &str = "barnard bundle";
/// Version of the format that is written, and read.
const VERSION: i64 = 1;
/// Most volumes and records.
const MOST: usize = 4096;

/// Errors of a bundle relative to the scene that it was made from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// Voxels along the longest edge of its largest volume; 0 for none.
    pub voxels: usize,
    /// Voxels along the longest edge of the largest grid of the source.
    pub source_voxels: usize,
    /// Errors of a picture, if one was compared.
    pub picture: Option<PictureErrors>,
}

/// Errors of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureErrors {
    /// Size of the pictures that were compared \[pixels\].
    pub size: [usize; 2],
    /// Root mean square difference of the pictures relative to their root mean square, the largest of all bands \[1\].
    pub rms: f64,
    /// Difference of the total light relative to the total, the largest of all bands \[1\].
    pub total: f64,
}

/// Manifest as it is read.
pub(super) struct Manifest {
    pub name: String,
    pub errors: Errors,
    pub volumes: Vec<VolumeRow>,
    pub results: Vec<ResultRow>,
    pub files: Vec<String>,
}

/// Row of a volume.
pub(super) struct VolumeRow {
    pub name: String,
    pub shape: [usize; 3],
    pub exponent: i32,
    pub times: Vec<String>,
}

/// Row of a result.
pub(super) struct ResultRow {
    pub key: String,
    pub text: String,
    pub numbers: Vec<f64>,
    pub volumes: Vec<VolumeRow>,
}

fn table(entries: Vec<(&str, Value)>) -> Value {
    let mut table = Table::default();
    entries.into_iter().for_each(|(key, value)| table.insert(key, value));
    Value::Table(table)
}

fn list(values: impl Iterator<Item = Value>) -> Value {
    Value::List(values.map(Property::from).collect())
}

fn texts(texts: &[impl AsRef<str>]) -> Value {
    list(texts.iter().map(|text| Value::Text(text.as_ref().to_owned())))
}

fn integer(number: usize) -> Value {
    Value::Integer(number as i64)
}

fn volume_row(volume: &Volume) -> Value {
    table(vec![
        ("name", Value::Text(volume.name.clone())),
        ("shape", list(volume.shape.iter().map(|edge| integer(*edge)))),
        ("exponent", Value::Integer(volume.exponent.into())),
        ("times", texts(&volume.times)),
    ])
}

/// Text of a manifest.
pub(super) fn written(name: &str, errors: &Errors, volumes: &[Volume], results: &[GivenResult], files: &[&str]) -> String {
    let result = |result: &GivenResult| {
        table(vec![
            ("key", Value::Text(result.key.clone())),
            ("text", Value::Text(result.text.clone())),
            ("numbers", list(result.numbers.iter().map(|number| Value::Number(*number)))),
            ("volumes", list(result.volumes.iter().map(volume_row))),
        ])
    };
    let mut root = Table::default();
    root.insert("format", Value::Text(FORMAT.into()));
    root.insert("version", Value::Integer(VERSION));
    root.insert("program", Value::Text(format!("barnard {}", env!("CARGO_PKG_VERSION"))));
    root.insert("name", Value::Text(name.into()));
    let mut rows =
        vec![("rounding", Value::Number(ROUNDING)), ("voxels", integer(errors.voxels)), ("source_voxels", integer(errors.source_voxels))];
    if let Some(PictureErrors { size, rms, total }) = errors.picture {
        rows.push(("size", list(size.iter().map(|edge| integer(*edge)))));
        rows.push(("rms", Value::Number(rms)));
        rows.push(("total", Value::Number(total)));
    }
    root.insert("errors", table(rows));
    root.insert("files", texts(files));
    root.insert("volume", list(volumes.iter().map(volume_row)));
    root.insert("result", list(results.iter().map(result)));
    crate::toml::text(&root)
}

/// Reads a manifest; `file` is its name in messages.
pub(super) fn read(file: &str, text: &str) -> Result<Manifest> {
    let root = Rows { file, table: &crate::toml::properties(file, text)? };
    if root.text("format")? != FORMAT {
        return Err(root.wrong("format", &format!("\"{FORMAT}\"")));
    }
    let version = root.integer("version")?;
    if version != VERSION {
        let problem = format!("{file} has version {version} of the format, this program reads version {VERSION}");
        return Err(Error::conflict(problem, "make the file again with `barnard bake`, or update Barnard"));
    }
    let errors = match root.table.get("errors").map(|property| &property.value) {
        Some(Value::Table(table)) => Rows { file, table }.errors()?,
        _ => return Err(root.wrong("errors", "a table")),
    };
    let results = root.tables("result")?;
    Ok(Manifest {
        name: root.text("name")?.to_owned(),
        errors,
        volumes: root.volumes("volume")?,
        results: results.iter().map(Rows::result).collect::<Result<_>>()?,
        files: root.texts("files")?,
    })
}

/// Keys of a table of a manifest.
struct Rows<'a> {
    file: &'a str,
    table: &'a Table,
}

impl<'a> Rows<'a> {
    fn wrong(&self, key: &str, expected: &str) -> Error {
        let found = self.table.get(key).map_or_else(|| "missing".into(), |property| property.value.to_string());
        Error::conflict(format!("{}: {key} is {found}, not {expected}", self.file), "make the file again with `barnard bake`")
    }

    fn text(&self, key: &str) -> Result<&'a str> {
        self.table.get(key).and_then(|property| property.value.text()).ok_or_else(|| self.wrong(key, "a text"))
    }

    fn integer(&self, key: &str) -> Result<i64> {
        match self.table.get(key).map(|property| &property.value) {
            Some(Value::Integer(number)) => Ok(*number),
            _ => Err(self.wrong(key, "an integer")),
        }
    }

    fn list(&self, key: &str) -> Result<&'a [Property]> {
        match self.table.get(key).map(|property| &property.value) {
            Some(Value::List(items)) if items.len() <= MOST => Ok(items),
            _ => Err(self.wrong(key, &format!("a list of at most {MOST} items"))),
        }
    }

    fn texts(&self, key: &str) -> Result<Vec<String>> {
        let texts = self.list(key)?.iter().map(|item| item.value.text().map(str::to_owned)).collect::<Option<_>>();
        texts.ok_or_else(|| self.wrong(key, "a list of names"))
    }

    fn tables(&self, key: &str) -> Result<Vec<Rows<'a>>> {
        let row = |item: &'a Property| match &item.value {
            Value::Table(table) => Ok(Rows { file: self.file, table }),
            _ => Err(self.wrong(key, "a list of tables")),
        };
        self.list(key)?.iter().map(row).collect()
    }

    /// Integers that are not negative.
    fn counts<const N: usize>(&self, key: &str) -> Result<[usize; N]> {
        let count = |item: &Property| match item.value {
            Value::Integer(number) => usize::try_from(number).ok(),
            _ => None,
        };
        let counts: Option<Vec<usize>> = self.list(key)?.iter().map(count).collect();
        counts.and_then(|counts| counts.try_into().ok()).ok_or_else(|| self.wrong(key, &format!("{N} whole numbers")))
    }

    fn number(&self, key: &str) -> Result<f64> {
        self.table.get(key).and_then(|property| number(&property.value)).ok_or_else(|| self.wrong(key, "a number"))
    }

    fn errors(&self) -> Result<Errors> {
        let count = |key| usize::try_from(self.integer(key)?).map_err(|_| self.wrong(key, "a whole number"));
        let picture =
            || Ok::<_, Error>(PictureErrors { size: self.counts("size")?, rms: self.number("rms")?, total: self.number("total")? });
        Ok(Errors {
            voxels: count("voxels")?,
            source_voxels: count("source_voxels")?,
            picture: self.table.get("rms").map(|_| picture()).transpose()?,
        })
    }

    fn volumes(&self, key: &str) -> Result<Vec<VolumeRow>> {
        let row = |row: Rows| {
            let exponent = i32::try_from(row.integer("exponent")?).map_err(|_| row.wrong("exponent", "a binary exponent"))?;
            Ok(VolumeRow { name: row.text("name")?.to_owned(), shape: row.counts("shape")?, exponent, times: row.texts("times")? })
        };
        self.tables(key)?.into_iter().map(row).collect()
    }

    fn result(&self) -> Result<ResultRow> {
        let numbers = self.list("numbers")?.iter().map(|item| number(&item.value)).collect::<Option<_>>();
        Ok(ResultRow {
            key: self.text("key")?.to_owned(),
            text: self.text("text")?.to_owned(),
            numbers: numbers.ok_or_else(|| self.wrong("numbers", "a list of numbers"))?,
            volumes: self.volumes("volumes")?,
        })
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        Value::Integer(number) => Some(*number as f64),
        _ => None,
    }
}
