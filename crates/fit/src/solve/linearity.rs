//! Parameters on which predictions depend linearly.

use super::LARGER;
use super::LINEAR;
use super::ROUNDED;
use super::TRIED;
use super::largest;
use barnard::error::Error;
use barnard::error::Result;

use super::{Fitting, Prediction};

/// The model a step of a parameter aside, and two.
struct Tried {
    step: f64,
    one: Vec<f64>,
    two: Vec<f64>,
}

impl Fitting<'_> {
    /// The model a step of a parameter aside, and two.
    fn tried(&mut self, i: usize, values: &[f64], step: f64) -> Result<Tried> {
        let asked = self.aside(step, |search, step| {
            let moved =
                |by: f64| values.iter().enumerate().map(|(j, value)| if i == j { value + by } else { *value }).collect::<Vec<f64>>();
            Ok((search.mean(&moved(step))?, search.mean(&moved(2.0 * step))?))
        });
        asked.map(|(step, (one, two))| Tried { step, one, two })
    }

    /// Which parameters the model is linear in, all of them together.
    pub(super) fn classified(&mut self, values: &[f64], first: &Prediction) -> Result<Vec<bool>> {
        let count = self.parameters.len();
        let brightest = largest(&first.mean);
        let mut linear = vec![false; count];
        let (mut changes, mut steps): (Vec<Vec<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
        for i in 0..count {
            let mut tried = self.tried(i, values, self.step(i, values[i], TRIED))?;
            let differences = |one: &[f64]| one.iter().zip(&first.mean).map(|(a, b)| a - b).collect::<Vec<f64>>();
            let mut change = differences(&tried.one);
            // What is too small to be seen may be seen where it is more.
            for more in LARGER {
                let larger = more * self.step(i, values[i], TRIED);
                let (low, high) = self.parameters[i].bounds;
                if largest(&change) > ROUNDED * brightest || !(low..=high).contains(&(values[i] + 2.0 * larger)) {
                    break;
                }
                match self.tried(i, values, larger) {
                    Err(Error::Interrupted) => return Err(Error::Interrupted),
                    Err(_) => break,
                    Ok(larger) => tried = larger,
                }
                change = differences(&tried.one);
                self.reference[i] = values[i] + tried.step;
            }
            steps.push(tried.step);
            let largest = largest(&change);
            if largest <= ROUNDED * brightest {
                let problem = format!("the data do not depend on free parameter {}", self.parameters[i].key);
                return Err(Error::conflict(problem, "leave it out"));
            }
            let bends = tried.two.iter().zip(&first.mean).zip(&change).map(|((two, first), slope)| (two - first - 2.0 * slope).abs());
            linear[i] = bends.fold(0.0, f64::max) <= LINEAR * largest + ROUNDED * brightest;
            changes.push(change);
            if self.parameters[i].bounds.0 == f64::NEG_INFINITY && !self.can_be_negative(i, values)? {
                self.parameters[i].bounds.0 = 0.0;
            }
        }
        for i in 0..count {
            for j in (0..i).filter(|j| linear[*j]).collect::<Vec<_>>() {
                if !linear[i] {
                    break;
                }
                let mut both = values.to_vec();
                (both[i], both[j]) = (values[i] + steps[i], values[j] + steps[j]);
                let both = self.mean(&both)?;
                let least = largest(&changes[i]).min(largest(&changes[j]));
                let mixed = both
                    .iter()
                    .zip(&first.mean)
                    .zip(changes[i].iter().zip(&changes[j]))
                    .map(|((both, first), (a, b))| (both - first - a - b).abs());
                linear[i] = mixed.fold(0.0, f64::max) <= LINEAR * TRIED * least + ROUNDED * brightest;
            }
        }
        Ok(linear)
    }

    /// True if the model takes a parameter below zero.
    fn can_be_negative(&mut self, i: usize, values: &[f64]) -> Result<bool> {
        let mut below = values.to_vec();
        below[i] = -self.scale(i, values[i]);
        match self.predict(&below) {
            Ok(_) => Ok(true),
            Err(Error::Interrupted) => Err(Error::Interrupted),
            Err(_) => Ok(false),
        }
    }
}
