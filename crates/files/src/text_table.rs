//! Tables of text: columns separated by commas, semicolons, tabs or blanks. Lines that begin with `#` and empty ones are
//! skipped, except for column names that stand behind a `#` (numpy.savetxt, TOPCAT) and the units of an ECSV header.

use std::io::{BufRead, Read};

use barnard::data::TextTable;
use barnard::error::{Error, Result};
use barnard::properties::{Origin, Place};

use crate::columns::ecsv;

/// Most bytes of a line: a catalogue's are some thousands.
const MAX_LINE: u64 = 1 << 20;

/// The table that `source` holds, of at most `most_rows` rows; `file` is its name in messages. Rows behind the last
/// that is allowed are not read.
///
/// # Errors
/// If the source cannot be read, is no UTF-8 or has endless lines, there are no column names or rows, or a row has
/// more or fewer cells.
pub fn read(file: &str, source: impl BufRead, most_rows: usize) -> Result<TextTable> {
    let wrong = |line: usize, message: String| {
        let origin = Some(Origin { source: file.into(), line });
        Error::Scene { message, place: Place { origin, path: String::new(), key: "row".into() } }
    };
    let lines = SaidLines::new(source).map_err(|error| Error::file(file, error.to_string()))?;
    let delimiter = lines.delimiter.unwrap_or(b',');
    let malformed = |error: csv::Error| {
        let line = error.position().map_or(1, |p| p.line() as usize);
        match error.kind() {
            csv::ErrorKind::Io(error) => Error::file(file, error.to_string()),
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                wrong(line, format!("has {len} cells, the header {expected_len}; leave missing cells empty"))
            }
            _ => wrong(line, error.to_string()),
        }
    };
    let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).trim(csv::Trim::All).from_reader(lines);
    let mut columns: Vec<String> = reader.headers().map_err(malformed)?.iter().map(str::to_owned).collect();
    for (name, unit) in reader.get_ref().ecsv_units() {
        columns.iter_mut().filter(|column| **column == name).for_each(|column| *column = format!("{name} [{unit}]"));
    }
    let Some(line) = reader.get_ref().numbers.first().copied() else {
        return Err(wrong(1, "has no header".into()));
    };
    let mut table = TextTable { columns, line, rows: Vec::new() };
    let mut row = csv::StringRecord::new();
    let is_open = |row: &csv::StringRecord| row.iter().any(|cell| cell.contains('\n'));
    loop {
        match reader.read_record(&mut row) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) if !is_open(&row) => return Err(malformed(error)),
            Err(_) => {}
        }
        // A row's position is that of the empty lines before it.
        let before = row.position().map_or(1, |p| p.line() as usize);
        let line = reader.get_ref().said_from(before);
        if is_open(&row) {
            return Err(wrong(line, "has an unclosed quotation mark; close it, or remove it from the name".into()));
        }
        if table.rows.len() == most_rows {
            return Err(wrong(line, format!("has more than {most_rows} rows, the limit of such a table")));
        }
        table.rows.push((line, row.iter().map(str::to_owned).collect()));
    }
    if table.rows.is_empty() {
        return Err(wrong(table.line, "has no rows below its header".into()));
    }
    Ok(table)
}

/// The next line of a source, of [`MAX_LINE`] bytes at most, its end as "\n": lines end with LF, CR LF or CR.
fn line_of(source: &mut impl BufRead) -> std::io::Result<Vec<u8>> {
    let mut line = Vec::new();
    while (line.len() as u64) < MAX_LINE {
        let bytes = source.fill_buf()?;
        if bytes.is_empty() {
            break;
        }
        let room = bytes.len().min(MAX_LINE as usize - line.len());
        let end = bytes[..room].iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        line.extend_from_slice(&bytes[..end.unwrap_or(room)]);
        let Some(end) = end else {
            source.consume(room);
            continue;
        };
        let is_return = bytes[end] == b'\r';
        source.consume(end + 1);
        if is_return && source.fill_buf()?.first() == Some(&b'\n') {
            source.consume(1);
        }
        line.push(b'\n');
        break;
    }
    Ok(line)
}

/// The lines of a source as a CSV reader wants them: those that say nothing are empty, many blanks that part columns
/// are one.
struct SaidLines<R> {
    source: R,
    /// Column separator, after the first data line.
    delimiter: Option<u8>,
    /// Lines read so far.
    count: usize,
    /// Numbers of the lines that say something, from 1.
    numbers: Vec<usize>,
    /// Comments above the first of them, of at most [`MAX_LINE`] bytes.
    comments: String,
    /// The current line, and how much of it was given.
    line: String,
    given: usize,
}

