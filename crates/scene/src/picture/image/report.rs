//! Reports: how an image was made and its stated errors, as numbers.

use spectra::rule::Certificate;

use super::{Stepping, SteppingNumbers};
use crate::keywords::{self, Keyword};
use crate::properties::{Property, Table, Value};

/// How an image was made and its stated errors. Unknown values are `None`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Name of the back end, with its device.
    pub backend: Option<String>,
    /// Name of the spectral method.
    pub method: Option<String>,
    /// Largest number of scatterings.
    pub bounces: Option<usize>,
    /// Spacing of the samples along a ray.
    pub steps: Option<Stepping>,
    /// Requested accuracy \[1\].
    pub accuracy: Option<f64>,
    /// Largest optical depth at V from the camera to a sample to a star \[1\].
    pub depth: Option<f64>,
    /// Density detail below the voxels.
    pub detail: Option<DetailReport>,
    /// Spatial error.
    pub spatial: Option<SpatialError>,
    /// Error of multiple scattering.
    pub scattering: Option<ScatteringError>,
    /// Sampling of a path tracer.
    pub paths: Option<PathReport>,
    /// Spectral errors by passband.
    pub certificates: Vec<BandCertificates>,
    /// Number of radiances below zero, over all bands.
    pub negative: u64,
    /// Further statements, each with its topic.
    pub notes: Vec<(String, String)>,
}

/// Spectral errors of one passband.
#[derive(Debug, Clone, PartialEq)]
pub struct BandCertificates {
    /// Name of the passband.
    pub band: String,
    /// The name of each light that shines in it, with its error.
    pub lights: Vec<(String, Certificate)>,
}

/// Density detail below the voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetailReport {
    /// Octaves of displacement.
    pub octaves: usize,
    /// Displacement relative to the wavelength.
    pub strength: f64,
}

/// Spatial error measured by pilot rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpatialError {
    /// Spacing of the samples along the pilot rays.
    pub stepping: Stepping,
    /// Relative rms error of the worst band.
    pub error: f64,
    /// The part of it that is due to sampled functions, and the voxels along the longest edge of the coarsest of these.
    pub sampling: Option<(f64, usize)>,
    /// Number of pilot rays.
    pub rays: usize,
    /// The error that samples of a function cost stars that are seen through it; `None` where they cost nothing.
    pub unresolved: Option<UnresolvedStars>,
}

/// Error of the fluxes of unresolved stars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnresolvedStars {
    /// Relative rms error over the sampled stars, worst band.
    pub error: f64,
    /// Number of sampled stars.
    pub stars: usize,
}

/// Errors of multiple scattering in the picture, estimated from coarser cells and other directions: relative rms of the worst band over
/// pilot rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteringError {
    /// Error of the cells.
    pub spatial: f64,
    /// Error of the directions.
    pub angular: f64,
}

/// Sampling of a path tracer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PathReport {
    /// Paths per pixel.
    pub per_pixel: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Paths that were not finite and were skipped.
    pub skipped: u64,
}

/// Stepping, error, function samples, rays, and stars of a [`SpatialError`].
pub type SpatialNumbers = (SteppingNumbers, f64, Option<(f64, usize)>, usize, Option<(f64, usize)>);

impl SpatialError {
    /// The error as numbers, for storage.
    pub fn to_numbers(self) -> SpatialNumbers {
        let stars = self.unresolved.map(|stars| (stars.error, stars.stars));
        (self.stepping.to_numbers(), self.error, self.sampling, self.rays, stars)
    }

    /// The error of [numbers](Self::to_numbers); `None` for an unknown stepping.
    pub fn from_numbers((stepping, error, sampling, rays, stars): SpatialNumbers) -> Option<Self> {
        let unresolved = stars.map(|(error, stars)| UnresolvedStars { error, stars });
        Some(Self { stepping: Stepping::from_numbers(stepping)?, error, sampling, rays, unresolved })
    }

    /// The larger one of the errors of images and of stars, relative rms.
    pub fn worst(&self) -> f64 {
        self.unresolved.map_or(self.error, |stars| stars.error.max(self.error))
    }
}

