//! The `[background.catalogue]` table: stars of a CSV, where they are on the sky.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use spectra::error::nearest;
use spectra::passband::{self, Passband};
use spectra::sed;
use spectra::units::{Quantity, Temperature};

use super::proper_motion::{self, Motion, YEARS};
use super::star::{self, magnitude_system};
use crate::data::{InputNote, Inputs, TextTable};
use crate::error::{Error, Result};
use crate::observation::{Observation, SkyFrame, SkyPlace};
use crate::properties::{Choice, Choices, Key, KeyRow, Number, OrDefault, Origin, Path, Place, Required, Section, Text};
use crate::star_catalogue::{Builder, Colour, Photometry, PlacedCatalogue, SkyAxes, StarCatalogue};

const FILE: Key<Path, Required> = Key::path("file", "CSV file with a header and one star per row").required();
const AXES: Key<Choice<CatalogueAxes>, OrDefault> = Key::choice(
    "axes",
    "orientation of the sky. observation: as [observation] places each image, for any camera position; icrs or galactic: the scene's axes are those of the sky",
)
.default("observation");
const MAGNITUDE_BAND: Key<Text, OrDefault> =
    Key::text("magnitude_band", "embedded passband of a column `magnitude`").default("johnson-V").of("passbands");
const TEMPERATURE: Key<Temperature, OrDefault> =
    Key::quantity::<Temperature>("temperature", "temperature of stars without type, temperature or second magnitude")
        .positive()
        .default("5800 K");
const EPOCH: Key<Number> =
    Key::number("epoch", "year to which proper motions (columns pmra and pmdec, mas/yr) are applied, such as 2026.5")
        .range(YEARS)
        .example("2026.5")
        .otherwise("that of the catalogue");
const CATALOGUE_EPOCH: Key<Number> = Key::number("catalogue_epoch", "year of the positions")
    .range(YEARS)
    .example("2000.0")
    .needs("epoch")
    .otherwise("column ref_epoch; 2000 for HYG");
const FAINTEST: Key<Number> = Key::number("faintest", "limiting magnitude; fainter stars are skipped").range(-30.0..=40.0);

pub(super) const KEYS: &[KeyRow] =
    &[FILE.row, AXES.row, MAGNITUDE_BAND.row, star::MAGNITUDE_SYSTEM.row, TEMPERATURE.row, EPOCH.row, CATALOGUE_EPOCH.row, FAINTEST.row];

/// Orientation of the sky.
#[derive(Clone, Copy)]
enum CatalogueAxes {
    Observation,
    Icrs,
    Galactic,
}

impl Choices for CatalogueAxes {
    const ROWS: &'static [(&'static str, Self)] = &[("observation", Self::Observation), ("icrs", Self::Icrs), ("galactic", Self::Galactic)];
}

/// Most stars of a catalogue.
pub const MAX_ROWS: usize = 1_000_000;
/// Most types of stars: each is a spectrum of its own.
const MAX_TYPES: usize = 256;

/// Names that catalogues have for what is read, in small letters.
const RIGHT_ASCENSION: [&str; 5] = ["ra", "raj2000", "ra_icrs", "_raj2000", "right_ascension"];
const DECLINATION: [&str; 6] = ["dec", "dej2000", "de_icrs", "_dej2000", "decj2000", "declination"];
/// Longitudes that their catalogues state in degrees: those of VizieR.
const IN_DEGREES: [&str; 4] = ["raj2000", "ra_icrs", "_raj2000", "glon"];
const LONGITUDE: [&str; 3] = ["l", "glon", "galactic_longitude"];
const LATITUDE: [&str; 3] = ["b", "glat", "galactic_latitude"];
/// Magnitudes by the names of columns, and their passbands. `gmag` is Gaia's with this capital letter alone, as VizieR
/// writes it: SDSS and Pan-STARRS have a `gmag` too.
const MAGNITUDES: [(&str, &str); 8] = [
    ("phot_g_mean_mag", "gaiadr3-G"),
    ("phot_bp_mean_mag", "gaiadr3-BP"),
    ("phot_rp_mean_mag", "gaiadr3-RP"),
    (GAIA_G, "gaiadr3-G"),
    ("bpmag", "gaiadr3-BP"),
    ("rpmag", "gaiadr3-RP"),
    ("vmag", "johnson-V"),
    ("bmag", "johnson-B"),
];

