//! The benchmarks of Lexington, beside nine codes. The atomic data of today are thirty years newer than theirs; where that
//! leads outside, the test says so.

use ionisation::atoms::Element;
use ionisation::balance::{Accuracy, Diffuse};
use ionisation::benchmarks::{BENCHMARKS, BenchmarkRow};

/// Tolerance of a line beyond the range of the published codes \[1\].
const WIDER: f64 = 0.1;

/// The lines that lie outside; everything else is asked to be within the codes' own range, Hβ within 3 % of their median.
fn outside(rows: &[BenchmarkRow], temperature: f64) -> Vec<&'static str> {
    let mut outside = Vec::new();
    for row in rows {
        let [low, high] = row.range();
        println!("{:24} {:.4} {low} to {high}", row.quantity, row.found);
        match row.quantity.split(' ').next() {
            Some("L(Hb)") => assert!((row.found / row.median() - 1.0).abs() < 0.03, "{row:?}"),
            Some("T") if row.quantity.contains("n_e") => assert!(row.is_within(temperature), "{row:?}"),
            Some("T" | "R" | "<He+>/<H+>") => assert!(row.is_within(0.0), "{row:?}"),
            _ if row.is_within(WIDER) => {}
            _ => outside.push(row.quantity),
        }
    }
    outside
}

#[test]
fn hii40() {
    let sphere = BENCHMARKS[0].sphere(Diffuse::Outward, &Accuracy::REFERENCE);
    let rows = BENCHMARKS[0].rows(&sphere);
    assert_eq!(rows.len(), 25);
    // Cloudy 25 has 0.997 for [S III]: its collision strengths, and the recombination of S³⁺ and S²⁺, are as new as ours.
    assert_eq!(outside(&rows, 0.0), ["[S III] 9532+9069"]);
    // Cloudy 25 has the front of helium at 4.309 pc.
    let helium = sphere.front_cm(Element::Helium, 0).unwrap() / 3.085_677_581e18;
    assert!((helium / 4.309 - 1.0).abs() < 0.01, "{helium}");
}

#[test]
fn hii20() {
    let sphere = BENCHMARKS[1].sphere(Diffuse::Outward, &Accuracy::REFERENCE);
    let rows = BENCHMARKS[1].rows(&sphere);
    assert_eq!(rows.len(), 21);
    // Cloudy 25 has 6910 K, and all of these outside of what the nine found as well, by data that are as new as ours: C II]
    // 0.0756, [O II] 0.0113 and 1.401, [S III] 0.209 and 0.293. By the recombination rates of today S²⁺, which cools, is
    // rarer, and its infrared lines are fainter by the collision strengths of today.
    let warm = ["C II] 2325+", "[O II] 7320+7330", "[O II] 3726+3729"];
    assert_eq!(outside(&rows, 0.03), [&warm[..], &["[S III] 18.7 um", "[S III] 9532+9069"]].concat());
}

/// The planetary nebulae, whose own light goes in all directions, as that of the codes does: power, temperatures, size and
/// helium are within what eight codes found. Lines lie outside whose data are newer: dielectronic recombination of N²⁺
/// (0.65e-12 cm³ s⁻¹ at 10⁴ K for 2.0e-12 of Nussbaumer & Storey 1983), of O²⁺ (0.94 for 1.66), and of S²⁺ and S³⁺, of which
/// nothing was known; and collision strengths, step by step in docs/gas.md.
#[test]
fn planetary_nebulae() {
    for (benchmark, lines) in [
        (BENCHMARKS[2], &["[N II] 6584+6548", "[O II] 3726+3729", "[Ne III] 15.5 um", "[Ne III] 3869+3968"][..]),
        (BENCHMARKS[3], &["[S II] 6716+6731"]),
    ] {
        let rows = benchmark.rows(&benchmark.isotropic(&Accuracy::REFERENCE));
        let is_line = |row: &&BenchmarkRow| !["L(Hb)", "T", "R", "<He+>/<H+>"].contains(&row.quantity.split(' ').next().unwrap());
        for row in &rows {
            println!("{} {:24} {:.4} {:?}", benchmark.name, row.quantity, row.found, row.range());
            assert!(is_line(&row) || row.is_within(0.0), "{row:?}");
        }
        let outside: Vec<&str> = rows.iter().filter(is_line).filter(|row| !row.is_within(WIDER)).map(|row| row.quantity).collect();
        assert_eq!(outside, lines, "{}", benchmark.name);
    }
}

