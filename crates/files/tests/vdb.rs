//! OpenVDB files that OpenVDB itself wrote (vdb/write.cc), in every coding, against the formula that filled them.

use std::io::{Cursor, Read};
use std::path::Path;

use barnard::data::{Array, ArrayFrame, ArrayHeader, ArrayPart, Numbers};
use barnard_files::formats::{members, read_array};

/// The bytes of a file of the archive.
fn file(name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(Cursor::new(include_bytes!("vdb.zip"))).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.vdb")).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

/// A part of a grid, and what its file says of all of it.
fn part(bytes: &[u8], member: Option<&str>, choose: impl Fn(&ArrayHeader) -> ArrayPart) -> Result<(ArrayHeader, Array), String> {
    let mut seen = None;
    let choose = &mut |layout: &ArrayHeader| {
        seen = Some(layout.clone());
        Ok(choose(layout))
    };
    let array = read_array(Cursor::new(bytes.to_vec()), Path::new("cloud.vdb"), member, choose, 1 << 26).map_err(|e| e.to_string())?;
    Ok((seen.unwrap(), array))
}

fn whole(bytes: &[u8], member: Option<&str>) -> Result<(ArrayHeader, Array), String> {
    part(bytes, member, ArrayHeader::whole)
}

fn refusal(name: &str) -> String {
    whole(&file(name), None).unwrap_err()
}

/// The lowest voxel of the clouds, and how many there are along each axis, the tile beside them included.
const LOW: [usize; 3] = [2, 2, 2];
const SHAPE: [usize; 3] = [30, 14, 14];

/// The value of a voxel, as vdb/write.cc has it.
fn voxel([i, j, k]: [usize; 3], inactive: usize) -> f64 {
    let value = ((3 * i + 5 * j + 7 * k) % 61 + 1) as f64 / 8.0;
    if (24..32).contains(&i) && (8..16).contains(&j) && (8..16).contains(&k) {
        2.0
    } else if !((2..18).contains(&i) && (2..12).contains(&j) && (2..12).contains(&k)) {
        0.0
    } else if (i + 2 * j + 3 * k) % 3 != 0 {
        value
    } else {
        [0.0, 0.25, if i < 9 { 0.25 } else { 0.5 }, value / 2.0][inactive]
    }
}

/// A part of the cloud, x running fastest, blocks at its upper ends filled up with nothing.
fn expected(part: &ArrayPart, inactive: usize) -> Vec<f64> {
    let [nx, ny, nz] = part.shape();
    let mut values = Vec::new();
    for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x)))) {
        let along = |axis: usize, cell: usize| {
            let first = part.ranges[axis].start + cell * part.every;
            (first..(first + part.every).min(part.ranges[axis].end)).map(move |i| LOW[axis] + i)
        };
        let block = along(0, x).flat_map(|i| along(1, y).flat_map(move |j| along(2, z).map(move |k| [i, j, k])));
        values.push(block.map(|place| voxel(place, inactive)).sum::<f64>() / part.every.pow(3) as f64);
    }
    values
}

fn numbers(array: &Array) -> Vec<f64> {
    assert!(array.fortran);
    array.data.doubles()
}

/// Floats, halves and doubles; plain, packed by zlib and by Blosc, all values or the active ones alone; inactive voxels
/// that hold nothing, one value, two, or each its own.
#[test]
fn every_coding_is_read() {
    let all = ArrayHeader { shape: SHAPE, frame: None }.whole();
    let mut sizes = Vec::new();
    for kind in ["float", "half", "double", "halved"] {
        // No writer at hand packs doubles as halves by zlib.
        let packers = ["plain", "blosc", "zip"].into_iter().take(if kind == "halved" { 2 } else { 3 });
        let packings = packers.flat_map(|p| [p.to_owned(), format!("{p}_mask")]).map(|p| (p, 0));
        for (packing, inactive) in packings.chain((1..4).map(|i| (format!("inactive{i}"), i))) {
            let bytes = file(&format!("{kind}_{packing}"));
            let (layout, array) = whole(&bytes, None).unwrap();
            assert_eq!((layout.shape, array.shape), (SHAPE, SHAPE), "{kind} {packing}");
            assert!(matches!(array.data, Numbers::Double(_)) == (kind == "double" || kind == "halved"), "{kind} {packing}");
            assert_eq!(numbers(&array), expected(&all, inactive), "{kind} {packing}");
            sizes.push(bytes.len());
        }
    }
    sizes.dedup();
    assert!(sizes.len() > 30, "the files are packed in different ways: {sizes:?}");
    let (_, streamed) = whole(&file("streamed"), None).unwrap();
    assert_eq!(numbers(&streamed), expected(&all, 0));
}

