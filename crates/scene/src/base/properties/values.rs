//! Types of values: how a key's value is checked and what reading it returns.

use std::marker::PhantomData;

use glam::DVec3;
use spectra::error::article;
use spectra::units::{Length, Quantity, QuantityRow};

use super::key::{KeyRow, Literal, Range, Type, ValueRef};
use super::{Property, Section, Table, Value};
use crate::error::{Error, Result};

/// Positions and lengths beyond this [pc] leave too few digits for a cloud.
const FARTHEST_PC: f64 = 1e9;

/// Type of a key's value.
pub trait ValueType {
    /// The type for manual, editor and Python.
    const TYPE: Type;
    /// Numbers that are allowed unless the key restricts them.
    const RANGE: Range = Range::ALL;
    /// The value that reading returns.
    type Value<'a>;
    /// Reads a value.
    ///
    /// # Errors
    /// If it has another type, or is out of the key's range; place and remedy are stated.
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Self::Value<'a>>;
}

/// A key of a table and its value.
pub struct Entry<'a, 'k> {
    /// The table.
    pub section: &'k Section<'a>,
    /// The key.
    pub key: &'k KeyRow,
    /// The value.
    pub value: ValueRef<'a>,
}

impl<'a> Entry<'a, '_> {
    /// An error about the value.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.section.error(self.key, message)
    }

    /// The error that the value has another type; `expected` follows "expected".
    pub fn wrong(&self, expected: &str) -> Error {
        let found = match self.value {
            ValueRef::Given(value) => value.to_string(),
            ValueRef::Literal(literal) => literal.to_string(),
        };
        self.error(format!("found {found}; expected {expected}"))
    }

    fn text(&self) -> Result<&'a str> {
        self.value.text().ok_or_else(|| self.wrong("a text in quotes"))
    }

    /// The number, if it is in the key's range.
    fn in_range(&self, number: f64) -> Result<f64> {
        if self.key.range.contains(number) {
            return Ok(number);
        }
        let allowed = self.key.range_words().unwrap_or_else(|| "finite".into());
        Err(self.error(format!("{} is out of range; it must be {allowed}", self.key.number_words(number))))
    }

    /// A quantity in the key's range.
    fn quantity<Q: Quantity>(&self) -> Result<Q> {
        let wrong = || self.wrong(&format!("{} {} with its unit, such as \"{}\"", article(Q::NAME), Q::NAME, Q::EXAMPLE));
        let quantity = match self.value {
            ValueRef::Given(Value::Quantity(numbers, unit)) => match numbers[..] {
                [number] => self.section.wrap(self.key, Q::in_unit(number, unit))?,
                _ => return Err(wrong()),
            },
            other => self.section.wrap(self.key, Q::parse(other.text().ok_or_else(wrong)?))?,
        };
        let is_length = Q::NAME == Length::NAME;
        if is_length && quantity.internal().abs() > FARTHEST_PC {
            return Err(
                self.error(format!("{} exceeds {FARTHEST_PC:e} pc; move the scene closer", self.key.number_words(quantity.internal())))
            );
        }
        self.in_range(quantity.internal()).map(|_| quantity)
    }
}

impl<Q: Quantity> ValueType for Q {
    const TYPE: Type = Type::Quantity(Q::NAME, &[QuantityRow::of::<Q>()]);
    type Value<'a> = Q;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Q> {
        entry.quantity()
    }
}

/// Any text.
pub enum Text {}

/// Path of a file, relative to the scene.
pub enum Path {}

/// Expression of fields.
pub enum Formula {}

macro_rules! text_type {
    ($($name:ident: $kind:expr),*) => {$(
        impl ValueType for $name {
            const TYPE: Type = $kind;
            type Value<'a> = &'a str;
            fn read<'a>(entry: &Entry<'a, '_>) -> Result<&'a str> {
                entry.text()
            }
        }
    )*};
}

text_type!(Text: Type::Text, Path: Type::Path, Formula: Type::Expression);

/// Values that scenes choose by name.
pub trait Choices: Copy + 'static {
    /// Names and values.
    const ROWS: &'static [(&'static str, Self)];
}

/// One of some values by name.
pub struct Choice<C>(PhantomData<C>);

fn names<C: Choices>() -> Vec<&'static str> {
    C::ROWS.iter().map(|(name, _)| *name).collect()
}

