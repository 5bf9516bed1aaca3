//! Machine-readable keywords of an image: names of at most eight characters, as
//! FITS has them; other formats carry the same.

/// The value of a keyword.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A text.
    Text(String),
    /// A number, in the unit that the comment names.
    Number(f64),
    /// A whole number.
    Integer(i64),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Text(text) => f.write_str(text),
            Value::Number(number) => write!(f, "{number:E}"),
            Value::Integer(number) => write!(f, "{number}"),
        }
    }
}

/// A keyword as FITS headers and EXR attributes hold it.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyword {
    /// Its name: at most eight capital letters, digits, `-` and `_`.
    pub name: &'static str,
    /// The value it is set to.
    pub value: Value,
    /// Unit in brackets, and what it means.
    pub comment: &'static str,
}

/// A keyword with a text.
pub fn text(name: &'static str, value: impl Into<String>, comment: &'static str) -> Keyword {
    Keyword { name, value: Value::Text(value.into()), comment }
}

/// A number; none where it is not finite.
pub fn number(name: &'static str, value: f64, comment: &'static str) -> Option<Keyword> {
    value.is_finite().then_some(Keyword { name, value: Value::Number(value), comment })
}

/// A keyword with a whole number.
pub fn integer(name: &'static str, value: usize, comment: &'static str) -> Keyword {
    Keyword { name, value: Value::Integer(i64::try_from(value).unwrap_or(i64::MAX)), comment }
}
