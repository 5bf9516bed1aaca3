//! Exponentials: all they need is k and a weight for each term.

use spectra::rule::Form;

use super::{FormEntry, Heads, Turns};

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "nodes",
    of: |form| matches!(form, Form::Nodes(_)),
    wgsl: include_str!("../shaders/forms/nodes.wgsl"),
    bounded: true,
    turns: Turns { each_band: 2, each_term: 1 },
    heads: Heads::Bands,
    fill: |_, _, _| Ok(()),
};
