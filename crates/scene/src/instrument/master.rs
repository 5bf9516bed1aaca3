//! Masters: the frames of an instrument, calibrated and combined.
//!
//! Of each pixel the electrons of all frames, without bias and dark, are averaged but for those that are full and those that stand apart:
//! more than 5 σ of the median (of two frames: of the smaller), σ² = N + r² + g²/12 + 1, N the median. The variance of the mean is
//! that of the pixel's own mean, over the number of frames that are left (Howell 2006, Handbook of CCD Astronomy, 4.4). Bias and dark are
//! taken to be known without noise.

use rayon::prelude::*;

use super::cosmic_rays::charge;
use super::detector::scattered;
use super::exposures::Exposures;
use crate::control::{Control, Stage};
use crate::error::Result;
use crate::image::{Band, Image, Layer, LayerContent, Samples};
use crate::keywords;
use crate::random::Counter;

/// Flags of a masked pixel: sums of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Flag {
    /// A frame was full and left out.
    Saturated = 1,
    /// A frame stood apart and was left out: a cosmic ray.
    Rejected = 2,
    /// No frame is good: the value says little.
    Bad = 4,
}

/// Rejection threshold of a frame, in standard deviations.
const APART: f64 = 5.0;
/// The variance that numbers of few electrons are given at least \[e²\].
const LEAST: f64 = 1.0;

/// A pixel of the master: radiance and its variance, and flags.
#[derive(Debug, Clone, Copy, Default)]
struct MasterPixel {
    radiance: f64,
    variance: f64,
    flags: u8,
}

