//! Files of plates.

use barnard::fixtures::small_cloud;
use barnard::plates::Reach;
use barnard::{Control, Options, Plates};
use barnard_files::plates::{load, save};

const GAS: &str = r#"
[[emission]]
density = "cloud^2"
kind = "lines"
scale = "1e-25 W/m3/sr"
lines = [{ wavelength = "500.7 nm", strength = 1 }]
[method]
bake = 16
"#;

fn plates() -> Plates {
    let scene =
        barnard_files::parse("test.toml", "test", small_cloud(&[("[16, 12]", "[11, 7]")]) + GAS, &barnard_files::in_folder(".", 1 << 30))
            .unwrap();
    Plates::new(&scene, Reach::default(), None, &Options::default(), &Control::default()).unwrap()
}

/// What is read is what was written, bit by bit.
#[test]
fn plates_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.plates");
    let plates = plates();
    assert_eq!(plates.record().plates.len(), 2);
    save(&path, &plates).unwrap();
    assert!(load(&path, 1 << 30).unwrap().record() == plates.record());
    let error = load(&path, 64).unwrap_err().to_string();
    assert!(error.contains("MiB"), "{error}");
}

/// A file that is damaged anywhere is refused, or has what it had; no byte makes it panic or be taken for other plates.
#[test]
fn damaged_plates_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.plates");
    let plates = plates();
    save(&path, &plates).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut refused = 0;
    for step in 0..400 {
        let place = step * whole.len() / 400;
        let mut damaged = whole.clone();
        damaged[place] ^= 0x21;
        std::fs::write(&path, &damaged).unwrap();
        match load(&path, 1 << 30) {
            Ok(read) => assert!(read.record() == plates.record(), "{place}"),
            Err(_) => refused += 1,
        }
        std::fs::write(&path, &whole[..place]).unwrap();
        assert!(load(&path, 1 << 30).is_err(), "{place}");
    }
    assert!(refused > 200, "{refused}");
}
