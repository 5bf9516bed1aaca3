//! Cameras as scenes say them: `[camera]` and `[bookmark.NAME]`.

use std::f64::consts::PI;

use spectra::units::{Angle, Length};

use super::{Camera, MAX_EDGE, MAX_SUPERSAMPLING, Projection, TURN, stereo};
use crate::data::Inputs;
use crate::error::Result;
use crate::properties::{
    Direction, Integer, Key, KeyRow, Kind, Numbers, OrDefault, Position, Required, Section, Size, SubTable, build_kind_with,
};

pub(crate) const POSITION: Key<Position, Required> = Key::position("position", "position of the observer").required();
pub(crate) const TARGET: Key<Position, OrDefault> = Key::position("target", "target of the view").default("0 0 0 pc");
const UP: Key<Direction, OrDefault> = Key::direction("up", "up direction of the image").default(&[0.0, 1.0, 0.0]);
const SIZE: Key<Size, OrDefault> = Key::size("size", "pixels of the image").positive().at_most(MAX_EDGE as f64).default(&[512.0, 512.0]);
const CROP: Key<Numbers> = Key::numbers("crop", "[column, row, width, height] of the rendered part, in pixels from the upper left corner")
    .not_negative()
    .example("[0, 0, 256, 256]")
    .otherwise("the whole image");
const SUPERSAMPLING: Key<Integer<usize>, OrDefault> =
    Key::integer("supersampling", "rays per pixel edge").range(1..=MAX_SUPERSAMPLING as i64).default(1);
const STEREO: Key<SubTable> = Key::table("stereo", "stereo, [camera.stereo]").otherwise("one eye");
const PATH: Key<SubTable> = Key::table("path", "camera path, [camera.path]").otherwise("a static camera");
const FIELD_OF_VIEW: Key<Angle, Required> =
    Key::quantity::<Angle>("field_of_view", "horizontal field of view").positive().below(PI).required();
const WIDTH: Key<Length, Required> = Key::quantity::<Length>("width", "width of the image").positive().required();
const APERTURE: Key<Angle, OrDefault> =
    Key::quantity::<Angle>("aperture", "angle across the circle").positive().at_most(TURN * (1.0 + 1e-12)).default("180 deg");
const TILT: Key<Angle, OrDefault> =
    Key::quantity::<Angle>("tilt", "tilt of the image centre from up towards the target, at 90 deg the target is in the centre")
        .range(0.0..=PI * (1.0 + 1e-12))
        .default("0 deg");

/// The keys that every camera takes.
pub(crate) const COMMON: &[KeyRow] = &[POSITION.row, TARGET.row, UP.row, SIZE.row, CROP.row, SUPERSAMPLING.row, STEREO.row, PATH.row];

/// All kinds of camera that a scene may name.
pub const KINDS: &[Kind<Projection>] = &[
    Kind {
        name: "perspective",
        summary: "all rays from one point",
        keys: &[FIELD_OF_VIEW.row],
        build: |section, _| {
            let fov = section.read(&FIELD_OF_VIEW)?;
            Ok(Projection::Perspective { half_width: (0.5 * fov.0).tan() })
        },
    },
    Kind {
        name: "orthographic",
        summary: "parallel rays, starting on the image plane",
        keys: &[WIDTH.row],
        build: |section, _| Ok(Projection::Orthographic { half_width_pc: 0.5 * section.read(&WIDTH)?.0 }),
    },
    Kind {
        name: "fisheye",
        summary: "dome master: equidistant, black outside of the circle, front of the audience at the bottom",
        keys: &[APERTURE.row, TILT.row],
        build: |section, _| {
            let aperture = section.read(&APERTURE)?;
            let tilt = section.read(&TILT)?;
            Ok(Projection::dome(aperture.0, tilt.0))
        },
    },
    Kind {
        name: "equirectangular",
        summary: "360° image, longitude by latitude, target in the centre; twice as wide as high",
        keys: &[],
        build: |_, _| Ok(Projection::SPHERE),
    },
    Kind {
        name: "cubemap",
        summary: "360° image, six faces of a cube above each other, as in OpenEXR environment maps; six times as high as wide",
        keys: &[],
        build: |_, _| Ok(Projection::CUBE),
    },
];

/// Reads a `[bookmark.NAME]` table: a camera, with the pixels of the scene's own where it does not say others.
///
/// # Errors
/// If a key is unknown, missing or wrong; the error states its place.
pub fn bookmark(section: &Section, inputs: &Inputs, viewed: &Camera) -> Result<Camera> {
    let mut camera = build(section, inputs)?;
    if !section.has(&SIZE) {
        (camera.width, camera.height) = (viewed.width, viewed.height);
    }
    if !section.has(&SUPERSAMPLING) {
        camera.supersampling = viewed.supersampling;
    }
    Ok(camera)
}

/// Reads the `[camera]` table.
///
/// # Errors
/// If a key is unknown, missing or wrong; the error states its place.
pub fn build(section: &Section, inputs: &Inputs) -> Result<Camera> {
    let projection = build_kind_with("camera", KINDS, COMMON, section, inputs)?;
    if section.has(&PATH) {
        return Err(section.error(&PATH, "a bookmark cannot have a path; write it as [camera.path]"));
    }
    let (position, target) = (section.read(&POSITION)?, section.read(&TARGET)?);
    let camera = Camera::look_at(position, target).with_up(section.read(&UP)?);
    if !camera.forward.is_finite() {
        return Err(section.error(&TARGET, "camera and target are at the same position; move one of them"));
    }
    if !camera.right.is_finite() {
        return Err(section.error(&UP, "up is parallel to the viewing direction; choose another"));
    }
    let [width, height] = section.read(&SIZE)?;
    let eyes = section.read(&STEREO)?.map(|table| stereo::build(&table, position.distance(target))).transpose()?;
    if matches!(projection, Projection::Perspective { .. })
        && let Some(table) = section.read(&STEREO)?
    {
        table.refuse(&[&stereo::POLE_MERGE.row], "360° images")?;
    }
    if eyes.is_some() && matches!(projection, Projection::Orthographic { .. }) {
        return Err(section.error(&STEREO, "stereo requires a camera whose rays start at one point; use a kind such as \"perspective\""));
    }
    let camera = Camera { projection, stereo: eyes, ..camera }.with_size(width, height).with_supersampling(section.read(&SUPERSAMPLING)?);
    match section.read(&CROP)?.as_deref() {
        None => Ok(camera),
        Some(&[column, row, width, height]) if [column, row, width, height].iter().all(|v| v.fract() == 0.0) => {
            let part = camera.crop(column as usize, row as usize, width as usize, height as usize);
            part.map_err(|error| section.error(&CROP, error.to_string()))
        }
        Some(_) => Err(section.error(&CROP, "crop must be [column, row, width, height], four whole numbers")),
    }
}