/// PN75 ends before its front, so that a good part leaves of the light that hydrogen makes by recombining to its ground level:
/// 0.26; of a uniform sphere with the mean of its opacity, whose depth is 2.4, it is 0.29. A twelfth of it left while detours
/// were taken as six times as long.
#[test]
fn own_light_leaves_a_cloud_that_ends_before_its_front() {
    let benchmark = BENCHMARKS[2];
    let part = |sphere: &ionisation::sphere::Sphere| {
        let made: f64 = sphere.shells.iter().map(|shell| shell.volume(4.0 * std::f64::consts::PI) * shell.emitted[0]).sum();
        sphere.left[0] / made
    };
    let [isotropic, outward] =
        [benchmark.isotropic(&Accuracy::REFERENCE), benchmark.sphere(Diffuse::Outward, &Accuracy::REFERENCE)].map(|s| part(&s));
    println!("{isotropic} {outward}");
    assert!((0.22..0.32).contains(&isotropic), "{isotropic}");
    assert!((outward / isotropic - 1.0).abs() < 0.15, "{outward} {isotropic}");
}

/// Light that beams carry outward makes of a cloud what light in all directions does.
#[test]
fn outward_is_beside_isotropic() {
    for (benchmark, wider) in [(BENCHMARKS[0], 0.03), (BENCHMARKS[2], 0.08)] {
        let rows = |sphere| benchmark.rows(&sphere);
        let [truth, found] =
            [rows(benchmark.isotropic(&Accuracy::REFERENCE)), rows(benchmark.sphere(Diffuse::Outward, &Accuracy::REFERENCE))];
        for (value, truth) in found.iter().zip(&truth) {
            println!("{} {:24} {:+.1} %", benchmark.name, value.quantity, 100.0 * (value.found / truth.found - 1.0));
            let most = match value.quantity {
                quantity if quantity.starts_with("L(Hb)") || quantity.contains("n_e") => 0.01,
                "[N II] 6584+6548" | "[O II] 3726+3729" | "[O III] 5007+4959" | "[S III] 9532+9069" => wider,
                _ => continue,
            };
            assert!((value.found / truth.found - 1.0).abs() < most, "{value:?} {truth:?}");
        }
    }
}

/// Solver of three-dimensional clouds, compared with the reference.
#[test]
fn fast_is_the_reference() {
    let [truth, found] = [Accuracy::REFERENCE, Accuracy::FAST].map(|accuracy| {
        let sphere = BENCHMARKS[0].sphere(Diffuse::Outward, &accuracy);
        let lines = ["[OIII]5007", "[NII]6584", "[OII]3726", "[SII]6716", "[SIII]9531"].map(|label| sphere.line(label));
        let front = sphere.front_cm(Element::Hydrogen, 0).unwrap();
        (sphere.shells.len(), [&[sphere.temperature(), sphere.helium(), front], &lines[..]].concat())
    });
    assert!(found.0 < truth.0 / 4);
    println!("{:?}", found.1.iter().zip(&truth.1).map(|(a, b)| 100.0 * (a / b - 1.0)).collect::<Vec<_>>());
    for (value, truth) in found.1.iter().zip(&truth.1) {
        assert!((value / truth - 1.0).abs() < 5e-3, "{value:e} {truth:e}");
    }
}
