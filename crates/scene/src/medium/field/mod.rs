//! Scalar fields over space: densities of dust and gas.
//!
//! A field is a grid (trilinear between voxel centres, the border value in the outer half voxel, zero outside) or a
//! function. An expression that uses a grid lives on the voxels of the finest of them, over the box in which it can be
//! other than zero; an expression of functions alone stays a function. A new kind of field is one file and one row of
//! [`KINDS`].

mod bad_values;
mod cells;
mod column;
mod cuboid;
mod dust_map;
mod expression;
mod fbm;
mod formula;
mod front;
mod grid;
mod lattice;
mod loaded;
mod operators;
mod partition;
mod placement;
mod plummer;
mod program;
mod sampled;
mod shell;
mod simplex;
mod slab;
mod sphere;
mod store;
mod support;
mod turbulence;

use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::{Digest, Fingerprint};
use spectra::units::{Length, short};

pub use column::column;
pub use cuboid::Cuboid;
pub use expression::Expression;
pub use fbm::Fbm;
pub use formula::{check_name, functions, functions_of_two};
pub use front::mean_share;
pub(crate) use front::{along, filtered, largest_around, voxel_shares};
pub use grid::Grid;
pub use lattice::Lattice;
pub use lattice::trilinear;
pub use loaded::{Loaded, load};
pub(crate) use loaded::{grams_per_h, mass_per_h};
pub use partition::Partition;
pub use plummer::Plummer;
pub use shell::Shell;
pub use simplex::Simplex;
pub use slab::Slab;
pub use sphere::Sphere;
pub use turbulence::Turbulence;

use crate::blocks::Storage;
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::geometry::Bounds;
use crate::properties::{Kind, Section, build_kind};

/// Scalar function of position, such as a density.
///
/// # Examples
/// A Gaussian cloud with a standard deviation of 0.3 pc:
///
/// ```
/// use barnard_scene::field::Field;
/// use barnard_scene::geometry::Bounds;
/// use barnard_scene::glam::DVec3;
///
/// #[derive(Debug)]
/// struct Gaussian;
///
/// impl Field for Gaussian {
///     fn at(&self, p: DVec3) -> f64 {
///         if self.bounds().contains(p) { (-0.5 * p.length_squared() / 0.09).exp() } else { 0.0 }
///     }
///     fn bounds(&self) -> Bounds {
///         Bounds::cube(DVec3::ZERO, 1.0)
///     }
/// }
///
/// assert_eq!(Gaussian.at(DVec3::ZERO), 1.0);
/// ```
pub trait Field: std::fmt::Debug + Send + Sync {
    /// The value at `p` [unit of the field]; zero outside of [`Self::bounds`].
    fn at(&self, p: DVec3) -> f64;
    /// Writes the values at many places [unit of the field] into as many `values`: the numbers that [`at`](Self::at)
    /// gives, for fields that are quicker at it side by side.
    fn sample(&self, places: &[DVec3], values: &mut [f64]) {
        values.iter_mut().zip(places).for_each(|(value, p)| *value = self.at(*p));
    }
    /// The box outside of which it is zero.
    fn bounds(&self) -> Bounds;
    /// The grid itself, where the field is one.
    fn grid(&self) -> Option<&Grid> {
        None
    }
    /// Storage precision of its least exact grid.
    fn storage(&self) -> Storage {
        self.grid().map_or(Storage::Single, Grid::storage)
    }
    /// The cloud of noise itself, where the field is one: for back ends that evaluate it at every sample.
    fn fbm(&self) -> Option<&Fbm> {
        None
    }
    /// The length over which the field changes \[pc\]: its exact integrals start from steps of this size.
    fn feature_pc(&self) -> f64 {
        self.bounds().size().min_element() / 16.0
    }
    /// True if the field jumps anywhere, so that a value at the middle of a voxel says little of the voxel.
    fn has_edges(&self) -> bool {
        false
    }
    /// Refuses numbers that it cannot be reckoned with; a field with more of them than its bounds says which.
    ///
    /// # Errors
    /// If a number is wrong, with what would be right.
    fn check(&self) -> Result<()> {
        self.bounds().checked().map(drop)
    }
    /// Adds the content to a digest. The default distinguishes objects by address.
    fn content(&self, digest: &mut Digest) {
        digest.object(self);
    }
    /// Distances \[pc\] at which the field is not smooth along a ray.
    fn crossings(&self, _ray: &crate::geometry::Ray, _out: &mut Vec<f64>) {}
}

