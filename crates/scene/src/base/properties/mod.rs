//! Properties: the neutral tree that objects are read from.
//!
//! A [`Table`] holds texts, numbers, quantities, flags, lists and tables by name, each with its place in a file. TOML is
//! one source of such a tree, a dictionary of another language can be another; nothing here depends on either. A [`Key`]
//! declares one parameter with type, range and default, a [`Section`] reads a table with keys, a [`Kind`] is one way to
//! make an object of a table.

mod form;
mod key;
mod kind;
pub mod places;
mod section;
mod typed;
mod values;

use std::fmt;

use spectra::fingerprint::Fingerprint;

pub use crate::place::{Origin, Place};
pub use form::Form;
pub use key::{Fallback, KIND, KeyRow, Literal, Part, Range, Relation, Type, ValueRef};
pub use kind::{Kind, KindRow, build_kind, build_kind_with, chosen};
pub use section::{Named, Section};
pub use typed::{Key, Optional, OrDefault, Presence, Required};
pub use values::{
    Choice, Choices, Direction, Entry, Flag, Formula, Integer, NamedTables, Number, Numbers, Path, Position, Quantities, Size, SubTable,
    Tables, Text, Texts, ValueType,
};

/// The value of a property.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A text, or a quantity with its unit as a file writes it.
    Text(String),
    /// Numbers in one unit: a quantity, or the three lengths of a position.
    Quantity(Vec<f64>, String),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// true or false.
    Flag(bool),
    /// A list of properties.
    List(Vec<Property>),
    /// A table of properties.
    Table(Table),
}

impl Value {
    /// The text, of a text.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}

impl From<Literal> for Value {
    fn from(literal: Literal) -> Self {
        let list = |items: Vec<Value>| Value::List(items.into_iter().map(Property::from).collect());
        match literal {
            Literal::Text(text) => Value::Text(text.to_owned()),
            Literal::Integer(number) => Value::Integer(number),
            Literal::Number(number) => Value::Number(number),
            Literal::Flag(flag) => Value::Flag(flag),
            Literal::Numbers(numbers) => list(numbers.iter().map(|number| Value::Number(*number)).collect()),
            Literal::Texts(texts) => list(texts.iter().map(|text| Value::Text((*text).to_owned())).collect()),
        }
    }
}

/// A value and the line in which it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// The value.
    pub value: Value,
    /// The file and line in which it was said.
    pub origin: Option<Origin>,
}

impl From<Value> for Property {
    fn from(value: Value) -> Self {
        Self { value, origin: None }
    }
}

/// Values by name, in the order in which they were said.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    entries: Vec<(String, Property)>,
    origin: Option<Origin>,
}

impl Table {
    /// An empty table that begins at `origin`.
    pub fn new(origin: Option<Origin>) -> Self {
        Self { entries: Vec::new(), origin }
    }

    /// Sets `key`, in the place of a value that it had.
    pub fn insert(&mut self, key: impl Into<String>, property: impl Into<Property>) {
        let (key, property) = (key.into(), property.into());
        match self.entries.iter_mut().find(|(name, _)| *name == key) {
            Some((_, before)) => *before = property,
            None => self.entries.push((key, property)),
        }
    }

    /// Takes the property of `key` away.
    pub fn remove(&mut self, key: &str) {
        self.entries.retain(|(name, _)| name != key);
    }

    /// The property of `key`, where there is one.
    pub fn get(&self, key: &str) -> Option<&Property> {
        self.entries.iter().find(|(name, _)| name == key).map(|(_, property)| property)
    }

    /// The property of `key`, where there is one, to be changed.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Property> {
        self.entries.iter_mut().find(|(name, _)| name == key).map(|(_, property)| property)
    }

    /// Names and values, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Property)> {
        self.entries.iter().map(|(name, property)| (name.as_str(), property))
    }

    /// Fingerprint of keys and values, whatever lines they stand in.
    pub fn fingerprint(&self) -> Fingerprint {
        Fingerprint::of_text(&self.to_string())
    }

    /// The file and line in which the table begins.
    pub fn origin(&self) -> Option<&Origin> {
        self.origin.as_ref()
    }
}

