//! The light of one source through one passband, as a measure over λ and k.

use crate::exponential::attenuated;
use crate::extinction::ExtinctionLaw;
use crate::passband::Passband;
use crate::quadrature::gauss_of_measure;
use crate::spectrum::Spectrum;

/// A discrete measure Σ mass δ(λ): F(a) = Σ mass e^(−a k).
#[derive(Debug, Clone, Default)]
pub struct Measure {
    /// The wavelengths \[µm\].
    pub lambda_um: Vec<f64>,
    /// The extinction k(λ) at each, relative to V \[1\].
    pub k: Vec<f64>,
    /// W dλ, in the unit of F.
    pub mass: Vec<f64>,
}

impl Measure {
    /// The whole light without dust, F(0).
    pub fn total(&self) -> f64 {
        self.mass.iter().sum()
    }

    /// Mean of k over the mass \[1\]; not a number where there is none.
    pub fn mean_k(&self) -> f64 {
        self.k.iter().zip(&self.mass).map(|(k, m)| k * m).sum::<f64>() / self.total()
    }

    /// The light F(a) behind a depth.
    pub fn at(&self, depth: f64) -> f64 {
        attenuated(&self.k, &self.mass, depth)
    }

    /// A measure of fewer points with the same F(a) for 0 ≤ a ≤ `depth`, to a few parts in 1e11: in bins of k so narrow
    /// that a Δk ≤ 0.2, the three-point Gauss rule of what lies there (error (aΔk)⁶/2 016 000). λ of the points is
    /// lost.
    pub fn condensed(&self, depth: f64) -> Self {
        const WIDTH: f64 = 0.2;
        const POINTS: usize = 3;
        let mut order: Vec<usize> = (0..self.k.len()).collect();
        order.sort_by(|a, b| self.k[*a].total_cmp(&self.k[*b]));
        let width = WIDTH / depth.max(1e-9);
        let mut condensed = Self::default();
        let mut rest = &order[..];
        while let Some(first) = rest.first() {
            let count = rest.iter().take_while(|i| self.k[**i] <= self.k[*first] + width).count();
            let (bin, behind) = rest.split_at(count);
            let (k, mass): (Vec<f64>, Vec<f64>) = bin.iter().map(|i| (self.k[*i], self.mass[*i])).unzip();
            let points = if count > POINTS { gauss_of_measure(&k, &mass, POINTS) } else { k.into_iter().zip(mass).collect() };
            for (k, mass) in points {
                condensed.lambda_um.push(f64::NAN);
                condensed.k.push(k);
                condensed.mass.push(mass);
            }
            rest = behind;
        }
        condensed
    }

    /// The measure with one more factor f(λ).
    pub fn reweighted(&self, factor: impl Fn(f64) -> f64) -> Self {
        Self {
            lambda_um: self.lambda_um.clone(),
            k: self.k.clone(),
            mass: self.mass.iter().zip(&self.lambda_um).map(|(m, l)| m * factor(*l)).collect(),
        }
    }
}

/// A further spectral factor f(λ).
pub type Factor = Box<dyn Fn(f64) -> f64 + Send + Sync>;

/// One source of light through one passband.
pub struct Source {
    /// The name in certificates.
    pub name: String,
    /// The measure W dλ, lines included.
    pub measure: Measure,
    /// W(λ) without the lines, for rules that sample it.
    pub density: Factor,
    /// (λ \[µm\], mass) of the lines.
    pub lines: Vec<(f64, f64)>,
    /// Factors, such as the phase function at several angles, under which the certificate must hold as well.
    pub variants: Vec<Factor>,
}

impl Source {
    /// R(λ) · spectrum · factor(λ) through `band`, under `law`.
    pub fn new(
        name: &str,
        band: &Passband,
        spectrum: &Spectrum,
        law: &dyn ExtinctionLaw,
        factor: impl Fn(f64) -> f64 + Send + Sync + Clone + 'static,
    ) -> Self {
        let breaks: Vec<f64> = spectrum.breakpoints_um().chain(law.breakpoints_um()).collect();
        let mut measure = Measure::default();
        let mut push = |lambda_um: f64, mass: f64| {
            if mass != 0.0 {
                measure.lambda_um.push(lambda_um);
                measure.k.push(law.k(lambda_um));
                measure.mass.push(mass);
            }
        };
        for (lambda_um, weight) in band.samples(&breaks) {
            push(lambda_um, weight * band.response(lambda_um) * spectrum.continuum(lambda_um) * factor(lambda_um));
        }
        let through = |l: &crate::spectrum::Line| (l.lambda_um, l.strength * band.response(l.lambda_um));
        let seen: Vec<(f64, f64)> = spectrum.lines_through(band).iter().map(through).filter(|(_, m)| *m > 0.0).collect();
        let lines: Vec<(f64, f64)> = seen.iter().map(|&(l, m)| (l, m * factor(l))).collect();
        for &(lambda_um, mass) in &lines {
            push(lambda_um, mass);
        }
        let (band, spectrum) = (band.clone(), spectrum.clone());
        let density = Box::new(move |l: f64| band.response(l) * spectrum.continuum(l) * factor(l));
        Self { name: name.to_owned(), measure, density, lines, variants: Vec::new() }
    }
}
