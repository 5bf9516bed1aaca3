//! Images as FITS files.

use std::io::Write;
use std::time::{Duration, SystemTime};

use barnard::error::Result;
use barnard::image::{Image, Layer, LayerContent, PixelScale, Samples, SaveOptions, SkyCoordinates, Turned};
use barnard::instrument::Frame;
use barnard::keywords::Keyword;
use barnard::observation::RadianceUnit;

use super::LAYER;
use super::cards::{BLOCK, Cards};
use crate::formats::clock::now;
use crate::formats::{GridFile, ascii, distinct_names, failed};

/// The HDU that a file begins with, without data.
fn primary(image: &Image, keywords: &[Keyword]) -> Vec<u8> {
    let mut primary = Cards::default();
    primary.value("SIMPLE", "T", "conforms to FITS standard");
    primary.value("BITPIX", 8, "no data in this HDU");
    primary.value("NAXIS", 0, "bands follow as IMAGE extensions");
    primary.value("EXTEND", "T", "");
    origin(&mut primary, image, keywords);
    primary.finish()
}

/// Provenance of a file: keywords beside those of the image.
fn origin(primary: &mut Cards, image: &Image, keywords: &[Keyword]) {
    primary.text("CREATOR", &format!("Barnard {}", env!("CARGO_PKG_VERSION")), "spectral renderer of nebulae");
    primary.text("DATE", &now(), "UTC, when the file was written");
    image.cards().iter().chain(keywords).for_each(|keyword| primary.keyword(keyword));
    for (key, value) in image.statements().iter().filter(|(key, _)| holds(image, key)) {
        primary.history(&format!("{key}: {value}"));
    }
}

pub fn encode(image: &Image, _: &SaveOptions) -> Result<Vec<u8>> {
    let mut bytes = primary(image, &[]);
    // Channels of a spectrograph are one cube, and their standard errors another.
    let in_cube = image.spectral.map_or(0, |axis| axis.count);
    let errors = (0..in_cube).filter_map(|band| image.errors_of(band)).collect::<Vec<_>>();
    for (name, bands) in
        [(CUBE, (0..in_cube).collect()), (CUBE_ERROR, errors)].into_iter().filter(|(_, bands): &(_, Vec<usize>)| !bands.is_empty())
    {
        bytes.extend(header_of_cube(image, name, &bands));
        let bits = Bitpix::of(image);
        bands.iter().for_each(|band| bits.plane(image.width, densities(image, *band), &mut bytes));
        bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
    }
    for band in (0..image.bands.len()).filter(|band| image.spectral.is_none() || (*band >= in_cube && !image.is_error(*band))) {
        bytes.extend(header_of(image, band));
        Bitpix::of(image).rows(image.width, image.in_unit(band), &mut bytes);
    }
    for layer in &image.layers {
        for channel in channels(image, layer) {
            bytes.extend(header_of_layer(image, layer, &channel));
            let values = layer.channel(channel.number, image.width * image.height);
            let unit = image.bands.get(channel.number).and_then(|band| band.in_unit).filter(|_| layer.content == LayerContent::Light);
            bits_of(layer).rows(image.width, values.map(|value| unit.map_or(value, |unit| unit.value(value))), &mut bytes);
        }
    }
    Ok(bytes)
}

/// What holds of radiances in W m-2 sr-1 alone: keywords of bands, and the note of the quantity.
const OF_SI: [&str; 4] = ["PHOTFLAM", "ZPVEGA", "ZPAB", "quantity"];

fn unit(image: &Image) -> RadianceUnit {
    image.observation.map(|observation| observation.unit).unwrap_or_default()
}

/// True if a statement about a picture is true in its unit.
fn holds(image: &Image, name: &str) -> bool {
    unit(image) == RadianceUnit::Si || !OF_SI.contains(&name)
}

/// The unit of a picture's light, and the zero point of magnitudes.
fn unit_cards(cards: &mut Cards, unit: RadianceUnit, meaning: &str) {
    cards.text("BUNIT", unit.fits(), meaning);
    if let Some(system) = unit.magnitude_system() {
        cards.text("MAGSYS", system, "zero point of the magnitudes");
    }
}

/// Number type of an HDU: BITPIX.
#[derive(Clone, Copy)]
enum Bitpix {
    Double = -64,
    Single = -32,
    Integer = 16,
}

impl Bitpix {
    fn of(image: &Image) -> Self {
        if matches!(image.samples, Samples::Double(_)) { Self::Double } else { Self::Single }
    }

