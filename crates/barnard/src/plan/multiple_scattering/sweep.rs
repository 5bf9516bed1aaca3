//! One sweep: the radiance that given sources make, by short characteristics along discrete ordinates.
//!
//! Plane by plane along a face's axis; between two planes, a cell's radiance in a direction is
//!
//!   I = I₀ e^(−Δ) + S₀ (g − e^(−Δ)) + S (1 − g) + ē s g,   g = (1 − e^(−Δ))/Δ
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | I₀, S₀: radiance and source function one plane before, where the ray comes from, bilinear | `before` | of radiance |
//! | S = Σ_lm Y_lm ω p_l J_lm: what is scattered there, in parts of extinction | `source` | of radiance |
//! | Δ = k σ̄ s: optical depth between the planes | `depth` | 1 |
//! | ē s: light of gas | `glow` | of radiance |
//!
//! This is eq. (23) of docs/method.md, with the light of gas. Both weights of S are positive and add up to 1 − e^(−Δ):
//! no cell makes light from nothing, and an even field of light stays as it is where nothing is absorbed. Source:
//! Kunasz & Auer 1988, JQSRT 39, 67 (short characteristics). Left out: higher orders of interpolation, whose overshoots
//! would need limits; the blur that bilinear interpolation brings is known to be small for light that was scattered.

use glam::DVec3;
use rayon::prelude::*;
use spectra::simd;

use super::beam::{Beam, beam};
use super::cells::SweepCells;
use super::directions::{Face, TOGETHER, across};
use super::lanes::Lanes;
use super::mirrors::Mirrors;
use super::moments::Moments;
use crate::control::Control;
use crate::error::Result;
use crate::packet::{exp, fma};

/// The sources of light for some terms.
pub struct Sources<'a, const N: usize> {
    /// J_lm of each cell: light that scatters.
    pub scattered: &'a Moments<N>,
    /// The albedo times the Legendre moment, ω p_l, of each harmonic.
    pub scattering: &'a [Lanes<N>],
    /// Emission per length of each cell [pc⁻¹], where gas glows.
    pub glow: Option<&'a [Lanes<N>]>,
    /// Radiance that comes in from all around.
    pub around: Lanes<N>,
}

/// A row of a plane, with cells around it where nothing is but what comes in.
#[derive(Clone)]
struct PaddedRow<const N: usize> {
    /// The radiance of each cell and direction.
    radiance: Vec<Lanes<N>>,
    /// The emission σ S of scattered light of each cell and direction.
    scattering: Vec<Lanes<N>>,
    /// Light of gas per length.
    glow: Vec<Lanes<N>>,
    sigma: Vec<f32>,
}

/// A row of cells that is to be done.
struct CellRow<'a, const N: usize> {
    cells: &'a SweepCells,
    k: &'a Lanes<N>,
    sources: &'a Sources<'a, N>,
    beams: &'a [Beam],
    /// The beams as mirror images of each other.
    mirrors: &'a [Mirrors<N>],
    /// The number of cells around a plane.
    margin: usize,
    /// The number of the row in the plane.
    row: usize,
    /// Number of the first cell, and from one to the next.
    first: usize,
    stride: usize,
    /// Number of the first cell whose moments are at hand.
    base: usize,
}

/// Adds to `out` the moments of the light that `sources` send through `cells`, in which terms have the
/// extinctions `k`.
///
/// # Errors
/// On interruption by the user.
pub fn sweep<const N: usize>(
    cells: &SweepCells,
    k: &Lanes<N>,
    faces: &[Face],
    sources: &Sources<N>,
    out: &mut Moments<N>,
    control: &Control,
) -> Result<()> {
    for face in faces {
        control.check()?;
        sweep_face(cells, k, face, sources, out);
    }
    Ok(())
}

fn sweep_face<const N: usize>(cells: &SweepCells, k: &Lanes<N>, face: &Face, sources: &Sources<N>, out: &mut Moments<N>) {
    let dims = cells.lattice.dims;
    let (column, row) = across(face.axis);
    let beams: Vec<Beam> = face.directions.iter().map(|d| beam(cells, face, d)).collect();
    let towards: Vec<DVec3> = face.directions.iter().map(|d| d.towards).collect();
    let mirrors = Mirrors::of(&beams, &towards, (column, row), &sources.scattering[..sources.scattered.count]);
    // Behind the margin all is as it is in it.
    let margin = beams.iter().flat_map(|b| b.shift).map(|s| s.unsigned_abs() + 1).max().unwrap_or(1).min(dims[column].max(dims[row]) + 2);
    let length = dims[column] + 2 * margin;
    let empty = PaddedRow {
        radiance: vec![sources.around; length * beams.len()],
        scattering: vec![[0.0; N]; length * beams.len()],
        glow: vec![[0.0; N]; length],
        sigma: vec![0.0; length],
    };
    let mut before = vec![empty; dims[row] + 2 * margin];
    let mut after = before.clone();
    let strides = [1, dims[0], dims[0] * dims[1]];
    // Rows of a plane lie in parts of the moments that do not overlap: slabs of equal z, or rows of one.
    let part = strides[row];
    for step in 0..dims[face.axis] {
        let plane = if face.up { step } else { dims[face.axis] - 1 - step };
        let start = if face.axis == 2 { plane * strides[2] } else { 0 };
        let parts = out.data[start * out.count..].par_chunks_mut(part * out.count).take(dims[row]);
        after[margin..margin + dims[row]].par_iter_mut().zip(parts).enumerate().with_min_len(ROWS).for_each(|(number, (done, out))| {
            let first = plane * strides[face.axis] + number * strides[row];
            let base = start + number * part;
            let line =
                CellRow { cells, k, sources, beams: &beams, mirrors: &mirrors, margin, row: number, first, stride: strides[column], base };
            march_row(&line, &before, done, out);
        });
        std::mem::swap(&mut before, &mut after);
    }
}

