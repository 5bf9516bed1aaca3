//! Pictures of volumes that nobody holds as a whole, brick by brick: what the tasks of a graph do.
//!
//! Arrays have one axis, x fastest, then y; a range of voxels or rays is a pair of its start and end.

use std::collections::BTreeMap;
use std::ops::Range;

use barnard::backend::cpu::bricks::{self, Partial};
use barnard::field::{Grid, Lattice, Partition};
use barnard::geometry::Bounds;
use barnard::glam::DVec3;
use barnard::plan::star_depths::relay::{Brick, Carried, Handed, Layer, Pass, Relay};
use barnard::plan::{self, BrickFields};
use barnard::{Error, Result};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error::raised;
use crate::image::Image;
use crate::scene::{Owner, Scene, plan_options};
use crate::work;

type Pair = (usize, usize);
type BrickValues<'py> = PyReadonlyArray1<'py, f32>;
/// Effect of bricks on rays: rows, columns, values, depths of sources.
type PartialParts<'py> = (Pair, Pair, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f64>>);
/// Rays that are handed on: tier, rays along u and v, depths, entries.
type HandedParts<'py> = (usize, Pair, Pair, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>);

/// Lowest and highest corner [pc].
type CellCorners = ([f64; 3], [f64; 3]);
/// Depths of a brick's voxels, and the rays that are handed on.
type SweptParts<'py> = (Option<Bound<'py, PyArray1<f32>>>, Vec<HandedParts<'py>>);

fn pair(range: &Range<usize>) -> Pair {
    (range.start, range.end)
}

fn corners(bounds: &Bounds) -> CellCorners {
    (bounds.low.into(), bounds.high.into())
}

fn values(array: &BrickValues) -> PyResult<Vec<f32>> {
    Ok(array.as_slice()?.to_vec())
}

/// Effect of bricks on rays, as passed by Python.
#[derive(FromPyObject)]
pub struct GivenPartial<'py>(Pair, Pair, BrickValues<'py>, PyReadonlyArray1<'py, f64>);

impl GivenPartial<'_> {
    fn taken(&self) -> PyResult<Partial> {
        let Self(rows, columns, light, points) = self;
        let points = points.as_slice()?.to_vec();
        Ok(Partial { rows: rows.0..rows.1, columns: columns.0..columns.1, values: values(light)?, points })
    }
}

fn given<'py>(py: Python<'py>, partial: Partial) -> PartialParts<'py> {
    let Partial { rows, columns, values, points } = partial;
    (pair(&rows), pair(&columns), PyArray1::from_vec(py, values), PyArray1::from_vec(py, points))
}

/// The densities of a scene at `dims` voxels of a box: extinction at V [pc-1] of dust where there is dust, then each
/// glowing species.
#[pyfunction]
pub fn densities<'py>(
    py: Python<'py>,
    scene: &Scene,
    dims: [usize; 3],
    bounds: CellCorners,
    memory_limit: u64,
) -> PyResult<Vec<Bound<'py, PyArray1<f32>>>> {
    let grids = work::run(py, None, |control| {
        let bounds = Bounds { low: DVec3::from_array(bounds.0), high: DVec3::from_array(bounds.1) }.checked()?;
        plan::densities(&scene.0, &Lattice { dims, bounds }, &plan_options(memory_limit)?, control)
    })?;
    Ok(grids.iter().map(|grid| PyArray1::from_vec(py, grid.values().into_owned())).collect())
}

/// The lowest and the highest corner [pc] of the box outside of which the dust of a scene is zero.
#[pyfunction]
pub fn dust_bounds(scene: &Scene) -> Option<CellCorners> {
    scene.0.dust.as_ref().map(|dust| corners(&dust.density.bounds()))
}

/// Data shared by all bricks of a volume.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Whole {
    scene: Owner,
    whole: bricks::Whole,
}