    fn meaning(self) -> &'static str {
        match self {
            Self::Double | Self::Single => "IEEE floating point",
            Self::Integer => "integers",
        }
    }

    /// Adds values to the bytes of a file as these, up to the end of a block.
    fn rows(self, width: usize, values: impl Iterator<Item = f64>, bytes: &mut Vec<u8>) {
        self.plane(width, values, bytes);
        bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
    }

    /// Adds values to the bytes of a file as these.
    fn plane(self, width: usize, values: impl Iterator<Item = f64>, bytes: &mut Vec<u8>) {
        match self {
            Self::Double => rows(width, values.map(f64::to_be_bytes), bytes),
            Self::Single => rows(width, values.map(|value| (value as f32).to_be_bytes()), bytes),
            Self::Integer => rows(width, values.map(|value| (value as i16).to_be_bytes()), bytes),
        }
    }
}

/// Adds the values of an image, the first row on top, to the bytes of a file, whose first row is the lowest.
fn rows<const N: usize>(width: usize, values: impl Iterator<Item = [u8; N]>, bytes: &mut Vec<u8>) {
    let values: Vec<[u8; N]> = values.collect();
    values.chunks(width).rev().for_each(|row| bytes.extend_from_slice(row.as_flattened()));
}

/// A frame of an instrument: counts, which FITS knows as integers that are 32768 too small. One plane is the image of the first HDU, as
/// cameras write it and programs that stack frames read it; several are extensions.
pub(crate) fn encode_frame(frame: &Frame) -> Vec<u8> {
    let image = &frame.header;
    let is_alone = frame.planes.len() == 1;
    let mut bytes = if is_alone { Vec::new() } else { primary(image, &frame.keywords) };
    for (name, counts) in frame.planes.iter().zip(&frame.counts) {
        let mut cards = Cards::default();
        if is_alone {
            cards.value("SIMPLE", "T", "conforms to FITS standard");
            sized(&mut cards, image, Bitpix::Integer);
            cards.value("EXTEND", "T", "");
            origin(&mut cards, image, &[]);
        } else {
            extension(&mut cards, image, Bitpix::Integer);
        }
        cards.value("BZERO", 32768, "counts are not negative");
        cards.value("BSCALE", 1, "");
        cards.text("EXTNAME", &ascii(name), "passband, or a mosaic of several");
        cards.text("BUNIT", "adu", "counts");
        cards.text("FILTER", name, "passband, or a mosaic of several");
        cards.text("DATE-OBS", &begun(frame), "start of the exposure, the first being at J2000");
        cards.number("MJD-OBS", J2000_MJD + frame.begun_s / 86_400.0, "[d] the same");
        frame.keywords.iter().for_each(|keyword| cards.keyword(keyword));
        wcs(&mut cards, image, 2);
        bytes.extend(cards.finish());
        // Flipping the highest bit takes 32768 away.
        rows(image.width, counts.iter().map(|count| (count ^ 0x8000).to_be_bytes()), &mut bytes);
        bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
    }
    bytes
}

/// The modified Julian date of J2000 \[d\].
const J2000_MJD: f64 = 51_544.5;

/// J2000 \[s\] after the beginning of 1970.
const J2000_UNIX: f64 = 946_728_000.0;

/// The last second that a date of four digits can have \[s\] after the beginning of 1970.
const LAST_UNIX: f64 = 253_402_300_799.0;

/// When a frame begins, by a clock that starts at J2000: the same for the same frame whenever it is written.
fn begun(frame: &Frame) -> String {
    let milliseconds = 1e3 * (J2000_UNIX + frame.begun_s).clamp(0.0, LAST_UNIX);
    let time = SystemTime::UNIX_EPOCH + Duration::from_millis(milliseconds.round() as u64);
    humantime::format_rfc3339_millis(time).to_string().replace('Z', "")
}

/// A channel of a layer as an HDU: what it is called, which it is, its unit and what it means.
struct LayerHdu {
    name: String,
    number: usize,
    unit: Option<&'static str>,
    meaning: &'static str,
}

fn channels(image: &Image, layer: &Layer) -> Vec<LayerHdu> {
    let named = |name: &str, number, unit, meaning| LayerHdu { name: name.into(), number, unit, meaning };
    match layer.content {
        LayerContent::Light => {
            let bands = distinct_names(image).into_iter().enumerate();
            let channel = |(number, band)| LayerHdu {
                name: format!("{}.{band}", layer.name),
                number,
                unit: None,
                meaning: "part of the light of the band",
            };
            bands.map(channel).collect()
        }
        LayerContent::Mask => {
            let bands = distinct_names(image).into_iter().enumerate().filter(|(band, _)| !image.is_error(*band));
            let meaning = "1 saturated, 2 rejected, 4 no good frame";
            bands.map(|(number, band)| LayerHdu { name: format!("{}.{band}", layer.name), number, unit: None, meaning }).collect()
        }
        LayerContent::Depth => vec![named("depth", 0, Some("pc"), "mean distance of the light of dust and gas")],
        LayerContent::OpticalDepth => {
            vec![named("tau", 0, None, "optical depth at V"), named("opacity", 1, None, "fraction of V light absorbed by dust")]
        }
    }
}

