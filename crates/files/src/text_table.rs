//! Tables of text: columns parted by commas, semicolons, tabs or blanks, lines that begin with `#` and empty ones left
//! out.

use barnard::data::TextTable;
use barnard::error::{Error, Result};
use barnard::properties::{Origin, Place};

/// The table that `text` is, of at most `most_rows` rows; `file` is its name in messages.
///
/// # Errors
/// Where there are no column names or rows, or a row has more or fewer cells.
pub fn read(file: &str, text: &str, most_rows: usize) -> Result<TextTable> {
    let wrong = |line: usize, message: String| {
        let origin = Some(Origin { source: file.into(), line });
        Error::Scene { message, place: Place { origin, path: String::new(), key: "row".into() } }
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let is_said = |line: &str| !line.trim().is_empty() && !line.starts_with('#');
    let head = text.lines().find(|line| is_said(line)).ok_or_else(|| wrong(1, "holds no line of column names".into()))?;
    let delimiter = [b',', b';', b'\t'].into_iter().find(|d| head.as_bytes().contains(d)).unwrap_or(b' ');
    // Lines of blanks are empty; where blanks part columns, many are one.
    let line = |line: &str| match (is_said(line), delimiter) {
        (false, _) => String::new(),
        (true, b' ') => line.split_whitespace().collect::<Vec<_>>().join(" "),
        (true, _) => line.to_owned(),
    };
    let lines: Vec<String> = text.lines().map(line).collect();
    // Numbers of the lines that say something, from 1.
    let said: Vec<usize> = (1..).zip(&lines).filter(|(_, line)| !line.is_empty()).map(|(number, _)| number).collect();
    let text = lines.join("\n");
    let told = |error: csv::Error| {
        let line = error.position().map_or(1, |p| p.line() as usize);
        wrong(
            line,
            match error.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    format!("has {len} cells, the line of column names {expected_len}; a cell that says nothing is empty")
                }
                _ => error.to_string(),
            },
        )
    };
    let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).trim(csv::Trim::All).from_reader(text.as_bytes());
    let columns: Vec<String> = reader.headers().map_err(told)?.iter().map(str::to_owned).collect();
    let mut table = TextTable { columns, line: said.first().copied().unwrap_or(1), rows: Vec::new() };
    for row in reader.records() {
        let row = row.map_err(told)?;
        // A row's position is that of the empty lines before it.
        let before = row.position().map_or(1, |p| p.line() as usize);
        let line = said.get(said.partition_point(|at| *at < before)).copied().unwrap_or(before);
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
