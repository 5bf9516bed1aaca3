//! Columns of numbers out of text: the separators, decimal signs, comments and headers that people's files have.

use super::axis_unit::AxisUnit;
use super::cell::names_axis;
use crate::error::{Result, SpectraError};
use crate::table::MAX_SAMPLES;

/// Columns of numbers, with what their file says of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    /// The columns; without names where the file has none.
    pub columns: Vec<Column>,
    /// The rows, each with its line number and as many numbers as there are columns; empty cells are NaN.
    pub rows: Vec<(usize, Vec<f64>)>,
    /// Comments before the first row, without their marks, each with its line number.
    pub comments: Vec<(usize, String)>,
    /// The separators and the decimal sign, in words.
    pub dialect: String,
    /// True if the detector counts photons, where the file says so.
    pub counts_photons: Option<bool>,
}

/// The name of a column and the unit that its file states for it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// The name; empty where the file has none.
    pub name: String,
    /// The unit, where it is stated apart from the name.
    pub unit: Option<String>,
}

/// Separators of cells and of decimals.
#[derive(Debug, Clone, Copy)]
struct Dialect {
    separator: char,
    decimal: char,
}

const DIALECTS: [Dialect; 7] = [
    Dialect { separator: ';', decimal: '.' },
    Dialect { separator: '\t', decimal: '.' },
    Dialect { separator: ',', decimal: '.' },
    Dialect { separator: ' ', decimal: '.' },
    Dialect { separator: ';', decimal: ',' },
    Dialect { separator: '\t', decimal: ',' },
    Dialect { separator: ' ', decimal: ',' },
];

impl Dialect {
    fn cells<'a>(&self, line: &'a str) -> Vec<&'a str> {
        let unquoted = |cell: &'a str| cell.trim().trim_matches(['"', '\'']).trim();
        match self.separator {
            ' ' => line.split_whitespace().map(unquoted).collect(),
            separator => {
                let mut cells: Vec<&str> = line.split(separator).map(unquoted).collect();
                // Spreadsheets end rows with a separator.
                if cells.len() > 2 && cells.last() == Some(&"") {
                    cells.pop();
                }
                cells
            }
        }
    }

    fn number(&self, cell: &str) -> Option<f64> {
        if cell.is_empty() {
            return Some(f64::NAN);
        }
        if self.decimal == ',' && cell.contains('.') {
            return None;
        }
        // Fortran writes 1.0D+03.
        let text: String = cell
            .chars()
            .map(|c| {
                if c == self.decimal {
                    '.'
                } else if c == 'D' || c == 'd' {
                    'E'
                } else {
                    c
                }
            })
            .collect();
        text.parse().ok()
    }

    fn row(&self, line: &str) -> Option<Vec<f64>> {
        let cells = self.cells(line);
        if cells.iter().all(|cell| cell.is_empty()) {
            return None;
        }
        cells.into_iter().map(|cell| self.number(cell)).collect()
    }

    /// True if the line has several cells and each is a number, or empty behind the first.
    fn starts_with_numbers(&self, line: &str) -> bool {
        let cells = self.cells(line);
        let is_number = |cell: &&str| !cell.is_empty() && self.number(cell).is_some();
        let is_separated = if self.separator == ' ' { line.trim().contains(char::is_whitespace) } else { line.contains(self.separator) };
        is_separated && cells.first().is_some_and(is_number) && self.row(line).is_some()
    }

    fn words(&self) -> String {
        let separator = match self.separator {
            ';' => "semicolons",
            '\t' => "tabs",
            ',' => "commas",
            _ => "blanks",
        };
        if self.decimal == ',' { format!("separated by {separator}, decimal commas") } else { format!("separated by {separator}") }
    }
}

/// Marks that begin a comment.
const COMMENT_MARKS: [&str; 4] = ["#", "%", "!", "//"];

fn comment(line: &str) -> Option<&str> {
    COMMENT_MARKS.iter().find_map(|mark| line.strip_prefix(mark)).map(|rest| rest.trim_start_matches(['#', '%', '!', '/']).trim())
}

