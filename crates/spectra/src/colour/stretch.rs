//! Stretches: curves from radiance to display brightness.
//!
//! | name | y(x), x = (v − black)/(white − black) | source |
//! |---|---|---|
//! | linear | x | |
//! | asinh | asinh(s x)/asinh(s) | Lupton et al. 2004, PASP 116, 133 |
//! | log | ln(1 + s x)/ln(1 + s) | as in DS9 |
//! | midtone | (m − 1) x / ((2m − 1) x − m) | midtone transfer function of PixInsight |
//!
//! The stretch acts on the brightest of a pixel's colours and scales the others with it, so hues stay.

use crate::error::{Result, SpectraError};

/// A curve on [0, 1] with its parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    entry: &'static StretchEntry,
    /// The strength s or m of the table above \[1\].
    pub strength: f64,
}

/// One row of the catalogue of stretches.
#[derive(Debug)]
pub struct StretchEntry {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    default_strength: f64,
    range: (f64, f64),
    curve: fn(f64, f64) -> f64,
}

impl PartialEq for StretchEntry {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// All stretches.
pub const STRETCHES: &[StretchEntry] = &[
    StretchEntry {
        name: "asinh",
        summary: "asinh(s x)/asinh(s), s = 30 by default: faint and bright parts together (default)",
        default_strength: 30.0,
        range: (1e-3, 1e9),
        curve: |x, s| (s * x).asinh() / s.asinh(),
    },
    StretchEntry { name: "linear", summary: "as it is", default_strength: 1.0, range: (0.0, f64::MAX), curve: |x, _| x },
    StretchEntry {
        name: "log",
        summary: "ln(1 + s x)/ln(1 + s), s = 1000 by default",
        default_strength: 1000.0,
        range: (1e-3, 1e9),
        curve: |x, s| (s * x).ln_1p() / s.ln_1p(),
    },
    StretchEntry {
        name: "midtone",
        summary: "midtone transfer with midtone m = 0.1 by default",
        default_strength: 0.1,
        range: (1e-6, 1.0 - 1e-6),
        curve: |x, m| (m - 1.0) * x / ((2.0 * m - 1.0) * x - m),
    },
];

impl Default for Stretch {
    /// The first of the catalogue.
    fn default() -> Self {
        Self { entry: &STRETCHES[0], strength: STRETCHES[0].default_strength }
    }
}

impl Stretch {
    /// The stretch called `name`; `strength` is its parameter, the default if not given.
    ///
    /// # Errors
    /// If there is no such stretch, or its parameter lies outside of what it takes.
    pub fn by_name(name: &str, strength: Option<f64>) -> Result<Self> {
        let known: Vec<&str> = STRETCHES.iter().map(|s| s.name).collect();
        let entry = STRETCHES.iter().find(|s| s.name == name).ok_or_else(|| SpectraError::unknown("stretch", name, &known))?;
        let strength = strength.unwrap_or(entry.default_strength);
        let (low, high) = entry.range;
        if !(low..=high).contains(&strength) {
            return Err(SpectraError::Range { what: format!("strength of stretch \"{name}\""), value: strength, low, high });
        }
        Ok(Self { entry, strength })
    }

    /// The brightness y(x); x below zero is black, above one white.
    pub fn apply(&self, x: f64) -> f64 {
        (self.entry.curve)(x.clamp(0.0, 1.0), self.strength)
    }

    /// The name in the catalogue.
    pub fn name(&self) -> &'static str {
        self.entry.name
    }

    /// A stretched colour: the brightest channel follows the curve, the others keep their ratio to it; what is
    /// overexposed pales to white.
    pub fn apply_rgb(&self, rgb: [f64; 3]) -> [f64; 3] {
        let brightest = rgb.iter().copied().fold(0.0, f64::max);
        if brightest <= 0.0 {
            return [0.0; 3];
        }
        let gain = self.apply(brightest) / brightest;
        let pale = 1.0 - 1.0 / brightest.max(1.0);
        rgb.map(|v| v.max(0.0) * gain).map(|v| v + pale * (1.0 - v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stretch_goes_from_black_to_white_and_ascends() {
        for entry in STRETCHES {
            let stretch = Stretch::by_name(entry.name, None).unwrap();
            assert!(stretch.apply(0.0).abs() < 1e-12 && (stretch.apply(1.0) - 1.0).abs() < 1e-12, "{}", entry.name);
            assert!((0..100).all(|i| stretch.apply(i as f64 / 100.0) < stretch.apply((i + 1) as f64 / 100.0)), "{}", entry.name);
        }
    }

    #[test]
    fn midtone_maps_its_parameter_to_one_half() {
        assert!((Stretch::by_name("midtone", Some(0.2)).unwrap().apply(0.2) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn overexposure_pales() {
        let stretch = Stretch::by_name("asinh", None).unwrap();
        let rgb = stretch.apply_rgb([1000.0, 300.0, 100.0]);
        assert!(rgb.iter().all(|v| *v > 0.99 && *v <= 1.0));
        assert!(stretch.apply_rgb([1.0, 0.3, 0.1])[2] < 0.2);
    }

    #[test]
    fn hue_stays() {
        let rgb = Stretch::by_name("asinh", None).unwrap().apply_rgb([0.02, 0.01, 0.005]);
        assert!((rgb[0] / rgb[1] - 2.0).abs() < 1e-12 && rgb[0] > 0.1);
    }
}