const GAIA_G: &str = "Gmag";
/// Columns that SDSS, Pan-STARRS, SkyMapper and others all have.
const SURVEY_MAGNITUDES: [&str; 6] = ["umag", "gmag", "rmag", "imag", "zmag", "ymag"];

/// Missing-value markers of catalogues.
const BLANKS: [&str; 4] = ["null", "nan", "--", "none"];

/// Names of a column with the colour B − V.
const COLOURS: [&str; 4] = ["ci", "b-v", "b_v", "bv"];
/// Columns by which the HYG database is recognised. It gives right ascensions in hours, a V magnitude `mag`, the colour
/// B − V as `ci`, and the Sun as its first row (astronexus.com/projects/hyg).
const HYG: [&str; 4] = ["hip", "proper", "dist", "absmag"];
const SUN_OF_HYG: &str = "sol";
const EPOCH_OF_HYG: f64 = 2000.0;

/// The columns that are read, by their numbers.
struct StarColumns {
    frame: SkyFrame,
    place: [usize; 2],
    /// Degrees in the unit of each coordinate.
    degrees: [f64; 2],
    is_hyg: bool,
    name: Option<usize>,
    kind: Option<usize>,
    temperature: Option<usize>,
    /// The unit of temperatures, where their column states one.
    kelvin: Option<f64>,
    /// The magnitude, and one in another passband or a colour.
    magnitudes: [Option<usize>; 2],
    bands: [Option<Passband>; 2],
    /// True if the second is a colour, relative to the first.
    is_colour: bool,
}

/// Degrees in a unit of angle that a column states, in brackets or behind its name.
fn degrees_in(unit: &str) -> Option<f64> {
    match unit.trim().to_lowercase().as_str() {
        "deg" | "degree" | "degrees" | "d" | "°" => Some(1.0),
        "h" | "hr" | "hrs" | "hour" | "hours" | "hourangle" => Some(15.0),
        "rad" | "radian" | "radians" => Some(1f64.to_degrees()),
        "arcmin" => Some(1.0 / 60.0),
        "arcsec" => Some(1.0 / 3600.0),
        // Sexagesimal texts carry their unit themselves.
        "h:m:s" | "hms" | "\"h:m:s\"" | "d:m:s" | "dms" | "\"d:m:s\"" | "sexagesimal" => Some(1.0),
        _ => None,
    }
}

/// The name of a column of coordinates without a unit behind it, as in "ra_deg", and that unit.
fn unit_behind(name: &str) -> (&str, Option<&str>) {
    match name.rsplit_once(['_', ' ']) {
        Some((base, unit)) if degrees_in(unit).is_some() => (base, Some(unit)),
        _ => (name, None),
    }
}

