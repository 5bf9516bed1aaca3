//! TOML as a tree of properties, each with its line.

use std::ops::Range;
use std::sync::Arc;

use barnard::error::{Error, Result};
use barnard::properties::{Origin, Place, Property, Table, Value};
use toml_edit::{Document, DocumentMut, Item, TableLike, TomlError};

/// The tree that `text` is; `file` is its name in messages.
///
/// # Errors
/// If it is no TOML, or holds a date, which no key of a scene is.
pub fn properties(file: &str, text: &str) -> Result<Table> {
    let source = NumberedText::new(file, text);
    let document = Document::parse(text).map_err(|e| source.error(e.span(), "TOML", message(text, &e)))?;
    source.table(document.as_table(), source.origin(None))
}

/// The text that `table` is: what [`properties`] reads as the same tree.
///
/// Tables and lists of tables at the top have headers, `[camera]`, `[field.NAME]`, `[[star]]`; all that is deeper stands
/// in one line.
pub fn text(table: &Table) -> String {
    let mut document = DocumentMut::new();
    let is_tables = |items: &[Property]| !items.is_empty() && items.iter().all(|item| matches!(item.value, Value::Table(_)));
    for (key, property) in table.iter() {
        let item = match &property.value {
            Value::Table(table) if table.iter().next().is_some() && table.iter().all(|(_, p)| matches!(p.value, Value::Table(_))) => {
                let mut named = toml_edit::Table::new();
                named.set_implicit(true);
                table.iter().for_each(|(name, p)| drop(named.insert(name, headed(&p.value))));
                Item::Table(named)
            }
            Value::List(items) if is_tables(items) => {
                let tables = items.iter().filter_map(|item| headed(&item.value).into_table().ok());
                Item::ArrayOfTables(tables.collect())
            }
            other => headed(other),
        };
        document.insert(key, item);
    }
    document.to_string()
}

/// A value; a table with a header of its own.
fn headed(value: &Value) -> Item {
    let Value::Table(table) = value else { return Item::Value(in_line(value)) };
    let mut headed = toml_edit::Table::new();
    table.iter().for_each(|(key, property)| drop(headed.insert(key, Item::Value(in_line(&property.value)))));
    Item::Table(headed)
}

/// A value in one line.
fn in_line(value: &Value) -> toml_edit::Value {
    match value {
        Value::Text(text) => text.as_str().into(),
        Value::Quantity(numbers, unit) => {
            numbers.iter().map(|number| format!("{number:?} ")).chain([unit.clone()]).collect::<String>().into()
        }
        Value::Integer(number) => (*number).into(),
        Value::Number(number) => (*number).into(),
        Value::Flag(flag) => (*flag).into(),
        Value::List(items) => items.iter().map(|item| in_line(&item.value)).collect::<toml_edit::Array>().into(),
        Value::Table(table) => {
            table.iter().map(|(key, property)| (key, in_line(&property.value))).collect::<toml_edit::InlineTable>().into()
        }
    }
}

/// The error that something is wrong with `text`, with its line.
pub fn error(text: &str, error: &TomlError) -> Error {
    NumberedText::new("scene", text).error(error.span(), "TOML", message(text, error))
}

/// Message of a parser error, with the name of a key that is defined twice.
fn message(text: &str, error: &TomlError) -> String {
    match error.span().and_then(|span| text.get(span)) {
        Some(key) if error.message().trim() == "duplicate key" => format!("key \"{key}\" is defined twice; remove one"),
        _ => error.message().trim().to_owned(),
    }
}

/// A text whose lines are counted.
struct NumberedText {
    file: Arc<str>,
    /// The position at which each line but the first begins.
    starts: Vec<usize>,
}

impl NumberedText {
    fn new(file: &str, text: &str) -> Self {
        Self { file: file.into(), starts: text.match_indices('\n').map(|(at, _)| at + 1).collect() }
    }

    fn origin(&self, span: Option<Range<usize>>) -> Origin {
        let start = span.map_or(0, |span| span.start);
        Origin { source: self.file.clone(), line: self.starts.partition_point(|line| *line <= start) + 1 }
    }

    fn error(&self, span: Option<Range<usize>>, key: &str, message: impl Into<String>) -> Error {
        let place = Place { origin: Some(self.origin(span)), path: String::new(), key: key.into() };
        Error::Scene { message: message.into(), place }
    }

