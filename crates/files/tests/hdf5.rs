//! HDF5 files that h5py, xarray and yt wrote (hdf5/write.py), in every layout, type and packing, against the formula that
//! filled them.

use std::io::{Cursor, Read};
use std::path::Path;

use barnard::data::{Array, ArrayFrame, ArrayHeader, ArrayPart, Axis, Numbers};
use barnard_files::formats::{Member, members, read_array};

/// The bytes of a file of the archive.
fn file(name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(Cursor::new(include_bytes!("hdf5.zip"))).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

fn part(
    bytes: &[u8],
    member: Option<&str>,
    limit: u64,
    choose: impl Fn(&ArrayHeader) -> ArrayPart,
) -> Result<(ArrayHeader, Array), String> {
    let mut seen = None;
    let choose = &mut |layout: &ArrayHeader| {
        seen = Some(layout.clone());
        Ok(choose(layout))
    };
    let array = read_array(Cursor::new(bytes.to_vec()), Path::new("cloud.h5"), member, choose, limit).map_err(|e| e.to_string())?;
    Ok((seen.unwrap(), array))
}

fn whole(bytes: &[u8], member: Option<&str>) -> Result<(ArrayHeader, Array), String> {
    part(bytes, member, 1 << 26, ArrayHeader::whole)
}

const SHAPE: [usize; 3] = [12, 10, 14];

/// The value of an element, as hdf5/write.py has it, in eighths.
fn eighths([i, j, k]: [usize; 3]) -> f64 {
    ((3 * i + 5 * j + 7 * k) % 61 + 1) as f64
}

/// A part of the array, the last index fastest, blocks at its upper ends filled up with nothing.
fn expected(part: &ArrayPart, value: impl Fn([usize; 3]) -> f64) -> Vec<f64> {
    let [ni, nj, nk] = part.shape();
    let mut values = Vec::new();
    for (i, j, k) in (0..ni).flat_map(|i| (0..nj).flat_map(move |j| (0..nk).map(move |k| (i, j, k)))) {
        let along = |axis: usize, cell: usize| {
            let first = part.ranges[axis].start + cell * part.every;
            first..(first + part.every).min(part.ranges[axis].end)
        };
        let block = along(0, i).flat_map(|i| along(1, j).flat_map(move |j| along(2, k).map(move |k| [i, j, k])));
        values.push(block.map(&value).sum::<f64>() / part.every.pow(3) as f64);
    }
    values
}

fn all() -> ArrayPart {
    ArrayHeader { shape: SHAPE, frame: None }.whole()
}

fn numbers(array: &Array) -> Vec<f64> {
    assert!(!array.fortran);
    array.data.doubles()
}

/// Contents of a file.
fn listed(bytes: &[u8]) -> Vec<Member> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cloud.h5");
    std::fs::write(&path, bytes).unwrap();
    members(&path, 1 << 26).unwrap().1
}

/// Names of the datasets of a group.
fn names(bytes: &[u8], group: &str) -> Vec<String> {
    let start = format!("/{group}/");
    listed(bytes).into_iter().map(|member| member.name).filter(|name| name.starts_with(&start)).collect()
}

/// Contiguous, compact and chunked datasets, whatever index finds their chunks, in old files, new ones and behind a user
/// block; a fourth axis of one.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn every_layout_is_read() {
    let whole_array = expected(&all(), |at| eighths(at) / 8.0);
    for name in ["earliest.h5", "latest.h5", "behind.h5"] {
        let bytes = file(name);
        let datasets = names(&bytes, "layouts");
        assert_eq!(datasets.len(), 11, "{datasets:?}");
        for dataset in datasets {
            let (layout, array) = whole(&bytes, Some(&dataset)).unwrap_or_else(|e| panic!("{name} {dataset}: {e}"));
            assert_eq!((layout.shape, array.shape), (SHAPE, SHAPE), "{name} {dataset}");
            assert_eq!(numbers(&array), whole_array, "{name} {dataset}");
        }
    }
}

