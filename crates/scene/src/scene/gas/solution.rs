//! Solution of a gas, from a cache or anew.

use ionisation::balance::Accuracy;
use ionisation::cloud::{Ionised, Quantity};
use ionisation::error::IonisationError;
use ionisation::tracer::RayTracer;
use spectra::fingerprint::{Digest, Fingerprint};

use super::GasCloud;
use crate::cache::{Cache, GAS, Record};
use crate::control::Control;

/// Means by which a gas is solved.
pub(in crate::scene) struct Solver<'a> {
    pub is_rough: bool,
    pub memory_limit: u64,
    pub tracer: Option<&'a dyn RayTracer>,
    pub cache: Option<&'a dyn Cache>,
    pub control: &'a Control,
}

/// Solved cloud, with what is stored of it.
pub(super) struct Solved {
    /// Mean of each stored quantity by voxel.
    pub quantities: Vec<Vec<f32>>,
    /// Electron temperature, weighted by n_p n_e \[K\]; `None` where no gas is ionised.
    pub temperature: Option<f64>,
    /// Electron density, weighted by n_p n_e \[cm⁻³\]; `None` where no gas is ionised.
    pub electrons: Option<f64>,
    /// Passes, their last change, escaped photons and unsettled steps; without quantities.
    pub state: Ionised,
}

/// Problem of a cloud: scalars, and an array for each quantity. Each has a record of its own, so that the quantities of one filter
/// serve another.
pub(super) struct Solution<'a> {
    pub cloud: &'a GasCloud,
    /// Names of the stored quantities.
    pub names: &'a [String],
    /// Index of n_p n_e among the stored quantities.
    pub pairs: usize,
    pub accuracy: Accuracy,
}

impl Solution<'_> {
    /// Ionised state: that of the cache if it has all of it, otherwise a new one, which is stored. After the stored quantities,
    /// `quantities` has the products of n_p n_e with the electron temperature and with the electron density.
    pub fn found(&self, quantities: &[Quantity], solver: &Solver) -> Result<Solved, IonisationError> {
        // Light of one star goes through the gas on the processor.
        let tracer = solver.tracer.filter(|_| self.cloud.stars.len() > 1);
        let solve = || Ok(self.reduced(self.cloud.ionised(quantities, self.accuracy, tracer, solver.control)?));
        let Some(cache) = solver.cache.filter(|_| !self.cloud.stars.is_empty()) else { return solve() };
        let content = self.fingerprint(tracer);
        // A result of the processor serves a device as well.
        if let Some(known) = self.known(cache, content).or_else(|| self.known(cache, self.fingerprint(None))) {
            return Ok(known);
        }
        let found = solve()?;
        // A device that failed halfway leaves the work to the processor.
        if tracer.is_none_or(|tracer| tracer.name() == found.state.by) {
            self.store(cache, content, &found);
        }
        Ok(found)
    }

    /// Solution with means of the quantities that are not stored.
    fn reduced(&self, mut state: Ionised) -> Solved {
        let mut quantities = std::mem::take(&mut state.quantities);
        let products = quantities.split_off(self.names.len());
        let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
        let pairs = sum(&quantities[self.pairs]);
        let mut means = products.iter().map(|product| Some(sum(product) / pairs).filter(|mean| mean.is_finite()));
        let (temperature, electrons) = (means.next().flatten(), means.next().flatten());
        Solved { quantities, temperature, electrons, state }
    }

    /// Fingerprint of the cloud, the accuracy, and whether a device traces its light. Light of stars has single precision, in which
    /// processors agree.
    fn fingerprint(&self, tracer: Option<&dyn RayTracer>) -> Fingerprint {
        let GasCloud { lattice, hydrogen, abundances, dust_cm2, isothermal, diffuse, stars, memory_limit: _ } = self.cloud;
        let mut digest = Digest::new("ionised cloud");
        digest.plain(lattice).singles(hydrogen).numbers(abundances).number(*dust_cm2).plain(isothermal).plain(diffuse);
        for star in stars {
            digest.singles(&rounded(&star.position.to_array())).singles(&rounded(&star.light.energies_ev));
            digest.singles(&rounded(&star.light.photons));
            for nodes in star.light.weakening.iter().chain(&star.light.warming) {
                digest.singles(&rounded(nodes));
            }
        }
        digest.plain(&self.accuracy).plain(&tracer.is_some()).finish()
    }

    fn known(&self, cache: &dyn Cache, content: Fingerprint) -> Option<Solved> {
        let Record { text: by, numbers, .. } = cache.get(GAS, content)?;
        let [temperature, electrons, passes, change, steps, unsettled, escaped @ ..] = &numbers[..] else { return None };
        let quantity = |name: &String| {
            let array = cache.get(GAS, quantity(content, name))?.arrays.pop()?;
            (array.len() == self.cloud.hydrogen.len()).then(|| array.to_vec())
        };
        Some(Solved {
            quantities: self.names.iter().map(quantity).collect::<Option<_>>()?,
            temperature: Some(*temperature).filter(|mean| mean.is_finite()),
            electrons: Some(*electrons).filter(|mean| mean.is_finite()),
            state: Ionised {
                quantities: Vec::new(),
                passes: *passes as usize,
                change: *change,
                escaped: escaped.to_vec(),
                steps: *steps as u64,
                unsettled: *unsettled as u64,
                by,
            },
        })
    }

    fn store(&self, cache: &dyn Cache, content: Fingerprint, found: &Solved) {
        let Solved { quantities, temperature, electrons, state } = found;
        for (name, values) in self.names.iter().zip(quantities) {
            cache.put(
                GAS,
                quantity(content, name),
                &Record { text: name.clone(), arrays: vec![values.clone().into()], ..Record::default() },
            );
        }
        let means = [temperature, electrons].map(|mean| mean.unwrap_or(f64::NAN));
        let Ionised { passes, change, steps, unsettled, .. } = state;
        let numbers = [&means[..], &[*passes as f64, *change, *steps as f64, *unsettled as f64], &state.escaped].concat();
        cache.put(GAS, content, &Record { text: state.by.clone(), numbers, arrays: Vec::new() });
    }
}

/// Numbers in single precision.
fn rounded(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|number| *number as f32).collect()
}

/// Fingerprint of a quantity of a cloud.
fn quantity(cloud: Fingerprint, name: &str) -> Fingerprint {
    Digest::new("quantity").part(cloud).text(name).finish()
}
