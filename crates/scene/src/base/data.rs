//! Inputs of a scene other than its tree: texts, tables of text and arrays, by name.
//!
//! Nothing here opens a file: a [`DataSource`] finds what a name means, on a disk, in memory or behind a network.

use std::borrow::Cow;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::{Arc, Mutex};

use spectra::curve::Columns;

pub use super::shared::Shared;
use crate::blocks::{Blocking, Blocks};
use crate::cache::Cache;
use crate::error::{Error, Result};

/// A three-dimensional array, or the part of one that was asked for, as its file has it.
#[derive(Debug)]
pub struct Array {
    /// Lengths of the axes, in the file's order of indices.
    pub shape: [usize; 3],
    /// The values, in the file's order.
    pub data: Numbers,
    /// True if the first index runs fastest.
    pub fortran: bool,
}

/// Header of an array in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrayHeader {
    /// Lengths of the axes, in the file's order of indices.
    pub shape: [usize; 3],
    /// Metadata of its values and axes, if its format supports them.
    pub frame: Option<ArrayFrame>,
}

impl ArrayHeader {
    /// All of the array.
    pub fn whole(&self) -> ArrayPart {
        ArrayPart { ranges: self.shape.map(|n| 0..n), every: 1, clip: false, blocking: None }
    }
}

/// The part of an array that is read.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrayPart {
    /// Elements along each axis, in the file's order of indices.
    pub ranges: [Range<usize>; 3],
    /// So many elements along each axis become one, their mean; what is missing at the upper ends counts as zero.
    pub every: usize,
    /// True if elements that are negative or no numbers count as zero.
    pub clip: bool,
    /// Conversion to blocks of a grid, if any.
    pub blocking: Option<Blocking>,
}

impl ArrayPart {
    /// Lengths of the axes of what is read.
    pub fn shape(&self) -> [usize; 3] {
        std::array::from_fn(|axis| self.ranges[axis].len().div_ceil(self.every))
    }

    /// True if this is all of an array, as it is.
    pub fn is_whole(&self, shape: [usize; 3]) -> bool {
        self.every == 1 && !self.clip && self.blocking.is_none() && (0..3).all(|axis| self.ranges[axis] == (0..shape[axis]))
    }
}

/// Chooses what of an array is read, once its file has said what it has.
pub type Choose<'a> = &'a mut dyn FnMut(&ArrayHeader) -> Result<ArrayPart>;

/// Numbers in the precision that their file has, and no more: large arrays are mostly single.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// Numbers that single precision holds.
    Single(Shared<f32>),
    /// Numbers that need more.
    Double(Shared<f64>),
    /// Blocks of a grid, along x, y and z, where a [`ArrayPart`] asks for them.
    Blocks(Blocks),
}

impl Numbers {
    /// All of them, in double precision; those of blocks with x running fastest.
    pub fn doubles(&self) -> Vec<f64> {
        match self {
            Self::Single(values) => values.iter().map(|v| f64::from(*v)).collect(),
            Self::Double(values) => values.to_vec(),
            Self::Blocks(blocks) => blocks.values().into_iter().map(f64::from).collect(),
        }
    }
}

/// The orders that three axes can have, by their names.
pub const AXIS_ORDERS: [&str; 6] = ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx"];

/// Metadata of an array in a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ArrayFrame {
    /// The axes by name, in the order of the array's indices: one of [`AXIS_ORDERS`].
    pub order: &'static str,
    /// Unit of the values, as it is written.
    pub unit: Option<String>,
    /// The axes in the order of the array's indices, where their steps are known.
    pub axes: [Option<Axis>; 3],
    /// True if the steps of the axes came of a box along x, y and z, and hold in this order of them alone.
    pub is_by_letter: bool,
    /// True if there is nothing beyond the array, rather than something that the file does not have.
    pub is_sparse: bool,
    /// Axes that the file declares not to be lengths, such as "velocity (CTYPE3 VRAD)".
    pub others: [Option<String>; 3],
    /// The names of axes of which none says which of x, y and z it is, where the file gives such names.
    pub unnamed: Option<String>,
    /// Why the file's frame cannot be followed, such as a rotation, in words after "its".
    pub problem: Option<String>,
}

