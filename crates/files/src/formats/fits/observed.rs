//! Observed images: every plane of a file with its unit and its place on the sky.

use std::io::Cursor;
use std::path::Path;

use barnard::error::{Error, Result};
use barnard::glam::{DMat2, DVec2, DVec3};
use barnard::image::{ERROR_SUFFIX, Image, Samples, SaveOptions};

use super::header::{Header, headers};
use super::{LAYER, gzip, planes};
use crate::formats::Request;

/// The planes of a file.
#[derive(Debug, Clone)]
pub struct Observed {
    /// Pixels along a row.
    pub width: usize,
    /// Pixels along a column.
    pub height: usize,
    /// Each image of two axes, in the order of the file.
    pub planes: Vec<ImagePlane>,
}

/// An image of two axes.
#[derive(Debug, Clone)]
pub struct ImagePlane {
    /// The number of its HDU, zero for the first.
    pub hdu: usize,
    /// The name of its HDU (EXTNAME); nothing where it has none.
    pub name: String,
    /// Its number among those of its name (EXTVER).
    pub version: i64,
    /// Its unit, as BUNIT says it.
    pub unit: Option<String>,
    /// Its values, the first row on top; NaN where the file has none.
    pub values: Vec<f64>,
    /// World coordinates of its pixels, if stated.
    pub sky: Option<Sky>,
}

/// World coordinates of pixels: the part of a world coordinate system that flat pictures need, FITS papers I and II.
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    kinds: [String; 2],
    /// World-coordinate features unsupported for flat pictures, by keyword: distortions, a turned pole, an old equinox.
    peculiar: Option<String>,
    reference: DVec2,
    /// The coordinates of the reference \[deg\].
    value: DVec2,
    /// Steps along both axes \[deg\].
    matrix: DMat2,
    height: f64,
}

/// Names that other programs give to the one image of a file, its standard errors, its mask, and planes of neither kind.
const SCIENCE: &str = "SCI";
const ERRORS: [&str; 4] = ["ERR", "ERROR", "UNCERT", "SIGMA"];
const MASKS: [&str; 2] = ["DQ", "MASK"];
const ASIDE: [&str; 11] = ["WHT", "WEIGHT", "CON", "CTX", "AREA", "VAR", "VARIANCE", "VAR_POISSON", "VAR_RNOISE", "VAR_FLAT", "IVM"];

/// Prefix of a mask's name, before the name of the image.
pub const MASK_PREFIX: &str = "mask.";

impl Observed {
    /// The images, without their errors, masks and weights.
    pub fn images(&self) -> impl Iterator<Item = &ImagePlane> {
        self.planes.iter().filter(|plane| !is_aside(&plane.name))
    }

    /// The image of a passband by its name; where one band is asked for, that called SCI or the only one.
    ///
    /// # Errors
    /// Says what images there are where none is meant, or several are.
    pub fn plane(&self, name: &str, bands: usize) -> std::result::Result<&ImagePlane, String> {
        let images = || self.images();
        let called = |name: &str| images().filter(|plane| plane.name.eq_ignore_ascii_case(name)).collect::<Vec<&ImagePlane>>();
        let mut found = called(name);
        if found.is_empty() && bands == 1 {
            found = called(SCIENCE);
        }
        if found.is_empty() && bands == 1 && images().count() == 1 {
            found = images().collect();
        }
        match found[..] {
            [one] => Ok(one),
            [] => {
                let known: Vec<&str> = self.planes.iter().map(|plane| plane.name.as_str()).collect();
                Err(format!(
                    "has no image of passband {name}; its images are {}; select one with FILE[NAME] or FILE[NUMBER]",
                    known.join(", ")
                ))
            }
            [first, ..] => {
                let (count, wanted) = (found.len(), &first.name);
                Err(format!("has {count} images named {wanted}; select one with FILE[{wanted},{}]", first.version))
            }
        }
    }

    /// Variant with one image, and its errors and mask: by the name of its HDU, by name and version as in "SCI,2", or by number.
    ///
    /// # Errors
    /// Says what images there are where none or several are meant.
    pub fn chosen(mut self, hdu: &str) -> std::result::Result<Self, String> {
        let (name, version) = match hdu.split_once(',') {
            Some((name, version)) => {
                (name.trim(), Some(version.trim().parse::<i64>().map_err(|_| format!("has no HDU of version {version}"))?))
            }
            None => (hdu.trim(), None),
        };
        let number = name.parse::<usize>().ok();
        let is_it = |plane: &&ImagePlane| match number {
            Some(number) => plane.hdu == number,
            None => plane.name.eq_ignore_ascii_case(name) && version.is_none_or(|version| plane.version == version),
        };
        let found: Vec<&ImagePlane> = self.planes.iter().filter(is_it).collect();
        let [one] = found[..] else {
            let known: Vec<String> = self.planes.iter().map(|plane| format!("{} ({},{})", plane.hdu, plane.name, plane.version)).collect();
            let count = if found.is_empty() { "no".to_owned() } else { found.len().to_string() };
            return Err(format!("has {count} images {hdu}; its images are {}", known.join(", ")));
        };
        let (hdu, version) = (one.hdu, one.version);
        self.planes.retain(|plane| plane.hdu == hdu || (is_aside(&plane.name) && plane.version == version));
        Ok(self)
    }

