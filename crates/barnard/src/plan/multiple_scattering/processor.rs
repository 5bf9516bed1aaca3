//! Orders of scattering on the processor, which stands behind every device.

use std::sync::{Arc, OnceLock};

use super::cells::Cells;
use super::lanes::{EightLanes, Powers, WIDTH};
use super::moments::Moments;
use super::sweep::{Sources, sweep};
use super::sweeper::{Failure, Orders, Sweeper, Transfer};
use crate::control::Control;
use crate::error::Error;

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
        self.next.darken();
        let ([near, far], dark) = (faces, [0.0; WIDTH]);
        let directions = if self.is_first { near } else { far };
        sweep(cells, k, directions, &Sources { scattered: &self.order, scattering, glow: None, around: dark }, &mut self.next, control)?;
        if std::mem::take(&mut self.is_first) && (glow.is_some() || *around != dark) {
            self.order.darken();
            sweep(cells, k, far, &Sources { scattered: &self.order, scattering, glow, around: *around }, &mut self.next, control)?;
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