/// Floats of 2, 4 and 8 bytes and whole numbers of 1 to 8, of either byte order; single precision where that holds them.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn every_type_is_read() {
    let bytes = file("latest.h5");
    let datasets = names(&bytes, "types");
    assert_eq!(datasets.len(), 23, "{datasets:?}");
    for dataset in datasets {
        let (_, array) = whole(&bytes, Some(&dataset)).unwrap_or_else(|e| panic!("{dataset}: {e}"));
        let is_whole = !dataset.contains("_f");
        assert_eq!(numbers(&array), expected(&all(), |at| eighths(at) / if is_whole { 1.0 } else { 8.0 }), "{dataset}");
        let needs_more = ["f8", "i4", "i8", "u4", "u8"].iter().any(|kind| dataset.ends_with(kind));
        assert_eq!(matches!(array.data, Numbers::Double(_)), needs_more, "{dataset}");
    }
}

/// Chunks packed by gzip, LZF and szip, shuffled, with checksums, as differences; those that no packer made smaller.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn every_packing_is_read() {
    for name in ["earliest.h5", "latest.h5"] {
        let bytes = file(name);
        let datasets = names(&bytes, "filters");
        assert_eq!(datasets.len(), 9, "{datasets:?}");
        for dataset in datasets {
            let (_, array) = whole(&bytes, Some(&dataset)).unwrap_or_else(|e| panic!("{name} {dataset}: {e}"));
            let is_whole = dataset.ends_with("i4");
            assert_eq!(numbers(&array), expected(&all(), |at| eighths(at) / if is_whole { 1.0 } else { 8.0 }), "{name} {dataset}");
        }
        let noise = |dataset: &str| numbers(&whole(&bytes, Some(dataset)).unwrap().1);
        assert_eq!(noise("noise/lzf"), noise("/noise/plain"));
        let long = numbers(&whole(&bytes, Some("/long/lzf")).unwrap().1);
        assert!(long.iter().enumerate().all(|(i, v)| *v == if i % 5000 < 4000 { 0.0 } else { 2.5 }));
    }
}

/// Chunks that nobody wrote have the value that the file says.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn what_was_never_written_is_filled() {
    for name in ["earliest.h5", "latest.h5"] {
        let bytes = file(name);
        for (dataset, fill) in [("/holes/f4", 0.0), ("/filled/f4", 2.5)] {
            let written = |[i, j, k]: [usize; 3]| (5..10).contains(&i) && (4..8).contains(&j) && (6..12).contains(&k);
            let value = |at| if written(at) { eighths(at) / 8.0 } else { fill };
            assert_eq!(numbers(&whole(&bytes, Some(dataset)).unwrap().1), expected(&all(), value), "{name} {dataset}");
        }
        assert!(numbers(&whole(&bytes, Some("/nothing/f4")).unwrap().1).iter().all(|v| *v == 0.0));
    }
}

/// Numbers that netCDF's attributes say to be packed are what they stand for, and those that stand for none are blank.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn packed_numbers_are_what_they_stand_for() {
    for name in ["earliest.h5", "latest.h5"] {
        let bytes = file(name);
        // Halves of whole numbers below 24 are cut off, and four quarters above the offset mean nothing.
        let truncated = |at| (4.0 * (eighths(at) / 8.0 - 3.0)).trunc();
        let value = |at| if truncated(at) == 4.0 { f64::NAN } else { 0.25 * truncated(at) + 3.0 };
        let same = |found: Vec<f64>, expected: Vec<f64>| {
            assert!(found.iter().zip(&expected).all(|(a, b)| a == b || a.is_nan() && b.is_nan()) && found.iter().any(|v| v.is_nan()));
        };
        same(numbers(&whole(&bytes, Some("/packed/i2")).unwrap().1), expected(&all(), value));
        let blank = |at| if eighths(at) == 20.0 { f64::NAN } else { eighths(at) / 8.0 };
        same(numbers(&whole(&bytes, Some("/packed/f4")).unwrap().1), expected(&all(), blank));
    }
}

