//! Directions of a face that are mirror images of each other, whose harmonics are alike but for their signs.
//!
//! A real harmonic is even or odd in each coordinate. Mirrored in the two axes of a face, up to four directions share
//! the sums of its four kinds,
//!
//!   S(±u, ±v) = S_ee ± S_oe ± S_eo ± S_oo
//!
//! so that sources and moments of the four cost what those of one do, and a few sums.

use glam::DVec3;

use super::beam::Beam;
use super::harmonics::{COUNT, harmonics};
use crate::packet::{LANES, Lane, fma};

/// Kinds of harmonics: even and odd along the columns and along the rows of a face.
const KINDS: usize = 4;

/// Beams that are mirror images of each other.
pub(super) struct Mirrors {
    /// The number of each beam, and its sign for each kind.
    beams: Vec<(usize, [f32; KINDS])>,
    /// For each kind the numbers of its harmonics, what they scatter into the first beam, and its quadrature weights.
    kinds: [Vec<MirrorTerm>; KINDS],
}

struct MirrorTerm {
    number: usize,
    /// The harmonic times what is scattered of it.
    harmonic: f32,
    quadrature: f32,
}

/// The kind of each harmonic across these axes.
fn kinds(across: (usize, usize)) -> [usize; COUNT] {
    // A place where no harmonic is zero.
    let place = DVec3::new(0.31, 0.53, 0.79).normalize();
    let values = harmonics(place);
    let is_odd = |axis: usize| {
        let mut mirrored = place;
        mirrored[axis] = -mirrored[axis];
        harmonics(mirrored).iter().zip(values).map(|(m, y)| usize::from(m * y < 0.0)).collect::<Vec<usize>>()
    };
    let (columns, rows) = (is_odd(across.0), is_odd(across.1));
    std::array::from_fn(|h| columns[h] + 2 * rows[h])
}

impl Mirrors {
    /// Groups the beams of a face by their directions, with as many harmonics as there are albedos times Legendre moments
    /// ω p_l in `scattering`.
    pub(super) fn of(beams: &[Beam], towards: &[DVec3], across: (usize, usize), scattering: &[f32]) -> Vec<Self> {
        let kinds = kinds(across);
        let alike = |a: &DVec3, b: &DVec3| (a.abs() - b.abs()).abs().max_element() < 1e-9;
        let mut groups: Vec<(usize, Self)> = Vec::new();
        for (b, value) in towards.iter().enumerate() {
            let group = groups.iter_mut().find(|(first, _)| alike(&towards[*first], value));
            if let Some((first, group)) = group {
                let sign = |axis: usize| if towards[*first][axis] * value[axis] < 0.0 { -1.0 } else { 1.0 };
                let (u, v) = (sign(across.0), sign(across.1));
                group.beams.push((b, [1.0, u, v, u * v]));
                continue;
            }
            let terms = |kind: usize| {
                let y = &beams[b].harmonics;
                let numbers = (0..scattering.len()).filter(|h| kinds[*h] == kind && y[*h].abs() > 1e-9);
                let term = |number: usize| MirrorTerm {
                    number,
                    harmonic: y[number] * scattering[number],
                    quadrature: beams[b].quadrature[number],
                };
                numbers.map(term).collect()
            };
            groups.push((b, Self { beams: vec![(b, [1.0; KINDS])], kinds: [0, 1, 2, 3].map(terms) }));
        }
        groups.into_iter().map(|(_, group)| group).collect()
    }

    /// Writes Σ Y_lm ω p_l J_lm of every beam for sixteen cells, whose moments J_lm stand `stride` apart.
    #[inline(always)]
    pub(super) fn sources(&self, moments: &[Lane], stride: usize, out: &mut [Lane]) {
        let mut sums = [[0.0; LANES]; KINDS];
        for (sum, terms) in sums.iter_mut().zip(&self.kinds) {
            for MirrorTerm { number, harmonic, .. } in terms {
                let moment = &moments[number * stride];
                for i in 0..LANES {
                    sum[i] = fma(*harmonic, moment[i], sum[i]);
                }
            }
        }
        for (beam, signs) in &self.beams {
            for i in 0..LANES {
                let even = fma(signs[1], sums[1][i], sums[0][i]);
                out[*beam][i] = fma(signs[2], fma(signs[1], sums[3][i], sums[2][i]), even);
            }
        }
    }

    /// Adds the radiance of every beam to the moments of sixteen cells, which stand `stride` apart.
    #[inline(always)]
    pub(super) fn gather(&self, radiance: &[Lane], stride: usize, moments: &mut [Lane]) {
        let mut sums = [[0.0; LANES]; KINDS];
        for (beam, signs) in &self.beams {
            for (sum, sign) in sums.iter_mut().zip(signs) {
                for i in 0..LANES {
                    sum[i] = fma(*sign, radiance[*beam][i], sum[i]);
                }
            }
        }
        for (sum, terms) in sums.iter().zip(&self.kinds) {
            for MirrorTerm { number, quadrature, .. } in terms {
                let moment = &mut moments[number * stride];
                for i in 0..LANES {
                    moment[i] = fma(*quadrature, sum[i], moment[i]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::beam::beam;
    use super::super::cells::SweepCells;
    use super::super::directions::{TOGETHER, across, faces};
    use super::*;
    use crate::field::Lattice;
    use crate::geometry::Bounds;
    use crate::random::Counter;

    /// Sources and moments of mirrored beams are the sums over harmonics themselves, beam by beam, for every number of
    /// directions and degree; and images are found: no face has as many groups as directions.
    #[test]
    fn mirrors_are_the_sums_themselves() {
        let lattice = Lattice { dims: [4, 5, 6], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let cells = SweepCells::of(lattice.clone(), vec![1.0; lattice.cells()]);
        let mut random = Counter::new(3, 0);
        for (edge, count) in [(2, 1), (3, 36), (4, 9), (6, 36)] {
            for face in faces(edge) {
                let beams: Vec<Beam> = face.directions.iter().map(|d| beam(&cells, &face, d)).collect();
                let towards: Vec<DVec3> = face.directions.iter().map(|d| d.towards).collect();
                let scattering: Vec<f32> = (0..count).map(|h| 0.9 - 0.02 * h as f32).collect();
                let mirrors = Mirrors::of(&beams, &towards, across(face.axis), &scattering);
                assert!(mirrors.len() < beams.len() && mirrors.iter().map(|m| m.beams.len()).sum::<usize>() == beams.len());
                let mut some = |n: usize| -> Vec<Lane> { (0..n).map(|_| [random.uniform() as f32 - 0.5; LANES]).collect() };
                let (moments, radiance) = (some(2 * count), some(beams.len()));
                let mut sources = [[0.0; LANES]; TOGETHER];
                mirrors.iter().for_each(|m| m.sources(&moments, 2, &mut sources));
                let mut gathered = vec![[0.0; LANES]; 2 * count];
                mirrors.iter().for_each(|m| m.gather(&radiance, 2, &mut gathered));
                for (beam, source) in beams.iter().zip(&sources) {
                    let truth: f32 = (0..count).map(|h| beam.harmonics[h] * scattering[h] * moments[2 * h][3]).sum();
                    assert!((source[3] - truth).abs() < 1e-5, "{edge}: {} {truth}", source[3]);
                }
                for (h, moment) in gathered.iter().step_by(2).enumerate() {
                    let truth: f32 = beams.iter().zip(&radiance).map(|(beam, radiance)| beam.quadrature[h] * radiance[5]).sum();
                    assert!((moment[5] - truth).abs() < 1e-5, "{edge} {h}: {} {truth}", moment[5]);
                }
            }
        }
    }
}
