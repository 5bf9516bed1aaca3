//! The pipelines of the last plans, by their shapes: a plan that has as many terms as one before it compiles nothing.

use crate::device::Gpu;
use crate::layout::ShaderLayout;
use crate::resources::pauses;
use crate::shader::source;
use crate::shape::ShaderShape;
use crate::tables::Offsets;
use crate::tuning::Tuning;

/// Most pipelines that are kept.
const KEPT: usize = 8;

/// The pipelines of the last shapes, the newest last.
pub struct Pipelines {
    tuning: Tuning,
    known: Vec<RecentPipelines>,
}

struct RecentPipelines {
    shape: ShaderShape,
    offsets: Offsets,
    pipeline: wgpu::ComputePipeline,
}

impl Pipelines {
    /// No pipelines yet; all will be made as `tuning` says.
    pub fn new(tuning: Tuning) -> Self {
        Self { tuning, known: Vec::new() }
    }

    /// The pipeline of a layout's shape, which is made where none is kept.
    pub fn of(&mut self, gpu: &Gpu, layout: &ShaderLayout) -> wgpu::ComputePipeline {
        let found = self.known.iter().position(|known| known.shape == layout.shape && known.offsets == layout.offsets);
        let newest = match found {
            Some(at) => self.known.remove(at),
            None => {
                let text = source(&layout.shape, &layout.offsets, self.tuning.workgroup, pauses(gpu, self.tuning));
                // SAFETY: every loop of the march ends (`shader::tests::loops_end`), and numbers that count stay countable
                // (`check_limits`).
                let pipeline = unsafe { gpu.pipeline_that_ends(&text, "main") };
                RecentPipelines { shape: layout.shape.clone(), offsets: layout.offsets.clone(), pipeline }
            }
        };
        let pipeline = newest.pipeline.clone();
        self.known.push(newest);
        let surplus = self.known.len().saturating_sub(KEPT);
        self.known.drain(..surplus);
        pipeline
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{plan_of, scene};
    use crate::layout::quads;
    use crate::test_device::device;

    /// Plans that come back find their pipelines, and the number of kept ones is limited.
    #[test]
    #[ignore = "needs a graphics adapter: --include-ignored"]
    fn shapes_that_come_back_are_not_compiled_again() {
        let gpu = device();
        let layout = |count: usize| {
            let plan = plan_of(&scene(8, &format!("count = {count}")));
            ShaderLayout::new(&plan, quads(&plan, 0), false).unwrap()
        };
        let mut pipelines = Pipelines::new(Tuning::default());
        let (few, many) = (layout(2), layout(3));
        assert_ne!(few.shape, many.shape);
        let made = [&few, &many, &few].map(|layout| pipelines.of(&gpu, layout));
        assert!(made[0] == made[2] && made[0] != made[1]);
        assert_eq!(pipelines.known.len(), 2);
        for count in 4..4 + KEPT {
            pipelines.of(&gpu, &layout(count));
        }
        assert_eq!(pipelines.known.len(), KEPT);
        assert!(pipelines.of(&gpu, &few) != made[0]);
    }
}
