//! Placement of arrays of files in a scene, and the parts that are read.

use std::sync::Arc;

use crate::support::density;
use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::field::Field;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner};
use npyz::WriterBuilder;

/// A grid of OpenVDB from its archive: voxels 2 to 31 along x, 2 to 15 along y and z.
fn vdb(name: &str, keys: &str) -> Result<Arc<dyn Field>, String> {
    let bytes = unpacked(include_bytes!("vdb.zip"), &format!("{name}.vdb"));
    density("cloud.vdb", &bytes, keys, DEFAULT_LIMIT)
}

/// An array of 40 x 30 x 20 singles, x slowest, whose values tell their places.
fn npy() -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::<f32>::new().default_dtype().shape(&[40, 30, 20]).writer(&mut bytes);
    let mut writer = options.begin_nd().unwrap();
    let places = (0..40).flat_map(|x| (0..30).flat_map(move |y| (0..20).map(move |z| (x, y, z))));
    writer.extend(places.map(|(x, y, z)| value(x, y, z))).unwrap();
    writer.finish().unwrap();
    bytes
}

fn value(x: i32, y: i32, z: i32) -> f32 {
    (x * 1000 + y * 30 + z) as f32
}

fn close(at: DVec3, expected: [f64; 3]) -> bool {
    (at - DVec3::from(expected)).abs().max_element() < 1e-9
}

/// The box of a grid without units is what `scale`, `voxel` or corners say; without any the error names all three.
#[test]
fn lengths_without_a_unit_are_given_one() {
    let bounds = |name: &str, keys: &str| vdb(name, keys).map(|field| field.bounds());
    let message = bounds("map_uniform", "").unwrap_err();
    assert!(["scale", "voxel", "low and high"].iter().all(|key| message.contains(key)), "{message}");
    // Voxels of a half from 2 on reach from 0.75 to 15.75, or 7.75.
    let scaled = bounds("map_uniform", "scale = \"2 pc\"").unwrap();
    assert!(close(scaled.low, [1.5; 3]) && close(scaled.high, [31.5, 15.5, 15.5]), "{scaled:?}");
    let moved = bounds("map_uniform", "scale = \"2 pc\"\ncentre = \"0 0 100 pc\"").unwrap();
    assert!(close(moved.low, [-15.0, -7.0, 93.0]) && close(moved.high, [15.0, 7.0, 107.0]), "{moved:?}");
    let by_voxel = bounds("map_uniform", "voxel = \"0.1 pc\"").unwrap();
    assert!(close(by_voxel.low, [-1.5, -0.7, -0.7]) && close(by_voxel.high, [1.5, 0.7, 0.7]), "{by_voxel:?}");
    let field = bounds("map_uniform", "low = \"0 0 0 pc\"\nhigh = \"3 1 1 pc\"").unwrap();
    assert!(close(field.low, [0.0; 3]) && close(field.high, [3.0, 1.0, 1.0]), "{field:?}");
    // Beyond the active voxels there is nothing: a box that reaches there is cut to them, one that lies there is refused.
    let cut = bounds("map_uniform", "scale = \"2 pc\"\nlow = \"-9 3.5 -9 pc\"\nhigh = \"9.5 99 99 pc\"").unwrap();
    assert!(close(cut.low, [1.5, 3.5, 1.5]) && close(cut.high, [9.5, 15.5, 15.5]), "{cut:?}");
    let beside = bounds("map_uniform", "scale = \"2 pc\"\nlow = \"50 3 3 pc\"\nhigh = \"60 9 9 pc\"").unwrap_err();
    assert!(beside.contains("choose a box within the array"), "{beside}");
    let flat = bounds("map_scale", "voxel = \"1 pc\"").unwrap_err();
    assert!(flat.contains("not cubes") && flat.contains("scale"), "{flat}");
    let nothing = density("a.npy", &npy(), "scale = \"1 pc\"", DEFAULT_LIMIT).map(|_| ()).unwrap_err();
    assert!(nothing.contains("no lengths to scale"), "{nothing}");
}

