//! Pixels that stand for a picture: where its error is measured.
//!
//! A stratified sample. Every pixel at and around a star is one of its own, since light there grows as the inverse of
//! the distance and one pixel may hold most of the error; the others are parted into cells, each of which is stood for
//! by its middle, the brightest, and where functions jump the most contrasted, by nine pixels; and pixels along the
//! edges of the dust's box, where star depths have kinks, are added. Pixels are looked at where the picture is made, in
//! their middles: a ray between two of them may come nearer to a star than any that is rendered.

use std::collections::HashSet;

use rayon::prelude::*;

use crate::camera::Camera;
use crate::error::Result;
use crate::plan::SpatialPlan;

/// A pixel and how many it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plan) struct SampledPixel {
    pub(in crate::plan) column: usize,
    pub(in crate::plan) row: usize,
    pub(in crate::plan) stands_for: f64,
}

/// Cells along each edge of the image.
const EDGE: usize = 10;
/// Pixels on each edge of the dust's box.
const ON_EDGE: usize = 3;
/// Most stars that get pixels of their own.
const STARS: usize = 16;
/// Pixels along an edge of those around a star: of many stars, and of so few.
const AROUND: (usize, usize) = (3, 7);
const FEW_STARS: usize = 4;
/// The brightest cells, which are looked at in nine pixels each.
const BRIGHT: usize = 6;
/// The number of cells taken where functions jump, those that differ most from the cells beside them: there are the
/// rims, which hold the error of samples.
const CONTRASTED: usize = 40;
/// Images of no more pixels are taken whole.
const SMALL: usize = 400;

/// The sample of a camera's picture; `look` returns the light of a pixel in every band.
///
/// # Errors
/// Errors of `look`.
pub(in crate::plan) fn sampled(
    camera: &Camera,
    space: &SpatialPlan,
    look: impl Fn(usize, usize) -> Result<Vec<f64>> + Sync,
) -> Result<Vec<SampledPixel>> {
    let (width, height) = (camera.width, camera.height);
    if width * height <= SMALL {
        let all = (0..width * height).map(|i| SampledPixel { column: i % width, row: i / width, stands_for: 1.0 });
        return Ok(all.collect());
    }
    let near = around_stars(camera, space);
    let mut pixels: Vec<SampledPixel> =
        near.iter().map(|(column, row)| SampledPixel { column: *column, row: *row, stands_for: 1.0 }).collect();
    pixels.sort_by_key(|p| (p.row, p.column));
    // Edges of the dust's box are looked at more closely than others: what their pixels stand for, the others do not.
    let mut edges = on_edges(camera, space);
    edges.retain(|p| !near.contains(&(p.column, p.row)));
    let on_edge: HashSet<(usize, usize)> = edges.iter().map(|p| (p.column, p.row)).collect();
    let beside = (width * height - near.len()) as f64;
    let of_edges: f64 = edges.iter().map(|p| p.stands_for).sum();
    let others = beside - on_edge.len() as f64;
    let share = if others > 0.0 { (beside - of_edges) / others } else { 1.0 };
    let cells = ImageCells { width, height };
    let middle = |cell: usize| {
        let (column, row) = cells.middle(cell);
        look(column, row)
    };
    let light: Vec<Vec<f64>> = (0..EDGE * EDGE).into_par_iter().map(middle).collect::<Result<_>>()?;
    let bands = light.first().map_or(0, Vec::len);
    let most: Vec<f64> = (0..bands).map(|b| light.iter().map(|l| l[b]).fold(f64::MIN_POSITIVE, f64::max)).collect();
    let bright = |cell: usize| light[cell].iter().zip(&most).map(|(l, m)| l / m).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..EDGE * EDGE).collect();
    order.sort_by(|a, b| bright(*b).total_cmp(&bright(*a)));
    let mut looked_at: HashSet<usize> = order.iter().copied().take(BRIGHT).collect();
    if space.has_edges() {
        let contrast = |cell: usize| cells.neighbours(cell).map(|other| (bright(cell) - bright(other)).abs()).fold(0.0, f64::max);
        order.sort_by(|a, b| contrast(*b).total_cmp(&contrast(*a)));
        looked_at.extend(order.iter().take(CONTRASTED));
    }
    for cell in 0..EDGE * EDGE {
        let mut sampled_pixels = if looked_at.contains(&cell) { cells.ninths(cell) } else { vec![cells.middle(cell)] };
        let taken = |pixel: &(usize, usize)| near.contains(pixel) || on_edge.contains(pixel);
        sampled_pixels.retain(|pixel| !taken(pixel));
        // An image may have billions of pixels: those that are left are counted, not looked at.
        let left = cells.count(cell) - near.iter().chain(&on_edge).filter(|pixel| cells.holds(cell, pixel)).count();
        if left == 0 {
            continue;
        }
        if sampled_pixels.is_empty() {
            sampled_pixels.extend(cells.pixels(cell).find(|pixel| !taken(pixel)));
        }
        let stands_for = share * left as f64 / sampled_pixels.len().max(1) as f64;
        pixels.extend(sampled_pixels.into_iter().map(|(column, row)| SampledPixel { column, row, stands_for }));
    }
    pixels.extend(edges);
    Ok(pixels)
}

