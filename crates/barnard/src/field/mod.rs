//! Scalar fields over space: densities of dust and gas.
//!
//! A field is a grid (trilinear between voxel centres, the border value in the outer half voxel, zero outside) or a function. An expression that uses a
//! grid lives on the voxels of the finest of them, over the box in which it can be other than zero; an expression of functions alone stays a function. A new kind of field is one file and one row of [`KINDS`].

mod column;
mod cuboid;
mod expression;
mod fbm;
mod formula;
mod grid;
mod loaded;
mod plummer;
mod shell;
mod simplex;
mod slab;
mod sphere;
mod support;

use std::sync::Arc;

use glam::DVec3;

pub use column::column;
pub use expression::Expression;
pub use fbm::Fbm;
pub use formula::{FUNCTIONS, FUNCTIONS_OF_TWO, check_name};
pub use grid::{Grid, Lattice};
pub use simplex::Simplex;

use crate::error::Result;
use crate::geometry::Bounds;
use crate::scene::{Kind, Loader, Section};

/// A scalar function of place.
pub trait Field: std::fmt::Debug + Send + Sync {
    /// The value at `p` [unit of the field]; zero outside of [`Self::bounds`].
    fn at(&self, p: DVec3) -> f64;
    /// Where it is not zero.
    fn bounds(&self) -> Bounds;
    /// The grid itself, where the field is one.
    fn grid(&self) -> Option<&Grid> {
        None
    }
    /// The cloud of noise itself, where the field is one: for back ends that evaluate it at every sample.
    fn fbm(&self) -> Option<&Fbm> {
        None
    }
    /// The length over which the field changes [pc]: its exact integrals start from steps of this size.
    fn feature_pc(&self) -> f64 {
        self.bounds().size().min_element() / 16.0
    }
    /// Whether the field jumps anywhere, so that a value at the middle of a voxel says little of the voxel.
    fn has_edges(&self) -> bool {
        false
    }
    /// Distances [pc] at which the field is not smooth along a ray.
    fn crossings(&self, _ray: &crate::geometry::Ray, _out: &mut Vec<f64>) {}
}

/// All kinds of field.
pub const KINDS: &[Kind<Arc<dyn Field>>] = &[loaded::KIND, fbm::KIND, sphere::KIND, cuboid::KIND, plummer::KIND, shell::KIND, slab::KIND];

/// Builds the field that a `[field.NAME]` table describes.
pub fn build(section: &Section, loader: &Loader) -> Result<Arc<dyn Field>> {
    crate::scene::build_kind("field", KINDS, section, loader)
}
