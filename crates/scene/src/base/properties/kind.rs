//! Kinds: rows of a catalogue that a scene's tables choose by `kind = "..."`.

use spectra::SpectraError;

use super::{KIND, Key, KeyRow, Section};
use crate::data::Inputs;
use crate::error::Result;

/// One way to make a `T` from a table of a scene.
pub struct Kind<T: 'static> {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// The keys it takes beside `kind`.
    pub keys: &'static [KeyRow],
    /// Makes the object from a table of a scene.
    pub build: fn(&Section, &Inputs) -> Result<T>,
}

/// Description of a kind, without its constructor.
#[derive(Debug, Clone, Copy)]
pub struct KindRow {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// The keys it takes beside those of every kind.
    pub keys: &'static [KeyRow],
}

impl<T> Kind<T> {
    /// Catalogue row of this kind.
    pub fn row(&self) -> KindRow {
        KindRow { name: self.name, summary: self.summary, keys: self.keys }
    }
}

/// Builds what `section` describes by the row of `kinds` that its key `kind` names.
///
/// # Errors
/// If there is no such row, or its keys are wrong.
pub fn build_kind<T>(noun: &'static str, kinds: &[Kind<T>], section: &Section, inputs: &Inputs) -> Result<T> {
    build_kind_with(noun, kinds, &[], section, inputs)
}

/// Variant for tables that take `common` keys beside those of their kind.
///
/// # Errors
/// If there is no such row, or its keys are wrong.
pub fn build_kind_with<T>(noun: &'static str, kinds: &[Kind<T>], common: &[KeyRow], section: &Section, inputs: &Inputs) -> Result<T> {
    (chosen(noun, kinds, |k| (k.name, k.keys), common, section)?.build)(section, inputs)
}

/// The row of `kinds` that the key `kind` names, `section` holding no keys but its own and the `common` ones; `row`
/// gives name and keys of one.
///
/// # Errors
/// If there is no such row, or a key is unknown.
pub fn chosen<'k, K>(
    noun: &'static str,
    kinds: &'k [K],
    row: impl Fn(&K) -> (&'static str, &'static [KeyRow]),
    common: &[KeyRow],
    section: &Section,
) -> Result<&'k K> {
    let name = section.read(&Key::text(KIND, "kind of the table").required())?;
    let known: Vec<&str> = kinds.iter().map(|k| row(k).0).collect();
    let found = kinds.iter().find(|k| row(k).0 == name).ok_or_else(|| SpectraError::unknown(noun, name, &known));
    let kind = section.wrap(KIND, found)?;
    section.check_rows(&[KIND], row(kind).1.iter().chain(common))?;
    Ok(kind)
}