/// The pixel at a column and a row of the image plane, if it is one.
fn pixel_at(camera: &Camera, column: f64, row: f64) -> Option<(usize, usize)> {
    let inside = (0.0..camera.width as f64).contains(&column) && (0.0..camera.height as f64).contains(&row);
    inside.then_some((column as usize, row as usize))
}

/// The pixels in which stars stand, and those around them.
fn around_stars(camera: &Camera, space: &SpatialPlan) -> HashSet<(usize, usize)> {
    let around = if space.stars.len() <= FEW_STARS { AROUND.1 } else { AROUND.0 };
    let half = (around / 2) as f64;
    let places = space.stars.iter().take(STARS).filter_map(|star| camera.project(*star));
    let square = |(column, row): (f64, f64)| {
        (0..around * around).map(move |i| (column + (i % around) as f64 - half, row + (i / around) as f64 - half))
    };
    places.flat_map(square).filter_map(|(column, row)| pixel_at(camera, column, row)).collect()
}

/// Pixels along the edges of the dust's box, each once, for those that its part of an edge crosses; for itself alone
/// where that would be more than half of a small picture.
fn on_edges(camera: &Camera, space: &SpatialPlan) -> Vec<SampledPixel> {
    let even = (camera.width * camera.height) as f64 / (EDGE * EDGE) as f64;
    let bounds = space.dust.as_ref().map(|d| d.lattice().bounds);
    let mut pixels = Vec::new();
    for (axis, corner) in (0..12).map(|i| (i / 4, i % 4)) {
        let Some(bounds) = bounds else { break };
        let place = |part: f64| {
            let mut unit = [0.0; 3];
            unit[axis] = part;
            unit[(axis + 1) % 3] = f64::from(corner as u32 & 1);
            unit[(axis + 2) % 3] = f64::from(corner as u32 >> 1);
            camera.project(bounds.low + glam::DVec3::from(unit) * bounds.size())
        };
        let (Some(a), Some(b)) = (place(0.0), place(1.0)) else { continue };
        let stands_for = ((a.0 - b.0).hypot(a.1 - b.1) / ON_EDGE as f64).max(1.0).min(even);
        let parts = (0..ON_EDGE).map(|i| (i as f64 + 0.5) / ON_EDGE as f64);
        let crossed = parts.filter_map(place).filter_map(|(column, row)| pixel_at(camera, column, row));
        pixels.extend(crossed.map(|(column, row)| SampledPixel { column, row, stands_for }));
    }
    pixels.sort_by(|a: &SampledPixel, b| (a.row, a.column).cmp(&(b.row, b.column)).then(b.stands_for.total_cmp(&a.stands_for)));
    pixels.dedup_by_key(|p| (p.row, p.column));
    let all: f64 = pixels.iter().map(|p| p.stands_for).sum();
    if all > 0.5 * (camera.width * camera.height) as f64 {
        pixels.iter_mut().for_each(|p| p.stands_for = 1.0);
    }
    pixels
}

