//! Headers of FITS files, as they are read.

use barnard::data::{AXIS_ORDERS, ArrayFrame, Axis};
use barnard::error::{Error, Result};

use super::cards::{BLOCK, CARD};
use crate::formats::Request;

/// More header blocks than any real file has, of all its HDUs.
const MAX_HEADER_BLOCKS: usize = 16_384;
/// The beginning of every HDU but the first.
const EXTENSION: &[u8] = b"XTENSION";
/// HDUs that are looked at.
const MAX_HDUS: usize = 1000;

/// Axes that are not lengths, by the first part of their CTYPE. Source: FITS standard 4.0, tables 23, 25 and 28.
/// Further names are those of older files and other programs.
const OTHER_AXES: [(&str, &[&str]); 7] = [
    ("place on the sky", &["RA", "DEC", "GLON", "GLAT", "ELON", "ELAT", "SLON", "SLAT", "HLON", "HLAT"]),
    ("velocity", &["VRAD", "VOPT", "VELO", "FELO", "BETA", "ZOPT", "VELOCITY", "VLSR", "VHEL", "VEL"]),
    ("frequency", &["FREQ", "FREQUENCY", "NU"]),
    ("wavelength", &["WAVE", "AWAV", "WAVN", "WAVELENGTH", "LAMBDA", "WAVENUMBER"]),
    ("photon energy", &["ENER", "ENERGY"]),
    ("time", &["TIME", "MJD", "UTC"]),
    ("state of polarisation", &["STOKES"]),
];

/// Units of axes that are no lengths of a volume, whatever CTYPE says, in small letters.
const OTHER_UNITS: [(&str, &[&str]); 5] = [
    ("velocity", &["m/s", "km/s", "cm/s", "m s-1", "km s-1", "m.s-1", "km.s-1"]),
    ("frequency", &["hz", "khz", "mhz", "ghz", "thz"]),
    ("wavelength", &["angstrom", "angstroms", "nm", "um", "micron", "microns", "cm-1"]),
    ("photon energy", &["ev", "kev", "mev"]),
    ("time", &["s", "d", "yr", "a"]),
];

/// Off-diagonal elements of a matrix below this, relative to its largest, are rounding: cos 90° is 6e-17.
const ROUNDING: f64 = 1e-12;

/// Keywords, without the numbers of axes behind them, whose values are numbers.
const NUMBERS: [&str; 18] = [
    "BITPIX", "NAXIS", "CRPIX", "CRVAL", "CDELT", "CROTA", "BSCALE", "BZERO", "BLANK", "PCOUNT", "GCOUNT", "ZBITPIX", "ZNAXIS", "STEP",
    "SUN_POSX", "SUN_POSY", "SUN_POSZ", "THEAP",
];

/// True if the value of a keyword is a number by the standard.
fn is_numeric(keyword: &str) -> bool {
    let base = keyword.trim_end_matches(|c: char| c.is_ascii_digit());
    let of_matrix = |prefix: &str| {
        keyword.strip_prefix(prefix).is_some_and(|rest| !rest.is_empty() && rest.chars().all(|c| c.is_ascii_digit() || c == '_'))
    };
    NUMBERS.contains(&base) || NUMBERS.contains(&keyword) || of_matrix("CD") || of_matrix("PC")
}

/// A FITS number: Fortran's exponents D are read.
fn parsed(text: &str) -> Option<f64> {
    text.replace(['D', 'd'], "E").parse().ok().filter(|number: &f64| number.is_finite())
}

/// Header cards as text, keyword first.
pub struct Header {
    cards: Vec<(String, String)>,
    /// Cards that should be numbers and are not.
    broken: Vec<String>,
    /// The position at which the data begin.
    pub data: u64,
}

