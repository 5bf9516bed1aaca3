//! Cosmic rays: tracks of charge across a detector.
//!
//! Hits come evenly over the detector and from all directions: of those that cross a plane, cos²θ is even from 0 to 1, θ from the normal.
//! A track goes through silicon as thick as a pixel is wide, of which each micrometre frees 80 electrons (Janesick 2001, Scientific
//! Charge-Coupled Devices, 8.3.1). How that scatters from hit to hit is left out.

use rand_distr::{Distribution, Poisson};

use super::Detector;
use crate::random::Counter;

/// Electrons of a micrometre of a track.
const PER_MICROMETRE: f64 = 80.0;
/// Steps of a track in each pixel.
const STEPS: f64 = 4.0;
/// The longest track, in pixels.
const LONGEST: f64 = 1000.0;

/// Electrons of all tracks of an exposure \[s\], by the number of their pixel, in order.
pub(super) fn tracks(detector: &Detector, [width, height]: [usize; 2], exposure_s: f64, random: &mut Counter) -> Vec<(usize, f64)> {
    let area = (width * height) as f64 * (detector.pixel_um * 1e-4).powi(2);
    let Ok(poisson) = Poisson::new(detector.cosmic_rays * area * exposure_s) else { return Vec::new() };
    // Whoever asks for more hits than pixels gets as many.
    let count = (poisson.sample(random) as u64).min((width * height) as u64);
    let mut charges = Vec::new();
    for _ in 0..count {
        let place = [width, height].map(|edge| edge as f64 * random.uniform());
        let cosine = random.uniform().max(1e-12).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * random.uniform()).sin_cos();
        // All lengths in pixels: the silicon is one thick.
        let across = ((1.0 - cosine * cosine).sqrt() / cosine).min(LONGEST);
        let steps = (STEPS * across).ceil().max(1.0);
        let charge = PER_MICROMETRE * detector.pixel_um * across.hypot(1.0) / steps;
        for i in 0..steps as usize {
            let along = across * (i as f64 + 0.5) / steps;
            let (x, y) = (place[0] + cos * along, place[1] + sin * along);
            if (0.0..width as f64).contains(&x) && (0.0..height as f64).contains(&y) {
                charges.push((y as usize * width + x as usize, charge));
            }
        }
    }
    charges.sort_unstable_by_key(|(pixel, _)| *pixel);
    charges.dedup_by(|next, previous| {
        let same = next.0 == previous.0;
        if same {
            previous.1 += next.1;
        }
        same
    });
    charges.shrink_to_fit();
    charges
}

/// The electrons of tracks in a pixel.
pub(super) fn charge(tracks: &[(usize, f64)], pixel: usize) -> f64 {
    tracks.binary_search_by_key(&pixel, |(hit, _)| *hit).map_or(0.0, |i| tracks[i].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As many hits as the rate says, all of the silicon's thickness: straight through 80 e/µm, on the average twice that, since the
    /// mean of 1/cos θ is 2 where cos²θ is even.
    #[test]
    fn hits_come_at_their_rate() {
        let detector = Detector { cosmic_rays: 2.0, pixel_um: 10.0, ..Detector::default() };
        let edge = 400;
        let all = |seed| tracks(&detector, [edge, edge], 500.0, &mut Counter::new(seed, 0));
        let hits = 2.0 * 500.0 * (0.001 * edge as f64).powi(2);
        let charge = (0..40).flat_map(all).map(|(_, charge)| charge).sum::<f64>() / 40.0;
        // Long tracks leave the detector, and their lengths scatter.
        assert!((charge / (hits * 800.0 * 2.0) - 1.0).abs() < 0.08, "{}", charge / (hits * 1600.0));
        let once = all(3);
        assert!(once.windows(2).all(|pair| pair[0].0 < pair[1].0) && once.iter().all(|(pixel, _)| *pixel < edge * edge));
        assert_eq!((super::charge(&once, once[5].0), super::charge(&[], 3)), (once[5].1, 0.0));
        assert!(tracks(&Detector::default(), [edge, edge], 500.0, &mut Counter::new(1, 0)).is_empty());
    }
}
