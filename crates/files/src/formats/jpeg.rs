//! JPEG: the picture in the scene's palette and stretch, 8 bits a colour, sRGB, for what is only looked at.

use image::{ExtendedColorType, ImageEncoder};

use super::{Writer, colours};
use barnard::error::{Error, Result};
use barnard::image::Image;

/// The quality from which on eyes see no difference, of 100.
const QUALITY: u8 = 95;

pub(super) const fn writer(extension: &'static str) -> Writer {
    Writer {
        extension,
        is_picture: true,
        has_layers: false,
        summary: "picture in the scene's palette and stretch, sRGB, packed with a small loss",
        encode,
    }
}

fn encode(picture: &Image) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    let written = encoder.write_image(&colours::bytes(picture), picture.width as u32, picture.height as u32, ExtendedColorType::Rgb8);
    written.map_err(|e| Error::Encoding { format: "jpeg", reason: e.to_string() })?;
    Ok(bytes)
}