/// A certificate as a sentence.
fn certificate_words(c: &Certificate) -> String {
    format!("spectral error at most {:.1e} of F(0), {:.1e} of F(a), for depths up to {:.3}", c.absolute, c.relative, c.depth)
}

impl Report {
    /// Spectral errors of a passband; empty where they are unknown.
    pub fn certificates_of(&self, band: &str) -> &[(String, Certificate)] {
        self.certificates.iter().find(|known| known.band == band).map_or(&[], |known| &known.lights)
    }

    /// Statements about the spectral errors of a passband, a sentence for each light.
    pub fn band_words(&self, band: &str) -> Vec<String> {
        self.certificates_of(band).iter().map(|(light, c)| format!("{light}: {}", certificate_words(c))).collect()
    }

    /// The largest spectral error of a passband, as a sentence.
    pub fn worst_words(&self, band: &str) -> String {
        let lights = self.certificates_of(band);
        let Some((light, worst)) = lights.iter().max_by(|a, b| a.1.absolute.total_cmp(&b.1.absolute)) else {
            return "no light in this band".into();
        };
        let others = if lights.len() == 1 { String::new() } else { format!(", worst of {} lights ({light})", lights.len()) };
        certificate_words(worst) + &others
    }

    /// The largest spectral errors of a passband as FITS cards.
    pub fn band_cards(&self, band: &str) -> Vec<Keyword> {
        let worst = self.certificates_of(band).iter().map(|(_, certificate)| *certificate).reduce(Certificate::or_worse);
        let cards = worst.into_iter().flat_map(|c| {
            let absolute = keywords::number("SPECERR", c.absolute, "largest spectral error relative to F(0)");
            absolute.into_iter().chain(keywords::number("SPECREL", c.relative, "relative to F(a), the attenuated light"))
        });
        cards.collect()
    }

    /// The largest spectral error of all lights and passbands, relative to the unattenuated light.
    pub fn spectral_error(&self) -> Option<f64> {
        self.certificates.iter().flat_map(|band| &band.lights).map(|(_, c)| c.absolute).reduce(f64::max)
    }

    /// Relative errors in one line: the largest spectral error relative to the unattenuated light, the measured spatial error (rms),
    /// and the estimated error of multiple scattering in the picture (rms).
    pub fn summary(&self) -> String {
        let spatial = self.spatial.map(|spatial| format!(", spatial {:.0e}", spatial.error));
        let scattering = self.scattering.map(|error| format!(", multiple scattering {:.0e}", error.spatial.hypot(error.angular)));
        let spectral = self.spectral_error().unwrap_or_default();
        format!("spectral {spectral:.0e}{}{}", spatial.unwrap_or_default(), scattering.unwrap_or_default())
    }

    /// True if the measured spatial error is larger than requested.
    pub fn misses_accuracy(&self) -> bool {
        self.spatial.zip(self.accuracy).is_some_and(|(spatial, accuracy)| spatial.worst() > accuracy)
    }

    /// Statements about the image as a whole, each with its topic: its origin, then those of [`statements`](Self::statements).
    pub fn words(&self) -> Vec<(String, String)> {
        let backend = self.backend.as_ref().map(|backend| ("backend".to_owned(), format!("{backend}{}", self.sampling_words())));
        let method = self.method.as_ref().map(|method| ("method".to_owned(), method.clone()));
        backend.into_iter().chain(method).chain(self.statements()).collect()
    }

    /// Statements about errors, volumes and light, each with its topic.
    pub fn statements(&self) -> Vec<(String, String)> {
        let spatial = self.spatial.as_ref().map(|spatial| ("spatial error".to_owned(), self.spatial_words(spatial)));
        let mut words: Vec<(String, String)> = spatial.into_iter().chain(self.notes.iter().cloned()).collect();
        let mut state = |topic: &str, count: u64, what: &str| {
            if count > 0 {
                words.push((topic.to_owned(), format!("{count} {what}")));
            }
        };
        state("bad paths", self.paths.map_or(0, |paths| paths.skipped), "were not finite and were skipped");
        state("negative values", self.negative, "pixels over all bands, unchanged");
        words
    }

    fn sampling_words(&self) -> String {
        let Some(PathReport { per_pixel, seed, .. }) = self.paths else { return String::new() };
        let bounces = self.bounces.map(|bounces| format!(", at most {bounces} bounces")).unwrap_or_default();
        format!(", {per_pixel} paths per pixel{bounces}, seed {seed}")
    }

