//! FITS images in tiles and files that gzip packed, as astropy and CFITSIO wrote them (fits/write.py), against the formula
//! that filled them, or what astropy unpacks.

use std::io::{Cursor, Read};
use std::path::Path;

use barnard::data::{Array, ArrayHeader, ArrayPart};
use barnard_files::formats::{members, read_array, read_image};

fn file(name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(Cursor::new(include_bytes!("fits.zip"))).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

fn names() -> Vec<String> {
    let archive = zip::ZipArchive::new(Cursor::new(include_bytes!("fits.zip"))).unwrap();
    archive.file_names().map(|name| name.unwrap().into_owned()).collect()
}

fn part(name: &str, bytes: &[u8], asked: Option<&ArrayPart>) -> Result<Array, String> {
    let choose = &mut |layout: &ArrayHeader| Ok(asked.cloned().unwrap_or_else(|| layout.whole()));
    read_array(Cursor::new(bytes.to_vec()), Path::new(name), None, choose, 1 << 24).map_err(|e| e.to_string())
}

fn numbers(array: &Array) -> Vec<f64> {
    array.data.doubles()
}

const SHAPE: [usize; 3] = [12, 10, 14];

fn cube(value: impl Fn(f64) -> f64) -> Vec<f64> {
    let places = (0..12).flat_map(|i| (0..10).flat_map(move |j| (0..14).map(move |k| (i, j, k))));
    places.map(|(i, j, k)| value(f64::from((3 * i + 5 * j + 7 * k) % 61 + 1))).collect()
}

/// The numbers of an array of NumPy, by another reader than ours.
fn doubles(name: &str) -> Vec<f64> {
    let bytes = file(name);
    let array = npyz::NpyFile::new(&bytes[..]).unwrap();
    match array.dtype().num_bytes() {
        Some(4) => array.into_vec::<f32>().unwrap().into_iter().map(f64::from).collect(),
        _ => array.into_vec::<f64>().unwrap(),
    }
}

/// Whole numbers and others that were packed as they are: by Rice, by gzip with and without shuffling, and not at all; in
/// blocks, rows and planes; by CFITSIO's own packer.
#[test]
fn tiles_are_unpacked() {
    let mut seen = 0;
    for name in names() {
        let expected = match &name[..2] {
            "u1" | "i2" | "i4" => cube(|v| v),
            "f4" | "f8" => cube(|v| v / 8.0),
            _ if name == "fpack_i2.fits.fz" => cube(|v| 0.25 * v + 3.0),
            _ if name == "fpack_gzip.fits.fz" => cube(|v| v / 8.0),
            _ if name == "steep_rice.fits" => doubles("steep_rice.npy"),
            _ => continue,
        };
        let array = part(&name, &file(&name), None).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(array.shape, SHAPE, "{name}");
        let different = numbers(&array).iter().zip(&expected).position(|(found, expected)| found != expected);
        assert_eq!(different, None, "{name}");
        seen += 1;
    }
    assert_eq!(seen, 27);
}

/// Numbers that were made whole, with an offset for each or none, are those that astropy finds; blank ones stay blank.
#[test]
fn quantised_tiles_are_unpacked() {
    let mut seen = 0;
    for name in names().iter().filter_map(|name| name.strip_prefix("quantised_")?.strip_suffix(".fits")) {
        let file_name = format!("quantised_{name}.fits");
        let found_values = numbers(&part(&file_name, &file(&file_name), None).unwrap_or_else(|e| panic!("{name}: {e}")));
        let expected = doubles(&format!("quantised_{name}.npy"));
        assert_eq!(found_values.len(), expected.len());
        let mut blank = 0;
        for (i, (found, expected)) in found_values.iter().zip(&expected).enumerate() {
            blank += usize::from(expected.is_nan());
            let last_bit = if name.starts_with("f4") { 2e-7 } else { 1e-14 };
            let is_same = found.is_nan() && expected.is_nan() || (found - expected).abs() <= last_bit * expected.abs().max(1.0);
            assert!(is_same, "{name} {i}: {found} {expected}");
        }
        assert_eq!(blank, 1, "{name}");
        // Zeros that were kept are exact; where an offset was added for each number they are not.
        let offset = name.ends_with("_2");
        assert_eq!(found_values[..3] == [0.0; 3], !offset, "{name}: {:?}", &found_values[..3]);
        seen += 1;
    }
    assert_eq!(seen, 18);
}

/// A part across tiles is what it is of the whole, and so are means of blocks.
#[test]
fn parts_are_read() {
    for name in ["i4_rice_1.fits", "f4_gzip_2.fits", "i2_planes.fits", "plain.fits.gz"] {
        let all = cube(|v| if name.starts_with('i') { v } else { v / 8.0 });
        for ranges in [[2..9, 3..8, 4..11], [11..12, 0..1, 13..14], [0..12, 4..5, 0..14]] {
            for every in [1, 2, 5] {
                let asked = ArrayPart { ranges: ranges.clone(), every, clip: false, blocking: None };
                let array = part(name, &file(name), Some(&asked)).unwrap();
                let mut sums = vec![0.0; asked.shape().iter().product()];
                for (i, j, k) in ranges[0].clone().flat_map(|i| {
                    let ranges = ranges.clone();
                    ranges[1].clone().flat_map(move |j| ranges[2].clone().map(move |k| (i, j, k)))
                }) {
                    let [a, b, c] = [(0, i), (1, j), (2, k)].map(|(axis, at)| (at - ranges[axis].start) / every);
                    sums[(a * asked.shape()[1] + b) * asked.shape()[2] + c] += all[(i * 10 + j) * 14 + k] / every.pow(3) as f64;
                }
                for (found, expected) in numbers(&array).iter().zip(sums) {
                    assert!((found - expected).abs() <= 1e-6 * expected, "{name} {asked:?}: {found} {expected}");
                }
            }
        }
    }
}

/// A file that gzip packed is what it packed, listed too; images may be in tiles as well; what is not unpacked is named.
#[test]
fn packed_files_are_read() {
    assert_eq!(numbers(&part("a.fits.gz", &file("plain.fits.gz"), None).unwrap()), cube(|v| v / 8.0));
    let folder = tempfile::tempdir().unwrap();
    let saved = |name: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, file(name)).unwrap();
        path
    };
    let (_, listed) = members(&saved("plain.fits.gz"), 1 << 24).unwrap();
    assert!(listed[0].facts.contains(&("unit", "cm-3".into())), "{listed:?}");
    let (_, listed) = members(&saved("i4_rice_1.fits"), 1 << 24).unwrap();
    assert!(listed[1].facts.contains(&("packed", "in tiles by RICE_1".into())), "{listed:?}");
    let image = read_image(&saved("plane.fits"), 1 << 24).unwrap();
    let plane: Vec<f64> = (0..10).rev().flat_map(|j| (0..14).map(move |k| f64::from((5 * j + 7 * k) % 61 + 1))).collect();
    assert_eq!((image.width, image.height), (14, 10));
    assert!((0..10).all(|row| (0..14).all(|column| image.at(0, row, column) == plane[row * 14 + column])));
    let named = read_image(&saved("hcompress.fits"), 1 << 24).unwrap_err().to_string();
    assert!(named.contains("HCOMPRESS_1") && named.contains("funpack"), "{named}");
}