/// Writes items separated by commas.
fn write_items<T>(
    f: &mut fmt::Formatter<'_>,
    items: impl Iterator<Item = T>,
    each: impl Fn(&mut fmt::Formatter<'_>, T) -> fmt::Result,
) -> fmt::Result {
    for (i, item) in items.enumerate() {
        f.write_str(if i > 0 { ", " } else { "" })?;
        each(f, item)?;
    }
    Ok(())
}

/// Writes a list in one line.
fn write_list<T>(
    f: &mut fmt::Formatter<'_>,
    items: impl Iterator<Item = T>,
    each: impl Fn(&mut fmt::Formatter<'_>, T) -> fmt::Result,
) -> fmt::Result {
    f.write_str("[")?;
    write_items(f, items, each)?;
    f.write_str("]")
}

impl fmt::Display for Value {
    /// As it stands in one line of a scene: equal values print alike.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Text(text) => write!(f, "{text:?}"),
            Value::Integer(number) => write!(f, "{number}"),
            Value::Number(number) => write!(f, "{number:?}"),
            Value::Flag(flag) => write!(f, "{flag}"),
            Value::Quantity(numbers, unit) => {
                f.write_str("\"")?;
                numbers.iter().try_for_each(|number| write!(f, "{number:?} "))?;
                write!(f, "{unit}\"")
            }
            Value::List(items) => write_list(f, items.iter(), |f, item| write!(f, "{}", item.value)),
            Value::Table(table) => write!(f, "{table}"),
        }
    }
}

impl fmt::Display for Table {
    /// As an inline table: tables that say the same print alike, whatever lines they stand in.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("{ ")?;
        write_items(f, self.iter(), |f, (key, property)| write!(f, "{key} = {}", property.value))?;
        f.write_str(" }")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A key has one value, and tables that say the same in other lines print alike.
    #[test]
    fn tables_print_what_they_say() {
        let origin = |line| Some(Origin { source: "a".into(), line });
        let table = |line| {
            let mut table = Table::new(origin(line));
            table.insert("a", Value::Number(2.0));
            table.insert("a", Property { value: Value::Integer(1), origin: origin(line) });
            table.insert("b", Value::List(vec![Value::Text("x \"y\"".into()).into(), Value::Flag(true).into()]));
            table
        };
        assert_eq!(table(1).to_string(), "{ a = 1, b = [\"x \\\"y\\\"\", true] }");
        assert_eq!(table(1).to_string(), table(2).to_string());
        let mut less = table(1);
        less.remove("a");
        assert!(less.get("a").is_none() && less.to_string() != table(1).to_string());
    }

    /// Numbers in one unit are checked one by one, like a list of texts.
    #[test]
    fn quantities_are_in_range() {
        use spectra::units::{Quantity, Wavelength};
        const KEY: Key<Quantities<Wavelength>> = Key::quantities("domain", "wavelengths").at_most(2.0);
        let read = |value: Value| {
            let mut table = Table::default();
            table.insert("domain", value);
            Section::new(&table, "method")
                .read(&KEY)
                .map(|found| found.unwrap_or_default().into_iter().map(Quantity::internal).collect::<Vec<_>>())
        };
        let list = |texts: [&str; 2]| Value::List(texts.map(|text| Property::from(Value::Text(text.into()))).to_vec());
        assert_eq!(read(Value::Quantity(vec![500.0, 750.0], "nm".into())).unwrap(), read(list(["500 nm", "750 nm"])).unwrap());
        let refused = |value: Value| read(value).unwrap_err().to_string();
        let message = refused(Value::Quantity(vec![0.5, 3.0], "um".into()));
        assert!(message.contains("out of range") && message == refused(list(["0.5 um", "3 um"])), "{message}");
    }
}
