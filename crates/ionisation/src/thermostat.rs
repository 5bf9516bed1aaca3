//! Steps of the temperature towards balance.

use crate::lanes::Lanes;
use crate::state::{COLDEST, HOTTEST};

/// Temperatures that move to where heating is as much as cooling.
#[derive(Debug, Clone)]
pub struct Thermostat {
    /// T \[K\], zero before there is one, and by how much heating was more than cooling there, in parts of their mean.
    last: (Lanes, Lanes),
    /// Slope of the second over ln T at the last evaluation.
    slope: Lanes,
    /// Changes of ln T that are too small to tell a slope.
    little: f64,
}

/// The slope that is taken before any is known.
pub const SLOPE: f64 = 5.0;

impl Thermostat {
    /// Thermostat without history; changes of ln T must fall below a tolerance.
    pub fn new(settled: f64) -> Self {
        Self { last: (Lanes::ZERO, Lanes::ZERO), slope: Lanes::splat(SLOPE), little: 0.1 * settled }
    }

    /// Begins anew in a lane, with the slope of other gas that is near.
    pub fn begin(&mut self, lane: usize, slope: f64) {
        (self.last.0[lane], self.slope[lane]) = (0.0, slope);
    }

    /// The slope of a lane.
    pub fn slope(&self, lane: usize) -> f64 {
        self.slope[lane]
    }

    /// The next temperatures to try, given heating less cooling in parts of their mean at those before \[K\].
    #[inline(always)]
    pub fn next(&mut self, temperature: Lanes, excess: Lanes) -> Lanes {
        let (last, was) = self.last;
        // ln (T/T'), which is small.
        let moved = (temperature - last) / (temperature + last) * 2.0;
        // Cooling rises with some power of T beside heating; what the last two tell of it is held within reason.
        let ratio = ((was - excess) / moved).at_least(1.5).at_most(15.0);
        self.slope = last.above(0.0, moved.abs().above(self.little, ratio, self.slope), self.slope);
        self.last = (temperature, excess);
        let step = (excess / self.slope).at_least(-0.3).at_most(0.3);
        (temperature * (step + 2.0) / (Lanes::splat(2.0) - step)).at_least(COLDEST).at_most(HOTTEST)
    }
}
