//! Orders of scattering on the processor, which stands behind every device.

use std::sync::{Arc, OnceLock};

use super::lanes::{EightLanes, Powers, WIDTH};
use super::moments::Moments;
use super::rows::Rows;
use super::sweep::{Medium, Sources, sweep};
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
        Ok(Box::new(OnProcessor::new(transfer, first)))
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

/// Orders of the terms, one after the other.
struct OnProcessor<'a> {
    transfer: Transfer<'a>,
    medium: Medium<'a>,
    terms: Vec<TermOrders>,
    /// The number of harmonics of a cell.
    count: usize,
    is_first: bool,
}

/// Orders of one term.
struct TermOrders {
    k: f32,
    scattering: Vec<f32>,
    glow: Option<Rows>,
    around: f32,
    order: Rows,
    sum: Rows,
}

impl<'a> OnProcessor<'a> {
    fn new(transfer: Transfer<'a>, first: Moments) -> Self {
        let dims = transfer.cells.lattice.dims;
        let term = |t: usize| TermOrders {
            k: transfer.k[t],
            scattering: transfer.scattering.iter().map(|scattering| scattering[t]).collect(),
            glow: transfer.glow.map(|glow| Rows::from_function(dims, 1, |cell, _| glow[cell][t])),
            around: transfer.around[t],
            order: Rows::of_term(dims, &first, t),
            sum: Rows::zeroed(dims, first.count),
        };
        let terms = (0..transfer.terms).map(term).collect();
        Self { medium: Medium::new(transfer.cells), terms, count: first.count, transfer, is_first: true }
    }
}

impl Orders for OnProcessor<'_> {
    fn next(&mut self, control: &Control) -> Result<(Powers, Powers), Failure> {
        let Self { transfer: Transfer { faces: [near, far], .. }, medium, terms, is_first, .. } = self;
        let (mut last, mut all) = ([0.0; WIDTH], [0.0; WIDTH]);
        let is_first = std::mem::take(is_first);
        for (t, term) in terms.iter_mut().enumerate() {
            let TermOrders { k, scattering, glow, around, order, sum } = term;
            let mut next = Rows::zeroed(order.dims, order.numbers);
            let starlight = Sources { k: *k, scattered: order, scattering, glow: None, around: 0.0 };
            sweep(medium, if is_first { near } else { far }, &starlight, &mut next, control)?;
            if is_first && (glow.is_some() || *around != 0.0) {
                let dark = &Rows::zeroed(order.dims, order.numbers);
                let extended = Sources { scattered: dark, glow: glow.as_ref(), around: *around, ..starlight };
                sweep(medium, far, &extended, &mut next, control)?;
            }
            sum.add(&next, 1.0);
            *order = next;
            (last[t], all[t]) = (order.weighted(medium.sigma()), sum.weighted(medium.sigma()));
        }
        Ok((last, all))
    }

    fn sum(self: Box<Self>, last: &EightLanes) -> Result<Moments, Failure> {
        let mut moments = Moments::dark(self.transfer.cells.lattice.cells(), self.count);
        for (t, TermOrders { order, mut sum, .. }) in self.terms.into_iter().enumerate() {
            sum.add(&order, last[t]);
            sum.write(&mut moments, t);
        }
        Ok(moments)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::cells::SweepCells;
    use super::super::directions::faces;
    use super::*;
    use crate::field::Lattice;
    use crate::geometry::Bounds;

    /// The light of a term does not depend on the terms beside it.
    #[test]
    fn terms_are_alone() {
        let lattice = Lattice { dims: [6, 5, 7], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let count = lattice.cells();
        let cells = SweepCells::of(lattice, (0..count).map(|i| (i % 5) as f32).collect());
        let (near, far) = (faces(3), faces(2));
        let swept = |terms: &[usize]| {
            let lanes = |values: [f32; 2]| std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| values[*term]));
            let mut first = Moments::dark(count, 4);
            first.data.iter_mut().enumerate().for_each(|(i, m)| *m = lanes([(i % 7) as f32, (i % 3) as f32]));
            let glow = vec![lanes([0.1, 0.3]); count];
            let scattering = [lanes([0.8, 0.7]), lanes([0.5, 0.4]), lanes([0.5, 0.4]), lanes([0.5, 0.4])];
            let (k, around) = (lanes([1.0, 1.3]), lanes([0.2, 0.1]));
            let transfer = Transfer {
                cells: &cells,
                terms: terms.len(),
                k: &k,
                faces: [&near, &far],
                scattering: &scattering,
                glow: Some(&glow),
                around: &around,
            };
            let mut orders = Processor.start(transfer, first).unwrap();
            let powers: Vec<_> = (0..3).map(|_| orders.next(&Control::default()).unwrap()).collect();
            (powers[2], orders.sum(&lanes([0.5, 0.25])).unwrap().data)
        };
        let (both, second) = (swept(&[0, 1]), swept(&[1]));
        assert!(both.0.0[0] > both.0.0[1] && both.0.0[1] > 0.0 && both.0.0[2] == 0.0);
        assert!(both.0.0[1] == second.0.0[0] && both.1.iter().zip(&second.1).all(|(a, b)| a[1] == b[0]));
    }
}