/// What is read does not depend on how many threads read it.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn threads_make_no_difference() {
    let bytes = file("latest.h5");
    let read = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let asked = ArrayPart { every: 3, ..all() };
        let read = |name: &str| part(&bytes, Some(name), 1 << 26, |_| asked.clone()).map(|read| numbers(&read.1));
        pool.install(|| (read("/filters/gzip"), read("/refused/blosc")))
    };
    let (one, many) = (read(1), read(7));
    assert!(one.0.is_ok() && one.1.is_err() && one == many);
}

/// What is read of a dataset is what was asked for: a part across chunks, and means of blocks.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn parts_are_read() {
    let bytes = file("latest.h5");
    for dataset in
        ["/layouts/contiguous", "/layouts/chunked", "/layouts/growing_twice_packed", "/layouts/four_axes", "/filters/lzf_shuffle"]
    {
        for ranges in [[0..12, 0..10, 0..14], [3..9, 1..9, 4..5], [4..5, 9..10, 0..14], [11..12, 0..1, 13..14]] {
            for every in [1, 2, 3, 40] {
                let asked = ArrayPart { ranges: ranges.clone(), every, clip: false, blocking: None };
                let (_, array) = part(&bytes, Some(dataset), 1 << 26, |_| asked.clone()).unwrap();
                assert_eq!(array.shape, asked.shape());
                for (found, expected) in numbers(&array).iter().zip(expected(&asked, |at| eighths(at) / 8.0)) {
                    assert!((found - expected).abs() <= 1e-6 * expected, "{dataset} {asked:?}: {found} {expected}");
                }
            }
        }
    }
}

/// Datasets are found by hard and soft links and in large groups; links that lead back, nowhere or out of the file do no
/// harm.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn links_are_followed() {
    for name in ["earliest.h5", "latest.h5"] {
        let bytes = file(name);
        for dataset in ["/links/hard", "links/soft", "/links/many/group_17/f4", "/links/back/layouts/chunked"] {
            assert_eq!(numbers(&whole(&bytes, Some(dataset)).unwrap().1), expected(&all(), |at| eighths(at) / 8.0), "{name} {dataset}");
        }
        for dataset in ["/links/nowhere", "/links/outside", "/links/back", "/gas/density", ""] {
            let message = whole(&bytes, Some(dataset)).unwrap_err();
            assert!(message.contains("has no dataset") && message.contains("\"/filters/gzip\""), "{name} {dataset}: {message}");
        }
    }
}

/// What is no grid is refused by name, and what there is to choose from is said.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn what_is_no_grid_is_refused() {
    let bytes = file("latest.h5");
    for (dataset, reason) in [
        ("texts", "has texts"),
        ("records", "has records"),
        ("complex", "has records"),
        ("flat", "4 x 4"),
        ("empty", "empty"),
        ("bfloat", "IEEE 754"),
        ("twelve_bits", "padding bits"),
        ("never_written", "almost none were written"),
        ("blosc", "compressed with Blosc"),
        ("zstd", "compressed with Zstandard"),
    ] {
        let message = whole(&bytes, Some(&format!("/refused/{dataset}"))).unwrap_err();
        assert!(message.contains(reason) && message.contains(&format!("/refused/{dataset}")), "{dataset}: {message}");
    }
    let close = whole(&bytes, Some("/layouts/chunkd")).unwrap_err();
    assert!(close.contains("did you mean \"/layouts/chunked\"?"), "{close}");
    let several = whole(&bytes, None).unwrap_err();
    assert!(several.contains("array =") && several.contains("more"), "{several}");
    let memory = part(&bytes, Some("/layouts/chunked"), 1000, ArrayHeader::whole).unwrap_err();
    assert!(memory.contains("limit"), "{memory}");
    // The array is small when its blocks are joined, its only chunk is not.
    let chunk = part(&bytes, Some("/layouts/one_chunk"), 5000, |layout| ArrayPart { every: 14, ..layout.whole() }).unwrap_err();
    assert!(chunk.contains("chunk"), "{chunk}");
}

