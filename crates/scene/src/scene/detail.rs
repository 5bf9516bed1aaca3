//! The `[detail]` table: what densities have below their voxels.

use crate::detail::{DEVIATIONS, Detail, OCTAVES, SLOPES, STRENGTHS};
use crate::error::Result;
use crate::properties::{Key, Section};

pub(super) const KEYS: &[Key] = &[
    Key::optional("seed", "integer", "1", "seed of the noise"),
    Key::optional("octaves", "integer", "4", "octaves of waves from two voxels downwards, 1 to 8; unresolved octaves cost nothing"),
    Key::optional("strength", "number", "1", "factor of the deviations; 0 disables detail"),
    Key::optional(
        "deviation",
        "number",
        "measured on each grid",
        "deviation of ln density in the octave of two voxels: 0.1 is soft, 0.5 rough",
    ),
    Key::optional("slope", "number", "measured on each grid", "n of the spectrum k^-n; 3.667 is Kolmogorov's"),
];

pub(super) fn build(section: &Section) -> Result<Detail> {
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let plain = Detail::default();
    Ok(Detail {
        seed: section.integer("seed", 0..=i64::from(u32::MAX))?.map_or(plain.seed, |n| n as u32),
        octaves: section.integer("octaves", OCTAVES)?.map_or(plain.octaves, |n| n as usize),
        strength: section.number("strength", STRENGTHS)?.unwrap_or(plain.strength),
        deviation: section.number("deviation", DEVIATIONS)?,
        slope: section.number("slope", SLOPES)?,
    })
}
