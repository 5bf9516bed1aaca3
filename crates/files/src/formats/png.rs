//! PNG: the picture in the scene's palette and stretch, 8 or 16 bits a colour, sRGB.

use png::BitDepth;

use super::{Writer, avm, colours};
use barnard::error::{Error, Result};
use barnard::image::{Image, SaveOptions};

pub(super) const WRITER: Writer =
    Writer { extension: "png", summary: "picture in the scene's palette and stretch, sRGB", is_picture: true, has_layers: false, encode };

fn encode(image: &Image, options: &SaveOptions) -> Result<Vec<u8>> {
    let size = (image.width, image.height);
    let on_the_sky = avm::packet(image).map(|packet| (avm::XMP.to_owned(), packet));
    let notes: Vec<_> = image.statements().into_iter().chain(on_the_sky).collect();
    if options.display.bits == 16 {
        let words: Vec<u8> = colours::words(image, &options.display).into_iter().flat_map(u16::to_be_bytes).collect();
        return encoded(size, &words, BitDepth::Sixteen, &notes);
    }
    encode_png(size, &colours::bytes(image, &options.display), &notes)
}

/// Pixels as a .png: red, green and blue in sRGB, row by row, with notes of key and words.
///
/// # Errors
/// If the pixels are not as many as the size says.
pub fn encode_png(size: (usize, usize), pixels: &[u8], notes: &[(String, String)]) -> Result<Vec<u8>> {
    encoded(size, pixels, BitDepth::Eight, notes)
}

fn encoded(size: (usize, usize), pixels: &[u8], depth: BitDepth, notes: &[(String, String)]) -> Result<Vec<u8>> {
    let failed = |e: png::EncodingError| Error::Encoding { format: "png", reason: e.to_string() };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.0 as u32, size.1 as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(depth);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (key, value) in notes {
        encoder.add_itxt_chunk(key.clone(), value.clone()).map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(pixels).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}
