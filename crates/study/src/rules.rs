//! Rules as the chapters try them: any weight on any wavelengths, one rule, one size.

use spectra::extinction::Extinction;
use spectra::passband::Passband;
use spectra::quadrature::gauss_legendre;
use spectra::rule::{BandProblem, BandRule, Measure, Node, Settings, Source, rule};
use spectra::sed::BlackBody;
use spectra::spectrum::Spectrum;
use spectra::units::Temperature;

use crate::Result;

/// One passband, or an interval, and the sources that shine through it.
pub struct Run {
    /// The sources.
    pub sources: Vec<Source>,
    /// The interval of wavelengths [µm].
    pub domain_um: (f64, f64),
    pivot_um: f64,
    k: Box<dyn Fn(f64) -> f64 + Sync>,
}

/// Panels and Gauss points of an interval's measure.
const PANELS: usize = 64;
const PANEL_POINTS: usize = 16;

impl Run {
    /// A weight over an interval under an extinction.
    pub fn interval(
        domain_um: (f64, f64),
        weight: impl Fn(f64) -> f64 + Send + Sync + 'static,
        k: impl Fn(f64) -> f64 + Sync + 'static,
    ) -> Self {
        let (low, high) = domain_um;
        let mut measure = Measure::default();
        let width = (high - low) / PANELS as f64;
        for panel in 0..PANELS {
            for (x, w) in gauss_legendre(PANEL_POINTS) {
                let lambda = low + width * (panel as f64 + 0.5 * (1.0 + x));
                measure.lambda_um.push(lambda);
                measure.k.push(k(lambda));
                measure.mass.push(0.5 * width * w * weight(lambda));
            }
        }
        let source = Source { name: "weight".into(), measure, density: Box::new(weight), lines: Vec::new(), variants: Vec::new() };
        Self { sources: vec![source], domain_um, pivot_um: 0.5 * (low + high), k: Box::new(k) }
    }

    /// Black bodies of these temperatures [K] through a named passband under `inverse_wavelength`.
    pub fn passband(name: &str, temperatures: &[f64]) -> Result<Self> {
        let band = Passband::by_name(name)?;
        let law = Extinction::by_name("inverse_wavelength")?;
        let spectrum = |t: &f64| Spectrum::continuous(1.0, std::sync::Arc::new(BlackBody(Temperature(*t))));
        let sources = temperatures.iter().map(|t| Source::new("star", &band, &spectrum(t), &*law, |l| 0.55 / l)).collect();
        let pivot_um = band.pivot().0;
        Ok(Self { sources, domain_um: band.support_um(), pivot_um, k: Box::new(move |l| law.k(l)) })
    }

    /// The rule called `name` of a fixed size, for depths up to `depth`.
    pub fn solve(&self, name: &str, settings: &Settings, depth: f64) -> Result<BandRule> {
        let problem = BandProblem {
            sources: &self.sources,
            domain_um: self.domain_um,
            common_um: settings.domain_um.unwrap_or(self.domain_um),
            pivot: Node { lambda_um: self.pivot_um, k: (self.k)(self.pivot_um) },
            k: &*self.k,
            depth,
            accuracy: 1e-6,
            settings,
            interrupted: &|| false,
        };
        Ok((rule(name)?.solve)(&problem)?)
    }
}

/// Settings of a fixed size.
pub fn sized(count: usize) -> Settings {
    Settings { count: Some(count), ..Settings::default() }
}
