//! Parameters of a scene: every value that can be swept, animated or fitted, with its type, range and current value.

use super::schema::{TABLES, TableRow};
use crate::properties::{Fallback, Form, KIND, KeyRow, Part, Table, Value, ValueRef};

/// A value of a scene that can be changed.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Path, such as "star\[0\].temperature", as `--set`, animations, fits and Python accept it.
    pub path: String,
    /// Type, range and meaning.
    pub key: &'static KeyRow,
    /// Current value, which is the default if the scene does not state one.
    pub value: Value,
    /// True if the scene states the value.
    pub is_stated: bool,
    /// Parts of the scene that the value changes.
    pub parts: &'static [Part],
}

impl Parameter {
    /// Numbers of the value and their unit, which is empty for plain numbers; none for texts and flags.
    pub fn numbers(&self) -> Option<(Vec<f64>, String)> {
        match (self.key.value.quantity(), Form::of(&self.value)?) {
            (_, (Form::Quantity(unit), numbers)) => (!unit.is_empty()).then_some((numbers, unit)),
            (None, (_, numbers)) => Some((numbers, String::new())),
            (Some(_), _) => None,
        }
    }

    /// Allowed numbers in the unit of the value; infinite where there is no limit.
    pub fn range(&self) -> (f64, f64) {
        let unit = self.numbers().map(|(_, unit)| unit).unwrap_or_default();
        let size = self.key.value.quantity().and_then(|quantity| quantity.unit_size(&unit)).unwrap_or(1.0);
        (self.key.range.low / size, self.key.range.high / size)
    }

    /// Checks another value of the parameter.
    ///
    /// # Errors
    /// If it has another type or unit, or is out of range.
    pub fn check(&self, value: &Value) -> crate::error::Result<()> {
        let (path, _) = self.path.rsplit_once('.').unwrap_or_default();
        (self.key.validate)(self.key, ValueRef::Given(value), path)
    }
}

/// All parameters of a scene's tree, in the order of the manual.
pub fn parameters(tree: &Table) -> Vec<Parameter> {
    // Animations and frames define changes; they are not values of the scene.
    let rows = TABLES.iter().filter(|row| !["animation", "sequence", "camera.path", "camera.path.key"].contains(&row.path));
    rows.flat_map(|row| tables(tree, row.path).into_iter().flat_map(move |(path, table)| of_table(row, &path, table))).collect()
}

/// The parameter at a path; none where the schema has no such key, or the scene has neither a value nor a default of it.
pub fn parameter(tree: &Table, path: &str) -> Option<Parameter> {
    let steps = |path: &str| path.split(['.', '[']).map(|step| step.trim_end_matches(']').to_owned()).collect::<Vec<_>>();
    let wanted = steps(path);
    parameters(tree).into_iter().find(|parameter| steps(&parameter.path) == wanted)
}

fn of_table(row: &'static TableRow, path: &str, table: &Table) -> Vec<Parameter> {
    let dot = if path.is_empty() { "" } else { "." };
    let kind = table.get(KIND).and_then(|property| property.value.text());
    let parameter = |key: &'static KeyRow| {
        let stated = table.get(key.name).map(|property| property.value.clone());
        let default = match key.fallback {
            Fallback::Value(literal) => Some(Value::from(literal)),
            _ => None,
        };
        let is_stated = stated.is_some();
        let value = stated.or(default).filter(|value| !matches!(value, Value::Table(_)))?;
        Some(Parameter { path: format!("{path}{dot}{}", key.name), key, value, is_stated, parts: key.parts.unwrap_or(row.parts) })
    };
    row.keys_of(kind).filter(|key| !key.value.is_table()).filter_map(parameter).collect()
}

