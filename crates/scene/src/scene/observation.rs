//! The `[observation]` table: where on the sky the picture is taken.

use spectra::units::{Angle, Length};

use super::output::named;
use crate::camera::{Camera, Projection};
use crate::error::{Error, Result};
use crate::observation::{Observation, RadianceUnit, SkyFrame, SkyPlace};
use crate::properties::{Key, Section};

pub(super) const KEYS: &[Key] = &[
    Key::required(
        "target",
        "text",
        "the place of the sky in the middle of the camera's whole image (of a dome its own axis, the zenith unless it is tilted): \"18h18m48s -13d49m\", \"18:18:48 -13:49:00\" or \"274.7 -13.82\" in degrees",
    ),
    Key::optional("frame", "text", "icrs", "icrs or galactic: what the target's two angles are"),
    Key::optional("position_angle", "angle", "0 deg", "of the picture's up, from north through east; with 0 deg north is up and east left"),
    Key::optional(
        "distance",
        "length",
        "none",
        "how far away the middle of an orthographic image is, needed there: its lengths become angles; other cameras stand where they stand and do not ask",
    ),
    Key::optional(
        "unit",
        "text",
        "W m-2 sr-1",
        "what FITS files hold: W m-2 sr-1, erg s-1 cm-2 arcsec-2, MJy/sr, R (Rayleigh), photon s-1 m-2 sr-1, mag/arcsec2 AB, mag/arcsec2 ST or mag/arcsec2 Vega",
    ),
];

pub(super) fn build(section: &Section) -> Result<Observation> {
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let frame = named(section, "frame", SkyFrame::ROWS)?;
    Ok(Observation {
        target: section.wrap("target", SkyPlace::parse(frame, section.need_text("target")?))?,
        position_angle: section.quantity::<Angle>("position_angle")?.map_or(0.0, |angle| angle.0),
        distance_pc: section.positive::<Length>("distance")?.map(|length| length.0),
        unit: named(section, "unit", RadianceUnit::ROWS)?,
    })
}

/// Refuses what is no observation by this camera.
///
/// # Errors
/// Where a number is none that it can be, or a parallel view has no distance.
pub(super) fn check(observation: &Observation, camera: &Camera) -> Result<()> {
    observation.target.check()?;
    let is_finite = observation.position_angle.is_finite() && observation.distance_pc.is_none_or(|pc| pc.is_finite() && pc > 0.0);
    if !is_finite {
        return Err(Error::value("observation", "its angle or distance is not finite", "an angle, and a distance above zero"));
    }
    if matches!(camera.projection, Projection::Orthographic { .. }) && observation.distance_pc.is_none() {
        return Err(Error::value(
            "distance of an observation",
            "missing: an orthographic camera measures lengths",
            "how far away the middle of its image is, such as distance = \"400 pc\"",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// Parallel views need a distance; cameras that stand somewhere have their own.
    #[test]
    fn distances_are_asked_where_they_are_needed() {
        let flat = Camera::look_at(DVec3::Z, DVec3::ZERO).orthographic_pc(2.0);
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO);
        let near = Observation::default();
        let far = Observation { distance_pc: Some(400.0), ..near };
        assert!(check(&near, &camera).is_ok() && check(&far, &flat).is_ok() && check(&far, &camera).is_ok());
        assert!(check(&near, &flat).unwrap_err().to_string().contains("400 pc"));
        assert!(check(&Observation { distance_pc: Some(-1.0), ..near }, &flat).is_err());
        assert!(check(&Observation { position_angle: f64::NAN, ..near }, &camera).is_err());
    }
}
