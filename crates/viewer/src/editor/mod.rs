//! Tables of a scene as widgets: the rows of `scene::schema` say which keys there are, what they mean and what they are
//! written as.

mod first_values;
mod widgets;

use barnard::properties::KeyRow;
use barnard::scene::schema::TableRow;
use eframe::egui::{self, Response, Ui};
use toml_edit::{Item, TableLike};

use self::first_values::{added, of_kind};
use self::widgets::KeyWidget;
pub use self::widgets::{drag, is_changed};
use crate::command::Commands;
use barnard_explorer::document::Document;
use barnard_explorer::edit::{Edit, table};

/// The keys of the table at `place`, those that are there, and a menu of those that could be.
pub fn keys(ui: &mut Ui, document: &Document, place: &str, commands: &mut Commands) {
    keys_but(ui, document, place, &[], commands);
}

/// Keys without some that are listed elsewhere.
pub fn keys_but(ui: &mut Ui, document: &Document, place: &str, but: &[&str], commands: &mut Commands) {
    let Some(row) = row(place) else { return };
    let empty = toml_edit::Table::new();
    let here = table(document.toml().as_table(), place).unwrap_or(&empty);
    let kind = here.get("kind").and_then(Item::as_str);
    egui::Grid::new(("keys", place)).num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        if !(row.kinds)().is_empty() {
            kinds(ui, row, place, here, commands);
            ui.end_row();
        }
        for key in row.keys_of(kind).filter(|k| here.contains_key(k.name) && !k.value.is_table() && !but.contains(&k.name)) {
            if let Some(item) = here.get(key.name) {
                widget(ui, place, key, item, commands);
                ui.end_row();
            }
        }
    });
    missing(ui, row, place, here, but, commands);
}

/// The row of a place: "star.0" is a "star".
fn row(place: &str) -> Option<&'static TableRow> {
    let path: Vec<&str> = place.split('.').filter(|s| s.parse::<usize>().is_err()).collect();
    TableRow::by_name(&path.join("."))
}

/// One key, wherever it stands: its name and its widget.
pub fn key(ui: &mut Ui, document: &Document, place: &str, name: &str, commands: &mut Commands) {
    let Some(row) = row(place) else { return };
    let here = table(document.toml().as_table(), place);
    let kind = here.and_then(|t| t.get("kind")).and_then(Item::as_str);
    let found = row.keys_of(kind).find(|k| k.name == name);
    if let (Some(key), Some(item)) = (found, here.and_then(|t| t.get(name))) {
        ui.horizontal(|ui| widget(ui, place, key, item, commands));
    }
}

/// The menu of a table's kind. Another kind takes the keys it needs, and lets go of those it does not know.
fn kinds(ui: &mut Ui, row: &'static TableRow, place: &str, here: &dyn TableLike, commands: &mut Commands) {
    let now = here.get("kind").and_then(Item::as_str).unwrap_or("");
    let label = ui.label("kind");
    let kinds = (row.kinds)();
    let summary = kinds.iter().find(|k| k.name == now).map_or("", |k| k.summary);
    let response = egui::ComboBox::from_id_salt(("kind", place)).selected_text(now).show_ui(ui, |ui| {
        for kind in &kinds {
            if ui.selectable_label(kind.name == now, kind.name).on_hover_text(kind.summary).clicked() && kind.name != now {
                commands.push(of_kind(row, place, here, kind.name));
            }
        }
    });
    response.response.labelled_by(label.id).on_hover_text(summary);
}

/// A menu of keys that the table could have.
fn missing(ui: &mut Ui, row: &'static TableRow, place: &str, here: &dyn TableLike, but: &[&str], commands: &mut Commands) {
    let kind = here.get("kind").and_then(Item::as_str);
    let absent = |k: &&KeyRow| !here.contains_key(k.name) && !k.value.is_table() && !but.contains(&k.name);
    let absent: Vec<&KeyRow> = row.keys_of(kind).filter(absent).collect();
    if absent.is_empty() {
        return;
    }
    ui.menu_button("more …", |ui| {
        for key in absent {
            let default = key.default_words().map_or_else(String::new, |d| format!("\nnow: {d}"));
            if ui.button(key.name).on_hover_text(format!("{} ({}){default}", key.summary, key.type_words())).clicked() {
                commands.push(added(row, place, here, key));
                ui.close();
            }
        }
    });
}

/// The name of a key, with all that is known of it; a menu takes it away.
fn name(ui: &mut Ui, place: &str, key: &KeyRow, commands: &mut Commands) -> Response {
    let default = key.default_words().map_or_else(|| "required".to_owned(), |d| format!("without it: {d}"));
    let label = ui.add(egui::Label::new(key.name).sense(egui::Sense::click()));
    let label = label.on_hover_text(format!("{}\n{} · {default}", key.summary, key.type_words()));
    if !key.is_required() {
        label.context_menu(|ui| {
            if ui.button("Take away").clicked() {
                commands.push(Edit::remove(place, key.name));
                ui.close();
            }
        });
    }
    label
}

/// A key: its name, and the widget of its value.
fn widget(ui: &mut Ui, place: &str, key: &KeyRow, item: &Item, commands: &mut Commands) {
    let label = name(ui, place, key, commands);
    let response = KeyWidget { place, key, commands }.show(ui, item, label.id);
    response.labelled_by(label.id);
}

#[cfg(test)]
mod tests {
    use super::*;
    use barnard::properties::Type;
    use barnard::scene::schema::TABLES;

