//! Reports as values of Python: a dictionary of facts, and a state that pickles hold.

use barnard::image::{
    BandCertificates, DetailReport, PathReport, Report, ScatteringError, SpatialError, SpatialNumbers, Stepping, SteppingNumbers,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use spectra::rule::Certificate;

use crate::tree;

/// Facts of a report as a dictionary, as JSON has them.
pub fn facts<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyDict>> {
    tree::dictionary(py, &report.tree())
}

/// Light, error relative to F(0) and to F(a), depth.
type CertificateState = (String, f64, f64, f64);

/// Everything in a report.
#[derive(IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
pub struct ReportState {
    backend: Option<String>,
    method: Option<String>,
    bounces: Option<usize>,
    steps: Option<SteppingNumbers>,
    accuracy: Option<f64>,
    depth: Option<f64>,
    detail: Option<(usize, f64)>,
    spatial: Option<SpatialNumbers>,
    scattering: Option<(f64, f64)>,
    paths: Option<(u64, u64, u64)>,
    certificates: Vec<(String, Vec<CertificateState>)>,
    negative: u64,
    notes: Vec<(String, String)>,
}

impl From<&Report> for ReportState {
    fn from(report: &Report) -> Self {
        let report = report.clone();
        let row = |(light, c): (String, Certificate)| (light, c.absolute, c.relative, c.depth);
        let band = |certificates: BandCertificates| (certificates.band, certificates.lights.into_iter().map(row).collect());
        Self {
            backend: report.backend,
            method: report.method,
            bounces: report.bounces,
            steps: report.steps.map(Stepping::to_numbers),
            accuracy: report.accuracy,
            depth: report.depth,
            detail: report.detail.map(|detail| (detail.octaves, detail.strength)),
            spatial: report.spatial.map(SpatialError::to_numbers),
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
        let certificate = |(light, absolute, relative, depth): CertificateState| (light, Certificate { absolute, relative, depth });
        let band = |(band, lights): (String, Vec<CertificateState>)| BandCertificates {
            band,
            lights: lights.into_iter().map(certificate).collect(),
        };
        Self {
            backend: state.backend,
            method: state.method,
            bounces: state.bounces,
            steps: state.steps.and_then(Stepping::from_numbers),
            accuracy: state.accuracy,
            depth: state.depth,
            detail: state.detail.map(|(octaves, strength)| DetailReport { octaves, strength }),
            spatial: state.spatial.and_then(SpatialError::from_numbers),
            scattering: state.scattering.map(|(spatial, angular)| ScatteringError { spatial, angular }),
            paths: state.paths.map(|(per_pixel, seed, skipped)| PathReport { per_pixel, seed, skipped }),
            certificates: state.certificates.into_iter().map(band).collect(),
            negative: state.negative,
            notes: state.notes,
        }
    }
}
