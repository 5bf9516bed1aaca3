//! Light on one grid of squares, gathered by another.

use rayon::prelude::*;

/// A row of squares that gathers what falls on it of another: by square the first that it overlaps, and what parts of those it holds.
struct Overlaps(Vec<(usize, Vec<f64>)>);

impl Overlaps {
    /// `count` squares of an edge, the first of which begins at `first`, over `below` squares of edge one that begin at zero.
    fn new(below: usize, first: f64, edge: f64, count: usize) -> Self {
        let overlaps = |i: usize| {
            let (low, high) = (first + i as f64 * edge, first + (i + 1) as f64 * edge);
            let (from, to) = (low.floor().max(0.0) as usize, (high.ceil().max(0.0) as usize).min(below));
            let part = |k: usize| (high.min(k as f64 + 1.0) - low.max(k as f64)).max(0.0);
            (from.min(to), (from..to).map(part).collect())
        };
        Self((0..count).map(overlaps).collect())
    }
}

/// Squares of an image: how many in a row and a column, how long their edges are and where the first begins, by those of another.
pub(super) struct Squares {
    pub size: [usize; 2],
    pub first: [f64; 2],
    pub edge: f64,
}

impl Squares {
    /// As many squares of an edge around the middle of an image as it holds.
    pub(super) fn within(size: [usize; 2], edge: f64) -> Self {
        let count = size.map(|pixels| (pixels as f64 / edge * (1.0 + 1e-9)).floor() as usize);
        let first = std::array::from_fn(|i| 0.5 * (size[i] as f64 - count[i] as f64 * edge));
        Self { size: count, first, edge }
    }

    /// Resampled values of image pixels: their sum, row by row.
    pub(super) fn gathered(&self, values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
        let across = Overlaps::new(width, self.first[0], self.edge, self.size[0]);
        let down = Overlaps::new(height, self.first[1], self.edge, self.size[1]);
        let sum = |(first, parts): &(usize, Vec<f64>), value: &dyn Fn(usize) -> f64| -> f64 {
            parts.iter().enumerate().map(|(i, part)| part * value(first + i)).sum()
        };
        let rows: Vec<f64> = values
            .par_chunks(width)
            .take(height)
            .flat_map_iter(|row| across.0.iter().map(|weights| sum(weights, &|k| row[k])).collect::<Vec<_>>())
            .collect();
        let columns = self.size[0];
        down.0
            .par_iter()
            .flat_map_iter(|weights| (0..columns).map(|x| sum(weights, &|k| rows[k * columns + x])).collect::<Vec<_>>())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light is neither lost nor made, wherever edges lie, and even light stays even.
    #[test]
    fn light_is_gathered_whole() {
        let (width, height) = (30, 20);
        let values: Vec<f64> = (0..width * height).map(|i| ((i * 37) % 11) as f64).collect();
        for edge in [1.0, 1.5, 2.0, 2.5, 10.0 / 3.0] {
            let squares = Squares::within([width, height], edge);
            let gathered = squares.gathered(&values, [width, height]);
            assert_eq!(gathered.len(), squares.size[0] * squares.size[1]);
            let even = squares.gathered(&vec![2.0; width * height], [width, height]);
            assert!(even.iter().all(|v| (v - 2.0 * edge * edge).abs() < 1e-9), "{edge}");
            if squares.first == [0.0; 2] {
                assert!((gathered.iter().sum::<f64>() - values.iter().sum::<f64>()).abs() < 1e-9, "{edge}");
            }
        }
        // Two by two in the middle of an odd number: halves of the outer ones are left.
        let squares = Squares::within([5, 5], 2.0);
        let point: Vec<f64> = (0..25).map(|i| f64::from(u8::from(i == 12))).collect();
        assert_eq!((squares.first, squares.gathered(&point, [5, 5])), ([0.5; 2], vec![0.25; 4]));
    }
}
