//! Nodes of photon energy beside integrals over the spectrum.

use ionisation::atoms::{Atoms, BOLTZMANN_EV, Element};
use ionisation::balance::Photo;
use ionisation::lanes::Lanes;
use ionisation::light::{ABSORBERS, IonisingLight, ion};

/// Γ, and the heat, of an ion behind columns of H⁰, He⁰ and He⁺ \[cm⁻²\], per photon and cm².
fn integrals(temperature: f64, (element, charge): (Element, usize), columns: [f64; 3]) -> [f64; 2] {
    let fit = |(element, charge): (Element, usize)| Atoms::get().transition(element, charge).light.as_ref().unwrap();
    let (fitted, steps, low, high) = (fit((element, charge)), 24_000, 10.36f64, 500.0f64);
    let step = (high / low).ln() / f64::from(steps);
    (0..steps).fold([0.0; 2], |[rate, heat], i| {
        let e = low * ((f64::from(i) + 0.5) * step).exp();
        let depth: f64 = ABSORBERS.into_iter().zip(columns).map(|(absorber, column)| column * fit(absorber).at(e)).sum();
        let photons = e * e / (e / (BOLTZMANN_EV * temperature)).exp_m1() * e * step;
        let taken = photons * fitted.at(e) * (-depth).exp();
        [rate + taken, heat + taken * (e - fitted.threshold_ev)]
    })
}

#[test]
fn rates_are_integrals() {
    // The largest relative errors of a rate, and of the heat, that are allowed.
    let ions = [
        (Element::Hydrogen, 0, 1e-3),
        (Element::Helium, 0, 1e-3),
        (Element::Oxygen, 0, 5e-3),
        (Element::Oxygen, 1, 1e-2),
        (Element::Nitrogen, 1, 2e-3),
        (Element::Sulphur, 1, 6e-2),
        (Element::Sulphur, 2, 2e-3),
        (Element::Neon, 0, 6e-3),
    ];
    for temperature in [20_000.0, 40_000.0, 100_000.0] {
        let light = IonisingLight::new(|e| e * e / (e / (BOLTZMANN_EV * temperature)).exp_m1());
        let mut worst = [[0.0f64; 2]; 8];
        for hydrogen in [0.0, 1e15, 1e16, 1e17, 3e17, 1e18, 3e18] {
            for columns in [0.02, 0.1, 0.5].map(|part| [hydrogen, part * hydrogen, 0.0]) {
                let flux = std::array::from_fn(|node| Lanes::splat(light.photons[node] * (-light.opacity(columns, node)).exp()));
                let photo = Photo::new(&light, &flux);
                for (i, (element, charge, _)) in ions.into_iter().enumerate() {
                    let [rate, heat] = integrals(temperature, (element, charge), columns);
                    let [open, _] = integrals(temperature, (element, charge), [0.0; 3]);
                    // What is left of nearly nothing is not looked at.
                    if rate > 1e-3 * open {
                        let rates = [photo.rates[ion(element, charge)][0], photo.heat[ion(element, charge)][0]];
                        worst[i][0] = worst[i][0].max((rates[0] / rate - 1.0).abs());
                        worst[i][1] = worst[i][1].max((rates[1] / heat - 1.0).abs());
                    }
                }
            }
        }
        for ((element, charge, allowed), [rate, heat]) in ions.into_iter().zip(worst) {
            println!("{temperature} {}{charge}: {rate:.1e} {heat:.1e}", element.symbol());
            assert!(rate < allowed && heat < allowed, "{temperature} {}{charge}: {rate:e} {heat:e}", element.symbol());
        }
    }
}