    /// A table that begins at `origin`.
    fn table(&self, toml: &dyn TableLike, origin: Origin) -> Result<Table> {
        let mut table = Table::new(Some(origin.clone()));
        for (name, item) in toml.iter() {
            let key = toml.get_key_value(name).and_then(|(key, _)| key.span()).or_else(|| item.span());
            let place = key.map_or_else(|| origin.clone(), |span| self.origin(Some(span)));
            let begins = item.span().map_or_else(|| origin.clone(), |span| self.origin(Some(span)));
            let value = match item {
                Item::None => continue,
                Item::Value(value) => self.value(name, value, begins)?,
                Item::Table(table) => Value::Table(self.table(table, begins)?),
                Item::ArrayOfTables(tables) => {
                    let one = |table_of: &toml_edit::Table| {
                        let place = table_of.span().map_or_else(|| begins.clone(), |span| self.origin(Some(span)));
                        Ok(Property { value: Value::Table(self.table(table_of, place.clone())?), origin: Some(place) })
                    };
                    Value::List(tables.iter().map(one).collect::<Result<_>>()?)
                }
            };
            table.insert(name, Property { value, origin: Some(place) });
        }
        Ok(table)
    }

    /// The value of key `name`, or one of its list.
    fn value(&self, name: &str, toml: &toml_edit::Value, begins: Origin) -> Result<Value> {
        Ok(match toml {
            toml_edit::Value::String(text) => Value::Text(text.value().clone()),
            toml_edit::Value::Integer(number) => Value::Integer(*number.value()),
            toml_edit::Value::Float(number) => Value::Number(*number.value()),
            toml_edit::Value::Boolean(flag) => Value::Flag(*flag.value()),
            toml_edit::Value::Datetime(date) => {
                return Err(self.error(toml.span(), name, format!("{} is a date; scenes have no keys of dates", date.value())));
            }
            toml_edit::Value::Array(items) => {
                let item = |item: &toml_edit::Value| {
                    let place = item.span().map_or_else(|| begins.clone(), |span| self.origin(Some(span)));
                    Ok(Property { value: self.value(name, item, place.clone())?, origin: Some(place) })
                };
                Value::List(items.iter().map(item).collect::<Result<_>>()?)
            }
            toml_edit::Value::InlineTable(table) => Value::Table(self.table(table, begins)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every value has the line of its key, tables and items of lists that of their own beginning.
    #[test]
    fn places_are_lines() {
        let text = r#"a = 1

[b]
c = [
  { d = "x" },
  2.5,
]
[[e]]
f = true
[[e]]
f = false
[g.h]
i = 1
"#;
        let table = properties("test.toml", text).unwrap();
        let line = |property: &Property| property.origin.as_ref().unwrap().line;
        let under = |property: &Property, key: &str| match &property.value {
            Value::Table(table) => table.get(key).unwrap().clone(),
            other => panic!("{other}"),
        };
        assert_eq!(line(table.get("a").unwrap()), 1);
        let c = under(table.get("b").unwrap(), "c");
        assert_eq!(line(&c), 4);
        let (Value::List(items), Value::List(tables)) = (&c.value, &table.get("e").unwrap().value) else { panic!("no lists") };
        assert_eq!((line(&items[0]), line(&items[1]), line(&under(&items[0], "d"))), (5, 6, 5));
        assert_eq!((line(&tables[0]), line(&tables[1]), line(&under(&tables[1], "f"))), (8, 10, 11));
        assert_eq!(line(&under(&under(table.get("g").unwrap(), "h"), "i")), 13);
        assert_eq!(
            table.to_string(),
            "{ a = 1, b = { c = [{ d = \"x\" }, 2.5] }, e = [{ f = true }, { f = false }], g = { h = { i = 1 } } }"
        );
    }

    /// A key that is defined twice is named, with the line of the second.
    #[test]
    fn keys_are_defined_once() {
        let error = properties("test.toml", "[dust]\nlaw = \"gordon23\"\nlaw = \"draine03\"\n").unwrap_err().to_string();
        assert!(error.contains("key \"law\" is defined twice") && error.contains("test.toml:3"), "{error}");
    }

    /// What is written is read as the same tree, for every built-in scene and for values that need care.
    #[test]
    fn trees_are_written_as_they_are_read() {
        let hard = "a = \"x \\\"y\\\" \\n µ\"\nb = [1, 2.5, 1e300, -0.0]\nc = { d = { e = [] }, \"f g\" = true }\n[g.\"1.5\"]\nh = [{ i = 1 }]\n[[j]]\nk = 1\n[[j]]\n[l]\n";
        let texts = crate::builtin::SCENES.iter().map(|scene| scene.text).chain([hard]);
        for text_part in texts {
            let table = properties("test.toml", text_part).unwrap();
            let written = text(&table);
            assert_eq!(properties("test.toml", &written).unwrap().to_string(), table.to_string(), "{written}");
        }
        let written = text(&properties("test.toml", hard).unwrap());
        assert!(["[g.\"1.5\"]", "[[j]]", "[l]"].iter().all(|header| written.contains(header)) && !written.contains("[g]"), "{written}");
    }

    #[test]
    fn what_is_no_tree_is_refused_with_its_line() {
        for (text, words) in
            [("a = 1\nb = \n", "test.toml:2"), ("a = 1\nb = 2020-01-01\n", "test.toml:2, b"), ("a = 1\na = 2\n", "test.toml:2")]
        {
            let error = properties("test.toml", text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
