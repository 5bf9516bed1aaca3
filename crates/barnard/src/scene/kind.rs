//! Kinds: rows of a catalogue that a scene's tables choose by `kind = "..."`.

use spectra::SpectraError;

use super::{Key, Loader, Section};
use crate::error::Result;

/// One way to make a `T` from a table of a scene.
pub struct Kind<T: 'static> {
    /// Its name in scenes.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// The keys it takes beside `kind`.
    pub keys: &'static [Key],
    /// Makes it.
    pub build: fn(&Section, &Loader) -> Result<T>,
}

/// Builds what `section` describes by the row of `kinds` that its key `kind` names.
pub fn build_kind<T>(noun: &'static str, kinds: &[Kind<T>], section: &Section, loader: &Loader) -> Result<T> {
    build_kind_with(noun, kinds, &[], section, loader)
}

/// The same for tables that take `common` keys beside those of their kind.
pub fn build_kind_with<T>(noun: &'static str, kinds: &[Kind<T>], common: &[Key], section: &Section, loader: &Loader) -> Result<T> {
    let name = section.need_text("kind")?;
    let known: Vec<&str> = kinds.iter().map(|k| k.name).collect();
    let found = kinds.iter().find(|k| k.name == name).ok_or_else(|| SpectraError::unknown(noun, name, &known));
    let kind = section.wrap("kind", found)?;
    let keys: Vec<&str> = ["kind"].into_iter().chain(kind.keys.iter().chain(common).map(|k| k.name)).collect();
    section.check_keys(&keys)?;
    (kind.build)(section, loader)
}
