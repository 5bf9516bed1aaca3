//! A clump's shadow by beams, beside photons by chance.

use crate::common::clump::Clump;
use ionisation::balance::Diffuse;

/// Voxels along an edge, and photons of a round.
const EDGE: usize = 32;
const PHOTONS: u64 = 100_000;

/// Where light of recombinations stays on the spot, beams find what photons find, in the shadow and beside it. Where it goes in
/// all directions it goes into the shadow as well, which beams, whose own light goes outward, leave dark.
#[test]
fn beams_are_beside_photons() {
    let clump = Clump::new(EDGE);
    let result = |name: &str, neutral: Vec<f64>| {
        let [lit, shadow] = clump.ionised(&neutral);
        println!("{name}: {lit:.4} of what is lit, {shadow:.4} of the shadow");
        [lit, shadow]
    };
    let (spot, outward) = (clump.by_beams(Diffuse::OnTheSpot), clump.by_beams(Diffuse::Outward));
    let (spot, outward) = (result("beams, on the spot", spot), result("beams, outward", outward));
    let by_chance = result("photons, on the spot", clump.by_chance(false, PHOTONS));
    let diffuse = result("photons", clump.by_chance(true, PHOTONS));
    for found in [spot, outward, diffuse] {
        assert!((found[0] - by_chance[0]).abs() < 1e-3 && found[0] > 0.99, "{found:?}");
    }
    // The shadow's edge runs through voxels, each way by some.
    assert!((spot[1] - by_chance[1]).abs() < 0.02 && (outward[1] - by_chance[1]).abs() < 0.02);
    assert!(diffuse[1] > by_chance[1] + 0.1);
}
