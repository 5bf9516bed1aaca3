//! The report of a scene's ionised gas: profiles, lines beside benchmarks, maps.

use std::path::Path;

use barnard::control::Control;
use barnard::glam::DVec3;
use barnard::scene::{GasCloud, IonisedGas};
use ionisation::atoms::{Atoms, Element, EmissionLine, HYDROGEN_EV, LineTable};
use ionisation::balance::{Accuracy, Gas, GasState};
use ionisation::benchmarks::{BENCHMARKS, Found, labels};
use ionisation::cloud::{PARSEC_CM, Quantity};
use ionisation::error::IonisationError;
use spectra::constants::ELECTRONVOLT;

use crate::figure::{Axis, Figure, Series};
use crate::maps::{Map, Maps};
use crate::page::table;
use crate::{Result, StudyError};

/// Grams of a nucleus of hydrogen, and of the Sun.
const PROTON_G: f64 = 1.672_621_9e-24;
const SUN_G: f64 = 1.988_41e33;
/// Wavelengths of lines reported in addition to those of benchmarks \[µm\], and their least brightness relative to Hβ \[1\].
const VISIBLE: (f64, f64) = (0.36, 1.1);
const FAINTEST: f64 = 2e-3;
/// Lines that are summed up in one run at most.
const TOGETHER: usize = 24;
/// Shells of a profile.
const SHELLS: usize = 80;
/// Ions of the profiles and the maps.
const IONS: [(Element, usize, &str); 8] = [
    (Element::Hydrogen, 1, "H+"),
    (Element::Helium, 1, "He+"),
    (Element::Oxygen, 1, "O+"),
    (Element::Oxygen, 2, "O2+"),
    (Element::Nitrogen, 1, "N+"),
    (Element::Nitrogen, 2, "N2+"),
    (Element::Sulphur, 1, "S+"),
    (Element::Sulphur, 2, "S2+"),
];

/// Writes `gas.md` into a folder, with figures and maps beside it.
///
/// # Errors
/// If the gas cannot be solved, the user wished to stop, or a file cannot be written.
pub fn write(name: &str, gas: &IonisedGas, folder: &Path, control: &Control) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| barnard::Error::file(folder, format!("the folder cannot be made: {e}")))?;
    let run = CloudRun::new(&gas.cloud, control)?;
    let (profile, warm) = run.profiles();
    let page = run.page(name, gas);
    let put = |name: &str, bytes: &[u8]| barnard_files::formats::replace(&folder.join(name), bytes);
    for figure in [&profile, &warm] {
        put(&format!("{}.csv", figure.name), figure.csv().as_bytes())?;
        put(&format!("{}.svg", figure.name), figure.svg()?.as_bytes())?;
        put(&format!("{}.png", figure.name), &figure.png()?)?;
    }
    put("maps.png", &run.maps(name).png()?)?;
    put("gas.md", page.as_bytes())?;
    Ok(())
}

/// A cloud, and what was found of it.
struct CloudRun<'a> {
    cloud: &'a GasCloud,
    /// Mean position of its stars \[pc\].
    centre: DVec3,
    /// By ion of [`IONS`] its density beside that of its element's nuclei, times that of hydrogen's nuclei; n_p n_e, and that
    /// times T; n_e times He⁺ and H⁺ in parts of their elements.
    ions: Vec<Vec<f32>>,
    pairs: Vec<f32>,
    warm: Vec<f32>,
    /// The power of lines \[erg s⁻¹\].
    lines: Vec<(&'static EmissionLine, f64)>,
}