/// Reads the stars; where they are in a scene, [`placed`] says.
pub(super) fn build(section: &Section, inputs: &Inputs) -> Result<StarCatalogue> {
    let file = section.read(&FILE)?;
    let table = section.wrap(&FILE, inputs.table(file, MAX_ROWS))?;
    let label: Arc<str> = inputs.label(file).into();
    let columns = columns(section, &table, &label)?;
    let [Some(first), second] = &columns.bands else { return Err(section.error(&FILE, "has no magnitudes")) };
    let known: Vec<&Passband> = [first].into_iter().chain(second).collect();
    let system = magnitude_system(section, &known)?;
    let photometry = section.wrap(&FILE, Photometry::new(first.clone(), second.as_ref(), system))?;
    let plain = section.read(&TEMPERATURE)?;
    let faintest = section.read(&FAINTEST)?.unwrap_or(f64::INFINITY);
    let motion = motion(section, &table, &columns, &label)?;
    refuse_small_longitudes(&table, &columns, &label)?;
    let mut builder = Builder::new(photometry);
    let mut rows = StarRows { table: &table, columns: &columns, motion: motion.as_ref(), faintest, plain, types: Vec::new() };
    for (number, (line, cells)) in table.rows.iter().enumerate() {
        if let Some(star) = rows.star(number, cells).map_err(|message| wrong(&label, *line, message))? {
            builder.add(star.name, star.direction, star.magnitude, star.colour);
        }
    }
    let catalogue = builder.build(label.to_string());
    let unit = |axis: usize| match columns.degrees[axis] {
        15.0 => "hours",
        1.0 => "degrees",
        _ => "other angles",
    };
    let hyg = if columns.is_hyg { ", recognised as HYG, whose right ascensions are in hours" } else { "" };
    let moved = match &motion {
        Some(motion) => format!(", moved to {} by proper motion", motion.to),
        None if proper_motion::columns(&table).is_some() => "; proper motions are ignored (apply them with epoch = 2026.5)".into(),
        None => String::new(),
    };
    let (count, rows) = (catalogue.stars.len(), table.rows.len());
    let text = format!("catalogue: {count} stars of {rows} rows, coordinates in {} and {}{hyg}{moved}", unit(0), unit(1));
    inputs.note(InputNote { file: file.to_owned(), text, is_inferred: columns.is_hyg });
    Ok(catalogue)
}

/// Proper motion to the requested epoch, if there is one.
fn motion(section: &Section, table: &TextTable, columns: &StarColumns, label: &Arc<str>) -> Result<Option<Motion>> {
    let stated = section.read(&CATALOGUE_EPOCH)?;
    let Some(epoch) = section.read(&EPOCH)? else { return Ok(None) };
    if columns.frame != SkyFrame::Icrs {
        return Err(section.error(&EPOCH, "requires right ascensions and declinations; remove it"));
    }
    let from = stated.or(columns.is_hyg.then_some(EPOCH_OF_HYG));
    Motion::new(table, epoch, from).map(Some).map_err(|message| wrong(label, table.line, message))
}

/// The star of a row.
struct RowStar {
    name: String,
    direction: DVec3,
    magnitude: f64,
    colour: Colour,
}

/// Reader of the rows of a catalogue.
struct StarRows<'a> {
    table: &'a TextTable,
    columns: &'a StarColumns,
    motion: Option<&'a Motion>,
    /// Magnitude beyond which stars are left out.
    faintest: f64,
    /// Temperature of stars without a colour.
    plain: Temperature,
    /// Spectral types so far.
    types: Vec<String>,
}

/// The text in a column of a row; empty where it is missing.
fn cell(cells: &[String], column: Option<usize>) -> &str {
    let text = column.and_then(|column| cells.get(column)).map_or("", String::as_str).trim();
    if BLANKS.iter().any(|blank| text.eq_ignore_ascii_case(blank)) { "" } else { text }
}

/// # Errors
/// In words, if the text is no magnitude.
fn magnitude(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|magnitude| (-30.0..=40.0).contains(magnitude));
    number.ok_or_else(|| format!("\"{text}\" is not a magnitude; write a number from -30 to 40"))
}

