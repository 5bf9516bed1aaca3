//! The measured dust of the Galaxy, from small files that are laid out as the published ones (maps/write.py): where it is,
//! and how much.

use std::io::Read;
use std::sync::Arc;

use barnard::field::Field;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;

/// The bytes of a file of the archive.
fn file(name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(include_bytes!("maps.zip"))).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

fn density(name: &str, keys: &str) -> Result<Arc<dyn Field>, String> {
    crate::support::density(name, &file(name), keys, DEFAULT_LIMIT)
}

/// Extinction at V [mag/pc] of the cloud that each file has in one voxel, and of the dust around it.
#[test]
fn maps_are_read_where_and_as_they_are() {
    // A magnitude is 2.5 lg e of an e-folding.
    let magnitudes = 2.5 * std::f64::consts::LOG10_E;
    for (file, preset, [x, y, z], [low, high], [cloud, around]) in [
        ("mean_and_std_xyz.fits", "edenhofer24", [20.0, -10.0, 10.0], [[-25.0; 3], [25.0; 3]], [0.05 * 2.8, 0.001 * 2.8]),
        (
            "mean_std.h5",
            "leike20",
            [-360.5, -365.5, -263.5],
            [[-370.0, -370.0, -270.0], [-354.0, -362.0, -258.0]],
            [50e-3 * 1.2 * magnitudes, 1e-3 * 1.2 * magnitudes],
        ),
        ("cube_ext.fits.gz", "lallement22", [20.0, -10.0, 10.0], [[-45.0, -35.0, -25.0], [45.0, 35.0, 25.0]], [0.01, 0.0002]),
        ("cube_ext.fits.gz", "vergely22", [20.0, -10.0, 10.0], [[-45.0, -35.0, -25.0], [45.0, 35.0, 25.0]], [0.01, 0.0002]),
    ] {
        let field = density(file, &format!("preset = \"{preset}\"")).unwrap_or_else(|e| panic!("{preset}: {e}"));
        let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-6, "{preset}: {found} {expected}");
        let place = DVec3::new(x, y, z);
        close(field.at(place), cloud);
        let voxel = field.grid().unwrap().lattice().voxel_pc();
        for step in [DVec3::X, DVec3::Y, DVec3::Z] {
            close(field.at(place + step * voxel), around);
            close(field.at(place - step * voxel), around);
        }
        let bounds = field.bounds();
        let (low, high) = (DVec3::from(low), DVec3::from(high));
        assert!((bounds.low - low).abs().max_element() < 1e-9 && (bounds.high - high).abs().max_element() < 1e-9, "{preset}: {bounds:?}");
    }
    // Where nothing was measured there is nothing.
    let blank = density("mean_and_std_xyz.fits", "preset = \"edenhofer24\"").unwrap();
    assert_eq!(blank.at(DVec3::splat(-24.0)), 0.0);
}

/// A part of a map is read alone, and as coarsely as a budget of memory asks; both keep the dust that is there.
#[test]
fn maps_are_cut_and_made_coarse() {
    let map = |keys: &str| density("mean_and_std_xyz.fits", &format!("preset = \"edenhofer24\"\n{keys}"));
    let part = map("low = \"-5 -15 -5 pc\"\nhigh = \"25 15 15 pc\"").unwrap();
    assert!((part.at(DVec3::new(20.0, -10.0, 10.0)) / 0.14 - 1.0).abs() < 1e-6);
    assert_eq!(part.grid().unwrap().lattice().dims, [15, 15, 10]);
    // A part that is nearly all is a part, and no map goes elsewhere.
    let most = map("low = \"-24.9 -24.9 -24.9 pc\"\nhigh = \"24.9 24.9 24.9 pc\"").unwrap();
    assert!((most.at(DVec3::new(20.0, -10.0, 10.0)) / 0.14 - 1.0).abs() < 1e-6 && most.bounds().high.x == 25.0);
    assert!(map("low = \"0 0 0 pc\"\nhigh = \"50 50 50 pc\"").is_err());
    let sum = |field: &Arc<dyn Field>| {
        let grid = field.grid().unwrap();
        grid.values().iter().map(|v| f64::from(*v)).sum::<f64>() * grid.lattice().voxel_pc().element_product()
    };
    let whole = map("").unwrap();
    // 25 voxels an edge take 61 KiB; four become one of 8 pc, 7 an edge, 5.4 KiB with their sums.
    let coarse = map("memory = \"6 KiB\"").unwrap();
    assert_eq!(coarse.grid().unwrap().lattice().dims, [7; 3]);
    assert!((sum(&coarse) / sum(&whole) - 1.0).abs() < 1e-6, "{} {}", sum(&coarse), sum(&whole));
    assert_eq!(map("memory = \"1 GiB\"").unwrap().grid().unwrap().lattice().dims, [25; 3]);
    for (keys, word) in [
        ("memory = \"5 B\"", "no array fits"),
        ("memory = \"5\"", "has no unit"),
        ("memory = \"5 KiB\"\nevery = 2", "exclude each other"),
        ("unit = \"mag/pc\"", "unit and preset exclude each other"),
        ("preset = \"edenhofer\"", "edenhofer24"),
    ] {
        let message = if keys.starts_with("preset") { density("mean_and_std_xyz.fits", keys) } else { map(keys) };
        let message = message.map(|_| ()).unwrap_err();
        assert!(message.contains(word), "{keys}: {message}");
    }
}

/// A file that is another map, or none, is refused by its own words; one that is not there is said to be had where it is.
#[test]
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
fn other_files_are_refused() {
    let other = density("cube_ext.fits.gz", "preset = \"edenhofer24\"\narray = \"0\"").map(|_| ()).unwrap_err();
    assert!(other.contains("A0(550nm)/parsec") && other.contains("Zhang"), "{other}");
    let plain = density("mean_and_std_xyz.fits", "array = \"MEAN\"").map(|_| ()).unwrap_err();
    assert!(plain.contains("Zhang"), "{plain}");
    // Extinctions are densities that dust of 1 mag/pc takes.
    let field = density(
        "cube_ext.fits.gz",
        r#"unit = "mag/kpc"
wcs = false
low = "0 0 0 pc"
high = "9 7 5 pc""#,
    );
    assert!(field.map(|_| ()).unwrap_err().contains("correct or remove one"));
    let field = density("mean_std.h5", "array = \"mean\"\nunit = \"mag/kpc\"\nvoxel = \"1 pc\"").unwrap();
    assert!((field.at(DVec3::splat(-3.5)) / 1e-3 - 1.0).abs() < 1e-6);
}

/// The scene of the Local Bubble, on a small file of the same layout.
#[test]
fn the_local_bubble_is_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mean_and_std_xyz.fits"), file("mean_and_std_xyz.fits")).unwrap();
    let entry = barnard_files::builtin::entry("local_bubble").unwrap();
    std::fs::create_dir(folder.path().join("stars")).unwrap();
    std::fs::write(folder.path().join("stars/local_bubble.csv"), include_str!("../scenes/stars/local_bubble.csv")).unwrap();
    // The small file reaches 25 pc from the Sun.
    let text = entry.text.replace("-500 -500 -300 pc", "-20 -20 -20 pc").replace("500 500 300 pc", "20 20 20 pc");
    let scene = barnard_files::parse("bubble.toml", "local_bubble", text, &barnard_files::in_folder(folder.path(), DEFAULT_LIMIT)).unwrap();
    assert_eq!(scene.stars.len(), 30);
    assert!(scene.dust.as_ref().unwrap().density.at(DVec3::new(18.0, -10.0, 10.0)) > 0.0);
}
