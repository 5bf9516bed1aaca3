//! Edits of a scene's text: keys of tables that are set, removed and added.
//!
//! A table is named by its place: "" is the scene, "dust.phase" and "field.cloud" are tables in tables, "star.0" is the
//! first of a list.

use std::path::{Path, PathBuf};

use barnard::glam::DVec3;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// A change of the text, and its name: edits of one name that follow each other are undone together.
pub struct Edit {
    /// The name for the menu.
    pub name: String,
    apply: Box<dyn FnOnce(&mut DocumentMut)>,
}

impl Edit {
    /// An edit that changes the text in any way.
    pub fn new(name: impl Into<String>, apply: impl FnOnce(&mut DocumentMut) + 'static) -> Self {
        Self { name: name.into(), apply: Box::new(apply) }
    }

    /// Sets a key; a table that is not there is made.
    pub fn set(place: &str, key: &str, value: impl Into<Value>) -> Self {
        let (name, place, key, value) = (format!("{place}.{key}"), place.to_owned(), key.to_owned(), value.into());
        Self::new(name, move |document| {
            if let Some(table) = made(document.as_table_mut(), &place) {
                put(table, &key, value);
            }
        })
    }

    /// An edit that removes a key.
    pub fn remove(place: &str, key: &str) -> Self {
        let (name, place, key) = (format!("{place}.{key} removed"), place.to_owned(), key.to_owned());
        Self::new(name, move |document| {
            if let Some(table) = table_mut(document.as_table_mut(), &place) {
                table.remove(&key);
            }
        })
    }

    /// Adds a table to a list such as "star".
    pub fn push(list: &str, table: Table) -> Self {
        let (name, list) = (format!("{list} added"), list.to_owned());
        Self::new(name, move |document| {
            let item = document.entry(&list).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
            if let Some(tables) = item.as_array_of_tables_mut() {
                tables.push(table);
            } else if let Some(array) = item.as_array_mut() {
                array.push(table.into_inline_table());
            }
        })
    }

    /// Removes a table of a list.
    pub fn drop(list: &str, index: usize) -> Self {
        let (name, list) = (format!("{list}.{index} removed"), list.to_owned());
        Self::new(name, move |document| {
            let Some(item) = document.get_mut(&list) else { return };
            if let Some(tables) = item.as_array_of_tables_mut().filter(|t| index < t.len()) {
                tables.remove(index);
            } else if let Some(array) = item.as_array_mut().filter(|a| index < a.len()) {
                array.remove(index);
            }
        })
    }

    /// This edit and then another, as one under this one's name.
    pub fn and(self, other: Edit) -> Self {
        Self::new(self.name, move |document| {
            (self.apply)(document);
            (other.apply)(document);
        })
    }

    /// Copy of the edit under another name.
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Applies the edit to the tables of a text.
    pub fn apply(self, document: &mut DocumentMut) {
        (self.apply)(document);
    }
}

/// Sets a key and leaves the blanks and comments around it as they are.
fn put(table: &mut dyn TableLike, key: &str, mut value: Value) {
    if let Some(before) = table.get(key).and_then(Item::as_value) {
        *value.decor_mut() = before.decor().clone();
    }
    if let Some(item) = table.get_mut(key) {
        *item = Item::Value(value);
    } else {
        table.insert(key, Item::Value(value));
    }
}

/// The table at `place`, where there is one.
pub fn table<'a>(root: &'a Table, place: &str) -> Option<&'a dyn TableLike> {
    let mut table: &dyn TableLike = root;
    let mut steps = place.split('.').filter(|s| !s.is_empty()).peekable();
    while let Some(step) = steps.next() {
        let item = table.get(step)?;
        let index = steps.next_if(|s| s.parse::<usize>().is_ok() && item.as_table_like().is_none());
        table = match index.and_then(|s| s.parse::<usize>().ok()) {
            Some(index) => item.get(index)?.as_table_like()?,
            None => item.as_table_like()?,
        };
    }
    Some(table)
}

