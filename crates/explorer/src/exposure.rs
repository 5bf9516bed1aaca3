//! The levels that pictures are shown by. A picture is measured once, when it has settled; from then on white and the
//! balance of its bands stay as they were while things move and settle again, so that brighter looks brighter and
//! colours keep still.

use barnard::Scene;
use barnard::image::{Display, Image, Level, Tone};
use spectra::colour::Palette;

/// The factor by which the white that a settled picture asks for may lie from the one in use, either way: beyond,
/// the picture would be all black or all white.
const RANGE: f64 = 10.0;

/// Levels of earlier pictures.
#[derive(Default)]
pub struct Exposure {
    /// The latest last: who goes back to a palette finds its levels as they were.
    tones: Vec<MeasuredTone>,
}

/// Most levels that are kept.
const MOST: usize = 16;

/// Levels, and what they were measured for.
struct MeasuredTone {
    /// The number of times that they had been asked for anew.
    asked: u64,
    bands: Vec<String>,
    palette: Palette,
    balance: bool,
    /// The levels, with the white that the picture asked for, whatever the scene says.
    tone: Tone,
    /// True if that picture had settled.
    settled: bool,
}

impl Exposure {
    /// The levels of `image` in a scene with `display`, where levels were asked for anew `asked` times: those that are
    /// in use, if they are of the same bands and colours.
    pub fn tone(&mut self, asked: u64, display: &Display, image: &Image, settled: bool) -> Tone {
        let holds = |known: &MeasuredTone| {
            let same = known.asked == asked
                && known.bands.iter().eq(image.bands.iter().map(|b| &b.name))
                && known.palette == display.palette
                && known.balance == display.balance;
            same && (known.settled || !settled) && !(settled && known.is_off(display, image))
        };
        let known = match self.tones.iter().position(holds) {
            Some(number) => self.tones.remove(number),
            None => MeasuredTone {
                asked,
                bands: image.bands.iter().map(|band| band.name.clone()).collect(),
                palette: display.palette.clone(),
                balance: display.balance,
                tone: Display { white: Level::Auto, ..display.clone() }.tone(image),
                settled,
            },
        };
        let black = match display.black {
            Level::Auto => 0.0,
            Level::Radiance(black) => black,
        };
        let white = match display.white {
            Level::Auto => known.tone.white.max(black + f64::MIN_POSITIVE),
            Level::Radiance(white) => white,
        };
        let tone = Tone { black, white, stretch: display.stretch, ..known.tone.clone() };
        // What was held of the same colours holds no longer.
        self.tones.retain(|tone| !(tone.palette == known.palette && tone.balance == known.balance && tone.bands == known.bands));
        self.tones.push(known);
        self.tones.drain(..self.tones.len().saturating_sub(MOST));
        tone
    }
}

impl Exposure {
    /// Levels of the latest settled picture: white, then the columns of the balanced palette. `None` if no picture has settled.
    pub fn levels(&self, asked: u64) -> Option<Vec<f64>> {
        let MeasuredTone { tone, .. } = self.tones.last().filter(|known| known.settled && known.asked == asked)?;
        Some([tone.white].into_iter().chain(tone.palette.columns.as_flattened().iter().copied()).collect())
    }

    /// Takes [levels](Self::levels) of another exposure of the same scene; others are dropped.
    pub fn take_levels(&mut self, asked: u64, scene: &Scene, levels: Option<&[f64]>) {
        self.tones.clear();
        let Some([white, columns @ ..]) = levels.filter(|levels| levels.len() == 1 + 3 * scene.bands.len()) else { return };
        let (columns, _) = columns.as_chunks();
        let Display { palette, balance, stretch, .. } = &scene.display;
        self.tones.push(MeasuredTone {
            asked,
            bands: scene.bands.iter().map(|band| band.name().to_owned()).collect(),
            palette: palette.clone(),
            balance: *balance,
            tone: Tone { palette: Palette { columns: columns.to_vec() }, black: 0.0, white: *white, stretch: *stretch },
            settled: true,
        });
    }
}

impl MeasuredTone {
    /// True if little could be seen of a picture by these levels.
    fn is_off(&self, display: &Display, image: &Image) -> bool {
        let Level::Auto = display.white else { return false };
        let display_now = Display { white: Level::Auto, balance: false, palette: self.tone.palette.clone(), ..display.clone() }.tone(image);
        let ratio = display_now.white / self.tone.white;
        !(1.0 / RANGE..=RANGE).contains(&ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Document;
    use barnard::image::Samples;

    fn image(level: f32) -> Image {
        let values = (0..300).map(|i| level * (1 + i % 100) as f32).collect();
        Image::bare(10, 10, ["a", "b", "c"].map(str::to_owned).to_vec(), Samples::Single(values))
    }

    /// White stays where a settled picture had it, whatever moves; it is measured anew where somebody asks, where other
    /// bands or colours are shown, and where nothing could be seen.
    #[test]
    fn white_is_held() {
        let display = Document::builtin("barres_neyret", 1 << 32).unwrap().scene().display.clone();
        let mut exposure = Exposure::default();
        let white = |exposure: &mut Exposure, asked, level, settled| exposure.tone(asked, &display, &image(level), settled).white;
        let first = white(&mut exposure, 0, 1.0, false);
        assert_eq!(white(&mut exposure, 0, 3.0, false), first, "a first look is held while things move");
        let settled = white(&mut exposure, 0, 1.5, true);
        assert!((settled / first - 1.5).abs() < 1e-6, "a settled picture is measured");
        for (level, still) in [(2.0, false), (2.0, true), (0.3, false), (0.3, true)] {
            assert_eq!(white(&mut exposure, 0, level, still), settled, "{level}");
        }
        assert_eq!(white(&mut exposure, 0, 30.0, false), settled, "nothing jumps while it moves");
        assert!((white(&mut exposure, 0, 30.0, true) / settled - 20.0).abs() < 1e-4, "all would be white");
        assert!((white(&mut exposure, 1, 15.0, true) / settled - 10.0).abs() < 1e-4, "asked for anew");
        let balanced = Display { balance: !display.balance, ..display.clone() };
        let other = exposure.tone(1, &balanced, &image(15.0), true);
        assert_ne!(other.palette, display.palette, "bands are balanced anew");
        assert_eq!(exposure.tone(1, &display, &image(3.0), true).white, 10.0 * settled, "whoever goes back finds what was held");
        let scene = Document::builtin("barres_neyret", 1 << 32).unwrap().scene().clone();
        let mut other_exposure = Exposure::default();
        let bands = scene.bands.iter().map(|band| band.name().to_owned()).collect();
        let named = |level: f32| Image::bare(10, 10, bands, Samples::Single((0..300).map(|i| level * (1 + i % 100) as f32).collect()));
        let measured = other_exposure.tone(0, &display, &named(2.0), true);
        let levels = other_exposure.levels(0).unwrap();
        assert_eq!((levels[0], levels.len(), other_exposure.levels(1)), (measured.white, 10, None));
        let mut taking = Exposure::default();
        taking.take_levels(3, &scene, Some(&levels));
        assert_eq!(taking.levels(3).unwrap(), levels, "levels are handed over");
        taking.take_levels(3, &scene, None);
        assert_eq!(taking.levels(3), None);
        let display = Display { white: Level::Radiance(7.0), ..balanced };
        assert_eq!(exposure.tone(1, &display, &image(15.0), true), Tone { white: 7.0, ..other });
    }
}
