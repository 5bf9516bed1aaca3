//! The `[detail]` table: structure of densities below their voxels.

use crate::detail::{self, Detail};
use crate::error::Result;
use crate::properties::{Integer, Key, KeyRow, Number, OrDefault, Section};

const SEED: Key<Integer<u32>, OrDefault> = Key::integer("seed", "seed of the noise").default(1);
const OCTAVES: Key<Integer<usize>, OrDefault> =
    Key::integer("octaves", "octaves of waves from four voxels downwards; unresolved octaves cost nothing")
        .range(detail::OCTAVES)
        .default(6);
const STRENGTH: Key<Number, OrDefault> =
    Key::number("strength", "displacement relative to the wavelength, root mean square of a component; 0 disables detail")
        .range(detail::STRENGTHS)
        .default(0.05);

pub(super) const KEYS: &[KeyRow] = &[SEED.row, OCTAVES.row, STRENGTH.row];

pub(super) fn build(section: &Section) -> Result<Detail> {
    section.check(KEYS)?;
    Ok(Detail { seed: section.read(&SEED)?, octaves: section.read(&OCTAVES)?, strength: section.read(&STRENGTH)? })
}
