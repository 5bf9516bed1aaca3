//! Writes the tables of the benchmarks into docs/gas.md.

use ionisation::balance::{Accuracy, Diffuse};
use ionisation::benchmarks::BENCHMARKS;

fn main() -> std::io::Result<()> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/gas.md");
    let (begin, end) = ("<!-- benchmarks -->\n", "<!-- end of benchmarks -->");
    let page = std::fs::read_to_string(&path)?;
    let (before, rest) = page.split_once(begin).expect("the page has a place for tables");
    let (_, after) = rest.split_once(end).expect("and its end");
    let mut tables = String::new();
    for benchmark in BENCHMARKS {
        let [outward, spot] =
            [Diffuse::Outward, Diffuse::OnTheSpot].map(|diffuse| benchmark.rows(&benchmark.sphere(diffuse, &Accuracy::REFERENCE)));
        let isotropic = benchmark.rows(&benchmark.isotropic(&Accuracy::REFERENCE));
        tables += &format!(
            "\n**{}**: {} K, Q(H) = {:.3e} s⁻¹\n\n| quantity | median | range | isotropic | outward | on the spot |\n|---|---|---|---|---|---|\n",
            benchmark.name, benchmark.temperature, benchmark.photons
        );
        for ((row, outward), spot) in isotropic.iter().zip(&outward).zip(&spot) {
            let [low, high] = row.range();
            let number = |value: f64| if value > 100.0 { format!("{value:.0}") } else { format!("{:.*}", digits(value), value) };
            let mark = if row.is_within(0.1) { "" } else { " *" };
            let (median, low, high) = (number(row.median()), number(low), number(high));
            let [stated, outward, spot] = [row, outward, spot].map(|row| number(row.found));
            tables += &format!("| {} | {median} | {low} to {high} | {stated}{mark} | {outward} | {spot} |\n", row.quantity);
        }
    }
    std::fs::write(&path, format!("{before}{begin}{tables}\n{end}{after}"))
}

/// Decimals that leave three figures.
fn digits(value: f64) -> usize {
    (2 - value.log10().floor() as i32).clamp(0, 6) as usize
}
