//! A picture in the window: radiances, the plan that made them, and how they are shown.

use std::sync::Arc;
use web_time::Instant;

use barnard::backend;
use barnard::camera::Camera;
use barnard::control::Control;
use barnard::image::{Display, Glare, Image, PixelScale, Tone};
use barnard::instrument::{Exposures, Instrument, Kernels};
use barnard::plan::Planned;
use barnard::points::Sources;
use barnard::scene::Scene;
use barnard::{Error, Result};
use rayon::prelude::*;

use crate::order::AMPLIFIED;

/// Colour of a pixel: red, green and blue of sRGB, and opacity.
pub type Rgba = [u8; 4];

/// Colours over a picture, transparent where it is seen.
pub struct Overlay {
    /// Width and height \[pixels\].
    pub size: [usize; 2],
    /// Colours, height × width.
    pub colours: Vec<Rgba>,
}

/// A picture and what is known of it.
#[derive(Clone)]
pub struct Picture {
    /// The radiances of all bands.
    pub image: Arc<Image>,
    /// The scene it shows, with the camera it was seen by.
    pub scene: Arc<Scene>,
    /// The plan that made it.
    pub plan: Planned,
    /// The levels and the palette by which it is shown.
    pub tone: Tone,
    /// The colours, height × width.
    pub colours: Arc<Vec<Rgba>>,
    /// Stars over a picture that has none, in pixels of the window: transparent where none is.
    pub sparks: Option<Arc<Overlay>>,
    /// Glare of a picture that includes its stars, and its optics.
    spread: Option<(Glare, Arc<Image>)>,
    /// Instrument response to another picture, used for this one.
    recorded: Option<Recorded>,
    /// The histogram of the pixels of each band.
    pub histograms: Vec<Histogram>,
    /// The time that each part of it took.
    pub times: Times,
    /// The name of what marched the rays.
    pub backend: String,
}

/// Most bytes of kernels of point spreads that are kept.
const KERNELS: u64 = 1 << 29;

/// Instrument response to a picture.
#[derive(Clone)]
struct Recorded {
    /// The picture.
    image: Arc<Image>,
    /// The scene's instrument.
    instrument: Arc<Instrument>,
    /// Response with the given binning per axis.
    exposures: Exposures,
    kernels: Kernels,
    binning: usize,
    /// Collected light per pixel and band, in words.
    bands: Vec<String>,
}

/// No colour.
const TRANSPARENT: Rgba = [0; 4];

fn opaque([red, green, blue]: [u8; 3]) -> Rgba {
    [red, green, blue, u8::MAX]
}

/// Collected light per pixel in a band, in words.
fn gathered(exposures: &Exposures, number: usize, band: &str) -> String {
    let ([width, height], instrument) = (exposures.size(), exposures.instrument());
    let full = (0..width * height).filter(|pixel| exposures.mean(number, *pixel) >= instrument.detector.full_well).count();
    let sky = exposures.sky(number, (height / 2) * width + width / 2) * instrument.exposure_s;
    format!("{band}: sky {} e, {full} pixels full", crate::edit::rounded(sky, 3))
}

/// The times that the parts of a picture took \[s\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Times {
    /// The plan; zero where it was still there.
    pub plan: f64,
    /// The march of the rays.
    pub march: f64,
    /// The drawing of stars, and the certificates.
    pub stars: f64,
    /// The colours and the histograms.
    pub colours: f64,
}

impl Times {
    /// The sum of all parts \[s\].
    pub fn all(&self) -> f64 {
        self.plan + self.march + self.stars + self.colours
    }
}

/// Pixels of a band by the logarithm of their radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// The log₁₀ of radiance at both ends [W m⁻² sr⁻¹].
    pub range: (f64, f64),
    /// Pixels in equal steps between them.
    pub counts: Vec<u32>,
}

/// Steps of a histogram, the decades it spans, the part of the pixels that its range is made for, and the decades above
/// them.
const BINS: usize = 96;
const DECADES: f64 = 6.0;
const MANY: f64 = 0.99;
const ABOVE: f64 = 1.0;

