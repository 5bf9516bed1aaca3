//! Rows of keys: name, type, range, default and meaning of a parameter, declared once.
//!
//! Parser, manual, editor, Python package, animations and fits read these rows. [`Key`](super::Key) adds the type with which
//! [`Section::read`](super::Section::read) returns the value.

use std::fmt;

use spectra::units::{QuantityRow, short};

use super::Value;
use crate::error::Result;

/// Type of a key's value.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Type {
    /// Any text.
    Text,
    /// Path of a file.
    Path,
    /// Expression of fields.
    Expression,
    /// One of these texts.
    Choice(fn() -> Vec<&'static str>),
    /// true or false.
    Flag,
    /// Integer.
    Integer,
    /// Number.
    Number,
    /// Number with a unit of one of these quantities.
    Quantity(&'static str, &'static [QuantityRow]),
    /// Three lengths, "x y z unit".
    Position,
    /// Direction, [x, y, z].
    Direction,
    /// Width and height in pixels.
    Size,
    /// List of numbers.
    Numbers,
    /// List of texts, or one text.
    Texts,
    /// List of quantities.
    Quantities(&'static QuantityRow),
    /// Table.
    Table,
    /// List of tables.
    Tables,
    /// Tables by name.
    NamedTables,
    /// Values of several types, in words.
    Other(&'static str),
}

impl Type {
    /// True for tables, which have rows of their own.
    pub fn is_table(self) -> bool {
        matches!(self, Self::Table | Self::Tables | Self::NamedTables)
    }

    /// The quantity in whose units a value is written; the first where there are several.
    pub fn quantity(self) -> Option<&'static QuantityRow> {
        match self {
            Self::Quantity(_, rows) => rows.first(),
            _ => None,
        }
    }

    /// The texts that the value is one of; empty for other types.
    pub fn choices(self) -> Vec<&'static str> {
        match self {
            Self::Choice(names) => names(),
            _ => Vec::new(),
        }
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text | Self::Choice(_) => f.write_str("text"),
            Self::Path => f.write_str("path"),
            Self::Expression => f.write_str("expression"),
            Self::Flag => f.write_str("boolean"),
            Self::Integer => f.write_str("integer"),
            Self::Number => f.write_str("number"),
            Self::Quantity(name, _) => f.write_str(name),
            Self::Position => f.write_str("position"),
            Self::Direction => f.write_str("direction"),
            Self::Size => f.write_str("[width, height]"),
            Self::Numbers => f.write_str("list of numbers"),
            Self::Texts => f.write_str("text or list of texts"),
            Self::Quantities(quantity) => write!(f, "list of {}s", quantity.name),
            Self::Table => f.write_str("table"),
            Self::Tables => f.write_str("list of tables"),
            Self::NamedTables => f.write_str("tables by name"),
            Self::Other(words) => f.write_str(words),
        }
    }
}

/// Value that a key has by default, as a scene writes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Literal {
    /// A text, or a quantity with its unit.
    Text(&'static str),
    /// An integer.
    Integer(i64),
    /// A number.
    Number(f64),
    /// true or false.
    Flag(bool),
    /// A list of numbers.
    Numbers(&'static [f64]),
    /// A list of texts.
    Texts(&'static [&'static str]),
}

impl fmt::Display for Literal {
    /// As messages and the manual write it: texts without quotes, except in lists.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Integer(number) => write!(f, "{number}"),
            Self::Number(number) => f.write_str(&brief(*number)),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Numbers(numbers) => super::write_list(f, numbers.iter(), |f, number| f.write_str(&short(*number))),
            Self::Texts(texts) => super::write_list(f, texts.iter(), |f, text| write!(f, "{text:?}")),
        }
    }
}

/// Value of a table, or the default of a key.
#[derive(Debug, Clone, Copy)]
pub enum ValueRef<'a> {
    /// Value of the table.
    Given(&'a Value),
    /// Default.
    Literal(Literal),
}