    /// The standard errors of an image.
    pub fn errors_of(&self, name: &str) -> Option<&ImagePlane> {
        self.beside(&format!("{name}{ERROR_SUFFIX}"), &ERRORS)
    }

    /// The mask of an image, zero where pixels count.
    pub fn mask_of(&self, name: &str) -> Option<&ImagePlane> {
        self.beside(&format!("{MASK_PREFIX}{name}"), &MASKS)
    }

    fn beside(&self, hdu: &str, others: &[&str]) -> Option<&ImagePlane> {
        let images = self.images().count();
        let named = |plane: &&ImagePlane| others.iter().any(|other| plane.name.eq_ignore_ascii_case(other));
        self.planes
            .iter()
            .find(|plane| plane.name.eq_ignore_ascii_case(hdu))
            .or_else(|| self.planes.iter().find(named).filter(|_| images == 1))
    }
}

/// True if a name is that of errors, of a mask or of a layer.
fn is_aside(name: &str) -> bool {
    let other = |other: &&&str| name.eq_ignore_ascii_case(other);
    let lower = name.to_ascii_lowercase();
    lower.ends_with(ERROR_SUFFIX) || lower.starts_with(MASK_PREFIX) || ERRORS.iter().chain(&MASKS).chain(&ASIDE).any(|known| other(&known))
}

/// Reads every image of two axes of a FITS file, those of masks and errors too; together they may take `memory_limit` bytes.
///
/// # Errors
/// If the file cannot be read, or has images of different sizes, or none.
pub fn observed(path: &Path, memory_limit: u64) -> Result<Observed> {
    let file = std::fs::File::open(path).map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    let request = &mut Request::new(file, path, None, memory_limit)?;
    gzip::unpacked(request)?;
    let headers = headers(request)?;
    let mut all = Vec::new();
    let is_wanted = |header: &Header| header.text(LAYER).is_none_or(|layer| layer.trim().starts_with("mask"));
    let (width, height) = planes(request, &headers, is_wanted, |(hdu, header), values| {
        all.push(ImagePlane {
            hdu,
            version: header.number("EXTVER").map_or(1, |version| version as i64),
            name: header.text("EXTNAME").unwrap_or_default().trim().to_owned(),
            unit: header.text("BUNIT").map(|unit| unit.trim().to_owned()).filter(|unit| !unit.is_empty()),
            sky: Sky::of(header),
            values,
        });
    })?;
    Ok(Observed { width, height, planes: all })
}

/// World coordinates of a picture, as in its file; `None` if not stated.
///
/// # Errors
/// If it cannot be written as FITS.
pub fn sky_of(image: &Image) -> Result<Option<Sky>> {
    let Some(band) = image.bands.first() else { return Ok(None) };
    let pixels = image.width * image.height;
    let bare = Image {
        bands: vec![band.clone()],
        samples: Samples::Single(vec![0.0; pixels]),
        layers: Vec::new(),
        spectral: None,
        ..image.clone()
    };
    let path = Path::new("picture");
    let request = &mut Request::new(Cursor::new(super::encode(&bare, &SaveOptions::grey(1))?), path, None, u64::MAX)?;
    Ok(headers(request)?.iter().find_map(Sky::of))
}

