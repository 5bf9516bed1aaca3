//! Places of a tree, such as "star\[0\].temperature" or "star.0.temperature".

use super::{Property, Table, Value};

/// The steps of a place.
fn steps(place: &str) -> Result<Vec<&str>, String> {
    let steps: Vec<&str> = place.split(['.', '[']).map(|step| step.trim_end_matches(']')).collect();
    if steps.iter().any(|step| step.is_empty()) {
        return Err(format!("\"{place}\" is not a key; write a key such as \"star[0].temperature\" or \"camera.field_of_view\""));
    }
    Ok(steps)
}

/// Value at a path, if any.
///
/// # Errors
/// In words, if the place is none of any tree.
pub fn get<'a>(tree: &'a Table, place: &str) -> Result<Option<&'a Property>, String> {
    let steps = steps(place)?;
    let (first, rest) = (steps[0], &steps[1..]);
    let mut found = tree.get(first);
    for step in rest {
        found = match found.map(|property| &property.value) {
            Some(Value::Table(table)) => table.get(step),
            Some(Value::List(items)) => step.parse().ok().and_then(|number: usize| items.get(number)),
            _ => None,
        };
    }
    Ok(found)
}

/// Sets the value at a place such as "star\[0\].temperature" of a tree; a table that it has not said is made.
///
/// # Errors
/// In words, if the tree can have no such place.
pub fn set(tree: &mut Table, place: &str, property: Property) -> Result<(), String> {
    let steps = steps(place)?;
    let (key, way) = (steps[steps.len() - 1], &steps[..steps.len() - 1]);
    let mut table = tree;
    let mut way = way.iter().peekable();
    let mut so_far = String::new();
    while let Some(step) = way.next() {
        so_far += &format!("{}{step}", if so_far.is_empty() { "" } else { "." });
        let missing = || format!("the scene has no table \"{so_far}\"; add it to the scene first");
        let number: Option<usize> = way.peek().and_then(|next| next.parse().ok());
        let is_named = number.is_none() || *step == "bookmark" || *step == "field";
        if table.get(step).is_none() && is_named {
            table.insert(*step, Value::Table(Table::default()));
        }
        table = match (table.get_mut(step).map(|property| &mut property.value), number) {
            (Some(Value::Table(table)), _) => table,
            (Some(Value::List(items)), Some(number)) => {
                way.next();
                let count = items.len();
                match items.get_mut(number).map(|item| &mut item.value) {
                    Some(Value::Table(table)) => table,
                    _ => return Err(format!("{so_far}[{number}] does not exist; the scene has {count}, and the first is {so_far}[0]")),
                }
            }
            (Some(Value::List(_)), None) => return Err(format!("\"{so_far}\" is a list; add an index, such as {so_far}[0]")),
            _ => return Err(missing()),
        };
    }
    table.insert(key, property);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(words: &str) -> Value {
        Value::Text(words.into())
    }

    /// Values are set where they are meant, and invalid places are rejected.
    #[test]
    fn places_of_a_tree() {
        let mut tree = Table::default();
        let star = |name: &str| {
            let mut star = Table::default();
            star.insert("name", text(name));
            Property::from(Value::Table(star))
        };
        tree.insert("star", Value::List(vec![star("a"), star("b")]));
        tree.insert("camera", star("c").value);
        let mut changed = tree.clone();
        set(&mut changed, "star[1].temperature", text("1 K").into()).unwrap();
        set(&mut changed, "camera.name", text("d").into()).unwrap();
        set(&mut changed, "bands", text("hst").into()).unwrap();
        set(&mut changed, "bookmark.1.name", text("e").into()).unwrap();
        set(&mut changed, "bookmark.1.name", text("f").into()).unwrap();
        let found = |place: &str| get(&changed, place).unwrap().map(|property| property.value.clone());
        assert_eq!((found("star.1.temperature"), found("star[2].x"), found("bands.x")), (Some(text("1 K")), None, None));
        let document = "{ star = [{ name = \"a\" }, { name = \"b\", temperature = \"1 K\" }], camera = { name = \"d\" }, bands = \"hst\", \
                    bookmark = { 1 = { name = \"f\" } } }";
        assert_eq!(changed.to_string(), document);
        for (place, words) in [
            ("star[2].x", "star[2] does not exist; the scene has 2"),
            ("star.x", "star[0]"),
            ("emission[0].scale", "no table \"emission\""),
            ("camera..x", "not a key"),
            ("", "not a key"),
            ("camera.name.x", "no table \"camera.name\""),
        ] {
            let error = set(&mut tree.clone(), place, text("").into()).unwrap_err();
            assert!(error.contains(words), "{place}: {error}");
        }
    }
}