/// Most pixels that are counted, evenly over the picture.
const COUNTED: usize = 1 << 18;

impl Histogram {
    /// The histogram of one band's values.
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        // Stars are few and far brighter than all else: the range is that of the many.
        let mut bright: Vec<f64> = values.clone().filter(|v| v.is_finite() && *v > 0.0).collect();
        let many = (bright.len() as f64 * MANY) as usize;
        let high = if bright.is_empty() { 0.0 } else { bright.select_nth_unstable_by(many, f64::total_cmp).1.log10() + ABOVE };
        let range = (high - DECADES, high);
        let mut counts = vec![0; BINS];
        for value in values.filter(|v| *v > 0.0) {
            let bin = (value.log10() - range.0) / DECADES * BINS as f64;
            if bin >= 0.0 {
                counts[(bin as usize).min(BINS - 1)] += 1;
            }
        }
        Self { range, counts }
    }
}

impl Picture {
    /// The picture of `image`, which `plan` made of `scene`, shown by `tone`.
    pub fn new(image: Image, scene: Arc<Scene>, tone: Tone, plan: Planned, times: Times, backend: String) -> Self {
        let (colours, sparks, histograms) = (Arc::default(), None, Vec::new());
        let (image, spread, recorded) = (Arc::new(image), None, None);
        let mut picture = Self { image, plan, tone, colours, sparks, spread, recorded, histograms, times, backend, scene };
        picture.colour();
        picture
    }

    /// Shows the same light in another way.
    pub fn show(&mut self, display: &Display, tone: Tone) {
        self.scene = Arc::new(Scene::clone(&self.scene).with_display(display.clone()));
        self.tone = tone;
        self.colour();
    }

    /// Shows what the optics of the scene's display make of a picture that has its stars; once for each, it takes seconds.
    pub fn spread(&mut self) {
        let asked = self.scene.display.glare;
        if asked != self.spread.as_ref().map(|(glare, _)| *glare) {
            self.spread = asked.map(|glare| (glare, Arc::new(glare.seen(&self.image, self.tone.white))));
            self.colour();
        }
    }

    /// Instrument response of a scene to this picture; of what another has seen of it before as much as holds is taken.
    ///
    /// # Errors
    /// If the scene has no instrument, or it cannot see the picture.
    pub fn recorded(&self, scene: &Arc<Scene>, before: Option<&Self>, control: &Control) -> Result<Self> {
        let missing = || Error::missing("an instrument", "add one to the scene, such as [instrument] with preset = \"hst-wfc3-uvis\"");
        let instrument = scene.instrument.clone().ok_or_else(missing)?;
        // Where the window is coarser than the detector, pixels are summed.
        let binning = match (instrument.pixel_rad, self.image.pixel) {
            (Some(pixel), Some(PixelScale::Angle(degrees))) => (degrees.to_radians() / pixel * (1.0 - 1e-9)).ceil().max(1.0) as usize,
            _ => 1,
        };
        let known = before.and_then(|before| before.recorded.as_ref()).filter(|known| Arc::ptr_eq(&known.image, &self.image));
        if let Some((known, before)) = known.zip(before).filter(|(known, _)| known.instrument == instrument) {
            let mut picture = Self { scene: scene.clone(), image: before.image.clone(), tone: self.tone.clone(), ..before.clone() };
            picture.recorded = Some(known.clone());
            picture.colour();
            return Ok(picture);
        }
        let binned = Arc::new(Instrument::clone(&instrument).binned(binning));
        let mut kernels =
            before.and_then(|before| before.recorded.as_ref()).map(|known| known.kernels.clone()).unwrap_or(Kernels::within(KERNELS));
        let exposures = match known.filter(|known| known.exposures.instrument().sees_like(&binned)) {
            Some(known) => known.exposures.recorded_by(binned),
            None => Exposures::by(&mut kernels, binned, &self.image, &scene.bands, control)?,
        };
        let image = Arc::new(exposures.glance(control)?);
        let mut picture = Self { image, scene: scene.clone(), spread: None, sparks: None, ..self.clone() };
        let bands = self.scene.bands.iter().enumerate().map(|(number, band)| gathered(&exposures, number, band.name())).collect();
        picture.recorded = Some(Recorded { image: self.image.clone(), instrument, exposures, kernels, binning, bands });
        picture.colour();
        Ok(picture)
    }

