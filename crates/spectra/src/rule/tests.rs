//! Rules against the integral itself.

use std::sync::Arc;

use super::*;
use crate::extinction::Extinction;
use crate::passband::Passband;
use crate::quadrature::integrate;
use crate::sed::BlackBody;
use crate::spectrum::{Line, Spectrum};
use crate::units::Temperature;

/// The problem of a band for depths up to 20 and an accuracy of 1e-3.
fn problem<'a>(band: &Passband, sources: &'a [Source], k: &'a (dyn Fn(f64) -> f64 + Sync), settings: &'a Settings) -> BandProblem<'a> {
    let (lambda_um, domain_um) = (band.pivot().0, settings.domain_um.unwrap_or(band.support_um()));
    BandProblem {
        sources,
        domain_um,
        common_um: domain_um,
        pivot: Node { lambda_um, k: k(lambda_um) },
        k,
        depth: 20.0,
        accuracy: 1e-3,
        settings,
        interrupted: &|| false,
    }
}

fn black_bodies() -> Vec<Spectrum> {
    [3000.0, 5000.0, 8000.0, 12000.0, 20000.0, 40000.0].map(|t| Spectrum::continuous(1.0, Arc::new(BlackBody(Temperature(t))))).to_vec()
}

fn sources(band: &Passband, spectra: &[Spectrum], law: &Extinction) -> Vec<Source> {
    spectra.iter().map(|s| Source::new("star", band, s, &**law, |_| 1.0)).collect()
}

fn solve_with(
    name: &str,
    band: &Passband,
    spectra: &[Spectrum],
    law_name: &str,
    accuracy: f64,
    count: Option<usize>,
) -> (BandRule, Vec<Source>) {
    let law = Extinction::by_name(law_name).unwrap();
    let sources = sources(band, spectra, &law);
    let k = |l: f64| law.k(l);
    let settings = Settings { count, ..Settings::default() };
    let problem = BandProblem { accuracy, ..problem(band, &sources, &k, &settings) };
    let solved = (rule(name).unwrap().solve)(&problem).unwrap();
    (solved, sources)
}

/// The measured table of the design (six black bodies, k = 0.55/λ, a up to 20): the order of magnitude of each entry,
/// which was found with other curves of the same bands.
#[test]
fn band_quadrature_converges_as_designed() {
    for (name, errors) in
        [("johnson-B", [2e-2, 1e-3, 6e-5, 2e-6]), ("johnson-V", [8e-3, 8e-5, 5e-7, 1e-8]), ("cousins-R", [1e-2, 2e-4, 1e-6, 1e-8])]
    {
        let band = Passband::by_name(name).unwrap();
        for (n, expected) in errors.iter().enumerate() {
            let (rule, _) = solve_with("band_quadrature", &band, &black_bodies(), "inverse_wavelength", 0.0, Some(n + 1));
            assert!(rule.worst() < 3.0 * expected, "{name} with {} nodes: {:e}, designed {expected:e}", n + 1, rule.worst());
        }
    }
}

/// A closed form holds for one law alone.
fn law_of<'a>(entry: &RuleEntry, other: &'a str) -> &'a str {
    if entry.name == "analytic" { "inverse_wavelength" } else { other }
}

/// Every rule keeps what it certifies against an adaptive integral that shares nothing with it.
#[test]
fn every_certificate_is_honest() {
    for entry in RULES {
        for name in ["johnson-B", "hst-wfc3-f656n", "sdss2010-r"] {
            let band = Passband::by_name(name).unwrap();
            let spectra = black_bodies();
            let law_name = law_of(entry, "gordon23");
            let (rule, _) = solve_with(entry.name, &band, &spectra, law_name, 1e-3, None);
            let law = Extinction::by_name(law_name).unwrap();
            let pieces = band.pieces(&[]);
            for (s, spectrum) in spectra.iter().enumerate() {
                let truth = |a: f64| -> f64 {
                    let f = |l: f64| band.response(l) * spectrum.continuum(l) * (-a * law.k(l)).exp();
                    pieces.windows(2).map(|p| integrate(f, p[0], p[1], 1e-10)).sum()
                };
                for a in [0.0, 0.37, 1.9, 7.3, 19.7] {
                    let error = (rule.evaluate(s, a) - truth(a)).abs() / truth(0.0);
                    assert!(
                        error <= rule.certificates[s].absolute + 1e-9,
                        "{} {name} {a}: {error:e} > {:e}",
                        entry.name,
                        rule.certificates[s].absolute
                    );
                }
            }
        }
    }
}

