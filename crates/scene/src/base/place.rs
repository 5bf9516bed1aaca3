//! Places: where something was said, for messages.

use std::fmt;
use std::sync::Arc;

/// The line of a text in which something stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// Name of the text: a file, as messages say it.
    pub source: Arc<str>,
    /// Line in it, from 1.
    pub line: usize,
}

/// Location of a property: table and key, and the line of its text where there is a text.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The line, where the tree was made of a text.
    pub origin: Option<Origin>,
    /// Path of the table, "dust.phase" or "star\[0\]" for the first of a list; empty for the root.
    pub path: String,
    /// The key in that table.
    pub key: String,
}

impl Place {
    /// Path of the property, such as "star\[0\].temperature", as `--set` and Python accept it.
    pub fn full_path(&self) -> String {
        let dot = if self.path.is_empty() { "" } else { "." };
        format!("{}{dot}{}", self.path, self.key)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Origin { source, line }) = &self.origin {
            write!(f, "{source}:{line}, ")?;
        }
        f.write_str(&self.full_path())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places count from zero, with and without a text.
    #[test]
    fn places_are_paths() {
        let place = |path: &str, key: &str| Place { origin: None, path: path.into(), key: key.into() };
        assert_eq!(place("star[2]", "temperature").to_string(), "star[2].temperature");
        assert_eq!(place("dust.phase", "g").to_string(), "dust.phase.g");
        assert_eq!(place("", "bands").to_string(), "bands");
        let origin = Some(Origin { source: "a.toml".into(), line: 7 });
        assert_eq!(Place { origin: origin.clone(), ..place("star[2]", "x") }.to_string(), "a.toml:7, star[2].x");
        assert_eq!(Place { origin, ..place("", "bands") }.to_string(), "a.toml:7, bands");
    }
}
