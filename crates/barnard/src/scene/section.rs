//! Tables of a scene file: typed access to their keys, with errors that name file, line, key and what would be right.

use std::ops::{Range, RangeInclusive};

use glam::DVec3;
use spectra::error::nearest;
use spectra::units::{Length, Quantity, short};
use toml_edit::{Item, TableLike, Value};

use crate::error::{Error, Result};
use crate::geometry::Bounds;

/// One key that a table may have: the manual and the check for unknown keys read the same rows.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// What its value is.
    pub kind: &'static str,
    /// What holds when it is left out; nothing for a required key.
    pub default: Option<&'static str>,
    /// One line.
    pub summary: &'static str,
    /// The catalogue that its text is a name of, if any: see [`crate::catalogue`].
    pub catalogue: Option<&'static str>,
}

impl Key {
    /// A key that may be left out.
    pub const fn optional(name: &'static str, kind: &'static str, default: &'static str, summary: &'static str) -> Self {
        Self { name, kind, default: Some(default), summary, catalogue: None }
    }

    /// A key that must be there.
    pub const fn required(name: &'static str, kind: &'static str, summary: &'static str) -> Self {
        Self { name, kind, default: None, summary, catalogue: None }
    }

    /// Its text is a name of a catalogue.
    pub const fn of(self, catalogue: &'static str) -> Self {
        Self { catalogue: Some(catalogue), ..self }
    }
}

/// The text of a scene file and its name.
#[derive(Debug)]
pub struct SceneText {
    /// The name in messages.
    pub file: String,
    /// What stands in it.
    pub text: String,
}

impl SceneText {
    fn line(&self, span: Option<Range<usize>>) -> usize {
        let end = span.map_or(0, |s| s.start).min(self.text.len());
        self.text.as_bytes()[..end].iter().filter(|b| **b == b'\n').count() + 1
    }

    /// The error `message` at `span`.
    pub fn error(&self, span: Option<Range<usize>>, place: impl Into<String>, message: impl Into<String>) -> Error {
        Error::Scene { message: message.into(), file: self.file.clone(), line: self.line(span), place: place.into() }
    }
}

/// What stands in a table, without comments: equal texts say the same.
pub fn said(table: &dyn TableLike) -> String {
    let of = |item: &Item| match (item.as_table_like(), item.as_array_of_tables()) {
        (Some(table), _) => said(table),
        (None, Some(tables)) => tables.iter().map(|t| said(t)).collect(),
        (None, None) => item.as_value().map(|v| v.clone().decorated("", "").to_string()).unwrap_or_default(),
    };
    table.iter().map(|(key, item)| format!("{key:?} = {{{}}} ", of(item))).collect()
}

/// A text in quotes, in one line: breaks are blanks.
pub(super) fn one_line(text: &str) -> String {
    Value::from(text.replace(char::is_control, " ")).to_string()
}

/// Positions beyond this [pc] leave too few digits for a cloud.
const FARTHEST_PC: f64 = 1e9;

/// One table of the file.
#[derive(Clone)]
pub struct Section<'a> {
    source: &'a SceneText,
    table: &'a dyn TableLike,
    span: Option<Range<usize>>,
    path: String,
}

impl<'a> Section<'a> {
    /// The table `table`, called `path`.
    pub fn new(source: &'a SceneText, table: &'a dyn TableLike, span: Option<Range<usize>>, path: impl Into<String>) -> Self {
        Self { source, table, span, path: path.into() }
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

    /// Whether `key` is there.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// What stands in the table, without comments: equal texts say the same.
    pub fn said(&self) -> String {
        said(self.table)
    }

    /// Its values under `keys`, as they would stand in one line of an inline table.
    pub(super) fn inline<'k>(&self, keys: impl Iterator<Item = &'k str>) -> Vec<String> {
        let written = |value: &Value| value.as_str().map_or_else(|| value.clone().decorated("", "").to_string(), one_line);
        keys.filter_map(|key| Some(format!("{key} = {}", written(self.value(key)?)))).collect()
    }

    /// Refuses keys that are not in `known`.
    pub fn check_keys(&self, known: &[&str]) -> Result<()> {
        let Some((key, _)) = self.table.iter().find(|(k, _)| !known.contains(k)) else { return Ok(()) };
        let hint = nearest(key, known.iter().copied()).map(|n| format!(", did you mean \"{n}\"?")).unwrap_or_default();
        Err(self.error(key, format!("unknown key \"{key}\"{hint}; known: {}", known.join(", "))))
    }

    /// Refuses `keys` that nothing would read here, since they go with `partner`.
    pub fn refuse(&self, keys: &[&str], partner: &str) -> Result<()> {
        let Some(key) = keys.iter().find(|k| self.has(k)) else { return Ok(()) };
        Err(self.error(key, format!("\"{key}\" goes with {partner} only and would be ignored here; leave it out")))
    }