    const SCENE: &str = r#"
[camera]
kind = "perspective"
position = "0 0 6 pc"
field_of_view = "24 deg"

[camera.stereo]
eye_distance = "0.1 pc"

[camera.path]
[[camera.path.key]]
time = "0 s"
position = "0 0 6 pc"
[[camera.path.key]]
time = "1 s"
position = "1 0 5 pc"

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

[detail]
seed = 1

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

[gas]
density = "cloud"
voxels = 8

[background]
kind = "blackbody"
temperature = "15000 K"
radiance = "1e-7 W/m2/sr/um"

[background.stars]

[background.catalogue]
file = "sky.csv"

[[band]]
name = "mine"
kind = "top_hat"
centre = "550 nm"
width = "50 nm"

[display]
[display.glare]

[observation]
target = "18h18m48s -13d49m"
distance = "1.7 kpc"

[instrument]
aperture = "1 m"

[[instrument.psf]]
kind = "gaussian"
fwhm = "1 arcsec"

[output]
[method]
[method.path]
[method.reference]
[method.gpu]

[[animation]]
of = "dust.scale"
times = ["0 s", "1 s"]
values = ["4 mag/pc", "5 mag/pc"]

[sequence]
"#;

    fn document_of(text: &str) -> Document {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        std::fs::write(folder.path().join("stars.csv"), "x,y,z,temperature,luminosity\n0.1,0.2,0.3,5000,1\n").unwrap();
        std::fs::write(folder.path().join("sky.csv"), "ra,dec,magnitude\n274.7,-13.8,9\n").unwrap();
        Document::open(&path, 1 << 30).unwrap()
    }

    /// A place of every table.
    fn place(path: &str) -> String {
        match path {
            "star" | "star_table" | "emission" | "band" | "animation" | "camera.path.key" | "instrument.psf" => format!("{path}.0"),
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
                // Parallel rays see no stars at infinity, and are of one eye.
                let is_camera = ["camera", "bookmark.*"].contains(&row.path);
                let without = |text: String, part: &str| if is_camera { text.replace(part, "") } else { text };
                let text = without(SCENE.to_owned(), "[background.catalogue]\nfile = \"sky.csv\"\n");
                let text = without(without(text, "[background.stars]"), "[camera.stereo]\neye_distance = \"0.1 pc\"\n");
                let mut document = document_of(&text);
                let place = place(row.path);
                if kind.name == "power_law" && row.path == "star" {
                    let key = row.keys_of(None).find(|k| k.name == "spectral_luminosity").unwrap();
                    let edit = added(row, &place, table(document.toml().as_table(), &place).unwrap(), key);
                    document.apply(edit).unwrap();
                }
                let edit = of_kind(row, &place, table(document.toml().as_table(), &place).unwrap(), kind.name);
                // A file, or other fields.
                let needs_more = kind.keys.iter().any(|k| k.is_required() && matches!(k.value, Type::Path | Type::Expression));
                match document.apply(edit) {
                    Ok(()) => assert!(!needs_more, "{} {}", row.path, kind.name),
                    Err(error) => assert!(needs_more, "{} {}: {error}", row.path, kind.name),
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
            // A spectrograph takes the place of passbands.
            let bands = r#"[[band]]
name = "mine"
kind = "top_hat"
centre = "550 nm"
width = "50 nm"
"#;
            let spectrograph = r#"[spectrograph]
low = "500 nm"
high = "510 nm"
count = 5
"#;
            let text = if row.path == "spectrograph" { SCENE.replace(bands, spectrograph) } else { SCENE.to_owned() };
            let document = || document_of(&text);
            let base = document();
            let place = place(row.path);
            let here = table(base.toml().as_table(), &place).unwrap();
            let kind = here.get("kind").and_then(Item::as_str);
            for key in row.keys_of(kind).filter(|k| !here.contains_key(k.name) && !k.value.is_table() && k.name != "matrix") {
                let mut document = document();
                if let Err(error) = document.apply(added(row, &place, here, key)) {
                    refused.push(format!("{} {}: {error}", row.path, key.name));
                }
            }
        }
        let explained =
            |e: &String| ["requires", "does not support r_v", "does not exist", "exclude each other"].iter().any(|w| e.contains(w));
        assert!(refused.iter().all(explained) && refused.len() < 30, "{refused:#?}");
    }

    /// Comments and blanks stay where they are, whatever is set around them; tables on the way are made.
    #[test]
    fn texts_keep_their_comments() {
        let mut toml: toml_edit::DocumentMut = r#"a = 1 # one

# two
[b]
c = "x"   # three
"#
        .parse()
        .unwrap();
        Edit::set("b", "c", "y").and(Edit::set("", "a", 2)).and(Edit::set("d.e", "f", true)).apply(&mut toml);
        assert_eq!(
            toml.to_string(),
            r#"a = 2 # one

# two
[b]
c = "y"   # three

[d.e]
f = true
"#
        );
        let mut toml: toml_edit::DocumentMut = "[[e]]\nlines = [{ w = 1, s = 2 }, { w = 3, s = 4 }]\n".parse().unwrap();
        Edit::set("e.0.lines.1", "s", 9.5).and(Edit::drop("e", 7)).apply(&mut toml);
        assert_eq!(toml.to_string(), "[[e]]\nlines = [{ w = 1, s = 2 }, { w = 3, s = 9.5 }]\n");
        Edit::drop("e", 0).apply(&mut toml);
        assert_eq!(barnard_explorer::edit::count(&toml, "e"), 0);
    }
}
