//! Phase functions: how scattered light is spread over angle.
//!
//! Conventions: cos θ = +1 is forward scattering; ∫ p dΩ = 1; unit sr⁻¹. A phase function is one file and one row of
//! [`KINDS`].

mod draine;
mod henyey_greenstein;
mod isotropic;
mod rayleigh;
mod tabulated;

use std::sync::Arc;

pub use draine::Draine;
pub use henyey_greenstein::HenyeyGreenstein;
pub use isotropic::Isotropic;
pub use rayleigh::Rayleigh;
pub use tabulated::Tabulated;
pub(crate) use tabulated::read as tabulated;

use spectra::curve::Ordinate;
use spectra::extinction::Extinction;
use spectra::fingerprint::Digest;
use spectra::table::Table;

use crate::curve;
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::properties::{Key, KeyRow, Number, Path, Section, chosen};
use crate::random::Counter;

/// Angular distribution of scattered light, normalised over the sphere.
///
/// # Examples
/// Forward scattering with p = (1 + cos θ)/4π:
///
/// ```
/// use barnard_scene::phase::Phase;
/// use barnard_scene::random::Counter;
///
/// #[derive(Debug)]
/// struct Linear;
///
/// impl Phase for Linear {
///     fn at(&self, cosine: f64, _lambda_um: f64) -> f64 {
///         (1.0 + cosine) / (4.0 * std::f64::consts::PI)
///     }
///     fn sample(&self, _lambda_um: f64, random: &mut Counter) -> f64 {
///         // The inverse of the cumulative distribution (1 + cos θ)²/4.
///         2.0 * random.uniform().sqrt() - 1.0
///     }
///     fn is_spectral(&self) -> bool {
///         false
///     }
/// }
///
/// let sphere: f64 = (0..1000).map(|i| Linear.at((i as f64 + 0.5) / 500.0 - 1.0, 0.55) / 500.0).sum::<f64>() * 2.0 * std::f64::consts::PI;
/// assert!((sphere - 1.0).abs() < 1e-9);
/// ```
pub trait Phase: std::fmt::Debug + Send + Sync {
    /// Adds the content to a digest. The default distinguishes objects by address.
    fn content(&self, digest: &mut Digest) {
        digest.object(self);
    }
    /// The phase function p(cos θ, λ) [sr⁻¹]; λ \[µm\].
    fn at(&self, cosine: f64, lambda_um: f64) -> f64;
    /// A cos θ drawn with the density 2π p.
    fn sample(&self, lambda_um: f64, random: &mut Counter) -> f64;
    /// True if the function is 1/4π for every angle.
    fn is_isotropic(&self) -> bool {
        false
    }
    /// True if the function changes with wavelength.
    fn is_spectral(&self) -> bool;
}

/// One row of the catalogue; the scene's extinction law may bring its own mean cosine.
pub struct PhaseKind {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// The keys that it takes.
    pub keys: &'static [KeyRow],
    /// Makes the phase function from a table of a scene.
    pub build: fn(&Section, &Inputs, &Extinction) -> Result<Arc<dyn Phase>>,
}

/// All phase functions that a scene may name.
pub const KINDS: &[PhaseKind] = &[isotropic::KIND, henyey_greenstein::KIND, draine::KIND, rayleigh::KIND, tabulated::KIND];

/// Reads a `[dust.phase]` table.
///
/// # Errors
/// If a key is unknown, missing or wrong; the error states its place.
pub fn build(section: &Section, inputs: &Inputs, extinction: &Extinction) -> Result<Arc<dyn Phase>> {
    let kind = chosen("phase function", KINDS, |k| (k.name, k.keys), &[], section)?;
    (kind.build)(section, inputs, extinction)
}

/// Argument for a phase function: one, or one that is shared.
pub trait IntoPhase {
    /// The phase function as it is shared between its users.
    fn into_phase(self) -> Arc<dyn Phase>;
}

impl<P: Phase + 'static> IntoPhase for P {
    fn into_phase(self) -> Arc<dyn Phase> {
        Arc::new(self)
    }
}

