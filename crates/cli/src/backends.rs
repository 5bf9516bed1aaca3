//! The back ends that this program was built with.

use barnard::backend::Registry;
use clap::builder::PossibleValue;
use clap::builder::PossibleValuesParser;

/// All back ends that this program was built with.
pub fn registry() -> Registry {
    let registry = Registry::default();
    #[cfg(feature = "gpu")]
    let registry = registry.with(barnard_gpu::BACKENDS);
    registry
}

/// The names of the back ends for the command line; of those that read a plan alone where `planned`.
pub fn names(planned: bool) -> PossibleValuesParser {
    let own = registry();
    let rows = own.entries().iter().filter(|entry| entry.planned || !planned);
    PossibleValuesParser::new(rows.map(|entry| PossibleValue::new(entry.name).help(entry.summary)).collect::<Vec<_>>())
}