/// Axes that a file turns are turned back: each voxel is where the file's transform puts it.
#[test]
fn turned_axes_lie_where_the_file_says() {
    let straight = vdb("map_scale_translate", "scale = \"1 pc\"").unwrap();
    let turned = vdb("map_turned", "scale = \"1 pc\"").unwrap();
    let mut seen = 0;
    for [i, j, k] in [[3, 2, 2], [5, 7, 4], [16, 11, 11], [24, 8, 8], [31, 15, 15], [10, 3, 10]] {
        let [x, y, z] = [i, j, k].map(f64::from);
        let value = straight.at(DVec3::new(10.0 + 0.5 * x, 20.0 + y, 30.0 + 2.0 * z));
        // x to y, y to z, z to -x.
        assert_eq!(turned.at(DVec3::new(10.0 - 2.0 * z, 20.0 + 0.5 * x, 30.0 + y)), value, "{i} {j} {k}");
        seen += usize::from(value > 0.0);
    }
    assert_eq!(seen, 6);
    let bounds = turned.bounds();
    assert!(close(bounds.low, [-21.0, 20.75, 31.5]) && close(bounds.high, [7.0, 35.75, 45.5]), "{bounds:?}");
}

/// A box within that of the array is read alone, to whole voxels; one beside it is refused.
#[test]
fn parts_are_read() {
    let stored = |keys: &str| density("a.npy", &npy(), &format!("voxel = \"1 pc\"\ncentre = \"20 15 10 pc\"\n{keys}"), DEFAULT_LIMIT);
    let whole = stored("").unwrap();
    let part = stored("low = \"3.5 4 5 pc\"\nhigh = \"9 8.2 7 pc\"").unwrap();
    let bounds = part.bounds();
    assert!(close(bounds.low, [3.0, 4.0, 5.0]) && close(bounds.high, [9.0, 9.0, 7.0]), "{bounds:?}");
    assert_eq!(part.grid().unwrap().lattice().dims, [6, 5, 2]);
    for at in [[3.5, 4.5, 5.5], [8.5, 8.5, 6.5], [5.2, 6.1, 6.0]] {
        assert_eq!(part.at(at.into()), whole.at(at.into()), "{at:?}");
    }
    assert_eq!(part.at(DVec3::new(4.5, 5.5, 6.5)), f64::from(value(4, 5, 6)));
    let beside = stored("low = \"-1 0 0 pc\"\nhigh = \"9 8 7 pc\"").map(|_| ()).unwrap_err();
    assert!(beside.contains("from 0.0000 0.0000 0.0000 to 40.0000 30.0000 20.0000 pc"), "{beside}");
}

/// Means of blocks are those of the values, blocks at the upper end filled up with nothing, and no more memory is taken
/// than they need.
#[test]
fn blocks_become_their_means() {
    let stored = |keys: &str, limit: u64| density("a.npy", &npy(), &format!("low = \"0 0 0 pc\"\nhigh = \"40 30 20 pc\"\n{keys}"), limit);
    let coarse = stored("every = 8", DEFAULT_LIMIT).unwrap();
    let grid = coarse.grid().unwrap();
    let bounds = grid.lattice().bounds;
    assert_eq!(grid.lattice().dims, [5, 4, 3]);
    assert!(close(bounds.low, [0.0; 3]) && close(bounds.high, [40.0, 32.0, 24.0]), "{bounds:?}");
    let mean = |[x, y, z]: [i32; 3]| {
        let block = |cell: i32, end: i32| 8 * cell..(8 * cell + 8).min(end);
        let all = block(x, 40).flat_map(|i| block(y, 30).flat_map(move |j| block(z, 20).map(move |k| f64::from(value(i, j, k)))));
        all.sum::<f64>() / 512.0
    };
    for cell in [[0, 0, 0], [4, 2, 1], [4, 3, 2], [1, 3, 0]] {
        let at = DVec3::from(cell.map(|i| 8.0 * f64::from(i) + 4.0));
        let (found, expected) = (coarse.at(at), mean(cell));
        assert!((found / expected - 1.0).abs() < 1e-6, "{cell:?}: {found} {expected}");
    }
    // 24000 values take 96 kB, their means of blocks of 8 next to nothing.
    let limit = 64 << 10;
    assert!(stored("", limit).map(|_| ()).unwrap_err().contains("limit"));
    assert!(stored("every = 8", limit).is_ok());
    for wrong in ["every = 0", "every = 2000", "every = 1.5"] {
        assert!(stored(wrong, DEFAULT_LIMIT).map(|_| ()).unwrap_err().contains("every"), "{wrong}");
    }
}