impl IntoPhase for Arc<dyn Phase> {
    fn into_phase(self) -> Arc<dyn Phase> {
        self
    }
}

/// A mean cosine g(λ) \[1\].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum MeanCosine {
    /// A mean cosine that is the same at every wavelength.
    Constant(f64),
    /// A table of mean cosines over λ \[µm\].
    Table(Table),
}

/// The largest |g|: beyond it hardly any light is thrown to the side at all.
const MAX_COSINE: f64 = 0.999;

/// Key of a constant g.
const fn mean_cosine(summary: &'static str) -> Key<Number> {
    Key::number("g", summary).range(-MAX_COSINE..=MAX_COSINE).otherwise("the law's own").excludes("g_file")
}

const G: Key<Number> = mean_cosine("mean cosine");
const G_FILE: Key<Path> = Key::path("g_file", "text, ECSV, VOTable or FITS table of wavelength and g");

impl From<f64> for MeanCosine {
    fn from(g: f64) -> Self {
        MeanCosine::Constant(g)
    }
}

impl From<Table> for MeanCosine {
    fn from(g: Table) -> Self {
        MeanCosine::Table(g)
    }
}

impl MeanCosine {
    fn add_to(&self, digest: &mut Digest) {
        match self {
            Self::Constant(g) => drop(digest.text("constant").number(*g)),
            Self::Table(table) => table.add_to(digest.text("table")),
        }
    }

    /// Validated mean cosine, between −0.999 and 0.999.
    fn checked(self) -> Result<Self> {
        let far = |g: &&f64| g.is_nan() || g.abs() > MAX_COSINE;
        let wrong = match &self {
            MeanCosine::Constant(g) => Some(g).filter(far),
            MeanCosine::Table(table) => table.y().iter().find(far),
        };
        match wrong {
            Some(g) => Err(Error::out_of_range("mean cosine", g, format!("between -{MAX_COSINE} and {MAX_COSINE}"))),
            None => Ok(self),
        }
    }

    fn at(&self, lambda_um: f64) -> f64 {
        match self {
            MeanCosine::Constant(g) => *g,
            MeanCosine::Table(table) => table.at(lambda_um),
        }
    }

