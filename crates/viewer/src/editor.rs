//! Tables of a scene as widgets: the rows of `scene::schema` say which keys there are, what they mean and what they are
//! written as.

use barnard::properties::Key;
use barnard::scene::schema::TableRow;
use barnard_files::catalogue::CATALOGUES;
use eframe::egui::{self, DragValue, Id, Response, Ui};
use spectra::units::{QUANTITIES, QuantityRow, parts};
use toml_edit::{Array, InlineTable, Item, TableLike, Value};

use crate::document::Document;
use crate::edit::{Edit, numbers, rounded, significant, table};

/// Keys that are not shown as widgets: tables have headings of their own.
const NESTED: [&str; 3] = ["table", "tables by name", "list of tables"];
/// The relative change of a number in one point of a drag.
const DRAG: f64 = 0.006;
/// Size of a coordinate, whatever its digits: panels keep their width while a star is dragged.
const COORDINATE: [f32; 2] = [58.0, 18.0];
/// Most characters of a coordinate that three of stand in a line.
const SHORT: usize = 7;
/// Digits of numbers that are written.
const DIGITS: usize = 6;

/// What the widgets of one frame ask for.
pub type Edits = Vec<Edit>;

/// The keys of the table at `place`, those that are there, and a menu of those that could be.
pub fn keys(ui: &mut Ui, document: &Document, place: &str, edits: &mut Edits) {
    keys_but(ui, document, place, &[], edits);
}

/// The same without some keys, which stand elsewhere.
pub fn keys_but(ui: &mut Ui, document: &Document, place: &str, but: &[&str], edits: &mut Edits) {
    let Some(row) = row(place) else { return };
    let empty = toml_edit::Table::new();
    let here = table(document.toml().as_table(), place).unwrap_or(&empty);
    let kind = here.get("kind").and_then(Item::as_str);
    egui::Grid::new(("keys", place)).num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        if !(row.kinds)().is_empty() {
            kinds(ui, row, place, here, edits);
            ui.end_row();
        }
        for key in row.keys_of(kind).filter(|k| here.contains_key(k.name) && !NESTED.contains(&k.kind) && !but.contains(&k.name)) {
            if let Some(item) = here.get(key.name) {
                one(ui, place, key, item, edits);
                ui.end_row();
            }
        }
    });
    missing(ui, row, place, here, but, edits);
}

/// The row of a place: "star.0" is a "star".
fn row(place: &str) -> Option<&'static TableRow> {
    let path: Vec<&str> = place.split('.').filter(|s| s.parse::<usize>().is_err()).collect();
    TableRow::named(&path.join("."))
}

/// One key, wherever it stands: its name and its widget.
pub fn key(ui: &mut Ui, document: &Document, place: &str, name: &str, edits: &mut Edits) {
    let Some(row) = row(place) else { return };
    let here = table(document.toml().as_table(), place);
    let kind = here.and_then(|t| t.get("kind")).and_then(Item::as_str);
    let found = row.keys_of(kind).find(|k| k.name == name);
    if let (Some(key), Some(item)) = (found, here.and_then(|t| t.get(name))) {
        ui.horizontal(|ui| one(ui, place, key, item, edits));
    }
}

/// Which kind a table is of. Another kind takes the keys it needs, and lets go of those it does not know.
fn kinds(ui: &mut Ui, row: &'static TableRow, place: &str, here: &dyn TableLike, edits: &mut Edits) {
    let now = here.get("kind").and_then(Item::as_str).unwrap_or("");
    let label = ui.label("kind");
    let kinds = (row.kinds)();
    let summary = kinds.iter().find(|k| k.name == now).map_or("", |k| k.summary);
    let response = egui::ComboBox::from_id_salt(("kind", place)).selected_text(now).show_ui(ui, |ui| {
        for kind in &kinds {
            if ui.selectable_label(kind.name == now, kind.name).on_hover_text(kind.summary).clicked() && kind.name != now {
                edits.push(of_kind(row, place, here, kind.name));
            }
        }
    });
    response.response.labelled_by(label.id).on_hover_text(summary);
}