fn frame(name: &str, dataset: Option<&str>) -> ArrayFrame {
    whole(&file(name), dataset).unwrap().0.frame.unwrap()
}

fn axis(unit: &str, step: f64, first: f64) -> Option<Axis> {
    Some(Axis { unit: unit.into(), step, first })
}

/// Units, names of axes and coordinates are read where h5py, xarray and yt write them.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn places_are_read() {
    let labels = frame("labels.h5", None);
    assert_eq!((labels.order, labels.unit.as_deref(), labels.axes), ("zyx", Some("cm^-3"), [None, None, None]));
    let xarray = frame("xarray.nc", Some("density"));
    assert_eq!((xarray.order, xarray.unit.as_deref()), ("zyx", Some("m^-3")));
    assert_eq!(xarray.axes, [axis("pc", 0.5, -2.0), axis("pc", -0.25, 3.0), axis("pc", 1.0, 10.0)]);
    let uneven = frame("uneven.nc", Some("density"));
    assert!(uneven.others[1].as_ref().is_some_and(|other| other.contains("unequal")), "{:?}", uneven.others);
    let bare = frame("no_coordinates.nc", None);
    assert_eq!((bare.order, bare.axes), ("zyx", [None, None, None]));
    // Boxes of yt are in its own unit of length, here of two parsecs.
    let yt = frame("yt.h5", Some("/grid/density"));
    assert_eq!((yt.order, yt.unit.as_deref()), ("xyz", Some("g/cm**3")));
    for (found_axis, (low, high), count) in [(&yt.axes[0], (-2.0, 2.0), 12), (&yt.axes[1], (-4.0, 4.0), 10), (&yt.axes[2], (0.0, 14.0), 14)]
    {
        let axis = found_axis.as_ref().unwrap();
        let step = (high - low) / f64::from(count);
        // The file has it in centimetres.
        let pc = parsecs(&axis.unit);
        assert!((axis.step * pc / step - 1.0).abs() < 1e-9, "{axis:?}");
        assert!((axis.first * pc - (low + 0.5 * step)).abs() < 1e-9, "{axis:?}");
    }
}

/// Length of a unit in parsecs.
fn parsecs(unit: &str) -> f64 {
    use spectra::units::{Length, Quantity};
    Length::unit_size(unit).unwrap()
}

/// Files that end too early are refused; those with flipped bits give errors or numbers, and no panic.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn broken_files_are_refused() {
    for (name, datasets) in [
        ("labels.h5", &["/gas/n_H"][..]),
        ("xarray.nc", &["/density"]),
        ("earliest.h5", &["/filters/gzip", "/filters/szip_nn", "/layouts/growing"]),
        ("latest.h5", &["/filters/lzf_shuffle", "/layouts/growing_packed", "/layouts/growing_twice", "/types/big_f2"]),
    ] {
        let bytes = file(name);
        let refused = |bytes: &[u8]| datasets.iter().filter(|name| part(bytes, Some(name), 1 << 22, ArrayHeader::whole).is_err()).count();
        assert_eq!(refused(&bytes), 0, "{name}");
        let read: Vec<usize> = (0..bytes.len()).step_by(997).filter(|end| refused(&bytes[..*end]) < datasets.len()).collect();
        assert!(read.is_empty(), "{name} cut short at {read:?} of {}", bytes.len());
        let flipped = (0..bytes.len()).step_by(131).filter(|byte| {
            let mut bytes = bytes.clone();
            bytes[*byte] ^= 1 << (byte % 8);
            refused(&bytes) > 0
        });
        assert!(flipped.count() > 0, "{name}");
    }
}
