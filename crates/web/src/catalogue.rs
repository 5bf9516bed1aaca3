//! Names that the page offers.

use barnard_files::builtin::{self, SCENES};
use serde_json::{Value, json};
use spectra::colour::{PALETTES, STRETCHES};
use spectra::passband::SETS;
use wasm_bindgen::prelude::wasm_bindgen;

fn rows<'a>(rows: impl Iterator<Item = (&'a str, &'a str)>) -> Value {
    rows.map(|(name, summary)| json!({ "name": name, "summary": summary })).collect()
}

/// Built-in scenes, sets of filters, palettes and stretches, each with a name and a summary, as JSON. Scenes that need a file are left
/// out.
#[wasm_bindgen]
#[must_use]
pub fn catalogue() -> String {
    let scenes = SCENES.iter().filter(|scene| scene.needs.is_none()).map(|scene| (scene.name, scene.summary));
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scenes": rows(scenes),
        "filters": rows(SETS.iter().map(|set| (set.name, set.summary))),
        "palettes": rows(PALETTES.iter().map(|palette| (palette.name, palette.summary))),
        "stretches": rows(STRETCHES.iter().map(|stretch| (stretch.name, stretch.summary))),
    })
    .to_string()
}

/// Small picture of a built-in scene as JPEG; empty if there is none.
#[wasm_bindgen]
#[must_use]
pub fn thumbnail(name: &str) -> Vec<u8> {
    builtin::entry(name).ok().and_then(|scene| scene.thumbnail).map(<[u8]>::to_vec).unwrap_or_default()
}
