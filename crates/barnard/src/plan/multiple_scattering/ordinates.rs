//! Orders of scattering, one after the other, wherever they are swept: on the processor, or on a device that the caller
//! brings.
//!
//! A [`Sweeper`] takes up a [`Transfer`] and what shines first, and brings [`Orders`]: each scatters the one before and
//! sweeps it along the discrete ordinates. What is found does not depend on where it is found, but for the rounding of
//! single precision.

use std::fmt::Debug;
use std::sync::{Arc, OnceLock};

pub use super::cells::Cells;
pub use super::directions::{Face, across, faces};
pub use super::moments::Moments;
pub use super::sweep::{Beam, THIN_CELL, beam};
use super::sweep::{Sources, sweep};
use crate::control::Control;
use crate::error::Error;

/// Terms that are swept side by side.
pub const WIDTH: usize = crate::volume::MAX_CHANNELS;
/// A number for each of them.
pub type EightLanes = [f32; WIDTH];
/// Fluence in the dust, for each of them.
pub type Powers = [f64; WIDTH];

/// The medium that the light of eight terms crosses.
#[derive(Debug, Clone, Copy)]
pub struct Transfer<'a> {
    /// The cells in which the dust is.
    pub cells: &'a Cells,
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
    /// Where they do not fit.
    fn start<'a>(&self, transfer: Transfer<'a>, first: Moments) -> Result<Box<dyn Orders + 'a>, Failure>;
}

/// Orders of scattering, each from the one before.
pub trait Orders {
    /// The next one; gas and what comes in from around are part of the first. Its power, and that of all so far.
    ///
    /// # Errors
    /// When the user wishes to stop, and when a device gives up.
    fn next(&mut self, control: &Control) -> Result<(Powers, Powers), Failure>;

    /// The sum of all, and the last one by these factors.
    ///
    /// # Errors
    /// When a device gives up.
    fn sum(self: Box<Self>, last: &EightLanes) -> Result<Moments, Failure>;
}

/// The processor as a sweeper.
#[derive(Debug)]
pub struct Processor;

impl Sweeper for Processor {
    fn name(&self) -> String {
        "cpu".into()
    }

    fn start<'a>(&self, transfer: Transfer<'a>, first: Moments) -> Result<Box<dyn Orders + 'a>, Failure> {
        let dark = || Moments::dark(transfer.cells.lattice.cells(), first.count);
        let (sum, next) = (dark(), dark());
        Ok(Box::new(OnProcessor { transfer, order: first, next, sum, is_first: true }))
    }
}

/// A device, as long as it can, and the processor behind it.
pub struct Sweepers<'a> {
    device: Option<&'a dyn Sweeper>,
    /// Why the device was given up, once it was: it is not tried again.
    gave_up: OnceLock<String>,
}

impl<'a> Sweepers<'a> {
    /// The processor alone where there is no device.
    pub fn new(device: Option<&'a dyn Sweeper>) -> Self {
        Self { device, gave_up: OnceLock::new() }
    }

    /// Does `work` with the first sweeper that can; returns what it made, and the name that outputs state.
    ///
    /// # Errors
    /// When the user wishes to stop, and where the processor cannot either.
    pub fn run<T>(&self, work: impl Fn(&dyn Sweeper) -> Result<T, Failure>) -> crate::error::Result<(T, Arc<str>)> {
        if let Some(device) = self.device.filter(|_| self.gave_up.get().is_none()) {
            match work(device) {
                Ok(made) => return Ok((made, device.name().into())),
                Err(Failure::Stopped(error)) => return Err(error),
                Err(Failure::Unable(why)) => {
                    self.gave_up.get_or_init(|| format!(" ({}: {why})", device.name()));
                }
            }
        }
        let processor = Processor.name();
        match work(&Processor) {
            Ok(made) => Ok((made, (processor + self.gave_up.get().map_or("", String::as_str)).into())),
            Err(Failure::Stopped(error)) => Err(error),
            Err(Failure::Unable(why)) => Err(Error::Method(format!(
                "light that is scattered more than once cannot be swept ({processor}: {why}); write bounces = 1"
            ))),
        }
    }
}

struct OnProcessor<'a> {
    transfer: Transfer<'a>,
    order: Moments,
    next: Moments,
    sum: Moments,
    is_first: bool,
}

impl Orders for OnProcessor<'_> {
    fn next(&mut self, control: &Control) -> Result<(Powers, Powers), Failure> {
        let Transfer { cells, k, faces, scattering, glow, around } = self.transfer;
        self.order.scatter(scattering);
        self.next.data.fill([0.0; WIDTH]);
        let ([near, far], dark) = (faces, [0.0; WIDTH]);
        let directions = if self.is_first { near } else { far };
        sweep(cells, k, directions, &Sources { scattered: &self.order, glow: None, around: dark }, &mut self.next, control)?;
        if std::mem::take(&mut self.is_first) && (glow.is_some() || *around != dark) {
            self.order.data.fill(dark);
            sweep(cells, k, far, &Sources { scattered: &self.order, glow, around: *around }, &mut self.next, control)?;
        }
        self.sum.add(&self.next, &[1.0; WIDTH]);
        std::mem::swap(&mut self.order, &mut self.next);
        Ok((power(cells, &self.order), power(cells, &self.sum)))
    }

    fn sum(mut self: Box<Self>, last: &EightLanes) -> Result<Moments, Failure> {
        self.sum.add(&self.order, last);
        Ok(self.sum)
    }
}

/// The fluence in the dust, for each term.
fn power(cells: &Cells, moments: &Moments) -> Powers {
    let mut power = [0.0; WIDTH];
    for (fluence, sigma) in moments.data.iter().step_by(moments.count).zip(&cells.sigma) {
        power.iter_mut().zip(fluence).for_each(|(p, m)| *p += f64::from(*sigma) * f64::from(*m));
    }
    power
}