impl Columns {
    /// Reads columns of numbers from text. `name` is the file's name in messages.
    ///
    /// Cells are separated by commas, semicolons, tabs or blanks, the same in all rows. Decimal commas are read where
    /// no cell can mean anything else. Lines that begin with `#`, `%`, `!` or `//` are comments. A line of names, and a
    /// line of units below it, may precede the numbers.
    ///
    /// # Errors
    /// If a row is no row of numbers or has another length than the first, numbers are ambiguous, or there are more
    /// than a million rows; with the line.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).replace("\r\n", "\n").replace('\r', "\n");
        let lines: Vec<(usize, &str)> = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()).collect();
        if let Some((line, _)) = lines.iter().find(|(_, line)| line.contains('\0')) {
            return Err(SpectraError::table(name, format!("line {line} contains a NUL byte; save the file as plain text in UTF-8")));
        }
        let body: Vec<(usize, &str)> = lines.iter().copied().filter(|(_, line)| comment(line.trim_start()).is_none()).collect();
        let is_row = |line: &str| DIALECTS.iter().any(|dialect| dialect.starts_with_numbers(line));
        let Some(first) = body.iter().position(|(_, line)| is_row(line)) else {
            let is_numeric = |(_, line): &&(usize, &str)| line.trim_start().starts_with(|c: char| c.is_ascii_digit());
            let line = body.iter().find(is_numeric).or(body.first());
            let shown = line.map_or(String::new(), |(line, text)| format!("; line {line} is \"{}\"", clipped(text)));
            return Err(SpectraError::table(name, format!("has no rows of two or more numbers{shown}")));
        };
        if body.len() - first > MAX_SAMPLES {
            return Err(SpectraError::table(name, format!("has more than {MAX_SAMPLES} rows")));
        }
        let dialect = dialect(name, &body[first..])?;
        let first_line = body[first].0;
        let mut columns = Self {
            comments: lines
                .iter()
                .filter(|(line, _)| *line < first_line)
                .filter_map(|(line, text)| Some((*line, comment(text.trim_start())?.to_owned())))
                .collect(),
            dialect: dialect.words(),
            ..Self::default()
        };
        for (line, text) in &body[first..] {
            let row = dialect.row(text).ok_or_else(|| not_a_row(name, *line, text))?;
            let width = columns.rows.first().map_or(row.len(), |(_, first)| first.len());
            if row.len() != width {
                let count = row.len();
                let numbers = if count == 1 { "number" } else { "numbers" };
                let reason = format!("line {line} has {count} {numbers}, the rows above have {width}; use decimal points");
                return Err(SpectraError::table(name, reason));
            }
            columns.rows.push((*line, row));
        }
        columns.columns = columns.named(name, &body[..first], dialect)?;
        Ok(columns)
    }

    /// The columns by the lines above the first row, or by a comment that names them.
    fn named(&self, name: &str, head: &[(usize, &str)], dialect: Dialect) -> Result<Vec<Column>> {
        let width = self.rows.first().map_or(0, |(_, row)| row.len());
        let mut columns = vec![Column::default(); width];
        // A row that is broken must not pass for names: only a unit such as "0.1 nm" begins with a digit.
        let begins_with_number = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let is_broken =
            |line: &str| begins_with_number(line) && dialect.cells(line).first().is_none_or(|cell| AxisUnit::parse(cell).is_none());
        // Dashes below the names, as VizieR writes them.
        let head: Vec<&(usize, &str)> = head.iter().filter(|(_, line)| line.chars().any(|c| !"-=|+ \t,;".contains(c))).collect();
        if let Some((line, text)) = head.iter().find(|(_, line)| is_broken(line)) {
            return Err(not_a_row(name, *line, text));
        }
        // Titles may stand above the names, units below them.
        let first = head.iter().position(|(_, line)| cells_are_spectral(line, dialect, width)).unwrap_or(0);
        if head.len() > first + 2 {
            return Err(not_a_row(name, head[first + 1].0, head[first + 1].1));
        }
        if head.is_empty() {
            columns = self.commented(columns);
        }
        for (place, (line, text)) in head.into_iter().skip(first).enumerate() {
            let cells = head_cells(text, dialect, width).ok_or_else(|| {
                SpectraError::table(name, format!("line {line} must have {width} names, one per column: \"{}\"", clipped(text)))
            })?;
            for (column, cell) in columns.iter_mut().zip(cells) {
                if place == 0 {
                    column.name = cell;
                } else if !cell.is_empty() {
                    column.unit = Some(cell);
                }
            }
        }
        Ok(columns)
    }

    /// The cells of the last comment above the rows, where it has as many as there are columns and is no "KEY: VALUE".
    pub(super) fn last_comment(&self, width: usize) -> Option<Vec<String>> {
        let (_, text) = self.comments.last().filter(|(_, text)| !text.contains(':'))?;
        DIALECTS.iter().find_map(|dialect| cells_of_width(text, *dialect, width))
    }

    /// Columns as comments name them: the last one above the rows where one of its cells is a wavelength, or lines such
    /// as "1 WAVELENGTH wavelength of the filter [Angstrom]".
    fn commented(&self, mut columns: Vec<Column>) -> Vec<Column> {
        let last = self.last_comment(columns.len()).filter(|cells| is_spectral(cells));
        for (column, cell) in columns.iter_mut().zip(last.unwrap_or_default()) {
            column.name = cell;
        }
        for (_, text) in &self.comments {
            let mut words = text.split_whitespace();
            let number = words.next().and_then(|word| word.parse::<usize>().ok()).and_then(|number| number.checked_sub(1));
            let (Some(column), Some(name)) = (number.and_then(|number| columns.get_mut(number)), words.next()) else { continue };
            let unit = text.rsplit_once('[').and_then(|(_, unit)| unit.trim().strip_suffix(']'));
            if name.chars().all(|c| c.is_uppercase() || c.is_ascii_digit() || c == '_') {
                *column = Column { name: name.to_owned(), unit: unit.map(str::to_owned) };
            }
        }
        columns
    }
}

