//! Files of every format with random damage: whatever is in them, reading gives numbers or an error in bounded time and
//! memory, and never a panic.
//!
//! Each target takes the files of its corpus in turn and damages each in a way that the number of the round alone decides,
//! so that a round can be had again. BARNARD_FUZZ_SECONDS says how long each target goes on, BARNARD_FUZZ_ROUND where it
//! begins.

mod allocated;

use std::io::{Cursor, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use allocated::most_allocated;
use barnard::blocks::{Blocking, Storage};
use barnard::data::{ArrayHeader, ArrayPart};
use barnard::properties::Choices;
use barnard_files::formats::{members, read_array, read_image};

/// One target at a time, so that what is allocated is its own.
static TURN: Mutex<()> = Mutex::new(());
/// Most bytes that an array may take, and that reading one may take in all.
const LIMIT: u64 = 1 << 20;
const MOST_BYTES: usize = 96 << 20;
/// Longest that reading one may take.
const LONGEST: Duration = Duration::from_secs(20);

/// The files of an archive that end so, those of 500 kB at most.
fn corpus(archive: &[u8], ends: &str) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(Cursor::new(archive)).unwrap();
    let names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).filter(|name| name.ends_with(ends)).collect();
    let mut read = |name: String| {
        let mut bytes = Vec::new();
        archive.by_name(&name).unwrap().read_to_end(&mut bytes).unwrap();
        (name, bytes)
    };
    names.into_iter().map(&mut read).filter(|(_, bytes)| bytes.len() < 500_000).collect()
}

/// Numbers by a seed. Source: Steele, Lea & Flood 2014, OOPSLA (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Damages some bytes: bits, numbers that are too large, pieces that are elsewhere, missing or there twice.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(6) {
        if bytes.is_empty() {
            return;
        }
        // Headers stand at the beginning, mostly.
        let end = if random.below(2) == 0 { bytes.len() } else { bytes.len().min(2048) };
        let at = random.below(end);
        match random.below(8) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff, b'9'][random.below(6)],
            2 | 3 => {
                let length = bytes.len() as u64;
                let number = [0, 1, u64::MAX, 1 << 31, 1 << 60, i64::MAX as u64, length, length - 1, at as u64][random.below(9)];
                let size = [2, 4, 8][random.below(3)];
                let number = if random.below(2) == 0 { number.to_le_bytes() } else { (number << (64 - 8 * size)).to_be_bytes() };
                for (slot, byte) in bytes[at..].iter_mut().zip(&number[..size]) {
                    *slot = *byte;
                }
            }
            4 => {
                let (from, count) = (random.below(bytes.len()), 1 + random.below(64));
                let piece: Vec<u8> = bytes[from..].iter().take(count).copied().collect();
                bytes[at..].iter_mut().zip(piece).for_each(|(slot, byte)| *slot = byte);
            }
            5 => bytes.truncate(at),
            6 => drop(bytes.drain(at..(at + 1 + random.below(64)).min(bytes.len()))),
            _ => {
                let piece: Vec<u8> = bytes[at..].iter().take(1 + random.below(64)).copied().collect();
                drop(bytes.splice(at..at, piece));
            }
        }
    }
}

/// Reads a damaged file in every way that there is.
fn read(path: &Path, bytes: &[u8], names: &[&str], random: &mut Random) {
    let parts = [None, Some(names[random.below(names.len())])];
    for name in parts {
        let (coarse, cut) = (1 + random.below(3), random.below(4));
        let storage = Storage::ROWS[random.below(3)].1;
        let turned = random.below(2) == 0;
        let blocking = Blocking {
            axes: if turned { [2, 0, 1] } else { [0, 1, 2] },
            backwards: [turned, false, turned],
            factor: 0.5,
            clip: turned,
            storage,
        };
        let blocking = Some(blocking).filter(|_| random.below(2) == 0);
        let choose = &mut |layout: &ArrayHeader| {
            let mut part = ArrayPart { every: coarse, blocking: blocking.clone(), ..layout.whole() };
            for range in &mut part.ranges {
                *range = range.end * cut / 8..range.end - range.end * cut / 16;
                range.end = range.end.max(range.start + 1);
            }
            Ok(part)
        };
        drop(read_array(Cursor::new(bytes.to_vec()), path, name, choose, LIMIT));
    }
    if random.below(8) == 0 {
        std::fs::write(path, bytes).unwrap();
        drop(members(path, LIMIT));
        drop(read_image(path, LIMIT));
    }
}