impl StarRows<'_> {
    /// The star of a row; `None` for rows without a magnitude, faint stars, the Sun, and lines below the names.
    ///
    /// # Errors
    /// In words, if a value is wrong.
    fn star(&mut self, number: usize, cells: &[String]) -> std::result::Result<Option<RowStar>, String> {
        let columns = self.columns;
        // VizieR has units and a line of dashes below its names.
        let is_no_star = |column: &usize| !cell(cells, Some(*column)).contains(|c: char| c.is_ascii_digit());
        let is_sun = columns.is_hyg && cell(cells, columns.name).eq_ignore_ascii_case(SUN_OF_HYG);
        let [first, second] = columns.magnitudes.map(|column| cell(cells, column));
        if number < 2 && columns.place.iter().all(is_no_star) || is_sun || first.is_empty() {
            return Ok(None);
        }
        let brightness = magnitude(first)?;
        if brightness > self.faintest {
            return Ok(None);
        }
        let place = self.place(cells)?;
        let colour = self.colour(cells, brightness, second)?;
        let table = self.table;
        let number = |column: usize| match cell(cells, Some(column)) {
            "" => Ok(None),
            text => text.parse().map(Some).map_err(|_| format!("\"{text}\" in column \"{}\" is not a number", table.columns[column])),
        };
        let direction = self.motion.map_or(Ok(place.direction()), |motion| motion.direction(&place, number))?;
        Ok(Some(RowStar { name: cell(cells, columns.name).to_owned(), direction, magnitude: brightness, colour }))
    }

    fn place(&self, cells: &[String]) -> std::result::Result<SkyPlace, String> {
        // VizieR parts hours, minutes and seconds by blanks.
        let coordinate = |axis: usize| {
            let text = cell(cells, Some(self.columns.place[axis])).split_whitespace().collect::<Vec<_>>().join(":");
            match text.parse::<f64>() {
                Ok(number) => format!("{}", number * self.columns.degrees[axis]),
                Err(_) => text,
            }
        };
        SkyPlace::parse(self.columns.frame, &format!("{} {}", coordinate(0), coordinate(1))).map_err(|error| error.to_string())
    }

    /// Source of the spectrum: a type, a temperature, a magnitude in the `second` passband, or the default temperature.
    fn colour(&mut self, cells: &[String], brightness: f64, second: &str) -> std::result::Result<Colour, String> {
        let (kind, kelvin) = (cell(cells, self.columns.kind), cell(cells, self.columns.temperature));
        if !kind.is_empty() {
            let shape = sed::star(kind).map_err(|error| error.to_string())?;
            if !self.types.iter().any(|known| known == kind) {
                self.types.push(kind.to_owned());
            }
            if self.types.len() > MAX_TYPES {
                return Err(format!("the catalogue has more than {MAX_TYPES} spectral types; use temperatures or a second magnitude"));
            }
            return Ok(Colour::Type(shape, kind.to_owned()));
        }
        if !kelvin.is_empty() {
            let number = kelvin.parse::<f64>().ok().map(|number| Temperature(number * self.columns.kelvin.unwrap_or(1.0)));
            let temperature = number.map_or_else(|| Temperature::parse(kelvin), Ok).map_err(|error| error.to_string())?;
            if temperature.0.is_nan() || temperature.0 <= 0.0 {
                return Err(format!("{temperature} is out of range for a star"));
            }
            return Ok(Colour::Temperature(temperature.0));
        }
        if second.is_empty() {
            return Ok(Colour::Temperature(self.plain.0));
        }
        let second = magnitude(second)?;
        Ok(Colour::Magnitude(if self.columns.is_colour { brightness + second } else { second }))
    }
}

fn wrong(label: &Arc<str>, line: usize, message: String) -> Error {
    let origin = Some(Origin { source: label.clone(), line });
    Error::Scene { message, place: Place { origin, path: String::new(), key: "row".into() } }
}

