//! Images as FITS files.

use std::io::Write;

use barnard::error::Result;
use barnard::image::{Image, Layer, LayerContent, PixelScale, Samples};

use super::LAYER;
use super::cards::{BLOCK, Cards};
use crate::formats::{GridFile, distinct_names, failed, now};

pub fn encode(image: &Image) -> Result<Vec<u8>> {
    let mut primary = Cards::default();
    primary.value("SIMPLE", "T", "conforms to FITS standard");
    primary.value("BITPIX", 8, "no data in this HDU");
    primary.value("NAXIS", 0, "the bands follow as IMAGE extensions");
    primary.value("EXTEND", "T", "");
    primary.text("CREATOR", &format!("Barnard {}", env!("CARGO_PKG_VERSION")), "spectral renderer of nebulae");
    primary.text("DATE", &now(), "UTC, when the file was written");
    image.keywords.iter().for_each(|keyword| primary.keyword(keyword));
    for (key, value) in &image.notes {
        primary.history(&format!("{key}: {value}"));
    }
    let mut bytes = primary.finish();
    let double = matches!(image.samples, Samples::Double(_));
    for band in 0..image.bands.len() {
        bytes.extend(header_of(image, band));
        rows(image, double, image.band(band), &mut bytes);
    }
    for layer in &image.layers {
        for channel in channels(image, layer) {
            bytes.extend(header_of_layer(image, layer, &channel));
            rows(image, false, layer.channel(channel.number, image.width * image.height), &mut bytes);
        }
    }
    Ok(bytes)
}

/// Adds the values of an image to the bytes of a file, whose first row is the lowest, up to the end of a block.
fn rows(image: &Image, double: bool, values: impl Iterator<Item = f64>, bytes: &mut Vec<u8>) {
    let values: Vec<f64> = values.collect();
    for row in values.chunks(image.width).rev() {
        match double {
            true => bytes.extend(row.iter().flat_map(|v| v.to_be_bytes())),
            false => bytes.extend(row.iter().flat_map(|v| (*v as f32).to_be_bytes())),
        }
    }
    bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
}

/// A channel of a layer as an HDU: what it is called, which it is, its unit and what it means.
struct Channel {
    name: String,
    number: usize,
    unit: Option<&'static str>,
    meaning: &'static str,
}

fn channels(image: &Image, layer: &Layer) -> Vec<Channel> {
    let named = |name: &str, number, unit, meaning| Channel { name: name.into(), number, unit, meaning };
    match layer.content {
        LayerContent::Light => {
            let bands = distinct_names(image).into_iter().enumerate();
            let channel = |(number, band)| Channel {
                name: format!("{}.{band}", layer.name),
                number,
                unit: Some("W m-2 sr-1"),
                meaning: "a part of the band radiance",
            };
            bands.map(channel).collect()
        }
        LayerContent::Depth => vec![named("depth", 0, Some("pc"), "mean distance of the light of dust and gas")],
        LayerContent::OpticalDepth => {
            vec![named("tau", 0, None, "optical depth at V"), named("opacity", 1, None, "part of light at V that dust takes")]
        }
    }
}

fn header_of_layer(image: &Image, layer: &Layer, channel: &Channel) -> Vec<u8> {
    let mut cards = Cards::default();
    extension(&mut cards, image, false);
    cards.text("EXTNAME", &channel.name, "a channel of a layer");
    cards.text(LAYER, &layer.name, "the layer of the picture");
    if let Some(unit) = channel.unit {
        cards.text("BUNIT", unit, channel.meaning);
    } else {
        cards.history(channel.meaning);
    }
    wcs(&mut cards, image);
    cards.finish()
}

/// The cards that an image extension begins with.
fn extension(cards: &mut Cards, image: &Image, double: bool) {
    cards.text("XTENSION", "IMAGE", "image extension");
    cards.value("BITPIX", if double { -64 } else { -32 }, "IEEE floating point");
    cards.value("NAXIS", 2, "");
    cards.value("NAXIS1", image.width, "");
    cards.value("NAXIS2", image.height, "");
    cards.value("PCOUNT", 0, "");
    cards.value("GCOUNT", 1, "");
}