#[pymethods]
impl Whole {
    /// Plans a scene of coarse densities for a volume of `dims` voxels in the same box, cut where bricks begin.
    #[new]
    fn new(py: Python, scene: &Scene, dims: [usize; 3], cuts: [Vec<usize>; 3], memory_limit: u64) -> PyResult<Self> {
        let options = plan_options(memory_limit).map_err(|error| raised(py, error))?;
        let whole = work::run(py, None, |control| bricks::Whole::new(&scene.0, dims, cuts, &options, control))?;
        Ok(Self { scene: scene.0.clone(), whole })
    }

    /// The lowest and the highest corner of the box [pc].
    #[getter]
    fn bounds(&self) -> CellCorners {
        corners(&self.whole.partition().lattice().bounds)
    }

    /// Places of the stars that have depths [pc].
    #[getter]
    fn stars(&self) -> Vec<[f64; 3]> {
        self.whole.stars().into_iter().map(Into::into).collect()
    }

    /// Bricks in an order in which none stands before one that comes earlier.
    fn front_to_back(&self) -> Vec<[usize; 3]> {
        self.whole.front_to_back()
    }

    /// The voxels along x, y and z that the march of a brick reads.
    fn stored(&self, place: [usize; 3]) -> [Pair; 3] {
        self.whole.stored(place).each_ref().map(pair)
    }

    /// Effect of a brick on the rays of the picture, given what stands at the voxels that it holds.
    fn march<'py>(
        &self,
        py: Python<'py>,
        place: [usize; 3],
        dust: Option<BrickValues<'py>>,
        star_depths: Vec<BrickValues<'py>>,
        gas: Vec<BrickValues<'py>>,
    ) -> PyResult<PartialParts<'py>> {
        let all = |arrays: Vec<BrickValues>| arrays.iter().map(values).collect::<PyResult<Vec<_>>>();
        let fields = BrickFields { dust: dust.as_ref().map(values).transpose()?, star_depths: all(star_depths)?, gas: all(gas)? };
        Ok(given(py, work::run(py, None, |control| self.whole.march(place, fields, control))?))
    }

    /// Combined effect of two bricks, the nearer one first.
    fn over<'py>(&self, py: Python<'py>, front: GivenPartial<'py>, back: GivenPartial<'py>) -> PyResult<PartialParts<'py>> {
        let (front, back) = (front.taken()?, back.taken()?);
        Ok(given(py, work::run(py, None, |_| self.whole.over(front, back))?))
    }

    /// The picture of what all bricks do.
    fn picture(&self, py: Python, partial: GivenPartial) -> PyResult<Image> {
        let partial = partial.taken()?;
        let (image, _) = work::run(py, None, |control| self.whole.picture(&partial, control))?;
        Ok(Image::new(self.scene.clone(), image))
    }
}

/// The sweeps of one star's depths through bricks.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct StarSweep {
    partition: Partition,
    relay: Relay,
    layers: Vec<Layer>,
}

impl StarSweep {
    fn layer(&self, number: usize) -> Result<&Layer> {
        let allowed = || format!("below {}", self.layers.len());
        self.layers.get(number).ok_or_else(|| Error::out_of_range("layer of a sweep", number, allowed()))
    }

    fn grid(&self, values: Vec<f32>, voxels: &[Range<usize>; 3]) -> Result<Grid> {
        let lattice = self.partition.lattice().part(voxels);
        Grid::new(lattice.dims, lattice.bounds, values)
    }
}

#[pymethods]
impl StarSweep {
    /// The sweeps from a star through `dims` voxels of a box, cut where bricks begin; places are in pc.
    #[new]
    fn new(py: Python, dims: [usize; 3], bounds: CellCorners, cuts: [Vec<usize>; 3], star: [f64; 3]) -> PyResult<Self> {
        let bounds = Bounds { low: DVec3::from_array(bounds.0), high: DVec3::from_array(bounds.1) };
        let partition = Partition::new(Lattice { dims, bounds }, cuts).map_err(|error| raised(py, error))?;
        let star = DVec3::from_array(star);
        if !star.is_finite() {
            return Err(raised(py, Error::out_of_range("position of a star", star, "finite")));
        }
        let relay = Relay::new(partition.clone(), star);
        let layers = relay.layers();
        Ok(Self { partition, relay, layers })
    }