impl Exposures {
    /// All frames by one draw of their sum, for a look that passes by: radiances [W m⁻² sr⁻¹] as full and as noisy as those of the master,
    /// without cosmic rays, errors and mask.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn glance(&self, control: &Control) -> Result<Image> {
        let (instrument, detector, count) = (&self.instrument, &self.instrument.detector, self.pixels.count());
        let frames = instrument.frames as f64;
        let pixel = |(i, out): (usize, &mut f32)| {
            let (band, pixel) = (i / count, i % count);
            let mut random = Counter::nested(instrument.seed, band as u64, pixel as u64);
            let mean = self.mean(band, pixel);
            let deviation = (frames * detector.variance(0.0)).sqrt();
            let electrons = scattered(frames * mean, deviation, &mut random).min(frames * detector.full_well) / frames;
            *out = self.radiance(band, pixel, electrons) as f32;
        };
        let mut samples = vec![0.0f32; self.bands.len() * count];
        for (number, plane) in samples.chunks_mut(count).enumerate() {
            control.check()?;
            plane.par_iter_mut().enumerate().for_each(|(i, out)| pixel((number * count + i, out)));
        }
        Ok(Image { samples: Samples::Single(samples), ..self.header.clone() })
    }

    /// Expected masters: radiances [W m⁻² sr⁻¹] without noise, and behind each band the standard errors of a master. Each band
    /// of a mosaic is that of its own pixels, [which see](Self::sees) no other.
    pub fn ideal(&self) -> Image {
        let (instrument, detector, count) = (&self.instrument, &self.instrument.detector, self.pixels.count());
        let all = || (0..self.bands.len()).flat_map(|band| (0..count).map(move |pixel| (band, pixel)));
        let radiance = |(band, pixel): (usize, usize)| self.radiance(band, pixel, self.mean(band, pixel));
        let error = |(band, pixel): (usize, usize)| {
            let variance = detector.variance(self.mean(band, pixel)) / instrument.frames as f64;
            variance.sqrt() / (instrument.exposure_s * self.per_radiance(band, pixel))
        };
        let samples = Samples::Double(all().map(radiance).chain(all().map(error)).collect());
        Image { bands: self.with_errors(), samples, ..self.header.clone() }
    }

    /// True if a pixel of the detector sees a band: all do but those of a mosaic.
    pub fn sees(&self, band: usize, pixel: usize) -> bool {
        self.mosaic.is_none() || self.band_of(0, pixel) == band
    }

    /// The bands of radiances, then those of their errors.
    fn with_errors(&self) -> Vec<Band> {
        let bands = &self.header.bands;
        let errors = bands.iter().map(Band::of_errors);
        bands.iter().cloned().chain(errors).collect()
    }

    /// Radiance for a number of electrons of a frame, without the dark current and, if subtracted, the sky.
    fn radiance(&self, band: usize, pixel: usize, electrons: f64) -> f64 {
        let instrument = &self.instrument;
        let sky = if instrument.subtract_sky { self.sky(band, pixel) } else { 0.0 };
        (electrons / instrument.exposure_s - instrument.detector.dark_current - sky) / self.per_radiance(band, pixel)
    }

    /// The electrons that a radiance of 1 W m⁻² sr⁻¹ brings a pixel [e s⁻¹].
    fn per_radiance(&self, band: usize, pixel: usize) -> f64 {
        self.bands[band].per_watt * self.pixels.solid_angle(pixel)
    }

    /// All frames, calibrated and combined: radiances [W m⁻² sr⁻¹], a band of standard errors behind each, and a layer that is the mask.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn master(&self, control: &Control) -> Result<Image> {
        let (count, bands) = (self.pixels.count(), self.bands.len());
        let planes = self.planes().len();
        let all: Vec<Vec<MasterPixel>> = (0..planes)
            .map(|plane| self.combined(plane, &control.part(plane as f64 / planes as f64, (plane + 1) as f64 / planes as f64)))
            .collect::<Result<_>>()?;
        let combined: Vec<Vec<MasterPixel>> = match self.mosaic {
            Some(_) => (0..bands).map(|band| self.interpolated(&all[0], band)).collect(),
            None => all,
        };
        let flat = |value: fn(&MasterPixel) -> f64| combined.iter().flatten().map(move |pixel| value(pixel) as f32);
        let samples: Vec<f32> = flat(|pixel| pixel.radiance).chain(flat(|pixel| pixel.variance.sqrt())).collect();
        let mask: Vec<f32> = flat(|pixel| f64::from(pixel.flags)).collect();
        debug_assert_eq!(samples.len(), 2 * bands * count, "radiances and errors");
        let mut image = Image { bands: self.with_errors(), ..self.header.clone() };
        image.samples = Samples::Single(samples);
        image.layers = vec![Layer { name: "mask".into(), content: LayerContent::Mask, samples: Samples::Single(mask) }];
        image.keywords.extend(self.keywords(self.instrument.frames));
        image.keywords.push(keywords::text("SKYSUB", if self.instrument.subtract_sky { "yes" } else { "no" }, "mean sky is subtracted"));
        Ok(image)
    }

    /// All pixels of a plane.
    fn combined(&self, plane: usize, control: &Control) -> Result<Vec<MasterPixel>> {
        let frames = self.instrument.frames;
        let hits: Vec<Vec<(usize, f64)>> =
            (0..frames).into_par_iter().map(|frame| control.check().map(|()| self.hits(plane, frame))).collect::<Result<_>>()?;
        let [width, height] = self.pixels.size;
        let done = std::sync::atomic::AtomicU64::new(0);
        let row = |row: usize| {
            control.check()?;
            let mut electrons = Vec::with_capacity(frames);
            let pixel = |column: usize| {
                let pixel = row * width + column;
                let counts = hits.iter().enumerate().map(|(frame, hits)| self.count(plane, frame, pixel, charge(hits, pixel)));
                self.pixel(self.band_of(plane, pixel), pixel, counts, &mut electrons)
            };
            let pixels: Vec<MasterPixel> = (0..width).map(pixel).collect();
            let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            control.report(Stage::Frames, done, height as u64);
            Ok(pixels)
        };
        let rows: Vec<Vec<MasterPixel>> = (0..height).into_par_iter().map(row).collect::<Result<_>>()?;
        Ok(rows.concat())
    }

    /// A pixel's counts, combined; `electrons` is room for them.
    fn pixel(&self, band: usize, pixel: usize, counts: impl Iterator<Item = u16>, electrons: &mut Vec<f64>) -> MasterPixel {
        let (instrument, detector) = (&self.instrument, &self.instrument.detector);
        let (full, mut flags, mut frames) = (detector.saturation(), 0, 0);
        let mut all = 0.0;
        electrons.clear();
        for count in counts {
            frames += 1;
            all += detector.electrons(count);
            if count >= full {
                flags |= Flag::Saturated as u8;
            } else {
                electrons.push(detector.electrons(count));
            }
        }
        let candidates = electrons.len();
        let good = without_outliers(electrons, |level| (detector.variance(level) + LEAST).sqrt());
        if good.len() < candidates {
            flags |= Flag::Rejected as u8;
        }
        let (mean, left) = match good.len() {
            0 => (all / f64::from(frames), 1.0),
            left => (good.iter().sum::<f64>() / left as f64, left as f64),
        };
        if good.is_empty() {
            flags |= Flag::Bad as u8;
        }
        let deviation = (detector.variance(mean) / left).sqrt() / (instrument.exposure_s * self.per_radiance(band, pixel));
        MasterPixel { radiance: self.radiance(band, pixel, mean), variance: deviation.powi(2), flags }
    }

    /// A band of a mosaic at all pixels: its own, and between them a mean of those around.
    fn interpolated(&self, mosaic: &[MasterPixel], band: usize) -> Vec<MasterPixel> {
        let [width, height] = self.pixels.size;
        let at = |pixel: usize| {
            if self.band_of(0, pixel) == band {
                return mosaic[pixel];
            }
            let (column, row) = (pixel % width, pixel / width);
            let (mut sum, mut weights) = (MasterPixel::default(), 0.0);
            for (y, x) in (row.saturating_sub(1)..(row + 2).min(height))
                .flat_map(|y| (column.saturating_sub(1)..(column + 2).min(width)).map(move |x| (y, x)))
            {
                let other = y * width + x;
                if self.band_of(0, other) == band {
                    // Bilinear: those beside count twice as much as those across a corner.
                    let weight = if x == column || y == row { 2.0 } else { 1.0 };
                    let neighbour = &mosaic[other];
                    sum.radiance += weight * neighbour.radiance;
                    sum.variance += weight * weight * neighbour.variance;
                    sum.flags |= neighbour.flags;
                    weights += weight;
                }
            }
            MasterPixel { radiance: sum.radiance / weights, variance: sum.variance / (weights * weights), flags: sum.flags }
        };
        (0..mosaic.len()).into_par_iter().map(at).collect()
    }
}

