//! Curves over wavelength that tables of a scene name by a file: filters, spectra, albedos, mean cosines.

use spectra::curve::{CurveOptions, Ordinate, SpectralCurve};

use crate::data::{InputNote, Inputs};
use crate::error::Result;
use crate::properties::{Key, Section};

/// Keys that go with every file of a curve.
pub(crate) const UNIT: Key = Key::optional(
    "unit",
    "text",
    "the file's own",
    "unit of the file's spectral axis where the file states none, such as \"angstrom\", \"um\" or \"cm-1\"",
);
pub(crate) const COLUMN: Key =
    Key::optional("column", "text", "the only one, or the one named like its quantity", "name or number of the file's column to read");

/// Reads the curve of the file that `key` names.
///
/// # Errors
/// If the file cannot be read or understood, with its place.
pub(crate) fn read(section: &Section, key: &str, ordinate: Ordinate, inputs: &Inputs) -> Result<SpectralCurve> {
    let file = section.need_text(key)?;
    let options = CurveOptions { ordinate, unit: section.text(UNIT.name)?, column: section.text(COLUMN.name)? };
    let columns = section.wrap(key, inputs.columns(file))?;
    let curve = section.wrap(key, SpectralCurve::from_columns(file, &columns, options))?;
    inputs.note(InputNote { file: file.into(), text: format!("{}: {}", ordinate.name(), curve.note), is_inferred: curve.is_inferred });
    Ok(curve)
}