/// The cells of an image.
struct ImageCells {
    width: usize,
    height: usize,
}

impl ImageCells {
    /// The columns and the rows of a cell; none of an image that has fewer than cells.
    fn ranges(&self, cell: usize) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let range = |n: usize, i: usize| n * i / EDGE..n * (i + 1) / EDGE;
        (range(self.width, cell % EDGE), range(self.height, cell / EDGE))
    }

    fn pixels(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> {
        let (columns, rows) = self.ranges(cell);
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }

    fn count(&self, cell: usize) -> usize {
        let (columns, rows) = self.ranges(cell);
        columns.len() * rows.len()
    }

    fn holds(&self, cell: usize, (column, row): &(usize, usize)) -> bool {
        let (columns, rows) = self.ranges(cell);
        columns.contains(column) && rows.contains(row)
    }

    fn middle(&self, cell: usize) -> (usize, usize) {
        let (columns, rows) = self.ranges(cell);
        ((columns.start + columns.end) / 2, (rows.start + rows.end) / 2)
    }

    /// The cells beside a cell.
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (column, row) = (cell % EDGE, cell / EDGE);
        let left = column.checked_sub(1).map(|c| row * EDGE + c);
        let right = (column + 1 < EDGE).then_some(cell + 1);
        let above = row.checked_sub(1).map(|r| r * EDGE + column);
        let below = (row + 1 < EDGE).then_some(cell + EDGE);
        [left, right, above, below].into_iter().flatten()
    }

    /// The middles of the cell's nine parts.
    fn ninths(&self, cell: usize) -> Vec<(usize, usize)> {
        let (columns, rows) = self.ranges(cell);
        let at = |range: &std::ops::Range<usize>, i: usize| range.start + (range.end - range.start) * (2 * i + 1) / 6;
        let mut pixels: Vec<(usize, usize)> = (0..9).map(|i| (at(&columns, i % 3), at(&rows, i / 3))).collect();
        pixels.sort_unstable();
        pixels.dedup();
        pixels
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::control::Control;
    use crate::fixtures::{ball, dust, on_axis, scene, star};
    use crate::plan::{Options, Planner, Quality};

    /// The sample stands for every pixel once: the mean of a smooth picture is that of the sample, also where a star
    /// stands.
    #[test]
    fn every_pixel_is_stood_for() {
        // From within dust, whose box has no edges to be seen, and with all of it in view.
        let sizes = [(64, 48), (200, 31), (21, 20), (500, 7)];
        for ((width, height), (degrees, radius)) in sizes.into_iter().flat_map(|size| [(10.0, 9.0), (40.0, 1.0)].map(|view| (size, view))) {
            let camera = on_axis(4.0, degrees, (width, height));
            let scene =
                scene(camera, 8).with_dust(dust(ball(radius), "ccm89", 0.1)).with_star(star(9000.0, 1.0, 0.1 * DVec3::X)).build().unwrap();
            let plan = Planner::new(&Options::default()).with_quality(Quality::Fixed(8)).plan(&scene, None, &Control::default()).unwrap();
            let picture = |column: usize, row: usize| (0.05 * column as f64).sin() + 0.03 * row as f64 + 2.0;
            let sample = sampled(&scene.camera, &plan.space, |column, row| Ok(vec![picture(column, row)])).unwrap();
            let all: f64 = sample.iter().map(|p| p.stands_for).sum();
            assert!((all - (width * height) as f64).abs() < 1e-9, "{width} x {height}: {all}");
            let mean = sample.iter().map(|p| p.stands_for * picture(p.column, p.row)).sum::<f64>() / all;
            let truth = (0..width * height).map(|i| picture(i % width, i / width)).sum::<f64>() / all;
            assert!((mean / truth - 1.0).abs() < 0.02, "{width} x {height}: {mean} {truth}");
            let distinct: HashSet<(usize, usize)> = sample.iter().map(|p| (p.column, p.row)).collect();
            assert!(distinct.len() == sample.len() && sample.len() >= 49);
        }
    }
}
