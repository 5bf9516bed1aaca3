//! Moments of the radiance in cells, for eight terms side by side.

use rayon::prelude::*;

use super::{Octet, WIDTH};

/// Moments of the radiance: cell × harmonic × term.
#[derive(Debug, Clone)]
pub struct Moments {
    /// Harmonics of a cell.
    pub count: usize,
    pub data: Vec<Octet>,
}

impl Moments {
    /// Of no light.
    pub fn dark(cells: usize, count: usize) -> Self {
        Self { count, data: vec![[0.0; WIDTH]; cells * count] }
    }

    /// Bytes that so many take.
    pub fn bytes(cells: usize, count: usize) -> u64 {
        (size_of::<Octet>() as u64).saturating_mul(cells as u64).saturating_mul(count as u64)
    }

    /// Those of one cell.
    pub fn cell(&self, i: usize) -> &[Octet] {
        &self.data[i * self.count..][..self.count]
    }

    /// Adds what another has, by a factor for each term.
    pub fn add(&mut self, other: &Self, factor: &Octet) {
        self.data.par_iter_mut().zip(&other.data).with_min_len(4096).for_each(|(own, other)| {
            (0..WIDTH).for_each(|t| own[t] += factor[t] * other[t]);
        });
    }

    /// Scatters: moments become those of the source function.
    pub fn scatter(&mut self, scattering: &[Octet]) {
        self.data.par_chunks_mut(self.count).with_min_len(1024).for_each(|cell| {
            cell.iter_mut().zip(scattering).for_each(|(own, factor)| (0..WIDTH).for_each(|t| own[t] *= factor[t]));
        });
    }
}