/// Makes the table one of another kind.
fn of_kind(row: &'static TableRow, place: &str, here: &dyn TableLike, kind: &str) -> Edit {
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
const ONE_OF: &str = "one scale is needed";

/// What the default of a key begins with that another one needs.
const NEEDED_WITH: &str = "needed with ";

/// Adds a key, and those that it needs; where a table has exactly one of several, the other gives way.
fn added(row: &'static TableRow, place: &str, here: &dyn TableLike, key: &Key) -> Edit {
    let kind = here.get("kind").and_then(Item::as_str);
    let rival = |k: &&Key| key.default == Some(ONE_OF) && k.default == Some(ONE_OF) && here.contains_key(k.name);
    let partner = |k: &&Key| k.default.and_then(|d| d.strip_prefix(NEEDED_WITH)) == Some(key.name) && !here.contains_key(k.name);
    let edit = Edit::set(place, key.name, first_value(key));
    let edit = row.keys_of(kind).filter(rival).fold(edit, |edit, k| edit.and(Edit::remove(place, k.name)));
    row.keys_of(kind).filter(partner).fold(edit, |edit, k| edit.and(Edit::set(place, k.name, first_value(k))))
}

/// A menu of keys that the table could have.
fn missing(ui: &mut Ui, row: &'static TableRow, place: &str, here: &dyn TableLike, but: &[&str], edits: &mut Edits) {
    let kind = here.get("kind").and_then(Item::as_str);
    let absent = |k: &&Key| !here.contains_key(k.name) && !NESTED.contains(&k.kind) && !but.contains(&k.name);
    let absent: Vec<&Key> = row.keys_of(kind).filter(absent).collect();
    if absent.is_empty() {
        return;
    }
    ui.menu_button("more …", |ui| {
        for key in absent {
            let default = key.default.map_or_else(String::new, |d| format!("\nnow: {d}"));
            if ui.button(key.name).on_hover_text(format!("{} ({}){default}", key.summary, key.kind)).clicked() {
                edits.push(added(row, place, here, key));
                ui.close();
            }
        }
    });
}

/// The name of a key, with all that is known of it; a menu takes it away.
fn name(ui: &mut Ui, place: &str, key: &Key, edits: &mut Edits) -> Response {
    let default = key.default.map_or_else(|| "required".to_owned(), |d| format!("without it: {d}"));
    let label = ui.add(egui::Label::new(key.name).sense(egui::Sense::click()));
    let label = label.on_hover_text(format!("{}\n{} · {default}", key.summary, key.kind));
    if key.default.is_some() {
        label.context_menu(|ui| {
            if ui.button("Take away").clicked() {
                edits.push(Edit::remove(place, key.name));
                ui.close();
            }
        });
    }
    label
}

fn one(ui: &mut Ui, place: &str, key: &Key, item: &Item, edits: &mut Edits) {
    let label = name(ui, place, key, edits);
    let response = match (key.kind, item.as_value()) {
        (_, Some(Value::Boolean(flag))) => {
            let mut on = *flag.value();
            let response = ui.checkbox(&mut on, "");
            set_if(response, place, key, edits, || on.into())
        }
        ("position", Some(Value::String(text))) => position(ui, (place, key), label.id, text.value(), edits),
        ("integer", Some(Value::Integer(n))) => {
            let mut number = *n.value();
            let response = ui.add(DragValue::new(&mut number).update_while_editing(false));
            set_if(response, place, key, edits, || number.into())
        }
        (_, Some(Value::Integer(n))) => number(ui, *n.value() as f64, "", |v| significant(v).into(), (place, key), edits),
        (_, Some(Value::Float(v))) => number(ui, *v.value(), "", |v| significant(v).into(), (place, key), edits),
        (_, Some(Value::String(text))) => match (key.catalogue, parts(text.value()).filter(|_| quantity(key).is_some())) {
            (Some(catalogue), _) => choice(ui, catalogue, text.value(), (place, key), edits),
            (None, Some((value, unit))) => measured(ui, value, unit.to_owned(), (place, key), edits),
            (None, None) => words(ui, text.value(), |t| Some(t.into()), (place, key), edits),
        },
        (_, Some(value)) => {
            let text = value.clone().decorated("", "").to_string();
            words(ui, &text, |t| t.parse::<Value>().ok(), (place, key), edits)
        }
        (_, None) => ui.weak("a table"),
    };
    response.labelled_by(label.id);
}

fn set_if(response: Response, place: &str, key: &Key, edits: &mut Edits, value: impl FnOnce() -> Value) -> Response {
    if response.changed() {
        edits.push(Edit::set(place, key.name, value()));
    }
    response
}

/// The quantity that a key is written in; extinction is of two.
fn quantity(key: &Key) -> Option<&'static QuantityRow> {
    let name = if key.kind == "extinction" { "extinction per length" } else { key.kind };
    QUANTITIES.iter().find(|q| q.name == name)
}