/// The table at `place`, to be changed.
pub fn table_mut<'a>(root: &'a mut Table, place: &str) -> Option<&'a mut dyn TableLike> {
    let mut table: &mut dyn TableLike = root;
    let mut steps = place.split('.').filter(|s| !s.is_empty()).peekable();
    while let Some(step) = steps.next() {
        let item = table.get_mut(step)?;
        let index = steps.next_if(|s| s.parse::<usize>().is_ok() && item.as_table_like().is_none());
        table = match index.and_then(|s| s.parse::<usize>().ok()) {
            Some(index) => item.get_mut(index)?.as_table_like_mut()?,
            None => item.as_table_like_mut()?,
        };
    }
    Some(table)
}

/// The table at `place`, to be changed; tables on the way that are not there are made, and a value in the way, such as
/// `albedo = 0.6`, gives way.
fn made<'a>(root: &'a mut Table, place: &str) -> Option<&'a mut dyn TableLike> {
    if table(root, place).is_none()
        && let Some((parent, name)) = place.rsplit_once('.').or(Some(("", place)))
    {
        let parent = made(root, parent)?;
        let child = if parent.get("kind").is_some_and(Item::is_value) && !name.is_empty() {
            Item::Value(Value::InlineTable(InlineTable::new()))
        } else {
            let mut table = Table::new();
            // No head of its own where it only holds others, such as [bookmark] above [bookmark.1].
            table.set_implicit(true);
            Item::Table(table)
        };
        parent.insert(name, child);
    }
    table_mut(root, place)
}

/// The number of tables in a list.
pub fn count(root: &Table, list: &str) -> usize {
    root.get(list).map_or(0, |item| item.as_array_of_tables().map_or_else(|| item.as_array().map_or(0, Array::len), ArrayOfTables::len))
}

/// A number with a number of significant digits, without an exponent if possible.
pub fn rounded(value: f64, digits: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e9).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// A number as scenes write it, to the digits that matter.
pub fn significant(value: f64) -> f64 {
    rounded(value, 6).parse().unwrap_or(value)
}

/// A place as scenes write it, to a millionth of what is `near` it \[pc\].
pub fn place_text(p: DVec3, near: f64) -> String {
    let least = 1e-6 * near;
    let [x, y, z] = p.to_array().map(|v| {
        let digits = (v.abs() / least).max(1.0).log10().ceil().clamp(1.0, 15.0);
        rounded(if v.abs() < least { 0.0 } else { v }, digits as usize)
    });
    format!("{x} {y} {z} pc")
}

/// A list of numbers as a value.
pub fn numbers(values: impl IntoIterator<Item = f64>) -> Value {
    Value::Array(values.into_iter().map(significant).collect::<Array>())
}

/// A number, whole or not.
pub fn number(value: &Value) -> Option<f64> {
    value.as_float().or(value.as_integer().map(|i| i as f64))
}

/// The numbers of a list.
pub fn list(table: &dyn TableLike, key: &str) -> Option<Vec<f64>> {
    Some(table.get(key)?.as_array()?.iter().filter_map(number).collect())
}

/// Makes the names of files in `table` those that `path` says, absolute.
pub fn rebase_files(table: &mut dyn TableLike, path: &dyn Fn(&str) -> PathBuf) {
    for (key, item) in table.iter_mut() {
        let is_file = matches!(key.get(), "file" | "g_file");
        if let Some(text) = item.as_str().filter(|text| is_file && Path::new(text).is_relative()).map(str::to_owned) {
            let full = std::path::absolute(path(&text)).unwrap_or_else(|_| path(&text));
            *item = Item::Value(full.to_string_lossy().into_owned().into());
        } else if let Some(child) = item.as_table_like_mut() {
            rebase_files(child, path);
        } else if let Some(tables) = item.as_array_of_tables_mut() {
            tables.iter_mut().for_each(|t| rebase_files(t, path));
        } else if let Some(array) = item.as_array_mut() {
            array.iter_mut().filter_map(Value::as_inline_table_mut).for_each(|t| rebase_files(t, path));
        }
    }
}