/// Rows that one thread takes at least.
const ROWS: usize = 4;

/// Σ of four values by weights.
#[inline(always)]
fn blend<const N: usize>(four: [&Lanes<N>; 4], weights: &[f32; 4]) -> Lanes<N> {
    let mut sum = [0.0; N];
    for (values, weight) in four.into_iter().zip(weights) {
        for t in 0..N {
            sum[t] = fma(*weight, values[t], sum[t]);
        }
    }
    sum
}

simd! {
    fn march_row<const N: usize>(line: &CellRow<N>, before: &[PaddedRow<N>], done: &mut PaddedRow<N>, out: &mut [Lanes<N>]) {
        let (count, harmonics) = (line.beams.len(), line.sources.scattered.count);
        let columns = done.sigma.len() - 2 * line.margin;
        for column in 0..columns {
            let cell = line.first + column * line.stride;
            let sigma = line.cells.sigma[cell];
            let glow = line.sources.glow.map_or([0.0; N], |glow| glow[cell]);
            let source = line.sources.scattered.cell(cell);
            let moments = &mut out[(cell - line.base) * harmonics..][..harmonics];
            let here = column + line.margin;
            (done.sigma[here], done.glow[here]) = (sigma, glow);
            let (mut own_sources, mut radiances) = ([[0.0; N]; TOGETHER], [[0.0; N]; TOGETHER]);
            for mirrors in line.mirrors {
                mirrors.sources(source, &mut own_sources);
            }
            for (b, beam) in line.beams.iter().enumerate() {
                let own_source = own_sources[b];
                let row = (line.row + line.margin).saturating_add_signed(beam.shift[1]).min(before.len() - 2);
                let rows = [&before[row], &before[row + 1]];
                let at = here.saturating_add_signed(beam.shift[0]).min(done.sigma.len() - 2);
                let four = |values: fn(&PaddedRow<N>) -> &[Lanes<N>], stride: usize, b: usize| {
                    let place = |i: usize| (at + i) * stride + b;
                    [&values(rows[0])[place(0)], &values(rows[0])[place(1)], &values(rows[1])[place(0)], &values(rows[1])[place(1)]]
                };
                let incoming = blend(four(|r| &r.radiance, count, b), &beam.weights);
                let scattering = blend(four(|r| &r.scattering, count, b), &beam.weights);
                let w = &beam.weights;
                let upwind =
                    fma(w[0], rows[0].sigma[at], w[1] * rows[0].sigma[at + 1]) + fma(w[2], rows[1].sigma[at], w[3] * rows[1].sigma[at + 1]);
                // Where no dust is, its source function is that of the dust beside it.
                let (inverse, self_share) = if upwind > line.cells.least { (1.0 / upwind, 0.0) } else { (0.0, 1.0) };
                let clear = sigma <= line.cells.least;
                let depth = 0.5 * (upwind + sigma) * beam.length_pc;
                let (mut radiance, mut through) = ([0.0; N], [0.0; N]);
                for t in 0..N {
                    let (e, first, second) = shares(line.k[t] * depth);
                    through[t] = first + e;
                    let upwind_source = fma(scattering[t], inverse, self_share * own_source[t]);
                    let source = if clear { upwind_source } else { own_source[t] };
                    radiance[t] = fma(incoming[t], e, fma(upwind_source, first, source * second));
                }
                if line.sources.glow.is_some() {
                    let coming = blend(four(|r| &r.glow, 1, 0), &beam.weights);
                    for t in 0..N {
                        radiance[t] = fma(0.5 * (coming[t] + glow[t]) * beam.length_pc, through[t], radiance[t]);
                    }
                }
                radiances[b] = radiance;
                done.radiance[here * count + b] = radiance;
                for t in 0..N {
                    done.scattering[here * count + b][t] = own_source[t] * sigma;
                }
            }
            for mirrors in line.mirrors {
                mirrors.gather(&radiances, moments);
            }
        }
    }
}

/// Optical depth of a cell below which its weights are the series of theirs, whose differences would cancel.
pub const THIN_CELL: f32 = 0.03;

