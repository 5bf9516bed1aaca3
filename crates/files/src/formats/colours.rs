//! The colours of pictures in whole numbers, for the formats that hold those.

use barnard::image::{Display, Image};
use barnard::random::Counter;

/// The seed of the dither.
const SEED: u64 = 8;

/// The picture in bytes, height × width × red, green, blue in sRGB. Between two levels chance decides, by pixel and colour: so
/// that a slow change of brightness shows no bands, and a picture has the same bytes wherever it is made. Black stays black, and
/// white white.
pub(super) fn bytes(image: &Image, display: &Display) -> Vec<u8> {
    let level = |i: usize, c: usize, v: f64| {
        let whole = (255.0 * v).floor();
        let part = 255.0 * v - whole;
        (whole + f64::from(u8::from(Counter::nested(SEED, i as u64, c as u64).uniform() < part))) as u8
    };
    let picture = display.picture(image);
    picture.iter().enumerate().flat_map(|(i, pixel)| std::array::from_fn::<u8, 3, _>(|c| level(i, c, pixel[c]))).collect()
}

/// Variant in sixteen bits, which no eye distinguishes.
pub(super) fn words(image: &Image, display: &Display) -> Vec<u16> {
    display.picture(image).iter().flatten().map(|v| (65535.0 * v + 0.5) as u16).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use barnard::image::{Level, Samples};
    use spectra::colour::{Palette, Stretch};

    /// A ramp of three levels over a thousand pixels: the mean of neighbours follows it to a tenth of a level, where rounding is
    /// half a level off; black and white are exact, and the bytes are the same again.
    #[test]
    fn ramps_have_no_bands() {
        let (width, steps) = (3000usize, 3.0);
        let srgb = |i: usize| (100.0 + steps * i as f64 / width as f64) / 255.0;
        let linear = |v: f64| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
        let values: Vec<f64> = (0..width).map(|i| linear(srgb(i))).chain([0.0, 1.0]).collect();
        let image = Image::bare(width + 2, 1, vec!["a".into()], Samples::Double(values));
        let stretch = Stretch::by_name("linear", None).unwrap();
        let display = Display { palette: Palette { columns: vec![[1.0; 3]] }, stretch, white: Level::Radiance(1.0), ..Display::grey(1) };
        let (bytes, words) = (bytes(&image, &display), words(&image, &display));
        assert_eq!((&bytes[3 * width..], bytes.len()), (&[0, 0, 0, 255, 255, 255][..], 3 * (width + 2)));
        assert_eq!(bytes, super::bytes(&image, &display));
        let mean = |from: usize, quantity: &dyn Fn(usize) -> f64| (from..from + 300).map(quantity).sum::<f64>() / 300.0;
        for from in (0..2700).step_by(100) {
            let truth = mean(from, &|i| 255.0 * srgb(i));
            let dithered = mean(from, &|i| (0..3).map(|c| f64::from(bytes[3 * i + c])).sum::<f64>() / 3.0);
            assert!((dithered - truth).abs() < 0.1, "{from} {dithered} {truth}");
            let fine = mean(from, &|i| f64::from(words[3 * i]) / 257.0);
            assert!((fine - truth).abs() < 0.01);
        }
        let rounded = mean(400, &|i| (255.0 * srgb(i)).round());
        assert!((rounded - mean(400, &|i| 255.0 * srgb(i))).abs() > 0.1, "rounding shows bands");
    }
}
