//! Writes docs/gas_shadow.png: what is ionised behind a clump by beams, and by photons that go by chance.
//!
//! `cargo run --release -p barnard-study --example shadow`

#[path = "../../ionisation/tests/common/chance.rs"]
mod chance;
#[path = "../../ionisation/tests/common/clump.rs"]
mod clump;

use barnard_files::formats::replace;
use barnard_study::maps::{Map, Maps};
use clump::{Clump, HALF_PC};
use ionisation::balance::Diffuse;

/// Voxels along an edge, and photons of a round.
const EDGE: usize = 64;
const PHOTONS: u64 = 1_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let clump = Clump::new(EDGE);
    let found = [
        ("beams, own light outward", clump.by_beams(Diffuse::Outward)),
        ("photons, own light on the spot", clump.by_chance(false, PHOTONS)),
        ("photons, own light in all directions", clump.by_chance(true, PHOTONS)),
    ];
    let maps = found.map(|(title, neutral)| {
        let [lit, shadow] = clump.ionised(&neutral);
        println!("{title}: {lit:.4} of what is lit, {shadow:.4} of the shadow");
        let values = neutral[EDGE / 2 * EDGE * EDGE..][..EDGE * EDGE].iter().map(|neutral| 1.0 - neutral).collect();
        let sides = (-HALF_PC, HALF_PC);
        Map { title: title.into(), size: (EDGE, EDGE), across: sides, upwards: sides, values, range: (0.0, 1.0) }
    });
    let title = "Ionised part of hydrogen behind a clump".into();
    let png = Maps { name: "gas_shadow".into(), title, maps: maps.into() }.png()?;
    replace(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/gas_shadow.png"), &png)?;
    Ok(())
}