impl<'a> CloudRun<'a> {
    fn new(cloud: &'a GasCloud, control: &Control) -> Result<Self> {
        let densest = cloud.densest().max(1e-30);
        let most = cloud.electrons() * densest * densest;
        let solved = |quantities: &[Quantity], control: &Control| {
            cloud.ionised(quantities, Accuracy::FAST, None, control).map_err(|error| match error {
                IonisationError::Stopped => StudyError::Render(barnard::Error::Interrupted),
                error => StudyError::Gas(error),
            })
        };
        let tables = [&Atoms::get().recombination, &Atoms::get().collisional];
        let asked = labels();
        let is_told = |line: &EmissionLine| asked.contains(&&*line.label) || (VISIBLE.0..VISIBLE.1).contains(&line.wavelength_um);
        let lines: Vec<(&LineTable, &EmissionLine)> = tables
            .into_iter()
            .flat_map(|table| table.lines.iter().map(move |line| (table, line)))
            .filter(|(_, line)| is_told(line))
            .collect();
        // As many at once as memory holds.
        let together = (1..=TOGETHER).rev().find(|count| cloud.bytes(*count) <= cloud.memory_limit).unwrap_or(1);
        let runs = (1 + lines.len().div_ceil(together)) as f64;
        let fractions: Vec<_> = IONS
            .iter()
            .map(|(element, charge, _)| move |gas: &Gas, state: &GasState| gas.hydrogen * state.fractions[*element as usize][*charge])
            .collect();
        let mut quantities: Vec<Quantity> = fractions.iter().map(|value| Quantity { most: densest, value }).collect();
        let pairs = |gas: &Gas, state: &GasState| state.pairs(gas);
        let warm = |gas: &Gas, state: &GasState| pairs(gas, state) * state.temperature;
        quantities.push(Quantity { most, value: &pairs });
        quantities.push(Quantity { most: 6e4 * most, value: &warm });
        let mut ions = solved(&quantities, &control.part(0.0, 1.0 / runs))?.quantities;
        let [warm, pairs] = std::array::from_fn(|_| ions.pop().unwrap_or_default());
        let volume = (cloud.lattice.voxel_pc() * PARSEC_CM).element_product();
        let mut powers = Vec::new();
        for (run, lines) in lines.chunks(together).enumerate() {
            let functions: Vec<_> =
                lines.iter().map(|(table, line)| move |gas: &Gas, state: &GasState| state.emission(gas, table, line)).collect();
            let quantities: Vec<Quantity> =
                lines.iter().zip(&functions).map(|((table, line), value)| Quantity { most: cloud.most(table, line), value }).collect();
            let share = |run: usize| (1 + run) as f64 / runs;
            let found = solved(&quantities, &control.part(share(run), share(run + 1)))?;
            let power = |values: &Vec<f32>| volume * values.iter().map(|v| f64::from(*v)).sum::<f64>();
            powers.extend(lines.iter().zip(&found.quantities).map(|((_, line), values)| (*line, power(values))));
        }
        let photons = |star: &barnard::scene::IonisingStar| star.light.ionising();
        let all: f64 = cloud.stars.iter().map(photons).sum();
        let centre = cloud.stars.iter().map(|star| star.position * photons(star)).sum::<DVec3>() / all.max(f64::MIN_POSITIVE);
        Ok(Self { cloud, centre, ions, pairs, warm, lines: powers })
    }

    /// The power of a line by its label \[erg s⁻¹\].
    fn line(&self, label: &str) -> f64 {
        self.lines.iter().filter(|(line, _)| line.label == label).map(|(_, power)| power).sum()
    }

    /// The middle of a voxel \[pc\].
    fn place(&self, i: usize) -> DVec3 {
        let [nx, ny, _] = self.cloud.lattice.dims;
        let voxel = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
        self.cloud.lattice.bounds.low + (voxel + 0.5) * self.cloud.lattice.voxel_pc()
    }