/// A number that is dragged, or typed and then taken as a whole, in the digits that it is written with.
pub fn drag(value: &mut f64, speed: f64) -> DragValue<'_> {
    DragValue::new(value).speed(speed).update_while_editing(false).custom_formatter(|v, _| rounded(v, DIGITS))
}

/// Whether a number was changed by more than being shown in fewer digits.
pub fn is_changed(response: &Response, before: f64, after: f64) -> bool {
    response.changed() && rounded(before, DIGITS) != rounded(after, DIGITS)
}

/// A number that is dragged in proportion to itself.
fn number(ui: &mut Ui, value: f64, unit: &str, write: impl Fn(f64) -> Value, (place, key): (&str, &Key), edits: &mut Edits) -> Response {
    let mut changed = value;
    let suffix = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let response = ui.add(drag(&mut changed, (value.abs() * DRAG).max(1e-4)).suffix(suffix));
    if is_changed(&response, value, changed) {
        edits.push(Edit::set(place, key.name, write(changed)));
    }
    response
}

/// A quantity: its number, and the unit it is written in.
fn measured(ui: &mut Ui, value: f64, unit: String, (place, key): (&str, &Key), edits: &mut Edits) -> Response {
    let text = |v: f64| Value::from(format!("{} {unit}", rounded(v, DIGITS)));
    number(ui, value, &unit, text, (place, key), edits)
}

/// Three coordinates and a unit of length.
fn position(ui: &mut Ui, (place, key): (&str, &Key), label: Id, text: &str, edits: &mut Edits) -> Response {
    let words: Vec<&str> = text.split([' ', ',']).filter(|w| !w.is_empty()).collect();
    let &[x, y, z, unit] = &words[..] else { return ui.weak(text) };
    let (Ok(x), Ok(y), Ok(z)) = (x.parse::<f64>(), y.parse::<f64>(), z.parse::<f64>()) else { return ui.weak(text) };
    let before = [x, y, z];
    let mut after = before;
    let speed = (before.iter().map(|v| v.abs()).fold(0.0, f64::max) * DRAG).max(1e-3);
    let mut changed = false;
    let long = before.iter().any(|v| rounded(*v, DIGITS).len() > SHORT);
    let drags = |ui: &mut Ui| {
        ui.spacing_mut().interact_size = COORDINATE.into();
        let drags = [0, 1, 2].map(|i| {
            let response = ui.add(drag(&mut after[i], speed)).labelled_by(label);
            changed |= is_changed(&response, before[i], after[i]);
            response
        });
        ui.label(unit);
        drags.into_iter().reduce(|a, b| a | b)
    };
    // Long numbers stand below each other.
    let row = if long { ui.vertical(drags) } else { ui.horizontal(drags) };
    if changed {
        let written = |i: usize| if after[i] == before[i] { words[i].to_owned() } else { rounded(after[i], DIGITS) };
        edits.push(Edit::set(place, key.name, format!("{} {} {} {unit}", written(0), written(1), written(2))));
    }
    row.inner.unwrap_or(row.response)
}

