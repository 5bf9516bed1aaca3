//! Frustums of rays around a star: which planes they meet, and how far rays are apart. See `frustum_sweep`.

use glam::DVec3;

use crate::field::Lattice;

/// Planes in the first tier [voxels].
const FIRST_TIER: f64 = 8.0;
/// Rays along a voxel edge at the far end of a tier.
const RAYS_PER_VOXEL: f64 = 1.0;

/// One frustum around a star; `axes` are those of u, v and w.
#[derive(Debug, Clone)]
pub struct Frustum {
    /// The place of the star along u, v, w, zero at the first centre \[voxels\].
    pub star: [f64; 3],
    /// Axes of the lattice that are u, v and w; u before v.
    pub axes: [usize; 3],
    /// Voxels along u, v, w.
    pub dims: [usize; 3],
    /// Edges of a voxel \[pc\].
    pub edge: [f64; 3],
    /// ±1: towards larger or smaller w.
    pub sign: f64,
}

/// Rays of a tier: a grid in slopes [voxels a plane].
#[derive(Debug, Clone)]
pub struct Rays {
    /// Slopes of ray 1 of each axis; ray 0 stands before it, so that a cubic has its four.
    pub first: [f64; 2],
    /// The spacing from ray to ray.
    pub spacing: f64,
    /// Rays along u and v.
    pub counts: [usize; 2],
}

/// Rays for the voxels of planes number `begin` to `end`, counted as rays meet them.
#[derive(Debug, Clone)]
pub struct TierOf {
    /// The rays of the tier.
    pub rays: Rays,
    /// The first of its planes.
    pub begin: usize,
    /// The plane behind the tier's last.
    pub end: usize,
}

/// The six frustums around `star` \[pc\] through the voxels of `lattice`.
pub fn frustums(lattice: &Lattice, star: DVec3) -> Vec<Frustum> {
    let index = (star - lattice.bounds.low) / lattice.voxel_pc() - 0.5;
    let frustum = |axes: [usize; 3], sign| Frustum {
        star: axes.map(|a| index[a]),
        axes,
        dims: axes.map(|a| lattice.dims[a]),
        edge: axes.map(|a| lattice.voxel_pc()[a]),
        sign,
    };
    [[0, 1, 2], [0, 2, 1], [1, 2, 0]].into_iter().flat_map(|axes| [frustum(axes, -1.0), frustum(axes, 1.0)]).collect()
}

impl Frustum {
    /// Planes in the order in which rays meet them.
    pub fn planes(&self) -> Vec<usize> {
        let last = self.dims[2] as f64 - 1.0;
        if self.sign > 0.0 {
            let first = (self.star[2].floor() + 1.0).max(0.0);
            if first > last { Vec::new() } else { (first as usize..self.dims[2]).collect() }
        } else {
            let first = (self.star[2].ceil() - 1.0).min(last);
            if first < 0.0 { Vec::new() } else { (0..=first as usize).rev().collect() }
        }
    }

    /// Distance of the plane before number `number` of those that rays meet, or at which rays begin \[voxels\].
    pub fn before(&self, planes: &[usize], number: usize) -> f64 {
        if number == 0 { self.entry() } else { self.distance(planes[number - 1]) }
    }

    /// Distance of a plane from the star \[voxels\].
    pub fn distance(&self, plane: usize) -> f64 {
        self.sign * (plane as f64 - self.star[2])
    }

    /// Distance at which rays enter the box through the face that is nearest along w, zero inside \[voxels\].
    pub fn entry(&self) -> f64 {
        let face = if self.sign > 0.0 { -0.5 } else { self.dims[2] as f64 - 0.5 };
        (self.sign * (face - self.star[2])).max(0.0)
    }

    /// Tiers of rays, which double in distance.
    pub fn tiers(&self) -> Vec<TierOf> {
        let planes = self.planes();
        let (mut tiers, mut begin) = (Vec::new(), 0);
        while begin < planes.len() {
            let near = self.distance(planes[begin]);
            let reach = (2.0 * near).max(FIRST_TIER);
            let end = begin + planes[begin..].iter().take_while(|p| self.distance(**p) <= reach).count();
            tiers.extend(self.rays(near, self.distance(planes[end - 1])).map(|rays| TierOf { rays, begin, end }));
            begin = end;
        }
        tiers
    }

    /// The rays towards all voxels between two distances, if the frustum holds any.
    fn rays(&self, near: f64, far: f64) -> Option<Rays> {
        let spacing = 1.0 / (RAYS_PER_VOXEL * far);
        let mut rays = Rays { first: [0.0; 2], spacing, counts: [0; 2] };
        for axis in 0..2 {
            let (low, high) = (-self.star[axis], self.dims[axis] as f64 - 1.0 - self.star[axis]);
            let (low, high) = ((low / near).min(low / far), (high / near).max(high / far));
            if low > 1.0 || high < -1.0 {
                return None;
            }
            let (low, high) = (low.max(-1.0), high.min(1.0));
            rays.first[axis] = low;
            rays.counts[axis] = ((high - low) / spacing).ceil() as usize + 4;
        }
        Some(rays)
    }

    /// The border through which rays come in along u or v: none where the star stands between both.
    pub fn side(&self, axis: usize) -> Option<f64> {
        let (low, high) = (-0.5, self.dims[axis] as f64 - 0.5);
        if self.star[axis] < low {
            Some(low)
        } else if self.star[axis] > high {
            Some(high)
        } else {
            None
        }
    }

    /// True if any ray comes in through a side.
    pub fn has_side_entries(&self) -> bool {
        (0..2).any(|axis| self.side(axis).is_some())
    }

    /// Distance at which a ray of this slope is past the side's border \[voxels\]; infinite if it never is.
    pub fn enters(&self, axis: usize, slope: f64) -> f64 {
        let Some(border) = self.side(axis) else { return 0.0 };
        let way = border - self.star[axis];
        if way * slope > 0.0 { way / slope } else { f64::INFINITY }
    }
}
