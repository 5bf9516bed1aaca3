//! The cache: what is read from it has the bits of what is computed, and nothing broken is read.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use barnard::backend::Renderer;
use barnard::backend::cpu::Cpu;
use barnard::cache::{Cache, Record};
use barnard::control::Control;
use barnard::fixtures::{MemoryCache, SMALL_GAS};
use barnard::image::Image;
use barnard::plan::{Options, Planner};
use barnard::scene::{Loader, Scene};
use barnard::sequence::FrameSettings;
use barnard::spectra::fingerprint::Fingerprint;
use barnard_files::SceneFile;
use barnard_files::cache::DiskCache;

fn record(seed: f32) -> Record {
    let array = |length: usize| (0..length).map(|i| (i as f32 * 0.37 + seed).sin()).collect::<Vec<f32>>();
    Record {
        text: "cpu".into(),
        numbers: vec![1.5, -0.0, f64::MIN_POSITIVE],
        arrays: vec![array(1000).into(), Vec::new().into(), vec![0.0; 5000].into()],
    }
}

fn key(name: &str) -> Fingerprint {
    Fingerprint::of_text(name)
}

fn only_file(folder: &std::path::Path) -> PathBuf {
    let files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

/// A record comes back with all of its bits, by its kind and inputs alone.
#[test]
fn records_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let cache = DiskCache::new(folder.path().join("new"), 1 << 30);
    assert_eq!(cache.get("gas", key("a")), None);
    cache.put("gas", key("a"), &record(0.5));
    let found = cache.get("gas", key("a")).unwrap();
    assert_eq!(found, record(0.5));
    assert!(found.numbers[1].is_sign_negative());
    assert!(cache.get("gas", key("b")).is_none() && cache.get("frames", key("a")).is_none());
    cache.put("frames", key("a"), &Record::default());
    assert_eq!(cache.get("frames", key("a")), Some(Record::default()));
    let usage = cache.usage();
    assert_eq!(usage.iter().map(|usage| (usage.kind.as_str(), usage.records)).collect::<Vec<_>>(), [("frames", 1), ("gas", 1)]);
    // Zeros take little room.
    assert!(usage[1].bytes > 4000 && usage[1].bytes < 6000, "{}", usage[1].bytes);
    fs::write(folder.path().join("new/notes.txt"), "of another program").unwrap();
    cache.clear().unwrap();
    assert!(cache.usage().is_empty() && folder.path().join("new/notes.txt").exists());
}

/// A file that is cut or changed anywhere is no record, and is removed.
#[test]
fn broken_records_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let cache = DiskCache::new(folder.path(), 1 << 30);
    cache.put("gas", key("a"), &record(0.5));
    let file = only_file(folder.path());
    let whole = fs::read(&file).unwrap();
    let mut broken: Vec<Vec<u8>> = (0..whole.len()).step_by(97).map(|length| whole[..length].to_vec()).collect();
    for position in (0..whole.len()).step_by(101) {
        let mut changed = whole.clone();
        changed[position] ^= 0x10;
        broken.push(changed);
    }
    for bytes in broken {
        fs::write(&file, bytes).unwrap();
        assert_eq!(cache.get("gas", key("a")), None);
        assert!(!file.exists());
    }
    fs::write(&file, whole).unwrap();
    assert_eq!(cache.get("gas", key("a")), Some(record(0.5)));
}

