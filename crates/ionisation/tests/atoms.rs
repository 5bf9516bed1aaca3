//! Atomic data beside printed values.

use ionisation::atoms::{Atoms, Element};
use spectra::nebular::ion_lines;
use spectra::units::{NumberDensity, Temperature};

fn close(name: &str, found: f64, printed: f64, accuracy: f64) {
    assert!((found / printed - 1.0).abs() < accuracy, "{name}: {found:e} {printed:e}");
}

/// Case B of Storey & Hummer 1995, MNRAS 272, 41, at 100 cm⁻³; helium in Osterbrock & Ferland 2006, table 2.4; σ(H⁰) at its threshold, and that of He⁺, which is a fourth of it.
#[test]
fn hydrogen_and_helium() {
    let atoms = Atoms::get();
    for (temperature, case_b) in [(5e3, 4.522e-13), (1e4, 2.585e-13), (2e4, 1.428e-13)] {
        close("case B", atoms.hydrogen.case_b(temperature, 1.0), case_b, 5e-3);
    }
    close("to the ground", atoms.hydrogen.to_ground(1e4, 1.0), 1.58e-13, 5e-3);
    // The fits are of 1999, the table older.
    close("case B of helium", atoms.helium.case_b(1e4), 2.73e-13, 5e-3);
    close("to helium's ground", atoms.helium.to_ground(1e4), 1.59e-13, 4e-2);
    let threshold = |element, charge, energy| atoms.transition(element, charge).light.as_ref().unwrap().at(energy);
    close("H0", threshold(Element::Hydrogen, 0, 13.6), 6.30e-18, 1e-2);
    close("He0", threshold(Element::Helium, 0, 24.59), 7.42e-18, 5e-3);
    close("He+", threshold(Element::Helium, 1, 54.42), 1.576e-18, 1e-2);
    // 1s to 2s, 2p and 3: Scholz & Walters 1991, ApJ 380, 302, whose fit has all levels.
    close("excitation", atoms.hydrogen.excitation(1e4), 3.91e-24, 0.08);
}

/// Rates of charge exchange at 10⁴ K in the ORNL/UGA table of 2001 \[10⁻⁹ cm³ s⁻¹\].
#[test]
fn charge_exchange() {
    for (element, charge, printed) in [
        (Element::Carbon, 3, 3.27),
        (Element::Carbon, 4, 2.18),
        (Element::Nitrogen, 3, 3.33),
        (Element::Oxygen, 3, 4.14),
        (Element::Neon, 3, 5.65),
        (Element::Sulphur, 3, 2.30),
        (Element::Sulphur, 4, 6.50),
    ] {
        let rate = Atoms::get().transition(element, charge - 1).from_hydrogen.as_ref().unwrap();
        close(element.symbol(), 1e9 * rate.at(1e4), printed, 1e-2);
    }
    // Stancil et al. 1999, tables 2 to 4, as the polynomials of Cloudy have them.
    let oxygen = Atoms::get().transition(Element::Oxygen, 0);
    close("O+", oxygen.from_hydrogen.as_ref().unwrap().at(1e4), 2.05e-9, 0.03);
    close("O0", oxygen.to_proton.as_ref().unwrap().at(1e4), 1.65e-9, 0.12);
}

/// Totals at 10⁴ K: C²⁺, N⁺ and O²⁺ by electrons, radiative and dielectronic together: Nussbaumer & Storey 1983, A&A 126, 75
/// and Péquignot et al. 1991, A&A 251, 680, in Osterbrock & Ferland 2006, tables A2.x, agree within the factor by which
/// dielectronic rates were known.
#[test]
fn metals_recombine() {
    for (element, charge, low, high) in [
        (Element::Carbon, 2, 4e-12, 9e-12),
        (Element::Nitrogen, 1, 5e-13, 1.2e-12),
        (Element::Oxygen, 2, 2e-12, 6e-12),
        (Element::Oxygen, 1, 2.5e-13, 5e-13),
    ] {
        let rate = Atoms::get().transition(element, charge - 1).recombination(1e4);
        assert!((low..high).contains(&rate), "{} {charge}: {rate:e}", element.symbol());
    }
    for (element, charge) in Element::METALS.into_iter().flat_map(|element| (0..element.charges()).map(move |charge| (element, charge))) {
        let transition = Atoms::get().transition(element, charge);
        assert!(transition.light.is_some() && transition.radiative.is_some(), "{} {charge}", element.symbol());
    }
}

