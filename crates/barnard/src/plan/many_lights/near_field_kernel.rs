//! The kernel around a gathered star: what of its light is marched and what is gathered, eq. (24) of docs/method.md,
//! and depths within.

use glam::DVec3;

use crate::geometry::Bounds;

/// The kernel w = (1 − q)² for q < 1, 0 beyond, q = (b² + t² s)/R², around a star: what of its light is not gathered.
/// Before the star, where light goes on towards the eye, s = (R/L)²: phase functions are peaked there, and a peak is
/// wider than cells only from some distance on; behind it s = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearFieldKernel {
    /// R: across the line of sight, and behind the star \[pc\].
    pub reach_pc: f64,
    /// L: before the star \[pc\].
    pub ahead_pc: f64,
}

/// A kernel in single precision.
#[derive(Debug, Clone, Copy)]
pub struct KernelShape {
    /// The inverse square of R across the line of sight, 1/R² [pc⁻²].
    pub inverse_square: f32,
    /// 1 − s before the star.
    pub flat: f32,
}

impl NearFieldKernel {
    /// A kernel of the same radius in all directions.
    pub fn even(reach_pc: f64) -> Self {
        Self { reach_pc, ahead_pc: reach_pc }
    }

    /// The volume inside the kernel \[pc³\].
    pub fn volume(&self) -> f64 {
        2.0 / 3.0 * std::f64::consts::PI * self.reach_pc * self.reach_pc * (self.reach_pc + self.ahead_pc)
    }

    /// Copy of the kernel in single precision.
    pub fn shape(&self) -> KernelShape {
        KernelShape { inverse_square: self.reach_pc.powi(-2) as f32, flat: (1.0 - (self.reach_pc / self.ahead_pc).powi(2)) as f32 }
    }

    /// The share w of the light that is marched, at a squared distance \[pc²\] where light turns by an angle of this
    /// cosine.
    pub fn share(&self, square: f64, cosine: f64) -> f64 {
        let ahead = cosine.max(0.0);
        let flat = 1.0 - (self.reach_pc / self.ahead_pc).powi(2);
        let part = 1.0 - square * (1.0 - flat * ahead * ahead) / (self.reach_pc * self.reach_pc);
        if part > 0.0 { part * part } else { 0.0 }
    }

    /// The box around a kernel whose star is at the origin, the eye being in this direction \[pc\].
    pub fn bounds(&self, eye: DVec3) -> Bounds {
        // Eyes that are near see it under other angles.
        let end = (self.ahead_pc - self.reach_pc) * eye;
        let around = DVec3::splat(AROUND * self.reach_pc);
        Bounds { low: end.min(DVec3::ZERO) - around, high: end.max(DVec3::ZERO) + around }
    }
}

/// The factor by which the box around a kernel is larger than the kernel.
const AROUND: f64 = 1.25;

impl KernelShape {
    /// (1 − w)/r²: what is gathered [pc⁻²].
    #[inline(always)]
    pub fn beyond(&self, square: f32, cosine: f32) -> f32 {
        let ahead = if cosine > 0.0 { cosine } else { 0.0 };
        let scale = self.inverse_square * (1.0 - self.flat * ahead * ahead);
        let part = square * scale;
        if part < 1.0 { scale * (2.0 - part) } else { 1.0 / square }
    }
}

/// Places along a star's line of sight, as far as its kernel goes, at which its depth is known.
pub const PROFILE: usize = 8;
/// Depths at V from a star to those, itself the first \[1\].
pub type Profile = [f32; PROFILE + 1];

/// Depth at V from a star to a place in its kernel: that of a mean σ around it, of its profile before it \[1\].
#[inline(always)]
pub fn depth_within(profile: &Profile, inverse_step: f32, sigma: f32, distance: f32, cosine: f32) -> f32 {
    let around = distance * sigma;
    let ahead = if cosine > 0.0 { cosine * cosine } else { 0.0 };
    let at = (distance * inverse_step).min(PROFILE as f32);
    let i = (at as usize).min(PROFILE - 1);
    let along = profile[i] + (at - i as f32) * (profile[i + 1] - profile[i]);
    around + ahead * (along - around)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is gathered and what is marched add up to a star's light in every direction, and nothing is marched beyond
    /// the kernel.
    #[test]
    fn kernels_part_the_light() {
        for kernel in [NearFieldKernel::even(0.3), NearFieldKernel { reach_pc: 0.3, ahead_pc: 1.1 }] {
            let shape = kernel.shape();
            for i in 1..400 {
                for cosine in [-1.0, -0.4, 0.0, 0.3, 0.8, 1.0] {
                    let square = (0.004 * f64::from(i)).powi(2);
                    let beyond = f64::from(shape.beyond(square as f32, cosine as f32));
                    let sum = kernel.share(square, cosine) + square * beyond;
                    assert!((sum - 1.0).abs() < 2e-6, "{kernel:?} {square} {cosine}: {sum}");
                    // Never more than at the star.
                    assert!(beyond <= 2.0 / (0.3 * 0.3) * (1.0 + 1e-6));
                }
            }
            assert_eq!(kernel.share((kernel.reach_pc * 1.001).powi(2), -1.0), 0.0);
            assert_eq!(kernel.share((kernel.ahead_pc * 1.001).powi(2), 1.0), 0.0);
            assert!(kernel.share((kernel.reach_pc * 0.9).powi(2), 1.0) > 0.0);
        }
    }
}
