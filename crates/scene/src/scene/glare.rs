//! The `[display.glare]` table: what optics make of the bright points of a picture.

use spectra::units::Angle;

use crate::error::Result;
use crate::image::{Glare, glare, optics};
use crate::properties::{Key, KeyRow, Number, OrDefault, Section, Text};

const OPTICS: Key<Text, OrDefault> = Key::text("optics", "optics of the glare").default("hubble").of("optics");
const SIZE: Key<Number, OrDefault> =
    Key::number("size", "size of spikes and rings: λ/D at 550 nm in thousandths of the longer edge").range(glare::SIZES).default(0.5);
const ROTATION: Key<Angle, OrDefault> = Key::quantity::<Angle>("rotation", "rotation of the optics, counterclockwise").default("0 deg");
const SEEING: Key<Number, OrDefault> =
    Key::number("seeing", "seeing, full width at half maximum in thousandths of the longer edge").range(glare::SEEINGS).default(0.0);
const HALO: Key<Number, OrDefault> = Key::number("halo", "fraction of light in the halo").range(glare::HALOS).default(0.02);

pub(super) const KEYS: &[KeyRow] = &[OPTICS.row, SIZE.row, ROTATION.row, SEEING.row, HALO.row];

pub(super) fn build(section: &Section) -> Result<Glare> {
    section.check(KEYS)?;
    let optics = section.wrap(&OPTICS, optics::by_name(section.read(&OPTICS)?))?;
    Ok(Glare {
        optics,
        size: section.read(&SIZE)?,
        rotation: section.read(&ROTATION)?.0,
        seeing: section.read(&SEEING)?,
        halo: section.read(&HALO)?,
    })
}
