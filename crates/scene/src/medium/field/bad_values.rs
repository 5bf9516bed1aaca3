//! Values of a grid that are no densities.

use rayon::prelude::*;

use super::Grid;
use crate::error::{Error, Result};

/// Values of one kind: how many, and where and what the first of them is.
struct Bad {
    count: usize,
    first: [usize; 3],
    value: f32,
}

impl Grid {
    /// Refuses negative, NaN and infinite values; says how many and where.
    ///
    /// # Errors
    /// If there are some.
    pub fn check(&self, field: &str) -> Result<()> {
        let scaled = |v: f32| (f64::from(v) * self.factor) as f32;
        if !self.store.any(|v| !scaled(v).is_finite() || scaled(v) < 0.0) {
            return Ok(());
        }
        let found = |what, is_bad: fn(f32) -> bool| {
            let bad = self.count(is_bad)?;
            let ([x, y, z], cells) = (bad.first, self.lattice.cells());
            Some(Error::FieldValues { field: field.to_owned(), count: bad.count, what, cells, x, y, z, value: f64::from(bad.value) })
        };
        let wrong = found("cells that are NaN or infinite", |v| !v.is_finite()).or_else(|| found("negative cells", |v| v < 0.0));
        wrong.map_or(Ok(()), Err)
    }

    /// The values that are such.
    fn count(&self, is_such: fn(f32) -> bool) -> Option<Bad> {
        let [nx, ny, nz] = self.lattice.dims;
        let of_row = |row: &mut Vec<f32>, r: usize| {
            row.resize(nx, 0.0);
            self.row(0..nx, r % ny, r / ny, row);
            let first = row.iter().position(|v| is_such(*v))?;
            let count = row.iter().filter(|v| is_such(**v)).count();
            Some(Bad { count, first: [first, r % ny, r / ny], value: row[first] })
        };
        (0..ny * nz).into_par_iter().map_init(Vec::new, of_row).reduce(
            || None,
            |a, b| match (a, b) {
                (Some(a), Some(b)) => Some(Bad { count: a.count + b.count, ..a }),
                (a, b) => a.or(b),
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::grid::linear;

    #[test]
    fn bad_values_are_counted() {
        let grid = linear();
        let mut values = grid.values().into_owned();
        let mut check = |changes: &[(usize, f32)]| {
            changes.iter().for_each(|(i, value)| values[*i] = *value);
            Grid::from_lattice(grid.lattice.clone(), values.clone()).check("dust").unwrap_err().to_string()
        };
        let message = check(&[(5, -1.0), (9, -2.0)]);
        assert!(message.contains("2 negative cells") && message.contains("[5, 0, 0]"), "{message}");
        assert!(check(&[(7, f32::NAN)]).contains("1 cells that are NaN"));
        assert!(grid.scaled(1e38).check("dust").unwrap_err().to_string().contains("infinite"));
    }
}
