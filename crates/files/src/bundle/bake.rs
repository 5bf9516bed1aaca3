//! Bundles made from scenes: densities on fewer voxels, rounded, with the gas that stars ionise in them.

use std::sync::Arc;

use barnard::Options;
use barnard::cache;
use barnard::control::Control;
use barnard::error::{Error, Result};
use barnard::field::{Expression, Field, Lattice};
use barnard::glam::DVec3;
use barnard::image::Image;
use barnard::properties::places::set;
use barnard::properties::{Property, Table, Value};
use barnard::scene::{Loader, Scene};
use rayon::prelude::*;

use super::collected::Collected;
use super::results::Recorder;
use super::volume::Volume;
use super::{Bundle, Errors, PictureErrors};
use crate::scene::SceneFile;
use crate::{formats, toml};

/// Voxels along the longest edge that are tried first, and at least.
const FIRST: usize = 288;
const FEWEST: usize = 16;
/// Bundles that are made until one is small enough.
const ROUNDS: usize = 6;
/// Share of the next bundle in the requested bytes: sizes are not quite proportional to voxels.
const MARGIN: f64 = 0.95;
/// Samples along each edge of a voxel.
const PARTS: usize = 2;
/// Longest edge of the preview and of the compared pictures \[pixels\].
const PREVIEW_EDGE: f64 = 960.0;

/// Settings of a bundle.
#[derive(Debug, Clone)]
pub struct Baking {
    /// Most bytes of the file.
    pub bytes: usize,
    /// Options of the pictures that are compared.
    pub options: Options,
    /// True to compare pictures, of which one becomes the preview; takes the time of two renders.
    pub compares: bool,
}

/// Formula of a density in the text of a scene, and the grid that it is.
struct Density<'a> {
    /// Place of the formula, such as "dust.density".
    place: String,
    field: &'a Arc<dyn Field>,
}

/// Makes a bundle of at most a number of bytes, with its errors relative to the scene.
///
/// # Errors
/// If the scene cannot be rendered, its fields change over time, it does not fit into the bytes, or `control` stops it.
pub fn bake(file: &SceneFile, baking: &Baking, control: &Control) -> Result<Bundle> {
    let scene = &file.scene;
    let densities = densities(scene);
    let native = densities.iter().map(|density| edge(density.field)).max().unwrap_or(0);
    let mut voxels = native.min(FIRST);
    let mut smallest = usize::MAX;
    for _ in 0..ROUNDS {
        let mut bundle = on_voxels(file, &densities, native, voxels, baking.options.memory_limit, control)?;
        let mut size = bundle.encoded()?.len();
        if size <= baking.bytes {
            bundle.errors = Errors { voxels, source_voxels: native, picture: None };
            if baking.compares {
                compare(scene, &mut bundle, baking, control)?;
            }
            // The preview takes a part of the file.
            size = bundle.encoded()?.len();
            if size <= baking.bytes {
                return Ok(bundle);
            }
        }
        smallest = smallest.min(size);
        let fewer = (voxels as f64 * (MARGIN * baking.bytes as f64 / size as f64).cbrt()) as usize;
        if voxels <= FEWEST {
            break;
        }
        voxels = fewer.clamp(FEWEST, voxels - 1);
    }
    let megabytes = |bytes: usize| bytes as f64 / 1e6;
    let problem = format!("the scene takes {:.1} MB, not the requested {:.1} MB", megabytes(smallest), megabytes(baking.bytes));
    Err(Error::conflict(problem, "allow more with --limit, or use fewer files"))
}

/// Voxels along the longest edge of a grid.
fn edge(field: &Arc<dyn Field>) -> usize {
    field.grid().map_or(0, |grid| grid.lattice().dims.into_iter().max().unwrap_or(0))
}

/// Densities of a scene that are grids.
fn densities(scene: &Scene) -> Vec<Density<'_>> {
    let dust = scene.dust.iter().map(|dust| ("dust.density".to_owned(), &dust.density));
    let gas = scene.gas.iter().map(|gas| ("gas.density".to_owned(), &gas.density));
    let emission = scene.emission.iter().enumerate().map(|(i, emission)| (format!("emission.{i}.density"), &emission.density));
    let all = dust.chain(gas).chain(emission).map(|(place, field)| Density { place, field });
    all.filter(|density| density.field.grid().is_some()).collect()
}

