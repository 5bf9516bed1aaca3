//! Cameras as scenes say them: `[camera]` and `[bookmark.NAME]`.

use std::f64::consts::PI;

use glam::DVec3;
use spectra::units::{Angle, Length};

use super::{Camera, MAX_EDGE, Projection, SIZE, SUPERSAMPLING, TURN, stereo};
use crate::data::Inputs;
use crate::error::Result;
use crate::properties::{Key, Kind, Section, build_kind_with};

/// The keys that every camera takes.
pub(crate) const COMMON: &[Key] = &[
    Key::required("position", "position", "where the observer is"),
    Key::optional("target", "position", "0 0 0 pc", "what they look at"),
    Key::optional("up", "direction", "[0, 1, 0]", "what is up in the image"),
    Key::optional("size", "[width, height]", "[512, 512]", "pixels of the image"),
    Key::optional(
        "crop",
        "list of numbers",
        "the whole image",
        "[column, row, width, height] of the part that is rendered, in pixels from the upper left corner",
    ),
    Key::optional("supersampling", "integer", "1", "rays along each side of a pixel, 1 to 16"),
    Key::optional("stereo", "table", "one eye", "two eyes beside each other, [camera.stereo]"),
    Key::optional("path", "table", "the camera stands still", "how the camera moves, [camera.path]"),
];

/// All kinds of camera that a scene may name.
pub const KINDS: &[Kind<Projection>] = &[
    Kind {
        name: "perspective",
        summary: "all rays from one point",
        keys: &[Key::required("field_of_view", "angle", "horizontal field of view, below 180 deg")],
        build: |section, _| {
            let fov = section.need_positive::<Angle>("field_of_view")?;
            if fov.0 >= std::f64::consts::PI {
                return Err(section.error("field_of_view", format!("{fov} is too wide; it must be below 180 deg")));
            }
            Ok(Projection::Perspective { half_width: (0.5 * fov.0).tan() })
        },
    },
    Kind {
        name: "orthographic",
        summary: "parallel rays, starting on the image plane",
        keys: &[Key::required("width", "length", "width of the image")],
        build: |section, _| Ok(Projection::Orthographic { half_width_pc: 0.5 * section.need_positive::<Length>("width")?.0 }),
    },
    Kind {
        name: "fisheye",
        summary: "equal angles from the middle outwards, black beside the circle: a dome master, with what the audience faces at the bottom",
        keys: &[
            Key::optional("aperture", "angle", "180 deg", "the angle across the circle, up to 360 deg"),
            Key::optional(
                "tilt",
                "angle",
                "0 deg",
                "how far the middle of the image leans from up towards the target, 0 to 180 deg; at 90 deg the target is in the middle",
            ),
        ],
        build: |section, _| {
            let aperture = section.positive::<Angle>("aperture")?.unwrap_or(Angle(PI));
            let tilt = section.quantity::<Angle>("tilt")?.unwrap_or(Angle(0.0));
            if aperture.0 > TURN * (1.0 + 1e-12) {
                return Err(section.error("aperture", format!("{aperture} is more than all around; it is 360 deg at most")));
            }
            if !(0.0..=PI * (1.0 + 1e-12)).contains(&tilt.0) {
                return Err(section.error("tilt", format!("{tilt} is no tilt; it is 0 to 180 deg")));
            }
            Ok(Projection::dome(aperture.0, tilt.0))
        },
    },
    Kind {
        name: "equirectangular",
        summary: "all around, longitude by latitude, the target in the middle; twice as wide as high",
        keys: &[],
        build: |_, _| Ok(Projection::SPHERE),
    },
    Kind {
        name: "cubemap",
        summary: "all around, six faces of a cube one above the other, as environment maps of OpenEXR have them; six times as high as wide",
        keys: &[],
        build: |_, _| Ok(Projection::CUBE),
    },
];

/// Reads a `[bookmark.NAME]` table: a camera, with the pixels of the scene's own where it does not say others.
///
/// # Errors
/// Where a key is unknown, missing or wrong; its place is said.
pub fn bookmark(section: &Section, inputs: &Inputs, own: &Camera) -> Result<Camera> {
    let mut camera = build(section, inputs)?;
    if !section.has("size") {
        (camera.width, camera.height) = (own.width, own.height);
    }
    if !section.has("supersampling") {
        camera.supersampling = own.supersampling;
    }
    Ok(camera)
}

/// Reads the `[camera]` table.
///
/// # Errors
/// Where a key is unknown, missing or wrong; its place is said.
pub fn build(section: &Section, inputs: &Inputs) -> Result<Camera> {
    let projection = build_kind_with("camera", KINDS, COMMON, section, inputs)?;
    if section.has("path") {
        return Err(section.error("path", "a bookmark stands still; the path of a camera is [camera.path]"));
    }
    let (position, target) = (section.need_position("position")?, section.position("target")?.unwrap_or(DVec3::ZERO));
    let camera = Camera::look_at(position, target).up(section.direction("up")?.unwrap_or(DVec3::Y));
    if !camera.forward.is_finite() {
        return Err(section.error("target", "the camera stands on its target; move one of them"));
    }
    if !camera.right.is_finite() {
        return Err(section.error("up", "up is parallel to the viewing direction; choose another"));
    }
    let size = section.numbers("size")?.unwrap_or_else(|| vec![SIZE as f64; 2]);
    let whole = |v: f64| v.fract() == 0.0 && (1.0..=MAX_EDGE as f64).contains(&v);
    let &[width, height] = &size[..] else { return Err(section.error("size", "size is [width, height]")) };
    if !whole(width) || !whole(height) {
        return Err(section
            .error("size", format!("an image of {width} x {height} pixels cannot be made; both are whole numbers from 1 to {MAX_EDGE}")));
    }
    let supersampling = section.integer("supersampling", *SUPERSAMPLING.start() as i64..=*SUPERSAMPLING.end() as i64)?;
    let stereo = section.table("stereo")?.map(|own| stereo::build(&own, position.distance(target))).transpose()?;
    if matches!(projection, Projection::Perspective { .. })
        && let Some(own) = section.table("stereo")?
    {
        own.refuse(&["pole_merge"], "images of all around")?;
    }
    if stereo.is_some() && matches!(projection, Projection::Orthographic { .. }) {
        return Err(section.error("stereo", "two eyes need a kind of camera whose rays start at one point, such as \"perspective\""));
    }
    let camera =
        Camera { projection, stereo, ..camera }.size(width as usize, height as usize).supersampling(supersampling.unwrap_or(1) as usize);
    match section.numbers("crop")?.as_deref() {
        None => Ok(camera),
        Some(&[column, row, width, height]) if [column, row, width, height].iter().all(|v| v.fract() == 0.0 && *v >= 0.0) => {
            let part = camera.crop(column as usize, row as usize, width as usize, height as usize);
            part.map_err(|error| section.error("crop", error.to_string()))
        }
        Some(_) => Err(section.error("crop", "crop is [column, row, width, height], four whole numbers")),
    }
}
