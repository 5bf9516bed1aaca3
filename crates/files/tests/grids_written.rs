//! Grids that are written and read again: each format has every value where it was.

use crate::support::density;
use barnard::field::{Field, Grid};
use barnard::geometry::Bounds;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;
use barnard_files::formats::{GRID_WRITERS, GridFile, grid_writer, save_grid};

const DIMS: [usize; 3] = [150, 21, 34];

/// Lumps far apart in a box of unequal voxels; a few values that are not even in the last bit.
fn lumps() -> Grid {
    let bounds = Bounds { low: DVec3::new(-3.0, 1.0, -2.5), high: DVec3::new(12.0, 4.0, 6.0) };
    let value = |x: usize, y: usize, z: usize| {
        let lump = |at: [f64; 3]| 9.0 - (x as f64 - at[0]).powi(2) - (y as f64 - at[1]).powi(2) - (z as f64 - at[2]).powi(2);
        (lump([4.0, 4.0, 5.0]).max(0.0) + 1e-7 * lump([140.0, 18.0, 30.0]).max(0.0)) as f32 / 3.0
    };
    let [nx, ny, nz] = DIMS;
    let values = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| value(x, y, z)))).collect();
    Grid::new(DIMS, bounds, values).unwrap()
}

#[test]
fn grids_come_back() {
    let (grid, folder) = (lumps(), tempfile::tempdir().unwrap());
    let keys = |extension: &str| match extension {
        "npy" => "low = \"-3 1 -2.5 pc\"\nhigh = \"12 4 6 pc\"",
        "vdb" => "scale = \"1 pc\"\narray = \"lumps\"",
        _ => "",
    };
    for writer in GRID_WRITERS {
        let path = folder.path().join(format!("lumps.{}", writer.extension));
        save_grid(&path, &GridFile { grid: &grid, unit: Some("cm-3"), name: "lumps", memory_limit: DEFAULT_LIMIT }).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let read = density(&format!("lumps.{}", writer.extension), &bytes, keys(writer.extension), DEFAULT_LIMIT).unwrap();
        let (read, lattice) = (read.grid().unwrap(), grid.lattice());
        assert!((read.lattice().voxel_pc() - lattice.voxel_pc()).abs().max_element() < 1e-12, "{}", writer.extension);
        let values = grid.values();
        for (i, truth) in values.iter().enumerate() {
            let [x, y, z] = lattice.place(i);
            let place = lattice.centre(x, y, z);
            // Beyond the box of what is active a .vdb has nothing.
            let found = read.at(place);
            assert!(
                (found - f64::from(*truth)).abs() <= 1e-9 * f64::from(*truth) + 1e-12,
                "{} {x} {y} {z}: {found} {truth}",
                writer.extension
            );
        }
        assert!(values.iter().any(|v| *v > 0.0 && *v < 1e-5));
        // Every bit is that of before, where the box is that of before as well.
        assert!(read.lattice().dims == DIMS || writer.extension == "vdb", "{}", writer.extension);
        if read.lattice().dims == DIMS {
            assert!(read.values() == values && (read.lattice().bounds.low - lattice.bounds.low).abs().max_element() < 1e-12);
        }
        // Sparse grids are written as others are.
        let sparse = density("lumps.npy", &npy(&grid), &format!("{}\nstorage = \"single\"", keys("npy")), DEFAULT_LIMIT).unwrap();
        save_grid(&path, &GridFile { grid: sparse.grid().unwrap(), unit: None, name: "lumps", memory_limit: DEFAULT_LIMIT }).unwrap();
        let again = std::fs::read(&path).unwrap();
        assert!(writer.extension == "fits" || again.len() <= bytes.len(), "{}", writer.extension);
    }
    let unknown = grid_writer("a.tiff".as_ref()).err().unwrap().to_string();
    assert!(unknown.contains("known: .vdb, .fits, .h5, .npy"), "{unknown}");
}

fn npy(grid: &Grid) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    save_grid(&path, &GridFile { grid, unit: None, name: "a", memory_limit: DEFAULT_LIMIT }).unwrap();
    std::fs::read(&path).unwrap()
}

/// What cannot be written leaves nothing behind, and what was there before as it was.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn nothing_half_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing/lumps.fits");
    assert!(
        save_grid(&path, &GridFile { grid: &lumps(), unit: None, name: "lumps", memory_limit: DEFAULT_LIMIT })
            .unwrap_err()
            .to_string()
            .contains("missing")
    );
    let empty = Grid::new([9, 9, 9], lumps().lattice().bounds, vec![0.0; 729]).unwrap();
    let nothing = GridFile { grid: &empty, unit: None, name: "n", memory_limit: DEFAULT_LIMIT };
    assert!(save_grid(&folder.path().join("n.vdb"), &nothing).unwrap_err().to_string().contains("no value is above zero"));
    let path = folder.path().join("lumps.h5");
    let tight = GridFile { grid: &lumps(), unit: None, name: "lumps", memory_limit: 1 << 20 };
    assert!(save_grid(&path, &tight).unwrap_err().to_string().contains("limit"));
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none());
}
