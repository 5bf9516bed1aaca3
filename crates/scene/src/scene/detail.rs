//! The `[detail]` table: what densities have below their voxels.

use crate::detail::{self, Detail};
use crate::error::Result;
use crate::properties::{Integer, Key, KeyRow, Number, OrDefault, Section};

const SEED: Key<Integer<u32>, OrDefault> = Key::integer("seed", "seed of the noise").default(1);
const OCTAVES: Key<Integer<usize>, OrDefault> =
    Key::integer("octaves", "octaves of waves from two voxels downwards; unresolved octaves cost nothing")
        .range(detail::OCTAVES)
        .default(4);
const STRENGTH: Key<Number, OrDefault> =
    Key::number("strength", "factor of the deviations; 0 disables detail").range(detail::STRENGTHS).default(1.0);
const DEVIATION: Key<Number> = Key::number("deviation", "deviation of ln density in the octave of two voxels: 0.1 is soft, 0.5 rough")
    .range(detail::DEVIATIONS)
    .example("0.3")
    .otherwise("measured on each grid");
const SLOPE: Key<Number> = Key::number("slope", "n of the spectrum k^-n; 3.667 is Kolmogorov's")
    .range(detail::SLOPES)
    .example("3.667")
    .otherwise("measured on each grid");

pub(super) const KEYS: &[KeyRow] = &[SEED.row, OCTAVES.row, STRENGTH.row, DEVIATION.row, SLOPE.row];

pub(super) fn build(section: &Section) -> Result<Detail> {
    section.check(KEYS)?;
    Ok(Detail {
        seed: section.read(&SEED)?,
        octaves: section.read(&OCTAVES)?,
        strength: section.read(&STRENGTH)?,
        deviation: section.read(&DEVIATION)?,
        slope: section.read(&SLOPE)?,
    })
}
