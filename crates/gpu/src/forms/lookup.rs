//! Tables of ln F, one for each light and band.

use barnard::plan::Plan;
use spectra::rule::Form;

use super::{Contents, FormEntry, Heads};
use crate::error::Result;

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "lookup",
    of: |form| matches!(form, Form::Lookup(_)),
    wgsl: include_str!("../shaders/forms/lookup.wgsl"),
    bounded: false,
    turns: (1, 0),
    heads: Heads::LightsAndBands,
    fill,
};

fn fill(plan: &Plan, lights: &[usize], contents: &mut Contents) -> Result<()> {
    let bands = &plan.spectral.bands;
    for (i, light) in lights.iter().enumerate() {
        for (b, band) in bands.iter().enumerate() {
            let Form::Lookup(lookup) = &band.rule.form else { continue };
            let table = &lookup.tables[*light];
            contents.heads[i * bands.len() + b] = contents.equal_steps(table.step, &table.log);
        }
    }
    Ok(())
}
