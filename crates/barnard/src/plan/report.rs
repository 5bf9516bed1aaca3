//! Report of a plan: certificates with what arithmetic adds, the spatial error, words and keywords.

use spectra::rule::{Certificate, Rounding};

use crate::blocks::Storage;
use crate::keywords::{self, Keyword};
use crate::light::Route;
use crate::plan::{END_SHARE, Plan, Spatial, Unresolved};
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

    /// The certificate of a passband in words, a line for each light, for what a march found.
    pub fn certificate(&self, band: usize, stats: &RenderStats) -> Vec<String> {
        self.certificates(band, stats).iter().map(|(light, c)| format!("{}: {}", self.lights[*light].name, in_words(c))).collect()
    }

    /// Relative errors in one line: the largest spectral error relative to the unattenuated light, the measured spatial error (rms),
    /// and the estimated error of multiple scattering relative to that light.
    pub fn error_summary(&self, stats: &RenderStats) -> String {
        let certificates = (0..self.spectral.bands.len()).flat_map(|band| self.certificates(band, stats));
        let spectral = certificates.map(|(_, certificate)| certificate.absolute).fold(0.0, f64::max);
        let spatial = self.space.spatial.map(|spatial| format!(", spatial {:.0e}", spatial.error));
        let estimate = self.scattered_field.as_ref().and_then(|field| field.report.error_estimate);
        let scattering = estimate.map(|error| format!(", multiple scattering {:.0e}", error.spatial.hypot(error.angular)));
        format!("spectral {spectral:.0e}{}{}", spatial.unwrap_or_default(), scattering.unwrap_or_default())
    }

    /// The certificate of the light that a passband's rule serves worst, in words.
    pub fn worst_certificate(&self, band: usize, stats: &RenderStats) -> String {
        let certificates = self.certificates(band, stats);
        let Some((light, worst)) = certificates.iter().max_by(|a, b| a.1.absolute.total_cmp(&b.1.absolute)) else {
            return "no light in this band".into();
        };
        let others = match certificates.len() {
            1 => String::new(),
            count => format!(", worst of {count} lights ({})", self.lights[*light].name),
        };
        in_words(worst) + &others
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
        certificates.into_iter().enumerate().filter(shining).map(rounded).collect()
    }

    /// True if pilot rays or sampled stars found a larger error than requested.
    pub fn misses_accuracy(&self) -> bool {
        let worst = |s: Spatial| s.unresolved.map_or(s.error, |stars| stars.error.max(s.error));
        self.space.spatial.is_some_and(|s| worst(s) > self.spectral.accuracy)
    }

    /// Notes on the picture beside the certificates, each with what it is about.
    pub fn notes(&self) -> Vec<(String, String)> {
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
        let pages = pages.map(|v| ("volumes".into(), format!("sparse: {:.1} % of the voxels are stored", 100.0 * v.held())));
        let scattered_field =
            self.scattered_field.iter().filter(|f| f.report.sweeps > 0).map(|f| ("multiple scattering".into(), f.report.to_string()));
        let detail = self.detail.iter().filter(|detail| !detail.octaves.is_empty()).map(|detail| ("detail".into(), detail.in_words()));
        self.spatial_note()
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

    /// The spatial error in words.
    fn spatial_note(&self) -> Option<(String, String)> {
        let s = self.space.spatial?;
        let words = format!(
            "measured {:.1e} (relative rms of the worst band over {} pilot rays, {}, {})",
            s.error,
            s.rays,
            s.stepping,
            match &self.light_field {
                None => format!("star depths of {} per voxel", self.space.star_factor),
                Some(field) => format!("a light field of {} numbers per voxel", field.propagation.channels()),
            }
        );
        let words = match s.sampling {
            Some((error, edge)) => format!("{words}; function samples, {edge} per edge: {error:.1e}"),
            None => words,
        };
        let words = match s.unresolved {
            Some(Unresolved { error, stars }) => {
                format!("{words}; stars seen through it {error:.1e} (rms of {stars}, from the samples of dust)")
            }
            None => words,
        };
        let asked = self.spectral.accuracy;
        let words = if self.misses_accuracy() { format!("{words}: more than the requested {asked:.1e}") } else { words };
        Some(("spatial error".into(), words))
    }

    /// Keywords of the picture: method, steps and errors as numbers.
    pub fn keywords(&self, stats: &RenderStats) -> Vec<Keyword> {
        let mut keywords = vec![
            keywords::text("METHOD", self.spectral.method, "method of spectral integrals"),
            keywords::integer("BOUNCES", self.bounces, "largest number of scatterings"),
            keywords::text("STEPS", self.stepping.to_string(), "distance of samples"),
        ];
        keywords.extend(keywords::number("ACCURACY", self.spectral.accuracy, "asked for"));
        keywords.extend(keywords::number("TAUMAX", stats.depth, "largest optical depth at V"));
        if let Some(detail) = self.detail.as_ref().filter(|detail| !detail.octaves.is_empty()) {
            keywords.push(keywords::integer("DETAIL", detail.octaves.len(), "octaves of noise below the voxels"));
            let deepest = detail.roughness.iter().map(|of| of.deviation).fold(0.0, f64::max);
            keywords.extend(keywords::number("DETAILSD", deepest, "largest deviation of ln density, at two voxels"));
        }
        if let Some(spatial) = self.space.spatial {
            keywords.extend(keywords::number("SPATERR", spatial.error, "spatial error, relative rms, measured"));
            keywords.push(keywords::integer("SPATRAYS", spatial.rays, "number of pilot rays"));
            if let Some((error, edge)) = spatial.sampling {
                keywords.extend(keywords::number("SAMPERR", error, "error of function samples"));
                keywords.push(keywords::integer("BAKE", edge, "voxels per edge of function samples"));
            }
            if let Some(Unresolved { error, stars }) = spatial.unresolved {
                keywords.extend(keywords::number("STARERR", error, "relative rms of stars seen through samples of dust"));
                keywords.push(keywords::integer("STARSERR", stars, "number of these stars"));
            }
        }
        keywords
    }

    /// The spectral error of a band's worst light in keywords.
    pub fn band_keywords(&self, band: usize, stats: &RenderStats) -> Vec<Keyword> {
        in_keywords(self.certificates(band, stats).into_iter().map(|(_, certificate)| certificate))
    }
}

/// The worst of certificates in keywords.
pub(crate) fn in_keywords(certificates: impl Iterator<Item = Certificate>) -> Vec<Keyword> {
    let errors = certificates.reduce(Certificate::or_worse).into_iter().flat_map(|c| {
        let absolute = keywords::number("SPECERR", c.absolute, "largest spectral error relative to F(0)");
        absolute.into_iter().chain(keywords::number("SPECREL", c.relative, "relative to F(a), the attenuated light"))
    });
    errors.collect()
}

/// A certificate in words.
pub(crate) fn in_words(c: &Certificate) -> String {
    format!("spectral error at most {:.1e} of F(0), {:.1e} of F(a), for depths up to {:.3}", c.absolute, c.relative, c.depth)
}