/// Bundle with grids of at most `voxels` of `native` along their longest edge.
fn on_voxels(
    file: &SceneFile,
    densities: &[Density],
    native: usize,
    voxels: usize,
    memory_limit: u64,
    control: &Control,
) -> Result<Bundle> {
    let mut tree = file.tree().clone();
    let mut volumes: Vec<Volume> = Vec::new();
    let mut known: Vec<(&Arc<dyn Field>, String)> = Vec::new();
    for Density { place, field } in densities {
        control.check()?;
        let name = match known.iter().find(|(other, _)| Arc::ptr_eq(other, field)) {
            Some((_, name)) => name.clone(),
            None => {
                let name = place.trim_end_matches(".density").replace('.', "_");
                let (volume, lattice) = sampled(&name, field, voxels as f64 / native as f64);
                set(&mut tree, &format!("field.{name}"), grid_table(&volume, &lattice).into()).map_err(|problem| refused(&problem))?;
                volumes.push(volume);
                known.push((field, name.clone()));
                name
            }
        };
        set(&mut tree, place, Value::Text(name).into()).map_err(|problem| refused(&problem))?;
    }
    remove_unused(&mut tree);
    // The gas has the voxels of its density.
    if densities.iter().any(|density| density.place == "gas.density")
        && let Some(Value::Table(gas)) = tree.get_mut("gas").map(|property| &mut property.value)
    {
        gas.remove("voxels");
    }
    // A scene without a name has that of its file.
    tree.insert("name", Value::Text(file.scene.name.clone()));
    let text = toml::text(&tree);
    let source = file.scene.provenance.as_ref().map_or_else(|| toml::text(file.tree()), |provenance| provenance.text.to_string());
    let name = file.scene.name.clone();
    let mut bundle =
        Bundle { name, text, source, preview: Vec::new(), errors: Errors::default(), files: Vec::new(), volumes, results: Vec::new() };
    // Other files are those that the scene still reads.
    let files = Arc::new(Collected::new(bundle.files()?, file.loader().inputs.source().clone()));
    let recorder = Arc::new(Recorder::new(cache::GAS));
    let loader = Loader::new(files.clone(), memory_limit).under(control).with_cache(Some(recorder.clone()));
    let scene = SceneFile::parse("scene.toml", &bundle.name, bundle.text.clone(), loader)?.scene;
    bundle.files = files.files(memory_limit)?;
    if let Some(gas) = scene.ionised() {
        // The density of the gas may be that of the dust.
        let place = tree.get("gas").and_then(|gas| match &gas.value {
            Value::Table(gas) => gas.get("density")?.value.text().map(str::to_owned),
            _ => None,
        });
        let density = bundle.volumes.iter().find(|volume| Some(&volume.name) == place.as_ref());
        bundle.results = recorder.gas(gas.cloud.lattice.dims, density);
    }
    Ok(bundle)
}

fn refused(problem: &str) -> Error {
    Error::conflict(problem.to_owned(), "bake a scene with densities in [dust], [gas] or [[emission]]")
}

/// Volume of means of a field over voxels, `share` times as many along each edge as its own grid.
fn sampled(name: &str, field: &Arc<dyn Field>, share: f64) -> (Volume, Lattice) {
    let native = field.grid().map(|grid| grid.lattice().clone()).filter(|_| share >= 1.0);
    let lattice = native.unwrap_or_else(|| {
        let edge = (edge(field) as f64 * share).round().max(2.0) as usize;
        Lattice::along(field.bounds(), edge)
    });
    let parts = if share >= 1.0 { 1 } else { PARTS };
    let [nx, ny, _] = lattice.dims;
    let voxel = lattice.voxel_pc();
    let offset = |part: usize| (part as f64 + 0.5) / parts as f64 - 0.5;
    let offsets: Vec<DVec3> = (0..parts.pow(3))
        .map(|part| DVec3::new(offset(part % parts), offset(part / parts % parts), offset(part / (parts * parts))) * voxel)
        .collect();
    let mut values = vec![0.0f32; lattice.cells()];
    values.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
        let places: Vec<DVec3> = (0..nx)
            .flat_map(|x| {
                let centre = lattice.centre(x, row % ny, row / ny);
                offsets.iter().map(move |offset| centre + *offset)
            })
            .collect();
        let mut samples = vec![0.0; places.len()];
        field.sample(&places, &mut samples);
        for (out, samples) in out.iter_mut().zip(samples.chunks_exact(offsets.len())) {
            *out = (samples.iter().sum::<f64>() / samples.len() as f64) as f32;
        }
    });
    (Volume::new(name, lattice.dims, &values), lattice)
}

