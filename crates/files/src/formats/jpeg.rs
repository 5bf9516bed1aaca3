//! JPEG: the picture in the scene's palette and stretch, 8 bits a colour, sRGB, for what is only looked at.

use jpeg_encoder::{ColorType, Encoder};

use super::{Writer, colours};
use barnard::error::{Error, Result};
use barnard::image::{Image, SaveOptions};

/// The quality from which on eyes see no difference, of 100.
const QUALITY: u8 = 95;

pub(super) const fn writer(extension: &'static str) -> Writer {
    Writer {
        extension,
        is_picture: true,
        has_layers: false,
        summary: "picture in the scene's palette and stretch, sRGB, lossy compression",
        encode,
    }
}

fn encode(picture: &Image, options: &SaveOptions) -> Result<Vec<u8>> {
    let failed = |reason: String| Error::Encoding { format: "jpeg", reason };
    let side = |pixels: usize| u16::try_from(pixels).map_err(|_| failed(format!("{pixels} pixels exceed 65535 per edge")));
    let (width, height) = (side(picture.width)?, side(picture.height)?);
    let mut bytes = Vec::new();
    let encoded = Encoder::new(&mut bytes, QUALITY).encode(&colours::bytes(picture, &options.display), width, height, ColorType::Rgb);
    encoded.map_err(|e| failed(e.to_string()))?;
    Ok(bytes)
}