    /// Means over shells around the centre: where they are \[pc\], and of each of some values Σ value/Σ weight.
    fn shells(&self, weight: &[f32], values: &[&[f32]]) -> Vec<(f64, Vec<f64>)> {
        let radius = |i: usize| (self.place(i) - self.centre).length();
        let filled = || (0..weight.len()).filter(|i| weight[*i] > 0.0);
        let (near, far) = filled().map(radius).fold((f64::INFINITY, 0.0f64), |(near, far), r| (near.min(r), far.max(r)));
        let width = ((far - near) / SHELLS as f64).max(self.cloud.lattice.voxel_pc().min_element());
        let mut sums = vec![(0.0, 0.0, vec![0.0; values.len()]); SHELLS + 1];
        for i in filled() {
            let (place, all, sums_here) = &mut sums[(((radius(i) - near) / width) as usize).min(SHELLS)];
            (*place, *all) = (*place + radius(i) * f64::from(weight[i]), *all + f64::from(weight[i]));
            sums_here.iter_mut().zip(values).for_each(|(sum, values)| *sum += f64::from(values[i]));
        }
        let filled = sums.into_iter().filter(|(_, all, _)| *all > 0.0);
        filled.map(|(place, all, sums_of)| (place / all, sums_of.into_iter().map(|sum| sum / all).collect())).collect()
    }

    /// Parts of elements, and temperatures, over the distance from the centre.
    fn profiles(&self) -> (Figure, Figure) {
        let ions: Vec<&[f32]> = self.ions.iter().map(Vec::as_slice).collect();
        let shells = self.shells(&self.cloud.hydrogen, &ions);
        let series = |(number, (_, _, name)): (usize, &(Element, usize, &str))| Series {
            name: (*name).to_owned(),
            points: shells.iter().map(|(radius, parts)| (*radius, parts[number])).collect(),
        };
        let parts = Figure {
            name: "ions".into(),
            title: "Ions in parts of their element's nuclei, means over shells".into(),
            x: Axis::linear("distance from the stars [pc]"),
            y: Axis::linear("part [1]"),
            series: IONS.iter().enumerate().map(series).collect(),
        };
        let warm = self.shells(&self.pairs, &[&self.warm]);
        let temperature = Figure {
            name: "temperature".into(),
            title: "Temperature of electrons, weighted by n_p n_e, means over shells".into(),
            x: Axis::linear("distance from the stars [pc]"),
            y: Axis::linear("T [K]"),
            series: vec![Series { name: "T".into(), points: warm.iter().map(|(radius, t)| (*radius, t[0])).collect() }],
        };
        (parts, temperature)
    }

    /// Planes through the centre.
    fn maps(&self, name: &str) -> Maps {
        let [nx, ny, nz] = self.cloud.lattice.dims;
        let (low, voxel, high) = (self.cloud.lattice.bounds.low, self.cloud.lattice.voxel_pc(), self.cloud.lattice.bounds.high);
        let layer = (((self.centre - low) / voxel).z.max(0.0) as usize).min(nz - 1);
        let plane = |value: &dyn Fn(usize) -> f64| (0..nx * ny).map(|i| value(layer * nx * ny + i)).collect::<Vec<f64>>();
        let map = |title: String, values: Vec<f64>, range: (f64, f64)| Map {
            title,
            size: (nx, ny),
            across: (low.x, high.x),
            upwards: (low.y, high.y),
            values,
            range,
        };
        let part = |number: usize| {
            let fraction = |i: usize| f64::from(self.ions[number][i]) / f64::from(self.cloud.hydrogen[i]);
            map(format!("{} in parts of {}", IONS[number].2, IONS[number].0.symbol()), plane(&fraction), (0.0, 1.0))
        };
        let density = plane(&|i| f64::from(self.cloud.hydrogen[i]).log10());
        let ends = |values: &[f64]| {
            let known = values.iter().filter(|v| v.is_finite());
            known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
        };
        let dense = ends(&density);
        // Four powers of ten tell more than the emptiest voxel.
        let dense = if dense.0 <= dense.1 { (dense.0.max(dense.1 - 4.0).min(dense.1 - 0.5), dense.1) } else { (0.0, 1.0) };
        let warm = plane(&|i| f64::from(self.warm[i]) / f64::from(self.pairs[i]));
        let hot = ends(&warm);
        let hot = if hot.0 < hot.1 { (hot.0.max(4000.0).min(hot.1 - 1.0), hot.1) } else { (0.0, 1e4) };
        let mut maps = vec![map("log n_H [cm-3]".into(), density, dense), map("T [K]".into(), warm, hot)];
        maps.extend([0, 3, 2, 6].map(part));
        Maps { name: "maps".into(), title: format!("{name}: the plane z = {:.2} pc", low.z + (layer as f64 + 0.5) * voxel.z), maps }
    }