/// Beyond the limit, the records that were used least recently are removed, as are temporary files of killed processes; a record
/// larger than half of the limit is not stored.
#[test]
fn the_least_recently_used_go_first() {
    let folder = tempfile::tempdir().unwrap();
    let noisy = |seed: u32| {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from_bits(state & 0x3fff_ffff)
        };
        Record { arrays: vec![(0..25_000).map(|_| next()).collect::<Vec<f32>>().into()], ..Record::default() }
    };
    // About 100 kB each.
    let cache = DiskCache::new(folder.path(), 450_000);
    let abandoned = folder.path().join(".writing-abc");
    fs::write(&abandoned, "part").unwrap();
    let hours_ago = |hours: u64| SystemTime::now() - Duration::from_secs(3600 * hours);
    fs::File::options().append(true).open(&abandoned).unwrap().set_modified(hours_ago(2)).unwrap();
    for (i, name) in ["a", "b", "c", "d"].into_iter().enumerate() {
        cache.put("gas", key(name), &noisy(i as u32));
        let newest = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap())
            .max_by_key(|entry| entry.metadata().unwrap().modified().unwrap())
            .unwrap();
        fs::File::options().append(true).open(newest.path()).unwrap().set_modified(hours_ago(10 - i as u64)).unwrap();
    }
    assert!(!abandoned.exists());
    assert!(cache.get("gas", key("a")).is_some());
    cache.put("gas", key("e"), &noisy(9));
    let left: Vec<bool> = ["a", "b", "c", "d", "e"].iter().map(|name| cache.get("gas", key(name)).is_some()).collect();
    assert_eq!(left, [true, false, true, true, true]);
    let large = Record { arrays: vec![noisy(1).arrays[0].repeat(3).into()], ..Record::default() };
    cache.put("gas", key("large"), &large);
    assert!(cache.get("gas", key("large")).is_none() && cache.get("gas", key("e")).is_some());
}

fn parsed(text: &str, cache: Option<Arc<MemoryCache>>) -> Scene {
    let loader = Loader::default().with_cache(cache.map(|cache| cache as Arc<dyn Cache>));
    SceneFile::parse("gas.toml", "gas", text.to_owned(), loader).unwrap().scene
}

fn densities(scene: &Scene) -> Vec<(String, Vec<f32>)> {
    scene.species().iter().map(|species| (species.name.clone(), species.density.grid().unwrap().values().into_owned())).collect()
}

