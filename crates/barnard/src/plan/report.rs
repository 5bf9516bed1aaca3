//! Report of a plan: certificates with the errors of arithmetic, and notes.

use rayon::prelude::*;
use spectra::rule::{Certificate, Rounding};

use crate::blocks::Storage;
use crate::image::{BandCertificates, DetailReport, Report};
use crate::light::Route;
use crate::plan::{END_SHARE, Plan};
use crate::stats::RenderStats;
use crate::stored::Precision;

/// The largest relative error of a number in single precision.
pub const SINGLE: f64 = 1.0 / (1 << 24) as f64;
/// The largest relative error of a number in half precision, in which textures hold densities.
pub const HALF: f64 = 1.0 / (1 << 11) as f64;
/// Relative error of one term of one segment in single precision: the exponential's polynomial and that of sinh y/y.
const TERM_ROUNDING: f64 = 3e-6;

impl Plan {
    /// The largest relative error of a density, or of a star's depth, as the volumes have it: a depth in half precision
    /// is rounded when it is swept and when it is moved to its voxel's mean, which takes a third of its neighbours'.
    pub fn storage(&self) -> f64 {
        let volumes = match self.space.precision {
            Precision::Single => SINGLE,
            Precision::Half => 3.0 * HALF,
        };
        volumes + self.space.grid_storage().relative_error().unwrap_or(0.0)
    }

    /// The statistics that a march of this plan on the processor is expected to bring, before it was done.
    pub fn expected(&self) -> RenderStats {
        RenderStats {
            depth: self.spectral.depth,
            rays: (self.camera.width * self.camera.height) as u64,
            storage: self.storage(),
            negative: 0,
        }
    }

    /// The error that arithmetic adds to a light that takes `route`: depths and light are sums over all steps in single
    /// precision, of densities kept with a relative error of `storage`, and a ray ends when little is left. What comes
    /// straight from a star is done in double precision.
    pub(crate) fn rounding(&self, route: Route, storage: f64) -> Rounding {
        let longest = self.space.occupied.map_or(0.0, |b| b.size().length());
        let steps = if longest > 0.0 { self.stepping.steps(longest, self.space.voxel_pc()) as f64 } else { 0.0 };
        // A sum of n like terms loses at most half a unit of the last place n/2 times on the average of its way.
        let sum = SINGLE * (4.0 + 0.5 * steps);
        let early = f64::from(END_SHARE) * self.spectral.accuracy;
        match route {
            // Light is in proportion to a density; what single precision adds is among the term's.
            Route::Scattered { .. } | Route::Emitted { .. } => {
                Rounding { depth: storage + sum, light: TERM_ROUNDING + sum + early + (storage - SINGLE).max(0.0) }
            }
            Route::Background => Rounding { depth: storage + sum, light: SINGLE },
            Route::Direct { .. } | Route::FieldStar { .. } => Rounding { depth: 0.0, light: 0.0 },
        }
    }

    /// Certificates of the lights that shine in a passband, by their numbers, arithmetic included.
    pub fn certificates(&self, band: usize, stats: &RenderStats) -> Vec<(usize, Certificate)> {
        let (sources, depth) = (&self.spectral.bands[band].sources, stats.depth);
        let mut certificates = self.spectral.certify(band, depth);
        for (light, certificate) in self.light_field.iter().flat_map(|field| field.certify(band, sources, depth)) {
            certificates[light] = certificate;
        }
        let shining = |(light, _): &(usize, Certificate)| sources[*light].measure.total() > 0.0;
        let rounded = |(light, c): (usize, Certificate)| {
            let rounding = self.rounding(self.lights[light].route, stats.storage);
            let decay = self.spectral.bands[band].rule.form.decay();
            (light, c.rounded(&sources[light].measure, rounding, |a| decay.size(light, decay.weights(light), a)))
        };
        certificates.into_par_iter().enumerate().filter(shining).map(rounded).collect()
    }

