//! Tracer of starlight through known gas: the processor, or a device that the caller brings.
//!
//! A [`RayTracer`] takes up a cloud and its stars, and brings [`Turns`]: in each, light goes through what is known of the gas by
//! then. What comes to voxels does not depend on who has brought it, but for the rounding of single precision.

use std::fmt::Debug;

use crate::cloud::{Cloud, Star};
use crate::light::{ByNode, IonisingLight};
use crate::lit::BEHIND;
pub use crate::rays::Listener;
use crate::rays::Rays;
use crate::voxel::Voxel;

/// A cloud, and stars whose light goes through it.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The cloud.
    pub cloud: &'a Cloud<'a>,
    /// At least one star.
    pub stars: &'a [Star<'a>],
    /// Fraction of a star's light below which a beam ends \[1\].
    pub used_up: f64,
    /// The opacity of neutral gas by node, for one nucleus of hydrogen \[cm²\].
    pub dark: ByNode,
}

impl<'a> Task<'a> {
    /// The nodes that all stars have in common.
    pub fn kind(&self) -> &IonisingLight {
        self.stars[0].light
    }

    /// The rays of a star.
    pub fn rays(&self, star: usize) -> Rays<'a> {
        Rays { cloud: self.cloud, place: self.stars[star].place }
    }

    /// Numbers of a voxel's flux, node by node, and of what stands behind it.
    pub fn row(&self) -> usize {
        self.kind().energies_ev.len() + BEHIND
    }
}

/// Light in the voxels of a cloud.
#[derive(Debug, Clone)]
pub struct Light {
    /// By voxel the flux of all stars, node by node \[s⁻¹ cm⁻²\], and behind that three numbers times the flux in all of them: the
    /// distance that it has come \[pc\], the voxel's cross section and the relative variance of ways through it.
    pub flux: Vec<f32>,
    /// By star and voxel the ionisations of hydrogen by its light \[s⁻¹\].
    pub rates: Vec<Vec<f32>>,
}

impl Light {
    /// None yet.
    pub fn none(task: &Task) -> Self {
        let cells = task.cloud.hydrogen.len();
        Self { flux: vec![0.0; cells * task.row()], rates: vec![vec![0.0; cells]; task.stars.len()] }
    }
}

/// Why there is no next turn.
#[derive(Debug)]
#[non_exhaustive]
pub enum Failure {
    /// The listener has had enough.
    Stopped,
    /// The tracer cannot go on, and why.
    Unable(String),
    /// The processor is as fast: where a tracer starts alone.
    NotFaster,
}

/// A processor or a device that has light go through gas.
pub trait RayTracer: Debug + Send + Sync {
    /// The name that outputs state.
    fn name(&self) -> String;

    /// Takes up a cloud and its stars.
    ///
    /// # Errors
    /// If they do not fit.
    fn start<'a>(&self, task: Task<'a>) -> Result<Box<dyn Turns + 'a>, Failure>;
}

/// Turns of light, each through the gas that the one before has made.
pub trait Turns {
    /// Has the light of all stars go through voxels, or through clear space where nothing is known of them, and renews `light`, whose
    /// rates are those of the turn before; gives the part of each star's photons that leaves the cloud.
    ///
    /// # Errors
    /// If the listener has had enough, and when a device gives up; rates are as they were then, but for the processor's.
    fn next(&mut self, voxels: Option<&[Voxel]>, light: &mut Light, listener: Listener) -> Result<Vec<f64>, Failure>;
}
