//! How radiances become a picture on a display.

use std::cell::OnceCell;

use rayon::prelude::*;
use spectra::colour::{Palette, Stretch};
use spectra::passband::Passband;

use super::levels::LevelPixels;
use super::{Glare, Image};
use crate::error::{Error, Result};

/// The radiance that becomes black or white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Level {
    /// The level is found from the picture.
    Auto,
    /// A radiance, after the palette [W m⁻² sr⁻¹].
    Radiance(f64),
}

impl Level {
    /// The radiance, if it is stated [W m⁻² sr⁻¹].
    pub fn radiance(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Radiance(radiance) => Some(radiance),
        }
    }
}

impl From<Option<f64>> for Level {
    fn from(radiance: Option<f64>) -> Self {
        radiance.map_or(Self::Auto, Self::Radiance)
    }
}

/// How radiances become a picture on a display.
#[derive(Debug, Clone, PartialEq)]
pub struct Display {
    /// The matrix from bands to linear RGB.
    pub palette: Palette,
    /// True if each band is scaled to its own white level before the palette mixes them.
    pub balance: bool,
    /// The curve from radiances to brightness.
    pub stretch: Stretch,
    /// The level that becomes black.
    pub black: Level,
    /// The level that becomes white.
    pub white: Level,
    /// Bits of each colour, 8 or 16, in formats that have both.
    pub bits: u8,
    /// Glare of bright points, if any.
    pub glare: Option<Glare>,
}

impl Display {
    /// Refuses levels that show no picture.
    ///
    /// # Errors
    /// If a level is no number, white is not above black, colours have other bits than 8 or 16, or no optics have such a glare.
    pub fn check(&self) -> Result<()> {
        let number = |level: Level| match level {
            Level::Auto => None,
            Level::Radiance(value) => Some(value),
        };
        let (black, white) = (number(self.black), number(self.white));
        for (what, level) in [("black level", black), ("white level", white)] {
            if let Some(value) = level.filter(|v| !v.is_finite()) {
                return Err(Error::out_of_range(what, value, "a finite radiance"));
            }
        }
        if ![8, 16].contains(&self.bits) {
            return Err(Error::out_of_range("bits of a colour", self.bits, "8 or 16"));
        }
        self.glare.map_or(Ok(()), |glare| glare.check())?;
        match (black, white) {
            (Some(black), Some(white)) if white <= black => {
                Err(Error::out_of_range("white level", white, format!("above the black level, {black}")))
            }
            _ => Ok(()),
        }
    }
}

/// Part of the pixels that is darker than an automatic white.
const WHITE_PERCENTILE: f64 = 0.998;

/// Gaps of a stretch's table at equal steps of the fourth root, since stretches are steep in the dark; of the
/// encoding's at equal steps of the square root.
const STRETCH_GAPS: usize = 1024;
const CODE_GAPS: usize = 4096;

/// Conversion of the bands of a pixel to a colour: a display whose levels are numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Tone {
    /// The matrix from balanced bands to linear RGB.
    pub palette: Palette,
    /// Zero of the stretch [W m⁻² sr⁻¹, or of the balanced band].
    pub black: f64,
    /// The level that becomes white.
    pub white: f64,
    /// The curve from radiances to brightness.
    pub stretch: Stretch,
}

impl Tone {
    /// The picture, height × width × RGB in sRGB encoding [0, 1].
    pub fn picture(&self, image: &Image) -> Vec<[f64; 3]> {
        linear(self, image).map(|p| self.encoded(p)).collect()
    }

    /// The picture in bytes, height × width × RGB, by tables: for windows, fast, and at most one level from the exact
    /// one.
    pub fn bytes(&self, image: &Image) -> Vec<[u8; 3]> {
        linear(self, image).map(self.coder()).collect()
    }

    /// Conversion of palette colours to bytes, by the tables of [`Tone::bytes`].
    pub fn coder(&self) -> impl Fn([f64; 3]) -> [u8; 3] + Sync {
        let stretch = self.stretch_table();
        let code = |i: usize| (255.0 * spectra::colour::srgb_encode((i as f64 / CODE_GAPS as f64).powi(2)) + 0.5) as u8;
        let codes: Vec<u8> = (0..=CODE_GAPS).map(code).collect();
        let (black, range) = (self.black, 1.0 / (self.white - self.black));
        move |linear: [f64; 3]| {
            let scaled = linear.map(|v| ((v - black) * range).max(0.0));
            let brightest = scaled[0].max(scaled[1]).max(scaled[2]);
            if brightest.is_nan() || brightest <= 0.0 {
                return [0; 3];
            }
            let u = brightest.min(1.0).sqrt().sqrt() * STRETCH_GAPS as f64;
            let gap = (u as usize).min(STRETCH_GAPS - 1);
            let gain = (stretch[gap] + (u - gap as f64) * (stretch[gap + 1] - stretch[gap])) / brightest;
            let pale = 1.0 - 1.0 / brightest.max(1.0);
            scaled.map(|v| {
                let bright = v * gain;
                codes[((bright + pale * (1.0 - bright)).clamp(0.0, 1.0).sqrt() * CODE_GAPS as f64 + 0.5) as usize]
            })
        }
    }

