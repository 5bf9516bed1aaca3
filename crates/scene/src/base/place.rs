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

/// The place of a property: table and key, and the line of its text where there is a text.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The line, where the tree was made of a text.
    pub origin: Option<Origin>,
    /// The table's full name, "dust.phase" or "star.1" for the first of a list; empty for the root.
    pub path: String,
    /// The key in that table.
    pub key: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.origin {
            Some(Origin { source, line }) if self.path.is_empty() => write!(f, "{source}:{line}, {}", self.key),
            Some(Origin { source, line }) => write!(f, "{source}:{line}, [{}] {}", self.path, self.key),
            None => {
                for part in self.path.split('.').filter(|part| !part.is_empty()) {
                    match part.parse::<usize>() {
                        Ok(number) => write!(f, "[{}]", number.saturating_sub(1))?,
                        Err(_) => write!(f, "{}{part}", if self.path.starts_with(part) { "" } else { "." })?,
                    }
                }
                write!(f, "{}{}", if self.path.is_empty() { "" } else { "." }, self.key)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place without a text is a path as programs write it, the first of a list being number 0.
    #[test]
    fn places_of_trees_without_a_text_are_paths() {
        let place = |path: &str, key: &str| Place { origin: None, path: path.into(), key: key.into() }.to_string();
        assert_eq!(place("star.3", "temperature"), "star[2].temperature");
        assert_eq!(place("dust.phase", "g"), "dust.phase.g");
        assert_eq!(place("", "bands"), "bands");
        let origin = Some(Origin { source: "a.toml".into(), line: 7 });
        assert_eq!(Place { origin: origin.clone(), path: "star.3".into(), key: "x".into() }.to_string(), "a.toml:7, [star.3] x");
        assert_eq!(Place { origin, path: String::new(), key: "bands".into() }.to_string(), "a.toml:7, bands");
    }
}