    /// Instrument that recorded it, or will record it, in words.
    pub fn recorded_words(&self) -> String {
        let Some(Recorded { instrument, binning, .. }) = &self.recorded else { return "not observed yet".into() };
        let binned = if *binning > 1 { format!(", {binning} × {binning} pixels summed") } else { String::new() };
        format!("{}, {} × {} s{binned}", instrument.name, instrument.frames, crate::edit::rounded(instrument.exposure_s, 3))
    }

    /// Collected light per pixel and band, in words.
    pub fn recorded_bands(&self) -> &[String] {
        self.recorded.as_ref().map_or(&[], |recorded| &recorded.bands)
    }

    /// The light that is shown: with its glare, where it has one.
    fn seen(&self) -> &Image {
        self.spread.as_ref().map_or(&self.image, |(_, spread)| spread)
    }

    /// Makes colours and histograms anew.
    fn colour(&mut self) {
        let start = Instant::now();
        let image = &self.image;
        self.colours = Arc::new(self.tone.bytes(self.seen()).into_iter().map(opaque).collect());
        let stride = (image.width * image.height).div_ceil(COUNTED).max(1);
        self.histograms = (0..image.bands.len()).into_par_iter().map(|b| Histogram::of(image.band(b).step_by(stride))).collect();
        self.times.colours = start.elapsed().as_secs_f64();
    }

    /// Puts the scene's stars over a picture that has none, in the pixels of `camera`.
    ///
    /// # Errors
    /// If a star's light cannot be computed.
    pub fn spark(&mut self, camera: &Camera) -> Result<()> {
        let start = Instant::now();
        let plan = self.plan.clone().with_size(camera.width, camera.height);
        let (bands, size) = (self.image.bands.len(), camera.width * camera.height);
        let mut light = vec![0.0; bands * size];
        let _ = backend::draw(Sources::PREVIEW, &plan, &Control::default(), |i, value| light[i] += value)?;
        let (image, colours, tone, code) = (&self.image, &self.colours, &self.tone, self.tone.coder());
        let spark = |pixel: usize| {
            let radiance = |b: usize| light[b * size + pixel];
            if (0..bands).all(|b| radiance(b) == 0.0) {
                return TRANSPARENT;
            }
            let (column, row) = (pixel % camera.width, pixel / camera.width);
            let (x, y) = (column * image.width / camera.width, row * image.height / camera.height);
            let with = opaque(code(tone.palette.rgb((0..bands).map(|b| radiance(b) + image.at(b, y, x)))));
            // The wings of a star that nobody can see are none.
            if with == colours[y * image.width + x] { TRANSPARENT } else { with }
        };
        let colours = (0..size).into_par_iter().map(spark).collect();
        self.sparks = Some(Arc::new(Overlay { size: [camera.width, camera.height], colours }));
        self.times.stars = start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Colours of what `other` differs from this, amplified; both as this one is shown.
    pub fn difference(&self, other: &Self) -> Vec<Rgba> {
        let (ours, other) = (self.tone.picture(self.seen()), self.tone.picture(other.seen()));
        let one = |(a, b): (&[f64; 3], &[f64; 3])| {
            let amplified = |i: usize| (f64::from(AMPLIFIED) * (a[i] - b[i]).abs()).min(1.0);
            opaque(std::array::from_fn(|i| (amplified(i) * 255.0 + 0.5) as u8))
        };
        ours.iter().zip(&other).map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histograms_count_pixels() {
        let histogram = Histogram::of([0.0, 1e-3, 1e-3, 1e-9, 1.0, f64::NAN].into_iter());
        assert_eq!(histogram.range, (-5.0, 1.0));
        assert_eq!(histogram.counts.iter().sum::<u32>(), 3);
        assert_eq!((histogram.counts[BINS / 3], histogram.counts[BINS * 5 / 6]), (2, 1));
    }
}
