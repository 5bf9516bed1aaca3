//! Curves over wavelength that tables of a scene name by a file: filters, spectra, albedos, mean cosines.

use spectra::curve::{CurveOptions, Ordinate, SpectralCurve};

use crate::data::{InputNote, Inputs};
use crate::error::Result;
use crate::properties::{Key, Path, Section, Text};

/// Keys that go with every file of a curve.
pub(crate) const UNIT: Key<Text> =
    Key::text("unit", "unit of the file's spectral axis where the file states none, such as \"angstrom\", \"um\" or \"cm-1\"")
        .otherwise("the file's own");
pub(crate) const COLUMN: Key<Text> =
    Key::text("column", "name or number of the file's column to read").otherwise("the only one, or the one named like its quantity");

/// Reads the curve of the file that `key` names.
///
/// # Errors
/// If the file cannot be read or understood, with its place.
pub(crate) fn read<P>(section: &Section, key: &Key<Path, P>, ordinate: Ordinate, inputs: &Inputs) -> Result<SpectralCurve> {
    let file = section.need(key)?;
    let options = CurveOptions { ordinate, unit: section.read(&UNIT)?, column: section.read(&COLUMN)? };
    let columns = section.wrap(key, inputs.columns(file))?;
    let curve = section.wrap(key, SpectralCurve::from_columns(file, &columns, options))?;
    inputs.note(InputNote { file: file.into(), text: format!("{}: {}", ordinate.name(), curve.note), is_inferred: curve.is_inferred });
    Ok(curve)
}