    /// Reads the mean cosine from the key `g`, from a file, or from the law's own table.
    fn read(section: &Section, inputs: &Inputs, extinction: &Extinction) -> Result<Self> {
        if let Some(g) = section.read(&G)? {
            return Ok(MeanCosine::Constant(g));
        }
        if section.has(&G_FILE) {
            let table = curve::read(section, &G_FILE, Ordinate::MeanCosine, inputs)?.table;
            return section.wrap(&G_FILE, MeanCosine::Table(table).checked());
        }
        let cosines = extinction.dust_table().map(|t| MeanCosine::Table(t.mean_cosine.clone()));
        cosines.ok_or_else(|| {
            section.error(
                &G,
                format!(
                    "g is required, because law \"{}\" does not define a mean cosine; write one such as g = 0.5, or g_file",
                    extinction.name
                ),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use spectra::quadrature::integrate;

    use super::*;

    fn henyey(g: f64) -> HenyeyGreenstein {
        HenyeyGreenstein::new(g).unwrap()
    }

    fn draine_of(g: f64, alpha: f64) -> Draine {
        Draine::new(g, alpha).unwrap()
    }

    fn all() -> Vec<Arc<dyn Phase>> {
        // A row for each kind, then values that are harder than those.
        const TABLE: &str = "# wavelength_um: 0.4, 0.7\n-1, 0.1, 2\n0.2, 0.5, 1\n1, 4, 0\n";
        let law = Extinction::by_name("ccm89").unwrap();
        let row = |kind: &PhaseKind| (kind.name, kind.keys);
        let kinds = crate::fixtures::of_every_kind(KINDS, row, TABLE, |section, inputs| build(section, inputs, &law));
        let harder: [Arc<dyn Phase>; 5] = [
            Arc::new(henyey(-0.3)),
            Arc::new(draine_of(0.5, 1.0)),
            Arc::new(draine_of(-0.6, 3.0)),
            Arc::new(henyey(5e-5)),
            Arc::new(tabulated::two_columns()),
        ];
        kinds.into_iter().map(|(_, phase)| phase).chain(harder).collect()
    }

    #[test]
    fn every_phase_function_integrates_to_one() {
        for phase in all() {
            let sum = 2.0 * PI * integrate(|mu| phase.at(mu, 0.55), -1.0, 1.0, 1e-10);
            assert!((sum - 1.0).abs() < 1e-8, "{phase:?}: {sum}");
        }
    }

    /// Drawn cosines fall into 32 equal steps of cos θ as often as the function's integrals over them say: χ² of 31
    /// degrees of freedom.
    #[test]
    fn phase_functions_are_sampled() {
        const STEPS: usize = 32;
        const DRAWN: usize = 200_000;
        let statistic = |drawn: &dyn Phase, expected: &dyn Phase| -> f64 {
            let mut counts = [0.0; STEPS];
            let mut random = Counter::new(11, 5);
            for _ in 0..DRAWN {
                let cosine = drawn.sample(0.5, &mut random);
                assert!((-1.0..=1.0).contains(&cosine));
                counts[((0.5 * (cosine + 1.0) * STEPS as f64) as usize).min(STEPS - 1)] += 1.0;
            }
            let end = |i: usize| 2.0 * i as f64 / STEPS as f64 - 1.0;
            let share = |i: usize| 2.0 * PI * integrate(|mu| expected.at(mu, 0.5), end(i), end(i + 1), 1e-8);
            counts.iter().enumerate().map(|(i, n)| (n - DRAWN as f64 * share(i)).powi(2) / (DRAWN as f64 * share(i))).sum()
        };
        // 61.1 is passed once in a thousand times.
        for phase in all() {
            let chi = statistic(&*phase, &*phase);
            assert!(chi < 61.1, "{phase:?}: {chi}");
        }
        // It sees a sign that is wrong, and a small asymmetry.
        let [forward, backward, flat, slight] = [0.3, -0.3, 0.0, 0.02].map(henyey);
        assert!(statistic(&forward, &backward) > 1e3 && statistic(&flat, &slight) > 61.1);
    }

    /// ⟨cos θ⟩ = g for Henyey–Greenstein; forward is +1.
    #[test]
    fn mean_cosines() {
        let mean = |phase: &dyn Phase| 2.0 * PI * integrate(|mu| mu * phase.at(mu, 0.55), -1.0, 1.0, 1e-10);
        assert!((mean(&henyey(0.6)) - 0.6).abs() < 1e-8);
        assert!(mean(&Rayleigh).abs() < 1e-10);
        // Draine 2003, eq. 5: g_D = g (1 + α(3 + 2g²)/5) / (1 + α(1 + 2g²)/3).
        let (g, a) = (0.5f64, 1.0f64);
        let expected = g * (1.0 + a * (3.0 + 2.0 * g * g) / 5.0) / (1.0 + a * (1.0 + 2.0 * g * g) / 3.0);
        assert!((mean(&draine_of(g, a)) - expected).abs() < 1e-8);
    }

    /// What no phase function can have is refused by name.
    #[test]
    fn impossible_numbers_are_refused() {
        for wrong in [HenyeyGreenstein::new(1.0).map(drop), HenyeyGreenstein::new(f64::NAN).map(drop), Draine::new(-1.5, 1.0).map(drop)] {
            assert!(wrong.unwrap_err().to_string().contains("mean cosine"));
        }
        assert!(Draine::new(0.5, -1.0).unwrap_err().to_string().contains("alpha"));
    }

    #[test]
    fn no_asymmetry_is_isotropic() {
        let flat = henyey(0.0);
        assert!((flat.at(0.3, 0.5) - 1.0 / (4.0 * PI)).abs() < 1e-15);
    }
}