/// A name of a catalogue.
fn choice(ui: &mut Ui, catalogue: &str, now: &str, (place, key): (&str, &Key), edits: &mut Edits) -> Response {
    let rows = CATALOGUES.iter().find(|c| c.name == catalogue).map_or_else(Vec::new, |c| (c.rows)());
    let summary = rows.iter().find(|(name, _)| name == now).map_or("", |(_, summary)| summary).to_owned();
    let combo = egui::ComboBox::from_id_salt((place, key.name)).selected_text(now).width(150.0).show_ui(ui, |ui| {
        for (name, summary) in &rows {
            if ui.selectable_label(name == now, name).on_hover_text(summary).clicked() && name != now {
                edits.push(Edit::set(place, key.name, name.as_str()));
            }
        }
    });
    combo.response.on_hover_text(summary)
}

/// A text that is taken when it is left.
fn words(ui: &mut Ui, now: &str, write: impl Fn(&str) -> Option<Value>, (place, key): (&str, &Key), edits: &mut Edits) -> Response {
    let id = Id::unique(("words", place, key.name));
    let mut text = ui.data_mut(|d| d.get_temp::<String>(id)).unwrap_or_else(|| now.to_owned());
    let response = ui.add(egui::TextEdit::singleline(&mut text).id(id.with("edit")).desired_width(150.0));
    if response.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, text.clone()));
    }
    if response.lost_focus() {
        ui.data_mut(|d| d.remove::<String>(id));
        let given_up = ui.input(|i| i.key_pressed(egui::Key::Escape));
        match write(&text) {
            Some(value) if text != now && !given_up => edits.push(Edit::set(place, key.name, value)),
            _ => {}
        }
    }
    response
}

/// First values of keys that an example of their unit would not fit: key, what it is, value. Ends of a range are not
/// equal, widths are narrow.
const FIRST: [(&str, &str, &str); 7] = [
    ("low", "position", "-1 -1 -1 pc"),
    ("high", "position", "1 1 1 pc"),
    ("low", "wavelength", "400 nm"),
    ("high", "wavelength", "700 nm"),
    ("width", "wavelength", "50 nm"),
    ("fwhm", "wavelength", "50 nm"),
    ("half_width", "wavelength", "50 nm"),
];