/// Columns of magnitudes with their passbands, and true if the second is the colour B − V.
fn magnitudes(section: &Section, table: &TextTable, names: &[&str]) -> Result<(Vec<(usize, Passband)>, bool)> {
    let mut bands: Vec<(usize, Passband)> = Vec::new();
    if let Some(column) = find(names, &["magnitude", "mag"]) {
        let name = section.read(&MAGNITUDE_BAND)?;
        bands.push((column, section.wrap(&MAGNITUDE_BAND, Passband::by_name(name))?));
    } else {
        section.refuse(&[&MAGNITUDE_BAND.row], "a column \"magnitude\"")?;
    }
    for (column, name) in names.iter().enumerate() {
        let is_named = |known: &str| if known == GAIA_G { table.columns[column].trim().starts_with(known) } else { known == *name };
        let meant = MAGNITUDES.iter().find(|(known, _)| is_named(known)).map(|(_, band)| *band);
        let band_name = meant.or_else(|| passband::names().into_iter().find(|band| band.eq_ignore_ascii_case(name)));
        if let Some(band) = band_name.filter(|band| bands.iter().all(|(_, known)| known.name() != *band)) {
            bands.push((column, section.wrap(&FILE, Passband::by_name(band))?));
        }
    }
    let colour = find(names, &COLOURS).filter(|_| bands.len() == 1 && bands[0].1.name() == "johnson-V");
    if let Some(column) = colour {
        bands.push((column, section.wrap(&FILE, Passband::by_name("johnson-B"))?));
    }
    Ok((bands, colour.is_some()))
}

/// The first column with one of the known names.
fn find(names: &[&str], known: &[&str]) -> Option<usize> {
    names.iter().position(|name| known.contains(name))
}

/// Columns of sky positions, and their frame.
///
/// # Errors
/// If there are none; a hint where a name is misspelt.
fn sky_columns(names: &[&str]) -> std::result::Result<(SkyFrame, [usize; 2]), String> {
    let pair = |first: &[&str], second: &[&str]| find(names, first).zip(find(names, second)).map(|(a, b)| [a, b]);
    let icrs = pair(&RIGHT_ASCENSION, &DECLINATION).map(|place| (SkyFrame::Icrs, place));
    let found = icrs.or_else(|| pair(&LONGITUDE, &LATITUDE).map(|place| (SkyFrame::Galactic, place)));
    found.ok_or_else(|| {
        let known = ["ra", "dec", "glon", "glat"];
        let misspelt = names.iter().filter(|name| name.len() < 6 && !known.contains(name));
        let near = misspelt.filter_map(|name| nearest(name, known).map(|near| (name, near))).next();
        near.map(|(name, near)| format!("; did you mean \"{near}\" by \"{name}\"?")).unwrap_or_default()
    })
}