impl<C: Choices> ValueType for Choice<C> {
    const TYPE: Type = Type::Choice(names::<C>);
    type Value<'a> = C;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<C> {
        let text = entry.text()?;
        let found = C::ROWS.iter().find(|(name, _)| *name == text).map(|(_, value)| *value);
        found.ok_or_else(|| entry.wrong(&format!("one of {}", names::<C>().join(", "))))
    }
}

/// true or false.
pub enum Flag {}

impl ValueType for Flag {
    const TYPE: Type = Type::Flag;
    type Value<'a> = bool;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<bool> {
        match entry.value {
            ValueRef::Given(Value::Flag(flag)) => Ok(*flag),
            ValueRef::Literal(Literal::Flag(flag)) => Ok(flag),
            _ => Err(entry.wrong("true or false")),
        }
    }
}

/// Finite number.
pub enum Number {}

impl ValueType for Number {
    const TYPE: Type = Type::Number;
    type Value<'a> = f64;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<f64> {
        entry.in_range(entry.value.number().ok_or_else(|| entry.wrong("a number"))?)
    }
}

/// Integer that an `N` can hold.
pub struct Integer<N>(PhantomData<N>);

impl<N: TryFrom<i64> + 'static> ValueType for Integer<N> {
    const TYPE: Type = Type::Integer;
    type Value<'a> = N;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<N> {
        let number = entry.value.integer().ok_or_else(|| entry.wrong("an integer"))?;
        entry.in_range(number as f64)?;
        N::try_from(number).map_err(|_| entry.error(format!("{number} is out of range; it must be at least zero and smaller")))
    }
}

/// Position \[pc\]: three numbers and a unit in a text.
pub enum Position {}

impl ValueType for Position {
    const TYPE: Type = Type::Position;
    type Value<'a> = DVec3;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<DVec3> {
        let wrong = || entry.wrong("a position such as \"0.5 0 -2 pc\"");
        let (numbers, unit) = match entry.value {
            ValueRef::Given(Value::Quantity(numbers, unit)) => (numbers.clone(), unit.as_str()),
            other => position_parts(entry, other.text().ok_or_else(wrong)?)?,
        };
        let size = Length::unit_size(unit).ok_or_else(|| entry.wrong("a position with a unit of length, such as \"0.5 0 -2 pc\""))?;
        let &[x, y, z] = &numbers[..] else { return Err(wrong()) };
        let place = size * DVec3::new(x, y, z);
        if !place.is_finite() {
            return Err(wrong());
        }
        if place.abs().max_element() > FARTHEST_PC {
            return Err(entry.error(format!("is farther than {FARTHEST_PC:e} pc from the origin; move the scene closer")));
        }
        Ok(place)
    }
}

/// Numbers and unit of "x y z unit".
fn position_parts<'t>(entry: &Entry, text: &'t str) -> Result<(Vec<f64>, &'t str)> {
    let words: Vec<&str> = text.split([' ', ',']).filter(|word| !word.is_empty()).collect();
    let numbers: Vec<f64> = words.iter().map_while(|word| word.parse().ok()).collect();
    match words.get(3) {
        Some(unit) if numbers.len() == 3 && words.len() == 4 => Ok((numbers, unit)),
        None if numbers.len() == 3 => {
            Err(entry.error(format!("position \"{text}\" has no unit; write \"{text} pc\", or another unit of length")))
        }
        _ => Err(entry.wrong("a position such as \"0.5 0 -2 pc\"")),
    }
}

/// Unit vector, from a list of three numbers.
pub enum Direction {}

impl ValueType for Direction {
    const TYPE: Type = Type::Direction;
    type Value<'a> = DVec3;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<DVec3> {
        let numbers = entry.value.numbers();
        let direction = numbers.and_then(|numbers| DVec3::from_array(numbers.try_into().ok()?).try_normalize());
        direction.ok_or_else(|| entry.wrong("a direction such as [0, 0, 1]"))
    }
}

/// List of finite numbers.
pub enum Numbers {}

impl ValueType for Numbers {
    const TYPE: Type = Type::Numbers;
    type Value<'a> = Vec<f64>;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Vec<f64>> {
        let numbers = entry.value.numbers().ok_or_else(|| entry.wrong("a list of numbers such as [1, 0.5, 2]"))?;
        numbers.iter().try_for_each(|number| entry.in_range(*number).map(drop))?;
        Ok(numbers)
    }
}

