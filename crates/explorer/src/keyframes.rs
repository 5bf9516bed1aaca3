//! Keys of the camera's path in a scene's text.

use spectra::units::{Quantity, Time};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value};

use crate::edit::{Edit, table};
use crate::flight::Flight;

/// Moments that are one \[s\].
pub const SAME: f64 = 5e-4;

/// The moments of all keys \[s\], where they stand in the text.
pub fn moments(root: &Table) -> Vec<f64> {
    let keys = table(root, "camera.path").and_then(|path| path.get("key"));
    let count = keys
        .map_or(0, |keys| keys.as_array_of_tables().map_or_else(|| keys.as_array().map_or(0, toml_edit::Array::len), ArrayOfTables::len));
    (0..count).filter_map(|i| time_of(table(root, &format!("camera.path.key.{i}"))?.get("time")?)).collect()
}

fn time_of(item: &Item) -> Option<f64> {
    Time::parse(item.as_str()?).ok().map(|time| time.0)
}

/// The edit that takes a key away.
pub fn dropped(index: usize) -> Edit {
    Edit::new("key removed", move |document| {
        if let Some(tables) = keys_of(document).filter(|tables| index < tables.len()) {
            tables.remove(index);
        }
    })
}

/// The keys of the camera's path, made where there are none.
fn keys_of(document: &mut DocumentMut) -> Option<&mut ArrayOfTables> {
    /// A table of its own, where one stands in a line.
    fn unfolded(item: &mut Item) -> Option<&mut Table> {
        if let Some(inline) = item.as_inline_table().cloned() {
            *item = Item::Table(inline.into_table());
        }
        item.as_table_mut()
    }
    let camera = unfolded(document.entry("camera").or_insert_with(toml_edit::table))?;
    let path = camera.entry("path").or_insert_with(toml_edit::table);
    unfolded(path)?;
    let keys = path.as_table_mut()?.entry("key").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    if let Some(array) = keys.as_array().cloned() {
        *keys = Item::ArrayOfTables(
            array.iter().filter_map(|v| v.as_inline_table().cloned()).map(toml_edit::InlineTable::into_table).collect(),
        );
    }
    keys.as_array_of_tables_mut()
}

/// The edit that makes a view a key at a moment, in place of one that is there.
pub fn keyed(flight: &Flight, time: f64) -> Edit {
    let keys = flight.keys();
    Edit::new("key", move |document| {
        let Some(tables) = keys_of(document) else { return };
        let at = |table: &Table| table.get("time").and_then(time_of).unwrap_or(0.0);
        let there = (0..tables.len()).find(|i| tables.get(*i).is_some_and(|table| (at(table) - time).abs() < SAME));
        let mut table = Table::new();
        table.insert("time", Item::Value(Value::from(format!("{time} s"))));
        keys.into_iter().for_each(|(key, value)| drop(table.insert(key, Item::Value(value))));
        let mut all: Vec<Table> = tables.iter().cloned().enumerate().filter(|(i, _)| Some(*i) != there).map(|(_, table)| table).collect();
        all.push(table);
        all.sort_by(|a, b| at(a).total_cmp(&at(b)));
        tables.clear();
        all.into_iter().for_each(|mut table| {
            // Tables that moved stand where they are now.
            table.set_position(None);
            tables.push(table);
        });
    })
}
