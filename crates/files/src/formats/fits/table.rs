//! Tables of FITS, as far as the tiles of images stand in them: rows of cells, and lists behind the rows.
//!
//! Source: FITS standard 4.0, §7.3.

use barnard::error::{Error, Result};
use barnard::memory;
use spectra::curve::{self, Columns};
use spectra::table::MAX_SAMPLES;

use super::header::Header;
use crate::formats::Request;

/// The rows and columns of a table.
pub struct FitsTable {
    /// Bytes of a row.
    pub row: usize,
    rows: usize,
    /// Starts of the lists, from the first row on.
    pub heap: u64,
    columns: Vec<FitsColumn>,
}

struct FitsColumn {
    name: String,
    /// Offset in a row, and format.
    at: usize,
    format: String,
}

impl FitsTable {
    /// The table whose header this is.
    pub fn of(header: &Header) -> Result<Self, String> {
        let size =
            |keyword: &str| header.integer(keyword).and_then(|n| usize::try_from(n).ok()).ok_or(format!("{keyword} is missing or invalid"));
        let (row, rows, fields) = (size("NAXIS1")?, size("NAXIS2")?, size("TFIELDS")?);
        let heap = header.integer("THEAP").and_then(|n| u64::try_from(n).ok()).unwrap_or((row as u64).saturating_mul(rows as u64));
        let mut columns = Vec::new();
        let mut at = 0usize;
        for i in 1..=fields.min(999) {
            let format = header.text(&format!("TFORM{i}")).unwrap_or("").trim().to_owned();
            let width = width(&format).ok_or_else(|| format!("TFORM{i} = '{format}' is not a column format"))?;
            columns.push(FitsColumn { name: header.text(&format!("TTYPE{i}")).unwrap_or("").trim().to_owned(), at, format });
            at = at.saturating_add(width);
        }
        if at > row {
            return Err(format!("its columns need {at} bytes, a row has {row}"));
        }
        Ok(Self { row, rows, heap, columns })
    }

    /// Its rows, which stand before the lists.
    pub fn read(&self, request: &mut Request, header: &Header) -> Result<Vec<u8>> {
        let bytes = (self.row as u64).saturating_mul(self.rows as u64);
        memory::check(&format!("the table of tiles of {}", request.path.display()), bytes, request.memory_limit)?;
        let read = request.bytes(header.data, usize::try_from(bytes).unwrap_or(usize::MAX))?;
        read.ok_or_else(|| Error::file(request.path, "is truncated: its table of tiles is incomplete"))
    }

    fn column<'a>(&self, name: &str, cells: &'a [u8]) -> Option<(&str, &'a [u8])> {
        let column = self.columns.iter().find(|column| column.name == name)?;
        Some((column.format.trim_start_matches(|c: char| c.is_ascii_digit()), cells.get(column.at..)?))
    }

    /// All columns of single numbers, with their names and units; a column of anything else is refused by name.
    ///
    /// # Errors
    /// If a cell holds no single number, or there are more than a million rows.
    pub fn columns(&self, header: &Header, cells: &[u8]) -> Result<Columns, String> {
        if self.rows > MAX_SAMPLES {
            return Err(format!("has more than {MAX_SAMPLES} rows"));
        }
        let text = |keyword: &str, i: usize| header.text(&format!("{keyword}{}", i + 1)).map(str::trim).filter(|text| !text.is_empty());
        let mut columns = Columns {
            dialect: "of a FITS table".into(),
            rows: (1..=self.rows).map(|row| (row, Vec::new())).collect(),
            ..Columns::default()
        };
        for (i, column) in self.columns.iter().enumerate() {
            let letter = column.format.trim_start_matches('1');
            if letter.starts_with(|c: char| c.is_ascii_digit()) && !letter.ends_with('A') {
                return Err(format!("column \"{}\" has {} numbers per cell; write one number per row", column.name, column.format));
            }
            columns.columns.push(curve::Column { name: column.name.clone(), unit: text("TUNIT", i).map(str::to_owned) });
            let (scale, zero) =
                (header.number(&format!("TSCAL{}", i + 1)).unwrap_or(1.0), header.number(&format!("TZERO{}", i + 1)).unwrap_or(0.0));
            let blank = header.integer(&format!("TNULL{}", i + 1)).map(|blank| blank as f64);
            for (row, bytes) in columns.rows.iter_mut().zip(cells.chunks_exact(self.row.max(1))) {
                // A column of texts next to the numbers is no number.
                let stored = bytes.get(column.at..).and_then(|cell| number(letter, cell)).filter(|stored| Some(*stored) != blank);
                row.1.push(stored.map_or(f64::NAN, |stored| zero + scale * stored));
            }
        }
        if columns.columns.len() < 2 || columns.rows.is_empty() {
            return Err("has no rows of two or more columns".into());
        }
        Ok(columns)
    }

    /// Start of a cell's list, and its bytes.
    pub fn list(&self, name: &str, cells: &[u8]) -> Option<(u64, u64)> {
        let (format, cell) = self.column(name, cells)?;
        let (count, from) = match format.chars().next()? {
            'P' => {
                let number = |at: usize| Some(u64::from(u32::from_be_bytes(*cell.get(at..)?.first_chunk()?)));
                (number(0)?, number(4)?)
            }
            'Q' => {
                let number = |at: usize| Some(u64::from_be_bytes(*cell.get(at..)?.first_chunk()?));
                (number(0)?, number(8)?)
            }
            _ => return None,
        };
        Some((from, count.checked_mul(size(format.chars().nth(1)?)? as u64)?))
    }

    /// The number in a cell, where the table has such a column.
    pub fn number(&self, name: &str, cells: &[u8]) -> Option<f64> {
        let (format, cell) = self.column(name, cells)?;
        number(format, cell)
    }
}

/// The number in a cell of a format without its count.
fn number(format: &str, cell: &[u8]) -> Option<f64> {
    Some(match format.chars().next()? {
        'D' => f64::from_be_bytes(*cell.first_chunk()?),
        'E' => f64::from(f32::from_be_bytes(*cell.first_chunk()?)),
        'K' => i64::from_be_bytes(*cell.first_chunk()?) as f64,
        'J' => f64::from(i32::from_be_bytes(*cell.first_chunk()?)),
        'I' => f64::from(i16::from_be_bytes(*cell.first_chunk()?)),
        'B' => f64::from(*cell.first()?),
        _ => return None,
    })
}

/// Bytes of an element of a column. Source: FITS standard 4.0, table 18.
fn size(letter: char) -> Option<usize> {
    Some(match letter {
        'L' | 'B' | 'A' => 1,
        'I' => 2,
        'J' | 'E' => 4,
        'K' | 'D' | 'C' | 'P' => 8,
        'M' | 'Q' => 16,
        _ => return None,
    })
}

/// Bytes of a cell of a column.
fn width(format: &str) -> Option<usize> {
    let letter = format.find(|c: char| !c.is_ascii_digit())?;
    let count: usize = if letter == 0 { 1 } else { format[..letter].parse().ok()? };
    match format[letter..].chars().next()? {
        'X' => Some(count.div_ceil(8)),
        letter => count.checked_mul(size(letter)?),
    }
}
