//! Progress and interruption of long work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::{Error, Result};

/// Share of the work per report of progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Stars ionise gas.
    Gas,
    /// Depths between stars and cells.
    StarDepths,
    /// Light is solved in voxels or cells.
    Light,
    /// Rays of the image are marched.
    Rays,
    /// Frames of an instrument are read out.
    Frames,
}

impl Stage {
    /// All stages, in the order of a picture.
    pub const ALL: [Self; 5] = [Self::Gas, Self::StarDepths, Self::Light, Self::Rays, Self::Frames];

    /// Name of the work.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gas => "ionised gas",
            Self::StarDepths => "star depths",
            Self::Light => "light",
            Self::Rays => "rays",
            Self::Frames => "frames",
        }
    }
}

/// Steps of work that has parts.
const WHOLE: u64 = 10_000;

/// Hears of (stage, done, all).
type Listener = dyn Fn(Stage, u64, u64) + Send + Sync;

/// Hears of progress and can stop the work.
#[derive(Clone, Default)]
pub struct Control {
    stop: Arc<AtomicBool>,
    listener: Option<Arc<Listener>>,
}

impl std::fmt::Debug for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Control(interrupted: {})", self.interrupted())
    }
}

impl Control {
    /// A control whose listener receives every step as (stage, done, all).
    pub fn with_listener(listener: impl Fn(Stage, u64, u64) + Send + Sync + 'static) -> Self {
        Self { stop: Arc::default(), listener: Some(Arc::new(listener)) }
    }

    /// A control for work that is a part of more: its progress runs from `first` to `last` \[1\] of the whole, and
    /// never back.
    pub fn part(&self, first: f64, last: f64) -> Self {
        let Some(listener) = self.listener.clone() else { return self.clone() };
        let highest = AtomicU64::new(0);
        let heard = move |stage, done: u64, all: u64| {
            let share = (done as f64 / all.max(1) as f64).min(1.0);
            let now = ((first + (last - first) * share) * WHOLE as f64) as u64;
            listener(stage, highest.fetch_max(now, Ordering::Relaxed).max(now), WHOLE);
        };
        Self { stop: self.stop.clone(), listener: Some(Arc::new(heard)) }
    }

    /// Stops the work at its next look.
    pub fn interrupt(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// True if the work was interrupted: what is worked out from now on is thrown away, and may be anything.
    pub fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// An error once the work was interrupted.
    ///
    /// # Errors
    /// [`Interrupted`](Error::Interrupted), once the user wished to stop.
    pub fn check(&self) -> Result<()> {
        if self.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// Tells the listener that `done` of `all` steps of a stage are done.
    pub fn report(&self, stage: Stage, done: u64, all: u64) {
        if let Some(listener) = &self.listener {
            listener(stage, done, all);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    /// Parts of parts run on from where others ended, never back, and stop with the whole.
    #[test]
    fn parts_make_a_whole() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let ears = heard.clone();
        let control = Control::with_listener(move |_, done, all| ears.lock().unwrap().push(done as f64 / all as f64));
        for half in [(0.0, 0.5), (0.5, 1.0)] {
            let half = control.part(half.0, half.1);
            let (first, second) = (half.part(0.0, 0.2), half.part(0.2, 1.0));
            for (done, all) in [(1, 2), (2, 2), (1, 3)] {
                first.report(Stage::Light, done, all);
            }
            second.report(Stage::Light, 3, 4);
            second.report(Stage::Light, 9, 4);
        }
        let expected = [0.05, 0.1, 0.1, 0.4, 0.5, 0.55, 0.6, 0.6, 0.9, 1.0];
        let heard = heard.lock().unwrap();
        assert!(heard.len() == expected.len() && heard.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-4), "{heard:?}");
        control.part(0.0, 1.0).interrupt();
        assert!(control.check().is_err());
    }
}
