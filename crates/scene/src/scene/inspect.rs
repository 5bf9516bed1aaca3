//! The meaning of a file of a scene, for `barnard info`: everything that the scene could read it as.

use spectra::curve::Ordinate;
use spectra::passband::{Counting, Passband};

use super::{catalogue, star_table};
use crate::animation;
use crate::curve;
use crate::data::{InputNote, Inputs};
use crate::error::Result;
use crate::phase;
use crate::properties::{Key, Path, Required, Section, Table, Value};

/// One way to read a file.
struct Use {
    /// The name of the way in messages.
    name: &'static str,
    read: fn(&Section, &Inputs) -> Result<()>,
}

/// All ways to read a file of text or a table.
const USES: &[Use] = &[
    Use { name: "curve over wavelength", read: |section, inputs| curve_of(section, inputs) },
    Use { name: "phase function", read: |section, inputs| phase::tabulated(section, inputs).map(|_| ()) },
    Use { name: "star catalogue", read: |section, inputs| catalogue::build(section, inputs).map(|_| ()) },
    Use { name: "star table", read: |section, inputs| star_table::build(section, inputs).map(|_| ()) },
    Use { name: "camera path", read: |section, inputs| animation::check_path(section, inputs) },
];

/// The notes of every way in which `file` can be read, and the reasons why it cannot be read in the others.
pub fn inspect(file: &str, inputs: &Inputs) -> (Vec<InputNote>, Vec<(&'static str, String)>) {
    let mut table = Table::default();
    table.insert("file", Value::Text(file.into()));
    let refused = USES.iter().filter_map(|way| Some((way.name, (way.read)(&Section::new(&table, ""), inputs).err()?.to_string())));
    let refused = refused.collect();
    (inputs.notes(), refused)
}

const FILE: Key<Path, Required> = Key::path("file", "the file").required();

/// Reads a curve and notes what it would be as a filter.
fn curve_of(section: &Section, inputs: &Inputs) -> Result<()> {
    let curve = curve::read(section, &FILE, Ordinate::FluxDensity, inputs)
        .or_else(|_| curve::read(section, &FILE, Ordinate::Throughput, inputs))?;
    let counting = if curve.counts_photons == Some(true) { Counting::Photon } else { Counting::Energy };
    let file = section.read(&FILE)?;
    let range = |values: &[f64]| values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    let (low, high) = range(curve.table.y());
    let mut text = format!("values from {low} to {high}");
    if let Ok(band) = Passband::new(file, counting, curve.table) {
        text +=
            &format!("; as a filter: pivot {:.2} nm, width {:.2} nm, {}-counting", band.pivot().nm(), band.width().nm(), counting.name());
    }
    inputs.note(InputNote { file: file.into(), text, is_inferred: false });
    Ok(())
}
