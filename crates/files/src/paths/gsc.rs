//! Camera paths of Gaia Sky (.gsc): a line of text for each frame, with the frame rate in a comment.
//!
//! | column | what | unit |
//! |---|---|---|
//! | 1 | the time that is shown, as milliseconds or a date; a frame's own time is its number over the rate | |
//! | 2 to 4 | position | 10⁹ m |
//! | 5 to 7 | direction | |
//! | 8 to 10 | up | |
//!
//! Columns are parted by commas or blanks. The rate stands in a line `#fps 60.0`, and is 60 by default. Source: the
//! manual of Gaia Sky, "Camera paths". Left out: the time that is shown, which moves stars and planets there.

use barnard::data::TextTable;
use barnard::error::{Error, Result};
use barnard::properties::{Origin, Place};

use super::{PathReader, Request, table};

pub(super) const READER: PathReader = PathReader { extensions: &["gsc"], read };

/// The unit of lengths [m].
const UNIT_M: f64 = 1e9;
/// Frames a second where a file does not say it.
const USUAL_RATE: f64 = 60.0;
const COLUMNS: [&str; 10] = ["time [s]", "x [m]", "y [m]", "z [m]", "direction_x", "direction_y", "direction_z", "up_x", "up_y", "up_z"];

fn read(request: &Request) -> Result<TextTable> {
    let file = request.path.display().to_string();
    let text = std::str::from_utf8(request.bytes).map_err(|_| Error::file(request.path, "is not UTF-8 text"))?;
    let wrong = |line: usize, message: String| {
        let origin = Some(Origin { source: file.as_str().into(), line });
        Error::Scene { message, place: Place { origin, path: String::new(), key: "row".into() } }
    };
    let mut rate = USUAL_RATE;
    let mut rows: Vec<(usize, Vec<f64>)> = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let text = text.trim();
        if let Some(comment) = text.strip_prefix('#') {
            let stated_rate = comment.trim().strip_prefix("fps").map(|rest| rest.trim().trim_start_matches(['=', ':']).trim());
            if let Some(stated_rate) = stated_rate {
                let number = stated_rate.parse::<f64>().ok().filter(|rate| *rate > 0.0 && rate.is_finite());
                rate = number.ok_or_else(|| wrong(line, format!("\"{stated_rate}\" is not a number of frames per second")))?;
            }
            continue;
        }
        if text.is_empty() {
            continue;
        }
        if rows.len() == request.most_rows {
            return Err(wrong(line, format!("has more than {} frames, the limit of a path", request.most_rows)));
        }
        let words: Vec<&str> = text.split([',', ' ', '\t']).filter(|word| !word.is_empty()).collect();
        if words.len() != COLUMNS.len() {
            let wanted = "a frame must have a time, then position, direction and up, three numbers each";
            return Err(wrong(line, format!("has {} values; {wanted}", words.len())));
        }
        let number = |word: &&str| {
            let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| wrong(line, format!("\"{word}\" is not a number")))
        };
        let numbers = words[1..].iter().map(number).collect::<Result<Vec<f64>>>()?;
        rows.push((line, numbers));
    }
    let frame = |(i, (line, numbers)): (usize, (usize, Vec<f64>))| {
        let scaled = numbers.into_iter().enumerate().map(|(c, v)| if c < 3 { UNIT_M * v } else { v });
        (line, std::iter::once(i as f64 / rate).chain(scaled).collect())
    };
    Ok(table(&COLUMNS, rows.into_iter().enumerate().map(frame)))
}