/// A certificate that could not fail would be worthless: a rule whose weights are off by ten times the accuracy is
/// caught.
#[test]
fn a_wrong_rule_is_caught() {
    let band = Passband::by_name("johnson-V").unwrap();
    let (mut rule, sources) = solve_with("band_quadrature", &band, &black_bodies(), "ccm89", 1e-3, None);
    assert!(rule.worst() <= 1e-3);
    if let Form::Nodes(Nodes { weights, .. }) = &mut rule.form {
        weights[2][0] *= 1.02;
    }
    assert!(rule.certify(&sources, 20.0)[2].absolute > 5e-3);
}

#[test]
fn accuracy_is_kept_over_six_decades() {
    let band = Passband::by_name("johnson-B").unwrap();
    for exponent in 1..=8 {
        let accuracy = 10f64.powi(-exponent);
        let (rule, _) = solve_with("band_quadrature", &band, &black_bodies(), "fitzpatrick99", accuracy, None);
        assert!(rule.worst() <= accuracy, "{accuracy}: {:e}", rule.worst());
    }
}

#[test]
fn weights_are_never_negative() {
    for name in crate::passband::names() {
        let band = Passband::by_name(name).unwrap();
        if band.support_um().1 > 30.0 || band.support_um().0 < 0.0912 {
            continue;
        }
        let (rule, _) = solve_with("band_quadrature", &band, &black_bodies()[2..], "gordon23", 1e-3, None);
        let Form::Nodes(Nodes { weights, .. }) = &rule.form else { panic!("nodes expected") };
        assert!(weights.iter().flatten().all(|w| *w >= 0.0), "{name}");
        assert!(rule.worst() <= 1e-3, "{name}: {:e}", rule.worst());
    }
}

/// A single line is monochromatic: one node, exact.
#[test]
fn a_line_needs_one_node() {
    let band = Passband::by_name("hst-wfc3-f656n").unwrap();
    let line = Spectrum::of_lines(vec![Line { lambda_um: 0.6563, strength: 3.0 }]);
    let (rule, _) = solve_with("band_quadrature", &band, &[line], "ccm89", 1e-12, None);
    let Form::Nodes(Nodes { nodes, .. }) = &rule.form else { panic!("nodes expected") };
    assert_eq!(nodes.len(), 1);
    assert!(rule.worst() < 1e-12);
}

/// A phase-like factor under the integral is kept by the interpolatory weights.
#[test]
fn factors_are_integrated() {
    let band = Passband::by_name("johnson-V").unwrap();
    let (rule, sources) = solve_with("band_quadrature", &band, &black_bodies(), "ccm89", 1e-6, None);
    let factor = |l: f64| 1.0 / (1.0 + 4.0 * l * l);
    let Form::Nodes(Nodes { nodes, .. }) = &rule.form else { panic!("nodes expected") };
    let weights = rule.form.decay().weights_with(3, &sources[3], &factor);
    let value: f64 = nodes.iter().zip(&weights).map(|(n, w)| w * (-2.0 * n.k).exp()).sum();
    let truth = sources[3].measure.reweighted(factor).at(2.0);
    assert!((value / truth - 1.0).abs() < 1e-5, "{value} {truth}");
}