    /// The page.
    fn page(&self, name: &str, gas: &IonisedGas) -> String {
        let volume = (self.cloud.lattice.voxel_pc() * PARSEC_CM).element_product();
        let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
        let [nx, ny, nz] = self.cloud.lattice.dims;
        let ionised = volume * sum(&self.ions[0]);
        let helium = self.weighted(1) / self.weighted(0).max(f64::MIN_POSITIVE);
        let shells = self.shells(&self.cloud.hydrogen, &[&self.ions[0]]);
        let front = shells.windows(2).rev().find(|pair| pair[0].1[0] >= 0.5 && pair[1].1[0] < 0.5).map(|pair| {
            let [(inner, a), (outer, b)] = [(pair[0].0, pair[0].1[0]), (pair[1].0, pair[1].1[0])];
            inner + (a - 0.5) / (a - b) * (outer - inner)
        });
        let beta = self.line("Ba4-2");
        let mut text = format!("# Ionised gas of {name}\n\nWritten by `barnard gas`, version {}.\n\n", env!("CARGO_PKG_VERSION"));
        text += &format!("{nx} x {ny} x {nz} voxels of {:.4} pc.", self.cloud.lattice.voxel_pc().min_element());
        gas.notes().iter().for_each(|note| text += &format!(" {}.", capital(note)));
        text += "\n\n## Stars\n\n";
        text += &self.stars(gas);
        text += "## The whole\n\n";
        let known = |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
        text += &table(
            &["quantity", "value"],
            &[
                vec!["ionised hydrogen".into(), format!("{:.4e} Msun", ionised * PROTON_G / SUN_G)],
                vec!["temperature, weighted by n_p n_e".into(), format!("{} K", known(gas.temperature, 0))],
                vec!["density of electrons, weighted by n_p n_e".into(), format!("{} cm-3", known(gas.electrons, 1))],
                vec!["He+/H+, each in parts of its element".into(), format!("{helium:.3}")],
                vec!["half of the hydrogen is neutral, mean over directions, at".into(), format!("{} pc", known(front, 3))],
                vec!["L(Hb)".into(), format!("{beta:.4e} erg s-1")],
            ],
        );
        text += "![Ions](ions.svg)\n\n![Temperature](temperature.svg)\n\n![Maps](maps.png)\n\n## Lines\n\nPower in all directions, before any dust. Those above ";
        text += &self.lines(beta);
        text += &self.beside_benchmarks(helium, front, gas.temperature);
        text
    }

    /// Table of the stars.
    fn stars(&self, gas: &IonisedGas) -> String {
        let stars: Vec<Vec<String>> = self
            .cloud
            .stars
            .iter()
            .zip(&gas.escaped)
            .map(|(star, escaped)| {
                let [x, y, z] = star.position.to_array();
                let photons = star.light.ionising();
                let mean = star
                    .light
                    .photons
                    .iter()
                    .zip(&star.light.energies_ev)
                    .filter(|(_, e)| **e > HYDROGEN_EV)
                    .map(|(p, e)| p * e)
                    .sum::<f64>()
                    / photons;
                vec![
                    star.name.clone(),
                    format!("{x:.3}, {y:.3}, {z:.3}"),
                    format!("{photons:.3e}"),
                    format!("{mean:.2}"),
                    format!("{:.3e}", 1e7 * photons * mean * ELECTRONVOLT),
                    format!("{:.1} %", 100.0 * escaped),
                ]
            })
            .collect();
        table(
            &["star", "place [pc]", "photons above 13.6 eV [s-1]", "their mean [eV]", "power in them [erg s-1]", "leave the cloud"],
            &stars,
        )
    }