    /// The voxel on whose centre the star stands, which no frustum has: its depth is zero.
    #[getter]
    fn own_voxel(&self) -> Option<[usize; 3]> {
        self.relay.own_voxel()
    }

    /// For each layer its frustum and its bricks; those of a frustum are in the order in which its rays meet them.
    #[getter]
    fn layers(&self) -> Vec<(usize, Vec<[usize; 3]>)> {
        self.layers.iter().map(|layer| (layer.frustum, layer.bricks.clone())).collect()
    }

    /// True if rays come in through sides of the box, so that a pass must find their entries.
    fn has_entries(&self, frustum: usize) -> bool {
        self.relay.has_entries(frustum)
    }

    /// Rays along u and v of each tier.
    fn rays(&self, frustum: usize) -> Vec<[usize; 2]> {
        self.relay.rays(frustum)
    }

    /// The voxels along x, y and z whose dust the rays of a brick meet.
    fn needs(&self, py: Python, layer: usize, place: [usize; 3]) -> PyResult<[Pair; 3]> {
        let layer = self.layer(layer).map_err(|error| raised(py, error))?;
        Ok(self.relay.needs(layer, place).each_ref().map(pair))
    }

    /// The voxels beside a side of the box, 0 or 1, through which straight ways to those of the brick run.
    fn border(&self, py: Python, layer: usize, place: [usize; 3], side: usize) -> PyResult<Option<[Pair; 3]>> {
        let layer = self.layer(layer).map_err(|error| raised(py, error))?;
        Ok(self.relay.border(layer, place, side).map(|voxels| voxels.each_ref().map(pair)))
    }

    /// Sweeps a brick: the depths of its voxels, NaN where the layer's frustum has none, and the rays that it hands on.
    ///
    /// `carried` are depths and entries of all rays of some tiers as they come into the layer.
    #[expect(clippy::too_many_arguments, reason = "Python calls it by keywords")]
    fn sweep<'py>(
        &self,
        py: Python<'py>,
        layer: usize,
        finds_entries: bool,
        place: [usize; 3],
        dust: BrickValues<'py>,
        borders: [Option<BrickValues<'py>>; 2],
        carried: BTreeMap<usize, (BrickValues<'py>, BrickValues<'py>)>,
    ) -> PyResult<SweptParts<'py>> {
        let layer = self.layer(layer).map_err(|error| raised(py, error))?;
        let pass = if finds_entries { Pass::Entries } else { Pass::Depths };
        let dust = values(&dust)?;
        let [u, v] = borders;
        let borders = [u.as_ref().map(values).transpose()?, v.as_ref().map(values).transpose()?];
        let rays: Vec<(usize, Vec<f32>, Vec<f32>)> =
            carried.iter().map(|(tier, (depths, entries))| Ok((*tier, values(depths)?, values(entries)?))).collect::<PyResult<_>>()?;
        let (depths, handed) = work::run(py, None, |control| {
            let dust = self.grid(dust, &self.relay.needs(layer, place))?;
            let mut grids = [None, None];
            for (side, values) in borders.into_iter().enumerate() {
                let voxels = self.relay.border(layer, place, side);
                grids[side] = values.zip(voxels).map(|(values, voxels)| self.grid(values, &voxels)).transpose()?;
            }
            let brick = Brick { place, dust: &dust, borders: grids.each_ref().map(|grid| grid.as_ref()) };
            let carried: Carried = rays.iter().map(|(tier, depths, entries)| (*tier, (&depths[..], &entries[..]))).collect();
            self.relay.sweep(layer, pass, &brick, &carried, control)
        })?;
        let parts = |handed: Handed| {
            let Handed { tier, rays: [u, v], depths, entries } = handed;
            (tier, pair(&u), pair(&v), PyArray1::from_vec(py, depths), PyArray1::from_vec(py, entries))
        };
        Ok((depths.map(|depths| PyArray1::from_vec(py, depths)), handed.into_iter().map(parts).collect()))
    }
}
