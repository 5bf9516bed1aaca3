//! Samples along a ray: dust, depths from stars, gas.

use super::star_columns::StarColumns;
use super::steps::Steps;
use crate::geometry::{Bounds, Ray};
use crate::plan::SpatialPlan;
use crate::volume::Channel;

/// The number of places along a ray for all stars together, at which dust itself is marched towards them.
const PLACES: usize = 24;
/// The least number of places for each star.
const MIN_PLACES: usize = 6;

/// Samples at several positions of a ray.
pub(super) struct RaySamples {
    /// The stars whose depths are known.
    stars: usize,
    /// Values at one place: σ, the depths, the gas, the front.
    width: usize,
    values: Vec<f64>,
}

/// Sample at one position.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    /// σ at V [pc⁻¹].
    pub(super) sigma: f64,
    /// The depths from the stars that are seen, in their order.
    pub(super) depths: &'a [f64],
    /// The densities of the glowing species; those with a front, before it.
    pub(super) emission: &'a [f64],
    /// u of the front; one where densities contain it.
    pub(super) front: f64,
}

impl RaySamples {
    fn zeroed(stars: usize, space: &SpatialPlan, places: usize) -> Self {
        let width = 2 + stars + space.species();
        let mut samples = Self { stars, width, values: vec![0.0; width * places] };
        samples.values.chunks_exact_mut(width).for_each(|values| values[width - 1] = 1.0);
        samples
    }

    fn front_slot(&self) -> usize {
        self.width - 1
    }

    /// The sample at a place, by its number.
    #[inline(always)]
    pub(super) fn at(&self, place: usize) -> Sample<'_> {
        let values = &self.values[place * self.width..][..self.width];
        let front = values[self.front_slot()];
        Sample { sigma: values[0], depths: &values[1..1 + self.stars], emission: &values[1 + self.stars..self.front_slot()], front }
    }

    /// Samples of the plan's volumes; stars without depths of their own, which come last, have exact ones.
    pub(super) fn of_volumes(space: &SpatialPlan, ray: &Ray, places: &[f64], columns: &StarColumns) -> Self {
        let seen = &columns.stars;
        let mut samples = Self::zeroed(seen.len(), space, places.len());
        for volume in &space.volumes {
            // A place on the border belongs to the box, whatever its rounding.
            let margin = 1e-9 * volume.inner.bounds.size();
            let grown = Bounds { low: volume.inner.bounds.low - margin, high: volume.inner.bounds.high + margin };
            let slot = |channel: &Channel| match *channel {
                Channel::Dust => Some(0),
                // Stars with depths of their own come first, in ascending order.
                Channel::StarDepth(star) => space.marched().binary_search(&star).ok().map(|i| 1 + i),
                Channel::Emission(species) => Some(1 + seen.len() + species),
                Channel::Front => Some(samples.front_slot()),
                Channel::Light(_) | Channel::MultipleScattering(_) => None,
            };
            let slots: Vec<(usize, usize)> =
                volume.channels.iter().enumerate().filter_map(|(c, channel)| slot(channel).map(|slot| (c, slot))).collect();
            for (t, values) in places.iter().zip(samples.values.chunks_exact_mut(samples.width)) {
                let p = ray.at(*t);
                if grown.contains(p) {
                    let cell = volume.cell(p);
                    slots.iter().for_each(|(channel, slot)| values[*slot] = cell.value(*channel));
                }
            }
        }
        let count = space.marched().len().min(seen.len());
        for (t, values) in places.iter().zip(samples.values.chunks_exact_mut(samples.width)).filter(|(_, values)| values[0] > 0.0) {
            (count..seen.len()).for_each(|i| values[1 + i] = columns.depth(space, i, *t));
        }
        samples
    }

    /// Samples of the fields themselves, with star depths marched through them: those through the samples of the dust,
    /// and at some places along the refined `steps` what lies between both.
    pub(super) fn of_fields(space: &SpatialPlan, ray: &Ray, steps: &Steps, places: &[f64], columns: &StarColumns) -> Self {
        let seen = &columns.stars;
        let mut samples = Self::zeroed(seen.len(), space, places.len());
        let points: Vec<_> = places.iter().map(|t| ray.at(*t)).collect();
        let mut write = |slot: usize, row: &[f64]| {
            samples.values.chunks_exact_mut(samples.width).zip(row).for_each(|(values, value)| values[slot] = *value);
        };
        write(0, &space.dust_at(&points));
        for species in 0..space.species() {
            write(1 + seen.len() + species, &space.gas_at(species, &points));
        }
        let beyond = Beyond::new(space, ray, steps, seen);
        for (t, values) in places.iter().zip(samples.values.chunks_exact_mut(samples.width)).filter(|(_, values)| values[0] > 0.0) {
            (0..seen.len()).for_each(|i| values[1 + i] = (columns.depth(space, i, *t) + beyond.at(i, *t)).max(0.0));
        }
        samples
    }
}

/// The difference between star depths through the dust itself and through its samples.
struct Beyond {
    /// The places at which it is known \[pc\], ascending; values between them are linear.
    places: Vec<f64>,
    /// The difference at those places, star by star; none where dust is a grid.
    values: Vec<Vec<f64>>,
}

impl Beyond {
    fn new(space: &SpatialPlan, ray: &Ray, steps: &Steps, seen: &[usize]) -> Self {
        if !space.depth_is_sampled() {
            return Self { places: Vec::new(), values: Vec::new() };
        }
        let count = (PLACES / seen.len().max(1)).max(MIN_PLACES);
        let places = steps.places(count);
        let of_star = |star: &usize| places.iter().map(|t| space.depth_beyond_samples(space.stars[*star], ray.at(*t))).collect();
        let values = seen.iter().map(of_star).collect();
        Self { places, values }
    }

    fn at(&self, star: usize, t: f64) -> f64 {
        let Some(values) = self.values.get(star) else { return 0.0 };
        let above = self.places.partition_point(|place| *place <= t);
        let (low, high) = (above.saturating_sub(1), above.min(values.len() - 1));
        let gap = self.places[high] - self.places[low];
        let u = if gap > 0.0 { (t - self.places[low]) / gap } else { 0.0 };
        values[low] + u * (values[high] - values[low])
    }
}