/// Gas and turbulence of a cache are those that are computed; a filter whose lines are known, another camera and other display find
/// all of it, another star and another filter do not. Falsified records are seen.
#[test]
fn gas_is_solved_once() {
    let cache = Arc::new(MemoryCache::default());
    let alone = parsed(SMALL_GAS, None);
    let first = parsed(SMALL_GAS, Some(cache.clone()));
    assert_eq!(cache.counts().0, 0);
    for text in [
        SMALL_GAS.to_owned(),
        SMALL_GAS.replace("0 0 8 pc", "3 1 8 pc"),
        SMALL_GAS.replace("voxels = 16\n", "voxels = 16\ndoppler_fwhm = \"10 km/s\"\n"),
    ] {
        let second = parsed(&text, Some(cache.clone()));
        let (hits, misses) = cache.counts();
        assert!(hits > 5 && misses == 0, "{hits} {misses}");
        assert_eq!(densities(&second), densities(&alone));
    }
    assert_eq!(densities(&first), densities(&alone));
    let (gas, solved) = (first.ionised().unwrap(), alone.ionised().unwrap());
    assert_eq!(
        (gas.escaped.clone(), gas.passes, gas.unsettled, &gas.by),
        (solved.escaped.clone(), solved.passes, solved.unsettled, &solved.by)
    );
    let fewer = SMALL_GAS.replace(r#""hst-wfc3-f502n", "#, "");
    assert_eq!(densities(&parsed(&fewer, Some(cache.clone()))), densities(&parsed(&fewer, None)));
    assert_eq!(cache.counts().1, 0);
    for other in
        [SMALL_GAS.replace("40000 K", "40001 K"), SMALL_GAS.replace("hst-wfc3-f502n", "johnson-U"), SMALL_GAS.replace("60 *", "61 *")]
    {
        assert_eq!(densities(&parsed(&other, Some(cache.clone()))), densities(&parsed(&other, None)));
        assert!(cache.counts().1 > 0, "{other}");
    }
    cache.falsify("gas");
    assert_ne!(densities(&parsed(SMALL_GAS, Some(cache))), densities(&alone));
}

const SCATTERING: &str = r#"bands = ["johnson-V"]
[camera]
kind = "perspective"
position = "0 0 5 pc"
field_of_view = "26 deg"
size = [12, 12]
[field.ball]
kind = "plummer"
core = "0.3 pc"
cut = "0.8 pc"
[dust]
density = "ball"
law = "ccm89"
scale = "2 /pc"
albedo = 0.8
[[star]]
kind = "blackbody"
position = "0.3 0.5 1.3 pc"
temperature = "9000 K"
luminosity = "100 Lsun"
[method]
bounces = 1000
bake = 16
"#;

fn rendered(text: &str, cache: Option<Arc<MemoryCache>>) -> Image {
    let (options, control) = (Options::default().with_cache(cache.map(|cache| cache as Arc<dyn Cache>)), Control::default());
    let plan = Planner::new(&options).plan(parsed(text, None), None, &control).unwrap();
    Renderer::new(&mut Cpu).render(&plan, &control).unwrap().0
}

/// Multiple scattering of a cache is that which is computed, seen by another camera as well; other dust is not found. Falsified
/// records are seen.
#[test]
fn multiple_scattering_is_solved_once() {
    let cache = Arc::new(MemoryCache::default());
    let alone = rendered(SCATTERING, None);
    assert_eq!(rendered(SCATTERING, Some(cache.clone())), alone);
    assert_eq!(cache.counts().0, 0);
    assert_eq!(rendered(SCATTERING, Some(cache.clone())), alone);
    let (hits, misses) = cache.counts();
    assert!(hits > 0 && misses == 0, "{hits} {misses}");
    let aside = SCATTERING.replace("0 0 5 pc", "1 0 5 pc");
    assert_eq!(rendered(&aside, Some(cache.clone())), rendered(&aside, None));
    assert_eq!(cache.counts().1, 0);
    let thicker = SCATTERING.replace("2 /pc", "2.1 /pc");
    assert_eq!(rendered(&thicker, Some(cache.clone())), rendered(&thicker, None));
    assert!(cache.counts().1 > 0);
    cache.falsify("multiple_scattering");
    assert_ne!(rendered(SCATTERING, Some(cache)).samples, alone.samples);
}

/// The settings of a film are measured once; a changed track, star or camera measures them again.
#[test]
fn settings_of_films_are_measured_once() {
    let cache = Arc::new(MemoryCache::default());
    let film = |text: &str| {
        let text = format!(
            "{text}bake = 16\n[[animation]]\nof = \"star[0].temperature\"\ntimes = [\"0 s\", \"1 s\"]\nvalues = [\"9000 K\", \"15000 K\"]\n[sequence]\nframes_per_second = 10\n"
        );
        SceneFile::parse("film.toml", "film", text, Loader::default()).unwrap().sequence().unwrap()
    };
    let text = SCATTERING.replace("bounces = 1000\nbake = 16\n", "accuracy = 0.01\n");
    let settings = |text: &str, cached: bool| {
        let (sequence, mut scenes) = (film(text), 0);
        let options = Options::default().with_cache(cached.then(|| cache.clone() as Arc<dyn Cache>));
        let scene = |time: f64| {
            scenes += 1;
            sequence.scene(time)
        };
        let settings = FrameSettings::of(&sequence, scene, &options, &Control::default()).unwrap();
        (settings, scenes)
    };
    let (alone, pilots) = settings(&text, false);
    assert!(pilots > 1);
    assert_eq!(settings(&text, true), (alone.clone(), pilots + 1));
    assert_eq!(settings(&text, true), (alone, 1));
    for other in [text.replace("9000 K", "9500 K"), text.replace("0 0 5 pc", "0 1 5 pc"), text.replace("2 /pc", "3 /pc")] {
        assert!(settings(&other, true).1 > pilots, "{other}");
    }
}