/// True if one of some names is that of a spectral axis, or the first is a unit of one.
fn is_spectral(cells: &[String]) -> bool {
    let first = cells.first().is_some_and(|cell| cell.chars().count() > 1 && AxisUnit::parse(cell).is_some());
    first || cells.iter().any(|cell| names_axis(cell))
}

fn cells_are_spectral(line: &str, dialect: Dialect, width: usize) -> bool {
    head_cells(line, dialect, width).is_some_and(|cells| is_spectral(&cells))
}

/// Names of `width` columns, separated as the rows are or in any other way.
fn head_cells(line: &str, dialect: Dialect, width: usize) -> Option<Vec<String>> {
    [dialect].iter().chain(&DIALECTS).find_map(|dialect| cells_of_width(line, *dialect, width))
}

/// Names of `width` columns; blanks separate them only where they do not stand in brackets.
fn cells_of_width(line: &str, dialect: Dialect, width: usize) -> Option<Vec<String>> {
    let trimmed = |cells: Vec<&str>| Some(cells.into_iter().map(|cell| cell.trim().trim_matches('"').to_owned()).collect::<Vec<String>>());
    if dialect.separator != ' ' {
        let mut cells: Vec<&str> = line.split(dialect.separator).collect();
        while cells.len() > width && cells.last().is_some_and(|cell| cell.trim().is_empty()) {
            cells.pop();
        }
        return if cells.len() == width { trimmed(cells) } else { None };
    }
    // "Wavelength (nm)   Transmission (%)": two blanks separate, or brackets belong to the name before them.
    let wide: Vec<&str> = line.split("  ").filter(|part| !part.trim().is_empty()).collect();
    if wide.len() == width {
        return trimmed(wide);
    }
    let is_open = |name: &str| name.matches(['[', '(']).count() > name.matches([']', ')']).count();
    let mut joined: Vec<String> = Vec::new();
    for word in line.split_whitespace() {
        match joined.last_mut().filter(|last| word.starts_with(['[', '(']) || is_open(last)) {
            Some(last) => *last += &format!(" {word}"),
            None => joined.push(word.to_owned()),
        }
    }
    (joined.len() == width).then_some(joined)
}

