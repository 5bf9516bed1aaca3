//! One sweep: the radiance that given sources make, by short characteristics along discrete ordinates.
//!
//! Plane by plane along a face's axis, term by term; between two planes, a cell's radiance in a direction is
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
use super::mirrors::Mirrors;
use super::rows::Rows;
use crate::control::Control;
use crate::error::Result;
use crate::packet::{LANES, Lane, exp, fma, lanes};

/// Cells as sweeps read them.
pub struct Medium<'a> {
    cells: &'a SweepCells,
    /// Mean σ at V [pc⁻¹]: as rows along x, and as rows along y.
    sigma: [Rows; 2],
}

impl<'a> Medium<'a> {
    /// The cells of a sweep.
    pub fn new(cells: &'a SweepCells) -> Self {
        let sigma = Rows::from_function(cells.lattice.dims, 1, |cell, _| cells.sigma[cell]);
        Self { cells, sigma: [sigma.turned(), sigma] }
    }

    /// σ in rows along x.
    pub fn sigma(&self) -> &Rows {
        &self.sigma[1]
    }
}

/// The sources of light for one term.
pub struct Sources<'a> {
    /// Extinction relative to V.
    pub k: f32,
    /// J_lm of each cell: light that scatters.
    pub scattered: &'a Rows,
    /// The albedo times the Legendre moment, ω p_l, of each harmonic.
    pub scattering: &'a [f32],
    /// Emission per length of each cell [pc⁻¹], where gas glows.
    pub glow: Option<&'a Rows>,
    /// Radiance that comes in from all around.
    pub around: f32,
}

/// A row of a plane, with cells around it where nothing is but what comes in.
#[derive(Clone)]
struct PaddedRow {
    /// The radiance of each direction and cell.
    radiance: Vec<f32>,
    /// The emission σ S of scattered light of each direction and cell.
    scattering: Vec<f32>,
    /// Light of gas per length.
    glow: Vec<f32>,
    sigma: Vec<f32>,
}

/// A row of cells that is to be done.
struct CellRow<'a> {
    k: f32,
    /// Dust of less is none [pc⁻¹].
    least: f32,
    around: f32,
    beams: &'a [Beam],
    /// The beams as mirror images of each other.
    mirrors: &'a [Mirrors],
    /// The number of cells around a plane.
    margin: usize,
    /// The number of the row in the plane, and of cells in it.
    row: usize,
    columns: usize,
    sigma: &'a [Lane],
    glow: Option<&'a [Lane]>,
    /// Harmonic × packet.
    scattered: &'a [Lane],
}

/// Adds the moments of the radiance that sources make along the directions of `faces`.
///
/// # Errors
/// On interruption by the user.
pub fn sweep(medium: &Medium, faces: &[Face], sources: &Sources, out: &mut Rows, control: &Control) -> Result<()> {
    for face in faces.iter().filter(|face| face.axis > 0) {
        control.check()?;
        sweep_face(medium, face, sources, out);
    }
    // Across x, rows stand along y.
    let (scattered, glow) = (sources.scattered.turned(), sources.glow.map(Rows::turned));
    let sources = Sources { scattered: &scattered, glow: glow.as_ref(), ..*sources };
    let mut turned = Rows::zeroed(scattered.dims, out.numbers);
    for face in faces.iter().filter(|face| face.axis == 0) {
        control.check()?;
        sweep_face(medium, face, &sources, &mut turned);
    }
    out.add_turned(&turned);
    Ok(())
}