    /// The report of an image with these measurements, made by a back end.
    pub fn report(&self, backend: &str, stats: &RenderStats) -> Report {
        let detail = self.detail.as_ref().filter(|detail| !detail.octaves.is_empty());
        let detail = detail.map(|detail| DetailReport { octaves: detail.octaves.len(), strength: detail.settings.strength });
        let certificates = self.spectral.bands.par_iter().enumerate().map(|(number, band)| {
            let named = |(light, certificate): (usize, Certificate)| (self.lights[light].name.clone(), certificate);
            let lights = self.certificates(number, stats).into_iter().map(named).collect();
            BandCertificates { band: band.band.name().to_owned(), lights }
        });
        Report {
            backend: Some(backend.to_owned()),
            method: Some(self.spectral.method.to_owned()),
            bounces: Some(self.bounces),
            steps: Some(self.stepping),
            accuracy: Some(self.spectral.accuracy),
            depth: Some(stats.depth).filter(|depth| depth.is_finite()),
            detail,
            spatial: self.space.spatial,
            scattering: self.scattered_field.as_ref().and_then(|field| field.report.error_estimate),
            paths: None,
            certificates: certificates.collect(),
            negative: stats.negative,
            notes: self.notes(),
        }
    }

    /// The report of an image that is not rendered yet, with the depths that are expected.
    pub fn expected_report(&self) -> Report {
        Report { backend: None, ..self.report("", &self.expected()) }
    }

    /// Statements about volumes and fields of light, each with its topic.
    fn notes(&self) -> Vec<(String, String)> {
        let light = match &self.light_field {
            None => format!("{} per voxel", self.space.star_factor),
            Some(field) => format!("a light field of {} numbers per voxel", field.propagation.channels()),
        };
        let light = self.space.spatial.map(|_| ("star depths".into(), light));
        let isotropic = self.light_field.as_ref().filter(|f| f.isotropic_instead);
        let isotropic = isotropic.map(|_| ("phase function".into(), "ignored by this method, whose scattering is isotropic".into()));
        let far_field = self.scattered_field.iter().filter_map(|f| f.report.far_field).map(|f| ("aggregated stars".into(), f.to_string()));
        let volumes = (self.space.precision == Precision::Half).then(|| ("volumes".into(), "stored in half precision".into()));
        let bytes = (self.space.grid_storage() == Storage::Byte).then(|| {
            let words =
                "stored as bytes, with errors of up to 1/508 of the largest value per block of 16 voxels; stated errors exclude this";
            ("densities".into(), words.into())
        });
        let pages = self.space.volumes.iter().find(|v| !v.pages().is_whole());
        let pages = pages.map(|v| ("volumes".into(), format!("sparse: {:.1} % of the voxels are stored", 100.0 * v.stored_share())));
        let scattered_field =
            self.scattered_field.iter().filter(|f| f.report.sweeps > 0).map(|f| ("multiple scattering".into(), f.report.to_string()));
        let detail = self.detail.iter().filter(|detail| !detail.octaves.is_empty()).map(|detail| ("detail".into(), detail.in_words()));
        light
            .into_iter()
            .chain(detail)
            .chain(volumes)
            .chain(pages)
            .chain(bytes)
            .chain(isotropic)
            .chain(self.fit_note())
            .chain(far_field)
            .chain(scattered_field)
            .collect()
    }

    /// The worst of the polynomials that stand for spectra.
    fn fit_note(&self) -> Option<(String, String)> {
        let of_rules = self.spectral.bands.iter().flat_map(|band| {
            let fits = (0..self.lights.len()).filter_map(|light| band.rule.form.decay().fit(light).map(|fit| (light, fit)));
            fits.map(|(light, fit)| (format!("{} in {}", self.lights[light].name, band.band.name()), fit))
        });
        let of_stars = self.light_field.iter().flat_map(|f| f.fits().map(|(light, fit)| (self.lights[light].name.clone(), fit)));
        let (name, worst) = of_rules.chain(of_stars).max_by(|a, b| a.1.rms.total_cmp(&b.1.rms))?;
        let degree = worst.polynomial.coefficients.len() - 1;
        let words = format!(
            "worst of degree {degree}: {name}, rms {:.1e}, at most {:.1e} of its peak; included in the spectral error",
            worst.rms, worst.largest
        );
        Some(("polynomial fits".into(), words))
    }
}