/// One linear axis of an array.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Unit of its coordinate, as it is written; empty where nothing is.
    pub unit: String,
    /// The step from one element to the next, in that unit.
    pub step: f64,
    /// Coordinate of the middle of the first element.
    pub first: f64,
}

/// A table of text: a line of column names, then rows of as many cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TextTable {
    /// Names of the columns, without blanks around them.
    pub columns: Vec<String>,
    /// The line that they stand in, from 1.
    pub line: usize,
    /// The line number and the cells of each row.
    pub rows: Vec<(usize, Vec<String>)>,
}

impl TextTable {
    /// The name of a column in small letters, and the unit in brackets behind it, as in "x \[pc\]".
    pub fn parted(column: &str) -> (String, Option<&str>) {
        match column.split_once(['[', '(']) {
            Some((name, unit)) => {
                (name.trim().to_lowercase(), Some(unit.trim_end_matches([']', ')']).trim()).filter(|unit| !unit.is_empty()))
            }
            None => (column.trim().to_lowercase(), None),
        }
    }
}

/// Finds what the names in a scene mean.
pub trait DataSource: Debug + Send + Sync {
    /// The name by which messages call what `name` stands for: a path, mostly.
    fn label(&self, name: &str) -> String;

    /// The text called `name`, of at most `memory_limit` bytes.
    ///
    /// # Errors
    /// If there is none, it is no UTF-8, or it is larger.
    fn text(&self, name: &str, memory_limit: u64) -> Result<Cow<'static, str>>;

    /// Bytes of the file called `name`, at most `memory_limit` of them.
    ///
    /// # Errors
    /// If there is none, or it is larger.
    fn bytes(&self, name: &str, memory_limit: u64) -> Result<Vec<u8>> {
        let _ = memory_limit;
        Err(Error::file(self.label(name), "is not a file"))
    }

    /// The table of text called `name`, of at most `most_rows` rows.
    ///
    /// # Errors
    /// Errors of [`text`](Self::text), and if it is no table; [`Error::Scene`] says the line.
    fn table(&self, name: &str, most_rows: usize, memory_limit: u64) -> Result<TextTable>;

    /// Columns of numbers of the file called `name`: a text, or a table of another format.
    ///
    /// # Errors
    /// Errors of [`text`](Self::text), and if it holds no columns of numbers.
    fn columns(&self, name: &str, memory_limit: u64) -> Result<Columns> {
        Ok(Columns::parse(name, &self.text(name, memory_limit)?)?)
    }

    /// The first band of the picture called `name`, or its HDU `hdu`: columns and rows, and its values, row by row, the
    /// first on top.
    ///
    /// # Errors
    /// If there is none, or it is larger than `memory_limit` bytes.
    fn picture(&self, name: &str, hdu: Option<&str>, memory_limit: u64) -> Result<([usize; 2], Vec<f64>)> {
        let _ = (hdu, memory_limit);
        Err(Error::file(self.label(name), "contains no readable image"))
    }

    /// What `choose` chooses of the array called `name`; `member` is the one that is meant where there are several. Its
    /// values may take `memory_limit` bytes as single precision.
    ///
    /// # Errors
    /// If there is none, or it has not three axes, or it is larger, and those of `choose`.
    fn array(&self, name: &str, member: Option<&str>, choose: Choose, memory_limit: u64) -> Result<Array>;
}

