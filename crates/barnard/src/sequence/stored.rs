//! Settings of sequences as numbers of a cache.

use spectra::colour::Palette;

use crate::cache::Record;
use crate::image::{Display, ScatteringError, SpatialError, SpatialNumbers, Stepping, SteppingNumbers};
use crate::plan::{Choices, Fineness, RuleTarget};

/// Kind of the records.
pub const KIND: &str = "frames";

/// Stepping, star factor, sampled edge, rules, spatial error.
type Steps = (SteppingNumbers, usize, Option<usize>, (f64, f64), Option<SpatialNumbers>);

/// Choices and display as a record.
pub fn record(choices: &Choices, display: &Display) -> Record {
    let mut numbers = Vec::new();
    let Choices { stepping, star_factor, sampled_edge, rules, spatial, scattered_fineness, scattered: (scattered, far_field) } = choices;
    let spatial = spatial.map(SpatialError::to_numbers);
    (stepping.to_numbers(), *star_factor, *sampled_edge, (rules.accuracy, rules.depth), spatial).put(&mut numbers);
    scattered_fineness.map(|f| (f.cells, (f.directions[0], f.directions[1]), f.degree)).put(&mut numbers);
    (scattered.map(|error| (error.spatial, error.angular)), *far_field).put(&mut numbers);
    display.palette.columns.iter().map(|[r, g, b]| (*r, *g, *b)).collect::<Vec<_>>().put(&mut numbers);
    (display.balance, display.black.radiance(), display.white.radiance()).put(&mut numbers);
    Record { numbers, ..Record::default() }
}

/// Choices and display of a record; `stated` is the display of the first frame.
pub fn settings(record: &Record, stated: &Display) -> Option<(Choices, Display)> {
    let numbers = &mut record.numbers.iter().copied();
    let (stepping, star_factor, sampled_edge, (accuracy, depth), spatial): Steps = Numbers::take(numbers)?;
    let fineness: Option<(usize, (usize, usize), usize)> = Numbers::take(numbers)?;
    let (scattered, far_field): (Option<(f64, f64)>, Option<f64>) = Numbers::take(numbers)?;
    let columns: Vec<(f64, f64, f64)> = Numbers::take(numbers)?;
    let (balance, black, white): (bool, Option<f64>, Option<f64>) = Numbers::take(numbers)?;
    let choices = Choices {
        stepping: Stepping::from_numbers(stepping)?,
        star_factor,
        sampled_edge,
        rules: RuleTarget { accuracy, depth },
        spatial: match spatial {
            Some(numbers) => Some(SpatialError::from_numbers(numbers)?),
            None => None,
        },
        scattered_fineness: fineness.map(|(cells, (first, others), degree)| Fineness { cells, directions: [first, others], degree }),
        scattered: (scattered.map(|(spatial, angular)| ScatteringError { spatial, angular }), far_field),
    };
    let palette = Palette { columns: columns.into_iter().map(|(r, g, b)| [r, g, b]).collect() };
    Some((choices, Display { palette, balance, black: black.into(), white: white.into(), ..stated.clone() }))
}

/// Value that is stored as numbers in a row.
trait Numbers: Sized {
    fn put(&self, numbers: &mut Vec<f64>);
    fn take(numbers: &mut impl Iterator<Item = f64>) -> Option<Self>;
}

impl Numbers for f64 {
    fn put(&self, numbers: &mut Vec<f64>) {
        numbers.push(*self);
    }
    fn take(numbers: &mut impl Iterator<Item = f64>) -> Option<Self> {
        numbers.next()
    }
}

impl Numbers for usize {
    fn put(&self, numbers: &mut Vec<f64>) {
        numbers.push(*self as f64);
    }
    fn take(numbers: &mut impl Iterator<Item = f64>) -> Option<Self> {
        numbers.next().filter(|number| *number >= 0.0 && number.fract() == 0.0).map(|number| number as Self)
    }
}

impl Numbers for bool {
    fn put(&self, numbers: &mut Vec<f64>) {
        usize::from(*self).put(numbers);
    }
    fn take(numbers: &mut impl Iterator<Item = f64>) -> Option<Self> {
        usize::take(numbers).map(|number| number != 0)
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn put(&self, numbers: &mut Vec<f64>) {
        self.is_some().put(numbers);
        self.iter().for_each(|value| value.put(numbers));
    }
    fn take(numbers: &mut impl Iterator<Item = f64>) -> Option<Self> {
        if bool::take(numbers)? { T::take(numbers).map(Some) } else { Some(None) }
    }
}

impl<T: Numbers> Numbers for Vec<T> {
    fn put(&self, numbers: &mut Vec<f64>) {
        self.len().put(numbers);
        self.iter().for_each(|value| value.put(numbers));
    }
    fn take(numbers: &mut impl Iterator<Item = f64>) -> Option<Self> {
        (0..usize::take(numbers)?).map(|_| T::take(numbers)).collect()
    }
}

macro_rules! tuples {
    ($($($name:ident)+;)+) => {$(
        impl<$($name: Numbers),+> Numbers for ($($name,)+) {
            fn put(&self, numbers: &mut Vec<f64>) {
                #[expect(non_snake_case, reason = "the names of the types")]
                let ($($name,)+) = self;
                $($name.put(numbers);)+
            }
            fn take(numbers: &mut impl Iterator<Item = f64>) -> Option<Self> {
                Some(($($name::take(numbers)?,)+))
            }
        }
    )+};
}

tuples! { A B; A B C; A B C D E; }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Level, UnresolvedStars};

    /// A record has every number of its settings, and one that is cut or of another kind gives none.
    #[test]
    fn settings_are_stored_whole() {
        let error = SpatialError {
            stepping: Stepping::Paired(0.75),
            error: 1e-3,
            sampling: Some((2e-4, 96)),
            rays: 128,
            unresolved: Some(UnresolvedStars { error: 0.1, stars: 7 }),
        };
        let choices = Choices {
            stepping: Stepping::Fixed(100),
            star_factor: 2,
            sampled_edge: None,
            rules: RuleTarget { accuracy: 1e-3, depth: 8.25 },
            spatial: Some(error),
            scattered_fineness: Some(Fineness::PREVIEW),
            scattered: (Some(ScatteringError { spatial: 0.01, angular: 0.02 }), None),
        };
        let stated = Display { black: Level::Radiance(1e-9), ..Display::of(&spectra::passband::set("johnson").unwrap()) };
        let display = Display { white: Level::Radiance(3e-7), ..stated.clone() };
        let whole = record(&choices, &display);
        assert_eq!(settings(&whole, &stated), Some((choices, display)));
        for length in 0..whole.numbers.len() {
            assert_eq!(settings(&Record { numbers: whole.numbers[..length].to_vec(), ..Record::default() }, &stated), None, "{length}");
        }
        let mut other = whole.numbers;
        other[0] = 3.0;
        assert_eq!(settings(&Record { numbers: other, ..Record::default() }, &stated), None);
    }
}
