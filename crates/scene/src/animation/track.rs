//! Tracks: one value of a scene that changes from moment to moment.

use super::curve::{Curve, Interpolation};
use crate::properties::{Form, Value};

/// Values of a scene key over time.
#[derive(Debug, Clone, PartialEq)]
pub enum Track {
    /// Numbers that go from key to key.
    Numbers(Numbers),
    /// Values that hold until the next key, by the moments \[s\] from which on they do.
    Said(Vec<(f64, Value)>),
}

/// Numbers on a curve, in the form in which they stand in the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbers {
    form: Form,
    curve: Curve,
}

impl Track {
    /// The track that has these values at ascending moments \[s\].
    ///
    /// # Errors
    /// In words, if values have no numbers to go between, or differ in their unit or number.
    pub fn new(keys: Vec<(f64, Value)>, interpolation: Interpolation) -> Result<Self, String> {
        let Some((_, first)) = keys.first() else { return Err("a track must have at least one key".into()) };
        if interpolation == Interpolation::Step {
            return Ok(Self::Said(keys));
        }
        let between = |value: &Value| format!("{value} has no numbers to interpolate; use interpolation = \"step\"");
        let (form, _) = Form::of(first).ok_or_else(|| between(first))?;
        let mut values = Vec::new();
        let count = Form::of(first).map_or(0, |(_, numbers)| numbers.len());
        for (_, value) in &keys {
            let (form_of_value, numbers) = Form::of(value).ok_or_else(|| between(value))?;
            if form_of_value != form || numbers.len() != count {
                return Err(format!("{first} and {value} cannot be interpolated; write all keys in the same form and unit"));
            }
            if let Some(wrong) = numbers.iter().find(|v| !v.is_finite()) {
                return Err(format!("{wrong} is not a valid value of a key"));
            }
            values.extend(numbers);
        }
        let times = keys.iter().map(|(time, _)| *time).collect();
        Ok(Self::Numbers(Numbers { form, curve: Curve::new(times, values, interpolation) }))
    }

    /// The moment of its last key \[s\].
    pub fn end(&self) -> f64 {
        self.times().last().copied().unwrap_or(0.0)
    }

    /// The moments of its keys \[s\].
    pub fn times(&self) -> Vec<f64> {
        match self {
            Self::Numbers(numbers) => numbers.curve.times().to_vec(),
            Self::Said(keys) => keys.iter().map(|(time, _)| *time).collect(),
        }
    }

    /// The numbers of the value at a moment \[s\], in its stated unit; none if it has no numbers.
    pub fn numbers(&self, time: f64) -> Option<Vec<f64>> {
        match self {
            Self::Numbers(numbers) => Some(numbers.curve.at(time)),
            Self::Said(_) => Form::of(&self.at(time)).map(|(_, numbers)| numbers),
        }
    }

    /// The unit of its numbers, as the scene writes it; nothing where they have none.
    pub fn unit(&self) -> &str {
        match self {
            Self::Numbers(Numbers { form: Form::Quantity(unit), .. }) => unit,
            _ => "",
        }
    }

    /// The value at a moment \[s\].
    pub fn at(&self, time: f64) -> Value {
        match self {
            Self::Numbers(Numbers { form, curve }) => form.value(&curve.at(time)),
            Self::Said(keys) => {
                let after = keys.partition_point(|(from, _)| *from <= time);
                keys[after.saturating_sub(1)].1.clone()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(words: &str) -> Value {
        Value::Text(words.into())
    }

    fn quantity(numbers: &[f64], unit: &str) -> Value {
        Value::Quantity(numbers.to_vec(), unit.into())
    }

    /// Numbers go from key to key in whatever form they stand; what has none holds.
    #[test]
    fn values_of_all_forms() {
        let half = |a: Value, b: Value| Track::new(vec![(0.0, a), (2.0, b)], Interpolation::Linear).map(|track| track.at(1.0));
        assert_eq!(half(text("5000 K"), text("9000K")).unwrap(), quantity(&[7000.0], "K"));
        assert_eq!(half(text("0 0 5 pc"), text("1, -1, 2.5 pc")).unwrap(), quantity(&[0.5, -0.5, 3.75], "pc"));
        assert_eq!(half(text("2 1/pc"), text("3 1/pc")).unwrap(), quantity(&[2.5], "1/pc"));
        assert_eq!(half(Value::Integer(1), Value::Number(2.0)).unwrap(), Value::Number(1.5));
        let list = |values: [f64; 2]| Value::List(values.map(|v| Value::Number(v).into()).to_vec());
        assert_eq!(half(list([0.0, 1.0]), list([1.0, 3.0])).unwrap(), list([0.5, 2.0]));
        for (a, b, words) in [
            (text("1 pc"), text("1 ly"), "same form and unit"),
            (text("1 pc"), text("1 2 pc"), "cannot be interpolated"),
            (text("ccm89"), text("ccm89"), "no numbers to interpolate"),
            (Value::Number(f64::NAN), Value::Number(1.0), "NaN"),
        ] {
            let error = half(a, b).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
        let step_track = Track::new(vec![(0.0, text("ccm89")), (1.0, Value::Flag(true))], Interpolation::Step).unwrap();
        assert_eq!((step_track.at(0.9), step_track.at(1.0), step_track.at(-1.0)), (text("ccm89"), Value::Flag(true), text("ccm89")));
        assert_eq!((step_track.times(), step_track.end(), step_track.numbers(0.5)), (vec![0.0, 1.0], 1.0, None));
        let moved = Track::new(vec![(0.0, text("0 0 5 pc")), (2.0, text("1 2 3 pc"))], Interpolation::Linear).unwrap();
        assert_eq!((moved.times(), moved.numbers(1.0)), (vec![0.0, 2.0], Some(vec![0.5, 1.0, 4.0])));
        assert_eq!(moved.unit(), "pc");
    }
}
