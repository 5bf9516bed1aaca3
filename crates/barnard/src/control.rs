//! Progress and interruption of long work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// What is being done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Depths between stars and cells.
    StarDepths,
    /// Starlight put into voxels.
    Light,
    /// Rays of the image.
    Rays,
}

/// Hears of (stage, done, all).
type Listener = dyn Fn(Stage, u64, u64) + Send + Sync;

/// Hears of progress and can stop the work.
#[derive(Clone, Default)]
pub struct Control {
    stop: Arc<AtomicBool>,
    listener: Option<Arc<Listener>>,
}

impl Control {
    /// With a listener of (stage, done, all).
    pub fn with_listener(listener: impl Fn(Stage, u64, u64) + Send + Sync + 'static) -> Self {
        Self { stop: Arc::default(), listener: Some(Arc::new(listener)) }
    }

    /// Stops the work at its next look.
    pub fn interrupt(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// An error once the work was interrupted.
    pub fn check(&self) -> Result<()> {
        if self.stop.load(Ordering::Relaxed) { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// Tells the listener.
    pub fn report(&self, stage: Stage, done: u64, all: u64) {
        if let Some(listener) = &self.listener {
            listener(stage, done, all);
        }
    }
}