/// What is read of a file is what was asked for: a part, means of blocks, what is left when negative values are clipped.
#[test]
fn parts_are_read() {
    for name in ["float_blosc_mask", "double_plain", "half_zip"] {
        for ranges in [[0..30, 0..14, 0..14], [3..9, 1..11, 4..5], [20..30, 5..14, 5..14], [16..17, 13..14, 0..1]] {
            for every in [1, 2, 3, 40] {
                let asked = ArrayPart { ranges: ranges.clone(), every, clip: every == 2, blocking: None };
                let (_, array) = part(&file(name), None, |_| asked.clone()).unwrap();
                assert_eq!(array.shape, asked.shape());
                for (found, expected) in numbers(&array).iter().zip(expected(&asked, 0)) {
                    assert!((found - expected).abs() <= 1e-6 * expected, "{name} {asked:?}: {found} {expected}");
                }
            }
        }
    }
}

/// Voxels go where the file's transform puts them; what is none of the axes' is refused by name.
#[test]
fn transforms_are_read() {
    let read = |name: &str| -> (ArrayFrame, Vec<(f64, f64)>) {
        let frame = whole(&file(&format!("map_{name}")), None).unwrap().0.frame.unwrap();
        let axes = frame.axes.iter().flatten().map(|axis| (axis.step, axis.first)).collect();
        (frame, axes)
    };
    for (name, order, expected) in [
        ("uniform", "xyz", [(0.5, 1.0), (0.5, 1.0), (0.5, 1.0)]),
        ("scale", "xyz", [(0.5, 1.0), (1.0, 2.0), (2.0, 4.0)]),
        ("translate", "xyz", [(1.0, 12.0), (1.0, 22.0), (1.0, 32.0)]),
        ("uniform_translate", "xyz", [(0.5, 11.0), (0.5, 21.0), (0.5, 31.0)]),
        ("scale_translate", "xyz", [(0.5, 11.0), (1.0, 22.0), (2.0, 34.0)]),
        // x goes to y, y to z, and z to -x, which begins at 10.
        ("turned", "yzx", [(0.5, 21.0), (1.0, 32.0), (-2.0, 6.0)]),
    ] {
        let (frame, axes) = read(name);
        assert_eq!((frame.order, &axes[..]), (order, &expected[..]), "{name}");
        assert!(frame.unit.is_none() && frame.axes.iter().flatten().all(|axis| axis.unit.is_empty()), "{name}");
    }
    for (name, words) in [("map_rotated", "rotates its voxels"), ("map_sheared", "shears its voxels"), ("map_frustum", "frustum")] {
        let message = refusal(name);
        assert!(message.contains(words) && message.contains("\"density\"") && message.contains("resample"), "{name}: {message}");
    }
}

/// Whatever is no density is refused with words that say what it is, and what would be right.
#[test]
fn other_grids_are_refused() {
    for (name, words) in [
        ("level_set", ["level set", "fog volume"]),
        ("vectors", ["vectors", "Tree_vec3s_5_4_3"]),
        ("points", ["points", "VDB from Particles"]),
        ("integers", ["integers", "Tree_int32_5_4_3"]),
        ("empty", ["no voxel is active", "empty"]),
        ("background", ["background is 0.125", "must be zero"]),
    ] {
        let message = refusal(name);
        assert!(words.iter().all(|words| message.contains(words)) && message.contains("cloud.vdb"), "{name}: {message}");
    }
}

/// Several grids are told apart by name, or by number where two have one; a grid that shares another's tree is placed by
/// its own transform.
#[test]
fn grids_are_chosen_by_name() {
    let several = file("several");
    let message = whole(&several, None).unwrap_err();
    assert!(message.contains("3 numeric grids (\"temperature\", \"density\", \"moved\")") && message.contains("array = "), "{message}");
    let message = whole(&several, Some("smoke")).unwrap_err();
    assert!(message.contains("no grid \"smoke\"; it has \"velocity\", \"temperature\""), "{message}");
    assert!(whole(&several, Some("velocity")).unwrap_err().contains("vectors"));
    let (layout, temperature) = whole(&several, Some("temperature")).unwrap();
    assert!(layout.shape == [4; 3] && numbers(&temperature) == [5000.0; 64]);
    let (all, step) = (ArrayHeader { shape: SHAPE, frame: None }.whole(), |layout: &ArrayHeader| {
        layout.frame.as_ref().unwrap().axes[0].as_ref().unwrap().step
    });
    for (name, expected_step) in [("density", 1.0), ("moved", 0.25)] {
        let (layout, array) = whole(&several, Some(name)).unwrap();
        assert_eq!((numbers(&array), step(&layout)), (expected(&all, 0), expected_step), "{name}");
    }
    let one_name = file("one_name");
    let message = whole(&one_name, None).unwrap_err();
    assert!(message.contains("\"density[0]\", \"density[1]\""), "{message}");
    assert_eq!(whole(&one_name, Some("density[0]")).unwrap().0.shape, SHAPE);
    assert_eq!(whole(&one_name, Some("density[1]")).unwrap().0.shape, [4; 3]);
}