/// List of texts; one text is a list of one.
pub enum Texts {}

impl ValueType for Texts {
    const TYPE: Type = Type::Texts;
    type Value<'a> = Vec<&'a str>;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Vec<&'a str>> {
        let text = |item: &'a Property| match &item.value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        };
        let texts = match entry.value {
            ValueRef::Given(Value::List(items)) => items.iter().map(text).collect(),
            ValueRef::Literal(Literal::Texts(texts)) => Some(texts.to_vec()),
            other => other.text().map(|text| vec![text]),
        };
        texts.ok_or_else(|| {
            entry.wrong(&format!("a list of texts such as {}", entry.key.example.unwrap_or("[\"johnson-B\", \"johnson-V\"]")))
        })
    }
}

/// List of quantities; one quantity is a list of one.
pub struct Quantities<Q>(PhantomData<Q>);

impl<Q: Quantity> ValueType for Quantities<Q> {
    const TYPE: Type = Type::Quantities(&QuantityRow::of::<Q>());
    type Value<'a> = Vec<Q>;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Vec<Q>> {
        let one = |value| Entry { value, section: entry.section, key: entry.key }.quantity::<Q>();
        match entry.value {
            ValueRef::Given(Value::List(items)) => items.iter().map(|item| one(ValueRef::Given(&item.value))).collect(),
            ValueRef::Given(Value::Quantity(numbers, unit)) => {
                let single = |number: &f64| {
                    let value = Value::Quantity(vec![*number], unit.clone());
                    Entry { value: ValueRef::Given(&value), section: entry.section, key: entry.key }.quantity()
                };
                numbers.iter().map(single).collect()
            }
            ValueRef::Literal(Literal::Texts(texts)) => texts.iter().map(|text| one(ValueRef::Literal(Literal::Text(text)))).collect(),
            other => Ok(vec![one(other)?]),
        }
    }
}

/// Width and height in pixels.
pub enum Size {}

impl ValueType for Size {
    const TYPE: Type = Type::Size;
    type Value<'a> = [usize; 2];
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<[usize; 2]> {
        let wrong = || entry.error("a size is [width, height] in pixels, such as [512, 512]");
        let &[width, height] = &entry.value.numbers().ok_or_else(wrong)?[..] else { return Err(wrong()) };
        if width.fract() != 0.0 || height.fract() != 0.0 || !entry.key.range.contains(width) || !entry.key.range.contains(height) {
            let most = entry.key.range.high;
            return Err(
                entry.error(format!("a size of {width} x {height} pixels is out of range; both must be whole numbers from 1 to {most}"))
            );
        }
        Ok([width as usize, height as usize])
    }
}

/// Table.
pub enum SubTable {}

impl ValueType for SubTable {
    const TYPE: Type = Type::Table;
    type Value<'a> = Section<'a>;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Section<'a>> {
        match entry.value {
            ValueRef::Given(Value::Table(table)) => Ok(entry.section.child(entry.key.name.to_owned(), table)),
            _ => Err(entry.wrong("a table")),
        }
    }
}

/// List of tables.
pub enum Tables {}

impl ValueType for Tables {
    const TYPE: Type = Type::Tables;
    type Value<'a> = Vec<Section<'a>>;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Vec<Section<'a>>> {
        let name = entry.key.name;
        let wrong = || entry.wrong(&format!("a list of tables; write [[{name}]]"));
        let ValueRef::Given(Value::List(items)) = entry.value else { return Err(wrong()) };
        let table = |(i, item): (usize, &'a Property)| match &item.value {
            Value::Table(table) => Ok(entry.section.child(format!("{name}[{i}]"), table)),
            _ => Err(wrong()),
        };
        items.iter().enumerate().map(table).collect()
    }
}

/// Tables by name, as in `[field.dust]`.
pub enum NamedTables {}

impl ValueType for NamedTables {
    const TYPE: Type = Type::NamedTables;
    type Value<'a> = Vec<(&'a str, Section<'a>)>;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Self::Value<'a>> {
        let parent = SubTable::read(entry)?;
        let table: &'a Table = parent.properties();
        let child = |(name, property): (&'a str, &'a Property)| match &property.value {
            Value::Table(table) => Ok((name, parent.child(name.to_owned(), table))),
            _ => Err(parent.error(name, format!("found {}; expected a table", property.value))),
        };
        table.iter().map(child).collect()
    }
}
