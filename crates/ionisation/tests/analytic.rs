//! Clouds whose ionised parts have a size that can be written down.

use std::f64::consts::PI;

use ionisation::atoms::{Atoms, ELEMENTS, Element, photons_of_helium};
use ionisation::balance::{Diffuse, Gas, GasState};
use ionisation::lanes::Lanes;
use ionisation::light::IonisingLight;
use ionisation::sphere::Sphere;

const HYDROGEN: [f64; ELEMENTS] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const Q: f64 = 1e49;
const PARSEC_CM: f64 = 3.085_677_581e18;

fn pure(density: f64, dust_cm2: f64, diffuse: Diffuse) -> Sphere {
    let gas = Gas { dust_cm2, isothermal: Some(1e4), ..Gas::new(density, HYDROGEN) };
    Sphere::new(gas, &IonisingLight::blackbody(35_000.0, Q), diffuse, [1e-5 * PARSEC_CM, 100.0 * PARSEC_CM])
}

fn case_b() -> f64 {
    Atoms::get().hydrogen.case_b(1e4, 1.0)
}

/// 4π R³ n² α_B / 3 = Q, for a front that is thin: in dense gas. Source: Strömgren 1939, ApJ 89, 526.
#[test]
fn stroemgren() {
    for density in [1e4, 1e5] {
        let truth = (3.0 * Q / (4.0 * PI * density * density * case_b())).cbrt();
        for diffuse in [Diffuse::OnTheSpot, Diffuse::Outward] {
            let front = pure(density, 0.0, diffuse).front_cm(Element::Hydrogen, 0).unwrap();
            println!("{density} {diffuse:?}: {:.5}", front / truth);
            assert!((front / truth - 1.0).abs() < 5e-3, "{density} {diffuse:?}: {}", front / truth);
        }
    }
}

/// Dust takes its part of the light: 3 ∫₀^y y² e^(τ y) dy = 1, y the radius and τ the depth of dust, both in parts of
/// those of the sphere without dust. Source: Petrosian, Silk & Field 1972, ApJ 177, L69.
#[test]
fn dusty() {
    let density = 1e5;
    let without = (3.0 * Q / (4.0 * PI * density * density * case_b())).cbrt();
    for depth in [0.3, 1.0, 3.0] {
        // ∫ y² e^(τ y) = e^(τ y) (y²/τ − 2y/τ² + 2/τ³) − 2/τ³
        let filled =
            |y: f64| 3.0 * ((depth * y).exp() * (y * y / depth - 2.0 * y / depth.powi(2) + 2.0 / depth.powi(3)) - 2.0 / depth.powi(3));
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if filled(middle) < 1.0 { low = middle } else { high = middle }
        }
        let front = pure(density, depth / (density * without), Diffuse::OnTheSpot).front_cm(Element::Hydrogen, 0).unwrap() / without;
        println!("{depth}: {front:.5} {low:.5}");
        assert!((front / low - 1.0).abs() < 1e-2, "{depth}: {front} {low}");
    }
}

/// Photons that hydrogen and helium absorb are as many as recombinations, and Hβ is what case B makes of them.
#[test]
fn recombinations_are_as_many_as_photons() {
    let gas = Gas { isothermal: Some(1e4), ..Gas::new(100.0, [1.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]) };
    let light = IonisingLight::blackbody(40_000.0, Q);
    for diffuse in [Diffuse::OnTheSpot, Diffuse::Outward] {
        let sphere = Sphere::new(gas, &light, diffuse, [0.1 * PARSEC_CM, 100.0 * PARSEC_CM]);
        let atoms = Atoms::get();
        let ions = |state: &GasState, element: Element, charge| state.electrons * state.density(&gas, element, charge);
        // Each recombination to an excited level of helium gives hydrogen most of a photon back.
        let of_hydrogen = sphere.sum(|s| ions(s, Element::Hydrogen, 1) * case_b());
        let of_helium = sphere.sum(|s| {
            let neutral = s.fractions[0][0] / s.fractions[1][0];
            let excited = atoms.helium.to_excited(1e4).map(Lanes::splat);
            let given: f64 = photons_of_helium(excited, Lanes::splat(1e4), Lanes::splat(neutral)).iter().map(|photons| photons[0]).sum();
            ions(s, Element::Helium, 1) * (atoms.helium.case_b(1e4) - given)
        });
        let left: f64 = sphere.left.iter().zip(&light.energies_ev).filter(|(_, e)| **e > 13.6).map(|(photons, _)| photons).sum();
        let balance = (of_hydrogen + of_helium + left) / Q;
        println!("{diffuse:?}: {balance:.5}");
        assert!((balance - 1.0).abs() < 1e-3, "{diffuse:?}: {balance}");
    }
    // Hβ of pure hydrogen: Q α_eff hν / α_B; α_eff = 3.034e-14 cm³/s, α_B = 2.59e-13 at 10⁴ K: Osterbrock & Ferland 2006,
    // tables 2.1 and 4.4.
    let beta = pure(1000.0, 0.0, Diffuse::Outward).line("Ba4-2");
    let truth = Q * 3.034e-14 / 2.59e-13 * 4.0864e-12;
    println!("{:.4}", beta / truth);
    assert!((beta / truth - 1.0).abs() < 1e-2, "{}", beta / truth);
}
