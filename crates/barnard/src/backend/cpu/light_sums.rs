//! The light field's tables in single precision, and the bands of what rays have summed by them.

use super::terms::CoordinateTable;
use crate::packet::{LANES, Lane};
use crate::plan::LightField;

/// Tables of a light field.
#[derive(Debug)]
pub struct LightSums {
    pub(super) coordinates: CoordinateTable,
    /// M_imj, element × element × element.
    pub(super) products: Vec<f32>,
    /// The number of elements of the basis.
    pub(super) size: usize,
    /// The number of polynomials a spectrum is written in.
    pub(super) width: usize,
    /// Band × element × polynomial.
    resolution: Vec<Vec<f32>>,
}

impl LightSums {
    /// Converts the products and coordinates of `field` to single precision.
    pub fn new(field: &LightField) -> Self {
        let propagation = &field.propagation;
        let single = |values: &Vec<f64>| values.iter().map(|v| *v as f32).collect::<Vec<f32>>();
        Self {
            coordinates: CoordinateTable::new(&propagation.projection),
            products: single(&propagation.products),
            size: propagation.projection.basis.size(),
            width: propagation.span.len(),
            resolution: field.resolution.iter().map(single).collect(),
        }
    }

    /// The number of sums that each ray carries: element × polynomial.
    pub fn channels(&self) -> usize {
        self.size * self.width
    }

    /// Radiance of a ray's polynomials, into band × lane.
    pub fn resolve(&self, sum: &[Lane], radiance: &mut [f32]) {
        for (band, resolution) in self.resolution.iter().enumerate() {
            for (share, sum) in resolution.iter().zip(sum) {
                for lane in 0..LANES {
                    radiance[band * LANES + lane] += share * sum[lane];
                }
            }
        }
    }
}