fn bits_of(layer: &Layer) -> Bitpix {
    if layer.content == LayerContent::Mask { Bitpix::Integer } else { Bitpix::Single }
}

fn header_of_layer(image: &Image, layer: &Layer, channel: &LayerHdu) -> Vec<u8> {
    let mut cards = Cards::default();
    extension(&mut cards, image, bits_of(layer));
    cards.text("EXTNAME", &channel.name, "a channel of a layer");
    cards.text(LAYER, &layer.name, "the layer of the picture");
    match channel.unit {
        _ if layer.content == LayerContent::Light => unit_cards(&mut cards, unit(image), channel.meaning),
        Some(unit) => cards.text("BUNIT", unit, channel.meaning),
        None => cards.history(channel.meaning),
    }
    wcs(&mut cards, image, 2);
    cards.finish()
}

/// The cards that an image extension begins with.
fn extension(cards: &mut Cards, image: &Image, bits: Bitpix) {
    cards.text("XTENSION", "IMAGE", "image extension");
    sized(cards, image, bits);
    cards.value("PCOUNT", 0, "");
    cards.value("GCOUNT", 1, "");
}

fn sized(cards: &mut Cards, image: &Image, bits: Bitpix) {
    cards.value("BITPIX", bits as i32, bits.meaning());
    cards.value("NAXIS", 2, "");
    cards.value("NAXIS1", image.width, "");
    cards.value("NAXIS2", image.height, "");
}

/// The names of the cubes of channels and of their standard errors.
const CUBE: &str = "CUBE";
const CUBE_ERROR: &str = "CUBE_ERROR";

/// Unit of a cube's values, where they are a part of light in each wavelength, and how many of its wavelengths are a micrometre.
fn density_of(unit: RadianceUnit) -> Option<(&'static str, f64)> {
    match unit {
        RadianceUnit::Si => Some(("W m-2 sr-1 um-1", 1.0)),
        RadianceUnit::Cgs => Some(("erg s-1 cm-2 arcsec-2 Angstrom-1", 1e4)),
        _ => None,
    }
}

/// The values of a channel of a cube: band radiances by the width of the channel, other units as they are.
fn densities(image: &Image, band: usize) -> impl Iterator<Item = f64> + '_ {
    let radiance_band = (0..image.bands.len()).find(|index| image.errors_of(*index) == Some(band)).unwrap_or(band);
    let width = image.bands[radiance_band].width_um.unwrap_or(1.0);
    let factor = density_of(unit(image)).map_or(1.0, |(_, parts)| 1.0 / (width * parts));
    image.in_unit(band).map(move |value| value * factor)
}

fn header_of_cube(image: &Image, name: &str, bands: &[usize]) -> Vec<u8> {
    let mut cards = Cards::default();
    cards.text("XTENSION", "IMAGE", "image extension");
    cards.value("BITPIX", Bitpix::of(image) as i32, Bitpix::of(image).meaning());
    cards.value("NAXIS", 3, "");
    (1..).zip([image.width, image.height, bands.len()]).for_each(|(axis, count)| cards.value(&format!("NAXIS{axis}"), count, ""));
    cards.value("PCOUNT", 0, "");
    cards.value("GCOUNT", 1, "");
    cards.text("EXTNAME", name, "channels of a spectrograph");
    match density_of(unit(image)) {
        Some((stated, _)) => cards.text("BUNIT", stated, "mean over each channel"),
        None => unit_cards(&mut cards, unit(image), unit(image).meaning()),
    }
    if name == CUBE_ERROR {
        cards.text("HDUCLAS2", "ERROR", "standard errors of another HDU");
    }
    wcs(&mut cards, image, 3);
    if let Some(axis) = image.spectral {
        cards.text("CTYPE3", "WAVE", "wavelength in vacuum");
        cards.text("CUNIT3", "nm", "");
        cards.number("CRPIX3", 1.0, "the first channel");
        cards.number("CRVAL3", 1e3 * axis.first_um, "its middle");
        cards.number("CDELT3", 1e3 * axis.step_um, "width of a channel");
        cards.text("SPECSYS", "SOURCE", "wavelengths are at rest in the scene");
        if let Some(rest_um) = axis.rest_um {
            cards.number("RESTWAV", 1e-6 * rest_um, "[m] rest wavelength of the line, in vacuum");
        }
        if let Some(power) = axis.resolving_power {
            cards.number("SPEC_RES", power, "resolving power, wavelength over FWHM");
        }
    }
    cards.finish()
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
        cards.number(&format!("CRVAL{axis}"), first[i], "position of its centre");
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
    extension(&mut cards, image, Bitpix::of(image));
    cards.text("EXTNAME", &distinct_names(image)[index], "passband");
    if image.is_error(index) {
        // A difference of magnitudes has no zero point.
        let unit_text = if unit(image).magnitude_system().is_some() { "mag" } else { unit(image).fits() };
        cards.text("BUNIT", unit_text, "standard error of another HDU");
        cards.text("HDUCLAS2", "ERROR", "standard errors of another HDU");
    } else {
        unit_cards(&mut cards, unit(image), unit(image).meaning());
        cards.text("FILTER", &band.name, "passband");
    }
    if let Some(pivot) = band.pivot_um {
        cards.number("PIVOT", pivot * 1e3, "[nm] pivot wavelength");
    }
    if let Some(width) = band.width_um {
        cards.number("BANDWID", width * 1e3, "[nm] integral of the response R");
    }
    if let Some(counting) = band.counting {
        cards.text("COUNTING", counting, "quantity counted by the detector");
    }
    image.band_cards(index).iter().filter(|keyword| holds(image, keyword.name)).for_each(|keyword| cards.keyword(keyword));
    wcs(&mut cards, image, 2);
    for line in image.band_words(index) {
        cards.history(&format!("certificate: {line}"));
    }
    cards.finish()
}