impl<'a> ValueRef<'a> {
    pub(super) fn text(self) -> Option<&'a str> {
        match self {
            Self::Given(Value::Text(text)) => Some(text),
            Self::Literal(Literal::Text(text)) => Some(text),
            _ => None,
        }
    }

    pub(super) fn integer(self) -> Option<i64> {
        match self {
            Self::Given(Value::Integer(number)) => Some(*number),
            Self::Literal(Literal::Integer(number)) => Some(number),
            _ => None,
        }
    }

    pub(super) fn number(self) -> Option<f64> {
        match self {
            Self::Given(Value::Number(number)) => Some(*number),
            Self::Literal(Literal::Number(number)) => Some(number),
            other => other.integer().map(|number| number as f64),
        }
    }

    pub(super) fn numbers(self) -> Option<Vec<f64>> {
        match self {
            Self::Given(Value::List(items)) => {
                items.iter().map(|item| ValueRef::Given(&item.value).number().filter(|number| number.is_finite())).collect()
            }
            Self::Literal(Literal::Numbers(numbers)) => Some(numbers.to_vec()),
            _ => None,
        }
    }
}

/// Interval of allowed numbers, in the internal unit of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// True if the lower end itself is excluded.
    pub excludes_low: bool,
    /// True if the upper end itself is excluded.
    pub excludes_high: bool,
}

impl Range {
    /// All finite numbers.
    pub const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY, excludes_low: false, excludes_high: false };

    /// True if `value` is finite and lies within.
    pub fn contains(&self, value: f64) -> bool {
        let is_above = if self.excludes_low { value > self.low } else { value >= self.low };
        let is_below = if self.excludes_high { value < self.high } else { value <= self.high };
        value.is_finite() && is_above && is_below
    }

    /// The allowed numbers in words that follow "must be", with ends in a unit of this size; none where all are allowed.
    fn words(&self, size: f64, unit: &str) -> Option<String> {
        let number = |value: f64| brief(value / size);
        let zero_or = |value: f64| if value == 0.0 { "zero".to_owned() } else { format!("{}{unit}", number(value)) };
        let low = (self.low > -f64::MAX).then(|| (if self.excludes_low { "above" } else { "at least" }, zero_or(self.low)));
        let high = (self.high < f64::MAX).then(|| (if self.excludes_high { "below" } else { "at most" }, zero_or(self.high)));
        match (low, high) {
            (None, None) => None,
            (Some((words, low)), None) => Some(format!("{words} {low}")),
            (None, Some((words, high))) => Some(format!("{words} {high}")),
            (Some(_), Some(_)) if !self.excludes_low && !self.excludes_high => {
                Some(format!("between {} and {}{unit}", number(self.low), number(self.high)))
            }
            (Some((above, low)), Some((below, high))) => Some(format!("{above} {low} and {below} {high}")),
        }
    }
}

/// A number in few characters: nine digits, and a power of ten below 1e-3 and from 1e6 on.
fn brief(value: f64) -> String {
    let value: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) { short(value) } else { format!("{value:e}") }
}

/// Name of the key that selects the kind of a table.
pub const KIND: &str = "kind";

/// Effect of leaving a key out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fallback {
    /// The key is required.
    Required,
    /// This value holds.
    Value(Literal),
    /// The program decides; in words.
    Words(&'static str),
}

