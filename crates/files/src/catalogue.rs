//! All catalogues by name: `barnard list`, the manual and test loops read the same tables.

use spectra::SpectraError;

use barnard::error::Result;
use barnard::{backend, camera, phase, scene};

use crate::{builtin, formats};

/// The rows of a catalogue, each (name, summary).
type CatalogueRows = Vec<(String, String)>;

/// One catalogue of things that scenes name.
pub struct Catalogue {
    /// The name by which a person asks for it.
    pub name: &'static str,
    /// Contents in one line.
    pub summary: &'static str,
    /// Makes its rows.
    pub rows: fn() -> CatalogueRows,
}

fn rows<'a>(pairs: impl Iterator<Item = (&'a str, &'a str)>) -> CatalogueRows {
    pairs.map(|(name, summary)| (name.to_owned(), summary.to_owned())).collect()
}

/// All catalogues.
pub const CATALOGUES: &[Catalogue] = &[
    Catalogue { name: "scenes", summary: "built-in scenes", rows: || rows(builtin::SCENES.iter().map(|s| (s.name, s.summary))) },
    Catalogue { name: "methods", summary: "spectral methods", rows: || rows(scene::methods().map(|m| (m.name, m.summary))) },
    Catalogue { name: "backends", summary: "what renders", rows: || rows(backend::BACKENDS.iter().map(|b| (b.name, b.summary))) },
    Catalogue { name: "laws", summary: "extinction laws", rows: || rows(spectra::extinction::LAWS.iter().map(|l| (l.name, l.summary))) },
    Catalogue { name: "phases", summary: "phase functions", rows: || rows(phase::KINDS.iter().map(|k| (k.name, k.summary))) },
    Catalogue { name: "fields", summary: "kinds of field", rows: || rows(scene::field_kinds()) },
    Catalogue { name: "cameras", summary: "kinds of camera", rows: || rows(camera::KINDS.iter().map(|k| (k.name, k.summary))) },
    Catalogue { name: "spectra", summary: "kinds of stellar spectrum", rows: || rows(scene::star_spectra()) },
    Catalogue {
        name: "stars",
        summary: "stellar spectra of the embedded library; types between are interpolated",
        rows: || spectra::sed::star_names().map(|name| (name.to_owned(), spectra::sed::star_summary(name))).collect(),
    },
    Catalogue { name: "emission", summary: "kinds of emitting gas", rows: || rows(scene::emission_kinds()) },
    Catalogue {
        name: "line-lists",
        summary: "lines of model nebulae",
        rows: || rows(spectra::nebular::LINE_LISTS.iter().map(|l| (l.name, l.summary))),
    },
    Catalogue {
        name: "ions",
        summary: "ions with line emissivities",
        rows: || rows(spectra::nebular::ions().into_iter().map(|i| (i, "emissivities over temperature and density, PyNeb 1.1.32"))),
    },
    Catalogue { name: "passbands", summary: "embedded passbands", rows: passbands },
    Catalogue {
        name: "passband-sets",
        summary: "named sets of passbands",
        rows: || rows(spectra::passband::SETS.iter().map(|s| (s.name, s.summary))),
    },
    Catalogue {
        name: "passband-families",
        summary: "families of embedded passbands",
        rows: || rows(spectra::passband::FAMILIES.iter().map(|f| (f.name, f.summary))),
    },
    Catalogue { name: "passband-kinds", summary: "kinds of custom passband", rows: || rows(scene::band_kinds()) },
    Catalogue {
        name: "palettes",
        summary: "colours of bands",
        rows: || rows(spectra::colour::PALETTES.iter().map(|p| (p.name, p.summary))),
    },
    Catalogue {
        name: "stretches",
        summary: "curves from radiance to brightness",
        rows: || rows(spectra::colour::STRETCHES.iter().map(|s| (s.name, s.summary))),
    },
    Catalogue {
        name: "optics",
        summary: "optics of glare: telescopes and the eye",
        rows: || rows(barnard::image::optics::OPTICS.iter().map(|o| (o.name, o.summary))),
    },
    Catalogue {
        name: "instruments",
        summary: "telescopes with detectors, and their sources",
        rows: || rows(barnard::instrument::PRESETS.iter().map(|p| (p.name, p.summary))),
    },
    Catalogue {
        name: "psfs",
        summary: "point-spread functions",
        rows: || rows(barnard::instrument::psf::KINDS.iter().map(|k| (k.name, k.summary))),
    },
    Catalogue {
        name: "interpolations",
        summary: "interpolation between keyframes",
        rows: || rows(barnard::animation::INTERPOLATIONS.into_iter()),
    },
    Catalogue {
        name: "readers",
        summary: "readable file formats",
        rows: || formats::READERS.iter().map(|r| (r.extensions.join(", "), r.summary.to_owned())).collect(),
    },
    Catalogue {
        name: "writers",
        summary: "writable file formats",
        rows: || rows(formats::WRITERS.iter().map(|w| (w.extension, w.summary))),
    },
    Catalogue {
        name: "grid-writers",
        summary: "file formats of `barnard convert`",
        rows: || rows(formats::GRID_WRITERS.iter().map(|w| (w.extension, w.summary))),
    },
];

impl Catalogue {
    /// The catalogue called `name`.
    ///
    /// # Errors
    /// If there is none.
    pub fn by_name(name: &str) -> Result<&'static Catalogue> {
        let known: Vec<&str> = CATALOGUES.iter().map(|c| c.name).collect();
        Ok(CATALOGUES.iter().find(|c| c.name == name).ok_or_else(|| SpectraError::unknown("catalogue", name, &known))?)
    }
}

/// Name, pivot, width, counting and family.
fn passbands() -> CatalogueRows {
    let family = |name: &str| {
        spectra::passband::family(name)
            .map_or(if name.starts_with("cie") { "CIE 1931" } else { spectra::passband::FAMILIES[0].summary }, |f| f.summary)
    };
    let row = |name: &str| {
        let band = spectra::passband::Passband::by_name(name).ok()?;
        let leak = band.leak().map_or(String::new(), |leak| format!("; {leak}"));
        let words = format!("pivot {:.2} nm, width {:.2} nm; {}{leak}", band.pivot().nm(), band.width().nm(), family(name));
        Some((name.to_owned(), words))
    };
    spectra::passband::names().into_iter().filter_map(row).collect()
}
