//! The `[background.catalogue]` table: stars of a CSV, where they are on the sky.

use std::sync::Arc;

use glam::DMat3;
use spectra::error::nearest;
use spectra::passband::{self, Passband};
use spectra::sed;
use spectra::units::{Quantity, Temperature};

use super::star::magnitude_system;
use crate::data::{Inputs, TextTable};
use crate::error::{Error, Result};
use crate::observation::{Observation, SkyFrame, SkyPlace};
use crate::properties::{Key, Origin, Place, Section};
use crate::star_catalogue::{Builder, Colour, Photometry, PlacedCatalogue, SkyAxes, StarCatalogue};

pub(super) const KEYS: &[Key] = &[
    Key::required("file", "path", "the CSV: a line of column names, then a star in each row"),
    Key::optional(
        "axes",
        "text",
        "observation",
        "observation: the sky lies as [observation] says of every picture, from wherever it is taken; icrs or galactic: x, y and z of the scene are those of the sky",
    ),
    Key::optional("magnitude_band", "text", "johnson-V", "an embedded passband, for a column `magnitude`").of("passbands"),
    Key::optional("magnitude_system", "text", "vega", "vega or ab"),
    Key::optional("temperature", "temperature", "5800 K", "of stars of which neither type nor temperature nor a second magnitude is known"),
    Key::optional("faintest", "number", "none", "stars of larger magnitudes are left out"),
];

/// Most stars of a catalogue.
pub const MAX_ROWS: usize = 1_000_000;
/// Most types of stars: each is a spectrum of its own.
const MAX_TYPES: usize = 256;

/// Names that catalogues have for what is read, in small letters.
const RIGHT_ASCENSION: [&str; 5] = ["ra", "raj2000", "ra_icrs", "_raj2000", "right_ascension"];
const DECLINATION: [&str; 6] = ["dec", "dej2000", "de_icrs", "_dej2000", "decj2000", "declination"];
const LONGITUDE: [&str; 3] = ["l", "glon", "galactic_longitude"];
const LATITUDE: [&str; 3] = ["b", "glat", "galactic_latitude"];
/// Magnitudes by the names of columns, and the passbands that they mean.
const MAGNITUDES: [(&str, &str); 8] = [
    ("phot_g_mean_mag", "gaiadr3-G"),
    ("phot_bp_mean_mag", "gaiadr3-BP"),
    ("phot_rp_mean_mag", "gaiadr3-RP"),
    ("gmag", "gaiadr3-G"),
    ("bpmag", "gaiadr3-BP"),
    ("rpmag", "gaiadr3-RP"),
    ("vmag", "johnson-V"),
    ("bmag", "johnson-B"),
];

/// What catalogues write where they know nothing.
const BLANKS: [&str; 4] = ["null", "nan", "--", "none"];

/// The columns that are read, by their numbers.
struct Columns {
    frame: SkyFrame,
    place: [usize; 2],
    name: Option<usize>,
    kind: Option<usize>,
    temperature: Option<usize>,
    /// The magnitude, and one in another passband.
    magnitudes: [Option<usize>; 2],
    bands: [Option<Passband>; 2],
}

/// Reads the stars; where they are in a scene, [`placed`] says.
pub(super) fn build(section: &Section, inputs: &Inputs) -> Result<StarCatalogue> {
    let file = section.need_text("file")?;
    let table = section.wrap("file", inputs.table(file, MAX_ROWS))?;
    let label: Arc<str> = inputs.label(file).into();
    let columns = columns(section, &table, &label)?;
    let [Some(first), second] = &columns.bands else { return Err(section.error("file", "has no magnitudes")) };
    let photometry = section.wrap("file", Photometry::new(first.clone(), second.as_ref(), magnitude_system(section)?))?;
    let plain = section.positive::<Temperature>("temperature")?.unwrap_or(Temperature(5800.0));
    let faintest = section.number("faintest", -30.0..=40.0)?.unwrap_or(f64::INFINITY);
    let mut builder = Builder::new(photometry);
    let mut types = Vec::new();
    for (number, (line, cells)) in table.rows.iter().enumerate() {
        let cell = |column: Option<usize>| {
            let text = column.and_then(|column| cells.get(column)).map_or("", String::as_str).trim();
            if BLANKS.iter().any(|blank| text.eq_ignore_ascii_case(blank)) { "" } else { text }
        };
        // VizieR has units and a line of dashes below its names.
        let is_no_star = |text: &str| !text.contains(|c: char| c.is_ascii_digit());
        if number < 2 && [columns.place[0], columns.place[1]].iter().all(|column| is_no_star(cell(Some(*column)))) {
            continue;
        }
        let wrong = |message: String| wrong(&label, *line, message);
        let [first, second] = columns.magnitudes.map(cell);
        let magnitude = |text: &str| {
            let number = text.parse::<f64>().ok().filter(|m| (-30.0..=40.0).contains(m));
            number.ok_or_else(|| wrong(format!("\"{text}\" is no magnitude; a number from -30 to 40 is one")))
        };
        // Catalogues have rows without a magnitude.
        if first.is_empty() {
            continue;
        }
        let brightness = magnitude(first)?;
        if brightness > faintest {
            continue;
        }
        // VizieR parts hours, minutes and seconds by blanks.
        let [longitude, latitude] = columns.place.map(|column| cell(Some(column)).split_whitespace().collect::<Vec<_>>().join(":"));
        let text = format!("{longitude} {latitude}");
        let place = SkyPlace::parse(columns.frame, &text).map_err(|error| wrong(error.to_string()))?;
        let (kind, kelvin) = (cell(columns.kind), cell(columns.temperature));
        let colour = if !kind.is_empty() {
            let shape = sed::star(kind).map_err(|error| wrong(error.to_string()))?;
            if !types.iter().any(|known| known == kind) {
                types.push(kind.to_owned());
            }
            if types.len() > MAX_TYPES {
                return Err(wrong(format!("more than {MAX_TYPES} types of stars; give temperatures or a second magnitude")));
            }
            Colour::Type(shape, kind.to_owned())
        } else if !kelvin.is_empty() {
            let with_unit = if kelvin.ends_with('K') { kelvin.to_owned() } else { format!("{kelvin} K") };
            let temperature = Temperature::parse(&with_unit).map_err(|error| wrong(error.to_string()))?;
            if temperature.0.is_nan() || temperature.0 <= 0.0 {
                return Err(wrong(format!("{temperature} is no temperature of a star")));
            }
            Colour::Temperature(temperature.0)
        } else if !second.is_empty() {
            Colour::Magnitude(magnitude(second)?)
        } else {
            Colour::Temperature(plain.0)
        };
        builder.add(cell(columns.name).to_owned(), place.direction(), brightness, colour);
    }
    Ok(builder.build(label.to_string()))
}