    /// The stretch at equal steps of the fourth root of what it stretches, from 0 to 1.
    pub fn stretch_table(&self) -> Vec<f64> {
        (0..=STRETCH_GAPS).map(|i| self.stretch.apply((i as f64 / STRETCH_GAPS as f64).powi(4))).collect()
    }

    /// A linear colour between black and white, in sRGB encoding [0, 1].
    fn encoded(&self, linear: [f64; 3]) -> [f64; 3] {
        let scaled = linear.map(|v| (v - self.black) / (self.white - self.black));
        self.stretch.apply_rgb(scaled).map(spectra::colour::srgb_encode)
    }
}

impl Display {
    /// Default display of these passbands: in natural colours, or those of red, green and
    /// blue outside of the visible; black is zero, white found from the picture.
    pub fn of(bands: &[Passband]) -> Self {
        let palette = Palette::by_name("natural", bands).or_else(|_| Palette::by_name("rgb", bands));
        Self { palette: palette.unwrap_or_else(|_| Palette::grey(bands.len())), ..Self::grey(bands.len()) }
    }

    /// A display that shows all bands alike, in shades of grey.
    pub fn grey(bands: usize) -> Self {
        Self {
            palette: Palette::grey(bands),
            balance: false,
            stretch: Stretch::default(),
            black: Level::Auto,
            white: Level::Auto,
            bits: 8,
            glare: None,
        }
    }

    /// The levels that `image` asks for.
    pub fn tone(&self, image: &Image) -> Tone {
        let pixels = OnceCell::new();
        let percentile =
            |value: &(dyn Fn(&[f64]) -> f64 + Sync)| pixels.get_or_init(|| LevelPixels::of(image)).percentile(WHITE_PERCENTILE, value);
        let gain = |b: usize| {
            let white = if self.balance { percentile(&|bands| bands[b]) } else { 1.0 };
            if white > 0.0 { 1.0 / white } else { 1.0 }
        };
        let columns = self.palette.columns.iter().enumerate().map(|(b, column)| column.map(|c| c * gain(b))).collect();
        let black = match self.black {
            Level::Auto => 0.0,
            Level::Radiance(v) => v,
        };
        let mut tone = Tone { palette: Palette { columns }, black, white: 0.0, stretch: self.stretch };
        tone.white = match self.white {
            Level::Auto => {
                let brightness = |bands: &[f64]| tone.palette.rgb(bands.iter().copied()).into_iter().fold(0.0, f64::max);
                percentile(&brightness).max(black + f64::MIN_POSITIVE)
            }
            Level::Radiance(v) => v,
        };
        tone
    }

    /// The picture, height × width × RGB in sRGB encoding [0, 1], with its glare; levels are those of the image without it.
    pub fn picture(&self, image: &Image) -> Vec<[f64; 3]> {
        let tone = self.tone(image);
        match &self.glare {
            Some(glare) => tone.picture(&glare.seen(image, tone.white)),
            None => tone.picture(image),
        }
    }
}

/// The pixels of an image as linear colours.
fn linear(tone: &Tone, image: &Image) -> impl IndexedParallelIterator<Item = [f64; 3]> {
    let size = image.width * image.height;
    (0..size).into_par_iter().map(move |i| tone.palette.rgb((0..image.bands.len()).map(|b| image.samples.at(b * size + i))))
}

#[cfg(test)]
mod tests {
    use super::super::Samples;
    use super::*;
    use spectra::colour::STRETCHES;

    /// Bytes by tables are those of the exact picture, one level at most aside, in every stretch, from black to far
    /// above white.
    #[test]
    fn quick_bytes_are_the_picture() {
        let value = |i: usize| 10f64.powf(-7.0 + 9.0 * (i as f64 * 0.618_034).fract()) as f32;
        let (width, height) = (128, 64);
        let names = ["a", "b", "c"].map(str::to_owned).to_vec();
        let image = Image::bare(width, height, names, Samples::Single((0..3 * width * height).map(value).collect()));
        let palette = Palette { columns: vec![[0.1, 0.2, 1.0], [0.2, 1.0, 0.1], [1.0, 0.0, 0.1]] };
        for entry in STRETCHES {
            let tone = Tone { palette: palette.clone(), black: 1e-3, white: 2.0, stretch: Stretch::by_name(entry.name, None).unwrap() };
            let exact = tone.picture(&image).into_iter().map(|p| p.map(|v| (v * 255.0 + 0.5) as u8));
            let steps: Vec<u8> = tone.bytes(&image).iter().zip(exact).flat_map(|(a, b)| (0..3).map(move |c| a[c].abs_diff(b[c]))).collect();
            assert!(steps.iter().all(|s| *s <= 1), "{}: {:?}", entry.name, steps.iter().max());
            assert!(steps.iter().filter(|s| **s == 1).count() < steps.len() / 20, "{}", entry.name);
        }
    }
}
