//! Passbands of a scene: `bands = "SET"`, `bands = ["NAME", ...]`, and `[[band]]` tables.

use spectra::curve::Ordinate;
use spectra::passband::{self, Counting, Passband, Window, window};
use spectra::table::Table;
use spectra::units::Wavelength;

use crate::curve::{self, COLUMN, UNIT};
use crate::data::Inputs;
use crate::error::Result;
use crate::properties::{
    Choice, Choices, Key, KeyRow, Kind, Numbers, OrDefault, Part, Path, Required, Section, Text, Texts, build_kind_with,
};

/// Most characters of a name: those of a text in a FITS header, less those of the suffix of error planes.
const LONGEST_NAME: usize = 60;

/// Makes a band of its name.
pub(super) type BandMaker = Box<dyn FnOnce(&str, Counting) -> spectra::Result<Passband>>;

const CENTRE: Key<Wavelength, Required> = Key::quantity::<Wavelength>("centre", "its middle").required();

const PASSBAND: Key<Text, Required> =
    Key::text("passband", "name in the catalogue `passbands`, such as \"hst-wfc3-f656n\"").required().of("passbands");
const FILE: Key<Path, Required> = Key::path("file", "text, ECSV, VOTable or FITS table of wavelength and throughput").required();
const NM: Key<Numbers, Required> = Key::numbers("nm", "wavelengths of the points, ascending [nm]").example("[500, 600]").required();
const THROUGHPUT: Key<Numbers, Required> =
    Key::numbers("throughput", "throughput at the points").range(0.0..=1.0).example("[0, 1]").required();
const WIDTH: Key<Wavelength, Required> = Key::quantity::<Wavelength>("width", "its full width").positive().example("\"50 nm\"").required();
const FWHM: Key<Wavelength, Required> =
    Key::quantity::<Wavelength>("fwhm", "full width at half maximum").positive().example("\"50 nm\"").required();
const HALF_WIDTH: Key<Wavelength, Required> =
    Key::quantity::<Wavelength>("half_width", "distance of its zeros from the centre").positive().example("\"50 nm\"").required();
const COEFFICIENTS: Key<Numbers, Required> = Key::numbers("coefficients", "c_0, c_1, ...").required();
const LOW: Key<Wavelength, Required> = Key::quantity::<Wavelength>("low", "lower end").example("\"400 nm\"").required();
const HIGH: Key<Wavelength, Required> = Key::quantity::<Wavelength>("high", "upper end").example("\"700 nm\"").required();
const NAME: Key<Text, Required> = Key::text("name", "name in the output").required();
const COUNTING: Key<Choice<Counting>, OrDefault> =
    Key::choice("counting", "detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it")
        .default("energy");

