//! Stars on a detector: points, which optics alone spread.
//!
//! A picture draws a star as a disc of 1.65 pixels, which would widen it on a detector of about such pixels: of Hubble's 1.8 pixels 2.7
//! became. Discs are taken out of the picture's light, and stars put as points on pixels so fine that what optics make of them is well
//! sampled, at least [`PER_PIXEL`] of them along a pixel of the detector. On those the four nearest along each axis share a point such that
//! its moments up to the third are right (Lagrange's polynomial).

use super::layout::Pixels;
use crate::image::{Image, PointSource};
use crate::points::disc;

/// Fine pixels along one of the detector.
const PER_PIXEL: f64 = 4.0;
/// Most fine pixels; where more are needed they are coarser.
const MOST: usize = 1 << 25;

/// The stars of a picture that are inside of it.
pub(super) struct Points<'a> {
    points: Vec<&'a PointSource>,
    /// Pixels of the picture.
    size: [usize; 2],
    /// Fine pixels along each of them.
    pub finer: usize,
    /// Unit flux summed over all pixels [W m⁻²].
    scale: f64,
}

impl<'a> Points<'a> {
    /// Those of a picture whose pixels are `below`, for a detector whose pixels are `edge` of them wide; none where there are none.
    pub fn of(image: &'a Image, below: &Pixels, edge: f64) -> Option<Self> {
        let [width, height] = below.size;
        let is_inside = |point: &&PointSource| (0.0..width as f64).contains(&point.column) && (0.0..height as f64).contains(&point.row);
        let points: Vec<&PointSource> = image.points.iter().filter(is_inside).collect();
        let most = ((MOST / (width * height).max(1)) as f64).sqrt() as usize;
        let finer = ((PER_PIXEL / edge).ceil() as usize).clamp(1, most.max(1));
        let distance_pc = image.observation.and_then(|observation| observation.distance_pc);
        let scale = if below.is_parallel { distance_pc.map_or(0.0, |pc| pc.powi(-2)) } else { 1.0 };
        (!points.is_empty()).then_some(Self { points, size: below.size, finer, scale })
    }

    /// Takes the discs of a band out of light by pixel; the factor converts it to W m⁻².
    pub fn take_discs(&self, band: usize, per_watt: f64, light: &mut [f64]) {
        for point in &self.points {
            let all = self.scale * per_watt * point.flux[band];
            disc(self.size, point.column, point.row).for_each(|(pixel, share)| light[pixel] -= share * all);
        }
    }

    /// Copy of the light as points on fine pixels.
    pub fn light(&self, band: usize, per_watt: f64) -> Vec<f64> {
        let [width, height] = self.size.map(|pixels| pixels * self.finer);
        let mut light = vec![0.0; width * height];
        for point in &self.points {
            let all = self.scale * per_watt * point.flux[band];
            let [column, row] = [point.column, point.row].map(|place| place * self.finer as f64 - 0.5);
            for (y, down) in shared(row, height) {
                for (x, across) in shared(column, width) {
                    light[y * width + x] += all * down * across;
                }
            }
        }
        light
    }

    /// Adds light on fine pixels to that of the picture's.
    pub fn gather(&self, fine: &[f64], light: &mut [f64]) {
        let width = self.size[0];
        for (row, line) in fine.chunks_exact(width * self.finer).enumerate() {
            let out = &mut light[row / self.finer * width..][..width];
            out.iter_mut().zip(line.chunks_exact(self.finer)).for_each(|(out, values)| *out += values.iter().sum::<f64>());
        }
    }
}

/// The four pixels that share a point between their middles, those beyond the edge taken back to it, and their shares.
fn shared(place: f64, count: usize) -> [(usize, f64); 4] {
    let first = place.floor();
    let t = place - first;
    let shares = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ];
    std::array::from_fn(|i| (((first as i64 - 1 + i as i64).clamp(0, count as i64 - 1)) as usize, shares[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares of a point have the moments of a point: 1, x, x², x³.
    #[test]
    fn shares_have_the_moments_of_a_point() {
        for place in [7.0, 7.25, 7.5, 7.93] {
            for power in 0..4 {
                let moment: f64 = shared(place, 20).iter().map(|(pixel, share)| share * (*pixel as f64).powi(power)).sum();
                assert!((moment / place.powi(power) - 1.0).abs() < 1e-12, "{place} {power}");
            }
        }
        let at_edge: f64 = shared(-0.4, 20).iter().map(|(_, share)| share).sum();
        assert!((at_edge - 1.0).abs() < 1e-12);
    }
}