/// What a key is set to when it is added.
fn first_value(key: &Key) -> Value {
    if let Some((_, _, value)) = FIRST.iter().find(|(name, kind, _)| *name == key.name && *kind == key.kind) {
        return (*value).into();
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
        "direction" => numbers([0.0, 0.0, 1.0]),
        "list of tables" => {
            let line = [("wavelength", Value::from("656.28 nm")), ("strength", Value::from(1.0))].into_iter().collect::<InlineTable>();
            Value::Array([line].into_iter().collect::<Array>())
        }
        "boolean" => (default != "true").into(),
        "integer" => default.parse::<i64>().unwrap_or(64).into(),
        "number" | "number or table" => default.parse::<f64>().unwrap_or(0.5).into(),
        "list of numbers" if key.name == "nm" => numbers([500.0, 600.0]),
        "list of numbers" => numbers([0.0, 1.0]),
        "list of texts" => Value::Array(["300 nm", "1 um"].into_iter().collect::<Array>()),
        "[width, height]" => Value::Array([512i64, 512].into_iter().collect::<Array>()),
        "text or list" => default.into(),
        _ => default.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barnard::scene::schema::TABLES;

    const SCENE: &str = r#"
[camera]
kind = "perspective"
position = "0 0 6 pc"
field_of_view = "24 deg"

[bookmark.1]
kind = "perspective"
position = "0 4 0 pc"
up = [0, 0, 1]
field_of_view = "20 deg"

[field.cloud]
kind = "fbm"

[dust]
density = "cloud"
scale = "4 mag/pc"
albedo = { kind = "constant", value = 0.5 }
phase = { kind = "isotropic" }

[[star]]
kind = "blackbody"
position = "0.3 0.2 0.9 pc"
temperature = "20000 K"
luminosity = "3000 Lsun"

[[star_table]]
file = "stars.csv"

[[emission]]
kind = "recombination"
density = "cloud"
temperature = "10000 K"
electron_density = "1000 cm-3"

[background]
kind = "blackbody"
temperature = "15000 K"
radiance = "1e-7 W/m2/sr/um"

[background.stars]

[[band]]
name = "mine"
kind = "top_hat"
centre = "550 nm"
width = "50 nm"

[display]
[method]
"#;

    fn document() -> Document {
        said(SCENE)
    }

    fn said(text: &str) -> Document {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        std::fs::write(folder.path().join("stars.csv"), "x,y,z,temperature,luminosity\n0.1,0.2,0.3,5000,1\n").unwrap();
        Document::open(&path, 1 << 30).unwrap()
    }

    /// A place of every table.
    fn place(path: &str) -> String {
        match path {
            "star" | "star_table" | "emission" | "band" => format!("{path}.0"),
            "field.*" => "field.cloud".into(),
            "bookmark.*" => "bookmark.1".into(),
            path => path.into(),
        }
    }

    /// Every kind of every table can be chosen, and gets the keys that it needs; what needs a file says so.
    #[test]
    fn every_kind_can_be_chosen() {
        let mut chosen = 0;
        for row in TABLES {
            for kind in (row.kinds)() {
                // Parallel rays see no stars at infinity.
                let mut document =
                    said(&SCENE.replace(if ["camera", "bookmark.*"].contains(&row.path) { "[background.stars]" } else { "\0" }, ""));
                let place = place(row.path);
                if kind.name == "power_law" && row.path == "star" {
                    let key = row.keys_of(None).find(|k| k.name == "spectral_luminosity").unwrap();
                    let edit = added(row, &place, table(document.toml().as_table(), &place).unwrap(), key);
                    document.apply(edit).unwrap();
                }
                let edit = of_kind(row, &place, table(document.toml().as_table(), &place).unwrap(), kind.name);
                let needs_file = kind.keys.iter().any(|k| k.name == "file" && k.default.is_none());
                match document.apply(edit) {
                    Ok(()) => assert!(!needs_file, "{} {}", row.path, kind.name),
                    Err(error) => assert!(needs_file, "{} {}: {error}", row.path, kind.name),
                }
                chosen += 1;
            }
        }
        assert!(chosen > 30, "{chosen}");
    }

    /// Every key that a table may have can be added, but for those that only go with others, and the message then says
    /// which. A matrix has a button of its own.
    #[test]
    fn keys_can_be_added() {
        let mut refused = Vec::new();
        for row in TABLES.iter().filter(|row| !row.path.is_empty()) {
            let base = document();
            let place = place(row.path);
            let here = table(base.toml().as_table(), &place).unwrap();
            let kind = here.get("kind").and_then(Item::as_str);
            for key in row.keys_of(kind).filter(|k| !here.contains_key(k.name) && !NESTED.contains(&k.kind) && k.name != "matrix") {
                let mut document = document();
                if let Err(error) = document.apply(added(row, &place, here, key)) {
                    refused.push(format!("{} {}: {error}", row.path, key.name));
                }
            }
        }
        let explained = |e: &String| ["goes with", "takes no r_v", "cannot be read", "not both"].iter().any(|w| e.contains(w));
        assert!(refused.iter().all(explained) && refused.len() < 14, "{refused:#?}");
    }

    /// Comments and blanks stay where they are, whatever is set around them; tables on the way are made.
    #[test]
    fn texts_keep_their_comments() {
        let mut toml: toml_edit::DocumentMut = "a = 1 # one\n\n# two\n[b]\nc = \"x\"   # three\n".parse().unwrap();
        Edit::set("b", "c", "y").and(Edit::set("", "a", 2)).and(Edit::set("d.e", "f", true)).apply(&mut toml);
        assert_eq!(toml.to_string(), "a = 2 # one\n\n# two\n[b]\nc = \"y\"   # three\n\n[d.e]\nf = true\n");
        let mut toml: toml_edit::DocumentMut = "[[e]]\nlines = [{ w = 1, s = 2 }, { w = 3, s = 4 }]\n".parse().unwrap();
        Edit::set("e.0.lines.1", "s", 9.5).and(Edit::drop("e", 7)).apply(&mut toml);
        assert_eq!(toml.to_string(), "[[e]]\nlines = [{ w = 1, s = 2 }, { w = 3, s = 9.5 }]\n");
        Edit::drop("e", 0).apply(&mut toml);
        assert_eq!(crate::edit::count(&toml, "e"), 0);
    }
}
