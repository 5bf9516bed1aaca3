//! Light of many stars as a few polynomials: Barrès & Neyret's spectral-spatial basis propagation.
//!
//!   Σ_ℓ e^(−τ_ℓ k) P_ℓ/(4π r_ℓ²) ≈ Σ_i Q_i V_i,  V_i = Σ_ℓ q_i(τ_ℓ) P_ℓ/(4π r_ℓ²)     eq. (18) of docs/method.md
//!   e^(−τ k)                     ≈ Σ_m q_m(τ) Q_m                                      eq. (19)
//!   Q_i Q_m                      ≈ Σ_j M_imj Q_j,  M_imj = ⟨Q_i Q_m, Q_j⟩              eq. (19)
//!
//! so that a sample adds Σ_i (Σ_m q_m(τ) M_imj) V_i to the j-th polynomial of a ray, whatever the number of stars,
//! eq. (20); at its end, ∫ R k ω Q_j P dλ turns the polynomials into bands, eq. (21). Each star's P_ℓ is a
//! least-squares polynomial of its spectrum. Black bodies lie nearly in a space of two or three dimensions: what is
//! carried are coordinates in the few orthonormal polynomials that span all stars.
//!
//! Source: Barrès & Neyret 2023, their equations 2 to 4.

use nalgebra::{DMatrix, DVector};

use crate::error::Result;
use crate::polynomial::{Fit, Polynomial};
use crate::rule::{Certificate, Measure, Projection};

/// A basis, its products and the polynomials of all stars.
#[derive(Debug)]
pub struct Propagation {
    /// The elements and their coordinates over depth.
    pub projection: Projection,
    /// M_imj [µm^−½, element × element × element].
    pub products: Vec<f64>,
    /// Polynomials that span the spectra of all stars, each of norm one over the domain [µm^−½].
    pub span: Vec<Polynomial>,
    /// The spectra as polynomials, with what their fits cost.
    pub fits: Vec<Fit>,
    /// Coordinates of each star in the span \[star\]\[polynomial\].
    pub stars: Vec<Vec<f64>>,
}

/// Wavelengths at which spectra are fitted.
const SAMPLES: usize = 512;
/// The part of the accuracy that a spectrum may lose when it is written in the common polynomials.
const SPAN_SHARE: f64 = 0.3;
/// Negligible light relative to the brightest star.
const DARK: f64 = 1e-30;
/// Depths, along each way, at which the certificate looks.
const CERTIFIED: usize = 24;

/// Wavelength of each of the [`SAMPLES`] \[µm\].
fn sampled_lambda(low: f64, high: f64) -> impl Fn(usize) -> f64 {
    move |i| low + (high - low) * i as f64 / (SAMPLES - 1) as f64
}

/// Common polynomials of the spectra of all stars: a singular value decomposition of their fits.
struct CommonSpan {
    fits: Vec<Fit>,
    support_um: (f64, f64),
    /// The norm of each star's spectrum, and one over it; zero for a star that does not shine here.
    brightness: Vec<f64>,
    scale: Vec<f64>,
    singular_values: DVector<f64>,
    /// Right singular vectors \[direction, star\].
    right: DMatrix<f64>,
    /// Directions that are kept.
    rank: usize,
}

impl CommonSpan {
    fn new(fits: Vec<Fit>, (low, high): (f64, f64), accuracy: f64) -> Self {
        // Each of the same brightness, so that faint stars count: their light may be all there is.
        let (step, lambda) = (((high - low) / SAMPLES as f64).sqrt(), sampled_lambda(low, high));
        let sampled = DMatrix::from_fn(SAMPLES, fits.len(), |i, s| step * fits[s].polynomial.at(lambda(i)));
        let brightness: Vec<f64> = sampled.column_iter().map(|c| c.norm()).collect();
        let most = brightness.iter().copied().fold(0.0, f64::max);
        // A star that shines not at all here would be all rounding.
        let scale: Vec<f64> = brightness.iter().map(|b| if *b > DARK * most { 1.0 / b } else { 0.0 }).collect();
        let even = DMatrix::from_fn(SAMPLES, fits.len(), |i, s| sampled[(i, s)] * scale[s]);
        let svd = even.svd(false, true);
        let right = svd.v_t.unwrap_or_else(|| DMatrix::zeros(0, 0));
        let mut span = Self { fits, support_um: (low, high), brightness, scale, singular_values: svd.singular_values, right, rank: 0 };
        span.rank = (0..span.right.nrows()).find(|rank| span.is_enough(*rank, accuracy)).unwrap_or(span.right.nrows());
        span
    }

