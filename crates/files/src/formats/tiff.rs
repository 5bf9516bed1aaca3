//! TIFF: the picture in the scene's palette and stretch, 16 bits a colour, sRGB.

use std::io::Cursor;

use tiff::encoder::{TiffEncoder, colortype::RGB16};

use super::{Writer, colours};
use barnard::error::{Error, Result};
use barnard::image::{Image, SaveOptions};

pub(super) const fn writer(extension: &'static str) -> Writer {
    Writer {
        extension,
        is_picture: true,
        has_layers: false,
        summary: "picture in the scene's palette and stretch, 16 bits per colour, sRGB",
        encode,
    }
}

fn encode(picture: &Image, options: &SaveOptions) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let (width, height) = (picture.width as u32, picture.height as u32);
    let written = TiffEncoder::new(&mut bytes)
        .and_then(|mut file| file.write_image::<RGB16>(width, height, &colours::words(picture, &options.display)));
    written.map_err(|e| Error::Encoding { format: "tiff", reason: e.to_string() })?;
    Ok(bytes.into_inner())
}