    /// Table of the lines, beside Hβ of a power \[erg s⁻¹\].
    fn lines(&self, beta: f64) -> String {
        let asked = labels();
        let mut text = format!("{FAINTEST} of Hb between {} and {} um, and those that benchmarks ask for.\n\n", VISIBLE.0, VISIBLE.1);
        let is_told = |(line, power): &&(&EmissionLine, f64)| *power > FAINTEST * beta || *power > 0.0 && asked.contains(&&*line.label);
        let mut lines: Vec<&(&EmissionLine, f64)> = self.lines.iter().filter(is_told).collect();
        lines.sort_by(|a, b| a.0.wavelength_um.total_cmp(&b.0.wavelength_um));
        let line = |(line, power): &&(&EmissionLine, f64)| {
            vec![line.label.clone(), format!("{:.4}", line.wavelength_um), format!("{power:.3e}"), format!("{:.4}", power / beta)]
        };
        text += &table(&["line", "wavelength [um]", "power [erg s-1]", "beside Hb"], &lines.iter().map(line).collect::<Vec<_>>());
        text
    }

    /// Σ over voxels of n_e times the part of an element that is one of [`IONS`], as far as voxels' means tell it.
    fn weighted(&self, number: usize) -> f64 {
        let weighted = |i: usize| f64::from(self.ions[number][i]) * f64::from(self.pairs[i]) / f64::from(self.ions[0][i]);
        (0..self.pairs.len()).filter(|i| self.ions[0][*i] > 0.0).map(weighted).sum()
    }

    /// The tables of the benchmarks, with what this gas has.
    fn beside_benchmarks(&self, helium: f64, front: Option<f64>, temperature: Option<f64>) -> String {
        let inner = self.shells(&self.pairs, &[&self.warm]).first().map_or(f64::NAN, |(_, warm)| warm[0]);
        let found = Found {
            line: &|label| self.line(label),
            radius_cm: front.map_or(f64::NAN, |front| front * PARSEC_CM),
            helium,
            temperature: temperature.unwrap_or(f64::NAN),
            inner_temperature: inner,
        };
        let mut text = "## Beside the benchmarks\n\nUniform spheres around black bodies, as eight or nine codes have them (Wood, Mathis & Ercolano 2004, MNRAS 348, 1337; Ferland et al. 1995); lines in parts of Hb.\n\n".to_owned();
        for benchmark in BENCHMARKS {
            let number = |value: f64| {
                if value.is_nan() {
                    "-".into()
                } else if value > 100.0 {
                    format!("{value:.0}")
                } else {
                    format!("{value:.4}")
                }
            };
            let rows: Vec<Vec<String>> = benchmark
                .rows_of(&found)
                .iter()
                .map(|row| {
                    let [low, high] = row.range();
                    vec![row.quantity.to_owned(), number(row.found), number(row.median()), format!("{} to {}", number(low), number(high))]
                })
                .collect();
            text += &format!(
                "{}: {:.0} K, {:.2e} photons above 13.6 eV a second, {:.0} cm-3\n\n",
                benchmark.name, benchmark.temperature, benchmark.photons, benchmark.gas.hydrogen
            );
            text += &table(&["quantity", "this gas", "median", "range"], &rows);
        }
        text
    }
}

