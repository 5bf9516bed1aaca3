//! The back ends that this program was built with.

use barnard::backend::Registry;
use clap::builder::PossibleValue;
use clap::builder::PossibleValuesParser;

/// All of them.
pub fn registry() -> Registry {
    let registry = Registry::default();
    #[cfg(feature = "gpu")]
    let registry = registry.with(barnard_gpu::BACKENDS);
    registry
}

/// Their names, for the command line; those that read a plan alone where `planned`.
pub fn names(planned: bool) -> PossibleValuesParser {
    let own = registry();
    let rows = own.entries().iter().filter(|entry| entry.planned || !planned);
    PossibleValuesParser::new(rows.map(|entry| PossibleValue::new(entry.name).help(entry.summary)).collect::<Vec<_>>())
}
