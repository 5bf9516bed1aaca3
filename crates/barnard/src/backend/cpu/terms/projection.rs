//! Coordinates of e^(−a k) in a basis: read once for all bands that share it.

use spectra::rule::{Form, Projection};
use wide::f32x4;

use super::Course;
use crate::packet::{LANES, Lane, lanes, largest};
use crate::plan::Plan;

/// The bases of all bands.
#[derive(Debug)]
pub struct ProjectionTerms {
    groups: Vec<Group>,
}

/// Bands with one basis.
#[derive(Debug)]
struct Group {
    /// The first term of each band.
    first: Vec<usize>,
    table: CoordinateTable,
}

/// q_i(a) and q_i″(a)/6, so that a row of few elements is read as short vectors.
#[derive(Debug)]
pub struct CoordinateTable {
    /// Number of elements.
    size: usize,
    /// Entries per unit of depth.
    per_depth: f32,
    /// The elements and what lies behind them up to the fourth or eighth, then as many curvatures: entry × row.
    rows: Vec<f32>,
}

/// Half difference of depth up to which a segment is its middle and a curvature: y⁴/120 k⁴ is left out.
const SHORT: f32 = 0.2;

impl ProjectionTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let mut groups: Vec<(&[f64], Group)> = Vec::new();
        let mut first = 0;
        for band in &plan.spectral.bands {
            let Form::Projection(projection) = &band.rule.form else { continue };
            let exponents = &projection.basis.exponents[..];
            match groups.iter_mut().find(|(e, _)| *e == exponents) {
                Some((_, group)) => group.first.push(first),
                None => groups.push((exponents, Group { first: vec![first], table: CoordinateTable::new(projection) })),
            }
            first += projection.basis.size();
        }
        Self { groups: groups.into_iter().map(|(_, group)| group).collect() }
    }

    #[inline(always)]
    pub(super) fn gather(&self, course: &Course, base: impl Fn(usize) -> Option<Lane>, sum: &mut [Lane]) {
        for group in &self.groups {
            if group.table.size <= 4 {
                group.gather::<4>(course, &base, sum);
            } else {
                group.gather::<8>(course, &base, sum);
            }
        }
    }

    pub(super) fn at(&self, term: usize, depth: f32) -> f32 {
        let inside = |group: &&Group| group.first.iter().any(|first| (*first..first + group.table.size).contains(&term));
        let Some(group) = self.groups.iter().find(inside) else { return 0.0 };
        let element = group.first.iter().filter(|first| **first <= term).map(|first| term - first).min().unwrap_or(0);
        group.table.mean::<8>(depth, 0.0)[element]
    }
}

impl Group {
    #[inline(always)]
    fn gather<const ROW: usize>(&self, course: &Course, base: impl Fn(usize) -> Option<Lane>, sum: &mut [Lane]) {
        let means = self.table.means::<ROW>(course);
        for element in 0..self.table.size {
            let mean = &means[element];
            for first in &self.first {
                let Some(base) = base(first + element) else { continue };
                let sum = &mut sum[first + element];
                for lane in 0..LANES {
                    sum[lane] += base[lane] * mean[lane];
                }
            }
        }
    }
}

impl CoordinateTable {
    /// In f32.
    pub fn new(projection: &Projection) -> Self {
        let size = projection.basis.size();
        let padding = size.next_multiple_of(4) - size;
        let entry = |(i, q): (usize, &Vec<f64>)| {
            let bent = projection.basis.curvatures(projection.step * i as f64).into_iter().map(|c| c / 6.0);
            let gap = || std::iter::repeat_n(0.0, padding);
            q.iter().copied().chain(gap()).chain(bent).chain(gap()).map(|v| v as f32).collect::<Vec<f32>>()
        };
        let rows = projection.coordinates.iter().enumerate().flat_map(entry).collect();
        Self { size, per_depth: (1.0 / projection.step) as f32, rows }
    }

    /// The mean coordinates over the lanes' courses, element × lane.
    ///
    /// `ROW` is the number of elements, rounded up to four or eight.
    #[inline(always)]
    pub fn means<const ROW: usize>(&self, Course { middle, half }: &Course) -> [Lane; ROW] {
        let mut means = [[0.0; ROW]; LANES];
        if largest(&lanes(|lane| half[lane].abs())) <= SHORT {
            for lane in 0..LANES {
                means[lane] = self.mean(middle[lane], half[lane] * half[lane]);
            }
        } else {
            // The two points of Gauss.
            for lane in 0..LANES {
                let offset = half[lane] * 0.577_350_26;
                let (low, high) = (self.mean::<ROW>(middle[lane] - offset, 0.0), self.mean::<ROW>(middle[lane] + offset, 0.0));
                for i in 0..ROW {
                    means[lane][i] = 0.5 * (low[i] + high[i]);
                }
            }
        }
        // Four lanes change places with four elements.
        let mut turned = [[0.0; LANES]; ROW];
        for lane in (0..LANES).step_by(4) {
            for element in (0..ROW).step_by(4) {
                let quad = |i: usize| f32x4::new(std::array::from_fn(|e| means[lane + i][element + e]));
                for (e, values) in f32x4::transpose([quad(0), quad(1), quad(2), quad(3)]).into_iter().enumerate() {
                    turned[element + e][lane..lane + 4].copy_from_slice(&values.to_array());
                }
            }
        }
        turned
    }

    /// q + half² q″/6 at one depth; beyond the table its last entry is held.
    #[inline(always)]
    fn mean<const ROW: usize>(&self, depth: f32, half_squared: f32) -> [f32; ROW] {
        // A table of four elements may be asked for eight.
        let width = if self.size <= 4 { 4 } else { ROW };
        let stride = 2 * width;
        let x = depth * self.per_depth;
        let entry = (x as usize).min(self.rows.len() / stride - 2);
        let fraction = x - entry as f32;
        let fraction = f32x4::splat(if fraction < 1.0 { fraction } else { 1.0 });
        let row = &self.rows[entry * stride..][..2 * stride];
        let quad = |at: usize| f32x4::new([row[at], row[at + 1], row[at + 2], row[at + 3]]);
        let read = |at: usize| (quad(at + stride) - quad(at)).mul_add(fraction, quad(at));
        let mut mean = [0.0; ROW];
        for at in (0..width).step_by(4) {
            let value = read(width + at).mul_add(f32x4::splat(half_squared), read(at));
            mean[at..at + 4].copy_from_slice(&value.to_array());
        }
        mean
    }
}