/// A grid as a cube whose first axis is x, which runs fastest.
pub fn write_grid(file: &GridFile, out: &mut dyn Write) -> Result<()> {
    let lattice = file.grid.lattice();
    let [nx, ny, nz] = lattice.dims;
    let mut cards = Cards::default();
    cards.value("SIMPLE", "T", "conforms to FITS standard");
    cards.value("BITPIX", -32, "IEEE floating point");
    cards.value("NAXIS", 3, "");
    (1..).zip(lattice.dims).for_each(|(axis, count)| cards.value(&format!("NAXIS{axis}"), count, ""));
    cards.text("EXTNAME", file.name, "the grid");
    if let Some(unit) = file.unit {
        cards.text("BUNIT", unit, "unit of the values");
    }
    let (first, step) = (lattice.centre(0, 0, 0), lattice.voxel_pc());
    for (i, kind) in ["X", "Y", "Z"].into_iter().enumerate() {
        let axis = i + 1;
        cards.text(&format!("CTYPE{axis}"), kind, "Cartesian");
        cards.text(&format!("CUNIT{axis}"), "pc", "");
        cards.number(&format!("CRPIX{axis}"), 1.0, "the first voxel");
        cards.number(&format!("CRVAL{axis}"), first[i], "where its middle is");
        cards.number(&format!("CDELT{axis}"), step[i], "edge of a voxel");
    }
    cards.text("CREATOR", &format!("Barnard {}", env!("CARGO_PKG_VERSION")), "spectral renderer of nebulae");
    cards.text("DATE", &now(), "UTC, when the file was written");
    out.write_all(&cards.finish()).map_err(failed)?;
    let mut row = vec![0.0; nx];
    for (y, z) in (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))) {
        file.grid.row(0..nx, y, z, &mut row);
        out.write_all(&row.iter().flat_map(|value| value.to_be_bytes()).collect::<Vec<u8>>()).map_err(failed)?;
    }
    let bytes = 4 * lattice.cells();
    out.write_all(&vec![0; bytes.next_multiple_of(BLOCK) - bytes]).map_err(failed)
}

fn header_of(image: &Image, index: usize) -> Vec<u8> {
    let band = &image.bands[index];
    let mut cards = Cards::default();
    extension(&mut cards, image, matches!(image.samples, Samples::Double(_)));
    cards.text("EXTNAME", &distinct_names(image)[index], "passband");
    if image.is_error(index) {
        cards.text("BUNIT", "W m-2 sr-1", "standard error of the band radiance");
        cards.text("HDUCLAS2", "ERROR", "standard errors of another HDU");
    } else {
        cards.text("BUNIT", "W m-2 sr-1", "band radiance, integral of R I_lambda");
        cards.text("FILTER", &band.name, "passband");
    }
    if let Some(pivot) = band.pivot_um {
        cards.number("PIVOT", pivot * 1e3, "[nm] pivot wavelength");
    }
    if let Some(width) = band.width_um {
        cards.number("BANDWID", width * 1e3, "[nm] integral of the response R");
    }
    if let Some(counting) = band.counting {
        cards.text("COUNTING", counting, "what the detector counts");
    }
    band.keywords.iter().for_each(|keyword| cards.keyword(keyword));
    wcs(&mut cards, image);
    for line in &band.certificate {
        cards.history(&format!("certificate: {line}"));
    }
    cards.finish()
}

/// A linear frame centred on the axis of view: tangent plane, angles from the middle, or longitude and latitude in degrees, or lengths.
fn wcs(cards: &mut Cards, image: &Image) {
    let (kinds, unit, step) = match image.pixel {
        Some(PixelScale::Angle(degrees)) => (["XLON-TAN", "XLAT-TAN"], "deg", degrees),
        Some(PixelScale::Equidistant(degrees)) => (["XLON-ARC", "XLAT-ARC"], "deg", degrees),
        Some(PixelScale::PlateCarree(degrees)) => (["XLON-CAR", "XLAT-CAR"], "deg", degrees),
        Some(PixelScale::Length(pc)) => (["X", "Y"], "pc", pc),
        Some(PixelScale::OnCube(_)) | None => return,
    };
    let middles = [0.5 * (image.width as f64 + 1.0) + image.axis.0, 0.5 * (image.height as f64 + 1.0) + image.axis.1];
    for (i, (kind, middle)) in kinds.iter().zip(middles).enumerate() {
        let axis = i + 1;
        cards.text(&format!("CTYPE{axis}"), kind, "camera frame");
        cards.text(&format!("CUNIT{axis}"), unit, "");
        cards.number(&format!("CRPIX{axis}"), middle, "where the axis of view meets the image");
        cards.number(&format!("CRVAL{axis}"), 0.0, "");
        cards.number(&format!("CDELT{axis}"), step, "pixel scale");
    }
}
