//! Intervals of wavelength, a table over the segment's own depth for each light and interval.

use barnard::plan::Plan;
use spectra::rule::Form;

use super::{Contents, FormEntry, Heads, Turns};
use crate::error::Result;
use crate::tables::room;

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "preintegrated",
    is_form: |form| matches!(form, Form::Preintegrated(_)),
    wgsl: include_str!("../shaders/forms/preintegrated.wgsl"),
    bounded: false,
    is_short: false,
    turns: Turns { each_band: 2, each_term: 1 },
    heads: Heads::LightsAndTerms,
    fill,
};

fn fill(plan: &Plan, lights: &[usize], contents: &mut Contents) -> Result<()> {
    let room = room(plan.spectral().terms());
    for (i, light) in lights.iter().enumerate() {
        let mut term = i * room;
        for band in &plan.spectral().bands {
            let Form::Preintegrated(intervals) = &band.rule.form else { continue };
            for table in &intervals.tables[*light] {
                contents.heads[term] = contents.equal_steps(table.step, &table.mean);
                term += 1;
            }
        }
    }
    Ok(())
}