/// Condition under which a key has an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// Independent of other keys.
    Free,
    /// Exactly one key of the group of this name is required.
    OneOf(&'static str),
    /// Only together with another key; without it the key is an error.
    Needs(&'static str),
    /// As [`Needs`](Self::Needs), and required there.
    RequiredWith(&'static str),
    /// Only without another key.
    Excludes(&'static str),
    /// Required for something that other keys or a file decide, in words.
    RequiredFor(&'static str),
}

/// Part of a scene that something depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Part {
    /// Densities, phase function and detail.
    Space,
    /// Positions of stars.
    Stars,
    /// Spectra and visibility of lights, passbands, extinction law and albedo.
    Spectra,
    /// Amount of dust.
    Amount,
    /// Method and accuracy.
    Method,
    /// Options of single back ends.
    Backend,
    /// Camera.
    View,
    /// Palette, stretch and glare.
    Display,
    /// Sky position and unit.
    Observation,
    /// Telescope, detector and noise.
    Instrument,
    /// Layers and encoding of files.
    Output,
}

impl fmt::Display for Part {
    /// The name in small letters.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&format!("{self:?}").to_lowercase())
    }
}

impl Part {
    /// All parts that an image or a file depends on.
    pub const ALL: [Self; 11] = [
        Self::Space,
        Self::Stars,
        Self::Spectra,
        Self::Amount,
        Self::Method,
        Self::Backend,
        Self::View,
        Self::Display,
        Self::Observation,
        Self::Instrument,
        Self::Output,
    ];
}

/// One key that a table may have.
#[derive(Debug, Clone, Copy)]
pub struct KeyRow {
    /// Name in scenes.
    pub name: &'static str,
    /// Type of the value.
    pub value: Type,
    /// Allowed numbers, in the internal unit of a quantity.
    pub range: Range,
    /// Effect of leaving it out.
    pub fallback: Fallback,
    /// Dependence on other keys of its table.
    pub relation: Relation,
    /// Catalogue that lists the allowed texts, if any.
    pub catalogue: Option<&'static str>,
    /// Value, written as TOML, with which an editor adds the key; also shown by messages.
    pub example: Option<&'static str>,
    /// Parts of the scene that the value changes, if not those of its table.
    pub parts: Option<&'static [Part]>,
    /// Meaning in one line.
    pub summary: &'static str,
    /// Checks type and range of a value in the table of a path.
    pub validate: fn(key: &KeyRow, value: ValueRef, path: &str) -> Result<()>,
}

impl KeyRow {
    /// True if a table without the key is an error, whatever else it has.
    pub fn is_required(&self) -> bool {
        self.fallback == Fallback::Required
    }

    /// Condition under which an optional key is required, in words.
    pub fn condition(&self) -> Option<String> {
        match self.relation {
            Relation::OneOf(group) => Some(format!("exactly one {group} is required")),
            Relation::RequiredWith(key) => Some(format!("required with {key}")),
            Relation::RequiredFor(words) => Some(format!("required for {words}")),
            _ => None,
        }
    }

    /// The default, or what determines it, in words; none for a required key.
    pub fn default_words(&self) -> Option<String> {
        match self.fallback {
            Fallback::Required => None,
            Fallback::Value(literal) => Some(literal.to_string()),
            Fallback::Words(words) => Some(self.condition().unwrap_or_else(|| words.to_owned())),
        }
    }

    /// Type and range, such as "number between 0 and 1"; choices by name.
    pub fn type_words(&self) -> String {
        let choices = self.value.choices();
        if let Some((last, others)) = choices.split_last().filter(|(_, others)| !others.is_empty()) {
            return format!("{} or {last}", others.join(", "));
        }
        match self.range_words() {
            Some(range) if matches!(self.value, Type::Numbers | Type::Quantities(_) | Type::Size) => {
                format!("{}, each {range}", self.value)
            }
            Some(range) => format!("{} {range}", self.value),
            None => self.value.to_string(),
        }
    }

    /// The allowed numbers in words that follow "must be"; none where all are allowed.
    pub fn range_words(&self) -> Option<String> {
        match self.value.quantity() {
            Some(quantity) => self.range.words(quantity.units[0].1, &format!(" {}", quantity.units[0].0)),
            None => self.range.words(1.0, ""),
        }
    }

    /// A number of the key with its unit.
    pub fn number_words(&self, number: f64) -> String {
        match self.value.quantity() {
            Some(quantity) => quantity.words(number),
            None => short(number),
        }
    }

    /// A value as a scene writes it, behind the equals sign.
    pub fn example_words(&self) -> String {
        let quoted = |text: &str| format!("{text:?}");
        match (self.example, self.value, self.fallback) {
            (Some(example), ..) => example.to_owned(),
            (_, _, Fallback::Value(Literal::Text(text))) => quoted(text),
            (_, _, Fallback::Value(literal)) => literal.to_string(),
            (_, Type::Quantity(_, [quantity, ..]), _) => quoted(quantity.example),
            (_, Type::Position, _) => quoted("0 0 0 pc"),
            (_, Type::Direction, _) => "[0, 0, 1]".into(),
            (_, Type::Number | Type::Integer, _) if self.range.contains(1.0) => "1".into(),
            (_, Type::Number | Type::Integer, _) => short(self.range.low),
            (_, Type::Flag, _) => "true".into(),
            (_, Type::Choice(names), _) => names().first().map_or_else(String::new, |name| quoted(name)),
            (_, Type::Quantities(quantity), _) => format!("[{:?}]", quantity.example),
            (_, Type::Numbers, _) => "[0, 1]".into(),
            _ => quoted("..."),
        }
    }
}