/// The values that do not stand apart, of which the order may change; `deviation` is that of a level.
fn without_outliers(values: &mut [f64], deviation: impl Fn(f64) -> f64) -> &[f64] {
    values.sort_unstable_by(f64::total_cmp);
    // Of two, both scatter.
    let (level, scatter) = match values.len() {
        0 | 1 => return values,
        2 => (values[0], std::f64::consts::SQRT_2),
        many => (0.5 * (values[(many - 1) / 2] + values[many / 2]), 1.0),
    };
    let most = APART * scatter * deviation(level);
    let first = values.partition_point(|value| *value < level - most);
    let last = values.partition_point(|value| *value <= level + most);
    &values[first..last]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_apart_is_left_out() {
        let accepted = |values: &[f64]| without_outliers(&mut values.to_vec(), |level| level.max(0.0).sqrt() + 1.0).to_vec();
        assert_eq!(accepted(&[100.0, 3000.0, 104.0, 90.0]), [90.0, 100.0, 104.0]);
        assert_eq!(accepted(&[100.0, 3000.0]), [100.0]);
        assert_eq!(accepted(&[3000.0]), [3000.0]);
        assert!(accepted(&[]).is_empty());
        assert_eq!(accepted(&[100.0, 110.0, 0.0, 105.0]), [100.0, 105.0, 110.0]);
    }
}