impl Header {
    /// Reads a header of at most a number of blocks, which is reduced by those read.
    fn read(request: &mut Request, start: u64, blocks: &mut usize) -> Result<Self> {
        let path = request.path;
        let broken = |reason: &str| Error::file(path, format!("is not a valid FITS file: {reason}"));
        let (mut cards, mut problems) = (Vec::new(), Vec::new());
        for block in 0..*blocks {
            let from = start + (block * BLOCK) as u64;
            let bytes = request.bytes(from, BLOCK)?.ok_or_else(|| broken("the header is truncated: no END card"))?;
            for card in bytes.chunks_exact(CARD) {
                let text = String::from_utf8_lossy(card).into_owned();
                let keyword: String = text.chars().take(8).collect::<String>().trim().to_owned();
                if keyword == "END" {
                    *blocks -= block + 1;
                    return Ok(Self { cards, broken: problems, data: from + BLOCK as u64 });
                }
                if keyword == "CONTINUE" {
                    // A text that ends with "&" is continued by the next card (FITS standard 4.0, §4.2.1.2).
                    if let Some((_, value)) = cards.last_mut().filter(|(_, value): &&mut (String, String)| value.ends_with('&')) {
                        value.pop();
                        *value += &value_of(&text.chars().skip(8).collect::<String>());
                    }
                } else if text.chars().nth(8) == Some('=') {
                    let value = value_of(&text.chars().skip(10).collect::<String>());
                    if is_numeric(&keyword) && !value.is_empty() && parsed(&value).is_none() {
                        problems.push(format!("{keyword} = {value} is not a number"));
                    }
                    if is_numeric(&keyword)
                        && cards
                            .iter()
                            .any(|(keyword_before, other): &(String, String)| *keyword_before == keyword && parsed(other) != parsed(&value))
                    {
                        problems.push(format!("{keyword} occurs twice with different values"));
                    }
                    if keyword == "BLANK" && !value.is_empty() && value.parse::<i64>().is_err() {
                        problems.push(format!("BLANK = {value} is not a whole number"));
                    }
                    cards.push((keyword, value));
                }
            }
        }
        Err(broken(&format!("its headers exceed {MAX_HEADER_BLOCKS} blocks")))
    }

    pub fn text(&self, keyword: &str) -> Option<&str> {
        self.cards.iter().find(|(k, _)| k == keyword).map(|(_, v)| v.as_str())
    }

    pub fn number(&self, keyword: &str) -> Option<f64> {
        parsed(self.text(keyword)?)
    }

    /// The first card that should be a number and is not, in words.
    pub fn broken(&self) -> Option<&str> {
        self.broken.first().map(String::as_str)
    }

    /// Refuses a header with a card that should be a number and is not.
    pub fn check(&self, path: &std::path::Path) -> Result<()> {
        match self.broken() {
            Some(broken) => Err(Error::file(path, format!("{broken}; correct the card: decimal point, nothing after the number"))),
            None => Ok(()),
        }
    }

    pub fn integer(&self, keyword: &str) -> Option<i64> {
        self.text(keyword)?.parse().ok()
    }

    /// True if it is a table that holds an image in tiles.
    pub fn is_packed(&self) -> bool {
        self.text("XTENSION") == Some("BINTABLE") && self.text("ZIMAGE") == Some("T")
    }

    /// True if the first row is the top one: ROWORDER is TOP-DOWN and there is no WCS. Otherwise the first row of FITS is the
    /// lowest.
    pub fn is_top_down(&self) -> bool {
        self.text("ROWORDER").is_some_and(|order| order.trim().eq_ignore_ascii_case("TOP-DOWN")) && self.text("CTYPE1").is_none()
    }

    /// Lengths of the axes of its image, the fastest first.
    pub fn axes(&self) -> Option<Vec<u64>> {
        self.lengths(if self.is_packed() { "ZNAXIS" } else { "NAXIS" })
    }

    /// Number type of its image: their bits, below zero for floating point.
    pub fn bitpix(&self) -> Option<i64> {
        self.integer(if self.is_packed() { "ZBITPIX" } else { "BITPIX" })
    }

    fn lengths(&self, keyword: &str) -> Option<Vec<u64>> {
        let count = self.integer(keyword).filter(|n| (0..=9).contains(n))?;
        (1..=count).map(|i| self.integer(&format!("{keyword}{i}")).and_then(|n| u64::try_from(n).ok())).collect()
    }

    /// Numbers, from one on, and lengths of the axes that are longer than one, the fastest first.
    pub fn squeezed(&self) -> Vec<(usize, u64)> {
        self.axes().unwrap_or_default().into_iter().enumerate().map(|(i, n)| (i + 1, n)).filter(|(_, n)| *n != 1).collect()
    }

    /// The sort of table that people take for an image, in words; none for an image.
    pub fn table(&self) -> Option<String> {
        if self.text("XTENSION") != Some("BINTABLE") || self.is_packed() {
            return None;
        }
        let name = self.text("EXTNAME").map_or(String::new(), |n| format!(" \"{n}\""));
        Some(match self.text("PIXTYPE") {
            Some("HEALPIX") => format!(
                "HDU{name} is a HEALPix map of the sky (NSIDE {}) without depth; convert it to a grid first",
                self.text("NSIDE").unwrap_or("unknown")
            ),
            _ => format!("HDU{name} is a table"),
        })
    }

