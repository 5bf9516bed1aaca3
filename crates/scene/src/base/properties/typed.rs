//! Typed keys: constants that a table is read with.
//!
//! `Key::quantity::<Temperature>("temperature", "…").range(1.0..=1e9).required()` is read as a `Temperature` in range.

use std::marker::PhantomData;
use std::ops::{Deref, RangeInclusive};

use spectra::units::Quantity;

use super::Table;
use super::key::{Fallback, KeyRow, Literal, Part, Range, Relation, ValueRef};
use super::section::{Named, Section};
use super::values::{
    Choice, Choices, Direction, Entry, Flag, Formula, Integer, NamedTables, Number, Numbers, Path, Position, Quantities, Size, SubTable,
    Tables, Text, Texts, ValueType,
};
use crate::error::{Error, Result};
use crate::geometry::Bounds;

/// Key of a table whose value has the type `T`; `P` says what reading gives without it.
pub struct Key<T, P = Optional> {
    /// The row for parser, manual, editor and Python.
    pub row: KeyRow,
    marker: PhantomData<fn() -> (T, P)>,
}

impl<T, P> Deref for Key<T, P> {
    type Target = KeyRow;
    fn deref(&self) -> &KeyRow {
        &self.row
    }
}

/// Checks a value by the type of its key.
fn validate<T: ValueType>(key: &KeyRow, value: ValueRef, path: &str) -> Result<()> {
    let table = Table::default();
    T::read(&Entry { section: &Section::new(&table, path), key, value }).map(drop)
}

impl<T, P> Named for Key<T, P> {
    fn name(&self) -> &str {
        self.row.name
    }
}

/// Result of reading a key that may be absent.
pub trait Presence {
    /// The result of [`Section::read`] for a value of type `V`.
    type Output<V>;
    /// The value of a key that is there.
    fn present<V>(value: V) -> Self::Output<V>;
    /// The value of a key that is not.
    ///
    /// # Errors
    /// If the key is required.
    fn absent<'a, T: ValueType>(section: &Section<'a>, key: &KeyRow) -> Result<Self::Output<T::Value<'a>>>;
}

/// Reading an absent key gives `None`.
pub enum Optional {}

/// Reading an absent key is an error.
pub enum Required {}

/// Reading an absent key gives its default.
pub enum OrDefault {}

impl Presence for Optional {
    type Output<V> = Option<V>;
    fn present<V>(value: V) -> Option<V> {
        Some(value)
    }
    fn absent<'a, T: ValueType>(_: &Section<'a>, _: &KeyRow) -> Result<Option<T::Value<'a>>> {
        Ok(None)
    }
}

impl Presence for Required {
    type Output<V> = V;
    fn present<V>(value: V) -> V {
        value
    }
    fn absent<'a, T: ValueType>(section: &Section<'a>, key: &KeyRow) -> Result<T::Value<'a>> {
        Err(section.missing(key))
    }
}

impl Presence for OrDefault {
    type Output<V> = V;
    fn present<V>(value: V) -> V {
        value
    }
    fn absent<'a, T: ValueType>(section: &Section<'a>, key: &KeyRow) -> Result<T::Value<'a>> {
        match key.fallback {
            Fallback::Value(literal) => T::read(&Entry { section, key, value: ValueRef::Literal(literal) }),
            _ => Err(section.missing(key)),
        }
    }
}