pub(super) const KINDS: &[Kind<BandMaker>] = &[
    Kind {
        name: "catalogue",
        summary: "an embedded passband",
        keys: &[PASSBAND.row],
        build: |section, _| {
            let band = section.wrap(&PASSBAND, Passband::by_name(section.read(&PASSBAND)?))?;
            Ok(Box::new(move |name, _| Ok(band.with_name(name))))
        },
    },
    Kind {
        name: "file",
        summary: "from a file of wavelength and throughput",
        keys: &[FILE.row, UNIT.row, COLUMN.row],
        build: |section, inputs| {
            let file = section.read(&FILE)?;
            let curve = curve::read(section, &FILE, Ordinate::Throughput, inputs)?;
            let checked = section.wrap(&FILE, Passband::new(file, Counting::Energy, curve.table.clone()))?;
            let brightest = checked.largest();
            if brightest > MAX_THROUGHPUT {
                return Err(section.error(
                    "file",
                    format!("{file} reaches a throughput of {brightest:.4}; throughputs must be between 0 and 1 (divide percent by 100)"),
                ));
            }
            // A file that says what its detector counts decides where the scene says nothing.
            let stated = curve.counts_photons.filter(|_| !section.has(&COUNTING));
            let stated_counting = stated.map(|photons| if photons { Counting::Photon } else { Counting::Energy });
            Ok(Box::new(move |name, counting| Passband::new(name, stated_counting.unwrap_or(counting), curve.table)))
        },
    },
    Kind {
        name: "points",
        summary: "piecewise linear; zero outside",
        keys: &[NM.row, THROUGHPUT.row],
        build: |section, _| {
            let nm = section.read(&NM)?;
            let throughput = section.read(&THROUGHPUT)?;
            if nm.len() != throughput.len() || nm.len() < 2 {
                let message = format!(
                    "{} wavelengths and {} throughputs; a curve needs two or more of each, in equal number",
                    nm.len(),
                    throughput.len()
                );
                return Err(section.error(&THROUGHPUT, message));
            }
            let table = section.wrap(&NM, Table::new("points", nm.iter().map(|v| v * 1e-3).collect(), throughput))?;
            Ok(Box::new(move |name, counting| Passband::new(name, counting, table)))
        },
    },
    Kind {
        name: "top_hat",
        summary: "1 within centre +- width/2",
        keys: &[CENTRE.row, WIDTH.row],
        build: |section, _| analytic(Window::TopHat { centre: section.read(&CENTRE)?, width: section.read(&WIDTH)? }),
    },
    Kind {
        name: "gaussian",
        summary: "a Gaussian, truncated at 2.5 FWHM",
        keys: &[CENTRE.row, FWHM.row],
        build: |section, _| analytic(Window::Gaussian { centre: section.read(&CENTRE)?, fwhm: section.read(&FWHM)? }),
    },
    Kind {
        name: "cos2",
        summary: "cos2(pi (lambda - centre)/(2 half_width))",
        keys: &[CENTRE.row, HALF_WIDTH.row],
        build: |section, _| analytic(Window::Cos2 { centre: section.read(&CENTRE)?, half_width: section.read(&HALF_WIDTH)? }),
    },
    Kind {
        name: "polynomial",
        summary: "sum of c_i lambda^i with lambda in um, clipped at zero",
        keys: &[COEFFICIENTS.row, LOW.row, HIGH.row],
        build: |section, _| {
            let coefficients = section.read(&COEFFICIENTS)?;
            analytic(Window::Polynomial { coefficients, low: section.read(&LOW)?, high: section.read(&HIGH)? })
        },
    },
];

/// Passband sets and embedded passbands of a scene.
pub(super) const BANDS: Key<Texts> = Key::texts("bands", "a set of passbands, or a list of embedded ones")
    .otherwise("johnson")
    .of("passband-sets")
    .example("\"johnson\"")
    .affects(&[Part::Spectra, Part::Display]);

fn analytic(shape: Window) -> Result<BandMaker> {
    Ok(Box::new(move |name, counting| window(name, counting, shape)))
}

/// Relative curves, such as those of the eye, may pass one; percent do not.
const MAX_THROUGHPUT: f64 = 2.0;

/// The keys that every band takes.
pub(super) const KEYS: &[KeyRow] = &[NAME.row, COUNTING.row];

impl Choices for Counting {
    const ROWS: &'static [(&'static str, Self)] = &[("energy", Self::Energy), ("photon", Self::Photon)];
}

pub(super) fn build(root: &Section, inputs: &Inputs) -> Result<Vec<Passband>> {
    let tables = root.tables("band")?;
    let mut bands = match root.read(&BANDS)? {
        Some(names) => named(root, &names)?,
        None if tables.is_empty() => named(root, &["johnson"])?,
        None => Vec::new(),
    };
    for section in tables {
        let make = build_kind_with("passband", KINDS, KEYS, &section, inputs)?;
        let counting = section.read(&COUNTING)?;
        let name = section.read(&NAME)?;
        if name.chars().count() > LONGEST_NAME {
            let message = format!("the name has {} characters; files support at most {LONGEST_NAME}", name.chars().count());
            return Err(section.error(&NAME, message));
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
            bands.push(root.wrap("bands", Passband::by_name(name))?);
        } else {
            let known: Vec<&str> = passband::SETS.iter().map(|s| s.name).chain(passband::names()).collect();
            return root.wrap("bands", Err(spectra::SpectraError::unknown("passband or set", name, &known)));
        }
    }
    Ok(bands)
}
