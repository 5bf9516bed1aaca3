//! Coordinates in a basis; bands with the same basis share a table.

use barnard::plan::Plan;
use spectra::basis::MAX_SIZE;
use spectra::rule::Form;

use super::{Contents, FormEntry, Heads, Turns};
use crate::error::Result;

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "projection",
    is_form: |form| matches!(form, Form::Projection(_)),
    wgsl: include_str!("../shaders/forms/projection.wgsl"),
    bounded: false,
    is_short: false,
    turns: Turns { each_band: 2 + 2 * MAX_SIZE, each_term: 1 },
    heads: Heads::Bands,
    fill,
};

fn fill(plan: &Plan, _: &[usize], contents: &mut Contents) -> Result<()> {
    let mut written: Vec<(&[f64], [f32; 4])> = Vec::new();
    for (b, band) in plan.spectral().bands.iter().enumerate() {
        let Form::Projection(projection) = &band.rule.form else { continue };
        let exponents = &projection.basis.exponents[..];
        let head = match written.iter().find(|(e, _)| *e == exponents) {
            Some((_, head)) => *head,
            None => {
                let head = contents.coordinates(projection);
                written.push((exponents, head));
                head
            }
        };
        contents.heads[b] = head;
    }
    Ok(())
}
