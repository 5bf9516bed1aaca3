//! Exponentials: all they need is k and a weight for each term.

use spectra::rule::Form;

use super::{FormEntry, Heads};

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "nodes",
    of: |form| matches!(form, Form::Nodes(_)),
    wgsl: include_str!("../shaders/forms/nodes.wgsl"),
    bounded: true,
    turns: (2, 1),
    heads: Heads::Bands,
    fill: |_, _, _| Ok(()),
};
