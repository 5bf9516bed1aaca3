//! Tables of text: columns parted by commas, semicolons, tabs or blanks, lines that begin with `#` and empty ones left
//! out.

use std::io::{BufRead, Read};

use barnard::data::TextTable;
use barnard::error::{Error, Result};
use barnard::properties::{Origin, Place};

/// Most bytes of a line: a catalogue's are some thousands.
const MAX_LINE: u64 = 1 << 20;

/// The table that `source` holds, of at most `most_rows` rows; `file` is its name in messages. Rows behind the last
/// that is allowed are not read.
///
/// # Errors
/// Where the source cannot be read, is no UTF-8 or has endless lines, there are no column names or rows, or a row has
/// more or fewer cells.
pub fn read(file: &str, source: impl BufRead, most_rows: usize) -> Result<TextTable> {
    let wrong = |line: usize, message: String| {
        let origin = Some(Origin { source: file.into(), line });
        Error::Scene { message, place: Place { origin, path: String::new(), key: "row".into() } }
    };
    let lines = SaidLines::new(source).map_err(|error| Error::file(file, error.to_string()))?;
    let delimiter = lines.delimiter.unwrap_or(b',');
    let told = |error: csv::Error| {
        let line = error.position().map_or(1, |p| p.line() as usize);
        match error.kind() {
            csv::ErrorKind::Io(error) => Error::file(file, error.to_string()),
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                wrong(line, format!("has {len} cells, the line of column names {expected_len}; a cell that says nothing is empty"))
            }
            _ => wrong(line, error.to_string()),
        }
    };
    let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).trim(csv::Trim::All).from_reader(lines);
    let columns: Vec<String> = reader.headers().map_err(told)?.iter().map(str::to_owned).collect();
    let Some(line) = reader.get_ref().said.first().copied() else {
        return Err(wrong(1, "holds no line of column names".into()));
    };
    let mut table = TextTable { columns, line, rows: Vec::new() };
    let mut row = csv::StringRecord::new();
    while reader.read_record(&mut row).map_err(told)? {
        // A row's position is that of the empty lines before it.
        let before = row.position().map_or(1, |p| p.line() as usize);
        let line = reader.get_ref().said_from(before);
        if table.rows.len() == most_rows {
            return Err(wrong(line, format!("has more than {most_rows} rows, which is most that such a table may have")));
        }
        table.rows.push((line, row.iter().map(str::to_owned).collect()));
    }
    if table.rows.is_empty() {
        return Err(wrong(table.line, "holds no rows below its column names".into()));
    }
    Ok(table)
}

/// The lines of a source as a CSV reader wants them: those that say nothing are empty, many blanks that part columns
/// are one.
struct SaidLines<R> {
    source: R,
    /// What parts columns, once a line has said something.
    delimiter: Option<u8>,
    /// Lines read so far.
    count: usize,
    /// Numbers of the lines that say something, from 1.
    said: Vec<usize>,
    /// The current line, and how much of it was given.
    line: String,
    given: usize,
}

impl<R: BufRead> SaidLines<R> {
    /// Reads up to the first line that says something, which parts its columns as all lines do.
    fn new(source: R) -> std::io::Result<Self> {
        let mut lines = Self { source, delimiter: None, count: 0, said: Vec::new(), line: String::new(), given: 0 };
        let mut head = String::new();
        while lines.said.is_empty() && lines.advance()? {
            head += &lines.line;
        }
        lines.line = head;
        Ok(lines)
    }

    /// Takes the next line up; false where there is none.
    fn advance(&mut self) -> std::io::Result<bool> {
        let refuse = |words: &str| Err(std::io::Error::new(std::io::ErrorKind::InvalidData, words));
        let mut bytes = Vec::new();
        if self.source.by_ref().take(MAX_LINE).read_until(b'\n', &mut bytes)? == 0 {
            return Ok(false);
        }
        if bytes.len() as u64 == MAX_LINE && !bytes.ends_with(b"\n") {
            return refuse("has a line of more than a mebibyte, which no table of text has");
        }
        let Ok(text) = std::str::from_utf8(&bytes) else { return refuse("is no text in UTF-8") };
        self.count += 1;
        let text = if self.count == 1 { text.strip_prefix('\u{feff}').unwrap_or(text) } else { text };
        let text = text.trim_end_matches(['\n', '\r']);
        self.line.clear();
        if !text.trim().is_empty() && !text.starts_with('#') {
            self.said.push(self.count);
            let parts = || [b',', b';', b'\t'].into_iter().find(|d| text.as_bytes().contains(d));
            match self.delimiter.get_or_insert_with(|| parts().unwrap_or(b' ')) {
                b' ' => self.line = text.split_whitespace().collect::<Vec<_>>().join(" "),
                _ => self.line += text,
            }
        }
        self.line.push('\n');
        self.given = 0;
        Ok(true)
    }

    /// The first line that says something, from `line` on.
    fn said_from(&self, line: usize) -> usize {
        self.said.get(self.said.partition_point(|at| *at < line)).copied().unwrap_or(line)
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