/// Finds what columns mean.
fn columns(section: &Section, table: &TextTable, label: &Arc<str>) -> Result<StarColumns> {
    let parted: Vec<(String, Option<&str>)> = table.columns.iter().map(|column| TextTable::parted(column)).collect();
    let names: Vec<&str> = parted.iter().map(|(name, _)| unit_behind(name).0).collect();
    let (frame, place) = sky_columns(&names).map_err(|hint| {
        let named = table.columns.join(", ");
        wrong(label, table.line, format!("has no columns \"ra\" and \"dec\", or \"glon\" and \"glat\" ({named}){hint}"))
    })?;
    let (bands, is_colour) = magnitudes(section, table, &names)?;
    if bands.is_empty() {
        let survey = names.iter().find(|name| SURVEY_MAGNITUDES.contains(*name));
        let survey = survey
            .map(|name| format!("; \"{name}\" is ambiguous between surveys: rename the column to its passband, such as \"sdss2010-g\""));
        let message = "has no magnitude column; name one \"magnitude\", or after a passband such as \"johnson-V\" or \"phot_g_mean_mag\"";
        return Err(wrong(label, table.line, message.to_owned() + &survey.unwrap_or_default()));
    }
    let is_hyg = HYG.iter().all(|name| names.contains(name));
    let mut degrees = [if is_hyg { 15.0 } else { 1.0 }, 1.0];
    for (axis, column) in place.into_iter().enumerate() {
        let stated = parted[column].1.or(unit_behind(&parted[column].0).1);
        let Some(unit) = stated else { continue };
        degrees[axis] = degrees_in(unit).ok_or_else(|| {
            let message =
                format!("column \"{}\" has the unknown angle unit \"{unit}\"; known: deg, h, rad, arcmin, arcsec", table.columns[column]);
            wrong(label, table.line, message)
        })?;
    }
    let temperature = find(&names, &["temperature", "teff", "teff_gspphot"]);
    let kelvin = temperature.and_then(|column| Some((column, parted[column].1?)));
    let kelvin = kelvin.map(|(column, unit)| {
        Temperature::unit_size(unit).ok_or_else(|| {
            wrong(
                label,
                table.line,
                format!("column \"{}\" has the unknown temperature unit \"{unit}\"; known: K, kK", table.columns[column]),
            )
        })
    });
    if let Some(column) =
        bands.iter().map(|(column, _)| *column).find(|column| parted[*column].1.is_some_and(|unit| !unit.eq_ignore_ascii_case("mag")))
    {
        let message = format!("column \"{}\" has an unknown magnitude unit; write \"[mag]\" or no unit", table.columns[column]);
        return Err(wrong(label, table.line, message));
    }
    let mut bands = bands.into_iter();
    let (first, second) = (bands.next(), bands.next());
    Ok(StarColumns {
        frame,
        place,
        degrees,
        is_hyg,
        name: find(&names, &["name", "proper", "proper_name"]),
        kind: find(&names, &["type", "spectral_type"]),
        temperature,
        kelvin: kelvin.transpose()?,
        is_colour,
        magnitudes: [first.as_ref().map(|(column, _)| *column), second.as_ref().map(|(column, _)| *column)],
        bands: [first.map(|(_, band)| band), second.map(|(_, band)| band)],
    })
}

/// Refuses longitudes without a unit that may be hours or radians: numbers of which none is above 24, or above 2π.
fn refuse_small_longitudes(table: &TextTable, columns: &StarColumns, label: &Arc<str>) -> Result<()> {
    let column = columns.place[0];
    let (name, unit) = TextTable::parted(&table.columns[column]);
    let is_stated = unit.is_some() || unit_behind(&name).1.is_some() || columns.is_hyg || IN_DEGREES.contains(&name.as_str());
    let (most, units) = match columns.frame {
        SkyFrame::Icrs => (24.0, ["deg", "h", "rad"].as_slice()),
        SkyFrame::Galactic => (std::f64::consts::TAU, ["deg", "rad"].as_slice()),
    };
    let numbers = || table.rows.iter().filter_map(|(_, cells)| cells.get(column)?.parse::<f64>().ok());
    if is_stated || numbers().next().is_none() || numbers().any(|number| number > most) {
        return Ok(());
    }
    let ways: Vec<String> = units.iter().map(|unit| format!("\"{name} [{unit}]\"")).collect();
    let message =
        format!("has column \"{name}\" without a unit and without values above {most:.4}, which is ambiguous; write {}", ways.join(" or "));
    Err(wrong(label, table.line, message))
}

/// The catalogue around a scene.
pub(super) fn placed(section: &Section, catalogue: Arc<StarCatalogue>, observation: Option<&Observation>) -> Result<PlacedCatalogue> {
    let axes = match section.read(&AXES)? {
        CatalogueAxes::Icrs => SkyAxes::OfScene(DMat3::IDENTITY),
        CatalogueAxes::Galactic => SkyAxes::OfScene(SkyFrame::Galactic.from_icrs()),
        CatalogueAxes::Observation => {
            let missing = "a catalogue requires [observation] to place the sky; add it, or write axes = \"icrs\"";
            SkyAxes::OfPicture(observation.ok_or_else(|| section.error(&AXES, missing))?.axes())
        }
    };
    Ok(PlacedCatalogue { catalogue, axes })
}