/// A sentence with a capital letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use barnard::memory::DEFAULT_LIMIT;
    use barnard::scene::Scene;

    use super::*;

    fn scene(star: &str, gas: &str) -> Scene {
        let text = format!(
            r#"bands = ["hst-wfc3-f656n"]
[camera]
kind = "perspective"
position = "0 0 30 pc"
field_of_view = "25 deg"
size = [8, 8]
[field.ball]
kind = "sphere"
radius = "2 pc"
[gas]
density = "{gas} * ball"
voxels = 20
abundances = "hii40"
[[star]]
kind = "blackbody"
position = "{star} pc"
temperature = "40000 K"
luminosity = "1e4 Lsun"
"#
        );
        barnard_files::parse("gas.toml", "gas", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
    }

    /// The report holds what the gas has: photons as many as the star sends, lines in their ratios, figures with numbers.
    #[test]
    fn reports_are_written() {
        let scene = scene("0 0 0", "300");
        let gas = scene.ionised().unwrap();
        let folder = tempfile::tempdir().unwrap();
        write("a ball", gas, folder.path(), &Control::default()).unwrap();
        let page = std::fs::read_to_string(folder.path().join("gas.md")).unwrap();
        let cells = |row: &str| -> Vec<f64> {
            let line = page.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("{row}: {page}"));
            line.split('|').filter_map(|cell| cell.split_whitespace().next()?.parse().ok()).collect()
        };
        // L(Hb) = Q α_eff hν/α_B, 4.79e-13 erg for a photon that ionises hydrogen: Osterbrock & Ferland 2006, tables 2.1 and 4.4.
        // Helium's photons, and the temperature, change that by some hundredths.
        let photons = gas.cloud.stars[0].light.ionising();
        let beta = cells("| L(Hb) |")[0];
        assert!((beta / (4.79e-13 * photons) - 1.0).abs() < 0.06, "{beta:e} {photons:e}");
        // [O III] 5007 beside 4959 is 2.98 by their transition probabilities: Storey & Zeippen 2000, MNRAS 312, 813.
        let ratio = cells("| [OIII]5007 |")[2] / cells("| [OIII]4959 |")[2];
        assert!((ratio / 2.98 - 1.0).abs() < 0.02, "{ratio}");
        assert!(page.contains("## Beside the benchmarks") && cells("| [O II] 3726+3729 |").len() >= 3);
        let profile = std::fs::read_to_string(folder.path().join("ions.csv")).unwrap();
        let inner: Vec<f64> =
            profile.lines().filter(|line| line.starts_with("\"H+\"")).filter_map(|line| line.rsplit(',').next()?.parse().ok()).collect();
        assert!(inner.len() > 5 && inner[0] > 0.99 && *inner.last().unwrap() < 0.1, "{inner:?}");
        let maps = std::fs::read(folder.path().join("maps.png")).unwrap();
        let info = png::Decoder::new(std::io::Cursor::new(&maps)).read_info().unwrap().info().size();
        assert!(info.0 == 3 * 430 && info.1 > 600, "{info:?}");
    }

    /// No gas, dense gas beside the star, and a star far away: reports have numbers, and no more light than the star can ionise.
    #[test]
    fn reports_of_nothing_are_written() {
        for (star, gas) in [("0 0 0", "0"), ("0 0 2.9", "1e5"), ("0 40 0", "10")] {
            let scene = scene(star, gas);
            let gas_of_scene = scene.ionised().unwrap();
            let folder = tempfile::tempdir().unwrap();
            write("nothing", gas_of_scene, folder.path(), &Control::default()).unwrap();
            let page = std::fs::read_to_string(folder.path().join("gas.md")).unwrap();
            let words = page.split(|c: char| !c.is_alphanumeric());
            assert_eq!(words.filter(|word| ["NaN", "inf"].contains(word)).count(), 0, "{star} {gas}: {page}");
            let beta = page.lines().find_map(|line| line.strip_prefix("| L(Hb) |")?.split_whitespace().next()?.parse::<f64>().ok());
            let most = 4.79e-13 * gas_of_scene.cloud.stars[0].light.ionising();
            assert!(beta.is_some_and(|beta| (0.0..0.6 * most).contains(&beta) && (beta > 0.0) == (gas != "0")), "{star} {gas}: {beta:?}");
            assert!(folder.path().join("maps.png").exists(), "{star} {gas}");
        }
        let control = Control::default();
        control.interrupt();
        let stopped = write("stopped", scene("0 0 0", "300").ionised().unwrap(), tempfile::tempdir().unwrap().path(), &control);
        assert!(matches!(stopped, Err(StudyError::Render(barnard::Error::Interrupted))));
    }
}
