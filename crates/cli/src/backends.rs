//! The back ends that this program was built with.

use std::ffi::OsStr;
use std::sync::Arc;

#[cfg(feature = "gpu")]
use barnard::backend::DeviceUse;
use barnard::backend::Registry;
use barnard::scene::RayTracer;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};

/// All back ends that this program was built with.
pub fn registry() -> Registry {
    let registry = Registry::default();
    #[cfg(feature = "gpu")]
    let registry = registry.with(barnard_gpu::BACKENDS);
    registry
}

/// Tracer of ionising starlight of a back end: its device, which is opened once there is such gas.
pub fn tracer(backend: &str) -> Option<Arc<dyn RayTracer>> {
    #[cfg(feature = "gpu")]
    if registry().by_name(backend).is_ok_and(|entry| entry.device != DeviceUse::Never) {
        return Some(Arc::new(barnard_gpu::IonisingRays::once_asked()));
    }
    let _ = backend;
    None
}

/// The back ends that a program without feature `gpu` lacks.
#[cfg(not(feature = "gpu"))]
const LACKING: &[&str] = &["gpu", "auto"];
#[cfg(feature = "gpu")]
const LACKING: &[&str] = &[];

/// Reads the name of a back end; of those that this program could have had it says how they are built.
#[derive(Clone)]
pub struct BackendName {
    known: PossibleValuesParser,
    lacking: &'static [&'static str],
}

/// The names of the back ends for the command line; of those that read a plan alone where `planned`.
pub fn names(planned: bool) -> BackendName {
    let all_backends = registry();
    let rows = all_backends.entries().iter().filter(|entry| entry.planned || !planned);
    let known = rows.map(|entry| PossibleValue::new(entry.name).help(entry.summary)).collect::<Vec<_>>();
    BackendName { known: PossibleValuesParser::new(known), lacking: LACKING }
}

impl TypedValueParser for BackendName {
    type Value = String;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<String, Error> {
        let Some(name) = self.lacking.iter().find(|name| value == **name) else {
            return self.known.parse_ref(command, argument, value);
        };
        let words = format!("this build has no back end {name}; build it with: cargo run --release -F gpu -- ...\n");
        Err(Error::raw(ErrorKind::InvalidValue, words).with_cmd(command))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        self.known.possible_values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_program_lacks_is_said_with_how_to_build_it() {
        let parser = BackendName { known: PossibleValuesParser::new(["cpu"]), lacking: &["gpu"] };
        let read = |name: &str| parser.parse_ref(&Command::new("barnard"), None, OsStr::new(name));
        assert_eq!(read("cpu").unwrap(), "cpu");
        let lacking = read("gpu").unwrap_err().to_string();
        assert!(lacking.contains("no back end gpu") && lacking.contains("-F gpu"), "{lacking}");
        let unknown = read("cpus").unwrap_err().to_string();
        assert!(!unknown.contains("-F gpu"), "{unknown}");
    }
}
