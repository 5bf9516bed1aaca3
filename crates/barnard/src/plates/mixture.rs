//! Pictures as sums of plates: the matrix from coordinates to bands, and the loop over pixels.

use rayon::prelude::*;
use spectra::simd;

use super::Plate;

/// Weights of a plate in a band, level × (of_mean + Σ_t of_coordinate_t q_t) with the stored numbers q.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Share {
    pub of_mean: f64,
    pub of_coordinate: Vec<f64>,
}

/// Pixels that one thread takes at a time, and those whose numbers are held at once.
const CHUNK: usize = 1 << 13;
const BLOCK: usize = 512;

/// Adds plates to a picture, bands × height × width, by what each band takes of each, plate × band.
pub(super) fn add(plates: &[Plate], shares: &[Vec<Share>], pixels: usize, picture: &mut [f32]) {
    let mut chunks: Vec<Vec<&mut [f32]>> = (0..pixels.div_ceil(CHUNK)).map(|_| Vec::new()).collect();
    for band in picture.chunks_exact_mut(pixels) {
        band.chunks_mut(CHUNK).zip(&mut chunks).for_each(|(part, chunk)| chunk.push(part));
    }
    chunks.into_par_iter().enumerate().for_each(|(number, mut bands)| {
        for (plate, shares) in plates.iter().zip(shares) {
            add_chunk(plate, shares, number * CHUNK, &mut bands);
        }
    });
}

simd! {
    fn add_chunk(plate: &Plate, shares: &[Share], first: usize, bands: &mut [&mut [f32]]) {
        let length = bands.first().map_or(0, |band| band.len());
        let mut numbers = vec![[0.0f32; BLOCK]; plate.coordinates.len()];
        for from in (0..length).step_by(BLOCK) {
            let count = BLOCK.min(length - from);
            let level = &plate.level[first + from..][..count];
            for (stored, numbers) in plate.coordinates.iter().zip(&mut numbers) {
                let stored = &stored[first + from..][..count];
                numbers.iter_mut().zip(stored).for_each(|(number, q)| *number = f32::from(*q));
            }
            for (share, band) in shares.iter().zip(bands.iter_mut()) {
                let mut light = [share.of_mean as f32; BLOCK];
                for (factor, numbers) in share.of_coordinate.iter().map(|factor| *factor as f32).zip(&numbers) {
                    for (light, number) in light.iter_mut().zip(numbers) {
                        *light = factor.mul_add(*number, *light);
                    }
                }
                // No light is less than none: what stored numbers lose of a dark pixel could be more than it has.
                for ((out, level), light) in band[from..][..count].iter_mut().zip(level).zip(&light) {
                    *out += level * light.max(0.0);
                }
            }
        }
    }
}

/// Variant in double precision: smooth in what spectra and the amount of dust change, however small the change.
pub(super) fn add_in_double(plates: &[Plate], shares: &[Vec<Share>], pixels: usize, picture: &mut [f64]) {
    picture.par_chunks_exact_mut(pixels).enumerate().for_each(|(band, picture)| {
        for (plate, share) in plates.iter().zip(shares).map(|(plate, shares)| (plate, &shares[band])) {
            for (pixel, (out, level)) in picture.iter_mut().zip(&plate.level).enumerate() {
                let coordinate = |(factor, stored): (&f64, &Vec<u16>)| factor * f64::from(stored[pixel]);
                let light = share.of_mean + share.of_coordinate.iter().zip(&plate.coordinates).map(coordinate).sum::<f64>();
                *out += f64::from(*level) * light.max(0.0);
            }
        }
    });
}
