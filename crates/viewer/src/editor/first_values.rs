//! Initial text of an added table or key.

use barnard::properties::{Fallback, KeyRow, Literal, Relation, Type};
use barnard::scene::schema::TableRow;
use barnard_files::catalogue::Catalogue;
use toml_edit::{Item, TableLike, Value};

use barnard_explorer::edit::Edit;

/// Makes the table one of another kind.
pub fn of_kind(row: &'static TableRow, place: &str, here: &dyn TableLike, kind: &str) -> Edit {
    let known: Vec<&KeyRow> = row.keys_of(Some(kind)).collect();
    let mut edit = Edit::set(place, "kind", kind);
    for (name, _) in here.iter().filter(|(name, _)| *name != "kind" && !known.iter().any(|k| k.name == *name)) {
        edit = edit.and(Edit::remove(place, name));
    }
    for key in known.iter().filter(|k| k.is_required() && !here.contains_key(k.name)) {
        edit = edit.and(Edit::set(place, key.name, first_value(key)));
    }
    edit
}

/// Adds a key, and those that it needs; keys that exclude it are removed.
pub fn added(row: &'static TableRow, place: &str, here: &dyn TableLike, key: &KeyRow) -> Edit {
    let kind = here.get("kind").and_then(Item::as_str);
    let mut edit = Edit::set(place, key.name, first_value(key));
    let (mut open, mut known) = (vec![*key], vec![key.name]);
    while let Some(key) = open.pop() {
        for other in row.keys_of(kind).filter(|other| other.name != key.name) {
            let is_rival = matches!(key.relation, Relation::OneOf(_)) && other.relation == key.relation
                || key.relation == Relation::Excludes(other.name)
                || other.relation == Relation::Excludes(key.name);
            let is_needed = matches!(key.relation, Relation::Needs(name) | Relation::RequiredWith(name) if name == other.name)
                || other.relation == Relation::RequiredWith(key.name);
            if is_rival && here.contains_key(other.name) {
                edit = edit.and(Edit::remove(place, other.name));
            } else if is_needed && !here.contains_key(other.name) && !known.contains(&other.name) {
                edit = edit.and(Edit::set(place, other.name, first_value(other)));
                known.push(other.name);
                open.push(*other);
            }
        }
    }
    edit
}

/// The value with which a key is added: its example or default; the other value of a boolean.
fn first_value(key: &KeyRow) -> Value {
    if let (Type::Flag, Fallback::Value(Literal::Flag(default))) = (key.value, key.fallback) {
        return (!default).into();
    }
    let has_value = key.example.is_some() || matches!(key.fallback, Fallback::Value(_));
    match key.catalogue.filter(|_| !has_value).and_then(|name| Catalogue::by_name(name).ok()) {
        Some(catalogue) => (catalogue.rows)().first().map(|row| row.0.clone()).unwrap_or_default().into(),
        None => key.example_words().parse().unwrap_or_else(|_| key.example_words().into()),
    }
}