/// The dialect of rows: the first in which every row is one of numbers.
fn dialect(name: &str, rows: &[(usize, &str)]) -> Result<Dialect> {
    let width = |dialect: &Dialect| {
        let count = |line: &str| dialect.row(line).map(|row| row.len());
        let first = count(rows[0].1).filter(|width| *width > 1)?;
        rows.iter().all(|(_, line)| count(line) == Some(first)).then_some(first)
    };
    let Some(found) = DIALECTS.iter().find(|dialect| width(dialect).is_some()) else {
        // One row differs: the dialect of the first row names it.
        let first = DIALECTS.iter().find(|dialect| dialect.row(rows[0].1).is_some_and(|row| row.len() > 1));
        return first.copied().ok_or_else(|| not_a_row(name, rows[0].0, rows[0].1));
    };
    if found.decimal == ',' {
        // "1,234" may mean 1.234 or 1234: a cell that can mean a decimal fraction alone decides.
        let cells = rows.iter().flat_map(|(_, line)| found.cells(line)).filter(|cell| cell.contains(','));
        let grouped = |cell: &str| {
            let (whole, decimals) = cell.split_once(',').unwrap_or((cell, ""));
            decimals.len() == 3 && (1..=3).contains(&whole.trim_start_matches(['-', '+']).len()) && !whole.starts_with('0')
        };
        if cells.clone().all(grouped) {
            let (line, text) = rows.iter().find(|(_, line)| line.contains(',')).unwrap_or(&rows[0]);
            let reason = format!("line {line}: \"{}\" has commas that separate decimals or thousands; write decimal points", clipped(text));
            return Err(SpectraError::table(name, reason));
        }
    }
    Ok(*found)
}

fn not_a_row(name: &str, line: usize, text: &str) -> SpectraError {
    SpectraError::table(
        name,
        format!(
            "line {line} is not a row of numbers: \"{}\"; use decimal points, and separate columns with commas, semicolons, tabs or blanks",
            clipped(text)
        ),
    )
}

fn clipped(line: &str) -> String {
    line.trim().chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each text holds the rows (400, 0.6), (500, 0.7).
    #[test]
    fn dialects_are_read() {
        for text in [
            "400,0.6\n500,0.7\n",
            "400 0.6\n500 0.7\n",
            "  400\t0.6\r\n  500\t0.7\r\n",
            "400;0.6\r500;0.7\r",
            "400;0,6\n500;0,7\n",
            "400\t0,6\n500\t0,7\n",
            "400,0 0,6\n500,0 0,7\n",
            "\u{feff}400,0.6\n500,0.7\n",
            "\u{feff}# note\nnm,t\n400,0.6\n500,0.7\n",
            "4.0D+02,6.0d-1\n5.0D+02,7.0d-1\n",
            "\"400\",\"0.6\"\n\"500\",\"0.7\"\n",
            "400,0.6,\n500,0.7,\n",
            "% note\n! note\n// note\n400 0.6\n\n500 0.7\n",
            "wave;t\nnm;\n---;---\n400;0,6\n500;0,7\n",
            "Filter V\nwavelength_nm,t\n400,0.6\n500,0.7\n",
            "400\u{a0}0.6\n500\u{a0}0.7\n",
        ] {
            let columns = Columns::parse("t", text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            let rows: Vec<Vec<f64>> = columns.rows.into_iter().map(|(_, row)| row).collect();
            assert_eq!(rows, [[400.0, 0.6], [500.0, 0.7]], "{text:?}");
        }
    }

    #[test]
    fn what_is_ambiguous_is_refused_with_its_line() {
        for (text, words) in [
            ("", "no rows"),
            ("a,b\n1,2\nx,y\n", "line 3"),
            ("1,2\n1,2,3\n", "line 2"),
            ("a,b\n500,5;0,5\n600,5;0.6\n", "line 3"),
            ("5,100;1,200\n5,200;1,300\n", "thousands"),
            ("400,0.6\n500\0,0.7\n", "NUL"),
            ("a b c d\ne f g h\ni j k l\n1 2 3 4\n", "line 2"),
            ("1\n2\n", "no rows"),
            ("500 --\n525 0.4\n550 0.8\n", "line 1"),
            ("500*,0.0\n525,0.4\n", "line 1"),
            ("# nm\n5_00 0\n550 0.8\n", "line 2"),
            ("nm,t\n500,null\n525,0.4\n", "line 2"),
        ] {
            let error = Columns::parse("t", text).unwrap_err().to_string();
            assert!(error.contains(words), "{text:?}: {error}");
        }
    }
}
