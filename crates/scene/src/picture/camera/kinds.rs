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
    Key::required("position", "position", "position of the observer"),
    Key::optional("target", "position", "0 0 0 pc", "target of the view"),
    Key::optional("up", "direction", "[0, 1, 0]", "up direction of the image"),
    Key::optional("size", "[width, height]", "[512, 512]", "pixels of the image"),
    Key::optional(
        "crop",
        "list of numbers",
        "the whole image",
        "[column, row, width, height] of the rendered part, in pixels from the upper left corner",
    ),
    Key::optional("supersampling", "integer", "1", "rays per pixel edge, 1 to 16"),
    Key::optional("stereo", "table", "one eye", "stereo, [camera.stereo]"),
    Key::optional("path", "table", "a static camera", "camera path, [camera.path]"),
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
                return Err(section.error("field_of_view", format!("{fov} is out of range; a field of view must be below 180 deg")));
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
        summary: "dome master: equidistant, black outside of the circle, front of the audience at the bottom",
        keys: &[
            Key::optional("aperture", "angle", "180 deg", "angle across the circle, up to 360 deg"),
            Key::optional(
                "tilt",
                "angle",
                "0 deg",
                "tilt of the image centre from up towards the target, 0 to 180 deg; at 90 deg the target is in the centre",
            ),
        ],
        build: |section, _| {
            let aperture = section.positive::<Angle>("aperture")?.unwrap_or(Angle(PI));
            let tilt = section.quantity::<Angle>("tilt")?.unwrap_or(Angle(0.0));
            if aperture.0 > TURN * (1.0 + 1e-12) {
                return Err(section.error("aperture", format!("{aperture} is out of range; an aperture must be at most 360 deg")));
            }
            if !(0.0..=PI * (1.0 + 1e-12)).contains(&tilt.0) {
                return Err(section.error("tilt", format!("{tilt} is out of range; a tilt must be between 0 and 180 deg")));
            }
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
/// If a key is unknown, missing or wrong; its place is said.
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
/// If a key is unknown, missing or wrong; its place is said.
pub fn build(section: &Section, inputs: &Inputs) -> Result<Camera> {
    let projection = build_kind_with("camera", KINDS, COMMON, section, inputs)?;
    if section.has("path") {
        return Err(section.error("path", "a bookmark cannot have a path; write it as [camera.path]"));
    }
    let (position, target) = (section.need_position("position")?, section.position("target")?.unwrap_or(DVec3::ZERO));
    let camera = Camera::look_at(position, target).up(section.direction("up")?.unwrap_or(DVec3::Y));
    if !camera.forward.is_finite() {
        return Err(section.error("target", "camera and target are at the same position; move one of them"));
    }
    if !camera.right.is_finite() {
        return Err(section.error("up", "up is parallel to the viewing direction; choose another"));
    }
    let malformed = || section.error("size", "a size is [width, height] in pixels, such as [512, 512]");
    let size = section.numbers("size").map_err(|_| malformed())?.unwrap_or_else(|| vec![SIZE as f64; 2]);
    let whole = |v: f64| v.fract() == 0.0 && (1.0..=MAX_EDGE as f64).contains(&v);
    let &[width, height] = &size[..] else { return Err(malformed()) };
    if !whole(width) || !whole(height) {
        return Err(section.error(
            "size",
            format!("a size of {width} x {height} pixels is out of range; both must be whole numbers from 1 to {MAX_EDGE}"),
        ));
    }
    let supersampling = section.integer("supersampling", *SUPERSAMPLING.start() as i64..=*SUPERSAMPLING.end() as i64)?;
    let stereo = section.table("stereo")?.map(|own| stereo::build(&own, position.distance(target))).transpose()?;
    if matches!(projection, Projection::Perspective { .. })
        && let Some(own) = section.table("stereo")?
    {
        own.refuse(&["pole_merge"], "360° images")?;
    }
    if stereo.is_some() && matches!(projection, Projection::Orthographic { .. }) {
        return Err(section.error("stereo", "stereo requires a camera whose rays start at one point; use a kind such as \"perspective\""));
    }
    let camera =
        Camera { projection, stereo, ..camera }.size(width as usize, height as usize).supersampling(supersampling.unwrap_or(1) as usize);
    match section.numbers("crop")?.as_deref() {
        None => Ok(camera),
        Some(&[column, row, width, height]) if [column, row, width, height].iter().all(|v| v.fract() == 0.0 && *v >= 0.0) => {
            let part = camera.crop(column as usize, row as usize, width as usize, height as usize);
            part.map_err(|error| section.error("crop", error.to_string()))
        }
        Some(_) => Err(section.error("crop", "crop must be [column, row, width, height], four whole numbers")),
    }
}