/// Table of a field that reads a volume.
fn grid_table(volume: &Volume, lattice: &Lattice) -> Value {
    let corner = |corner: DVec3| Value::Quantity(corner.to_array().to_vec(), "pc".into());
    let mut table = Table::default();
    table.insert("kind", Value::Text("grid".into()));
    table.insert("file", Value::Text(format!("{}.npy", volume.name)));
    table.insert("axes", Value::Text("zyx".into()));
    table.insert("low", corner(lattice.bounds.low));
    table.insert("high", corner(lattice.bounds.high));
    table.insert("factor", Value::Number(f64::from(volume.exponent).exp2()));
    Value::Table(table)
}

/// Removes fields that no formula names.
fn remove_unused(tree: &mut Table) {
    let mut formulas = Vec::new();
    for (name, property) in tree.iter().filter(|(name, _)| *name != "field") {
        formulas_of(name, property, &mut formulas);
    }
    let Some(Value::Table(fields)) = tree.get_mut("field").map(|property| &mut property.value) else { return };
    let mut used: Vec<String> = Vec::new();
    while let Some(formula) = formulas.pop() {
        for name in Expression::names(&formula).unwrap_or_default() {
            if !used.contains(&name)
                && let Some(property) = fields.get(&name)
            {
                formulas_of("field", property, &mut formulas);
                used.push(name);
            }
        }
    }
    let unused: Vec<String> = fields.iter().map(|(name, _)| name.to_owned()).filter(|name| !used.contains(name)).collect();
    unused.iter().for_each(|name| fields.remove(name));
}

/// Adds the formulas within a value: densities, velocities and expressions.
fn formulas_of(key: &str, property: &Property, formulas: &mut Vec<String>) {
    match &property.value {
        Value::Text(text) if ["density", "velocity", "formula"].contains(&key) => formulas.push(text.clone()),
        Value::List(items) => items.iter().for_each(|item| formulas_of(key, item, formulas)),
        Value::Table(table) => table.iter().for_each(|(key, property)| formulas_of(key, property, formulas)),
        _ => {}
    }
}

/// Renders both scenes, and sets the preview and the errors of the bundle.
fn compare(source: &Scene, bundle: &mut Bundle, baking: &Baking, control: &Control) -> Result<()> {
    let camera = &source.camera;
    let scale = (PREVIEW_EDGE / camera.width.max(camera.height) as f64).min(1.0);
    let [width, height] = [camera.width, camera.height].map(|edge| ((edge as f64 * scale).round() as usize).max(1));
    let baked = bundle.scene(baking.options.memory_limit, control)?.scene;
    let pictured = |scene: &Scene| {
        let scene = scene.clone().with_camera(scene.camera.clone().with_size(width, height));
        Ok::<_, Error>((barnard::render_with(&scene, &baking.options, control)?, scene))
    };
    let (reference, _) = pictured(source)?;
    let (picture, scene) = pictured(&baked)?;
    let encode = formats::writer("preview.jpg".as_ref())?.encode;
    bundle.preview = encode(&picture, &scene.save_options())?;
    let bands = 0..reference.bands.len();
    let largest = |error: &dyn Fn(usize) -> f64| bands.clone().map(error).fold(0.0, f64::max);
    bundle.errors.picture = Some(PictureErrors {
        size: [width, height],
        rms: largest(&|band| {
            let (squares, all) = summed(&reference, &picture, band, |a, b| ((a - b).powi(2), a * a));
            (squares / all).sqrt()
        }),
        total: largest(&|band| {
            let (difference, all) = summed(&reference, &picture, band, |a, b| (a - b, a));
            (difference / all).abs()
        }),
    });
    Ok(())
}

/// Sums of two functions over the pixels of a band.
fn summed(a: &Image, b: &Image, band: usize, function: impl Fn(f64, f64) -> (f64, f64)) -> (f64, f64) {
    let pairs = a.band(band).zip(b.band(band)).map(|(a, b)| function(a, b));
    pairs.fold((0.0, 0.0), |sums, pair| (sums.0 + pair.0, sums.1 + pair.1))
}
