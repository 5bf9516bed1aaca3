//! The neighbourhood of a star: where 1/r², the phase function and the star depth all change within a step.
//!
//! The segment is cut into equal angles as the star sees it (dt/r² = dϑ/b), each with its density and its exact star
//! depth.

use glam::DVec3;

use crate::field::Field;
use crate::geometry::Ray;
use crate::plan::SpatialPlan;
use crate::plan::segment::Segment;

/// A piece of a segment near a star.
pub struct NearPiece {
    /// The scattering of the piece, ∫ σ dt/r² [pc⁻²].
    pub scattering: f64,
    /// Optical depth at V, eye to piece to star \[1\].
    pub depth: f64,
    /// The cosine of the scattering angle, +1 forward.
    pub cosine: f64,
}

/// The dust near a star.
pub struct DustNearby<S, D> {
    /// The extinction σ at V of a place [pc⁻¹].
    pub sigma: S,
    /// Optical depth at V from the star to a place \[1\].
    pub depth: D,
}

/// The dust around a star as its samples have it.
pub fn samples(space: &SpatialPlan, star: DVec3) -> DustNearby<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> f64> {
    let sigma = |p| space.dust.as_ref().map_or(0.0, |dust| dust.at(p));
    DustNearby { sigma, depth: move |p| space.depth(star, p) }
}

/// The dust around a star as the fields themselves have it.
pub fn fields(space: &SpatialPlan, star: DVec3) -> DustNearby<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> f64> {
    DustNearby { sigma: |p| space.sigma_at(p), depth: move |p| space.depth(star, p) + space.depth_beyond_samples(star, p) }
}

/// The resolution with which the neighbourhood of a star is marched.
#[derive(Debug, Clone, Copy)]
pub struct Resolution {
    /// The widest angle over which the phase function changes but little \[rad\].
    pub phase_angle: f64,
    /// The factor by which pieces are more than those of the back ends.
    pub fineness: f64,
}

/// Widest angle of a piece \[rad\].
pub const PIECE: f64 = 0.12;
/// The most by which the optical depth at V along a ray may grow in one: from the eye and from the star it changes by
/// up to twice that, which a midpoint takes for none.
pub const PIECE_DEPTH: f64 = 0.05;
/// Most pieces of a segment.
pub const MAX_PIECES: usize = 256;
/// A ray through the star itself passes by at this distance \[pc\], as in the reference.
pub const CLOSEST: f64 = 1e-6;
/// Segments closer than this many voxels of the star depths are cut.
pub const NEAR_VOXELS: f64 = 2.5;
/// Segments that the star sees under more than about this angle \[rad\] are cut.
pub const NEAR_ANGLE: f64 = 0.35;
/// Steps longer than this part of their distance to a star are marched in parts: what is near is bright, and is sampled
/// finely.
pub const PART_DISTANCE: f64 = 0.2;
/// The shortest part of a step, in voxels.
pub const SHORTEST_PART: f64 = 0.5;

/// Widest angle of a piece beside a gathered star \[rad\].
pub const NEAR_FIELD_PIECE: f64 = 0.4;
/// The accuracy to which the phase function is asked there.
pub const NEAR_FIELD_ACCURACY: f64 = 0.02;
/// Most pieces of a segment there.
pub const NEAR_FIELD_PIECES: usize = 32;

/// Widest angle of a piece beside a gathered star for a phase function that may be asked at the middle of `phase_angle`
/// at an `accuracy` \[rad\].
pub fn near_field_piece(phase_angle: f64, accuracy: f64) -> f64 {
    NEAR_FIELD_PIECE.min(phase_angle * (NEAR_FIELD_ACCURACY / accuracy).sqrt())
}

/// The number of parts in which a step of length `dt` must be marched, so that each is short beside its distance to a
/// star with the closest approach `b` at `foot`; all lengths in pc, along the ray from where the step starts.
pub fn parts(b: f64, foot: f64, dt: f64, voxel: f64) -> usize {
    let nearest = foot - foot.clamp(0.0, dt);
    let distance = (b * b + nearest * nearest).sqrt().max(NEAR_VOXELS * voxel);
    (dt / (PART_DISTANCE * distance)).min(dt / (SHORTEST_PART * voxel)).ceil().max(1.0) as usize
}

/// Most angles at which the phase function is asked in one segment or piece.
pub const MAX_PHASES: usize = 64;

/// The number of angles at which a phase function must be asked within `angle` \[rad\].
pub fn phases(angle: f64, phase_angle: f64) -> usize {
    ((angle / phase_angle).ceil() as usize).clamp(1, MAX_PHASES)
}

/// The pieces of a segment of `ray`, split where the phase function changes within one.
pub fn pieces(
    dust: DustNearby<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> f64>,
    resolution: Resolution,
    star: DVec3,
    ray: &Ray,
    segment: &Segment,
    mut visit: impl FnMut(NearPiece),
) {
    let Resolution { phase_angle, fineness } = resolution;
    let Segment { from, to, tau, growth } = *segment;
    let foot = (star - ray.origin).dot(ray.direction);
    let b = (star - ray.at(foot)).length().max(CLOSEST);
    let (start, end) = (((from - foot) / b).atan(), ((to - foot) / b).atan());
    let count = fineness * ((end - start) / PIECE).max(growth / PIECE_DEPTH);
    let count = count.ceil().clamp(2.0, fineness * MAX_PIECES as f64);
    let width = (end - start) / count;
    let phases = phases(width, phase_angle);
    for i in 0..count as usize {
        let theta = start + (i as f64 + 0.5) * width;
        let t = foot + b * theta.tan();
        let mut depth = None;
        for j in 0..phases {
            // Seen from the star the ray runs through θ; light turns by θ + π/2, and where it goes to counts as much as
            // what is there.
            let theta = start + (i as f64 + (j as f64 + 0.5) / phases as f64) * width;
            let sigma = (dust.sigma)(ray.at(foot + b * theta.tan()));
            if sigma > 0.0 {
                let along = tau + growth * ((t - from) / (to - from)).clamp(0.0, 1.0);
                let depth = *depth.get_or_insert_with(|| along + (dust.depth)(ray.at(t)));
                visit(NearPiece { scattering: sigma * width / (b * phases as f64), depth, cosine: -theta.sin() });
            }
        }
    }
}
