//! Solution of a gas, from a cache or anew.

use ionisation::balance::Accuracy;
use ionisation::cloud::{Ionised, Quantity};
use ionisation::error::IonisationError;
use ionisation::tracer::RayTracer;
use spectra::fingerprint::{Digest, Fingerprint};

use super::GasCloud;
use crate::cache::{Cache, Record};
use crate::control::Control;

/// Kind of the records.
const KIND: &str = "gas";

/// Means by which a gas is solved.
pub(in crate::scene) struct Solver<'a> {
    pub is_rough: bool,
    pub memory_limit: u64,
    pub tracer: Option<&'a dyn RayTracer>,
    pub cache: Option<&'a dyn Cache>,
    pub control: &'a Control,
}

/// Solution of a cloud: scalars, and an array for each quantity. Each has a record of its own, so that the quantities of one filter
/// serve another.
pub(super) struct Solution<'a> {
    pub cloud: &'a GasCloud,
    /// Names of the quantities.
    pub names: &'a [String],
    pub accuracy: Accuracy,
}

impl Solution<'_> {
    /// Ionised state: that of the cache if it has all of it, otherwise a new one, which is stored.
    pub fn found(&self, quantities: &[Quantity], solver: &Solver) -> Result<Ionised, IonisationError> {
        // Light of one star goes through the gas on the processor.
        let tracer = solver.tracer.filter(|_| self.cloud.stars.len() > 1);
        let solve = || self.cloud.ionised(quantities, self.accuracy, tracer, solver.control);
        let Some(cache) = solver.cache.filter(|_| !self.cloud.stars.is_empty()) else { return solve() };
        let content = self.fingerprint(tracer);
        if let Some(known) = self.known(cache, content) {
            return Ok(known);
        }
        let found = solve()?;
        // A device that failed halfway leaves the work to the processor.
        if tracer.is_none_or(|tracer| tracer.name() == found.by) {
            self.store(cache, content, &found);
        }
        Ok(found)
    }

    /// Fingerprint of the cloud, the accuracy, and whether a device traces its light.
    fn fingerprint(&self, tracer: Option<&dyn RayTracer>) -> Fingerprint {
        let GasCloud { lattice, hydrogen, abundances, dust_cm2, isothermal, diffuse, stars, memory_limit: _ } = self.cloud;
        let mut digest = Digest::new("ionised cloud");
        digest.plain(lattice).singles(hydrogen).numbers(abundances).number(*dust_cm2).plain(isothermal).plain(diffuse);
        for star in stars {
            digest.numbers(&star.position.to_array()).plain(&star.light);
        }
        digest.plain(&self.accuracy).plain(&tracer.is_some()).finish()
    }

    fn known(&self, cache: &dyn Cache, content: Fingerprint) -> Option<Ionised> {
        let Record { text: by, numbers, .. } = cache.get(KIND, content)?;
        let [passes, change, steps, unsettled, escaped @ ..] = &numbers[..] else { return None };
        let quantity = |name: &String| {
            let array = cache.get(KIND, quantity(content, name))?.arrays.pop()?;
            (array.len() == self.cloud.hydrogen.len()).then(|| array.to_vec())
        };
        Some(Ionised {
            quantities: self.names.iter().map(quantity).collect::<Option<_>>()?,
            passes: *passes as usize,
            change: *change,
            escaped: escaped.to_vec(),
            steps: *steps as u64,
            unsettled: *unsettled as u64,
            by,
        })
    }

    fn store(&self, cache: &dyn Cache, content: Fingerprint, found: &Ionised) {
        let Ionised { quantities, passes, change, escaped, steps, unsettled, by } = found;
        for (name, values) in self.names.iter().zip(quantities) {
            cache.put(KIND, quantity(content, name), &Record { arrays: vec![values.clone().into()], ..Record::default() });
        }
        let numbers = [&[*passes as f64, *change, *steps as f64, *unsettled as f64], &escaped[..]].concat();
        cache.put(KIND, content, &Record { text: by.clone(), numbers, arrays: Vec::new() });
    }
}

/// Fingerprint of a quantity of a cloud.
fn quantity(cloud: Fingerprint, name: &str) -> Fingerprint {
    Digest::new("quantity").part(cloud).text(name).finish()
}
