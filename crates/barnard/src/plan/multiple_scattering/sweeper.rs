//! Sweeper of scattering orders: the processor, or a device that the caller brings.
//!
//! A [`Sweeper`] takes up a [`Transfer`] and what shines first, and brings [`Orders`]: each scatters the one before and
//! sweeps it along the discrete ordinates. What is found does not depend on where it is found, but for the rounding of
//! single precision.

use std::fmt::Debug;

use super::cells::SweepCells;
use super::directions::Face;
use super::lanes::{EightLanes, Powers};
use super::moments::Moments;
use crate::control::Control;
use crate::error::Error;

/// The medium that the light of eight terms crosses.
#[derive(Debug, Clone, Copy)]
pub struct Transfer<'a> {
    /// The cells in which the dust is.
    pub cells: &'a SweepCells,
    /// Terms that there are; in the lanes behind them is no light.
    pub terms: usize,
    /// Extinction in parts of that at V.
    pub k: &'a EightLanes,
    /// Directions of starlight that has scattered once, and of all other: it comes from near the stars, and few
    /// directions would draw rays of it. What comes in from around must have those of later orders, or an even field of
    /// light would not stay even.
    pub faces: [&'a [Face]; 2],
    /// The albedo times the Legendre moment, ω p_l, of each harmonic.
    pub scattering: &'a [EightLanes],
    /// Light of gas per length [pc⁻¹], where there is any.
    pub glow: Option<&'a [EightLanes]>,
    /// Radiance that comes in from all around.
    pub around: &'a EightLanes,
}

/// Why there is no next order.
#[derive(Debug)]
#[non_exhaustive]
pub enum Failure {
    /// The user's wish to stop.
    Stopped(Error),
    /// The sweeper cannot go on, and why.
    Unable(String),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Stopped(error)
    }
}

/// A processor or a device that sweeps orders of scattering.
pub trait Sweeper: Debug + Send + Sync {
    /// The name that outputs state.
    fn name(&self) -> String;

    /// Takes up moments of light that has not been scattered yet.
    ///
    /// # Errors
    /// If they do not fit.
    fn start<'a>(&self, transfer: Transfer<'a>, first: Moments) -> Result<Box<dyn Orders + 'a>, Failure>;
}

/// Orders of scattering, each from the one before.
pub trait Orders {
    /// Sweeps the next order; returns its power, and that of all so far. Gas and light from around shine in the first.
    ///
    /// # Errors
    /// On interruption by the user, and when a device gives up.
    fn next(&mut self, control: &Control) -> Result<(Powers, Powers), Failure>;

    /// The sum of all orders, the last one added once more by these factors.
    ///
    /// # Errors
    /// If a device gives up.
    fn sum(self: Box<Self>, last: &EightLanes) -> Result<Moments, Failure>;
}