    /// The matrix element that turns steps along pixel axis `j` into coordinates along axis `i`: of CD, of PC and CDELT,
    /// by their present or older names, or of CROTA2. None where the header gives none.
    fn matrix(&self, i: usize, j: usize) -> Option<f64> {
        let cdelt = |axis: usize| self.number(&format!("CDELT{axis}"));
        if let Some(cd) = self.number(&format!("CD{i}_{j}")).or_else(|| self.number(&format!("CD{i:03}{j:03}"))) {
            return Some(cd);
        }
        if let Some(pc) = self.number(&format!("PC{i}_{j}")).or_else(|| self.number(&format!("PC{i:03}{j:03}"))) {
            return Some(pc * cdelt(i).unwrap_or(1.0));
        }
        let angle = self.number("CROTA2").or_else(|| self.number("CROTA1")).unwrap_or(0.0).to_radians();
        match (i, j) {
            (1 | 2, 1 | 2) if i == j => Some(angle.cos() * cdelt(i)?),
            (1, 2) => Some(-angle.sin() * cdelt(2).unwrap_or(0.0)),
            (2, 1) => Some(angle.sin() * cdelt(1).unwrap_or(0.0)),
            _ if i == j => cdelt(i),
            _ => Some(0.0),
        }
    }

    /// For each axis of coordinates the pixel axis that it runs along, and the step; or why there is none such.
    fn followed(&self, axes: &[usize]) -> std::result::Result<Vec<Option<(usize, f64)>>, String> {
        if let Some((axis, angle)) = (3..=9).find_map(|i| Some((i, self.number(&format!("CROTA{i}")).filter(|angle| *angle != 0.0)?))) {
            return Err(format!("its axes are rotated by CROTA{axis} = {angle}"));
        }
        let count = self.axes().map_or(0, |axes| axes.len());
        // Axes in other units have other sizes: rounding is relative to the row.
        let row = |i: usize| (1..=count).filter_map(|j| self.matrix(i, j)).map(f64::abs).fold(0.0, f64::max);
        let is_step = |value: f64, i: usize| value.is_finite() && value.abs() > ROUNDING * row(i).max(f64::MIN_POSITIVE);
        let mut followed = Vec::new();
        for i in axes {
            let steps: Vec<(usize, f64)> = (1..=count).filter_map(|j| Some((j, self.matrix(*i, j).filter(|v| is_step(*v, *i))?))).collect();
            match steps[..] {
                [] => followed.push(None),
                [only] if axes.contains(&only.0) => followed.push(Some(only)),
                [first, ..] => {
                    let (j, value) = steps.iter().copied().find(|(j, _)| j != i).unwrap_or(first);
                    return Err(format!("its axes {i} and {j} are rotated or sheared (element {i}_{j} of the matrix is {value})"));
                }
            }
        }
        let along: Vec<usize> = followed.iter().flatten().map(|(j, _)| *j).collect();
        if (1..along.len()).any(|k| along[..k].contains(&along[k])) {
            return Err("two of its axes are parallel to the same array axis".into());
        }
        Ok(followed)
    }

    /// The values' unit and, where coordinates are linear and along the array's axes, those axes.
    pub fn frame(&self) -> ArrayFrame {
        let written = |keyword: &str| self.text(keyword).map(str::trim).filter(|t| !t.is_empty()).map(str::to_owned);
        // Maps of the Galaxy's dust say their unit elsewhere, and the Sun's place in steps from the lower corner.
        let unit = ["BUNIT", "UNIT", "CUNIT"].into_iter().find_map(written);
        let around_the_sun = |i: usize| {
            let step = self.number("STEP").filter(|step| step.is_finite() && *step > 0.0)?;
            let sun = self.number(["SUN_POSX", "SUN_POSY", "SUN_POSZ"].get(i - 1)?)?;
            Some(Axis { unit: "pc".into(), step, first: (0.5 - sun) * step })
        };
        let mut frame = ArrayFrame { order: "zyx", unit, ..ArrayFrame::default() };
        let axes: Vec<usize> = self.squeezed().into_iter().take(3).map(|(i, _)| i).collect();
        let followed = self.followed(&axes).unwrap_or_else(|reason| {
            frame.problem = Some(reason);
            vec![None; axes.len()]
        });
        let mut letters = [' '; 3];
        for (place, (i, step)) in axes.iter().zip(followed).enumerate() {
            // The array's axis along which the coordinate runs; indices run the other way.
            let j = step.map_or(*i, |(j, _)| j);
            let Some(along) = axes.iter().position(|axis| *axis == j) else { continue };
            let slot = 2 - along;
            let axis = step.map(|(j, step)| {
                let reference = self.number(&format!("CRPIX{j}")).unwrap_or(0.0);
                let first = self.number(&format!("CRVAL{i}")).unwrap_or(0.0) + (1.0 - reference) * step;
                Axis { unit: written(&format!("CUNIT{i}")).unwrap_or_default(), step, first }
            });
            frame.axes[slot] = axis.filter(|axis| axis.first.is_finite()).or_else(|| around_the_sun(*i));
            letters[slot] = ['x', 'y', 'z'][place];
            frame.others[slot] = self.other(*i);
        }
        let letters: String = letters.into_iter().collect();
        frame.order = AXIS_ORDERS.into_iter().find(|order| *order == letters).unwrap_or("zyx");
        frame
    }

