//! Depths as rules take them: a span along a segment, and a place in a table.

/// Optical depths at V that run linearly between two ends, as along a segment of a ray \[1\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthSpan {
    /// The depth at which the span begins.
    pub from: f64,
    /// The depth at which the span ends, which may be less.
    pub to: f64,
}

impl DepthSpan {
    /// The span of a single depth.
    pub fn at(depth: f64) -> Self {
        Self { from: depth, to: depth }
    }

    /// The smallest depth of the span.
    pub fn low(self) -> f64 {
        self.from.min(self.to)
    }

    /// The largest depth of the span.
    pub fn high(self) -> f64 {
        self.from.max(self.to)
    }
}

/// A place between two entries of a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct TablePlace {
    /// The number of the entry before the place.
    pub gap: usize,
    /// The fraction of the way from that to the next \[1\].
    pub fraction: f64,
}

impl TablePlace {
    /// The place of an abscissa in units of the step, in a table of a given number of entries; beyond the last entry the last gap
    /// goes on.
    pub fn new(x: f64, entries: usize) -> Self {
        let gap = (x as usize).min(entries - 2);
        Self { gap, fraction: x - gap as f64 }
    }
}
