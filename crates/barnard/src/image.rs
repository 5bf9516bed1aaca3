//! Images: linear band radiance with everything a reader needs to use it.

use rayon::prelude::*;
use spectra::colour::{Palette, Stretch};
use spectra::passband::Passband;

use crate::error::{Error, Result};
use crate::keywords::Keyword;

/// Band radiances, bands × height × width [W m⁻² sr⁻¹].
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// The values of a back end in single precision.
    Single(Vec<f32>),
    /// The values of a back end in double precision.
    Double(Vec<f64>),
}

impl Samples {
    /// The value at a position in the array.
    pub fn at(&self, index: usize) -> f64 {
        match self {
            Samples::Single(v) => f64::from(v[index]),
            Samples::Double(v) => v[index],
        }
    }

    /// Adds to the value at a position.
    pub fn add(&mut self, index: usize, value: f64) {
        match self {
            Samples::Single(v) => v[index] += value as f32,
            Samples::Double(v) => v[index] += value,
        }
    }

    /// The number of values.
    pub fn len(&self) -> usize {
        match self {
            Samples::Single(v) => v.len(),
            Samples::Double(v) => v.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// One band of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// The name of the passband.
    pub name: String,
    /// Pivot wavelength \[µm\], where known.
    pub pivot_um: Option<f64>,
    /// "energy" or "photon", where known.
    pub counting: Option<&'static str>,
    /// ∫ R dλ \[µm\], to turn band radiance into mean spectral radiance.
    pub width_um: Option<f64>,
    /// The certificate in words, a line for each source.
    pub certificate: Vec<String>,
    /// What the band says of itself in keywords.
    pub keywords: Vec<Keyword>,
}

/// What the name of a band of standard errors ends with, after the name of the band that they are of.
pub const ERROR_SUFFIX: &str = "_error";

/// The size of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PixelScale {
    /// Angle at the middle of the image \[deg\].
    Angle(f64),
    /// Length \[pc\], under an orthographic camera.
    Length(f64),
    /// Angle on a dome, the same along each line through the middle \[deg\].
    Equidistant(f64),
    /// Angle of longitude and of latitude \[deg\].
    PlateCarree(f64),
    /// Angle in the middle of each face of a cube \[deg\].
    OnCube(f64),
}

impl PixelScale {
    /// Its number and its unit, "deg" or "pc".
    pub fn in_unit(self) -> (f64, &'static str) {
        match self {
            Self::Angle(degrees) | Self::Equidistant(degrees) | Self::PlateCarree(degrees) | Self::OnCube(degrees) => (degrees, "deg"),
            Self::Length(pc) => (pc, "pc"),
        }
    }
}

/// A rendered image.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// The number of pixels along a row.
    pub width: usize,
    /// Rows, the first on top.
    pub height: usize,
    /// The bands, in the order of the samples.
    pub bands: Vec<Band>,
    /// The radiances, bands × height × width.
    pub samples: Samples,
    /// Size of a pixel, where known.
    pub pixel: Option<PixelScale>,
    /// Where the axis of view meets the image, from its middle to the right and upwards \[pixels\].
    pub axis: (f64, f64),
    /// Key and value, in words: scene, back end, method, accuracy.
    pub notes: Vec<(String, String)>,
    /// What the picture says of itself in keywords.
    pub keywords: Vec<Keyword>,
    /// How the picture is shown on a display.
    pub display: Display,
}

impl Image {
    /// An image of which only names and values are known.
    pub fn bare(width: usize, height: usize, names: Vec<String>, samples: Samples) -> Self {
        let band = |name| Band { name, pivot_um: None, counting: None, width_um: None, certificate: Vec::new(), keywords: Vec::new() };
        let bands: Vec<Band> = names.into_iter().map(band).collect();
        let display = Display::grey(bands.len());
        Self { width, height, bands, samples, pixel: None, axis: (0.0, 0.0), notes: Vec::new(), keywords: Vec::new(), display }
    }

    /// Radiance of a pixel in a band [W m⁻² sr⁻¹].
    pub fn at(&self, band: usize, row: usize, column: usize) -> f64 {
        self.samples.at((band * self.height + row) * self.width + column)
    }

