//! What a plan is made by beside the scene: what a program allows, and the method that is in force.

use std::sync::Arc;

use crate::memory;
use crate::plan::ordinates;
use crate::scene::{Method, Scene};

/// What a program may decide beside the scene.
#[derive(Debug, Clone)]
pub struct Options {
    /// Most bytes a plan may take.
    pub memory_limit: u64,
    /// What sweeps light that is scattered more than once; the processor where it is not said.
    pub sweeper: Option<Arc<dyn ordinates::Sweeper>>,
}

impl Default for Options {
    /// On the processor alone.
    fn default() -> Self {
        Self { memory_limit: memory::DEFAULT_LIMIT, sweeper: None }
    }
}

impl Options {
    /// On the processor alone, with so much memory \[bytes\].
    pub fn within(memory_limit: u64) -> Self {
        Self { memory_limit, ..Self::default() }
    }
}

/// What a plan is made by: the method that is in force, which need not be the scene's while a rule is made finer, and
/// what it may take.
#[derive(Debug, Clone)]
pub(crate) struct Settings {
    /// Spectral rule and accuracy.
    pub method: Method,
    /// Most bytes a plan may take.
    pub memory_limit: u64,
    /// What sweeps light that is scattered more than once.
    pub sweeper: Option<Arc<dyn ordinates::Sweeper>>,
}

impl Settings {
    /// The scene's own method.
    pub fn of(scene: &Scene, options: &Options) -> Self {
        Self { method: scene.method.clone(), memory_limit: options.memory_limit, sweeper: options.sweeper.clone() }
    }
}
