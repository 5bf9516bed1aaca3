//! The `[observation]` table: where on the sky the picture is taken.

use spectra::units::{Angle, Length};

use crate::camera::{Camera, Projection};
use crate::error::{Error, Result};
use crate::observation::{Observation, RadianceUnit, SkyFrame, SkyPlace};
use crate::properties::{Choice, Key, KeyRow, OrDefault, Required, Section, Text};

const TARGET: Key<Text, Required> = Key::text(
    "target",
    "sky position of the centre of the whole image (of a dome: its axis, the zenith unless tilted): \"18h18m48s -13d49m\", \"18:18:48 -13:49:00\" or \"274.7 -13.82\" in degrees",
)
.required();
const FRAME: Key<Choice<SkyFrame>, OrDefault> = Key::choice("frame", "frame of the target").default("icrs");
const POSITION_ANGLE: Key<Angle, OrDefault> = Key::quantity::<Angle>(
    "position_angle",
    "position angle of the image's up direction, from north through east; at 0 deg north is up and east left",
)
.default("0 deg");
const DISTANCE: Key<Length> = Key::quantity::<Length>(
    "distance",
    "distance of the centre of an orthographic image, which converts lengths to angles; required there, unused by other cameras",
)
.positive();
const UNIT: Key<Choice<RadianceUnit>, OrDefault> = Key::choice("unit", "unit of FITS files; R is Rayleigh").default("W m-2 sr-1");

pub(super) const KEYS: &[KeyRow] = &[TARGET.row, FRAME.row, POSITION_ANGLE.row, DISTANCE.row, UNIT.row];

pub(super) fn build(section: &Section) -> Result<Observation> {
    section.check(KEYS)?;
    Ok(Observation {
        target: section.wrap(&TARGET, SkyPlace::parse(section.read(&FRAME)?, section.read(&TARGET)?))?,
        position_angle: section.read(&POSITION_ANGLE)?.0,
        distance_pc: section.read(&DISTANCE)?.map(|length| length.0),
        unit: section.read(&UNIT)?,
    })
}

/// Refuses what is no observation by this camera.
///
/// # Errors
/// If a number is none that it can be, or a parallel view has no distance.
pub(super) fn check(observation: &Observation, camera: &Camera) -> Result<()> {
    observation.target.check()?;
    let is_finite = observation.position_angle.is_finite() && observation.distance_pc.is_none_or(|pc| pc.is_finite() && pc > 0.0);
    if !is_finite {
        return Err(Error::out_of_range(
            "position angle or distance of the observation",
            "not finite, or not above zero",
            "a finite angle, and a finite distance above zero",
        ));
    }
    if matches!(camera.projection, Projection::Orthographic { .. }) && observation.distance_pc.is_none() {
        let what = "the distance of the observation with an orthographic camera";
        return Err(Error::missing(what, "add it to [observation], such as distance = \"400 pc\""));
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
        let flat = Camera::look_at(DVec3::Z, DVec3::ZERO).with_orthographic_pc(2.0);
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO);
        let near = Observation::default();
        let far = Observation { distance_pc: Some(400.0), ..near };
        assert!(check(&near, &camera).is_ok() && check(&far, &flat).is_ok() && check(&far, &camera).is_ok());
        assert!(check(&near, &flat).unwrap_err().to_string().contains("400 pc"));
        assert!(check(&Observation { distance_pc: Some(-1.0), ..near }, &flat).is_err());
        assert!(check(&Observation { position_angle: f64::NAN, ..near }, &camera).is_err());
    }
}
