//! Stereo: what two eyes see beside each other.
//!
//! An eye stands s = ±b/2 to the right of the camera. In a flat image both look straight ahead through one window at the
//! distance of convergence c: the image's middle lies −s/(c h) halves of its width from the axis, h as in `camera` (an
//! off-axis pair). In images of all around (omni-directional stereo; Ishiguro, Yamamoto & Tsuji 1992, IEEE Trans. Pattern
//! Anal. Mach. Intell. 14, 257) each direction d is seen by eyes that face it,
//!
//!   o = s f(α) d × u / |d × u|,   ray: from o towards (c d − o)/|c d − o|
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | b: from eye to eye | `distance_pc` | pc |
//! | c: where both eyes see one image | `convergence_pc` | pc |
//! | u: up; α: angle of d above the horizon, upwards or downwards | | |
//! | f: 1 below the first angle, 0 above the second, cos(πx/2) between | `merge` | rad |
//!
//! so that above one's head, where no eye is the left one, both see the same: Blender's pole merge. Parallel eyes have c = ∞.
//! Left out: heads that lean.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use spectra::units::{Angle, Length};

use crate::error::{Error, Result};
use crate::properties::{Choice, Choices, Key, KeyRow, OrDefault, Quantities, Required, Section};

const EYE_DISTANCE: Key<Length, Required> =
    Key::quantity::<Length>("eye_distance", "distance of the eyes; 1/30 of the distance to the object is deep, 1/100 shallow")
        .positive()
        .required();
const CONVERGENCE: Key<Length> =
    Key::quantity::<Length>("convergence", "distance of the screen plane; nearer objects appear in front of it")
        .positive()
        .otherwise("to the target");
const ARRANGEMENT: Key<Choice<Arrangement>, OrDefault> =
    Key::choice("arrangement", "over_under has the left eye on top; `%V` in an output name writes a file per eye").default("over_under");
pub(super) const POLE_MERGE: Key<Quantities<Angle>, OrDefault> =
    Key::quantities("pole_merge", "in 360° images, altitudes between which both eyes merge").default(&["60 deg", "75 deg"]);

/// Keys of `[camera.stereo]`.
pub(crate) const KEYS: &[KeyRow] = &[EYE_DISTANCE.row, CONVERGENCE.row, ARRANGEMENT.row, POLE_MERGE.row];

/// How images of both eyes become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Arrangement {
    /// The left eye's image is above the right one's.
    OverUnder,
    /// The left eye's image is to the left.
    SideBySide,
}

impl Choices for Arrangement {
    const ROWS: &'static [(&'static str, Self)] = &[("over_under", Self::OverUnder), ("side_by_side", Self::SideBySide)];
}

/// Two eyes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stereo {
    /// Combination of the two images.
    pub arrangement: Arrangement,
    /// The length from eye to eye \[pc\].
    pub distance_pc: f64,
    /// The distance at which both see one image \[pc\]; infinite for parallel eyes.
    pub convergence_pc: f64,
    /// Angles above and below the horizon between which both eyes become one \[rad\].
    pub merge: (f64, f64),
}

/// Default heights between which both eyes merge [rad].
const MERGE: (f64, f64) = (PI / 3.0, PI * 75.0 / 180.0);

impl Stereo {
    /// Eyes so far apart that see one image at a distance of convergence \[pc\], the left one above the right one.
    pub fn new(distance_pc: f64, convergence_pc: f64) -> Self {
        Self { arrangement: Arrangement::OverUnder, distance_pc, convergence_pc, merge: MERGE }
    }

    /// Refuses what no eyes can be.
    pub(super) fn check(&self) -> Result<()> {
        let positive = |v: f64| v > 0.0;
        if !(positive(self.distance_pc) && self.distance_pc.is_finite() && positive(self.convergence_pc)) {
            let found = format!("{} and {} pc", self.distance_pc, self.convergence_pc);
            return Err(Error::out_of_range("eye distance and convergence", found, "above zero"));
        }
        let (from, to) = self.merge;
        if !(0.0 <= from && from < to && to <= FRAC_PI_2 * (1.0 + 1e-9)) {
            let found = format!("{:.2} and {:.2} deg", from.to_degrees(), to.to_degrees());
            return Err(Error::out_of_range("pole_merge", found, "ascending, from 0 to 90 deg"));
        }
        Ok(())
    }
}

/// Reads `[camera.stereo]` of a camera whose target is so far away \[pc\].
pub(super) fn build(section: &Section, target_pc: f64) -> Result<Stereo> {
    section.check(KEYS)?;
    let ends = section.read(&POLE_MERGE)?;
    let wrong = || section.error(&POLE_MERGE, "pole_merge must be two ascending angles, such as [\"60 deg\", \"75 deg\"]");
    let &[from, to] = &ends[..] else { return Err(wrong()) };
    let stereo = Stereo {
        arrangement: section.read(&ARRANGEMENT)?,
        distance_pc: section.read(&EYE_DISTANCE)?.0,
        convergence_pc: section.read(&CONVERGENCE)?.map_or(target_pc, |length| length.0),
        merge: (from.0, to.0),
    };
    section.wrap(&POLE_MERGE, stereo.check())?;
    Ok(stereo)
}