/// File contents are listed without values: names, types, classes, boxes, transforms.
#[test]
fn contents_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("several.vdb");
    std::fs::write(&path, file("several")).unwrap();
    let (_, listed) = members(&path, 1 << 26).unwrap();
    let names: Vec<&str> = listed.iter().map(|member| &*member.name).collect();
    assert_eq!(names, ["velocity", "temperature", "density", "moved"]);
    let fact = |name: &str, what: &str| {
        let member = listed.iter().find(|member| member.name == name).unwrap();
        member.facts.iter().find(|(known, _)| *known == what).map_or("", |(_, fact)| fact).to_owned()
    };
    assert_eq!((&*fact("velocity", "type"), &*fact("velocity", "box")), ("Tree_vec3s_5_4_3", ""));
    assert_eq!((&*fact("density", "class"), &*fact("density", "box")), ("fog volume", "30 x 14 x 14 voxels from 2 2 2 on"));
    // Two of three voxels, and the tile.
    let places = (2..18).flat_map(|i| (2..12).flat_map(move |j| (2..12).map(move |k| i + 2 * j + 3 * k)));
    assert_eq!(fact("density", "active"), format!("{} voxels", places.filter(|sum| sum % 3 != 0).count() + 512));
    assert_eq!(fact("moved", "tree"), "that of \"density\"");
    std::fs::write(&path, file("map_frustum")).unwrap();
    let (_, frustum) = members(&path, 1 << 26).unwrap();
    assert!(frustum[0].facts.iter().any(|(what, fact)| *what == "refused" && fact.contains("frustum")), "{frustum:?}");
    assert!(fact("moved", "transform").starts_with("steps of a voxel along x: 0.25 0 0; y: 0 0.25 0"), "{}", fact("moved", "transform"));
}

/// Tiles of inner nodes and of the root, and voxels below zero, are in their places, whatever block they are part of.
#[test]
fn large_tiles_are_read() {
    let bytes = file("large");
    let (layout, array) = whole(&bytes, None).unwrap();
    // From -1, -128, -128 to 255, 0, 0.
    assert_eq!(layout.shape, [257, 129, 129]);
    let values = numbers(&array);
    let at = |[x, y, z]: [usize; 3]| values[(z * 129 + y) * 257 + x];
    assert_eq!((at([0, 127, 127]), at([1, 128, 128]), at([129, 0, 0]), at([256, 127, 127])), (0.5, 0.75, 1.5, 1.5));
    assert_eq!((at([128, 0, 0]), at([129, 128, 0]), at([0, 0, 0])), (0.0, 0.0, 0.0));
    assert_eq!(values.iter().sum::<f64>(), 1.5 * 128f64.powi(3) + 0.5 + 0.75);
    // A tile of 4096 voxels is never filled voxel by voxel.
    let (layout, coarse) = part(&file("root_tile"), None, |layout| ArrayPart { every: 1024, ..layout.whole() }).unwrap();
    assert_eq!((layout.shape, coarse.shape), ([8192, 4096, 4096], [8, 4, 4]));
    let values = numbers(&coarse);
    assert!(values.iter().enumerate().all(|(i, v)| *v
        == if i % 8 >= 4 {
            3.0
        } else if i == 0 {
            f64::from((0.75 / 1024f64.powi(3)) as f32)
        } else {
            0.0
        }));
    let message = whole(&file("root_tile"), None).unwrap_err();
    assert!(message.contains("524288 MiB") && message.contains("cloud.vdb"), "{message}");
}

/// Grids of floats are the same in all versions that are read; others are refused by number.
#[test]
fn versions_are_told_apart() {
    let bytes = file("float_zip_mask");
    let versioned = |version: u32| {
        let mut bytes = bytes.clone();
        bytes[8..12].copy_from_slice(&version.to_le_bytes());
        whole(&bytes, None).map(|(_, array)| numbers(&array))
    };
    let all = expected(&ArrayHeader { shape: SHAPE, frame: None }.whole(), 0);
    (222..=225).for_each(|version| assert_eq!(versioned(version).unwrap(), all, "{version}"));
    for version in [0, 221, 226, u32::MAX] {
        let message = versioned(version).unwrap_err();
        assert!(message.contains(&format!("version {version} ")) && message.contains("222 to 225"), "{message}");
    }
}

/// Files that end early are refused, wherever they end; those with a wrong byte give an error or numbers, and never a
/// panic.
#[test]
fn broken_files_are_refused() {
    for name in ["float_blosc_mask", "half_zip_mask", "double_inactive2", "several", "streamed"] {
        let (bytes, member) = (file(name), (name == "several").then_some("moved"));
        for end in (0..bytes.len() - 1).step_by(if cfg!(debug_assertions) { 997 } else { 97 }) {
            // What follows the tree of the grid is not looked at.
            if let Err(message) = whole(&bytes[..end], member) {
                assert!(message.contains("cloud.vdb"), "{name} {end}: {message}");
            } else {
                assert!(name == "several", "{name} {end}");
            }
        }
        let mut refused = 0;
        for place in (0..bytes.len()).step_by(31) {
            let mut bytes = bytes.clone();
            bytes[place] ^= 0x81;
            refused += usize::from(whole(&bytes, member).is_err());
        }
        assert!(refused > 20, "{name}: {refused}");
    }
}
