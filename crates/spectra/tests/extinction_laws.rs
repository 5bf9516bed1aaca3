//! Our extinction laws against an independent implementation of the same papers.

use spectra::extinction::Extinction;

#[test]
fn laws_agree_with_an_independent_implementation() {
    let text = include_str!("data/extinction_laws.csv");
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let names = [("CCM89", "ccm89"), ("O94", "odonnell94"), ("F99", "fitzpatrick99"), ("G23", "gordon23")];
    let mut compared = 0;
    for line in lines {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        for (column, value) in header.iter().zip(&values).skip(1).filter(|(_, v)| v.is_finite()) {
            let (law, r_v) = column.split_once("_Rv").unwrap();
            let name = names.iter().find(|n| n.0 == law).unwrap().1;
            let ours = Extinction::with_r_v(name, Some(r_v.parse().unwrap())).unwrap();
            let (low, high) = ours.range_um();
            if !(low..=high).contains(&values[0]) {
                continue;
            }
            let k = ours.k(values[0]);
            assert!((k - value).abs() <= 6e-6 * value.abs().max(1.0), "{column} at {} um: {k} {value}", values[0]);
            compared += 1;
        }
    }
    assert!(compared > 5000, "only {compared} values compared");
}
