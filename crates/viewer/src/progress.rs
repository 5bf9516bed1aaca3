//! Progress of a picture between the thread that makes it and the window.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use barnard::control::{Control, Stage};

/// Parts of a stage, whose number stands before them.
const PARTS: u32 = 1000;
/// Shortest time between two reports to the window, which takes processors to draw.
const PERIOD: Duration = Duration::from_millis(250);

/// Stage of a picture, and its finished share; nothing at first.
#[derive(Debug, Default)]
pub struct Progress(AtomicU32);

impl Progress {
    /// Control for work whose progress is kept here; `changed` is called at most four times a second.
    pub fn control(self: &Arc<Self>, changed: impl Fn() + Send + Sync + 'static) -> Control {
        let (progress, last_report) = (self.clone(), Mutex::new(None::<Instant>));
        Control::with_listener(move |stage, done, all| {
            let number = Stage::ALL.iter().position(|known| *known == stage).unwrap_or(0) as u32;
            let parts = (f64::from(PARTS) * (done as f64 / all.max(1) as f64).min(1.0)) as u32;
            progress.0.store(1 + number * (PARTS + 1) + parts, Ordering::Relaxed);
            // A thread without the lock leaves the report to the one that has it.
            if let Ok(mut last_report) = last_report.try_lock()
                && last_report.is_none_or(|time| time.elapsed() >= PERIOD)
            {
                *last_report = Some(Instant::now());
                changed();
            }
        })
    }

    /// Forgets the work of before.
    pub fn reset(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    /// Name of the current stage and its finished share \[1\], once work has reported.
    pub fn now(&self) -> Option<(&'static str, f32)> {
        let now = self.0.load(Ordering::Relaxed).checked_sub(1)?;
        let (stage, parts) = (now / (PARTS + 1), now % (PARTS + 1));
        Some((Stage::ALL[stage as usize].name(), parts as f32 / PARTS as f32))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    #[test]
    fn stages_and_their_shares_are_told() {
        let (progress, changes) = (Arc::new(Progress::default()), Arc::new(AtomicUsize::new(0)));
        let count = changes.clone();
        let control = progress.control(move || {
            count.fetch_add(1, Ordering::Relaxed);
        });
        assert_eq!(progress.now(), None);
        control.report(Stage::Gas, 0, 0);
        assert_eq!(progress.now(), Some(("ionised gas", 0.0)));
        for _ in 0..3 {
            control.report(Stage::Rays, 1, 4);
        }
        assert_eq!(progress.now(), Some(("rays", 0.25)));
        control.report(Stage::Frames, 7, 4);
        assert_eq!(progress.now(), Some(("frames", 1.0)));
        let reports = changes.load(Ordering::Relaxed);
        assert!((1..5).contains(&reports), "{reports}");
        progress.reset();
        assert_eq!(progress.now(), None);
    }
}
