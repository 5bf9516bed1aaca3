//! Orders of scattering on the processor, which stands behind every device.

use std::sync::{Arc, OnceLock};

use super::cells::SweepCells;
use super::lanes::{EightLanes, Lanes, Powers, WIDTH, resized};
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
        // A sweep waits for memory: few terms take few lanes.
        Ok(match transfer.terms {
            0..=2 => Box::new(OnProcessor::<2>::new(transfer, first)),
            3..=4 => Box::new(OnProcessor::<4>::new(transfer, first)),
            _ => Box::new(OnProcessor::<WIDTH>::new(transfer, first)),
        })
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

    /// True if a device sweeps, and has not given up.
    pub fn has_device(&self) -> bool {
        self.device.is_some() && self.gave_up.get().is_none()
    }

    /// Does `work` with the first sweeper that can; returns what it made, and the name that outputs state.
    ///
    /// # Errors
    /// On interruption by the user, and if the processor cannot either.
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
            Err(Failure::Unable(why)) => Err(Error::Method(format!("multiple scattering failed ({processor}: {why}); set bounces = 1"))),
        }
    }
}

/// Orders of a given number of terms, side by side.
struct OnProcessor<'a, const N: usize> {
    transfer: Transfer<'a>,
    k: Lanes<N>,
    scattering: Vec<Lanes<N>>,
    glow: Option<Vec<Lanes<N>>>,
    around: Lanes<N>,
    order: Moments<N>,
    next: Moments<N>,
    sum: Moments<N>,
    is_first: bool,
}

impl<'a, const N: usize> OnProcessor<'a, N> {
    fn new(transfer: Transfer<'a>, first: Moments) -> Self {
        let (count, order) = (first.count, first.resized());
        // Two more of the kind are made now: what it was made from goes before.
        drop(first);
        let dark = || Moments::dark(transfer.cells.lattice.cells(), count);
        let all = |lanes: &[EightLanes]| lanes.iter().map(resized).collect();
        Self {
            k: resized(transfer.k),
            scattering: all(transfer.scattering),
            glow: transfer.glow.map(all),
            around: resized(transfer.around),
            order,
            next: dark(),
            sum: dark(),
            is_first: true,
            transfer,
        }
    }
}

impl<const N: usize> Orders for OnProcessor<'_, N> {
    fn next(&mut self, control: &Control) -> Result<(Powers, Powers), Failure> {
        let Self { transfer, k, scattering, glow, around, order, next, sum, is_first } = self;
        let Transfer { cells, faces: [near, far], .. } = *transfer;
        next.darken();
        let dark = [0.0; N];
        let directions = if *is_first { near } else { far };
        sweep(cells, k, directions, &Sources { scattered: order, scattering, glow: None, around: dark }, next, control)?;
        if std::mem::take(is_first) && (glow.is_some() || *around != dark) {
            order.darken();
            sweep(cells, k, far, &Sources { scattered: order, scattering, glow: glow.as_deref(), around: *around }, next, control)?;
        }
        sum.add(next, &[1.0; N]);
        std::mem::swap(order, next);
        Ok((power(cells, order), power(cells, sum)))
    }

    fn sum(self: Box<Self>, last: &EightLanes) -> Result<Moments, Failure> {
        let Self { mut sum, order, next, .. } = *self;
        sum.add(&order, &resized(last));
        drop((order, next));
        Ok(sum.resized())
    }
}

/// The fluence in the dust, for each term.
fn power<const N: usize>(cells: &SweepCells, moments: &Moments<N>) -> Powers {
    let mut power = [0.0; WIDTH];
    for (fluence, sigma) in moments.data.iter().step_by(moments.count).zip(&cells.sigma) {
        power.iter_mut().zip(fluence).for_each(|(p, m)| *p += f64::from(*sigma) * f64::from(*m));
    }
    power
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::directions::faces;
    use super::*;
    use crate::field::Lattice;
    use crate::geometry::Bounds;

    /// The light of two terms does not depend on how many lanes are swept beside them.
    #[test]
    fn lanes_are_alone() {
        let lattice = Lattice { dims: [6, 5, 7], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let count = lattice.cells();
        let cells = SweepCells::of(lattice, (0..count).map(|i| (i % 5) as f32).collect());
        let mut first = Moments::dark(count, 4);
        first.data.iter_mut().enumerate().for_each(|(i, m)| m[..2].copy_from_slice(&[(i % 7) as f32, (i % 3) as f32]));
        let two = |a: f32, b: f32| resized(&[a, b]);
        let (near, far) = (faces(3), faces(2));
        let transfer = Transfer {
            cells: &cells,
            terms: 2,
            k: &two(1.0, 1.3),
            faces: [&near, &far],
            scattering: &[two(0.8, 0.7), two(0.5, 0.4), two(0.5, 0.4), two(0.5, 0.4)],
            glow: Some(&vec![two(0.1, 0.3); count]),
            around: &two(0.2, 0.1),
        };
        let swept = |mut orders: Box<dyn Orders + '_>| {
            let powers: Vec<_> = (0..3).map(|_| orders.next(&Control::default()).unwrap()).collect();
            (powers, orders.sum(&two(0.5, 0.25)).unwrap().data)
        };
        let narrow = swept(Processor.start(transfer, first.clone()).unwrap());
        assert!(narrow.0[2].0[0] > narrow.0[2].0[1] && narrow.0[2].0[1] > 0.0 && narrow.0[2].0[2] == 0.0);
        assert!(narrow == swept(Box::new(OnProcessor::<4>::new(transfer, first.clone()))));
        assert!(narrow == swept(Box::new(OnProcessor::<WIDTH>::new(transfer, first.clone()))));
    }
}