/// A file of an archive.
fn unpacked(archive: &[u8], name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(archive)).unwrap();
    let mut bytes = Vec::new();
    std::io::copy(&mut archive.by_name(name).unwrap(), &mut bytes).unwrap();
    bytes
}

/// A box that a file says along x, y and z holds in the order in which its axes were taken, and is refused in another.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn boxes_by_letter_hold_in_their_order() {
    let bytes = unpacked(include_bytes!("hdf5.zip"), "edges.h5");
    let bounds = density("edges.h5", &bytes, "", DEFAULT_LIMIT).unwrap().bounds();
    assert!(close(bounds.low, [0.0; 3]) && close(bounds.high, [14.0, 10.0, 12.0]), "{bounds:?}");
    let other = density("edges.h5", &bytes, "axes = \"zyx\"", DEFAULT_LIMIT).map(|_| ()).unwrap_err();
    assert!(other.contains("read as xyz") && other.contains("wcs = false"), "{other}");
    let keys = r#"axes = "zyx"
wcs = false
low = "0 0 0 pc"
high = "14 10 12 pc""#;
    assert_eq!(density("edges.h5", &bytes, keys, DEFAULT_LIMIT).unwrap().grid().unwrap().lattice().dims, [14, 10, 12]);
}

/// One cloud is one field, to the last bit, whatever format it is read from: NumPy, FITS plain, in tiles and packed by
/// gzip, HDF5 in half, single and double precision, of either byte order, in chunks and not.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn one_cloud_is_the_same_from_each_format() {
    let (fits, hdf5) = (&include_bytes!("fits.zip")[..], &include_bytes!("hdf5.zip")[..]);
    let mut npy = Vec::new();
    let mut writer = npyz::WriteOptions::<f32>::new().default_dtype().shape(&[12, 10, 14]).writer(&mut npy).begin_nd().unwrap();
    let places = (0..12).flat_map(|i| (0..10).flat_map(move |j| (0..14).map(move |k| (i, j, k))));
    writer.extend(places.map(|(i, j, k)| ((3 * i + 5 * j + 7 * k) % 61 + 1) as f32 / 8.0)).unwrap();
    writer.finish().unwrap();
    let with_keys = |name: &str, bytes: &[u8], keys: &str| {
        let keys = format!(
            r#"axes = "zyx"
voxel = "2 pc"
unit = "cm-3"
{keys}"#
        );
        density(name, bytes, &keys, DEFAULT_LIMIT).unwrap_or_else(|e| panic!("{name} {keys}: {e}"))
    };
    let expected = with_keys("a.npy", &npy, "");
    let is_same = |field: &Arc<dyn Field>| {
        let (found, expected) = (field.grid().unwrap(), expected.grid().unwrap());
        found.lattice() == expected.lattice() && found.values() == expected.values()
    };
    for name in ["plain.fits", "plain.fits.gz", "f4_gzip_2.fits", "f8_gzip_1.fits", "fpack_gzip.fits.fz"] {
        assert!(is_same(&with_keys(name, &unpacked(fits, name), "")), "{name}");
    }
    let latest = unpacked(hdf5, "latest.h5");
    for dataset in ["layouts/contiguous", "layouts/growing_twice_packed", "filters/lzf_shuffle", "types/big_f2", "types/little_f8"] {
        assert!(is_same(&with_keys("latest.h5", &latest, &format!("array = \"{dataset}\""))), "{dataset}");
    }
    // Another cloud is not the same.
    let other = with_keys("latest.h5", &latest, "array = \"types/little_i4\"");
    assert!(!is_same(&other));
    // Nor are its pictures; those of one cloud are, bit by bit.
    let blocks = with_keys("plain.fits.gz", &unpacked(fits, "plain.fits.gz"), "storage = \"single\"");
    let tiles = with_keys("f8_gzip_1.fits", &unpacked(fits, "f8_gzip_1.fits"), "");
    let chunks = with_keys("latest.h5", &latest, "array = \"filters/lzf_shuffle\"");
    let truth = picture(&expected);
    assert!(truth.iter().any(|v| *v > 0.0) && [blocks, tiles, chunks].iter().all(|field| picture(field) == truth));
    assert!(picture(&other) != truth);
}