    /// The quantity of an axis that is no length, by its name or its unit.
    fn other(&self, i: usize) -> Option<String> {
        let kind = self.text(&format!("CTYPE{i}")).unwrap_or("").trim();
        let unit = self.text(&format!("CUNIT{i}")).unwrap_or("").trim();
        let first = kind.split(['-', ' ', '_']).next().unwrap_or("").to_uppercase();
        let by_name = OTHER_AXES.iter().find(|(_, kinds)| kinds.contains(&first.as_str()));
        let by_unit = OTHER_UNITS.iter().find(|(_, units)| units.contains(&unit.to_lowercase().as_str()));
        match (by_name, by_unit) {
            (Some((what, _)), _) => Some(format!("{what} (CTYPE{i} {kind})")),
            (None, Some((what, _))) => Some(format!("{what} (CUNIT{i} {unit})")),
            (None, None) => None,
        }
    }

    /// The bytes of the data, padded to blocks.
    fn data_bytes(&self) -> Option<u64> {
        let axes = self.lengths("NAXIS")?;
        let size = self.integer("BITPIX")?.unsigned_abs() / 8;
        let (parameters, groups) = (self.integer("PCOUNT").unwrap_or(0).max(0) as u64, self.integer("GCOUNT").unwrap_or(1).max(0) as u64);
        let cells = if axes.is_empty() { Some(0) } else { axes.iter().try_fold(1u64, |n, a| n.checked_mul(*a)) }?;
        let bytes = cells.checked_add(parameters)?.checked_mul(groups)?.checked_mul(size)?;
        bytes.checked_next_multiple_of(BLOCK as u64)
    }
}

/// The value of a card: text without quotes, anything else up to the comment.
fn value_of(field: &str) -> String {
    let field = field.trim();
    if let Some(quoted) = field.strip_prefix('\'') {
        // Two quotation marks in a text are one.
        let marked = quoted.replace("''", "\u{0}");
        return marked.split('\'').next().unwrap_or("").trim_end().replace('\u{0}', "'");
    }
    field.split('/').next().unwrap_or("").trim().to_owned()
}

/// Reads the headers of all HDUs of the file.
pub fn headers(request: &mut Request) -> Result<Vec<Header>> {
    let magic = b"SIMPLE  =";
    if request.bytes(0, magic.len())?.is_none_or(|found| found != magic) {
        return Err(Error::file(request.path, "is not a FITS file: it does not begin with SIMPLE"));
    }
    let mut headers = Vec::new();
    let (mut start, mut blocks) = (0u64, MAX_HEADER_BLOCKS);
    while start.saturating_add(BLOCK as u64) <= request.length && headers.len() < MAX_HDUS {
        // Records behind the last HDU are no part of it (FITS standard 4.0, §3.5).
        if !headers.is_empty() && request.bytes(start, EXTENSION.len())?.is_none_or(|found| found != EXTENSION) {
            break;
        }
        let header = Header::read(request, start, &mut blocks)?;
        let next = header.data_bytes().and_then(|n| header.data.checked_add(n));
        let next = next.ok_or_else(|| Error::file(request.path, "BITPIX or NAXIS are missing or invalid"))?;
        headers.push(header);
        start = next;
    }
    if headers.is_empty() {
        return Err(Error::file(request.path, "is truncated: its first header does not end"));
    }
    Ok(headers)
}
