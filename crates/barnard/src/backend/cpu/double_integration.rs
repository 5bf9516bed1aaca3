//! Barrès & Neyret's double integration: star depths marched again at every sample instead of being read.

use glam::DVec3;
use spectra::simd;

use crate::geometry::Ray;
use crate::packet::{Cursor, LANES, Lane, PacketPlaces, lanes};
use crate::plan::star_depths::OPAQUE;
use crate::volume::{MAX_CHANNELS, Volume};

simd! {
    /// Depths from `star` to sixteen places through `dust`, a volume of nothing else, by `steps` midpoints each.
    pub fn depths_of(dust: &Volume, star: DVec3, places: &[DVec3; LANES], steps: usize) -> Lane {
        let rays: [(Ray, f64); LANES] = std::array::from_fn(|lane| Ray::between(star, places[lane]));
        let inside = |lane: usize| dust.inner.bounds.clip(&rays[lane].0).map_or((0.0, 0.0), |(near, far)| (near, far.min(rays[lane].1)));
        let spans: [(f64, f64); LANES] = std::array::from_fn(inside);
        let dt = lanes!(|lane| (spans[lane].1 - spans[lane].0).max(0.0) as f32 / steps as f32);
        let cursor = Cursor::new(dust, &std::array::from_fn(|lane| rays[lane].0), &spans.map(|span| span.0), &spans.map(|span| span.1));
        let mut sum = [0.0; LANES];
        for step in 0..steps {
            let t = lanes!(|lane| (step as f32 + 0.5) * dt[lane]);
            let mut values = [[0.0; LANES]; MAX_CHANNELS];
            cursor.read(PacketPlaces::on_rays(&t), &mut values);
            for lane in 0..LANES {
                sum[lane] += values[0][lane] * dt[lane];
            }
            if step % 16 == 15 && sum.iter().all(|s| *s > OPAQUE as f32) {
                break;
            }
        }
        lanes!(|lane| if sum[lane] > OPAQUE as f32 { OPAQUE as f32 } else { sum[lane] })
    }
}