/// A source, and how much may be read of it at once.
#[derive(Debug, Clone)]
pub struct Inputs {
    source: Arc<dyn DataSource>,
    /// Most bytes that one array or image may take.
    pub memory_limit: u64,
    /// True if what takes long is made roughly.
    pub is_rough: bool,
    /// Cache of results between runs, if any.
    pub cache: Option<Arc<dyn Cache>>,
    /// Log of the interpretation of files; clones share it.
    notes: Arc<Mutex<Vec<InputNote>>>,
}

/// Interpretation of a file of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputNote {
    /// The file, as the scene names it.
    pub file: String,
    /// Its quantity, units, range and count, in one line.
    pub text: String,
    /// True if something of it was inferred, since neither the file nor the scene states it.
    pub is_inferred: bool,
}

impl Inputs {
    /// Reads from `source`; each array may take `memory_limit` bytes.
    pub fn new(source: Arc<dyn DataSource>, memory_limit: u64) -> Self {
        Self { source, memory_limit, is_rough: false, cache: None, notes: Arc::default() }
    }

    /// Source of the files.
    pub fn source(&self) -> &Arc<dyn DataSource> {
        &self.source
    }

    /// The name by which messages call what `name` stands for.
    pub fn label(&self, name: &str) -> String {
        self.source.label(name)
    }

    /// Copy of the source with a record of its own.
    #[must_use]
    pub fn recording(&self) -> Self {
        Self { notes: Arc::default(), ..self.clone() }
    }

    /// Records how a file was understood, once.
    pub fn note(&self, note: InputNote) {
        if let Ok(mut notes) = self.notes.lock()
            && !notes.contains(&note)
        {
            notes.push(note);
        }
    }

    /// Interpretations of the files that were read so far.
    pub fn notes(&self) -> Vec<InputNote> {
        self.notes.lock().map(|notes| notes.clone()).unwrap_or_default()
    }

    /// Columns of numbers of the file called `name`.
    ///
    /// # Errors
    /// Errors of [`DataSource::columns`].
    pub fn columns(&self, name: &str) -> Result<Columns> {
        self.source.columns(name, self.memory_limit)
    }

    /// The text called `name`.
    ///
    /// # Errors
    /// Errors of [`DataSource::text`].
    pub fn text(&self, name: &str) -> Result<Cow<'static, str>> {
        self.source.text(name, self.memory_limit)
    }

    /// The table of text called `name`, of at most `most_rows` rows.
    ///
    /// # Errors
    /// Errors of [`DataSource::table`].
    pub fn table(&self, name: &str, most_rows: usize) -> Result<TextTable> {
        self.source.table(name, most_rows, self.memory_limit)
    }

    /// The first band of the picture called `name`, or its HDU `hdu`: columns and rows, and its values, row by row.
    ///
    /// # Errors
    /// Errors of [`DataSource::picture`].
    pub fn picture(&self, name: &str, hdu: Option<&str>) -> Result<([usize; 2], Vec<f64>)> {
        self.source.picture(name, hdu, self.memory_limit)
    }

    /// What `choose` chooses of the array called `name`; `member` is the one that is meant where there are several.
    ///
    /// # Errors
    /// Errors of [`DataSource::array`].
    pub fn array(&self, name: &str, member: Option<&str>, choose: Choose) -> Result<Array> {
        self.source.array(name, member, choose, self.memory_limit)
    }
}

/// A source that has nothing: for scenes that name no files.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoData;

impl NoData {
    fn refuse<T>(name: &str) -> Result<T> {
        Err(Error::file(name, "cannot be read, because this scene has no files"))
    }
}

impl DataSource for NoData {
    fn label(&self, name: &str) -> String {
        name.to_owned()
    }
    fn text(&self, name: &str, _: u64) -> Result<Cow<'static, str>> {
        Self::refuse(name)
    }
    fn table(&self, name: &str, _: usize, _: u64) -> Result<TextTable> {
        Self::refuse(name)
    }
    fn array(&self, name: &str, _: Option<&str>, _: Choose, _: u64) -> Result<Array> {
        Self::refuse(name)
    }
}
