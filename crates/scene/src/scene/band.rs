//! Passbands of a scene: `bands = "SET"`, `bands = ["NAME", ...]`, and `[[band]]` tables.

use spectra::curve::Ordinate;
use spectra::passband::{self, Counting, Passband, Window, window};
use spectra::table::Table;
use spectra::units::Wavelength;

use crate::curve::{self, COLUMN, UNIT};
use crate::data::Inputs;
use crate::error::Result;
use crate::properties::{Key, Kind, Section, build_kind_with};

/// Most characters of a name: those of a text in a FITS header, less those of the suffix of error planes.
const LONGEST_NAME: usize = 60;

/// Makes a band of its name.
pub(super) type Named = Box<dyn FnOnce(&str, Counting) -> spectra::Result<Passband>>;

const CENTRE: Key = Key::required("centre", "wavelength", "its middle");

pub(super) const KINDS: &[Kind<Named>] = &[
    Kind {
        name: "catalogue",
        summary: "an embedded passband",
        keys: &[Key::required("passband", "text", "name in the catalogue `passbands`, such as \"hst-wfc3-f656n\"").of("passbands")],
        build: |section, _| {
            let band = section.wrap("passband", Passband::named(section.need_text("passband")?))?;
            Ok(Box::new(move |name, _| Ok(band.renamed(name))))
        },
    },
    Kind {
        name: "file",
        summary: "from a file of wavelength and throughput",
        keys: &[Key::required("file", "path", "text, ECSV, VOTable or FITS table of wavelength and throughput"), UNIT, COLUMN],
        build: |section, inputs| {
            let file = section.need_text("file")?;
            let curve = curve::read(section, "file", Ordinate::Throughput, inputs)?;
            let checked = section.wrap("file", Passband::new(file, Counting::Energy, curve.table.clone()))?;
            let brightest = checked.largest();
            if brightest > MAX_THROUGHPUT {
                return Err(section.error(
                    "file",
                    format!("{file} reaches a throughput of {brightest:.4}; throughputs must be between 0 and 1 (divide percent by 100)"),
                ));
            }
            // A file that says what its detector counts decides where the scene says nothing.
            let stated = curve.counts_photons.filter(|_| !section.has("counting"));
            let own = stated.map(|photons| if photons { Counting::Photon } else { Counting::Energy });
            Ok(Box::new(move |name, counting| Passband::new(name, own.unwrap_or(counting), curve.table)))
        },
    },
    Kind {
        name: "points",
        summary: "piecewise linear; zero outside",
        keys: &[
            Key::required("nm", "list of numbers", "wavelengths of the points, ascending [nm]"),
            Key::required("throughput", "list of numbers", "throughput at the points, 0 to 1"),
        ],
        build: |section, _| {
            let nm = section.need_numbers("nm", "[400, 500, 600]")?;
            let throughput = section.need_numbers("throughput", "[0, 1, 0]")?;
            if nm.len() != throughput.len() || nm.len() < 2 {
                let message = format!(
                    "{} wavelengths and {} throughputs; a curve needs two or more of each, in equal number",
                    nm.len(),
                    throughput.len()
                );
                return Err(section.error("throughput", message));
            }
            if let Some(wrong) = throughput.iter().find(|t| !(0.0..=1.0).contains(*t)) {
                return Err(section.error("throughput", format!("a throughput of {wrong} is out of range; it must be between 0 and 1")));
            }
            let table = section.wrap("nm", Table::new("points", nm.iter().map(|v| v * 1e-3).collect(), throughput))?;
            Ok(Box::new(move |name, counting| Passband::new(name, counting, table)))
        },
    },
    Kind {
        name: "top_hat",
        summary: "1 within centre +- width/2",
        keys: &[CENTRE, Key::required("width", "wavelength", "its full width")],
        build: |section, _| analytic(Window::TopHat { centre: section.need("centre")?, width: section.need_positive("width")? }),
    },
    Kind {
        name: "gaussian",
        summary: "a Gaussian, truncated at 2.5 FWHM",
        keys: &[CENTRE, Key::required("fwhm", "wavelength", "full width at half maximum")],
        build: |section, _| analytic(Window::Gaussian { centre: section.need("centre")?, fwhm: section.need_positive("fwhm")? }),
    },
    Kind {
        name: "cos2",
        summary: "cos2(pi (lambda - centre)/(2 half_width))",
        keys: &[CENTRE, Key::required("half_width", "wavelength", "distance of its zeros from the centre")],
        build: |section, _| analytic(Window::Cos2 { centre: section.need("centre")?, half_width: section.need_positive("half_width")? }),
    },
    Kind {
        name: "polynomial",
        summary: "sum of c_i lambda^i with lambda in um, clipped at zero",
        keys: &[
            Key::required("coefficients", "list of numbers", "c_0, c_1, ..."),
            Key::required("low", "wavelength", "lower end"),
            Key::required("high", "wavelength", "upper end"),
        ],
        build: |section, _| {
            let coefficients = section.need_numbers("coefficients", "[0, 1]")?;
            analytic(Window::Polynomial { coefficients, low: section.need("low")?, high: section.need::<Wavelength>("high")? })
        },
    },
];

fn analytic(shape: Window) -> Result<Named> {
    Ok(Box::new(move |name, counting| window(name, counting, shape)))
}

/// Relative curves, such as those of the eye, may pass one; percent do not.
const MAX_THROUGHPUT: f64 = 2.0;

/// The keys that every band takes.
pub(super) const KEYS: &[Key] = &[
    Key::required("name", "text", "name in the output"),
    Key::optional(
        "counting",
        "text",
        "energy",
        "detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it",
    ),
];

pub(super) fn build(root: &Section, inputs: &Inputs) -> Result<Vec<Passband>> {
    let own = root.tables("band")?;
    let mut bands = match root.texts("bands")? {
        Some(names) => named(root, &names)?,
        None if own.is_empty() => named(root, &["johnson"])?,
        None => Vec::new(),
    };
    for section in own {
        let make = build_kind_with("passband", KINDS, KEYS, &section, inputs)?;
        let counting = section.wrap("counting", Counting::named(section.choice("counting", &["energy", "photon"])?.unwrap_or("energy")))?;
        let name = section.need_text("name")?;
        if name.chars().count() > LONGEST_NAME {
            let message = format!("the name has {} characters; files support at most {LONGEST_NAME}", name.chars().count());
            return Err(section.error("name", message));
        }
        bands.push(section.wrap("kind", make(name, counting))?);
    }
    Ok(bands)
}

/// The passbands of some names, each that of a set or of a passband.
fn named(root: &Section, names: &[&str]) -> Result<Vec<Passband>> {
    let mut bands = Vec::new();
    for name in names {
        if passband::SETS.iter().any(|s| s.name == *name) {
            bands.extend(root.wrap("bands", passband::set(name))?);
        } else if passband::names().contains(name) {
            bands.push(root.wrap("bands", Passband::named(name))?);
        } else {
            let known: Vec<&str> = passband::SETS.iter().map(|s| s.name).chain(passband::names()).collect();
            return root.wrap("bands", Err(spectra::SpectraError::unknown("passband or set", name, &known)));
        }
    }
    Ok(bands)
}
/// Passbands as a text that is the same for the same ones.
pub(super) fn said(bands: &[Passband]) -> String {
    bands.iter().map(|band| format!("{} {:?} {:e}", band.name(), band.support_um(), band.pivot().0)).collect::<Vec<_>>().join("; ")
}