    /// Refuses values that are no numbers: sums that went past the range of f32.
    ///
    /// # Errors
    /// Where there are some, with their number and band.
    pub fn check(&self) -> Result<()> {
        for (b, band) in self.bands.iter().enumerate() {
            let count = self.band(b).filter(|v| !v.is_finite()).count();
            if count > 0 {
                let reason = format!(
                    "{count} pixels of band {} are NaN or infinite: densities or spectra are too large for single precision",
                    band.name
                );
                return Err(Error::Strength(reason));
            }
        }
        Ok(())
    }

    /// Relative rms difference of a band from one of `truth`, √Σ(a − b)² / √Σb²; zero where they are equal.
    pub fn relative_rmse(&self, band: usize, truth: &Self, truth_band: usize) -> f64 {
        relative_rms(self.band(band).zip(truth.band(truth_band)))
    }

    /// The band of the standard errors of band `of`, where there is one.
    pub fn errors_of(&self, of: usize) -> Option<usize> {
        self.bands.iter().position(|band| band.name.strip_suffix(ERROR_SUFFIX) == Some(&self.bands[of].name))
    }

    /// Whether a band holds the standard errors of another.
    pub fn is_error(&self, band: usize) -> bool {
        (0..self.bands.len()).any(|of| self.errors_of(of) == Some(band))
    }

    /// The bands that are radiances, without those of standard errors.
    pub fn radiances(&self) -> impl Iterator<Item = usize> + '_ {
        let errors: Vec<usize> = (0..self.bands.len()).filter_map(|b| self.errors_of(b)).collect();
        (0..self.bands.len()).filter(move |b| !errors.contains(b))
    }

    /// The values of one band, row by row.
    pub fn band(&self, band: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        let size = self.width * self.height;
        (band * size..(band + 1) * size).map(|i| self.samples.at(i))
    }
}

/// Relative rms difference of pairs (a, b), √Σ(a − b)² / √Σb²; zero where they are equal, NaN where one is no number.
pub fn relative_rms(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (squares, size) = pairs.fold((0.0, 0.0), |(squares, size), (a, b)| (squares + (a - b).powi(2), size + b * b));
    if squares == 0.0 { 0.0 } else { (squares / size).sqrt() }
}

/// The largest of some errors; NaN where one is NaN.
pub fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |worst, error| if error <= worst || worst.is_nan() { worst } else { error })
}

/// The radiance that becomes black or white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Level {
    /// The level is found from the picture.
    Auto,
    /// A radiance, after the palette [W m⁻² sr⁻¹].
    Radiance(f64),
}

/// How radiances become a picture on a display.
#[derive(Debug, Clone, PartialEq)]
pub struct Display {
    /// The matrix from bands to linear RGB.
    pub palette: Palette,
    /// Whether each band is scaled to its own white level before the palette mixes them.
    pub balance: bool,
    /// The curve from radiances to brightness.
    pub stretch: Stretch,
    /// The level that becomes black.
    pub black: Level,
    /// The level that becomes white.
    pub white: Level,
    /// Bits of each colour, 8 or 16, in formats that have both.
    pub bits: u8,
}

impl Display {
    /// Refuses levels that show no picture.
    ///
    /// # Errors
    /// Where a level is no number, white is not above black, or colours have other bits than 8 or 16.
    pub fn check(&self) -> Result<()> {
        let number = |level: Level| match level {
            Level::Auto => None,
            Level::Radiance(value) => Some(value),
        };
        let (black, white) = (number(self.black), number(self.white));
        for (what, level) in [("black level", black), ("white level", white)] {
            if let Some(value) = level.filter(|v| !v.is_finite()) {
                return Err(Error::value(what, value, "a radiance"));
            }
        }
        if ![8, 16].contains(&self.bits) {
            return Err(Error::value("bits of a colour", self.bits, "8 or 16"));
        }
        match (black, white) {
            (Some(black), Some(white)) if white <= black => {
                Err(Error::value("white level", white, format!("above the black one, {black}")))
            }
            _ => Ok(()),
        }
    }
}

/// The part of the pixels that may be brighter than an automatic white.
const WHITE_PERCENTILE: f64 = 0.998;

/// Gaps of a stretch's table at equal steps of the fourth root, since stretches are steep in the dark; of the
/// encoding's at equal steps of the square root.
const STRETCH_GAPS: usize = 1024;
const CODE_GAPS: usize = 4096;