/// A tile that claims more than its numbers could take is refused before it is read, and so is a block of any length.
#[test]
fn impossible_tiles_are_refused() {
    let whole = file("i4_rice_1.fits");
    let find = |text: &[u8]| whole.windows(text.len()).position(|part_bytes| part_bytes == text).unwrap();
    // The table begins behind the header of its HDU; a descriptor is a count and a place.
    let second = find(b"XTENSION");
    let end = whole[second..].windows(80).step_by(80).position(|card| card.starts_with(b"END     ")).unwrap();
    let table = second + (80 * (end + 1)).next_multiple_of(2880);
    let mut greedy = whole.clone();
    greedy[table..table + 4].copy_from_slice(&100_000u32.to_be_bytes());
    let message = part("a.fits", &greedy, None).unwrap_err();
    assert!(message.contains("longer than its numbers") && message.contains("tile 1"), "{message}");
    let mut long = whole.clone();
    let value = find(b"ZVAL1   =") + 10;
    long[value..value + 20].copy_from_slice(format!("{:>20}", 1u64 << 62).as_bytes());
    let message = part("a.fits", &long, None).unwrap_err();
    assert!(message.contains("BLOCKSIZE"), "{message}");
}

/// Files that end too early are refused; those with flipped bits give errors or numbers, and no panic.
#[test]
fn broken_files_are_refused() {
    for name in ["i4_rice_1.fits", "quantised_f4_gzip_2_2.fits", "fpack_i2.fits.fz", "plain.fits.gz"] {
        let bytes = file(name);
        for end in (0..bytes.len()).step_by(97) {
            // What is behind the tiles pads the last block.
            let array = part(name, &bytes[..end], None);
            assert!(array.is_err() || end + 2880 > bytes.len(), "{name} cut short at {end} of {}", bytes.len());
        }
        let refused = (0..bytes.len()).step_by(7).filter(|byte| {
            let mut bytes = bytes.clone();
            bytes[*byte] ^= 1 << (byte % 8);
            part(name, &bytes, None).is_err()
        });
        assert!(refused.count() > 10, "{name}");
    }
}