/// The tables at a path of the schema, such as "star" or "field.*", each with its path in the tree.
fn tables<'a>(tree: &'a Table, path: &str) -> Vec<(String, &'a Table)> {
    let mut found = vec![(String::new(), tree)];
    for step in path.split('.').filter(|step| !step.is_empty()) {
        let below = |(place, table): (String, &'a Table)| {
            let named: Vec<(&str, &'a Value)> = match step {
                "*" => table.iter().map(|(name, property)| (name, &property.value)).collect(),
                name => table.get(name).map(|property| (name, &property.value)).into_iter().collect(),
            };
            let dot = if place.is_empty() { "" } else { "." };
            named.into_iter().flat_map(|(name, value)| within(format!("{place}{dot}{name}"), value)).collect::<Vec<_>>()
        };
        found = found.into_iter().flat_map(below).collect();
    }
    found
}

fn within(path: String, value: &Value) -> Vec<(String, &Table)> {
    match value {
        Value::Table(table) => vec![(path, table)],
        Value::List(items) => {
            let table = |(i, item): (usize, &'_ crate::properties::Property)| match &item.value {
                Value::Table(_) => Some(i),
                _ => None,
            };
            let indices: Vec<usize> = items.iter().enumerate().filter_map(table).collect();
            indices.into_iter().flat_map(|i| within(format!("{path}[{i}]"), &items[i].value)).collect()
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::properties::Property;

    fn table(entries: &[(&str, Value)]) -> Table {
        let mut table = Table::default();
        entries.iter().for_each(|(key, value)| table.insert(*key, value.clone()));
        table
    }

    /// Stated values and defaults are listed with path, unit and range; tables and keys without a value are not.
    #[test]
    fn parameters_have_values_units_and_ranges() {
        let star = table(&[
            ("kind", Value::Text("blackbody".into())),
            ("temperature", Value::Text("20 kK".into())),
            ("position", Value::Quantity(vec![0.0, 1.0, 2.0], "pc".into())),
        ]);
        let field = table(&[("kind", Value::Text("fbm".into())), ("octaves", Value::Integer(3))]);
        let stars = Value::List(vec![Property::from(Value::Table(star))]);
        let tree = table(&[("star", stars), ("field", Value::Table(table(&[("cloud", Value::Table(field))])))]);
        let all = parameters(&tree);
        let found = |path: &str| all.iter().find(|parameter| parameter.path == path).unwrap_or_else(|| panic!("{path}"));
        let temperature = found("star[0].temperature");
        assert_eq!(temperature.numbers(), Some((vec![20.0], "kK".into())));
        let (low, high) = temperature.range();
        assert!(temperature.is_stated && (low - 1e-3).abs() < 1e-15 && (high - 1e6).abs() < 1e-6);
        assert!(temperature.check(&Value::Quantity(vec![21.0], "kK".into())).is_ok());
        for wrong in [Value::Quantity(vec![-1.0], "kK".into()), Value::Quantity(vec![1.0], "pc".into()), Value::Number(1.0)] {
            assert!(temperature.check(&wrong).unwrap_err().to_string().contains("star[0].temperature"));
        }
        assert_eq!(found("star[0].position").numbers(), Some((vec![0.0, 1.0, 2.0], "pc".into())));
        assert_eq!((found("field.cloud.octaves").range(), found("field.cloud.gain").is_stated), ((1.0, 12.0), false));
        assert!(all.iter().all(|parameter| parameter.path != "star[0].luminosity" && parameter.path != "camera"));
    }

    /// Every default of the schema is a value of its key.
    #[test]
    fn defaults_are_valid() {
        let mut checked = 0;
        for row in TABLES {
            let of_kinds = (row.kinds)().into_iter().flat_map(|kind| kind.keys);
            for key in row.keys.iter().chain(of_kinds) {
                if let Fallback::Value(literal) = key.fallback {
                    let valid = (key.validate)(key, ValueRef::Literal(literal), "");
                    assert!(valid.is_ok(), "{} {}: {}", row.title, key.name, valid.unwrap_err());
                    checked += 1;
                }
            }
        }
        assert!(checked > 80, "{checked}");
    }
}
