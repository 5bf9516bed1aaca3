//! Tracks in a scene's text: keys of values that change, `[[animation]]`.

use toml_edit::{Array, DocumentMut, Item, Table, TableLike, Value};

use crate::edit::{Edit, rounded, significant, table_mut};

/// Animation entries of a scene.
const CHANGES: [&str; 3] = ["animation", "sequence", "camera.path"];

/// Times and values of a track.
fn lists(document: &mut DocumentMut, track: usize) -> Option<&mut dyn TableLike> {
    table_mut(document.as_table_mut(), &format!("animation.{track}"))
}

/// A list of a track; one of one text may be that text alone.
fn array<'a>(track: &'a mut dyn TableLike, name: &str) -> Option<&'a mut Array> {
    let item = track.get_mut(name)?;
    if let Some(text) = item.as_str().map(str::to_owned) {
        *item = Item::Value(Array::from_iter([text]).into());
    }
    item.as_array_mut()
}

/// A moment, to the millisecond.
fn moment(time: f64) -> String {
    format!("{} s", (1e3 * time).round() / 1e3)
}

/// A value with another number, in its own unit; none where it has not one number.
fn with_number(value: &Value, number: f64) -> Option<Value> {
    match value.as_str() {
        Some(text) => spectra::units::parts(text).map(|(_, unit)| format!("{} {unit}", rounded(number, 7)).trim_end().into()),
        None => crate::edit::number(value).map(|_| significant(number).into()),
    }
}

/// Puts a value in place of another, and leaves the blanks and comments around it as they are.
fn put(array: &mut Array, index: usize, mut value: Value) {
    if let Some(before) = array.get(index) {
        *value.decor_mut() = before.decor().clone();
        array.replace_formatted(index, value);
    }
}

/// The edit that moves a key of a track to another moment \[s\], and gives it another number if stated.
pub fn moved(track: usize, key: usize, time: f64, number: Option<f64>) -> Edit {
    Edit::new("key moved", move |document| {
        let Some(track) = lists(document, track) else { return };
        if let Some(times) = array(track, "times") {
            put(times, key, moment(time).into());
        }
        let Some((values, number)) = array(track, "values").zip(number) else { return };
        if let Some(value) = values.get(key).and_then(|value| with_number(value, number)) {
            put(values, key, value);
        }
    })
}

/// The edit that adds a key to a track, as its number `key`, at a moment \[s\], with the value that the track has there.
pub fn added(track: usize, key: usize, time: f64, value: &barnard::properties::Value) -> Edit {
    // What a scene shows of a value is how TOML writes it.
    let value = value.to_string().parse::<Value>();
    Edit::new("key added", move |document| {
        let (Some(track), Ok(value)) = (lists(document, track), value) else { return };
        for (name, content) in [("times", moment(time).into()), ("values", value)] {
            if let Some(list) = array(track, name).filter(|list| key <= list.len()) {
                list.insert(key, content);
            }
        }
    })
}

/// The edit that takes a key away, and with its last one the track.
pub fn dropped(track: usize, key: usize) -> Edit {
    Edit::new("key removed", move |document| {
        let Some(track_lists) = lists(document, track) else { return };
        let count = array(track_lists, "times").map_or(0, |times| times.len());
        if count == 1 && key == 0 {
            return Edit::drop("animation", track).apply(document);
        }
        for name in ["times", "values"] {
            if let Some(list) = array(track_lists, name).filter(|list| key < list.len()) {
                list.remove(key);
            }
        }
    })
}

/// The edit that begins a track of a key of the scene, at a moment \[s\]; `holds` where each value holds until the next one.
pub fn begun(place: &str, value: Value, time: f64, holds: bool) -> Edit {
    let mut table = Table::new();
    for (name, list) in
        [("of", place.into()), ("times", Array::from_iter([moment(time)]).into()), ("values", Array::from_iter([value]).into())]
    {
        table.insert(name, Item::Value(list));
    }
    if holds {
        table.insert("interpolation", Item::Value("step".into()));
    }
    Edit::push("animation", table).with_name(format!("track of {place}"))
}

/// The keys of a scene that have numbers, and so can change smoothly: what each is called, and what it says.
pub fn possible(root: &Table) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    walk(root, "", &mut found);
    found
}

