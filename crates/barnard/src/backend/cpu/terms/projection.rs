//! Coordinates of e^(−a k) in a basis: read once for all bands that share it.

use spectra::rule::Form;

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
    /// Number of elements.
    size: usize,
    /// Entries per unit of depth.
    per_depth: f32,
    /// Coordinates, entry × element.
    coordinates: Vec<f32>,
}

/// Half difference of depth up to which a segment is read at its middle alone: 2e-5 k² of what is there.
const SHORT: f32 = 0.01;

impl ProjectionTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let mut groups: Vec<(&[f64], Group)> = Vec::new();
        let mut first = 0;
        for band in &plan.spectral.bands {
            let Form::Projection(projection) = &band.rule.form else { continue };
            let (size, exponents) = (projection.basis.size(), &projection.basis.exponents[..]);
            match groups.iter_mut().find(|(e, _)| *e == exponents) {
                Some((_, group)) => group.first.push(first),
                None => {
                    let entries = projection.coordinates[0].len();
                    let coordinates = (0..entries).flat_map(|i| projection.coordinates.iter().map(move |q| q[i] as f32)).collect();
                    groups.push((exponents, Group { first: vec![first], size, per_depth: (1.0 / projection.step) as f32, coordinates }));
                }
            }
            first += size;
        }
        Self { groups: groups.into_iter().map(|(_, group)| group).collect() }
    }

    #[inline(always)]
    pub(super) fn gather(&self, Course { middle, half }: &Course, base: impl Fn(usize) -> Option<Lane>, sum: &mut [Lane]) {
        let short = largest(&lanes(|lane| half[lane].abs())) <= SHORT;
        for group in &self.groups {
            let (low, high) = if short {
                (group.place(middle), None)
            } else {
                // The two points of Gauss.
                let offset = lanes(|lane| half[lane] * 0.577_350_26);
                (group.place(&lanes(|lane| middle[lane] - offset[lane])), Some(group.place(&lanes(|lane| middle[lane] + offset[lane]))))
            };
            for element in 0..group.size {
                let mut q = group.read(element, &low);
                if let Some(high) = &high {
                    let other = group.read(element, high);
                    q = lanes(|lane| 0.5 * (q[lane] + other[lane]));
                }
                for first in &group.first {
                    let Some(base) = base(first + element) else { continue };
                    let sum = &mut sum[first + element];
                    for lane in 0..LANES {
                        sum[lane] += base[lane] * q[lane];
                    }
                }
            }
        }
    }

    pub(super) fn at(&self, term: usize, depth: f32) -> f32 {
        let inside = |group: &&Group| group.first.iter().any(|first| (*first..first + group.size).contains(&term));
        let Some(group) = self.groups.iter().find(inside) else { return 0.0 };
        let element = group.first.iter().filter(|first| **first <= term).map(|first| term - first).min().unwrap_or(0);
        group.read(element, &group.place(&[depth; LANES]))[0]
    }
}

impl Group {
    /// Entry and fraction of each lane's depth; the last entry is held.
    #[inline(always)]
    fn place(&self, depth: &Lane) -> ([usize; LANES], Lane) {
        let last = self.coordinates.len() / self.size - 2;
        let (mut entry, mut fraction) = ([0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let x = depth[lane] * self.per_depth;
            entry[lane] = (x as usize).min(last);
            let f = x - entry[lane] as f32;
            fraction[lane] = if f < 1.0 { f } else { 1.0 };
        }
        (entry, fraction)
    }

    #[inline(always)]
    fn read(&self, element: usize, (entry, fraction): &([usize; LANES], Lane)) -> Lane {
        lanes(|lane| {
            let i = entry[lane] * self.size + element;
            let (low, high) = (self.coordinates[i], self.coordinates[i + self.size]);
            low + fraction[lane] * (high - low)
        })
    }
}