    fn spatial_words(&self, spatial: &SpatialError) -> String {
        let mut words = format!(
            "measured {:.1e} (relative rms of the worst band over {} pilot rays, {})",
            spatial.error, spatial.rays, spatial.stepping
        );
        if let Some((error, edge)) = spatial.sampling {
            words += &format!("; function samples, {edge} per edge: {error:.1e}");
        }
        if let Some(UnresolvedStars { error, stars }) = spatial.unresolved {
            words += &format!("; stars seen through it {error:.1e} (rms of {stars}, from the samples of dust)");
        }
        match self.accuracy {
            Some(accuracy) if self.misses_accuracy() => format!("{words}: more than the requested {accuracy:.1e}"),
            _ => words,
        }
    }

    /// Statements about the image as a whole as FITS cards.
    pub fn cards(&self) -> Vec<Keyword> {
        let text = |name, value: Option<String>, comment| value.map(|value| keywords::text(name, value, comment));
        let number = |name, value: Option<f64>, comment| value.and_then(|value| keywords::number(name, value, comment));
        let integer = |name, value: Option<usize>, comment| value.map(|value| keywords::integer(name, value, comment));
        let count = |value: u64| usize::try_from(value).unwrap_or(usize::MAX);
        let spatial = self.spatial;
        let sampling = spatial.and_then(|spatial| spatial.sampling);
        let stars = spatial.and_then(|spatial| spatial.unresolved);
        [
            text("BACKEND", self.backend.clone(), "back end"),
            text("METHOD", self.method.clone(), "method of spectral integrals"),
            integer("BOUNCES", self.bounces, "largest number of scatterings"),
            integer("NPATHS", self.paths.map(|paths| count(paths.per_pixel)), "paths per pixel"),
            integer("SEED", self.paths.map(|paths| count(paths.seed)), "seed of the random numbers"),
            text("STEPS", self.steps.map(|steps| steps.to_string()), "distance of samples"),
            number("ACCURACY", self.accuracy, "requested"),
            number("TAUMAX", self.depth, "largest optical depth at V"),
            integer("DETAIL", self.detail.map(|detail| detail.octaves), "octaves of displacement below the voxels"),
            number("DETAILST", self.detail.map(|detail| detail.strength), "displacement relative to the wavelength"),
            number("SPATERR", spatial.map(|spatial| spatial.error), "spatial error, relative rms, measured"),
            integer("SPATRAYS", spatial.map(|spatial| spatial.rays), "number of pilot rays"),
            number("SAMPERR", sampling.map(|(error, _)| error), "error of function samples"),
            integer("BAKE", sampling.map(|(_, edge)| edge), "voxels per edge of function samples"),
            number("STARERR", stars.map(|stars| stars.error), "relative rms of stars seen through samples of dust"),
            integer("STARSERR", stars.map(|stars| stars.stars), "number of these stars"),
            number("SCATERR", self.scattering.map(|error| error.spatial), "multiple scattering, error of its cells"),
            number("SCATANG", self.scattering.map(|error| error.angular), "multiple scattering, error of its directions"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// The report as a tree, the same for JSON and other languages; unknown values are absent.
    pub fn tree(&self) -> Table {
        let text = |value: &Option<String>| value.clone().map(Value::Text);
        let paths = |paths: PathReport| {
            table([("per_pixel", count(paths.per_pixel)), ("seed", count(paths.seed)), ("skipped", count(paths.skipped))])
        };
        let notes = self.notes.iter().map(|(topic, words)| (topic.as_str(), Some(Value::Text(words.clone()))));
        entries([
            ("backend", text(&self.backend)),
            ("method", text(&self.method)),
            ("bounces", integer(self.bounces)),
            ("steps", self.steps.map(|steps| Value::Text(steps.to_string()))),
            ("accuracy", number(self.accuracy)),
            ("optical_depth", number(self.depth)),
            ("spectral_error", number(self.spectral_error())),
            ("spatial_error", self.spatial.map(spatial_error)),
            ("misses_accuracy", self.spatial.map(|_| Value::Flag(self.misses_accuracy()))),
            (
                "scattering_error",
                self.scattering.map(|error| table([("spatial", number(Some(error.spatial))), ("angular", number(Some(error.angular)))])),
            ),
            (
                "detail",
                self.detail.map(|detail| table([("octaves", integer(Some(detail.octaves))), ("strength", number(Some(detail.strength)))])),
            ),
            ("paths", self.paths.map(paths)),
            ("certificates", Some(Value::Table(entries(self.certificates.iter().map(certificates))))),
            ("negative_values", count(self.negative)),
            ("notes", Some(Value::Table(entries(notes)))),
        ])
    }
}

/// Table of the values that are known.
fn entries<'a>(rows: impl IntoIterator<Item = (&'a str, Option<Value>)>) -> Table {
    let mut table = Table::default();
    for (name, value) in rows {
        if let Some(value) = value {
            table.insert(name, value);
        }
    }
    table
}

fn table<const N: usize>(rows: [(&str, Option<Value>); N]) -> Value {
    Value::Table(entries(rows))
}

fn number(value: Option<f64>) -> Option<Value> {
    value.filter(|value| value.is_finite()).map(Value::Number)
}

fn integer(value: Option<usize>) -> Option<Value> {
    count(value? as u64)
}

fn count(value: u64) -> Option<Value> {
    i64::try_from(value).ok().map(Value::Integer)
}

fn spatial_error(spatial: SpatialError) -> Value {
    table([
        ("error", number(Some(spatial.error))),
        ("pilot_rays", integer(Some(spatial.rays))),
        ("function_samples", number(spatial.sampling.map(|(error, _)| error))),
        ("samples_per_edge", integer(spatial.sampling.map(|(_, edge)| edge))),
        ("stars", number(spatial.unresolved.map(|stars| stars.error))),
        ("sampled_stars", integer(spatial.unresolved.map(|stars| stars.stars))),
    ])
}

/// Certificates of a band, by its name.
fn certificates(BandCertificates { band, lights }: &BandCertificates) -> (&str, Option<Value>) {
    let row = |(light, c): &(String, Certificate)| {
        Property::from(table([
            ("light", Some(Value::Text(light.clone()))),
            ("absolute", number(Some(c.absolute))),
            ("relative", number(Some(c.relative))),
            ("depth", number(Some(c.depth))),
        ]))
    };
    (band, Some(Value::List(lights.iter().map(row).collect())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> Report {
        let certificate = |absolute| Certificate { absolute, relative: 2.0 * absolute, depth: 3.0 };
        let spatial = SpatialError { stepping: Stepping::PerVoxel(0.5), error: 2e-3, sampling: None, rays: 96, unresolved: None };
        Report {
            backend: Some("cpu".into()),
            method: Some("fixed".into()),
            accuracy: Some(1e-3),
            spatial: Some(spatial),
            certificates: vec![BandCertificates {
                band: "V".into(),
                lights: vec![("sun".into(), certificate(1e-4)), ("glow".into(), certificate(3e-4))],
            }],
            ..Report::default()
        }
    }

    /// Words, cards and the tree state the numbers of the report, and nothing that is unknown.
    #[test]
    fn all_forms_state_the_same_numbers() {
        let report = report();
        assert_eq!(report.summary(), "spectral 3e-4, spatial 2e-3");
        assert!(report.misses_accuracy() && report.words().iter().any(|(_, words)| words.ends_with("more than the requested 1.0e-3")));
        let value = |name: &str, cards: &[Keyword]| cards.iter().find(|card| card.name == name).map(|card| card.value.clone());
        assert_eq!(value("SPECERR", &report.band_cards("V")), Some(keywords::Value::Number(3e-4)));
        assert_eq!(value("SPATERR", &report.cards()), Some(keywords::Value::Number(2e-3)));
        assert_eq!((value("NPATHS", &report.cards()), report.band_cards("B")), (None, Vec::new()));
        let tree = report.tree();
        let number = |name: &str| tree.get(name).map(|property| property.value.clone());
        assert_eq!((number("spectral_error"), number("paths")), (Some(Value::Number(3e-4)), None));
        let enough = Report { accuracy: Some(2e-3), ..report };
        assert!(!enough.misses_accuracy());
    }
}
