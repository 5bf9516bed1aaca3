//! The processor as a ray tracer, which stands behind every device.

use crate::tracer::{Failure, Light, Listener, RayTracer, Task, Turns};
use crate::transport::OnProcessor;
use crate::voxel::Voxel;

/// The processor as a tracer.
#[derive(Debug)]
pub struct Processor;

impl RayTracer for Processor {
    fn name(&self) -> String {
        "cpu".into()
    }

    fn start<'a>(&self, task: Task<'a>) -> Result<Box<dyn Turns + 'a>, Failure> {
        Ok(Box::new(OnProcessor::new(task)))
    }
}

/// A device, as long as it can, and the processor behind it.
pub(crate) struct Tracers<'a> {
    task: Task<'a>,
    turns: Option<Box<dyn Turns + 'a>>,
    /// Name of the device that traced the light.
    pub by: String,
}

impl<'a> Tracers<'a> {
    /// The processor alone where there is no device, or where it has no room.
    pub fn new(device: Option<&dyn RayTracer>, task: Task<'a>) -> Self {
        let Some(device) = device else { return Self { task, turns: None, by: Processor.name() } };
        match device.start(task) {
            Ok(turns) => Self { task, turns: Some(turns), by: device.name() },
            Err(Failure::Unable(why)) => Self { task, turns: None, by: Self::instead_of(&device.name(), &why) },
            Err(Failure::Stopped | Failure::NotFaster) => Self { task, turns: None, by: Processor.name() },
        }
    }

    /// The name of the processor where a device could not.
    fn instead_of(device: &str, why: &str) -> String {
        format!("{} ({device}: {why})", Processor.name())
    }

    /// The next turn ([`Turns::next`]).
    pub fn next(&mut self, voxels: Option<&[Voxel]>, light: &mut Light, listener: Listener) -> Result<Vec<f64>, Failure> {
        let task = self.task;
        let turns = self.turns.get_or_insert_with(|| Box::new(OnProcessor::new(task)));
        match turns.next(voxels, light, listener) {
            Err(Failure::Unable(why)) => {
                self.by = Self::instead_of(&self.by, &why);
                // The device's memory first.
                self.turns = None;
                let mut processor = Box::new(OnProcessor::new(task));
                let escaped = processor.next(voxels, light, listener);
                self.turns = Some(processor);
                escaped
            }
            found => found,
        }
    }
}