/// The truth's own points against adaptive integration of one function on every piece of its own, in smooth filters and
/// measured ones of hundreds of corners, which cost no more.
#[test]
fn truth_points_converge() {
    let law = Extinction::by_name("fitzpatrick99").unwrap();
    let spectrum = &black_bodies()[3];
    let depths = [0.0, 2.0, 20.0];
    for name in ["johnson-B", "sdss2010-r", "hst-wfc3-f656n", "lsst2023-g"] {
        let band = Passband::by_name(name).unwrap();
        let pieces = band.pieces(&law.breakpoints_um());
        for accuracy in [1e-4, 1e-6] {
            let integrand = |l: f64| depths.map(|a: f64| spectrum.continuum(l) * (-a * law.k(l)).exp()).to_vec();
            let points = truth_points(&band, &law.breakpoints_um(), integrand, accuracy);
            assert!(points.len() <= 60, "{name} {accuracy}: {} of {} corners", points.len(), pieces.len());
            for (i, a) in depths.iter().enumerate() {
                let f = |l: f64| band.response(l) * spectrum.continuum(l) * (-a * law.k(l)).exp();
                let truth: f64 = pieces.windows(2).map(|p| integrate(f, p[0], p[1], 1e-11)).sum();
                let value: f64 = points.iter().map(|(l, w)| w * integrand(*l)[i]).sum();
                assert!((value / truth - 1.0).abs() < accuracy, "{name} {accuracy} {a}: {}", value / truth - 1.0);
            }
        }
    }
}

/// A filter whose response runs over hundreds of nanometres in one straight line, before a cool star: what counts as
/// truth has all of it.
#[test]
fn wide_pieces_are_resolved() {
    let table = crate::table::Table::new("leak", vec![0.22, 0.25, 0.28, 1.1], vec![0.0, 1.0, 1e-3, 1e-5]).unwrap();
    let band = Passband::new("leak", crate::passband::Counting::Photon, table).unwrap();
    let law = Extinction::by_name("odonnell94").unwrap();
    let spectrum = Spectrum::continuous(1.0, Arc::new(BlackBody(Temperature(2500.0))));
    let source = Source::new("star", &band, &spectrum, &*law, |_| 1.0);
    for a in [0.0, 3.0, 30.0] {
        let f = |l: f64| band.response(l) * spectrum.continuum(l) * (-a * law.k(l)).exp();
        let pieces = band.pieces(&law.breakpoints_um());
        let truth: f64 = pieces
            .windows(2)
            .map(|p| {
                (0..64)
                    .map(|i| {
                        let end = |i: usize| p[0] + (p[1] - p[0]) * i as f64 / 64.0;
                        integrate(f, end(i), end(i + 1), 1e-13)
                    })
                    .sum::<f64>()
            })
            .sum();
        assert!((source.measure.at(a) / truth - 1.0).abs() < 1e-8, "{a}: {}", source.measure.at(a) / truth - 1.0);
    }
}