fn fuzz(target: &str, corpus: &[(String, Vec<u8>)], names: &[&str]) {
    let _turn = TURN.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    assert!(!corpus.is_empty(), "{target} has a corpus");
    let number = |name: &str, usual: f64| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual);
    let (budget, first) = (number("BARNARD_FUZZ_SECONDS", 4.0), number("BARNARD_FUZZ_ROUND", 0.0) as u64);
    let folder = tempfile::tempdir().unwrap();
    let began = Instant::now();
    let mut round = first;
    while began.elapsed().as_secs_f64() < budget {
        let (name, whole) = &corpus[round as usize % corpus.len()];
        let mut random = Random(round);
        let mut bytes = whole.clone();
        damage(&mut bytes, &mut random);
        let path = folder.path().join(name);
        let since = Instant::now();
        let (outcome, most) = most_allocated(|| catch_unwind(AssertUnwindSafe(|| read(&path, &bytes, names, &mut random))));
        let took = since.elapsed();
        assert!(outcome.is_ok(), "{target}: {name}, round {round}: it panicked");
        assert!(took < LONGEST, "{target}: {name}, round {round}: it took {took:?}");
        assert!(most < MOST_BYTES, "{target}: {name}, round {round}: it took {} MiB", most >> 20);
        round += 1;
    }
    eprintln!("{target}: {} rounds in {:.0} s", round - first, began.elapsed().as_secs_f64());
    assert!(round > first);
}

#[test]
#[ignore = "long"]
#[cfg(feature = "hdf5")]
fn hdf5() {
    let corpus: Vec<_> = corpus(include_bytes!("hdf5.zip"), "").into_iter().filter(|(name, _)| !name.ends_with(".zip")).collect();
    let names = [
        "/filters/gzip_shuffle",
        "/filters/lzf",
        "/filters/szip_nn",
        "/filters/scaleoffset_i4",
        "/filters/fletcher32_gzip_shuffle",
        "/layouts/growing",
        "/layouts/growing_twice_packed",
        "/layouts/four_axes",
        "/layouts/compact",
        "/types/big_f2",
        "/links/many/group_17/f4",
        "/gas/n_H",
        "/density",
        "/grid/density",
    ];
    fuzz("hdf5", &corpus, &names);
}

#[test]
#[ignore = "long"]
fn fits() {
    let mut files = corpus(include_bytes!("fits.zip"), ".fits");
    files.extend(corpus(include_bytes!("fits.zip"), ".fz"));
    files.extend(corpus(include_bytes!("fits.zip"), ".gz"));
    files.extend(corpus(include_bytes!("maps.zip"), ".fits"));
    fuzz("fits", &files, &["0", "1", "CUBE"]);
}

#[test]
#[ignore = "long"]
fn vdb() {
    fuzz("vdb", &corpus(include_bytes!("vdb.zip"), ".vdb"), &["density", "a"]);
}

#[test]
#[ignore = "long"]
fn npy() {
    fuzz("npy", &corpus(include_bytes!("fits.zip"), ".npy"), &["a"]);
}

#[test]
#[ignore = "long"]
fn npz() {
    use std::io::Write;
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in corpus(include_bytes!("fits.zip"), ".npy").into_iter().take(2) {
        for (method, kind) in [(zip::CompressionMethod::Stored, "stored"), (zip::CompressionMethod::Deflated, "packed")] {
            let options = zip::write::SimpleFileOptions::default().compression_method(method);
            archive.start_file(format!("{kind}_{name}"), options).unwrap();
            archive.write_all(&bytes).unwrap();
        }
    }
    let bytes = archive.finish().unwrap().into_inner();
    let listed = zip::ZipArchive::new(Cursor::new(&bytes[..])).unwrap();
    let names: Vec<String> = listed.file_names().map(|name| name.unwrap().trim_end_matches(".npy").to_owned()).collect();
    fuzz("npz", &[("arrays.npz".into(), bytes)], &names.iter().map(String::as_str).collect::<Vec<_>>());
}
