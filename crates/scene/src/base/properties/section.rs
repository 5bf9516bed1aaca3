//! Sections: typed access to the keys of a table, with errors that name place, key and what would be right.

use std::ops::RangeInclusive;

use glam::DVec3;
use spectra::error::{article, nearest};
use spectra::units::{Length, Quantity, short};

use super::{Place, Property, Table, Value};
use crate::error::{Error, Result};
use crate::geometry::Bounds;

/// Positions beyond this [pc] leave too few digits for a cloud.
const FARTHEST_PC: f64 = 1e9;

/// One table of a scene, with its full name.
#[derive(Clone)]
pub struct Section<'a> {
    table: &'a Table,
    path: String,
}

impl<'a> Section<'a> {
    /// The section that is the whole tree.
    pub fn root(table: &'a Table) -> Self {
        Self::new(table, "")
    }

    /// The table `table`, called `path`.
    pub fn new(table: &'a Table, path: impl Into<String>) -> Self {
        Self { table, path: path.into() }
    }

    /// The table that the section reads.
    pub fn properties(&self) -> &'a Table {
        self.table
    }

    /// The table's full name, such as "dust.phase".
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The last part of the name.
    pub fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or(&self.path)
    }

    /// Names of the keys that are there.
    pub fn keys(&self) -> Vec<&'a str> {
        self.table.iter().map(|(k, _)| k).collect()
    }

    /// True if the table has `key`.
    pub fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    /// Canonical text of the table, without comments.
    pub fn said(&self) -> String {
        self.table.to_string()
    }

    /// Refuses keys that are not in `known`.
    ///
    /// # Errors
    /// If one is not known; its place, those that are known and the nearest of them are said.
    pub fn check_keys(&self, known: &[&str]) -> Result<()> {
        let Some((key, _)) = self.table.iter().find(|(k, _)| !known.contains(k)) else { return Ok(()) };
        let hint = nearest(key, known.iter().copied()).map(|n| format!(", did you mean \"{n}\"?")).unwrap_or_default();
        Err(self.error(key, format!("unknown key \"{key}\"{hint}; known: {}", known.join(", "))))
    }

    /// Refuses `keys` that nothing would read here, since they go with `partner`.
    ///
    /// # Errors
    /// If one of them is there; its place is said.
    pub fn refuse(&self, keys: &[&str], partner: &str) -> Result<()> {
        let Some(key) = keys.iter().find(|k| self.has(k)) else { return Ok(()) };
        Err(self.error(key, format!("\"{key}\" requires {partner} and would be ignored here; remove it")))
    }

    /// The error `message` about `key`.
    pub fn error(&self, key: &str, message: impl Into<String>) -> Error {
        let origin = self.table.get(key).and_then(|p| p.origin.as_ref()).or(self.table.origin()).cloned();
        Error::Scene { message: message.into(), place: Place { origin, path: self.path.clone(), key: key.to_owned() } }
    }

    /// Adds this key's place to an error from elsewhere.
    ///
    /// # Errors
    /// That of `result`, with the place of `key` where it has none.
    pub fn wrap<T, E: Into<Error>>(&self, key: &str, result: std::result::Result<T, E>) -> Result<T> {
        result.map_err(|e| match e.into() {
            placed @ (Error::Scene { .. } | Error::Memory { .. } | Error::Interrupted) => placed,
            other => self.error(key, other.to_string()),
        })
    }

    fn value(&self, key: &str) -> Option<&'a Value> {
        self.table.get(key).map(|property| &property.value)
    }

    fn missing(&self, key: &str, example: &str) -> Error {
        self.error(key, format!("key \"{key}\" is required; write it like {key} = {example}"))
    }

    fn wrong(&self, key: &str, wanted: &str) -> Error {
        let found = self.value(key).map(Value::to_string).unwrap_or_default();
        self.error(key, format!("found {found}; expected {wanted}"))
    }

    /// The value of `key` as a text.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>> {
        match self.value(key) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(_) => Err(self.wrong(key, "a text in quotes")),
        }
    }

    /// A text that must be there.
    ///
    /// # Errors
    /// If it is missing or something else; its place and what would be right are said.
    pub fn need_text(&self, key: &str) -> Result<&'a str> {
        self.text(key)?.ok_or_else(|| self.missing(key, "\"...\""))
    }

    /// The value of `key` as one of `choices`.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn choice(&self, key: &str, choices: &[&'static str]) -> Result<Option<&'static str>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        let found = choices.iter().find(|c| **c == text);
        found.map(|c| Some(*c)).ok_or_else(|| self.wrong(key, &format!("one of {}", choices.join(", "))))
    }

    /// A number within `range`.
    ///
    /// # Errors
    /// If the value is something else, or lies outside; its place and what would be right are said.
    pub fn number(&self, key: &str, range: RangeInclusive<f64>) -> Result<Option<f64>> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let number = number_of(value).ok_or_else(|| self.wrong(key, "a number"))?;
        if !range.contains(&number) {
            let [number, low, high] = [number, *range.start(), *range.end()].map(short);
            return Err(self.error(key, format!("{number} is out of range; it must be between {low} and {high}")));
        }
        Ok(Some(number))
    }

    /// An integer within `range`.
    ///
    /// # Errors
    /// If the value is something else, or lies outside; its place and what would be right are said.
    pub fn integer(&self, key: &str, range: RangeInclusive<i64>) -> Result<Option<i64>> {
        let number = match self.value(key) {
            None => return Ok(None),
            Some(Value::Integer(number)) => *number,
            Some(_) => return Err(self.wrong(key, "an integer")),
        };
        if !range.contains(&number) {
            return Err(self.error(key, format!("{number} is out of range; it must be between {} and {}", range.start(), range.end())));
        }
        Ok(Some(number))
    }

    /// The value of `key`, true or false.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn flag(&self, key: &str) -> Result<Option<bool>> {
        match self.value(key) {
            None => Ok(None),
            Some(Value::Flag(flag)) => Ok(Some(*flag)),
            Some(_) => Err(self.wrong(key, "true or false")),
        }
    }

    /// A quantity with its unit.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn quantity<Q: Quantity>(&self, key: &str) -> Result<Option<Q>> {
        if self.value(key).is_some_and(|value| !matches!(value, Value::Text(_))) {
            return Err(self.wrong(key, &format!("{} {} with its unit, such as \"{}\"", article(Q::NAME), Q::NAME, Q::EXAMPLE)));
        }
        match self.text(key)? {
            None => Ok(None),
            Some(text) => {
                let quantity = self.wrap(key, Q::parse(text))?;
                if Q::NAME == Length::NAME && quantity.internal().abs() > FARTHEST_PC {
                    return Err(self.error(key, format!("{text} exceeds {FARTHEST_PC:e} pc; move the scene closer")));
                }
                Ok(Some(quantity))
            }
        }
    }

    /// A quantity that must be there.
    ///
    /// # Errors
    /// If it is missing or something else; its place and what would be right are said.
    pub fn need<Q: Quantity>(&self, key: &str) -> Result<Q> {
        self.quantity(key)?.ok_or_else(|| self.missing(key, &format!("\"{}\"", Q::EXAMPLE)))
    }

    /// A quantity above zero.
    ///
    /// # Errors
    /// If the value is something else, or not above zero; its place and what would be right are said.
    pub fn positive<Q: Quantity + std::fmt::Display>(&self, key: &str) -> Result<Option<Q>> {
        let quantity = self.quantity::<Q>(key)?;
        if let Some(q) = quantity.filter(|q| q.internal() <= 0.0) {
            return Err(self.error(key, format!("{q} is out of range; the {} must be above zero, such as \"{}\"", Q::NAME, Q::EXAMPLE)));
        }
        Ok(quantity)
    }

    /// A quantity above zero that must be there.
    ///
    /// # Errors
    /// If it is missing or something else; its place and what would be right are said.
    pub fn need_positive<Q: Quantity + std::fmt::Display>(&self, key: &str) -> Result<Q> {
        self.positive(key)?.ok_or_else(|| self.missing(key, &format!("\"{}\"", Q::EXAMPLE)))
    }

    /// A place "x y z unit" \[pc\].
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn position(&self, key: &str) -> Result<Option<DVec3>> {
        let wrong = || self.wrong(key, "a position such as \"0.5 0 -2 pc\"");
        let text = match self.value(key) {
            None => return Ok(None),
            Some(Value::Text(text)) => text,
            Some(_) => return Err(wrong()),
        };
        let words: Vec<&str> = text.split([' ', ',']).filter(|w| !w.is_empty()).collect();
        let &[x, y, z, unit] = &words[..] else {
            let has_numbers = words.len() == 3 && words.iter().all(|word| word.parse::<f64>().is_ok());
            let unitless = || self.error(key, format!("position \"{text}\" has no unit; write \"{text} pc\", or another unit of length"));
            return Err(if has_numbers { unitless() } else { wrong() });
        };
        let size = Length::unit_size(unit).ok_or_else(|| self.wrong(key, "a position with a unit of length, such as \"0.5 0 -2 pc\""))?;
        let parse = |t: &str| t.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
        let place = size * DVec3::new(parse(x)?, parse(y)?, parse(z)?);
        if place.abs().max_element() > FARTHEST_PC {
            return Err(self.error(key, format!("is farther than {FARTHEST_PC:e} pc from the origin; move the scene closer")));
        }
        Ok(Some(place))
    }

    /// A place that must be there.
    ///
    /// # Errors
    /// If it is missing or something else; its place and what would be right are said.
    pub fn need_position(&self, key: &str) -> Result<DVec3> {
        self.position(key)?.ok_or_else(|| self.missing(key, "\"0 0 0 pc\""))
    }

    /// A box between two corners.
    ///
    /// # Errors
    /// If it is missing or something else; its place and what would be right are said.
    pub fn bounds(&self, low: &str, high: &str) -> Result<Bounds> {
        let bounds = Bounds { low: self.need_position(low)?, high: self.need_position(high)? };
        if !bounds.low.cmplt(bounds.high).all() {
            return Err(self.error(high, format!("{high} must exceed {low} along every axis")));
        }
        Ok(bounds)
    }

    /// A direction [x, y, z], normalised.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn direction(&self, key: &str) -> Result<Option<DVec3>> {
        let Some(numbers) = self.numbers(key)? else { return Ok(None) };
        let wrong = || self.wrong(key, "a direction such as [0, 0, 1]");
        let [x, y, z] = numbers[..] else { return Err(wrong()) };
        DVec3::new(x, y, z).try_normalize().map(Some).ok_or_else(wrong)
    }

    /// A list of numbers.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn numbers(&self, key: &str) -> Result<Option<Vec<f64>>> {
        let wrong = || self.wrong(key, "a list of numbers such as [1, 0.5, 2]");
        let items = match self.value(key) {
            None => return Ok(None),
            Some(Value::List(items)) => items,
            Some(_) => return Err(wrong()),
        };
        let number = |item: &Property| number_of(&item.value).filter(|v| v.is_finite());
        items.iter().map(|item| number(item).ok_or_else(wrong)).collect::<Result<Vec<f64>>>().map(Some)
    }

    /// A list of numbers that must be there, written like `example`.
    ///
    /// # Errors
    /// If it is missing or something else; its place and what would be right are said.
    pub fn need_numbers(&self, key: &str, example: &str) -> Result<Vec<f64>> {
        self.numbers(key)?.ok_or_else(|| self.missing(key, example))
    }

    /// A list of texts; a single text is a list of one.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<&'a str>>> {
        let wrong = || self.wrong(key, "a list of texts such as [\"johnson-B\", \"johnson-V\"]");
        let text = |item: &'a Property| match &item.value {
            Value::Text(text) => Ok(text.as_str()),
            _ => Err(wrong()),
        };
        match self.value(key) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(vec![text])),
            Some(Value::List(items)) => items.iter().map(text).collect::<Result<Vec<&str>>>().map(Some),
            Some(_) => Err(wrong()),
        }
    }

    /// The table under `key`.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn table(&self, key: &str) -> Result<Option<Section<'a>>> {
        match self.value(key) {
            None => Ok(None),
            Some(Value::Table(table)) => Ok(Some(self.child(key.to_owned(), table))),
            Some(_) => Err(self.wrong(key, "a table")),
        }
    }

    /// The tables under `key`, a list of tables.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn tables(&self, key: &str) -> Result<Vec<Section<'a>>> {
        let wrong = || self.wrong(key, &format!("a list of tables; write [[{key}]]"));
        let table = |(i, item): (usize, &'a Property)| match &item.value {
            Value::Table(table) => Ok(self.child(format!("{key}[{i}]"), table)),
            _ => Err(wrong()),
        };
        match self.value(key) {
            None => Ok(Vec::new()),
            Some(Value::List(items)) => items.iter().enumerate().map(table).collect(),
            Some(_) => Err(wrong()),
        }
    }

    /// The named tables under `key`, as in `[field.dust]`.
    ///
    /// # Errors
    /// If the value is something else; its place and what would be right are said.
    pub fn named_tables(&self, key: &str) -> Result<Vec<(&'a str, Section<'a>)>> {
        let Some(parent) = self.table(key)? else { return Ok(Vec::new()) };
        let names: Vec<&'a str> = parent.keys();
        names.into_iter().map(|n| Ok((n, parent.table(n)?.ok_or_else(|| parent.wrong(n, "a table"))?))).collect()
    }

    fn child(&self, key: String, table: &'a Table) -> Section<'a> {
        let path = if self.path.is_empty() { key } else { format!("{}.{key}", self.path) };
        Section::new(table, path)
    }
}

/// A number, whole or not.
fn number_of(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        Value::Integer(number) => Some(*number as f64),
        _ => None,
    }
}
