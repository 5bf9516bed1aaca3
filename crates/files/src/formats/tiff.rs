//! TIFF: the picture in the scene's palette and stretch, 16 bits a colour, sRGB.

use std::io::Cursor;

use image::{ExtendedColorType, ImageEncoder};

use super::{Writer, colours};
use barnard::error::{Error, Result};
use barnard::image::Image;

pub(super) const fn writer(extension: &'static str) -> Writer {
    Writer {
        extension,
        is_picture: true,
        has_layers: false,
        summary: "picture in the scene's palette and stretch, 16 bits a colour, sRGB",
        encode,
    }
}

fn encode(picture: &Image) -> Result<Vec<u8>> {
    let words: Vec<u8> = colours::words(picture).into_iter().flat_map(u16::to_ne_bytes).collect();
    let mut bytes = Cursor::new(Vec::new());
    let encoder = image::codecs::tiff::TiffEncoder::new(&mut bytes);
    let written = encoder.write_image(&words, picture.width as u32, picture.height as u32, ExtendedColorType::Rgb16);
    written.map_err(|e| Error::Encoding { format: "tiff", reason: e.to_string() })?;
    Ok(bytes.into_inner())
}
