//! Rays and boxes \[pc\].

use glam::DVec3;

use crate::error::{Error, Result};

/// A half line.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// The point at which it starts \[pc\].
    pub origin: DVec3,
    /// The direction in which it goes, of length one.
    pub direction: DVec3,
}

impl Ray {
    /// The point at distance `t_pc`.
    pub fn at(&self, t_pc: f64) -> DVec3 {
        self.origin + t_pc * self.direction
    }

    /// The ray from `a` towards `b`, with the distance between them \[pc\].
    pub fn between(a: DVec3, b: DVec3) -> (Self, f64) {
        let length = (b - a).length();
        let direction = if length > 0.0 { (b - a) / length } else { DVec3::X };
        (Self { origin: a, direction }, length)
    }
}

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The lowest corner \[pc\].
    pub low: DVec3,
    /// The highest corner \[pc\].
    pub high: DVec3,
}

impl Bounds {
    /// The cube of half side `half_pc` around `centre`.
    pub fn cube(centre: DVec3, half_pc: f64) -> Self {
        Self { low: centre - DVec3::splat(half_pc), high: centre + DVec3::splat(half_pc) }
    }

    /// Problem with the box, in words; `None` if it is valid.
    pub fn fault(&self) -> Option<String> {
        const EDGES: std::ops::RangeInclusive<f64> = 1e-25..=1e15;
        let (size, away) = (self.size(), self.low.abs().max(self.high.abs()).max_element());
        let sound = size.is_finite() && size.to_array().iter().all(|edge| EDGES.contains(edge) && *edge > 1e-9 * away);
        (!sound).then(|| {
            let [x, y, z] = size.to_array();
            format!(
                "the box of {x:e} x {y:e} x {z:e} pc, {away:e} pc from the origin, is out of range; edges must be {:e} to {:e} pc, and at least 1e-9 of that distance",
                EDGES.start(),
                EDGES.end()
            )
        })
    }

    /// Validated box.
    ///
    /// # Errors
    /// If it is not, with what is wrong.
    pub fn checked(self) -> Result<Self> {
        self.fault().map_or(Ok(self), |fault| Err(Error::Bounds(fault)))
    }

    /// The lengths of the edges \[pc\].
    pub fn size(&self) -> DVec3 {
        self.high - self.low
    }

    /// True if `p` lies inside or on the border.
    pub fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.low).all() && p.cmple(self.high).all()
    }

    /// True if `p` lies inside or on a lower border: of boxes side by side, one holds it.
    #[inline(always)]
    pub fn holds(&self, p: DVec3) -> bool {
        p.cmpge(self.low).all() && p.cmplt(self.high).all()
    }

    /// The box whose faces lie farther out by a length \[pc\].
    pub fn grown(&self, by_pc: f64) -> Self {
        Self { low: self.low - by_pc, high: self.high + by_pc }
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box that both hold, where they meet.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        low.cmplt(high).all().then_some(Self { low, high })
    }

    /// The part of the ray inside, from zero on, as distances \[pc\].
    pub fn clip(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            if d == 0.0 {
                if o < self.low[axis] || o > self.high[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.low[axis] - o) / d, (self.high[axis] - o) / d);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near < far).then_some((near, far))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips() {
        let cube = Bounds::cube(DVec3::ZERO, 1.0);
        let ray = Ray { origin: DVec3::new(0.0, 0.0, -5.0), direction: DVec3::Z };
        assert_eq!(cube.clip(&ray), Some((4.0, 6.0)));
        let inside = Ray { origin: DVec3::ZERO, direction: DVec3::Z };
        assert_eq!(cube.clip(&inside), Some((0.0, 1.0)));
        let beside = Ray { origin: DVec3::new(2.0, 0.0, -5.0), direction: DVec3::Z };
        assert_eq!(cube.clip(&beside), None);
        let behind = Ray { origin: DVec3::new(0.0, 0.0, 5.0), direction: DVec3::Z };
        assert_eq!(cube.clip(&behind), None);
    }
}