impl Sky {
    /// World coordinates of a header; `None` without two sky axes.
    fn of(header: &Header) -> Option<Self> {
        let kind = |axis: usize| header.text(&format!("CTYPE{axis}")).map(|kind| kind.trim().to_owned());
        let kinds = [kind(1)?, kind(2)?];
        let longitude = ["RA--", "GLON", "ELON"].iter().any(|start| kinds[0].starts_with(start));
        if !longitude {
            return None;
        }
        let number = |keyword: &str| header.number(keyword);
        let pair = |keyword: &str| Some(DVec2::new(number(&format!("{keyword}1"))?, number(&format!("{keyword}2"))?));
        let element = |i: usize, j: usize| {
            number(&format!("CD{i}_{j}")).or_else(|| {
                let turned = number(&format!("PC{i}_{j}")).unwrap_or(if i == j { 1.0 } else { 0.0 });
                Some(turned * number(&format!("CDELT{i}"))?)
            })
        };
        let has_matrix = number("CD1_1").or(number("CD1_2")).is_some();
        let element_of = |i: usize, j: usize| if has_matrix { Some(number(&format!("CD{i}_{j}")).unwrap_or(0.0)) } else { element(i, j) };
        let matrix =
            || Some(DMat2::from_cols(DVec2::new(element_of(1, 1)?, element_of(2, 1)?), DVec2::new(element_of(1, 2)?, element_of(2, 2)?)));
        let whole = || Some((pair("CRPIX")?, pair("CRVAL")?, matrix().filter(|matrix| matrix.determinant() != 0.0)?));
        let known = whole();
        let is_there = |keyword: &&str| header.text(keyword).is_some() || number(keyword).is_some();
        let is_distorted = || kinds[0].get(8..).filter(|more| !more.is_empty()).map(|_| format!("CTYPE1 = {}", kinds[0]));
        let is_turned = || number("LONPOLE").filter(|pole| *pole != 180.0).map(|pole| format!("LONPOLE = {pole}"));
        let is_old = || header.text("RADESYS").filter(|frame| frame.trim().starts_with("FK4")).map(|frame| format!("RADESYS = {frame}"));
        let is_rotated = || number("CROTA2").filter(|turn| *turn != 0.0 && !has_matrix).map(|turn| format!("CROTA2 = {turn}"));
        let is_polynomial = || {
            let plane = kinds[0].ends_with("TAN").then_some(["PV1_0", "PV1_1", "PV1_2", "PV2_0", "PV2_1", "PV2_2"]);
            plane.and_then(|keywords| keywords.into_iter().find(|keyword| is_there(keyword))).map(str::to_owned)
        };
        let others =
            || ["A_ORDER", "B_ORDER", "CPDIS1", "CPDIS2"].iter().find(|keyword| is_there(keyword)).map(|keyword| (*keyword).to_owned());
        let is_of_another_year = || number("EQUINOX").filter(|year| *year != 2000.0).map(|year| format!("EQUINOX = {year}"));
        let is_none = || known.is_none().then(|| "invalid CRPIX, CRVAL, CD, PC or CDELT".to_owned());
        let peculiar = is_none()
            .or_else(is_distorted)
            .or_else(others)
            .or_else(is_rotated)
            .or_else(is_polynomial)
            .or_else(is_turned)
            .or_else(is_old)
            .or_else(is_of_another_year);
        let (reference, value, matrix) = known.unwrap_or((DVec2::ZERO, DVec2::ZERO, DMat2::IDENTITY));
        Some(Self { kinds, peculiar, reference, value, matrix, height: *header.axes()?.get(1)? as f64 })
    }

    /// The direction of a place of the picture, columns and rows from its upper left corner, in the frame of its coordinates.
    fn direction(&self, x: f64, y: f64) -> DVec3 {
        // Pixel centres are whole numbers from one on, the first row is the lowest.
        let pixel = DVec2::new(x + 0.5, self.height - y + 0.5);
        let flat = (self.matrix * (pixel - self.reference)) * std::f64::consts::PI / 180.0;
        let (l, b) = (self.value.x.to_radians(), self.value.y.to_radians());
        let middle = DVec3::new(b.cos() * l.cos(), b.cos() * l.sin(), b.sin());
        let (east, north) = (DVec3::new(-l.sin(), l.cos(), 0.0), DVec3::new(-b.sin() * l.cos(), -b.sin() * l.sin(), b.cos()));
        (middle + flat.x * east + flat.y * north).normalize()
    }

    /// Why places of another picture cannot be compared with those of this one, a picture of a scene; nothing where they can.
    pub fn differs(&self, other: &Self) -> Option<String> {
        let [ours, theirs] = [self, other].map(|sky| sky.kinds.join(" and "));
        let of_kind = || (ours != theirs).then(|| format!("has the axes {theirs}, the scene's picture {ours}"));
        other.peculiar.as_ref().map(|feature| format!("has {feature}, which is unsupported")).or_else(of_kind)
    }

    /// How many of this one's pixels a place of another picture lies from where this one has it, which does not
    /// [differ](Self::differs). Both are tangent planes.
    pub fn pixels_apart(&self, other: &Self, x: f64, y: f64) -> f64 {
        let pixel = self.matrix.determinant().abs().sqrt().to_radians();
        (self.direction(x, y) - other.direction(x, y)).length() / pixel
    }
}
