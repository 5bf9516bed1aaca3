//! Patches of the sphere around a star: those of a cube's faces, in equal angles, each of which falls into four.

use std::f64::consts::FRAC_PI_4;

use glam::DVec3;

/// A patch of a face, one of 2^level along each of its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    face: u8,
    level: u32,
    place: [u32; 2],
}

impl Patch {
    /// All patches of a level.
    pub fn all(level: u32) -> impl Iterator<Item = Self> {
        let edge = 1u32 << level;
        (0..6).flat_map(move |face| (0..edge).flat_map(move |j| (0..edge).map(move |i| Self { face, level, place: [i, j] })))
    }

    /// The four that it is made of.
    pub fn parts(self) -> [Self; 4] {
        let [i, j] = self.place.map(|i| 2 * i);
        [[i, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]].map(|place| Self { level: self.level + 1, place, ..self })
    }

    /// The face of the cube: along x, y or z, and of two of these first the one towards higher numbers.
    pub fn face(self) -> u32 {
        self.face.into()
    }

    /// Number of subdivisions of a face.
    pub fn level(self) -> u32 {
        self.level
    }

    /// The tangents of the angles at which its middle stands, along the two axes behind that of its face.
    pub fn tangents(self) -> [f64; 2] {
        [0, 1].map(|axis| self.tangent(axis, 1))
    }

    /// A place on the cube's face, in halves of a patch from its lower edge: 0, 1 and 2.
    fn tangent(self, axis: usize, half: u32) -> f64 {
        let place = f64::from(2 * self.place[axis] + half) / f64::from(2u32 << self.level);
        ((2.0 * place - 1.0) * FRAC_PI_4).tan()
    }

    /// The direction of its middle.
    pub fn direction(self) -> DVec3 {
        self.towards([1, 1])
    }

    fn towards(self, half: [u32; 2]) -> DVec3 {
        let (u, v) = (self.tangent(0, half[0]), self.tangent(1, half[1]));
        let (axis, sign) = (usize::from(self.face / 2), if self.face.is_multiple_of(2) { 1.0 } else { -1.0 });
        let mut direction = [0.0; 3];
        (direction[axis], direction[(axis + 1) % 3], direction[(axis + 2) % 3]) = (sign, u, v);
        DVec3::from(direction).normalize()
    }

    /// The directions of its corners.
    pub fn corners(self) -> [DVec3; 4] {
        [[0, 0], [2, 0], [0, 2], [2, 2]].map(|corner| self.towards(corner))
    }

    /// The largest angle between its middle and its corners \[rad\].
    pub fn reach(self) -> f64 {
        let middle = self.direction();
        self.corners().map(|corner| corner.dot(middle).min(1.0).acos()).into_iter().fold(0.0, f64::max)
    }

    /// Its solid angle \[sr\].
    pub fn solid_angle(self) -> f64 {
        // That of the rectangle from the middle of the face to a place.
        let corner = |i: u32, j: u32| {
            let (u, v) = (self.tangent(0, i), self.tangent(1, j));
            (u * v / (1.0 + u * u + v * v).sqrt()).atan()
        };
        corner(2, 2) - corner(0, 2) - corner(2, 0) + corner(0, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Patches fill the sphere, parts fill their patch, and directions lie within.
    #[test]
    fn patches_fill_the_sphere() {
        for level in [0, 1, 4] {
            let all: f64 = Patch::all(level).map(Patch::solid_angle).sum();
            assert!((all - 4.0 * std::f64::consts::PI).abs() < 1e-10, "{level}: {all}");
        }
        for patch in Patch::all(2) {
            let parts: f64 = patch.parts().into_iter().map(Patch::solid_angle).sum();
            assert!((parts / patch.solid_angle() - 1.0).abs() < 1e-12);
            assert!(patch.parts().iter().all(|part| part.direction().dot(patch.direction()).acos() < patch.reach()));
        }
        let mean: DVec3 = Patch::all(3).map(|patch| patch.direction() * patch.solid_angle()).sum();
        assert!(mean.length() < 1e-12);
    }
}
