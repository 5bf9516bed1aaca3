//! Images as FITS files.

use std::io::Write;

use barnard::error::Result;
use barnard::image::{Image, PixelScale, Samples};

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
    for band in 0..image.bands.len() {
        bytes.extend(header_of(image, band));
        // The first row of FITS is the lowest.
        for row in (0..image.height).rev() {
            for column in 0..image.width {
                match &image.samples {
                    Samples::Single(_) => bytes.extend((image.at(band, row, column) as f32).to_be_bytes()),
                    Samples::Double(_) => bytes.extend(image.at(band, row, column).to_be_bytes()),
                }
            }
        }
        bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
    }
    Ok(bytes)
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
    cards.text("XTENSION", "IMAGE", "image extension");
    cards.value("BITPIX", if matches!(image.samples, Samples::Double(_)) { -64 } else { -32 }, "IEEE floating point");
    cards.value("NAXIS", 2, "");
    cards.value("NAXIS1", image.width, "");
    cards.value("NAXIS2", image.height, "");
    cards.value("PCOUNT", 0, "");
    cards.value("GCOUNT", 1, "");
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
