//! The `[display.glare]` table: what optics make of the bright points of a picture.

use spectra::units::Angle;

use crate::error::Result;
use crate::image::{Glare, glare, optics};
use crate::properties::{Key, Section};

pub(super) const KEYS: &[Key] = &[
    Key::optional("optics", "text", "hubble", "optics of the glare").of("optics"),
    Key::optional("size", "number", "0.5", "size of spikes and rings: λ/D at 550 nm in thousandths of the longer edge"),
    Key::optional("rotation", "angle", "0 deg", "rotation of the optics, counterclockwise"),
    Key::optional("seeing", "number", "0", "seeing, full width at half maximum in thousandths of the longer edge"),
    Key::optional("halo", "number", "0.02", "fraction of light in the halo"),
];

pub(super) fn build(section: &Section) -> Result<Glare> {
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let plain = Glare::default();
    let optics = section.text("optics")?.map(|name| section.wrap("optics", optics::named(name))).transpose()?;
    Ok(Glare {
        optics: optics.unwrap_or(plain.optics),
        size: section.number("size", glare::SIZES)?.unwrap_or(plain.size),
        rotation: section.quantity::<Angle>("rotation")?.map_or(plain.rotation, |angle| angle.0),
        seeing: section.number("seeing", glare::SEEINGS)?.unwrap_or(plain.seeing),
        halo: section.number("halo", glare::HALOS)?.unwrap_or(plain.halo),
    })
}
