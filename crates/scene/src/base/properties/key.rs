//! Keys: the rows that the check for unknown keys, the manual and the explorer read.

/// One key that a table may have.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// The name as scenes write it.
    pub name: &'static str,
    /// Kind of value, such as a length.
    pub kind: &'static str,
    /// Default value; none for a required key.
    pub default: Option<&'static str>,
    /// Meaning in one line.
    pub summary: &'static str,
    /// The catalogue that its text is a name of, if any.
    pub catalogue: Option<&'static str>,
}

impl Key {
    /// A key that may be left out.
    pub const fn optional(name: &'static str, kind: &'static str, default: &'static str, summary: &'static str) -> Self {
        Self { name, kind, default: Some(default), summary, catalogue: None }
    }

    /// A key that must be there.
    pub const fn required(name: &'static str, kind: &'static str, summary: &'static str) -> Self {
        Self { name, kind, default: None, summary, catalogue: None }
    }

    /// Copy of the key, whose text is a name of a catalogue.
    pub const fn of(self, catalogue: &'static str) -> Self {
        Self { catalogue: Some(catalogue), ..self }
    }
}