/// The weights e^(−Δ), g − e^(−Δ) and 1 − g of a cell, with g = (1 − e^(−Δ))/Δ.
#[inline(always)]
fn shares(depth: f32) -> (f32, f32, f32) {
    let e = exp(-depth);
    let thin = depth < THIN_CELL;
    let g = (1.0 - e) / if thin { 1.0 } else { depth };
    let first = if thin { depth * fma(depth, fma(depth, 0.125, -1.0 / 3.0), 0.5) } else { g - e };
    let second = if thin { depth * fma(depth, fma(depth, 1.0 / 24.0, -1.0 / 6.0), 0.5) } else { 1.0 - g };
    (e, first, second)
}

#[cfg(test)]
mod tests {
    use super::super::directions::{Direction, faces};
    use super::super::harmonics::harmonics;
    use super::super::lanes::{EightLanes, WIDTH};
    use super::*;
    use crate::field::Lattice;
    use crate::geometry::Bounds;

    fn cells(dims: [usize; 3], size: DVec3, sigma: impl Fn(DVec3) -> f64) -> SweepCells {
        let lattice = Lattice { dims, bounds: Bounds { low: -0.5 * size, high: 0.5 * size } };
        let sweep = |cell: usize| {
            let [x, y, z] = lattice.place(cell);
            sigma(lattice.centre(x, y, z)) as f32
        };
        let sigma = (0..lattice.cells()).map(sweep).collect();
        SweepCells::of(lattice, sigma)
    }

    /// Dust that absorbs nothing changes nothing in an even field of light, wherever it is.
    #[test]
    fn an_even_field_stays() {
        let cells = cells([7, 5, 9], DVec3::new(1.0, 2.0, 1.5), |p| 3.0 + 40.0 * (7.0 * p.x).sin().max(0.0) + 5.0 * p.y * p.y);
        let (k, faces) = ([0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 4.0, 9.0], faces(3));
        let around: EightLanes = std::array::from_fn(|t| 1.0 + t as f32);
        // S = I: its moment of degree zero is √4π of it.
        let fluence = around.map(|i| i * (spectra::constants::SPHERE as f32).sqrt());
        let mut scattered = Moments::dark(cells.lattice.cells(), 9);
        scattered.data.iter_mut().step_by(9).for_each(|m| *m = fluence);
        let mut out = Moments::dark(cells.lattice.cells(), 9);
        sweep(
            &cells,
            &k,
            &faces,
            &Sources { scattered: &scattered, scattering: &[[1.0; WIDTH]; 9], glow: None, around },
            &mut out,
            &Control::default(),
        )
        .unwrap();
        for (i, (found, expected)) in out.data.iter().zip(&scattered.data).enumerate() {
            let close = (0..WIDTH).all(|t| (found[t] - expected[t]).abs() < 2e-5 * fluence[t]);
            assert!(close, "{i}: {found:?} {expected:?}");
        }
    }

    /// Gas between two planes sends its length where there is no dust; where there is even dust that does not scatter,
    /// light from outside falls as e^(−kΔ).
    #[test]
    fn light_falls_and_gas_glows() {
        let size = DVec3::new(1.0, 1.0, 1.0);
        let (k, faces) = ([0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6], faces(2));
        let clear = cells([16; 3], size, |_| 0.0);
        let dark = Moments::dark(clear.lattice.cells(), 1);
        let run = |cells: &SweepCells, glow: Option<&[EightLanes]>, around: EightLanes| {
            let mut out = dark.clone();
            sweep(
                cells,
                &k,
                &faces,
                &Sources { scattered: &dark, scattering: &[[1.0; WIDTH]], glow, around },
                &mut out,
                &Control::default(),
            )
            .unwrap();
            out
        };
        // Far inside, the path through gas along each direction is the same to both faces: fluence is 4π times the mean
        // path.
        let gas = vec![[2.0; WIDTH]; dark.data.len()];
        let out = run(&clear, Some(&gas), [0.0; WIDTH]);
        let middle = clear.lattice.index(8, 8, 8);
        let path = |d: &Direction| d.weight * 2.0 * 8.0 / 16.0 / d.towards.abs().max_element();
        let expected: f64 = faces.iter().flat_map(|f| &f.directions).map(path).sum::<f64>() * harmonics(DVec3::X)[0];
        let found = f64::from(out.cell(middle)[0][3]);
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
        let dusty = cells([16; 3], size, |_| 3.0);
        let (near, far) = (run(&dusty, None, [1.0; WIDTH]).cell(middle)[0], run(&clear, None, [1.0; WIDTH]).cell(middle)[0]);
        for t in 0..WIDTH {
            let mean = |d: &Direction| {
                d.weight / spectra::constants::SPHERE * (-f64::from(k[t]) * 3.0 * 0.5 / d.towards.abs().max_element()).exp()
            };
            let expected: f64 = faces.iter().flat_map(|f| &f.directions).map(mean).sum();
            let found = f64::from(near[t] / far[t]);
            assert!((found / expected - 1.0).abs() < 0.05, "{t}: {found} {expected}");
        }
    }
}
