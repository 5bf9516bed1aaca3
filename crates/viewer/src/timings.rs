//! Rate of new pictures in the window, as printed by `barnard view --timings`.

use std::time::Instant;

use barnard_explorer::order::Refinement;

/// State of the window in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// The number of the order whose picture is shown, and its quality, where there is one.
    pub shown: Option<(u64, Refinement)>,
    /// The pixels of the picture, width and height.
    pub size: (usize, usize),
    /// True if something moves.
    pub moving: bool,
    /// True if the picture is the one that `barnard render` makes of all that was asked for.
    pub settled: bool,
    /// When something changed last \[s\].
    pub changed: f64,
}

/// The frames of a window since something changed, on a clock in seconds.
#[derive(Debug, Default)]
pub struct Timings {
    /// When the program began, until its first picture has come.
    began: Option<Instant>,
    last: Option<Look>,
    /// When pictures came while something moved.
    previews: Vec<f64>,
    /// When the window was drawn while a picture settled.
    frames: Vec<f64>,
}

impl Timings {
    /// Timings of a program from its start, which include the first picture.
    pub fn since(began: Instant) -> Self {
        Self { began: Some(began), ..Self::default() }
    }

    /// Takes up what is shown at a time; returns what there is to tell of it.
    pub fn frame(&mut self, now: f64, look: Look) -> Option<String> {
        let last = self.last.replace(look);
        let is_new = look.shown.is_some() && last.is_none_or(|last| last.shown != look.shown);
        if let Some(began) = self.began.take_if(|_| is_new) {
            return Some(format!("first picture {:.2} s after the start", began.elapsed().as_secs_f64()));
        }
        if look.moving {
            self.frames.clear();
            if is_new {
                self.previews.push(now);
            }
            return None;
        }
        self.frames.push(now);
        let previews = std::mem::take(&mut self.previews);
        if let Some(pace) = EventPace::of(&previews) {
            return Some(format!("{} previews, {pace}", previews.len()));
        }
        if !look.settled {
            return None;
        }
        let frames = std::mem::take(&mut self.frames);
        let is_first = last.is_none_or(|last| !last.settled || last.moving);
        let pace = EventPace::of(&frames).filter(|_| is_first)?;
        let (width, height) = look.size;
        Some(format!("settled {width} x {height} {:.2} s after the last change, the window drawn {pace}", now - look.changed))
    }
}

/// Event counter.
struct EventPace {
    /// Times a second, in the mean.
    rate: f64,
    /// The longest that it did not [s].
    longest: f64,
}

impl EventPace {
    /// The pace of what happened at these times; none of less than two.
    fn of(times: &[f64]) -> Option<Self> {
        let [first, .., last] = times else { return None };
        let longest = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        Some(Self { rate: (times.len() - 1) as f64 / (last - first), longest })
    }
}

impl std::fmt::Display for EventPace {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:.1} times a second, {:.0} ms apart at most", self.rate, 1000.0 * self.longest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_and_settling_are_told_once() {
        let mut timings = Timings::default();
        let look =
            |number, quality, moving, settled, changed| Look { shown: Some((number, quality)), size: (740, 810), moving, settled, changed };
        for i in 0..21u64 {
            // Two frames for each picture.
            let now = 0.05 * i as f64;
            assert_eq!(timings.frame(now, look(i / 2, Refinement::Coarse, true, false, now)), None);
        }
        let rest = timings.frame(1.15, look(10, Refinement::Coarse, false, false, 1.0)).unwrap();
        assert_eq!(rest, "11 previews, 10.0 times a second, 100 ms apart at most");
        assert_eq!(timings.frame(1.35, look(10, Refinement::Full, false, false, 1.0)), None);
        assert_eq!(timings.frame(1.45, look(10, Refinement::Full, false, false, 1.0)), None);
        let settled = timings.frame(1.75, look(10, Refinement::Settled, false, true, 1.0)).unwrap();
        assert_eq!(settled, "settled 740 x 810 0.75 s after the last change, the window drawn 5.0 times a second, 300 ms apart at most");
        assert_eq!(timings.frame(2.0, look(10, Refinement::Settled, false, true, 1.0)), None);
        assert_eq!(timings.frame(9.0, look(10, Refinement::Settled, false, true, 1.0)), None);
        let mut timings = Timings::since(Instant::now());
        assert_eq!(timings.frame(0.0, Look { shown: None, ..look(0, Refinement::Coarse, true, false, 0.0) }), None);
        let first = timings.frame(0.1, look(1, Refinement::Coarse, true, false, 0.1)).unwrap();
        assert!(first.starts_with("first picture 0.0") && first.ends_with(" s after the start"), "{first}");
        assert_eq!(timings.frame(0.2, look(2, Refinement::Coarse, true, false, 0.2)), None);
    }
}