fn wrong(label: &Arc<str>, line: usize, message: String) -> Error {
    let origin = Some(Origin { source: label.clone(), line });
    Error::Scene { message, place: Place { origin, path: String::new(), key: "row".into() } }
}

/// Finds what columns mean.
fn columns(section: &Section, table: &TextTable, label: &Arc<str>) -> Result<Columns> {
    let names: Vec<String> = table.columns.iter().map(|column| TextTable::parted(column).0).collect();
    let find = |known: &[&str]| names.iter().position(|name| known.contains(&name.as_str()));
    let pair = |first: &[&str], second: &[&str]| find(first).zip(find(second)).map(|(a, b)| [a, b]);
    let icrs = pair(&RIGHT_ASCENSION, &DECLINATION).map(|place| (SkyFrame::Icrs, place));
    let found = icrs.or_else(|| pair(&LONGITUDE, &LATITUDE).map(|place| (SkyFrame::Galactic, place)));
    let (frame, place) = found.ok_or_else(|| {
        let named = table.columns.join(", ");
        let misspelt = |name: &&String| name.len() < 6 && !["ra", "dec", "glon", "glat"].contains(&name.as_str());
        let near = names.iter().filter(misspelt).find_map(|name| nearest(name, ["ra", "dec", "glon", "glat"]).map(|near| (name, near)));
        let hint = near.map(|(name, near)| format!("; is \"{name}\" meant to be \"{near}\"?")).unwrap_or_default();
        wrong(label, table.line, format!("has no columns \"ra\" and \"dec\", or \"glon\" and \"glat\" ({named}){hint}"))
    })?;
    let mut bands: Vec<(usize, Passband)> = Vec::new();
    if let Some(column) = find(&["magnitude", "mag"]) {
        let name = section.text("magnitude_band")?.unwrap_or("johnson-V");
        bands.push((column, section.wrap("magnitude_band", Passband::named(name))?));
    } else {
        section.refuse(&["magnitude_band"], "a column \"magnitude\"")?;
    }
    for (column, name) in names.iter().enumerate() {
        let meant = MAGNITUDES.iter().find(|(own, _)| own == name).map(|(_, band)| *band);
        let own = meant.or_else(|| passband::names().into_iter().find(|band| band.eq_ignore_ascii_case(name)));
        if let Some(band) = own.filter(|band| bands.iter().all(|(_, known)| known.name() != *band)) {
            bands.push((column, section.wrap("file", Passband::named(band))?));
        }
    }
    if bands.is_empty() {
        let message = "has no column of magnitudes: \"magnitude\", or the name of a passband such as \"johnson-V\" or \"phot_g_mean_mag\"";
        return Err(wrong(label, table.line, message.to_owned()));
    }
    let mut bands = bands.into_iter();
    let (first, second) = (bands.next(), bands.next());
    Ok(Columns {
        frame,
        place,
        name: find(&["name", "proper", "proper_name"]),
        kind: find(&["type", "spectral_type"]),
        temperature: find(&["temperature", "teff", "teff_gspphot"]),
        magnitudes: [first.as_ref().map(|(column, _)| *column), second.as_ref().map(|(column, _)| *column)],
        bands: [first.map(|(_, band)| band), second.map(|(_, band)| band)],
    })
}

/// The catalogue around a scene.
pub(super) fn placed(section: &Section, catalogue: Arc<StarCatalogue>, observation: Option<&Observation>) -> Result<PlacedCatalogue> {
    let axes = match section.choice("axes", &["observation", "icrs", "galactic"])? {
        Some("icrs") => SkyAxes::OfScene(DMat3::IDENTITY),
        Some("galactic") => SkyAxes::OfScene(SkyFrame::Galactic.from_icrs()),
        _ => {
            let missing = "the sky of a catalogue lies as [observation] says, which is missing; add it, or write axes = \"icrs\"";
            SkyAxes::OfPicture(observation.ok_or_else(|| section.error("axes", missing))?.axes())
        }
    };
    Ok(PlacedCatalogue { catalogue, axes })
}
