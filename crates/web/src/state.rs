//! State of an explorer as the page shows it.

use barnard::image::Image;
use barnard_explorer::document::Document;
use barnard_explorer::edit::table;
use barnard_explorer::picture::Picture;
use barnard_explorer::probe::Probed;
use serde_json::{Value, json};
use toml_edit::Item;

/// Keys of a star and of the gas that the page changes.
const STAR_KEYS: [&str; 4] = ["name", "temperature", "luminosity", "position"];
const GAS_KEYS: [&str; 3] = ["density", "voxels", "temperature"];

/// A scene as the page shows it.
pub fn scene(document: &Document) -> Value {
    let scene = document.scene();
    let text = |place: &str, key: &str| {
        let item = table(document.toml().as_table(), place).and_then(|table| table.get(key)).and_then(Item::as_value);
        item.map(|value| value.as_str().map_or_else(|| value.to_string().trim().to_owned(), str::to_owned))
    };
    let texts =
        |place: &str, keys: &[&str]| -> Value { keys.iter().filter_map(|key| Some((key.to_string(), json!(text(place, key)?)))).collect() };
    let star = |number: usize| texts(&format!("star.{number}"), &STAR_KEYS);
    json!({
        "name": scene.name,
        "description": scene.description,
        "size": [scene.camera.width, scene.camera.height],
        "bands": scene.bands.iter().map(|band| band.name()).collect::<Vec<_>>(),
        "filters": text("", "bands"),
        "palette": text("display", "palette"),
        "stretch": scene.display.stretch.name(),
        "strength": scene.display.stretch.strength,
        "dust": text("dust", "scale"),
        "albedo": text("dust", "albedo"),
        "stars": (0..document.stars().len()).map(star).collect::<Vec<_>>(),
        "gas": scene.gas.as_ref().map(|_| texts("gas", &GAS_KEYS)),
        "bookmarks": scene.bookmarks.keys().collect::<Vec<_>>(),
        "duration": scene.timeline.as_ref().map(|timeline| timeline.frames.time(timeline.frames.last())),
        "rough": document.is_rough(),
        "undo": document.can_undo(),
        "redo": document.can_redo(),
    })
}

/// Pixel of a picture: radiances of its bands, optical depth, and the spectrum.
pub fn pixel(picture: &Picture, (column, row): (usize, usize)) -> Value {
    let probed = Probed::new(picture, (column, row));
    let (depth, continuum, failure) = match &probed.found {
        Ok(probe) => (Some(probe.depth), probe.continuum.clone(), None),
        Err(problem) => (None, Vec::new(), Some(problem)),
    };
    json!({
        "pixel": [column, row],
        "bands": bands(&picture.image, column, row),
        "unit": "W m⁻² sr⁻¹",
        "depth": depth,
        "wavelengths": probed.wavelengths_um,
        "continuum": continuum,
        "failure": failure,
    })
}

fn bands(image: &Image, column: usize, row: usize) -> Value {
    let value = |(number, band): (usize, &barnard::image::Band)| json!({ "name": band.label(), "value": image.at(number, row, column) });
    image.bands.iter().enumerate().map(value).collect()
}
