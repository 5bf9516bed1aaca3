//! Bricks in the order of their layers, in one process: the depths of one sweep, bit by bit.

use super::*;
use crate::geometry::Bounds;
use crate::plan::star_depths::frustum_sweep::sweep;
use crate::volume::{Channel, ChannelMut, Volume};

/// A part of a grid as a grid of its own.
fn part(grid: &Grid, voxels: &[Range<usize>; 3]) -> Grid {
    let lattice = grid.lattice().part(voxels);
    let rows = voxels[2].clone().flat_map(|z| voxels[1].clone().map(move |y| (y, z)));
    let values = grid.values();
    let data = rows.flat_map(|(y, z)| values[grid.lattice().row(voxels[0].clone(), y, z)].to_vec()).collect();
    Grid::from_lattice(lattice, data)
}

/// Rays of all tiers: depths and entries.
type All = BTreeMap<usize, (Vec<f32>, Vec<f32>)>;

/// One pass over the layers of a frustum from what rays bring: what they carry behind the last, and what `visit`
/// hears of each brick.
fn pass(grid: &Grid, relay: &Relay, layers: &[Layer], pass: Pass, mut all: All, mut visit: impl FnMut([usize; 3], Vec<f32>)) -> All {
    for layer in layers {
        let rays = relay.rays(layer.frustum);
        let mut next: All = all.clone();
        for place in &layer.bricks {
            let dust = part(grid, &relay.needs(layer, *place));
            let borders = [0, 1].map(|side| relay.border(layer, *place, side).map(|voxels| part(grid, &voxels)));
            let brick = Brick { place: *place, dust: &dust, borders: borders.each_ref().map(|b| b.as_ref()) };
            let carried = all.iter().map(|(tier, rays)| (*tier, (&rays.0[..], &rays.1[..]))).collect();
            let (values, handed) = relay.sweep(layer, pass, &brick, &carried, &Control::default()).unwrap();
            values.into_iter().for_each(|values| visit(*place, values));
            for Handed { tier, rays: [columns, rows], depths, entries } in handed {
                let [width, height] = rays[tier];
                let faces = next.entry(tier).or_insert_with(|| (vec![f32::NAN; width * height], vec![f32::NAN; width * height]));
                for (j, y) in rows.enumerate() {
                    for (i, x) in columns.clone().enumerate() {
                        faces.0[y * width + x] = depths[j * columns.len() + i];
                        if let Some(entry) = entries.get(j * columns.len() + i) {
                            faces.1[y * width + x] = *entry;
                        }
                    }
                }
            }
        }
        all = next;
    }
    all
}

/// The depths of all voxels by bricks.
fn by_bricks(grid: &Grid, cuts: &[Vec<usize>; 3], star: DVec3) -> Vec<f32> {
    let relay = Relay::new(Partition::new(grid.lattice().clone(), cuts.clone()).unwrap(), star);
    let layers = relay.layers();
    let mut depths = vec![f32::NAN; grid.lattice().cells()];
    if let Some([x, y, z]) = relay.own_voxel() {
        depths[grid.lattice().index(x, y, z)] = 0.0;
    }
    for frustum in 0..6 {
        let layers_of_frustum: Vec<Layer> = layers.iter().filter(|layer| layer.frustum == frustum).cloned().collect();
        let begin = match relay.has_entries(frustum) {
            true => {
                let all = pass(grid, &relay, &layers_of_frustum, Pass::Entries, All::new(), |_, _| ());
                all.into_iter().map(|(tier, (_, entries))| (tier, (entries.iter().map(|depth| -depth).collect(), Vec::new()))).collect()
            }
            false => All::new(),
        };
        pass(grid, &relay, &layers_of_frustum, Pass::Depths, begin, |place, values| {
            let voxels = relay.partition.voxels(place);
            for (i, value) in values.into_iter().enumerate().filter(|(_, value)| !value.is_nan()) {
                let [nx, ny] = [voxels[0].len(), voxels[1].len()];
                let [x, y, z] = [voxels[0].start + i % nx, voxels[1].start + i / nx % ny, voxels[2].start + i / (nx * ny)];
                depths[grid.lattice().index(x, y, z)] = value;
            }
        });
    }
    depths
}

fn whole(grid: &Grid, star: DVec3) -> Vec<f32> {
    let mut volume = Volume::zeroed(grid.lattice(), vec![Channel::StarDepth(0)]);
    sweep(grid, star, &mut ChannelMut { volume: &mut volume, slot: 0 }, &Control::default(), |_| ()).unwrap();
    (0..grid.lattice().cells()).map(|i| volume.value(volume.index(grid.lattice().place(i)), 0)).collect()
}

/// Waves with walls in them, in voxels of unequal edges, and stars inside, on borders between bricks, on faces and
/// corners, beside them, outside and far away.
#[test]
fn bricks_have_the_depths_of_the_whole() {
    let dims = [41, 30, 37];
    let lattice = Lattice { dims, bounds: Bounds { low: DVec3::splat(-1.0), high: DVec3::new(1.0, 1.2, 1.0) } };
    let grid = Grid::sampled(lattice, |p| {
        let wall = if (p.x - 0.4 * p.y).abs() < 0.08 && p.z > 0.1 { 400.0 } else { 0.0 };
        4.0 * (0.5 + 0.5 * (9.0 * p.x).sin() * (7.0 * p.y + 3.0 * p.z).cos()) + wall
    });
    let cuts = [vec![0, 9, 20, 41], vec![0, 16, 30], vec![0, 12, 13, 30, 37]];
    let between = grid.lattice().bounds.low + DVec3::new(20.0, 16.0, 12.0) * grid.lattice().voxel_pc();
    let stars = [
        DVec3::new(0.1, -0.2, 0.3),
        between,
        grid.lattice().centre(20, 4, 12),
        DVec3::new(0.0, 0.0, -1.0),
        DVec3::new(1.0, 1.2, 1.0),
        DVec3::new(1.01, -0.99, 0.0),
        DVec3::new(-1.06, 0.3, 0.5),
        DVec3::new(3.0, 0.5, 0.2),
        DVec3::new(-2.0, 2.5, 1.7),
        DVec3::new(0.0, 0.0, -500.0),
    ];
    for star in stars {
        let (ours, theirs) = (by_bricks(&grid, &cuts, star), whole(&grid, star));
        let differ = (0..ours.len()).filter(|i| ours[*i].to_bits() != theirs[*i].to_bits()).count();
        let worst = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs() / (1.0 + b)).fold(0.0, f32::max);
        assert!(differ == 0, "{star}: {differ} of {} voxels differ, by up to {worst:.1e}", ours.len());
    }
}
