//! Tables of ln F, one for each light and band: a quad for each gap between entries, as
//! `spectra::rule::DepthTable::rows` has it.

use barnard::plan::Plan;
use spectra::rule::Form;

use super::{Contents, FormEntry, Heads, Turns};
use crate::error::Result;

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "lookup",
    is_form: |form| matches!(form, Form::Lookup(_)),
    wgsl: include_str!("../shaders/forms/lookup.wgsl"),
    bounded: false,
    is_short: false,
    turns: Turns { each_band: 1, each_term: 0 },
    heads: Heads::LightsAndBands,
    fill,
};

fn fill(plan: &Plan, lights: &[usize], contents: &mut Contents) -> Result<()> {
    let bands = &plan.spectral().bands;
    for (i, light) in lights.iter().enumerate() {
        for (b, band) in bands.iter().enumerate() {
            let Form::Lookup(lookup) = &band.rule.form else { continue };
            let table = &lookup.tables[*light];
            contents.heads[i * bands.len() + b] = [(1.0 / table.step) as f32, (table.log.len() - 1) as f32, contents.here(), 0.0];
            contents.tables.0.extend(table.rows().map(|row| row.map(|v| v as f32)));
        }
    }
    Ok(())
}