/// A linear frame centred on the axis of view: tangent plane, angles from the middle, or longitude and latitude in degrees, or lengths.
fn wcs(cards: &mut Cards, image: &Image, axes: usize) {
    let sky = image.observation.zip(image.pixel).and_then(|(observation, pixel)| SkyCoordinates::of(&observation, pixel));
    if let Some(sky) = sky {
        return on_the_sky(cards, image, &sky, axes);
    }
    let (kinds, unit, step) = match image.pixel {
        Some(PixelScale::Angle(degrees)) => (["XLON-TAN", "XLAT-TAN"], "deg", degrees),
        Some(PixelScale::Equidistant(degrees)) => (["XLON-ARC", "XLAT-ARC"], "deg", degrees),
        Some(PixelScale::PlateCarree(degrees)) => (["XLON-CAR", "XLAT-CAR"], "deg", degrees),
        Some(PixelScale::Length(pc)) => (["X", "Y"], "pc", pc),
        Some(PixelScale::OnCube(_)) | None => return,
    };
    for (i, (kind, middle)) in kinds.iter().zip(image.reference_pixel()).enumerate() {
        let axis = i + 1;
        cards.text(&format!("CTYPE{axis}"), kind, "camera frame");
        cards.text(&format!("CUNIT{axis}"), unit, "");
        cards.number(&format!("CRPIX{axis}"), middle, "optical axis in the image");
        cards.number(&format!("CRVAL{axis}"), 0.0, "");
        cards.number(&format!("CDELT{axis}"), step, "pixel scale");
    }
}

/// A frame of the sky.
fn on_the_sky(cards: &mut Cards, image: &Image, sky: &SkyCoordinates, axes: usize) {
    cards.value("WCSAXES", axes, "");
    let comment = match sky.turned {
        Turned::Plane(_) => "the target",
        Turned::Sphere { .. } => "over the image's own pole",
    };
    for (i, kind) in sky.kinds().iter().enumerate() {
        let axis = i + 1;
        cards.text(&format!("CTYPE{axis}"), kind, "place on the sky");
        cards.text(&format!("CUNIT{axis}"), "deg", "");
        cards.number(&format!("CRPIX{axis}"), image.reference_pixel()[i], "optical axis in the image");
        cards.number(&format!("CRVAL{axis}"), sky.reference_deg[i], comment);
        cards.number(&format!("CDELT{axis}"), sky.step_deg[i], "pixel scale");
    }
    let pole = match sky.turned {
        Turned::Plane(matrix) => {
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                cards.number(&format!("PC{}_{}", i + 1, j + 1), matrix[i][j], "");
            }
            180.0
        }
        Turned::Sphere { pole_deg } => {
            cards.number("PV1_1", 0.0, "[deg] own longitude of CRVAL");
            cards.number("PV1_2", 90.0, "[deg] own latitude of CRVAL");
            pole_deg
        }
    };
    cards.number("LONPOLE", pole, "[deg] own longitude of the sky's pole");
    if let Some(reference) = sky.frame.reference() {
        cards.text("RADESYS", reference, "");
    }
}
