//! Pictures of a scene in one go.

use barnard::backend::cpu::{self, Findings, finished};
use barnard::control::Control;
use barnard::image::Image;
use barnard::plan::Plan;
use barnard::scene::Scene;

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::layout::Layout;
use crate::march::{Renderer, Tuning};

/// Renders the plan of `scene`; stars are drawn by the processor.
///
/// # Errors
/// For methods that no shader has, grids beyond the device's limits, and devices that give up.
pub fn render(gpu: &Gpu, scene: &Scene, plan: &Plan, tuning: Tuning, control: &Control) -> Result<(Image, Findings)> {
    let (data, findings) = Renderer::new(gpu, plan, tuning)?.radiance(control)?;
    let mut image = finished(scene, plan, data, findings, &gpu.name())?;
    if tuning.on_the_fly {
        image.notes.push(("density".into(), "noise at every sample; star depths and empty space as sampled".into()));
    }
    Ok((image, findings))
}

/// Renders on a device that `open` brings. One that gives up is opened once more, then the processor takes over; `tell` hears of it.
///
/// # Errors
/// As [`render`], but for devices that give up.
pub fn render_surely(
    mut open: impl FnMut() -> Result<Gpu>,
    scene: &Scene,
    plan: &Plan,
    (tuning, control): (Tuning, &Control),
    mut tell: impl FnMut(&str),
) -> Result<(Image, Findings)> {
    for _ in 0..2 {
        match render(&open()?, scene, plan, tuning, control) {
            Err(GpuError::Lost(why)) => tell(&format!("the device gave up: {why}")),
            done => return done,
        }
    }
    tell("the device gave up twice; rendering on the cpu");
    Ok(cpu::render(scene, plan, control)?)
}

/// Why no device can render this plan; none where one can, as far as its limits go.
pub fn unable(plan: &Plan, tuning: Tuning) -> Option<GpuError> {
    Layout::new(plan, Vec::new(), tuning.on_the_fly).err()
}