    /// True if this number of directions leaves less of each star than the error of its fit or of the tolerance.
    fn is_enough(&self, rank: usize, accuracy: f64) -> bool {
        let part = |i: usize, s: usize| (self.singular_values[i] * self.right[(i, s)]).powi(2);
        let left = |s: usize| (rank..self.right.nrows()).map(|i| part(i, s)).sum::<f64>().sqrt();
        self.fits.iter().enumerate().all(|(s, fit)| left(s) <= fit.rms.max(SPAN_SHARE * accuracy))
    }

    /// The polynomial of a direction.
    fn polynomial(&self, direction: usize, degree: usize) -> Polynomial {
        let mut coefficients = vec![0.0; degree + 1];
        for (s, fit) in self.fits.iter().enumerate() {
            let share = self.right[(direction, s)] * self.scale[s] / self.singular_values[direction];
            coefficients.iter_mut().zip(&fit.polynomial.coefficients).for_each(|(sum, c)| *sum += share * c);
        }
        Polynomial { coefficients, interval_um: self.support_um }
    }

    /// A star in the polynomials that are kept.
    fn coordinates(&self, star: usize) -> Vec<f64> {
        (0..self.rank).map(|i| self.brightness[star] * self.singular_values[i] * self.right[(i, star)]).collect()
    }
}

impl Propagation {
    /// The propagation of stars with these `spectra` over λ \[µm\], fitted over the interval `support_um` by
    /// polynomials of so high a `degree`.
    ///
    /// # Errors
    /// If the spectra cannot be fitted.
    pub fn new(
        projection: &Projection,
        spectra: &[&dyn Fn(f64) -> f64],
        support_um: (f64, f64),
        degree: usize,
        accuracy: f64,
    ) -> Result<Self> {
        let (low, high) = support_um;
        let lambda = sampled_lambda(low, high);
        let fit = |spectrum: &&dyn Fn(f64) -> f64| {
            Polynomial::fit(&(0..SAMPLES).map(|i| (lambda(i), spectrum(lambda(i)), 1.0)).collect::<Vec<_>>(), degree)
        };
        let fits = spectra.iter().map(fit).collect::<Result<Vec<Fit>>>()?;
        let common = CommonSpan::new(fits, (low, high), accuracy);
        let span = (0..common.rank).map(|i| common.polynomial(i, degree)).collect();
        let stars = (0..common.fits.len()).map(|star| common.coordinates(star)).collect();
        Ok(Self { products: projection.basis.products(), projection: projection.clone(), span, fits: common.fits, stars })
    }

    /// Elements times polynomials: numbers a voxel and a ray carry.
    pub fn channels(&self) -> usize {
        self.projection.basis.size() * self.span.len()
    }

    /// Adds `amount` of a star's light at depth τ_ℓ to a voxel: element × polynomial.
    pub fn deposit(&self, star: usize, depth: f64, amount: f64, voxel: &mut [f64]) {
        for (q, voxel) in self.projection.at(depth).zip(voxel.chunks_exact_mut(self.span.len())) {
            voxel.iter_mut().zip(&self.stars[star]).for_each(|(v, c)| *v += amount * q * c);
        }
    }

    /// Adds `amount` of a voxel's light, seen through depth τ, to a ray: element × polynomial.
    pub fn accumulate(&self, depth: f64, amount: f64, voxel: &[f64], ray: &mut [f64]) {
        let (n, width) = (self.projection.basis.size(), self.span.len());
        let q: Vec<f64> = self.projection.at(depth).collect();
        for (i, from) in voxel.chunks_exact(width).enumerate() {
            for (j, to) in ray.chunks_exact_mut(width).enumerate() {
                let share: f64 = (0..n).map(|m| q[m] * self.products[(i * n + m) * n + j]).sum();
                to.iter_mut().zip(from).for_each(|(t, f)| *t += amount * share * f);
            }
        }
    }

    /// ∫ R k ω Q_j P dλ for a band of response R k ω [element × polynomial].
    pub fn resolution(&self, response: &Measure) -> Vec<f64> {
        let width = self.span.len();
        let mut resolution = vec![0.0; self.channels()];
        for ((lambda, k), mass) in response.lambda_um.iter().zip(&response.k).zip(&response.mass) {
            for (element, row) in self.projection.basis.elements(*k).iter().zip(resolution.chunks_exact_mut(width)) {
                row.iter_mut().zip(&self.span).for_each(|(r, p)| *r += mass * element * p.at(*lambda));
            }
        }
        resolution
    }

