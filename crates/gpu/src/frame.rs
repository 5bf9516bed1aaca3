//! Data that change between pictures.

use barnard::camera::panorama::PanoramaLayout;
use barnard::camera::{Camera, Eye, Projection};
use barnard::geometry::Bounds;
use barnard::plan::{END_SHARE, Plan, Stepping};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// The fields are those of `frame.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FrameConstants {
    pub middle: [f32; 4],
    pub across: [f32; 4],
    pub upwards: [f32; 4],
    pub forward: [f32; 4],
    pub turn_x: [f32; 4],
    pub turn_y: [f32; 4],
    pub low: [f32; 4],
    pub high: [f32; 4],
    pub steps: [f32; 4],
    pub limits: [f32; 4],
    pub jitter: [f32; 4],
    pub size: [u32; 4],
    pub strip: [u32; 4],
    pub counts: [u32; 4],
    pub depths: [f32; 4],
    pub seeds: [u32; 4],
}

/// Turns of loops that a ray takes before it pauses on a software adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Patience(pub u32);

impl Patience {
    /// The turns of a ray that runs undisturbed: half of what llvmpipe allows, since neighbours count together.
    pub const FULL: Patience = Patience(32_000);
    /// The patience that pauses a ray after every part of a step.
    pub const NONE: Patience = Patience(0);

    /// The patience to go on with after a ray paused too late.
    pub fn less(self) -> Self {
        if self.0 < 500 { Self::NONE } else { Patience(self.0 / 4) }
    }
}

/// Rows of the picture that a dispatch renders, and those that its buffer holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRows {
    /// The rows of the dispatch.
    pub strip: Strip,
    /// The rows that the buffer holds.
    pub stored: Strip,
}

/// Rows that follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strip {
    pub first: usize,
    pub count: usize,
}

/// The way in which one pass over a picture takes its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass {
    /// The place in its pixel that a ray goes through, from the middle [pixels].
    pub subpixel: (f32, f32),
    /// The part of a step in which a ray starts, moved from pixel to pixel; none: at the border.
    pub start: Option<f32>,
    /// Samples in parts of the plan's.
    pub steps: f32,
    /// The weight of the pass beside the passes before it.
    pub share: f32,
}

impl Pass {
    /// The picture as the plan says.
    pub const WHOLE: Pass = Pass { subpixel: (0.0, 0.0), start: None, steps: 1.0, share: 1.0 };
    /// A first look, with a quarter of the samples.
    pub const COARSE: Pass = Pass { steps: 0.25, start: Some(0.5), ..Pass::WHOLE };

    /// Number `n` of the passes over a picture with `s` rays along each side of a pixel.
    pub fn supersampling(s: usize, n: usize) -> Self {
        let place = |i: usize| ((i as f64 + 0.5) / s as f64 - 0.5) as f32;
        Pass { subpixel: (place(n % s), place(n / s)), share: 1.0 / (n + 1) as f32, ..Pass::WHOLE }
    }

    /// Number `n` of passes that refine a picture without end: a first look, then pictures with the plan's samples,
    /// each at other places, whose mean is that of pixels with an area.
    pub fn refining(n: u32) -> Self {
        if n == 0 {
            return Pass::COARSE;
        }
        // Roberts' R3 sequence: powers of the root of x⁴ = x + 1.
        let part = |step: f64| (0.5 + step * f64::from(n)).fract() as f32;
        let subpixel = (part(0.819_172_513_396_164_4) - 0.5, part(0.671_043_606_703_789_2) - 0.5);
        Pass { subpixel, start: Some(part(0.549_700_477_901_970_3)), steps: 1.0, share: 1.0 / n as f32 }
    }
}

/// How pixels become rays, seen from the middle of the scene.
struct SightConstants {
    middle: [f32; 4],
    across: DVec3,
    upwards: DVec3,
    forward: DVec3,
    turn_x: [f32; 4],
    turn_y: [f32; 4],
}

