//! Reports as values of Python: a dictionary of facts, and a state that pickles hold.

use barnard::image::{BandCertificates, DetailReport, PathReport, Report, ScatteringError, SpatialError, Stepping, UnresolvedStars};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use spectra::rule::Certificate;

use crate::tree;

/// Facts of a report as a dictionary, as JSON has them.
pub fn facts<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyDict>> {
    tree::dictionary(py, &report.tree())
}

/// Steps: number of the kind, and the samples.
type SteppingState = (usize, f64);
/// Spatial error: steps, error, function samples, rays, stars.
type Spatial = (SteppingState, f64, Option<(f64, usize)>, usize, Option<(f64, usize)>);
/// Light, error relative to F(0) and to F(a), depth.
type CertificateState = (String, f64, f64, f64);

/// Everything in a report.
#[derive(IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
pub struct ReportState {
    backend: Option<String>,
    method: Option<String>,
    bounces: Option<usize>,
    steps: Option<SteppingState>,
    accuracy: Option<f64>,
    depth: Option<f64>,
    detail: Option<(usize, f64)>,
    spatial: Option<Spatial>,
    scattering: Option<(f64, f64)>,
    paths: Option<(u64, u64, u64)>,
    certificates: Vec<(String, Vec<CertificateState>)>,
    negative: u64,
    notes: Vec<(String, String)>,
}

fn steps(stepping: Stepping) -> SteppingState {
    match stepping {
        Stepping::PerVoxel(samples) => (0, samples),
        Stepping::Paired(segments) => (1, segments),
        Stepping::Fixed(samples) => (2, samples as f64),
    }
}

fn stepping((kind, samples): SteppingState) -> Stepping {
    match kind {
        0 => Stepping::PerVoxel(samples),
        1 => Stepping::Paired(samples),
        _ => Stepping::Fixed(samples as usize),
    }
}

impl From<&Report> for ReportState {
    fn from(report: &Report) -> Self {
        let report = report.clone();
        let spatial = |error: SpatialError| {
            (steps(error.stepping), error.error, error.sampling, error.rays, error.unresolved.map(|stars| (stars.error, stars.stars)))
        };
        let row = |(light, c): (String, Certificate)| (light, c.absolute, c.relative, c.depth);
        let band = |certificates: BandCertificates| (certificates.band, certificates.lights.into_iter().map(row).collect());
        Self {
            backend: report.backend,
            method: report.method,
            bounces: report.bounces,
            steps: report.steps.map(steps),
            accuracy: report.accuracy,
            depth: report.depth,
            detail: report.detail.map(|detail| (detail.octaves, detail.deviation)),
            spatial: report.spatial.map(spatial),
            scattering: report.scattering.map(|error| (error.spatial, error.angular)),
            paths: report.paths.map(|paths| (paths.per_pixel, paths.seed, paths.skipped)),
            certificates: report.certificates.into_iter().map(band).collect(),
            negative: report.negative,
            notes: report.notes,
        }
    }
}

impl From<ReportState> for Report {
    fn from(state: ReportState) -> Self {
        let spatial = |(steps, error, sampling, rays, stars): Spatial| SpatialError {
            stepping: stepping(steps),
            error,
            sampling,
            rays,
            unresolved: stars.map(|(error, stars)| UnresolvedStars { error, stars }),
        };
        let certificate = |(light, absolute, relative, depth): CertificateState| (light, Certificate { absolute, relative, depth });
        let band = |(band, lights): (String, Vec<CertificateState>)| BandCertificates {
            band,
            lights: lights.into_iter().map(certificate).collect(),
        };
        Self {
            backend: state.backend,
            method: state.method,
            bounces: state.bounces,
            steps: state.steps.map(stepping),
            accuracy: state.accuracy,
            depth: state.depth,
            detail: state.detail.map(|(octaves, deviation)| DetailReport { octaves, deviation }),
            spatial: state.spatial.map(spatial),
            scattering: state.scattering.map(|(spatial, angular)| ScatteringError { spatial, angular }),
            paths: state.paths.map(|(per_pixel, seed, skipped)| PathReport { per_pixel, seed, skipped }),
            certificates: state.certificates.into_iter().map(band).collect(),
            negative: state.negative,
            notes: state.notes,
        }
    }
}