/// How the bands of a pixel become a colour: a display whose levels are numbers.
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

    /// What makes bytes of a colour that the palette gave, by the tables of [`Tone::bytes`].
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
    /// As pictures of these passbands are shown that nothing is said of: in natural colours, or those of red, green and
    /// blue outside of the visible; black is zero, white found from the picture.
    pub fn of(bands: &[Passband]) -> Self {
        let palette = Palette::named("natural", bands).or_else(|_| Palette::named("rgb", bands));
        Self { palette: palette.unwrap_or_else(|_| Palette::grey(bands.len())), ..Self::grey(bands.len()) }
    }

    /// A display that shows all bands alike, in shades of grey.
    pub fn grey(bands: usize) -> Self {
        Self { palette: Palette::grey(bands), balance: false, stretch: Stretch::default(), black: Level::Auto, white: Level::Auto, bits: 8 }
    }

    /// The levels that `image` asks for.
    pub fn tone(&self, image: &Image) -> Tone {
        let gain = |b: usize| if self.balance { gain(image.band(b)) } else { 1.0 };
        let columns = self.palette.columns.iter().enumerate().map(|(b, column)| column.map(|c| c * gain(b))).collect();
        let black = match self.black {
            Level::Auto => 0.0,
            Level::Radiance(v) => v,
        };
        let mut tone = Tone { palette: Palette { columns }, black, white: 0.0, stretch: self.stretch };
        tone.white = match self.white {
            Level::Auto => {
                let brightness = linear(&tone, image).map(|p| p.into_iter().fold(0.0, f64::max));
                percentile(brightness.collect(), WHITE_PERCENTILE).max(black + f64::MIN_POSITIVE)
            }
            Level::Radiance(v) => v,
        };
        tone
    }

    /// The picture, height × width × RGB in sRGB encoding [0, 1].
    pub fn picture(&self, image: &Image) -> Vec<[f64; 3]> {
        self.tone(image).picture(image)
    }
}

/// The pixels of an image as linear colours.
fn linear(tone: &Tone, image: &Image) -> impl IndexedParallelIterator<Item = [f64; 3]> {
    let size = image.width * image.height;
    (0..size).into_par_iter().map(move |i| tone.palette.rgb((0..image.bands.len()).map(|b| image.samples.at(b * size + i))))
}

fn gain(values: impl Iterator<Item = f64>) -> f64 {
    let white = percentile(values.collect(), WHITE_PERCENTILE);
    if white > 0.0 { 1.0 / white } else { 1.0 }
}

/// The value below which the part `p` of the finite positive `values` lies; zero where there are none.
fn percentile(mut values: Vec<f64>, p: f64) -> f64 {
    values.retain(|v| v.is_finite() && *v > 0.0);
    if values.is_empty() {
        return 0.0;
    }
    let index = ((values.len() - 1) as f64 * p) as usize;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use spectra::colour::STRETCHES;

    /// Standard errors are those of a band that is there; a filter of one's own may be called like them.
    #[test]
    fn errors_have_a_band() {
        let image =
            |names: &[&str]| Image::bare(1, 1, names.iter().map(|n| (*n).to_owned()).collect(), Samples::Double(vec![0.0; names.len()]));
        let radiances = |names: &[&str]| image(names).radiances().collect::<Vec<_>>();
        assert_eq!(radiances(&["V", "V_error", "tracking_error"]), [0, 2]);
        assert_eq!(radiances(&["V_error"]), [0]);
        assert_eq!(image(&["B", "V", "B_error", "V_error"]).errors_of(1), Some(3));
        assert_eq!(image(&["B", "V_error"]).errors_of(0), None);
    }

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
            let tone = Tone { palette: palette.clone(), black: 1e-3, white: 2.0, stretch: Stretch::named(entry.name, None).unwrap() };
            let exact = tone.picture(&image).into_iter().map(|p| p.map(|v| (v * 255.0 + 0.5) as u8));
            let steps: Vec<u8> = tone.bytes(&image).iter().zip(exact).flat_map(|(a, b)| (0..3).map(move |c| a[c].abs_diff(b[c]))).collect();
            assert!(steps.iter().all(|s| *s <= 1), "{}: {:?}", entry.name, steps.iter().max());
            assert!(steps.iter().filter(|s| **s == 1).count() < steps.len() / 20, "{}", entry.name);
        }
    }
}