macro_rules! constructors {
    ($($(#[$doc:meta])* $name:ident: $value:ty $(, $generic:ident: $bound:path)?;)*) => {
        impl Key<()> {$(
            $(#[$doc])*
            pub const fn $name$(<$generic: $bound + 'static>)?(name: &'static str, summary: &'static str) -> Key<$value> {
                Key::<$value>::new(name, summary)
            }
        )*}
    };
}

constructors! {
    /// A text.
    text: Text;
    /// A path of a file.
    path: Path;
    /// An expression of fields.
    formula: Formula;
    /// One of some values by name.
    choice: Choice<C>, C: Choices;
    /// true or false.
    flag: Flag;
    /// An integer.
    integer: Integer<N>, N: TryFrom<i64>;
    /// A number.
    number: Number;
    /// A quantity.
    quantity: Q, Q: Quantity;
    /// A position.
    position: Position;
    /// A direction.
    direction: Direction;
    /// Width and height in pixels.
    size: Size;
    /// A list of numbers.
    numbers: Numbers;
    /// A list of texts, or one text.
    texts: Texts;
    /// A list of quantities.
    quantities: Quantities<Q>, Q: Quantity;
    /// A table.
    table: SubTable;
    /// A list of tables.
    tables: Tables;
    /// Tables by name.
    named_tables: NamedTables;
}

impl<T: ValueType> Key<T> {
    /// The key with a default that a scene writes as a text, for types of several forms.
    pub const fn or(self, text: &'static str) -> Key<T, OrDefault> {
        self.with_default(Literal::Text(text))
    }

    /// A key that may be left out.
    pub const fn new(name: &'static str, summary: &'static str) -> Self {
        let row = KeyRow {
            name,
            value: T::TYPE,
            range: T::RANGE,
            fallback: Fallback::Words("none"),
            relation: Relation::Free,
            catalogue: None,
            example: None,
            parts: None,
            summary,
            validate: validate::<T>,
        };
        Self { row, marker: PhantomData }
    }

    /// The key with words for what holds without it.
    pub const fn otherwise(self, words: &'static str) -> Self {
        Self { row: KeyRow { fallback: Fallback::Words(words), ..self.row }, ..self }
    }

    /// The key, required.
    pub const fn required(self) -> Key<T, Required> {
        Key { row: KeyRow { fallback: Fallback::Required, ..self.row }, marker: PhantomData }
    }

    const fn with_default(self, literal: Literal) -> Key<T, OrDefault> {
        Key { row: KeyRow { fallback: Fallback::Value(literal), ..self.row }, marker: PhantomData }
    }
}

impl<T, P> Key<T, P> {
    /// The key in a relation to others of its table.
    pub const fn relation(self, relation: Relation) -> Self {
        Self { row: KeyRow { relation, ..self.row }, ..self }
    }

    /// The key as one of a group of which a table has exactly one; `group` is the noun of messages.
    pub const fn one_of(self, group: &'static str) -> Self {
        self.relation(Relation::OneOf(group))
    }

    /// The key, which has an effect only together with another.
    pub const fn needs(self, key: &'static str) -> Self {
        self.relation(Relation::Needs(key))
    }

    /// The key, required with another and without effect otherwise.
    pub const fn required_with(self, key: &'static str) -> Self {
        self.relation(Relation::RequiredWith(key))
    }

    /// The key, required for something that other keys or a file decide, in words.
    pub const fn required_for(self, words: &'static str) -> Self {
        self.relation(Relation::RequiredFor(words))
    }

    /// The key, which has an effect only without another.
    pub const fn excludes(self, key: &'static str) -> Self {
        self.relation(Relation::Excludes(key))
    }

    /// The key, whose texts are names of a catalogue.
    pub const fn of(self, catalogue: &'static str) -> Self {
        Self { row: KeyRow { catalogue: Some(catalogue), ..self.row }, ..self }
    }

    /// The key with a value, as TOML, that an editor adds it with.
    pub const fn example(self, example: &'static str) -> Self {
        Self { row: KeyRow { example: Some(example), ..self.row }, ..self }
    }

    /// The key, whose value changes these parts of the scene instead of those of its table.
    pub const fn affects(self, parts: &'static [Part]) -> Self {
        Self { row: KeyRow { parts: Some(parts), ..self.row }, ..self }
    }

    const fn in_range(self, range: Range) -> Self {
        Self { row: KeyRow { range, ..self.row }, ..self }
    }

    const fn between(self, low: f64, high: f64) -> Self {
        self.in_range(Range { low, high, ..Range::ALL })
    }

    /// The key with numbers above zero.
    pub const fn positive(self) -> Self {
        let range = Range { low: 0.0, excludes_low: true, ..self.row.range };
        self.in_range(range)
    }

    /// The key with numbers of at least zero.
    pub const fn not_negative(self) -> Self {
        let range = Range { low: 0.0, excludes_low: false, ..self.row.range };
        self.in_range(range)
    }

    /// The key with numbers of at most `high`, in the internal unit of a quantity.
    pub const fn at_most(self, high: f64) -> Self {
        let range = Range { high, excludes_high: false, ..self.row.range };
        self.in_range(range)
    }

    /// The key with numbers below `high`, in the internal unit of a quantity.
    pub const fn below(self, high: f64) -> Self {
        let range = Range { high, excludes_high: true, ..self.row.range };
        self.in_range(range)
    }

    /// Checks a number that did not come from a table.
    ///
    /// # Errors
    /// If it is out of range; the error names the key.
    pub fn check(&self, number: f64) -> Result<()> {
        match self.row.range_words() {
            _ if self.row.range.contains(number) => Ok(()),
            words => Err(Error::out_of_range(self.row.name, number, words.unwrap_or_else(|| "finite".into()))),
        }
    }
}

impl<P> Key<Numbers, P> {
    /// The key with numbers in a range.
    pub const fn range(self, range: RangeInclusive<f64>) -> Self {
        self.between(*range.start(), *range.end())
    }
}

impl<P> Key<Number, P> {
    /// The key with numbers in a range.
    pub const fn range(self, range: RangeInclusive<f64>) -> Self {
        self.between(*range.start(), *range.end())
    }
}

impl<N: 'static, P> Key<Integer<N>, P> {
    /// The key with integers in a range.
    pub const fn range(self, range: RangeInclusive<i64>) -> Self {
        self.between(*range.start() as f64, *range.end() as f64)
    }
}

impl<Q: Quantity, P> Key<Q, P> {
    /// The key with quantities in a range, in the internal unit.
    pub const fn range(self, range: RangeInclusive<f64>) -> Self {
        self.between(*range.start(), *range.end())
    }
}

impl Key<Number> {
    /// The key with a default.
    pub const fn default(self, number: f64) -> Key<Number, OrDefault> {
        self.with_default(Literal::Number(number))
    }
}

impl<N: TryFrom<i64> + 'static> Key<Integer<N>> {
    /// The key with a default.
    pub const fn default(self, number: i64) -> Key<Integer<N>, OrDefault> {
        self.with_default(Literal::Integer(number))
    }
}

impl Key<Flag> {
    /// The key with a default.
    pub const fn default(self, flag: bool) -> Key<Flag, OrDefault> {
        self.with_default(Literal::Flag(flag))
    }
}

impl Key<Text> {
    /// The key with a default.
    pub const fn default(self, text: &'static str) -> Key<Text, OrDefault> {
        self.with_default(Literal::Text(text))
    }
}

impl Key<Path> {
    /// The key with a default.
    pub const fn default(self, path: &'static str) -> Key<Path, OrDefault> {
        self.with_default(Literal::Text(path))
    }
}

impl<C: Choices> Key<Choice<C>> {
    /// The key with the default of this name.
    pub const fn default(self, name: &'static str) -> Key<Choice<C>, OrDefault> {
        self.with_default(Literal::Text(name))
    }
}

impl<Q: Quantity> Key<Q> {
    /// The key with a default, with its unit.
    pub const fn default(self, text: &'static str) -> Key<Q, OrDefault> {
        self.with_default(Literal::Text(text))
    }
}

impl Key<Position> {
    /// The key with a default, with its unit.
    pub const fn default(self, text: &'static str) -> Key<Position, OrDefault> {
        self.with_default(Literal::Text(text))
    }
}

impl Key<Direction> {
    /// The key with a default.
    pub const fn default(self, components: &'static [f64]) -> Key<Direction, OrDefault> {
        self.with_default(Literal::Numbers(components))
    }
}

impl Key<Size> {
    /// The key with a default.
    pub const fn default(self, size: &'static [f64; 2]) -> Key<Size, OrDefault> {
        self.with_default(Literal::Numbers(size))
    }
}

impl Key<Texts> {
    /// The key with a default.
    pub const fn default(self, texts: &'static [&'static str]) -> Key<Texts, OrDefault> {
        self.with_default(Literal::Texts(texts))
    }
}

