//! The values of an image.

/// Band radiances, bands × height × width [W m⁻² sr⁻¹].
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// The values of a back end in single precision.
    Single(Vec<f32>),
    /// The values of a back end in double precision.
    Double(Vec<f64>),
}

impl Samples {
    /// The value at a position in the array.
    pub fn at(&self, index: usize) -> f64 {
        match self {
            Samples::Single(v) => f64::from(v[index]),
            Samples::Double(v) => v[index],
        }
    }

    /// Adds to the value at a position.
    pub fn add(&mut self, index: usize, value: f64) {
        match self {
            Samples::Single(v) => v[index] += value as f32,
            Samples::Double(v) => v[index] += value,
        }
    }

    /// The number of values.
    pub fn len(&self) -> usize {
        match self {
            Samples::Single(v) => v.len(),
            Samples::Double(v) => v.len(),
        }
    }

    /// True if there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// As many zeros in the same precision.
    pub fn zeroed(&self) -> Self {
        match self {
            Samples::Single(v) => Samples::Single(vec![0.0; v.len()]),
            Samples::Double(v) => Samples::Double(vec![0.0; v.len()]),
        }
    }

    /// Adds as many other values to these.
    pub fn add_all(&mut self, others: &Self) {
        (0..self.len().min(others.len())).for_each(|i| self.add(i, others.at(i)));
    }

    /// Puts other values behind these, in double precision where either is.
    pub fn append(&mut self, others: Self) {
        match (&mut *self, others) {
            (Samples::Single(values), Samples::Single(others)) => values.extend(others),
            (Samples::Double(values), Samples::Double(others)) => values.extend(others),
            (values, others) => {
                let all = (0..values.len()).map(|i| values.at(i)).chain((0..others.len()).map(|i| others.at(i)));
                *self = Samples::Double(all.collect());
            }
        }
    }

    /// Multiplies all values by a factor.
    pub fn scale(&mut self, factor: f64) {
        match self {
            Samples::Single(v) => v.iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32),
            Samples::Double(v) => v.iter_mut().for_each(|v| *v *= factor),
        }
    }

    /// So many values, each from where `from` says: of the first of two arrays, or of the other where it says so.
    pub(crate) fn gathered(first: &Self, other: &Self, count: usize, from: impl Fn(usize) -> (bool, usize)) -> Self {
        match (first, other) {
            (Samples::Single(a), Samples::Single(b)) => {
                Samples::Single((0..count).map(from).map(|(of_other, i)| if of_other { b[i] } else { a[i] }).collect())
            }
            (a, b) => Samples::Double((0..count).map(from).map(|(of_other, i)| if of_other { b.at(i) } else { a.at(i) }).collect()),
        }
    }
}