    /// The error `message` about `key`.
    pub fn error(&self, key: &str, message: impl Into<String>) -> Error {
        let span = self.table.get_key_value(key).and_then(|(k, item)| k.span().or_else(|| item.span())).or_else(|| self.span.clone());
        let place = if self.path.is_empty() { key.to_owned() } else { format!("[{}] {key}", self.path) };
        self.source.error(span, place, message)
    }

    /// Adds this key's place to an error from elsewhere.
    pub fn wrap<T, E: Into<Error>>(&self, key: &str, result: std::result::Result<T, E>) -> Result<T> {
        result.map_err(|e| match e.into() {
            placed @ (Error::Scene { .. } | Error::Memory { .. } | Error::Interrupted) => placed,
            other => self.error(key, other.to_string()),
        })
    }

    fn value(&self, key: &str) -> Option<&'a Value> {
        self.table.get(key).and_then(Item::as_value)
    }

    fn missing(&self, key: &str, example: &str) -> Error {
        self.error(key, format!("key \"{key}\" is missing; write it like {key} = {example}"))
    }

    fn wrong(&self, key: &str, wanted: &str) -> Error {
        let found = self.table.get(key).map(|i| i.to_string().trim().to_owned()).unwrap_or_default();
        self.error(key, format!("{found} is not {wanted}"))
    }

    /// A text.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>> {
        match self.table.get(key) {
            None => Ok(None),
            Some(item) => item.as_str().map(Some).ok_or_else(|| self.wrong(key, "a text in quotes")),
        }
    }

    /// A text that must be there.
    pub fn need_text(&self, key: &str) -> Result<&'a str> {
        self.text(key)?.ok_or_else(|| self.missing(key, "\"...\""))
    }

    /// One of `choices`.
    pub fn choice(&self, key: &str, choices: &[&'static str]) -> Result<Option<&'static str>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        let found = choices.iter().find(|c| **c == text);
        found.map(|c| Some(*c)).ok_or_else(|| self.wrong(key, &format!("one of {}", choices.join(", "))))
    }

    /// A number within `range`.
    pub fn number(&self, key: &str, range: RangeInclusive<f64>) -> Result<Option<f64>> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        let number = value.as_float().or_else(|| value.as_integer().map(|i| i as f64)).ok_or_else(|| self.wrong(key, "a number"))?;
        if !range.contains(&number) {
            return Err(self.error(key, format!("{} lies outside of {:e} to {:e}", short(number), range.start(), range.end())));
        }
        Ok(Some(number))
    }

    /// An integer within `range`.
    pub fn integer(&self, key: &str, range: RangeInclusive<i64>) -> Result<Option<i64>> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        let number = value.as_integer().ok_or_else(|| self.wrong(key, "an integer"))?;
        if !range.contains(&number) {
            return Err(self.error(key, format!("{number} lies outside of {} to {}", range.start(), range.end())));
        }
        Ok(Some(number))
    }

    /// true or false.
    pub fn flag(&self, key: &str) -> Result<Option<bool>> {
        match self.table.get(key) {
            None => Ok(None),
            Some(item) => item.as_bool().map(Some).ok_or_else(|| self.wrong(key, "true or false")),
        }
    }

    /// A quantity with its unit.
    pub fn quantity<Q: Quantity>(&self, key: &str) -> Result<Option<Q>> {
        if self.has(key) && self.value(key).and_then(Value::as_str).is_none() {
            return Err(self.wrong(key, &format!("a {} with its unit, such as \"{}\"", Q::NAME, Q::EXAMPLE)));
        }
        match self.text(key)? {
            None => Ok(None),
            Some(text) => {
                let quantity = self.wrap(key, Q::parse(text))?;
                if Q::NAME == Length::NAME && quantity.internal().abs() > FARTHEST_PC {
                    return Err(self.error(key, format!("{text} is longer than {FARTHEST_PC:e} pc; bring the scene closer")));
                }
                Ok(Some(quantity))
            }
        }
    }

    /// A quantity that must be there.
    pub fn need<Q: Quantity>(&self, key: &str) -> Result<Q> {
        self.quantity(key)?.ok_or_else(|| self.missing(key, &format!("\"{}\"", Q::EXAMPLE)))
    }

    /// A quantity above zero.
    pub fn positive<Q: Quantity + std::fmt::Display>(&self, key: &str) -> Result<Option<Q>> {
        let quantity = self.quantity::<Q>(key)?;
        if let Some(q) = quantity.filter(|q| q.internal() <= 0.0) {
            return Err(self.error(key, format!("{q} is not above zero; a {} here must be, such as \"{}\"", Q::NAME, Q::EXAMPLE)));
        }
        Ok(quantity)
    }

    /// A quantity above zero that must be there.
    pub fn need_positive<Q: Quantity + std::fmt::Display>(&self, key: &str) -> Result<Q> {
        self.positive(key)?.ok_or_else(|| self.missing(key, &format!("\"{}\"", Q::EXAMPLE)))
    }

    /// A place "x y z unit" [pc].
    pub fn position(&self, key: &str) -> Result<Option<DVec3>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        let words: Vec<&str> = text.split([' ', ',']).filter(|w| !w.is_empty()).collect();
        let wrong = || self.wrong(key, "a position such as \"0.5 0 -2 pc\"");
        let [x, y, z, unit] = words[..] else { return Err(wrong()) };
        let size = Length::unit_size(unit).ok_or_else(|| self.wrong(key, "a position with a unit of length, such as \"0.5 0 -2 pc\""))?;
        let parse = |t: &str| t.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
        let place = size * DVec3::new(parse(x)?, parse(y)?, parse(z)?);
        if place.abs().max_element() > FARTHEST_PC {
            return Err(self.error(key, format!("lies farther than {FARTHEST_PC:e} pc from the origin; bring the scene closer")));
        }
        Ok(Some(place))
    }

    /// A place that must be there.
    pub fn need_position(&self, key: &str) -> Result<DVec3> {
        self.position(key)?.ok_or_else(|| self.missing(key, "\"0 0 0 pc\""))
    }

    /// A box between two corners.
    pub fn bounds(&self, low: &str, high: &str) -> Result<Bounds> {
        let bounds = Bounds { low: self.need_position(low)?, high: self.need_position(high)? };
        if !bounds.low.cmplt(bounds.high).all() {
            return Err(self.error(high, format!("{high} must lie above {low} along every axis")));
        }
        Ok(bounds)
    }

    /// A direction [x, y, z], normalised.
    pub fn direction(&self, key: &str) -> Result<Option<DVec3>> {
        let Some(numbers) = self.numbers(key)? else { return Ok(None) };
        let wrong = || self.wrong(key, "a direction such as [0, 0, 1]");
        let [x, y, z] = numbers[..] else { return Err(wrong()) };
        DVec3::new(x, y, z).try_normalize().map(Some).ok_or_else(wrong)
    }

    /// A list of numbers.
    pub fn numbers(&self, key: &str) -> Result<Option<Vec<f64>>> {
        let Some(item) = self.table.get(key) else { return Ok(None) };
        let wrong = || self.wrong(key, "a list of numbers such as [1, 0.5, 2]");
        let array = item.as_array().ok_or_else(wrong)?;
        let number = |v: &Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64)).filter(|v| v.is_finite());
        array.iter().map(|v| number(v).ok_or_else(wrong)).collect::<Result<Vec<f64>>>().map(Some)
    }

    /// A list of numbers that must be there, written like `example`.
    pub fn need_numbers(&self, key: &str, example: &str) -> Result<Vec<f64>> {
        self.numbers(key)?.ok_or_else(|| self.error(key, format!("key \"{key}\" is missing; write it like {key} = {example}")))
    }

    /// A list of texts; a single text is a list of one.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<&'a str>>> {
        let Some(item) = self.table.get(key) else { return Ok(None) };
        if let Some(text) = item.as_str() {
            return Ok(Some(vec![text]));
        }
        let wrong = || self.wrong(key, "a list of texts such as [\"johnson-B\", \"johnson-V\"]");
        let array = item.as_array().ok_or_else(wrong)?;
        array.iter().map(|v| v.as_str().ok_or_else(wrong)).collect::<Result<Vec<&str>>>().map(Some)
    }

    /// The table under `key`.
    pub fn table(&self, key: &str) -> Result<Option<Section<'a>>> {
        match self.table.get(key) {
            None => Ok(None),
            Some(item) => {
                let table = item.as_table_like().ok_or_else(|| self.wrong(key, "a table"))?;
                Ok(Some(self.child(key.to_owned(), table, item.span())))
            }
        }
    }

    /// The tables under `key`: `[[key]]`, or an array of inline tables.
    pub fn tables(&self, key: &str) -> Result<Vec<Section<'a>>> {
        let Some(item) = self.table.get(key) else { return Ok(Vec::new()) };
        let name = |i: usize| format!("{key}.{}", i + 1);
        if let Some(tables) = item.as_array_of_tables() {
            return Ok(tables.iter().enumerate().map(|(i, t)| self.child(name(i), t, t.span())).collect());
        }
        let wrong = || self.wrong(key, &format!("a list of tables; write [[{key}]]"));
        let array = item.as_array().ok_or_else(wrong)?;
        let inline =
            |(i, v): (usize, &'a Value)| v.as_inline_table().map(|t| self.child(name(i), t as &dyn TableLike, v.span())).ok_or_else(wrong);
        array.iter().enumerate().map(inline).collect()
    }

    /// The named tables under `key`, as in `[field.dust]`.
    pub fn named_tables(&self, key: &str) -> Result<Vec<(&'a str, Section<'a>)>> {
        let Some(parent) = self.table(key)? else { return Ok(Vec::new()) };
        let names: Vec<&'a str> = parent.keys();
        names.into_iter().map(|n| Ok((n, parent.table(n)?.ok_or_else(|| parent.wrong(n, "a table"))?))).collect()
    }

    fn child(&self, key: String, table: &'a dyn TableLike, span: Option<Range<usize>>) -> Section<'a> {
        let path = if self.path.is_empty() { key } else { format!("{}.{key}", self.path) };
        Section::new(self.source, table, span.or_else(|| self.span.clone()), path)
    }
}
