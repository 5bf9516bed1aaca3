//! How orders of scattering go, and when the rest of them is known.

use super::lanes::{EightLanes, WIDTH};

/// The error that is allowed of the sum of the orders that are not swept, as a part of all.
const REST: f64 = 1e-3;
/// The most that this sum may be, as a part of all.
const MAX_SERIES: f64 = 0.2;
/// Orders of less are none, as a part of all.
const NOTHING: f64 = 1e-9;

/// The powers of the orders of scattering, one after the other.
#[derive(Default)]
pub struct NeumannSeries {
    /// The power of each order, and of all up to it.
    pub orders: Vec<([f64; WIDTH], [f64; WIDTH])>,
}

impl NeumannSeries {
    /// Another order, and all up to it.
    pub fn push(&mut self, order: [f64; WIDTH], all: [f64; WIDTH]) {
        self.orders.push((order, all));
    }

    /// The ratio of the last order to that before, and the last order as a part of all.
    fn last(&self, back: usize, t: usize) -> Option<(f64, f64)> {
        let at = self.orders.len().checked_sub(1 + back)?;
        let ((order, all), (before, _)) = (&self.orders[at], &self.orders[at.checked_sub(1)?]);
        (all[t] > 0.0 && before[t] > 0.0).then(|| (order[t] / before[t], order[t] / all[t]))
    }

    /// True if the remaining geometric series is accurate enough.
    pub fn is_known(&self) -> bool {
        let known = |t: usize| {
            // An order of nothing is the last.
            if self.orders.last().is_some_and(|(order, all)| order[t] <= NOTHING * all[t]) {
                return true;
            }
            let (Some((ratio, part)), Some((before, _)), Some((first, _))) = (self.last(0, t), self.last(1, t), self.last(2, t)) else {
                return false;
            };
            // By how much the sum of the series may be wrong, and what it stands for.
            let change = (ratio - before).abs().max((before - first).abs());
            ratio < 1.0 && part * change / (1.0 - ratio).powi(2) < REST && part * ratio / (1.0 - ratio) < MAX_SERIES
        };
        (0..WIDTH).all(known)
    }

    /// The sum of the orders that are not swept, as a part of all, and for each term in units of the last order.
    pub fn rest(&self, bounces: usize) -> (f64, EightLanes) {
        let left = bounces.saturating_sub(1 + self.orders.len());
        let (mut series, mut rest) = (0.0f64, [0.0; WIDTH]);
        for (t, rest) in rest.iter_mut().enumerate() {
            if let Some((ratio, part)) = self.last(0, t).filter(|_| left > 0) {
                let ratio = ratio.clamp(0.0, 0.9999);
                let sum = ratio * (1.0 - ratio.powf(left as f64)) / (1.0 - ratio);
                *rest = sum as f32;
                series = series.max(part * sum / (1.0 + part * sum));
            }
        }
        (series, rest)
    }

    /// Expected number of orders.
    pub fn expected(&self, bounces: usize) -> u64 {
        let ratio = (0..WIDTH).filter_map(|t| self.last(0, t)).map(|l| l.0).fold(0.1, f64::max).min(0.99);
        let part = (0..WIDTH).filter_map(|t| self.last(0, t)).map(|l| l.1).fold(0.0, f64::max).max(REST);
        let more = ((REST / part).ln() / ratio.ln()).max(0.0) as usize;
        (self.orders.len() + more).min(bounces - 1) as u64
    }
}
