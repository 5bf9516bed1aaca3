//! Files that the page gives, for scenes that name them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use barnard_files::SceneFiles;
use barnard_files::builtin;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// Name of the volumes of built-in scenes, which are served packed.
const VOLUMES: &str = "volumes/";

thread_local! {
    /// Files by name. A worker has one thread.
    static FILES: RefCell<BTreeMap<String, Arc<[u8]>>> = const { RefCell::new(BTreeMap::new()) };
}

/// Gives a file for the scenes that are opened from now on. Volumes of built-in scenes are packed.
///
/// # Errors
/// If a packed volume is damaged.
#[wasm_bindgen]
pub fn give(name: String, bytes: &[u8]) -> Result<(), JsError> {
    let bytes = if name.starts_with(VOLUMES) {
        builtin::unpacked_volume(bytes).map_err(|error| JsError::new(&format!("{name}: {error}")))?
    } else {
        bytes.to_vec()
    };
    FILES.with_borrow_mut(|files| files.insert(name, bytes.into()));
    Ok(())
}

/// Files that a built-in scene requires and that were not given yet, one a line.
#[wasm_bindgen]
#[must_use]
pub fn needs(scene: &str) -> String {
    let Ok(entry) = builtin::entry(scene) else { return String::new() };
    let named = entry.text.split('"').filter(|word| word.starts_with(VOLUMES));
    let missing = named.filter(|name| FILES.with_borrow(|files| !files.contains_key(*name)));
    missing.collect::<Vec<_>>().join("\n")
}

/// Files of built-in scenes, and those that were given.
pub fn given() -> Arc<SceneFiles> {
    FILES.with_borrow(|files| builtin::files_with(files.iter().map(|(name, bytes)| (name.clone(), bytes.clone()))))
}
