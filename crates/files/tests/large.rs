//! Files that are larger than what may be held of them: a reader takes the memory of its result, and little beside it.

mod allocated;

use std::path::Path;
use std::sync::Arc;

use allocated::most_allocated;
use barnard::data::Inputs;
use barnard::field::{Field, Grid, load};
use barnard::geometry::Bounds;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;
use barnard::properties::{Section, Table, Value};
use barnard_files::SceneFiles;
use barnard_files::formats::{GRID_WRITERS, GridFile, save_grid};

const EDGE: usize = 224;
const MIB: usize = 1 << 20;

/// A ball in an empty box, of which it takes a sixteenth.
fn ball() -> Grid {
    let bounds = Bounds::cube(DVec3::ZERO, 1.0);
    let at = |i: usize| 2.0 * (i as f32 + 0.5) / EDGE as f32 - 1.0;
    let value = |x: usize, y: usize, z: usize| (1.0 - 6.0 * (at(x).powi(2) + at(y).powi(2) + at(z).powi(2))).max(0.0);
    let values = (0..EDGE).flat_map(|z| (0..EDGE).flat_map(move |y| (0..EDGE).map(move |x| value(x, y, z)))).collect();
    Grid::new([EDGE; 3], bounds, values).unwrap()
}

/// The most that was allocated for a field of a file with some keys, in MiB.
fn most(folder: &Path, name: &str, keys: &[(&str, Value)], limit: u64) -> usize {
    let mut table = Table::default();
    let text = |text: &str| Value::Text(text.into());
    table.insert("file", text(name));
    match name.rsplit('.').next() {
        Some("vdb") => table.insert("scale", text("1 pc")),
        Some("npy") => table.insert("voxel", text("0.01 pc")),
        _ => {}
    }
    keys.iter().for_each(|(key, value)| table.insert(*key, value.clone()));
    let inputs = Inputs::new(Arc::new(SceneFiles::in_folder(folder)), limit);
    // Each thread has memory of its own.
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let (loaded, most) = most_allocated(|| threads.install(|| load(&Section::new(&table, "field.n"), &inputs)));
    let grid = loaded.unwrap().grid;
    assert!((0.9..=1.0).contains(&grid.at(DVec3::ZERO)), "{name}");
    most / MIB
}

#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn what_is_read_takes_its_own_memory() {
    let folder = tempfile::tempdir().unwrap();
    let whole = 4 * EDGE.pow(3) / MIB;
    for writer in GRID_WRITERS {
        let name = format!("ball.{}", writer.extension);
        let file = GridFile { grid: &ball(), unit: Some("cm-3"), name: "ball", memory_limit: DEFAULT_LIMIT };
        save_grid(&folder.path().join(&name), &file).unwrap();
        let storage = |name: &str| ("storage", Value::Text(name.into()));
        let takes = |keys: &[(&str, Value)]| most(folder.path(), &name, keys, DEFAULT_LIMIT);
        let (all, coarse) = (takes(&[]), takes(&[("every", Value::Integer(4))]));
        let [single, half] = ["single", "half"].map(|name| takes(&[storage(name)]));
        // Threads unpack four blocks of an HDF5 file at once, each of 4 MiB as it is stored, and as numbers.
        let beside = if writer.extension == "h5" { 4 * 4 * 2 + 2 } else { 4 };
        let numbers = format!("{name}, of {whole} MiB: {all} all, {coarse} by four, {single} in blocks, {half} of halves");
        println!("{numbers}");
        // Means are summed up as doubles.
        assert!(coarse <= 3 * whole / 64 + beside, "{numbers}");
        assert!(single <= whole / 8 + beside && half <= whole / 16 + beside, "{numbers}");
        // One whose axes are turned stands there twice, unless that is more than there may be.
        let turned = if writer.extension == "h5" { whole } else { 0 };
        let expected = if writer.extension == "vdb" { single..=single } else { whole..=whole + turned + beside };
        assert!(expected.contains(&all), "{numbers}");
        let limited = most(folder.path(), &name, &[], 2 * (whole * MIB) as u64);
        assert!(limited <= whole / 8 + beside, "{numbers}, {limited} limited");
    }
}
