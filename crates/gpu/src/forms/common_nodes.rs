//! Exponentials at nodes that all bands share: a table for each band says what it takes of each light at each node.

use barnard::plan::Plan;
use spectra::rule::Form;

use super::{Contents, FormEntry, Heads, Turns};
use crate::error::Result;

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "common_nodes",
    is_form: |form| matches!(form, Form::CommonNodes(_)),
    wgsl: include_str!("../shaders/forms/common_nodes.wgsl"),
    bounded: true,
    is_short: true,
    turns: Turns { each_band: 0, each_term: 1 },
    heads: Heads::Bands,
    fill,
};

/// The head of a band: the first node that it takes, how many, and where its weights of all nodes start, light × node.
fn fill(plan: &Plan, lights: &[usize], contents: &mut Contents) -> Result<()> {
    for (b, band) in plan.spectral().bands.iter().enumerate() {
        let Form::CommonNodes(nodes) = &band.rule.form else { continue };
        contents.heads[b] = [nodes.first as f32, band.terms() as f32, contents.here(), 0.0];
        let mut weights = vec![0.0; nodes.nodes.len() * lights.len()];
        for (row, light) in weights.chunks_exact_mut(nodes.nodes.len()).zip(lights) {
            row[nodes.first..].iter_mut().zip(&nodes.weights[*light]).for_each(|(value, weight)| *value = *weight as f32);
        }
        contents.tables.numbers(&weights, 0);
    }
    Ok(())
}