/// Random bands, spectra, laws and depths: the true error, by adaptive integration of W itself, never exceeds the
/// certificate.
#[test]
fn certificates_hold_on_random_scenes() {
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let mut random = |low: f64, high: f64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let laws = ["inverse_wavelength", "ccm89", "odonnell94", "fitzpatrick99", "gordon23", "draine03_rv31"];
    for scene in 0..120 {
        let entry = &RULES[scene % RULES.len()];
        let law_name = law_of(entry, laws[random(0.0, laws.len() as f64) as usize]);
        let law = Extinction::by_name(law_name).unwrap();
        let centre = random(0.35, 1.6);
        let half = centre * random(0.002, 0.35);
        let shape = match scene % 3 {
            0 => crate::passband::Window::Cos2 { centre: crate::units::Wavelength(centre), half_width: crate::units::Wavelength(half) },
            1 => crate::passband::Window::TopHat { centre: crate::units::Wavelength(centre), width: crate::units::Wavelength(half) },
            _ => crate::passband::Window::Gaussian { centre: crate::units::Wavelength(centre), fwhm: crate::units::Wavelength(0.3 * half) },
        };
        let band = crate::passband::window("random", crate::passband::Counting::Photon, shape).unwrap();
        let spectra: Vec<Spectrum> =
            (0..1 + scene % 4).map(|_| Spectrum::continuous(1.0, Arc::new(BlackBody(Temperature(random(2500.0, 45_000.0)))))).collect();
        let sources = sources(&band, &spectra, &law);
        let (depth, accuracy) = (10f64.powf(random(-1.0, 1.8)), 10f64.powf(random(-6.0, -1.5)));
        let k = |l: f64| law.k(l);
        let settings = &Settings::default();
        let problem = BandProblem { depth, accuracy, ..problem(&band, &sources, &k, settings) };
        let solved = (entry.solve)(&problem).unwrap();
        let pieces = band.pieces(&law.breakpoints_um());
        for (s, spectrum) in spectra.iter().enumerate() {
            let truth = |a: f64| -> f64 {
                let f = |l: f64| band.response(l) * spectrum.continuum(l) * (-a * law.k(l)).exp();
                pieces.windows(2).map(|p| integrate(f, p[0], p[1], 1e-12)).sum()
            };
            let total = truth(0.0);
            for _ in 0..12 {
                let a = depth * random(0.0, 1.0).powi(2);
                let error = (solved.evaluate(s, a) - truth(a)).abs() / total;
                let stated = solved.certificates[s].absolute;
                assert!(error <= stated + 1e-10, "{} {law_name} scene {scene} depth {a}: {error:e} > {stated:e}", entry.name);
            }
        }
    }
}

/// A condensed measure has the same F(a), in the light and in the dark, with far fewer points.
#[test]
fn condensed_measures_keep_their_integrals() {
    let n = 5000;
    let k: Vec<f64> = (0..n).map(|i| 0.7 + 0.6 * (i as f64 / n as f64) + 0.01 * (i as f64).sin()).collect();
    let mass: Vec<f64> = (0..n).map(|i| (0.003 * i as f64).sin().powi(2)).collect();
    let measure = super::Measure { lambda_um: k.clone(), k, mass };
    for depth in [0.1, 3.0, 80.0] {
        let condensed = measure.condensed(depth);
        assert!(condensed.k.len() < n / 4, "{}", condensed.k.len());
        for i in 0..=20 {
            let a = depth * i as f64 / 20.0;
            assert!((condensed.at(a) / measure.at(a) - 1.0).abs() < 1e-10, "{a} of {depth}");
        }
    }
    // Past the depth it was made for it may be wrong, and is: the comparison can fail.
    assert!((measure.condensed(0.1).at(300.0) / measure.at(300.0) - 1.0).abs() > 1e-6);
}

/// A draw has the right mean: over many rays the estimate is the integral, and no ray is further off than stated.
#[test]
fn random_wavelengths_have_the_right_mean() {
    let band = Passband::by_name("johnson-B").unwrap();
    let (rule, sources) = solve_with("sampled", &band, &black_bodies(), "ccm89", 1e-3, Some(3));
    let Form::Sampled(sampled) = &rule.form else { panic!("samples expected") };
    const RAYS: usize = 4000;
    for (s, source) in sources.iter().enumerate() {
        for a in [0.0, 2.0, 9.0] {
            let ray = |i: usize| -> f64 {
                let value = |j: usize| {
                    let draw = sampled.draw(j, (i as f64 + 0.5) / RAYS as f64);
                    sampled.ratio[s][draw] * (-a * sampled.k[draw]).exp()
                };
                (0..3).map(value).sum::<f64>() / 3.0
            };
            let truth = source.measure.at(a) / source.measure.total();
            let mean = (0..RAYS).map(ray).sum::<f64>() / RAYS as f64;
            assert!((mean - truth).abs() < 2e-3 * truth.max(0.05), "{s} {a}: {mean} {truth}");
            let worst = (0..RAYS).map(|i| (ray(i) - truth).abs()).fold(0.0, f64::max);
            assert!(worst <= rule.certificates[s].absolute && worst > 0.0, "{worst} {:?}", rule.certificates[s]);
        }
    }
}

