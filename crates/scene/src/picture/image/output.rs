//! Encoding options of picture files.

use super::Display;
use crate::properties::Choices;

/// Display and encoding of an image in files.
#[derive(Debug, Clone, PartialEq)]
pub struct SaveOptions {
    /// Levels, palette, stretch and glare of colours.
    pub display: Display,
    /// Layers, compression and precision.
    pub output: Output,
}

impl SaveOptions {
    /// All bands alike in shades of grey, with the default encoding.
    pub fn grey(bands: usize) -> Self {
        Self { display: Display::grey(bands), output: Output::default() }
    }

    /// Options for images of instruments, whose optics are in the light already.
    #[must_use]
    pub fn without_glare(mut self) -> Self {
        self.display.glare = None;
        self
    }
}

/// Layers of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LayerChoice {
    /// Its light in parts: scattered, of each gas, of the background and of stars.
    pub light: bool,
    /// The mean distance of the light of dust and gas.
    pub depth: bool,
    /// The optical depth, and the opacity.
    pub tau: bool,
}

impl LayerChoice {
    /// The choice of these names.
    ///
    /// # Errors
    /// If there is no such layer, with those that there are.
    pub fn by_names(names: &[&str]) -> Result<Self, String> {
        let mut choice = Self::default();
        for name in names {
            match *name {
                "light" => choice.light = true,
                "depth" => choice.depth = true,
                "tau" => choice.tau = true,
                "all" => choice = Self { light: true, depth: true, tau: true },
                "none" => choice = Self::default(),
                other => return Err(format!("unknown layer \"{other}\"; known: light, depth, tau, all, none")),
            }
        }
        Ok(choice)
    }

    /// True if there is any.
    pub fn is_any(self) -> bool {
        self.light || self.depth || self.tau
    }
}

/// Content of layers of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LayerChannels {
    /// Linear colours by the scene's palette, of the same exposure as the picture's.
    #[default]
    Rgb,
    /// The radiances of all bands [W m⁻² sr⁻¹].
    Bands,
}

impl Choices for LayerChannels {
    const ROWS: &'static [(&'static str, Self)] = &[("rgb", Self::Rgb), ("bands", Self::Bands)];
}

/// The primaries of linear colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourSpace {
    /// Primaries of Rec. 709 and sRGB, white D65.
    #[default]
    Rec709,
    /// ACEScg: AP1, white D60.
    AcesCg,
}

impl Choices for ColourSpace {
    const ROWS: &'static [(&'static str, Self)] = &[("rec709", Self::Rec709), ("acescg", Self::AcesCg)];
}

impl ColourSpace {
    /// The name that files give it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rec709 => "Rec. 709",
            Self::AcesCg => "ACEScg",
        }
    }
}

/// How an OpenEXR file is compressed; all but the last keep every bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// Not at all.
    None,
    /// Runs of equal bytes.
    Rle,
    /// Deflate, each line alone.
    Zips,
    /// Deflate, sixteen lines together.
    #[default]
    Zip,
    /// Wavelets and Huffman's code.
    Piz,
    /// Deflate after 32 bits became 24.
    Pxr24,
}

impl Choices for Compression {
    const ROWS: &'static [(&'static str, Self)] =
        &[("none", Self::None), ("rle", Self::Rle), ("zips", Self::Zips), ("zip", Self::Zip), ("piz", Self::Piz), ("pxr24", Self::Pxr24)];
}

/// Encoding options of picture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Output {
    /// Layers stored with the picture.
    pub layers: LayerChoice,
    /// Content of layers of light.
    pub channels: LayerChannels,
    /// The primaries of linear colours.
    pub colours: ColourSpace,
    /// True if colours are in single precision, and not in half.
    pub single: bool,
    /// Compression of the file.
    pub compression: Compression,
}