fn sweep_face(medium: &Medium, face: &Face, sources: &Sources, out: &mut Rows) {
    let cells = medium.cells;
    let beams: Vec<Beam> = face.directions.iter().map(|d| beam(cells, face, d)).collect();
    let towards: Vec<DVec3> = face.directions.iter().map(|d| d.towards).collect();
    let mirrors = Mirrors::of(&beams, &towards, across(face.axis), &sources.scattering[..sources.scattered.numbers]);
    let sigma = &medium.sigma[face.axis.min(1)];
    // Planes stand along one axis of the rows, and rows along the other.
    let (axis, along) = if face.axis == 2 { (2, 1) } else { (1, 2) };
    let (dims, strides) = (sigma.dims, [0, 1, sigma.dims[1]]);
    let (columns, rows) = (dims[0], dims[along]);
    // Behind the margin all is as it is in it; packets that begin there are wholly in it.
    let shift = beams.iter().flat_map(|b| b.shift).map(|s| s.unsigned_abs() + 1).max().unwrap_or(1);
    let beyond = columns.max(rows) + 2;
    let margin = if shift <= beyond { shift } else { beyond + LANES + 1 };
    let length = columns.next_multiple_of(LANES) + 2 * margin + LANES;
    let empty = PaddedRow {
        radiance: vec![sources.around; length * beams.len()],
        scattering: vec![0.0; length * beams.len()],
        glow: vec![0.0; length],
        sigma: vec![0.0; length],
    };
    let mut before = vec![empty; rows + 2 * margin];
    let mut after = before.clone();
    let row_length = out.row_length();
    for step in 0..dims[axis] {
        let plane = if face.up { step } else { dims[axis] - 1 - step };
        // Rows of a plane do not overlap in the moments.
        let first = plane * strides[axis];
        let parts = out.rows_from(first).par_chunks_mut(strides[along] * row_length).take(rows);
        after[margin..margin + rows].par_iter_mut().zip(parts).enumerate().with_min_len(TASK.div_ceil(columns * beams.len())).for_each(
            |(number, (done, out))| {
                let row = first + number * strides[along];
                let line = CellRow {
                    k: sources.k,
                    least: cells.least,
                    around: sources.around,
                    beams: &beams,
                    mirrors: &mirrors,
                    margin,
                    row: number,
                    columns,
                    sigma: sigma.row(row),
                    glow: sources.glow.map(|glow| glow.row(row)),
                    scattered: sources.scattered.row(row),
                };
                march_row(&line, &before, done, &mut out[..row_length]);
            },
        );
        std::mem::swap(&mut before, &mut after);
    }
}

/// Directions of cells that are worth a task of their own, which takes some 40 µs.
const TASK: usize = 1 << 13;

/// Bilinear values at sixteen places of two rows, from number `at` on.
#[inline(always)]
fn blend(low: &[f32], high: &[f32], at: usize, w: &[f32; 4]) -> Lane {
    let (low, high) = (&low[at..][..LANES + 1], &high[at..][..LANES + 1]);
    lanes!(|i| fma(w[0], low[i], w[1] * low[i + 1]) + fma(w[2], high[i], w[3] * high[i + 1]))
}