/// What a segment holds is its integral, for every form and for any thickness: means are off by no more than the
/// certificate says of single depths.
#[test]
fn means_are_integrals_over_the_span() {
    for (entry, name) in RULES.iter().flat_map(|entry| ["johnson-V", "gaiadr3-G", "hst-wfc3-f656n"].map(|name| (entry, name))) {
        let band = Passband::by_name(name).unwrap();
        let (rule, sources) = solve_with(entry.name, &band, &black_bodies()[1..3], law_of(entry, "fitzpatrick99"), 1e-4, None);
        let Measure { k, mass, .. } = &sources[0].measure;
        let all: f64 = mass.iter().sum();
        let whole = |d: DepthSpan| k.iter().zip(mass).map(|(k, m)| m * mean_transmittance(k * d.from, k * d.to)).sum::<f64>();
        for (from, to) in [(0.5, 0.5), (0.3, 0.8), (2.0, 1.6), (0.0, 1.0), (0.0, 20.0), (12.0, 3.0), (0.0, 1e-4), (19.0, 19.01)] {
            let span = DepthSpan { from, to };
            let error = (rule.mean(0, span) - whole(span)).abs() / all;
            assert!(
                error <= rule.certificates[0].absolute + 1e-9,
                "{} {name} {from} {to}: {error:e} {:?}",
                entry.name,
                rule.certificates[0]
            );
        }
        // One depth in place of a thick span is far off: the comparison can fail.
        assert!(whole(DepthSpan { from: 0.0, to: 20.0 }) - whole(DepthSpan::at(10.0)) > 1e-2 * all);
    }
}

/// Each family falls as it must: exponentials by more than eight for an element, intervals by four for twice as many.
#[test]
fn methods_converge_at_their_order() {
    let band = Passband::by_name("johnson-V").unwrap();
    let worst = |name: &str, count: usize| solve_with(name, &band, &black_bodies(), "inverse_wavelength", 0.0, Some(count)).0.worst();
    for size in 1..4 {
        assert!(worst("projection", size) > 6.0 * worst("projection", size + 1), "{size}");
    }
    for count in [2, 4, 8] {
        let ratio = worst("preintegrated", count) / worst("preintegrated", 2 * count);
        assert!((2.5..6.0).contains(&ratio), "{count}: {ratio}");
    }
    assert!(worst("sampled", 16) < 0.25 * worst("sampled", 2));
}

#[test]
fn what_a_method_cannot_do_is_said() {
    let band = Passband::by_name("johnson-V").unwrap();
    let law = Extinction::by_name("ccm89").unwrap();
    let sources = sources(&band, &black_bodies(), &law);
    let k = |l: f64| law.k(l);
    let pivot = Node { lambda_um: 0.55, k: 1.0 };
    let refuse = |name: &str, settings: Settings| {
        let problem = BandProblem { pivot, ..problem(&band, &sources, &k, &settings) };
        (rule(name).unwrap().solve)(&problem).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refuse("analytic", Settings::default()).contains("inverse_wavelength"));
    assert!(refuse("projection", Settings { count: Some(9), ..Settings::default() }).contains("1 to 8"));
    assert!(refuse("sampled", Settings { count: Some(1000), ..Settings::default() }).contains("256"));
    assert!(refuse("common_nodes", Settings { domain_um: Some((0.5, 0.6)), ..Settings::default() }).contains("domain"));
    // ccm89 means nothing at 0.05 um, where its polynomials pass infinity.
    let nowhere = Settings { domain_um: Some((0.0, 0.0)), ..Settings::default() };
    assert!(refuse("projection", nowhere).contains("domain"));
}