/// The radiance of a cloud that a star lights.
fn picture(cloud: &Arc<dyn Field>) -> Vec<f64> {
    let text = r#"bands = "johnson"
[camera]
kind = "perspective"
position = "3 2 90 pc"
field_of_view = "25 deg"
size = [24, 20]
[field.cloud]
kind = "sphere"
radius = "5 pc"
[dust]
density = "cloud"
scale = "0.02 /pc"
law = "ccm89"
albedo = 0.6
[[star]]
kind = "blackbody"
position = "1 2 3 pc"
temperature = "9000 K"
luminosity = "100 Lsun"
visible = false
"#;
    let scene = barnard_files::parse("c.toml", "c", text.to_owned(), &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
    let scene = scene.edited(|spec| spec.dust.as_mut().unwrap().density = cloud.clone()).unwrap();
    let plan = Planner::new(&Options::default()).plan(&scene, None, &Control::default()).unwrap();
    let image = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
    (0..image.bands.len()).flat_map(|band| image.band(band).collect::<Vec<_>>()).collect()
}

/// An array that is kept in blocks is the same field: every value, between voxels, along lines and in means, whichever
/// way its axes run; and to the error that is stated where halves or bytes are asked for.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn blocks_are_the_array() {
    let latest = unpacked(include_bytes!("hdf5.zip"), "latest.h5");
    let tiles = unpacked(include_bytes!("fits.zip"), "f4_gzip_2.fits");
    let cases = [
        ("a.npy", npy(), "voxel = \"1 pc\""),
        ("a.npy", npy(), "voxel = \"1 pc\"\naxes = \"yzx\"\nfactor = 0.3"),
        ("latest.h5", latest, "voxel = \"2 pc\"\narray = \"filters/lzf_shuffle\"\nunit = \"cm-3\""),
        ("f4_gzip_2.fits", tiles, "voxel = \"2 pc\"\nunit = \"cm-3\""),
    ];
    for (name, bytes, keys) in &cases {
        for more in ["", "every = 3\nclip = true", "low = \"-6 -3 -4 pc\"\nhigh = \"5 4 4 pc\""] {
            let stored = |storage: &str| density(name, bytes, &format!("{keys}\n{more}\n{storage}"), DEFAULT_LIMIT).unwrap();
            let (rows, single) = (stored(""), stored("storage = \"single\""));
            let (rows, single) = (rows.grid().unwrap(), single.grid().unwrap());
            assert!(rows.lattice() == single.lattice() && rows.values() == single.values(), "{name} {keys} {more}");
            let bounds = rows.lattice().bounds;
            for i in 0..40 {
                let place = |step: f64| bounds.low + bounds.size() * DVec3::new(step, 1.7 * step, 0.3 + 2.3 * step).map(f64::fract);
                let (a, b) = (place(0.013 * f64::from(i)), place(0.21 + 0.031 * f64::from(i)));
                assert!(rows.at(a) == single.at(a) && rows.column(a, b, f64::INFINITY) == single.column(a, b, f64::INFINITY));
            }
            assert!(rows.merged(2, 1.5).values() == single.merged(2, 1.5).values());
            let largest = rows.values().iter().fold(0.0f32, |most, v| v.max(most));
            for (storage, relative, absolute) in [("half", 1.0 / 2048.0, 0.0), ("byte", 0.0, 1.0 / 508.0)] {
                let coarse = stored(&format!("storage = \"{storage}\""));
                let values = coarse.grid().unwrap().values().into_owned();
                let error = |(found, truth): (&f32, &f32)| (found - truth).abs() <= 1.001 * (relative * truth + absolute * largest);
                assert!(values.iter().zip(rows.values().iter()).all(error), "{name} {keys} {more} {storage}");
                assert!(more.contains("every") || name.ends_with("h5") || name.ends_with("fits") || values != *rows.values(), "{storage}");
            }
        }
    }
    let wrong = density("a.npy", &npy(), "voxel = \"1 pc\"\nstorage = \"nibble\"", DEFAULT_LIMIT).map(|_| ()).unwrap_err();
    assert!(["nibble", "single", "half", "byte"].iter().all(|word| wrong.contains(word)), "{wrong}");
}