impl SightConstants {
    fn of(camera: &Camera, middle: DVec3) -> Self {
        let (right, up) = (camera.right, camera.up);
        // Towards the image's middle, of length one along the axis of view, and where that meets the plane of the middle.
        let aside = camera.offset.0 * right + camera.offset.1 * up;
        // The observer moves along the view until the middle of the scene is beside them.
        let ahead = (middle - camera.position).dot(camera.forward).max(0.0);
        match camera.projection {
            Projection::Perspective { half_width: h } => {
                let forward = camera.forward + h * aside;
                Self {
                    middle: four(camera.position - middle + ahead * forward, ahead as f32),
                    across: ahead * h * right,
                    upwards: ahead * h * up,
                    forward,
                    turn_x: four(h * right, 0.0),
                    turn_y: four(h * up, 0.0),
                }
            }
            Projection::Orthographic { half_width_pc: h } => Self {
                middle: four(camera.position + h * aside - middle + ahead * camera.forward, ahead as f32),
                across: h * right,
                upwards: h * up,
                forward: camera.forward,
                turn_x: [0.0; 4],
                turn_y: [0.0; 4],
            },
            Projection::Panorama { layout, half_width } => {
                let [forward, across, upwards] = layout.axes(&[camera.forward, right, up]);
                let half_aperture = if let PanoramaLayout::Dome { half_aperture, .. } = layout { half_aperture } else { 0.0 };
                // One eye alone stands nowhere aside.
                let eye = camera.eye.unwrap_or(Eye { aside_pc: 0.0, convergence_pc: f64::INFINITY, merge: (0.0, 1.0) });
                Self {
                    middle: four(camera.position - middle, 0.0),
                    across,
                    upwards,
                    forward,
                    turn_x: [camera.offset.0, camera.offset.1, half_width, half_aperture].map(|v| v as f32),
                    turn_y: [eye.aside_pc, 1.0 / eye.convergence_pc, eye.merge.0, eye.merge.1].map(|v| v as f32),
                }
            }
        }
    }
}

impl FrameConstants {
    /// The frame of a plan whose loops count their turns, seen from `middle`, whose terms have the
    /// extinctions `k`; dust is at most `brightest` [pc⁻¹].
    pub fn new(plan: &Plan, shown_turns: usize, middle: DVec3, k: &[f32], brightest: f32, counts: [u32; 4]) -> Self {
        let camera: &Camera = plan.camera();
        let bounds = plan.space().occupied.unwrap_or(Bounds { low: middle, high: middle });
        let sight = SightConstants::of(camera, middle);
        let voxel = plan.space().voxel_pc();
        let (per_voxel, fixed) = match plan.stepping() {
            Stepping::PerVoxel(n) | Stepping::Paired(n) => (n, 0.0),
            Stepping::Fixed(n) => (0.0, n as f64),
        };
        let (smallest, largest) = k.iter().fold((f32::MAX, 0.0f32), |(low, high), k| (low.min(*k), high.max(*k)));
        let angle = plan.spectral().phase_angle.min(10.0);
        Self {
            middle: sight.middle,
            across: four(sight.across, camera.up.x as f32),
            upwards: four(sight.upwards, camera.up.y as f32),
            forward: four(sight.forward, camera.up.z as f32),
            turn_x: sight.turn_x,
            turn_y: sight.turn_y,
            low: four(bounds.low - middle, 0.0),
            high: four(bounds.high - middle, 0.0),
            steps: [per_voxel as f32, fixed as f32, voxel as f32, angle as f32],
            limits: [smallest, END_SHARE * plan.spectral().accuracy as f32, brightest, largest],
            jitter: [0.0; 4],
            size: [camera.width as u32, camera.height as u32, 0, 0],
            strip: [0; 4],
            counts,
            depths: [plan.space().star_depth as f32, shown_turns as f32, 0.0, 0.0],
            seeds: plan.space().cloud.as_ref().map_or([0; 4], |(cloud, _)| {
                let [x, y, z] = cloud.warps.map(|w| w.seed());
                [cloud.noise.seed(), x, y, z]
            }),
        }
    }

    /// The frame of some rows in one pass; rays that paused go on where they are `resumed`.
    pub fn of(&self, rows: FrameRows, pass: &Pass, patience: Patience, resumed: bool) -> FrameConstants {
        let [per_voxel, fixed, voxel, angle] = self.steps;
        let fixed = if fixed > 0.0 { (fixed * pass.steps).ceil() } else { 0.0 };
        let FrameRows { strip, stored } = rows;
        FrameConstants {
            steps: [per_voxel * pass.steps, fixed, voxel, angle],
            jitter: [pass.subpixel.0, pass.subpixel.1, pass.start.unwrap_or(-1.0), pass.share],
            size: [self.size[0], self.size[1], patience.0, u32::from(resumed)],
            strip: [strip.first, strip.count, stored.first, stored.count].map(|n| n as u32),
            ..*self
        }
    }
}

/// A place, and one number more.
pub fn four(p: DVec3, fourth: f32) -> [f32; 4] {
    [p.x as f32, p.y as f32, p.z as f32, fourth]
}