simd! {
    fn march_row(line: &CellRow, before: &[PaddedRow], done: &mut PaddedRow, out: &mut [Lane]) {
        let (packets, length) = (line.sigma.len(), done.sigma.len());
        for packet in 0..packets {
            let here = packet * LANES + line.margin;
            let sigma = line.sigma[packet];
            done.sigma[here..][..LANES].copy_from_slice(&sigma);
            let glow = line.glow.map_or([0.0; LANES], |glow| glow[packet]);
            done.glow[here..][..LANES].copy_from_slice(&glow);
            let (mut own_sources, mut radiances) = ([[0.0; LANES]; TOGETHER], [[0.0; LANES]; TOGETHER]);
            for mirrors in line.mirrors {
                mirrors.sources(&line.scattered[packet..], packets, &mut own_sources);
            }
            for (b, beam) in line.beams.iter().enumerate() {
                let own_source = &own_sources[b];
                let row = (line.row + line.margin).saturating_add_signed(beam.shift[1]).min(before.len() - 2);
                let (low, high) = (&before[row], &before[row + 1]);
                let at = here.saturating_add_signed(beam.shift[0]).min(length - LANES - 1);
                let w = &beam.weights;
                let upwind = blend(&low.sigma, &high.sigma, at, w);
                let incoming = blend(&low.radiance[b * length..], &high.radiance[b * length..], at, w);
                let scattering = blend(&low.scattering[b * length..], &high.scattering[b * length..], at, w);
                let reach = 0.5 * line.k * beam.length_pc;
                let (mut e, mut first, mut second) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
                for i in 0..LANES {
                    (e[i], first[i], second[i]) = shares(reach * (upwind[i] + sigma[i]));
                }
                let mut radiance: Lane = lanes!(|i| {
                    // Where no dust is, its source function is that of the dust beside it.
                    let filled = upwind[i] > line.least;
                    let upwind_source = if filled { scattering[i] / upwind[i] } else { own_source[i] };
                    let source = if sigma[i] <= line.least { upwind_source } else { own_source[i] };
                    fma(incoming[i], e[i], fma(upwind_source, first[i], source * second[i]))
                });
                if line.glow.is_some() {
                    let coming = blend(&low.glow, &high.glow, at, w);
                    let half = 0.5 * beam.length_pc;
                    radiance = lanes!(|i| fma(half * (coming[i] + glow[i]), first[i] + e[i], radiance[i]));
                }
                radiances[b] = radiance;
                done.radiance[b * length + here..][..LANES].copy_from_slice(&radiance);
                let scattered: Lane = lanes!(|i| own_source[i] * sigma[i]);
                done.scattering[b * length + here..][..LANES].copy_from_slice(&scattered);
            }
            for mirrors in line.mirrors {
                mirrors.gather(&radiances, packets, &mut out[packet..]);
            }
        }
        // Behind the last cell is what comes in.
        for b in 0..line.beams.len() {
            let last = b * length + line.margin + line.columns..b * length + line.margin + packets * LANES;
            done.radiance[last.clone()].fill(line.around);
            done.scattering[last].fill(0.0);
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
        let dims = cells.lattice.dims;
        for t in 0..WIDTH {
            let even = |_: usize, h: usize| if h == 0 { fluence[t] } else { 0.0 };
            let scattered = Rows::from_function(dims, 9, even);
            let mut out = Rows::zeroed(dims, 9);
            let sources = Sources { k: k[t], scattered: &scattered, scattering: &[1.0; 9], glow: None, around: around[t] };
            sweep(&Medium::new(&cells), &faces, &sources, &mut out, &Control::default()).unwrap();
            for row in 0..dims[1] * dims[2] {
                for (h, found) in out.row(row).iter().enumerate() {
                    let close = found[..dims[0]].iter().all(|found| (found - even(0, h)).abs() < 2e-5 * fluence[t]);
                    assert!(close, "{t} {row} {h}: {found:?}");
                }
            }
        }
    }

    /// Gas between two planes sends its length where there is no dust; where there is even dust that does not scatter,
    /// light from outside falls as e^(−kΔ).
    #[test]
    fn light_falls_and_gas_glows() {
        let size = DVec3::new(1.0, 1.0, 1.0);
        let (k, faces) = ([0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6], faces(2));
        let clear = cells([16; 3], size, |_| 0.0);
        // The fluence in the middle, for each extinction.
        let run = |cells: &SweepCells, gas: Option<f32>, around: f32| {
            let dims = cells.lattice.dims;
            let (dark, glow) = (Rows::zeroed(dims, 1), gas.map(|gas| Rows::from_function(dims, 1, |_, _| gas)));
            k.map(|k| {
                let mut out = Rows::zeroed(dims, 1);
                let sources = Sources { k, scattered: &dark, scattering: &[1.0], glow: glow.as_ref(), around };
                sweep(&Medium::new(cells), &faces, &sources, &mut out, &Control::default()).unwrap();
                out.row(8 + 8 * dims[1])[0][8]
            })
        };
        // Far inside, the path through gas along each direction is the same to both faces: fluence is 4π times the mean
        // path.
        let out = run(&clear, Some(2.0), 0.0);
        let path = |d: &Direction| d.weight * 2.0 * 8.0 / 16.0 / d.towards.abs().max_element();
        let expected: f64 = faces.iter().flat_map(|f| &f.directions).map(path).sum::<f64>() * harmonics(DVec3::X)[0];
        let found = f64::from(out[3]);
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
        let dusty = cells([16; 3], size, |_| 3.0);
        let (near, far) = (run(&dusty, None, 1.0), run(&clear, None, 1.0));
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