/// One of two eyes in an image of all around.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    /// Offset to the right of the camera \[pc\].
    pub aside_pc: f64,
    /// The distance at which both eyes see one image \[pc\]; infinite for parallel eyes.
    pub convergence_pc: f64,
    /// Angles above and below the horizon between which both eyes become one \[rad\].
    pub merge: (f64, f64),
}

/// Halvings by which the height of a place is found: to the last digits.
const HALVINGS: usize = 64;

impl Eye {
    /// Offset of the eye for direction `d` from the camera \[pc\].
    fn offset(&self, d: DVec3, up: DVec3) -> DVec3 {
        let side = d.cross(up);
        self.aside_pc * self.fade(d.dot(up).abs().atan2(side.length())) * side.try_normalize().unwrap_or(DVec3::ZERO)
    }

    /// Relative eye offset at an angle above or below the horizon \[rad\], \[1\].
    fn fade(&self, height: f64) -> f64 {
        let (from, to) = self.merge;
        if height >= to { 0.0 } else { (FRAC_PI_2 * ((height - from) / (to - from)).max(0.0)).cos() }
    }

    /// The ray of direction `d`: where it starts, from the camera \[pc\], and where it goes.
    pub(super) fn ray(&self, d: DVec3, up: DVec3) -> (DVec3, DVec3) {
        let offset = self.offset(d, up);
        let direction = if self.convergence_pc.is_finite() { (d - offset / self.convergence_pc).normalize() } else { d };
        (offset, direction)
    }

    /// The direction whose ray goes through a place, seen from the camera \[pc\]; none where none does.
    ///
    /// A ray of height α is at ρ² = s²f²(1 − t/c)² + t² cos²α across and t sin α upwards, t the way along d.
    pub(super) fn towards(&self, place: DVec3, up: DVec3) -> Option<DVec3> {
        let near = self.convergence_pc.recip();
        let high = place.dot(up);
        let across = place - high * up;
        let rho = across.length();
        let Some(aside) = across.try_normalize() else { return (high != 0.0).then(|| high.signum() * up) };
        // How far across a ray of this height, that goes so far, stands beside its direction.
        let beside = |height: f64, t: f64| self.aside_pc * self.fade(height) * (1.0 - t * near);
        let (height, t) = if high == 0.0 {
            let s2 = self.aside_pc * self.aside_pc;
            let (a, b) = (1.0 + s2 * near * near, s2 * near);
            let square = b * b + a * (rho * rho - s2);
            if square < 0.0 {
                return None;
            }
            (0.0, (b + square.sqrt()) / a)
        } else {
            // At the height that the place has from the camera a ray reaches too far across, straight up not far enough.
            let (mut low, mut top) = (high.abs().atan2(rho), FRAC_PI_2);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + top);
                let t = high.abs() / middle.sin();
                let reaches = beside(middle, t).hypot(t * middle.cos());
                if reaches >= rho { low = middle } else { top = middle }
            }
            (low, high.abs() / low.sin())
        };
        if t <= 0.0 {
            return None;
        }
        // Turned back by what stands beside it.
        let (a, b) = (beside(height, t), t * height.cos());
        let ahead = (b * aside - a * aside.cross(up)).try_normalize()?;
        Some((height.cos() * ahead + high.signum() * height.sin() * up).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every place farther away than the eyes are from each other is found, wherever it is and however fast the eyes merge: the
    /// ray of its direction goes through it.
    #[test]
    fn places_are_found() {
        let part = |i: usize, step: f64| (step * (i + 1) as f64).fract();
        for merge in [MERGE, (70f64.to_radians(), 71f64.to_radians())] {
            for convergence_pc in [2.5, 30.0, f64::INFINITY] {
                for distance in [0.8, 1.5, 15.0, 1e12] {
                    let eye = Eye { aside_pc: -0.5, convergence_pc, merge };
                    for i in 0..500 {
                        let (z, turn) = (2.0 * part(i, 0.618_034) - 1.0, 2.0 * PI * part(i, 0.754_878));
                        let r = (1.0 - z * z).sqrt();
                        let place = distance * DVec3::new(r * turn.cos(), z, r * turn.sin());
                        let d = eye.towards(place, DVec3::Y).unwrap();
                        let (origin, direction) = eye.ray(d, DVec3::Y);
                        let off = (place - origin).cross(direction).length();
                        assert!(
                            off < 1e-9 * distance && (place - origin).dot(direction) > 0.0,
                            "{merge:?} {convergence_pc} {place} {off:e}"
                        );
                    }
                }
            }
        }
    }
}