/// Osterbrock & Ferland 2006: Hβ (table 4.4), \[O III\] of temperature (5.4) and \[S II\] of density (figure 5.8).
#[test]
fn lines() {
    let atoms = Atoms::get();
    let line = |label: &str, temperature: f64, electrons: f64| {
        let table =
            [&atoms.collisional, &atoms.recombination].into_iter().find(|table| table.lines.iter().any(|l| l.label == label)).unwrap();
        let line = table.lines.iter().find(|line| line.label == label).unwrap();
        table.emissivity(line, &table.conditions(temperature, electrons))
    };
    close("Hb", line("Ba4-2", 1e4, 100.0), 1.235e-25, 3e-3);
    for temperature in [8e3, 1e4, 1.2e4f64] {
        let ratio =
            (line("[OIII]5007", temperature, 100.0) + line("[OIII]4959", temperature, 100.0)) / line("[OIII]4363", temperature, 100.0);
        close("[O III]", ratio, 7.90 * (3.29e4 / temperature).exp(), 0.1);
    }
    // In thin gas each excitation gives a photon: 8.629e-6 T^(−1/2) Υ/g e^(−E/kT) E, Υ as the sources of the
    // table have it: Sigut & Pradhan 1995, Saraph & Tully 1994, Tayal 2008, Liang et al. 2009.
    let thin = |strength: f64, weight: f64, um: f64| {
        let energy = 1.986_446e-12 / um;
        8.629e-6 / 100.0 * strength / weight * (-energy / 1.380_649e-12).exp() * energy
    };
    close("Mg II", line("MgII2796", 1e4, 1.0) + line("MgII2803", 1e4, 1.0), thin(16.9, 2.0, 0.2798), 0.01);
    close("[Mg IV]", line("[MgIV]4.488um", 1e4, 1.0), thin(0.358, 4.0, 4.488), 0.01);
    close("[Si II]", line("[SiII]34.81um", 1e4, 1.0), thin(6.09, 2.0, 34.81), 0.02);
    close("Si IV", line("SiIV1394", 1e4, 1.0) + line("SiIV1403", 1e4, 1.0), thin(15.61, 2.0, 0.1397), 0.01);
    let sulphur = |electrons: f64| line("[SII]6716", 1e4, electrons) / line("[SII]6731", 1e4, electrons);
    close("[S II], thin", sulphur(1.0), 1.44, 0.03);
    close("[S II], dense", sulphur(1e6), 0.44, 0.05);
}

/// Between the nodes of the tables: others, of another table, lie there.
#[test]
fn lines_between_nodes() {
    let atoms = Atoms::get();
    for (ion, label, um) in
        [("O3", "[OIII]5007", 0.500_684), ("N2", "[NII]6584", 0.658_345), ("O2", "[OII]3729", 0.372_881), ("H1", "Ba4-2", 0.486_138)]
    {
        let table = if ion == "H1" { &atoms.recombination } else { &atoms.collisional };
        let line = table.lines.iter().find(|line| line.label == label).unwrap();
        for temperature in [11_000.0, 16_000.0, 18_000.0] {
            let found = table.emissivity(line, &table.conditions(temperature, 1000.0));
            let lines = ion_lines(ion, Temperature(temperature), NumberDensity(1000.0)).unwrap();
            let other = lines.lines().iter().find(|line| (line.lambda_um - spectra::air::vacuum_um(um)).abs() < 2e-5).unwrap().strength;
            // W m⁻³ sr⁻¹ of n_e n_ion = 1 cm⁻⁶.
            close(label, found, other * 4.0 * std::f64::consts::PI * 10.0, 6e-3);
        }
    }
    // Two levels are exact in density, so a forbidden doublet is nearly so.
    let sulphur = atoms.collisional.lines.iter().find(|line| line.label == "[SII]6731").unwrap();
    let at = |electrons: f64| atoms.collisional.emissivity(sulphur, &atoms.collisional.conditions(1e4, electrons));
    let (a, b) = (at(1e3), at(1e4));
    assert!((a + b) / 2.0 < at(4e3) && at(4e3) < a, "{a} {} {b}", at(4e3));
}