/// Fingerprint of a field's content.
pub fn fingerprint(field: &dyn Field) -> Fingerprint {
    let mut digest = Digest::new("field");
    field.content(&mut digest);
    digest.finish()
}

/// Argument for a field: a field, or one that is shared.
pub trait IntoField {
    /// The field as it is shared between its users.
    fn into_field(self) -> Arc<dyn Field>;
}

impl<F: Field + 'static> IntoField for F {
    fn into_field(self) -> Arc<dyn Field> {
        Arc::new(self)
    }
}

impl IntoField for Arc<dyn Field> {
    fn into_field(self) -> Arc<dyn Field> {
        self
    }
}

/// A number within a range.
pub(crate) fn within(what: &'static str, value: f64, range: RangeInclusive<f64>) -> Result<f64> {
    if range.contains(&value) {
        return Ok(value);
    }
    Err(Error::out_of_range(what, value, format!("between {} and {}", short(*range.start()), short(*range.end()))))
}

/// A length above zero [pc].
fn above_zero(what: &'static str, length_pc: f64) -> Result<f64> {
    if length_pc > 0.0 && length_pc.is_finite() { Ok(length_pc) } else { Err(Error::out_of_range(what, Length(length_pc), "above zero")) }
}

/// Checks that a place has finite coordinates [pc].
fn place(what: &'static str, p: DVec3) -> Result<DVec3> {
    if p.is_finite() { Ok(p) } else { Err(Error::out_of_range(what, p, "finite")) }
}

/// A direction, of length one.
fn unit(what: &'static str, direction: DVec3) -> Result<DVec3> {
    if direction.is_normalized() {
        return Ok(direction);
    }
    direction.try_normalize().ok_or_else(|| Error::out_of_range(what, direction, "a vector of finite length above zero"))
}

/// All kinds of field that are made of nothing but what their tables say.
pub const KINDS: &[Kind<Arc<dyn Field>>] =
    &[loaded::KIND, fbm::KIND, sphere::KIND, cuboid::KIND, plummer::KIND, shell::KIND, slab::KIND, turbulence::KIND];

/// True if the field of a `[field.NAME]` table takes so long that it can be made roughly first.
pub(crate) fn takes_long(section: &Section) -> bool {
    section.kind() == Some(turbulence::KIND.name) && turbulence::takes_long(section)
}

/// Builds the field that a `[field.NAME]` table describes.
///
/// # Errors
/// If a key is unknown, missing or wrong; the error states its place.
pub fn build(section: &Section, inputs: &Inputs) -> Result<Arc<dyn Field>> {
    build_kind("field", KINDS, section, inputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::of_every_kind;
    use crate::geometry::Ray;

    /// Every kind: nothing outside of its box, densities within, and a column that is what a fine sum says of it,
    /// whichever way a ray goes.
    #[test]
    fn every_kind_is_a_density_with_columns() {
        let all = of_every_kind(KINDS, |kind| (kind.name, kind.keys), "", build);
        assert_eq!(all.len(), KINDS.len());
        for (name, field) in all {
            let bounds = field.bounds();
            assert!(bounds.fault().is_none() && field.feature_pc() > 0.0, "{name}");
            let (size, middle) = (bounds.size(), 0.5 * (bounds.low + bounds.high));
            let place = |i: usize, wide: f64| {
                let part = |step: f64| (step * (i + 1) as f64).fract() - 0.5;
                middle + wide * size * DVec3::new(part(0.618_034), part(0.414_214), part(0.732_051))
            };
            for p in (0..500).map(|i| place(i, 1.6)) {
                let value = field.at(p);
                assert!(value >= 0.0 && value.is_finite() && (bounds.contains(p) || value == 0.0), "{name} at {p}: {value}");
            }
            let mut seen = 0.0;
            for i in 0..8 {
                let (a, b) = (place(i, 1.5), middle - 0.3 * (place(i + 8, 1.0) - middle));
                let count = 20_000;
                let at = |j: usize| field.at(a.lerp(b, (j as f64 + 0.5) / f64::from(count)));
                let sum = (0..count as usize).map(at).sum::<f64>() * (b - a).length() / f64::from(count);
                let exact = column(&*field, a, b);
                assert!((exact - sum).abs() < 2e-3 * (b - a).length(), "{name}: {exact} {sum}");
                let mut crossings = Vec::new();
                field.crossings(&Ray::between(a, b).0, &mut crossings);
                assert!(crossings.iter().all(|t| t.is_finite()), "{name}");
                seen += sum;
            }
            assert!(seen > 0.0, "{name}: no ray met it");
        }
    }
}