fn walk(table: &dyn TableLike, place: &str, found: &mut Vec<(String, Value)>) {
    for (name, item) in table.iter() {
        let full = if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") };
        if CHANGES.contains(&full.as_str()) {
            continue;
        }
        if let Some(child) = item.as_table_like() {
            walk(child, &full, found);
        } else if let Some(tables) = item.as_array_of_tables() {
            tables.iter().enumerate().for_each(|(i, child)| walk(child, &format!("{full}[{i}]"), found));
        } else if let Some(value) = item.as_value() {
            let in_line = value.as_array().into_iter().flatten().enumerate();
            in_line.filter_map(|(i, v)| Some((i, v.as_inline_table()?))).for_each(|(i, child)| walk(child, &format!("{full}[{i}]"), found));
            let is_list = value.as_array().is_some_and(|list| !list.is_empty() && list.iter().all(|v| crate::edit::number(v).is_some()));
            if is_list || crate::edit::number(value).is_some() || value.as_str().is_some_and(|text| spectra::units::parts(text).is_some()) {
                let mut value = value.clone();
                value.decor_mut().clear();
                found.push((full, value));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = r#"name = "a"
[camera]
kind = "perspective"
position = "0 0 5 pc"
size = [64, 48]
[[star]]
name = "b"
temperature = "9000 K" # hot
[[animation]] # it cools
of = "star[0].temperature"
times = ["0 s", "4 s"]
values = ["9000 K", # first
"3000 K"]
"#;

    fn after(edit: Edit) -> String {
        let mut document: DocumentMut = SCENE.parse().unwrap();
        edit.apply(&mut document);
        document.to_string()
    }

    #[test]
    fn keys_move_come_and_go() {
        let text = after(moved(0, 1, 5.25, Some(4_500.000_000_1)));
        assert!(text.contains("times = [\"0 s\", \"5.25 s\"]") && text.contains("# first\n\"4500 K\"]"), "{text}");
        assert!(text.contains("# it cools") && text.contains("# hot"), "{text}");
        assert!(after(moved(0, 0, 1.0, None)).contains("times = [\"1 s\", \"4 s\"]\nvalues = [\"9000 K\""));
        let text = after(added(0, 1, 2.0, &barnard::properties::Value::Text("6000.0 K".into())));
        assert!(text.contains("\"0 s\", \"2 s\", \"4 s\"") && text.contains("\"6000.0 K\","), "{text}");
        let text = after(dropped(0, 0));
        assert!(text.contains("times = [ \"4 s\"]") && !text.contains("\"9000 K\","), "{text}");
        assert!(!after(dropped(0, 0).and(dropped(0, 0))).contains("animation"));
        assert_eq!(
            [moved(7, 0, 1.0, None), added(0, 9, 1.0, &barnard::properties::Value::Integer(1)), dropped(0, 9)].map(after),
            [SCENE; 3]
        );
    }

    /// One time may stand alone, long times keep their milliseconds, and numbers the digits that they had.
    #[test]
    fn texts_of_all_forms() {
        let alone = r#"[[animation]]
of = "display.white"
times = "1234.567 s"
values = [2]
"#;
        let after = |edit: Edit| {
            let mut document: DocumentMut = alone.parse().unwrap();
            edit.apply(&mut document);
            document.to_string()
        };
        let text = after(moved(0, 0, 1234.5664, Some(656.281)));
        assert!(text.contains("times = [\"1234.566 s\"]\nvalues = [656.281]"), "{text}");
        let two = after(added(0, 1, 2000.0, &barnard::properties::Value::Integer(3)));
        assert!(two.contains("[\"1234.567 s\", \"2000 s\"]\nvalues = [2, 3]"), "{two}");
        assert_eq!(after(dropped(0, 0)), "");
        assert!(after(begun("gas.voxels", 64.into(), 0.0, true)).ends_with("values = [64]\ninterpolation = \"step\"\n"));
    }

    #[test]
    fn keys_with_numbers_can_change() {
        let document: DocumentMut = SCENE.parse().unwrap();
        let names: Vec<String> = possible(&document).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["camera.position", "camera.size", "star[0].temperature"]);
        let (name, value) = possible(&document).remove(2);
        let text = after(begun(&name, value, 1.5, false));
        assert!(
            text.ends_with(
                r#"[[animation]]
of = "star[0].temperature"
times = ["1.5 s"]
values = ["9000 K"]
"#
            ),
            "{text}"
        );
    }
}
