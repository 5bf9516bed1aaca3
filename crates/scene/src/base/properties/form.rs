//! Numbers as they stand in a tree: alone, with a unit, in a list.

use super::Value;

/// The form in which numbers stand in a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// A number alone.
    Number,
    /// Numbers in one unit: a quantity or a position.
    Quantity(String),
    /// A list of numbers.
    List,
}

impl Form {
    /// The form of a value, and the numbers in it; none where it has none.
    pub fn of(value: &Value) -> Option<(Self, Vec<f64>)> {
        let number = |value: &Value| match value {
            Value::Number(number) => Some(*number),
            Value::Integer(number) => Some(*number as f64),
            _ => None,
        };
        match value {
            Value::Text(text) => {
                let (first, mut rest) = spectra::units::parts(text)?;
                let mut numbers = vec![first];
                // Word by word, until what follows is the unit, which may begin with a digit: 1/pc.
                loop {
                    rest = rest.trim_start_matches([' ', ',']);
                    let (word, behind) = rest.split_at(rest.find([' ', ',']).unwrap_or(rest.len()));
                    let Ok(number) = word.parse() else { break };
                    numbers.push(number);
                    rest = behind;
                }
                Some((Self::Quantity(rest.to_owned()), numbers))
            }
            Value::Quantity(numbers, unit) => Some((Self::Quantity(unit.clone()), numbers.clone())),
            Value::List(items) => Some((Self::List, items.iter().map(|item| number(&item.value)).collect::<Option<_>>()?)),
            other => Some((Self::Number, vec![number(other)?])),
        }
    }

    /// The value that such numbers, one or more, are.
    pub fn value(&self, numbers: &[f64]) -> Value {
        match self {
            Self::Number => Value::Number(numbers[0]),
            Self::Quantity(unit) => Value::Quantity(numbers.to_vec(), unit.clone()),
            Self::List => Value::List(numbers.iter().map(|v| Value::Number(*v).into()).collect()),
        }
    }
}