impl<Q: Quantity> Key<Quantities<Q>> {
    /// The key with a default, with units.
    pub const fn default(self, texts: &'static [&'static str]) -> Key<Quantities<Q>, OrDefault> {
        self.with_default(Literal::Texts(texts))
    }
}

impl<'a> Section<'a> {
    /// The value of a key: an option, the value, or the default, as the key declares.
    ///
    /// # Errors
    /// If a required key is missing, or a value has the wrong type or is out of range; place and remedy are stated.
    pub fn read<T: ValueType, P: Presence>(&self, key: &Key<T, P>) -> Result<P::Output<T::Value<'a>>> {
        self.stated(key)?.map_or_else(|| P::absent::<T>(self, &key.row), |value| Ok(P::present(value)))
    }

    /// The value of a key where it is required, whatever the key declares.
    ///
    /// # Errors
    /// If it is missing, has the wrong type or is out of range.
    pub fn need<T: ValueType, P>(&self, key: &Key<T, P>) -> Result<T::Value<'a>> {
        self.stated(key)?.ok_or_else(|| self.missing(&key.row))
    }

    /// The value of a key if the table has it, whatever the key declares.
    ///
    /// # Errors
    /// If the value has the wrong type or is out of range.
    pub fn stated<T: ValueType, P>(&self, key: &Key<T, P>) -> Result<Option<T::Value<'a>>> {
        let value = self.properties().get(key.row.name).map(|property| ValueRef::Given(&property.value));
        value.map(|value| T::read(&Entry { section: self, key: &key.row, value })).transpose()
    }

    /// A box between two corners.
    ///
    /// # Errors
    /// If a corner is missing or wrong, or the box is empty.
    pub fn bounds<P>(&self, low: &Key<Position, P>, high: &Key<Position, P>) -> Result<Bounds> {
        let bounds = Bounds { low: self.need(low)?, high: self.need(high)? };
        if !bounds.low.cmplt(bounds.high).all() {
            return Err(self.error(high, format!("{} must exceed {} along every axis", high.row.name, low.row.name)));
        }
        Ok(bounds)
    }

    /// The table called `key`, if any.
    ///
    /// # Errors
    /// If the value is not a table.
    pub fn table(&self, key: &'static str) -> Result<Option<Section<'a>>> {
        self.read(&Key::<SubTable>::new(key, ""))
    }

    /// The tables of the list `key`.
    ///
    /// # Errors
    /// If the value is not a list of tables.
    pub fn tables(&self, key: &'static str) -> Result<Vec<Section<'a>>> {
        Ok(self.read(&Key::<Tables>::new(key, ""))?.unwrap_or_default())
    }

    /// The named tables under `key`, as in `[field.dust]`.
    ///
    /// # Errors
    /// If one of the values is not a table.
    pub fn named_tables(&self, key: &'static str) -> Result<Vec<(&'a str, Section<'a>)>> {
        Ok(self.read(&Key::<NamedTables>::new(key, ""))?.unwrap_or_default())
    }
}