    /// The error of star `s` through a band against what `measure` says, for depths τ + τ_ℓ up to `depth`.
    pub fn certificate(&self, s: usize, resolution: &[f64], measure: &Measure, depth: f64) -> Certificate {
        let of_star = |star_depth: f64| {
            let mut voxel = vec![0.0; self.channels()];
            self.deposit(s, star_depth, 1.0, &mut voxel);
            voxel
        };
        let seen = |voxel: &[f64], view: f64| {
            let mut ray = vec![0.0; self.channels()];
            self.accumulate(view, 1.0, voxel, &mut ray);
            ray.iter().zip(resolution).map(|(v, r)| v * r).sum::<f64>()
        };
        let along = |i: usize| depth * (i as f64 / (CERTIFIED - 1) as f64).powi(2);
        let measure = measure.condensed(depth);
        let one_way = |i: usize| {
            let voxel = of_star(along(i));
            Certificate::behind(&measure, |view| seen(&voxel, view), along(i), depth - along(i))
        };
        let worst = (0..CERTIFIED).map(one_way).reduce(Certificate::or_worse);
        Certificate { depth, ..worst.unwrap_or(Certificate { absolute: 0.0, relative: 0.0, depth }) }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::extinction::Extinction;
    use crate::passband::Passband;
    use crate::quadrature::integrate;
    use crate::rule::{BandProblem, Form, Node, Settings, Source, rule};
    use crate::sed::{BlackBody, PowerLaw};
    use crate::spectrum::Spectrum;
    use crate::units::{Temperature, Wavelength};

    const DEPTH: f64 = 8.0;
    const ACCURACY: f64 = 1e-4;

    fn stars() -> Vec<Spectrum> {
        [3000.0, 5000.0, 8000.0, 12000.0, 20000.0, 40000.0].map(|t| Spectrum::continuous(1.0, Arc::new(BlackBody(Temperature(t))))).to_vec()
    }

    fn flat() -> Spectrum {
        Spectrum::continuous(1.0, Arc::new(PowerLaw { reference: Wavelength(1.0), exponent: 0.0 }))
    }

    fn propagation(band: &Passband, stars: &[Spectrum], size: usize) -> Propagation {
        let law = Extinction::by_name("ccm89").unwrap();
        let sources: Vec<Source> = stars.iter().map(|s| Source::new("star", band, s, &*law, |_| 1.0)).collect();
        let k = |l: f64| law.k(l);
        let domain = band.support_um();
        let settings = Settings { count: Some(size), ..Settings::default() };
        let pivot = Node { lambda_um: band.pivot().0, k: k(band.pivot().0) };
        let problem = BandProblem {
            sources: &sources,
            domain_um: domain,
            common_um: domain,
            pivot,
            k: &k,
            depth: DEPTH,
            accuracy: ACCURACY,
            settings: &settings,
            interrupted: &|| false,
        };
        let solved = (rule("projection").unwrap().solve)(&problem).unwrap();
        let Form::Projection(projection) = solved.form else { panic!("another form") };
        let continua: Vec<_> = stars.iter().map(|s| move |l: f64| s.continuum(l)).collect();
        let spectra: Vec<&dyn Fn(f64) -> f64> = continua.iter().map(|c| c as &dyn Fn(f64) -> f64).collect();
        Propagation::new(&projection, &spectra, domain, 5, ACCURACY).unwrap()
    }

    /// Six stars in one voxel, seen through dust, against the adaptive integral of all; each further element helps.
    #[test]
    fn many_lights_become_one() {
        let band = Passband::by_name("johnson-V").unwrap();
        let law = Extinction::by_name("ccm89").unwrap();
        let stars = stars();
        let (low, high) = band.support_um();
        let mut before = f64::MAX;
        for size in 2..=5 {
            let propagation = propagation(&band, &stars, size);
            let response = Source::new("response", &band, &flat(), &*law, |_| 1.0).measure;
            let resolution = propagation.resolution(&response);
            let mut worst: f64 = 0.0;
            for view in [0.0, 0.3, 1.1, 3.0] {
                let (mut voxel, mut ray) = (vec![0.0; propagation.channels()], vec![0.0; propagation.channels()]);
                let depth = |s: usize| 0.4 + 0.7 * s as f64;
                let amount = |s: usize| 1.0 / stars[s].continuum(0.55);
                (0..stars.len()).for_each(|s| propagation.deposit(s, depth(s), amount(s), &mut voxel));
                propagation.accumulate(view, 1.0, &voxel, &mut ray);
                let value: f64 = ray.iter().zip(&resolution).map(|(v, r)| v * r).sum();
                let light =
                    |l: f64| (0..stars.len()).map(|s| amount(s) * stars[s].continuum(l) * (-depth(s) * law.k(l)).exp()).sum::<f64>();
                let truth = integrate(|l| band.response(l) * light(l) * (-view * law.k(l)).exp(), low, high, 1e-9);
                worst = worst.max((value / truth - 1.0).abs());
            }
            assert!(worst < 0.5 * before, "{size} elements: {worst:e} after {before:e}");
            before = worst;
        }
        assert!(before < 1e-4, "{before:e}");
    }

    /// The certificates hold at depths that they did not look at, and they are not idle: some depth comes near each.
    #[test]
    fn certificates_hold() {
        let band = Passband::by_name("johnson-B").unwrap();
        let law = Extinction::by_name("ccm89").unwrap();
        let stars = stars();
        let propagation = propagation(&band, &stars, 3);
        let resolution = propagation.resolution(&Source::new("response", &band, &flat(), &*law, |_| 1.0).measure);
        for (s, star) in stars.iter().enumerate() {
            let measure = Source::new("star", &band, star, &*law, |_| 1.0).measure;
            let certificate = propagation.certificate(s, &resolution, &measure, DEPTH);
            let mut worst: f64 = 0.0;
            for i in 0..40 {
                let star_depth = DEPTH * f64::from(i) / 41.0;
                let mut voxel = vec![0.0; propagation.channels()];
                propagation.deposit(s, star_depth, 1.0, &mut voxel);
                for j in 0..40 {
                    let view = (DEPTH - star_depth) * f64::from(j) / 39.0;
                    let mut ray = vec![0.0; propagation.channels()];
                    propagation.accumulate(view, 1.0, &voxel, &mut ray);
                    let value: f64 = ray.iter().zip(&resolution).map(|(v, r)| v * r).sum();
                    worst = worst.max((value - measure.at(star_depth + view)).abs() / measure.total());
                }
            }
            assert!(worst <= certificate.absolute, "star {s}: {worst:e} {:e}", certificate.absolute);
            assert!(worst > 0.5 * certificate.absolute, "star {s}: {worst:e} {:e}", certificate.absolute);
        }
    }

    /// Black bodies need few polynomials, whatever their number; equal stars one.
    #[test]
    fn the_span_does_not_grow_with_the_stars() {
        let band = Passband::by_name("johnson-V").unwrap();
        let many: Vec<Spectrum> =
            (0..40).map(|i| Spectrum::continuous(1.0, Arc::new(BlackBody(Temperature(3000.0 + 900.0 * f64::from(i)))))).collect();
        let width = propagation(&band, &many, 3).span.len();
        assert!(width <= 5, "{width}");
        // Dark stars add nothing, and nothing but dark stars is nothing.
        let cold = |t: f64| Spectrum::continuous(1.0, Arc::new(BlackBody(Temperature(t))));
        let with_dark = propagation(&band, &[many[7].clone(), cold(20.0), cold(50.0)], 3);
        assert!(with_dark.span.len() == 1 && with_dark.stars[0][0].abs() > 0.0 && with_dark.stars.iter().flatten().all(|c| c.is_finite()));
        // A star unlike the others keeps a direction of its own, however many those are.
        let mut odd = vec![many[7].clone(); 20];
        odd.push(many[0].clone());
        let spanned = propagation(&band, &odd, 3);
        let rebuilt = |l: f64| spanned.stars[20].iter().zip(&spanned.span).map(|(c, p)| c * p.at(l)).sum::<f64>();
        for l in [0.5, 0.55, 0.6] {
            assert!((rebuilt(l) / odd[20].continuum(l) - 1.0).abs() < 1e-3, "{l}: {}", rebuilt(l) / odd[20].continuum(l));
        }
        let equal = vec![many[7].clone(), many[7].clone().scaled(1e-6)];
        assert_eq!(propagation(&band, &equal, 3).span.len(), 1);
    }
}
