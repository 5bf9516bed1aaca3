//! Few terms that stand for many: transport changes smoothly with extinction, albedo, phase function and spectrum, so the
//! source function of each term is nearly a sum of those of a few.
//!
//!   S_t ≈ Σ_j c_tj S_j
//!
//! All terms are solved on a coarse lattice. Those that are solved in full are chosen there one after the other, each time
//! the one that differs most from sums of those before (Gram–Schmidt with pivots, an interpolative decomposition), until
//! all others are within the allowed error. Source: Cheng et al. 2005, SIAM J. Sci. Comput. 26, 1389. The error on the
//! coarse lattice stands for that on the fine one; it does not depend on places.

use std::sync::Arc;

use rayon::prelude::*;

use super::cells::SweepCells;
use super::lanes::{EightLanes, WIDTH};
use super::solved::Solved;
use super::term::scattering;

/// Terms up to which all are solved in full.
const FEW: usize = 2;

/// The terms that are solved, and all others as sums of them.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// Numbers of the terms that are solved.
    pub solved: Vec<usize>,
    /// Coefficients c of every term: term × solved term.
    pub coefficients: Vec<Vec<f32>>,
    /// Allowed rms error of a term on the coarse lattice, relative to its rms \[1\].
    pub allowed: f64,
    /// The coarse solutions of all terms from which this was found, eight by eight; none where all terms are solved.
    pub coarse: Vec<Arc<Solved>>,
}

impl Reduction {
    /// All of a given number of terms.
    pub fn none(terms: usize) -> Self {
        let unit = |t: usize| (0..terms).map(|j| f32::from(u8::from(j == t))).collect();
        Self { solved: (0..terms).collect(), coefficients: (0..terms).map(unit).collect(), allowed: 0.0, coarse: Vec::new() }
    }

    /// True if there are so few terms that all are solved.
    pub fn is_needless(terms: usize) -> bool {
        terms <= FEW
    }

    /// The coefficients of up to eight terms from number `first` on: solved term × term.
    pub fn shares(&self, first: usize, count: usize) -> Vec<EightLanes> {
        let share = |j| std::array::from_fn(|t| if t < count { self.coefficients[first + t][j] } else { 0.0 });
        (0..self.solved.len()).map(share).collect()
    }

    /// The terms whose sums are all terms of some coarse solutions within a relative error.
    pub fn new(coarse: Vec<Arc<Solved>>, cells: &SweepCells, allowed: f64) -> Self {
        let columns: Vec<Vec<f32>> = coarse.iter().flat_map(|solved| sources(solved, cells)).collect();
        Self { coarse, ..decomposed(columns, allowed) }
    }
}

/// The scattered moments of each term, cell × harmonic, as they weigh in the dust.
fn sources(solved: &Solved, cells: &SweepCells) -> Vec<Vec<f32>> {
    let scattered = scattering(&solved.origin.terms);
    let harmonics = solved.moments.count;
    let column = |t: usize| {
        let cell = |(moments, sigma): (&[[f32; WIDTH]], &f32)| {
            let weight = sigma.sqrt();
            let values: Vec<f32> = moments.iter().zip(&scattered).map(|(m, s)| weight * s[t] * m[t]).collect();
            values
        };
        solved.moments.data.chunks_exact(harmonics).zip(&cells.sigma).flat_map(cell).collect()
    };
    (0..solved.origin.terms.len()).map(column).collect()
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

/// Takes `part` of `direction` from a column.
fn subtract(column: &mut [f32], part: f64, direction: &[f32]) {
    column.iter_mut().zip(direction).for_each(|(c, d)| *c = (f64::from(*c) - part * f64::from(*d)) as f32);
}

/// Columns as sums of few of them.
fn decomposed(mut columns: Vec<Vec<f32>>, allowed: f64) -> Reduction {
    let norms: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt()).collect();
    columns.par_iter_mut().zip(&norms).for_each(|(column, norm)| {
        let unit = if *norm > 0.0 { 1.0 / norm } else { 0.0 };
        column.iter_mut().for_each(|value| *value = (f64::from(*value) * unit) as f32);
    });
    let mut solved: Vec<usize> = Vec::new();
    // Parts of each column along the directions so far, column × direction.
    let mut parts = vec![Vec::new(); columns.len()];
    let mut left: Vec<f64> = norms.iter().map(|norm| if *norm > 0.0 { 1.0 } else { 0.0 }).collect();
    loop {
        // The first of equals, and none twice.
        let worst = (0..columns.len()).filter(|t| !solved.contains(t)).reduce(|a, b| if left[b] > left[a] { b } else { a });
        let Some(pivot) = worst.filter(|t| left[*t] > allowed.max(f64::MIN_POSITIVE)) else { break };
        let norm = left[pivot];
        let direction: Vec<f32> = columns[pivot].iter().map(|value| (f64::from(*value) / norm) as f32).collect();
        columns.par_iter_mut().zip(&mut parts).zip(&mut left).for_each(|((column, parts), left)| {
            let part = dot(column, &direction);
            subtract(column, part, &direction);
            parts.push(part);
            *left = dot(column, column).sqrt();
        });
        solved.push(pivot);
    }
    let coefficients = (0..norms.len()).map(|t| substituted(&parts, &solved, &norms, t)).collect();
    Reduction { solved, coefficients, allowed, coarse: Vec::new() }
}

/// The coefficients of column `t`: back substitution through the parts of the chosen columns, which are triangular.
fn substituted(parts: &[Vec<f64>], solved: &[usize], norms: &[f64], t: usize) -> Vec<f32> {
    let mut coefficients = vec![0.0; solved.len()];
    if let Some(position) = solved.iter().position(|s| *s == t) {
        coefficients[position] = 1.0;
    } else {
        for j in (0..solved.len()).rev() {
            let later: f64 = (j + 1..solved.len()).map(|i| parts[solved[i]][j] * coefficients[i]).sum();
            coefficients[j] = (parts[t][j] - later) / parts[solved[j]][j];
        }
        // Columns had been made as long as each other.
        coefficients.iter_mut().zip(solved).for_each(|(c, s)| *c *= norms[t] / norms[*s]);
    }
    coefficients.into_iter().map(|c| c as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten polynomials of degree two are sums of three of them; columns of nothing take none; where more error is
    /// allowed fewer are taken.
    #[test]
    fn sums_of_few_are_found() {
        let place = |i: usize| i as f32 / 40.0;
        let column = |t: usize| {
            let (a, b, c) = ((t as f32 * 0.7).sin(), (t as f32 * 1.3).cos(), 0.3 * (t as f32 * 2.1).sin());
            (0..40).map(|i| if t == 4 { 0.0 } else { 5.0 * (t + 1) as f32 * (a + b * place(i) + c * place(i).powi(2)) }).collect()
        };
        let columns: Vec<Vec<f32>> = (0..10).map(column).collect();
        let exact = decomposed(columns.clone(), 1e-5);
        assert_eq!(exact.solved.len(), 3);
        for (t, column) in columns.iter().enumerate() {
            let largest = column.iter().fold(0.0f32, |most, v| most.max(v.abs()));
            for (i, value) in column.iter().enumerate() {
                let sum: f32 = exact.coefficients[t].iter().zip(&exact.solved).map(|(c, s)| c * columns[*s][i]).sum();
                assert!((sum - value).abs() <= 1e-4 * largest, "{t} {i}: {sum} {value}");
            }
        }
        let loose = decomposed(columns, 0.3);
        assert!(!loose.solved.is_empty() && loose.solved.len() < 3, "{:?}", loose.solved);
    }
}
