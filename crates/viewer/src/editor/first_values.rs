//! Initial text of an added table or key.

use barnard::properties::Key;
use barnard::scene::schema::TableRow;
use barnard_files::catalogue::CATALOGUES;
use spectra::units::{QUANTITIES, QuantityRow, parts};
use toml_edit::{Array, InlineTable, Item, TableLike, Value};

use crate::edit::{Edit, numbers};

/// Makes the table one of another kind.
pub fn of_kind(row: &'static TableRow, place: &str, here: &dyn TableLike, kind: &str) -> Edit {
    let known: Vec<&Key> = row.keys_of(Some(kind)).collect();
    let mut edit = Edit::set(place, "kind", kind);
    for (name, _) in here.iter().filter(|(name, _)| *name != "kind" && !known.iter().any(|k| k.name == *name)) {
        edit = edit.and(Edit::remove(place, name));
    }
    for key in known.iter().filter(|k| k.default.is_none() && !here.contains_key(k.name)) {
        edit = edit.and(Edit::set(place, key.name, first_value(key)));
    }
    edit
}

/// Default of keys of which a table has exactly one.
const ONE_OF: &str = "exactly one scale is required";

/// The beginning of the default of a key that another key needs.
const NEEDED_WITH: &str = "needed with ";

/// Adds a key, and those that it needs; where a table has exactly one of several, the other gives way.
pub fn added(row: &'static TableRow, place: &str, here: &dyn TableLike, key: &Key) -> Edit {
    let kind = here.get("kind").and_then(Item::as_str);
    let rival = |k: &&Key| key.default == Some(ONE_OF) && k.default == Some(ONE_OF) && here.contains_key(k.name);
    let partner = |k: &&Key| k.default.and_then(|d| d.strip_prefix(NEEDED_WITH)) == Some(key.name) && !here.contains_key(k.name);
    let edit = Edit::set(place, key.name, first_value(key));
    let edit = row.keys_of(kind).filter(rival).fold(edit, |edit, k| edit.and(Edit::remove(place, k.name)));
    row.keys_of(kind).filter(partner).fold(edit, |edit, k| edit.and(Edit::set(place, k.name, first_value(k))))
}

/// The quantity that a key is written in; extinction is of two.
pub fn quantity(key: &Key) -> Option<&'static QuantityRow> {
    let name = if key.kind == "extinction" { "extinction per length" } else { key.kind };
    QUANTITIES.iter().find(|q| q.name == name)
}

/// First values of keys that an example of their unit would not fit: key, what it is, value. Ends of a range are not
/// equal, widths are narrow.
const FIRST: [(&str, &str, &str); 15] = [
    ("low", "position", "-1 -1 -1 pc"),
    ("high", "position", "1 1 1 pc"),
    ("low", "wavelength", "400 nm"),
    ("high", "wavelength", "700 nm"),
    ("width", "wavelength", "50 nm"),
    ("fwhm", "wavelength", "50 nm"),
    ("half_width", "wavelength", "50 nm"),
    ("slope", "number", "3.667"),
    ("resolving_power", "number", "3000"),
    ("mass_per_h", "number", "1.4"),
    ("epoch", "number", "2026.5"),
    ("catalogue_epoch", "number", "2000"),
    ("sky", "list of texts", "[\"21 mag\"]"),
    ("mosaic", "list of texts", "[]"),
    ("velocity", "list of texts", "[\"0\", \"0\", \"20*z\"]"),
];

/// The value that a key is set to when it is added.
fn first_value(key: &Key) -> Value {
    if let Some((_, _, value)) = FIRST.iter().find(|(name, kind, _)| *name == key.name && *kind == key.kind) {
        return value.parse().unwrap_or_else(|_| (*value).into());
    }
    if let Some(catalogue) = key.catalogue.and_then(|name| CATALOGUES.iter().find(|c| c.name == name)) {
        let rows = (catalogue.rows)();
        let default = key.default.filter(|d| rows.iter().any(|(name, _)| name == d));
        return default.map(str::to_owned).or_else(|| rows.first().map(|r| r.0.clone())).unwrap_or_default().into();
    }
    if let Some(quantity) = quantity(key) {
        let default = key.default.filter(|d| parts(d).is_some_and(|(_, unit)| !unit.is_empty()));
        return default.unwrap_or(quantity.example).into();
    }
    let default = key.default.unwrap_or("");
    match key.kind {
        "position" => (if parts(default).is_some() { default } else { "0 0 0 pc" }).into(),
        "direction" | "[width, height]" if default.parse::<Value>().is_ok_and(|v| v.is_array()) => {
            default.parse().unwrap_or_else(|_| default.into())
        }
        "direction" if key.name == "up" => numbers([0.0, 1.0, 0.0]),
        "direction" => numbers([0.0, 0.0, 1.0]),
        "list of tables" => {
            let line = [("wavelength", Value::from("656.28 nm")), ("strength", Value::from(1.0))].into_iter().collect::<InlineTable>();
            Value::Array([line].into_iter().collect::<Array>())
        }
        "boolean" => (default != "true").into(),
        "integer" if key.name == "star_depth_voxels" => 2.into(),
        "integer" => default.parse::<i64>().unwrap_or(64).into(),
        "number" | "number or table" => default.parse::<f64>().unwrap_or(0.5).into(),
        "list of numbers" if key.name == "crop" => numbers([0.0, 0.0, 256.0, 256.0]),
        "list of numbers" if key.name == "orientation" => numbers([0.0, 0.0, 0.0, 1.0]),
        "list of numbers" if key.name == "nm" => numbers([500.0, 600.0]),
        "list of numbers" => numbers([0.0, 1.0]),
        "list of texts" if key.name == "layers" => Value::Array(["all"].into_iter().collect::<Array>()),
        "list of texts" if key.name == "pole_merge" => Value::Array(["60 deg", "75 deg"].into_iter().collect::<Array>()),
        "list of texts" => Value::Array(["300 nm", "1 um"].into_iter().collect::<Array>()),
        "list of times" => Value::Array(["0 s", "1 s"].into_iter().collect::<Array>()),
        "list of values" => numbers([0.0, 1.0]),
        "[width, height]" => Value::Array([512i64, 512].into_iter().collect::<Array>()),
        "text or list" => default.into(),
        _ => default.into(),
    }
}
