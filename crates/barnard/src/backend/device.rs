//! Graphics devices of back ends.

use std::sync::Arc;

use glam::DVec3;

use super::Job;
use crate::control::Control;
use crate::error::Result;
use crate::plan::ordinates::Sweeper;

/// Graphics device that a [`Backend`](super::Backend) renders on.
pub trait Device {
    /// Uploads a job's plan before its light is requested, as after an edit.
    ///
    /// # Errors
    /// If the job cannot be planned, or does not fit on the device.
    fn prepare(&mut self, job: &Job, control: &Control) -> Result<()>;

    /// A faster device for multiple scattering than the processor, where there is one.
    fn sweeper(&self) -> Option<Arc<dyn Sweeper>>;

    /// Device time of the last work \[s\]; `None` where the device does not measure it.
    fn seconds(&self) -> Option<f64>;

    /// Runs for `seconds` \[s\], so that later timings are those of a device under load.
    ///
    /// # Errors
    /// If the device fails, and on interruption by the user.
    fn warm_up(&mut self, seconds: f64, control: &Control) -> Result<()>;

    /// Moves a star of the job that was uploaded last to a position \[pc\] without a new plan; false where that needs a new plan.
    ///
    /// # Errors
    /// If there is no such star, or the position is not finite.
    fn move_star(&mut self, star: usize, position: DVec3) -> Result<bool>;

    /// Warnings of all renders so far.
    fn warnings(&self) -> Vec<String>;

    /// Reason why the processor did the last job in place of the device; `None` where the device did.
    fn fallback(&self) -> Option<String>;
}