impl<R: BufRead> SaidLines<R> {
    /// Reads up to the first line that says something, which parts its columns as all lines do.
    fn new(source: R) -> std::io::Result<Self> {
        let comments = String::new();
        let mut lines = Self { source, delimiter: None, count: 0, numbers: Vec::new(), comments, line: String::new(), given: 0 };
        let mut head = String::new();
        while lines.numbers.is_empty() && lines.advance()? {
            if lines.numbers.is_empty() {
                head += &lines.line;
            }
            if head.len() + lines.comments.len() > MAX_LINE as usize {
                let words = "has more than 1 MiB of comments and empty lines above its first row";
                return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, words));
            }
        }
        if let Some(names) = lines.names_in_comment() {
            // The names stand in the empty line of their comment.
            head.pop();
            head += &names;
            head.push('\n');
            lines.numbers.insert(0, lines.count - 1);
        }
        lines.line = head + &lines.line;
        Ok(lines)
    }

    /// The column names in the comment right above the first row, where that row has numbers only: as many names as the
    /// row has cells.
    fn names_in_comment(&self) -> Option<String> {
        let delimiter = char::from(self.delimiter?);
        let cells: Vec<&str> = self.line.trim_end().split(delimiter).collect();
        let is_number = |cell: &&str| cell.trim().is_empty() || cell.trim().parse::<f64>().is_ok();
        let comment = self.comments.lines().last()?.trim_start_matches('#').trim();
        let names = if delimiter == ' ' { comment.split_whitespace().collect() } else { comment.split(delimiter).collect::<Vec<_>>() };
        let is_head = names.len() == cells.len() && cells.len() > 1 && !names.iter().any(is_number);
        (self.numbers == [self.count] && self.count > 1 && cells.iter().all(is_number) && is_head)
            .then(|| names.join(&delimiter.to_string()))
    }

    /// Names and units of columns by the header of an ECSV file.
    fn ecsv_units(&self) -> Vec<(String, String)> {
        if self.comments.starts_with(ecsv::MAGIC) { ecsv::units(&self.comments) } else { Vec::new() }
    }

    /// Takes the next line up; false where there is none.
    fn advance(&mut self) -> std::io::Result<bool> {
        let refuse = |words: &str| Err(std::io::Error::new(std::io::ErrorKind::InvalidData, words));
        let bytes = line_of(&mut self.source)?;
        if bytes.is_empty() {
            return Ok(false);
        }
        if bytes.len() as u64 >= MAX_LINE && !bytes.ends_with(b"\n") {
            return refuse("has a line of more than 1 MiB");
        }
        let Ok(text) = std::str::from_utf8(&bytes) else { return refuse("is not UTF-8 text") };
        self.count += 1;
        let text = if self.count == 1 { text.strip_prefix('\u{feff}').unwrap_or(text) } else { text };
        let text = text.trim_end_matches('\n');
        self.line.clear();
        if !text.trim().is_empty() && !text.starts_with('#') {
            self.numbers.push(self.count);
            let parts = || [b',', b';', b'\t'].into_iter().find(|d| text.as_bytes().contains(d));
            match self.delimiter.get_or_insert_with(|| parts().unwrap_or(b' ')) {
                b' ' => self.line = text.split_whitespace().collect::<Vec<_>>().join(" "),
                _ => self.line += text,
            }
        }
        if self.numbers.is_empty() && text.starts_with('#') {
            self.comments += text;
            self.comments.push('\n');
        } else if self.numbers.is_empty() && !self.comments.starts_with(ecsv::MAGIC) {
            // Column names stand right above the first row.
            self.comments.clear();
        }
        self.line.push('\n');
        self.given = 0;
        Ok(true)
    }

    /// The first line that says something, from `line` on.
    fn said_from(&self, line: usize) -> usize {
        self.numbers.get(self.numbers.partition_point(|at| *at < line)).copied().unwrap_or(line)
    }
}

impl<R: BufRead> Read for SaidLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.given == self.line.len() && !self.advance()? {
            return Ok(0);
        }
        let more = &self.line.as_bytes()[self.given..];
        let count = more.len().min(buffer.len());
        buffer[..count].copy_from_slice(&more[..count]);
        self.given += count;
        Ok(count)
    }
}
