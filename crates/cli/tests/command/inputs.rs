//! Arrays that are refused before they are believed.

use super::desk::{Desk, cloud, npy};

#[test]
fn bad_densities_are_counted() {
    let desk = Desk::new();
    desk.write("cloud.npy", &cloud(|i| if i % 100 == 7 { -1.0 } else { 1.0 }));
    desk.refuses_scene(&["6 negative cells of 512", "cloud"]);
    desk.write("cloud.npy", &cloud(|i| if i == 9 { f32::NAN } else { 1.0 }));
    desk.refuses_scene(&["1 cells that are NaN or infinite", "[0, 1, 1]"]);
    desk.write("cloud.npy", &cloud(|i| if i == 9 { f32::INFINITY } else { 1.0 }));
    desk.refuses_scene(&["NaN or infinite"]);
}

#[test]
fn broken_grids_are_refused_before_they_are_believed() {
    let desk = Desk::new();
    let good = cloud(|_| 1.0);
    desk.write("cloud.npy", &good[..1000]);
    desk.refuses_scene(&["truncated", "cloud.npy"]);
    desk.write("cloud.npy", b"hello");
    desk.refuses_scene(&["not an .npy array", "cloud.npy"]);
    desk.write("cloud.npy", &npy("<f4", "(8, 64)", &good[128..]));
    desk.refuses_scene(&["2 axes", "three"]);
    desk.write("cloud.npy", &npy("<f4", "(99999, 99999, 99999)", &[0; 64]));
    desk.refuses_scene(&["truncated", "999970000299999 values", "64 bytes found"]);
    desk.write("cloud.npy", &npy("<c8", "(2, 2, 2)", &[0; 64]));
    desk.refuses_scene(&["real numbers"]);
    desk.write("cloud.npy", &npy("<f4", "(0, 8, 8)", &[]));
    desk.refuses_scene(&["empty"]);
    // A header that is cut, twisted or longer than the file.
    for length in [8, 10, 20, 60] {
        desk.write("cloud.npy", &good[..length]);
        desk.refuses_scene(&["cloud.npy"]);
    }
    std::fs::remove_file(desk.path("cloud.npy")).unwrap();
    desk.refuses_scene(&["does not exist", "cloud.npy"]);
}

#[test]
fn broken_archives_and_fits_are_refused() {
    let desk = Desk::new();
    desk.with("cloud.npy", "no.npy").refuses_scene(&["no.npy", "scene.toml:", "field.cloud.file"]);
    desk.write("cloud.npz", b"PK\x03\x04 nothing");
    desk.with("cloud.npy", "cloud.npz").refuses_scene(&["cloud.npz"]);
    let mut fits = b"SIMPLE  =                    T".to_vec();
    fits.resize(2880, b' ');
    desk.write("cloud.fits", &fits);
    desk.with("cloud.npy", "cloud.fits").refuses_scene(&["cloud.fits", "END"]);
    let card = |text: &str| format!("{text:<80}");
    let header = |axes: &str| {
        let cards = [
            "SIMPLE  =                    T",
            "BITPIX  =                  -32",
            "NAXIS   =                    3",
            axes,
            "NAXIS2  =                    8",
            "NAXIS3  =                    8",
            "END",
        ];
        let mut bytes: Vec<u8> = cards.iter().flat_map(|c| card(c).into_bytes()).collect();
        bytes.resize(2880, b' ');
        bytes
    };
    desk.write("cloud.fits", &header("NAXIS1  =                    8")[..1000]);
    desk.refuses_scene(&["truncated", "cloud.fits"]);
    desk.write("cloud.fits", &header("NAXIS1  =                    8"));
    desk.refuses_scene(&["truncated", "cloud.fits"]);
    desk.write("cloud.fits", &header("NAXIS1  =  9223372036854775807"));
    desk.refuses_scene(&["cloud.fits"]);
    // And a good one renders.
    let mut good = header("NAXIS1  =                    8");
    good.extend((0..512).flat_map(|_| 0.7f32.to_be_bytes()));
    good.resize(5760, 0);
    desk.write("cloud.fits", &good);
    assert!(desk.run(&["render", "scene.toml", "-o", "fits.npy"]).status.success());
}

/// An archive whose member holds more than its header says.
#[test]
fn what_lies_behind_an_array_is_refused() {
    let desk = Desk::new();
    let mut bytes = cloud(|_| 0.5);
    bytes.extend(vec![0; 1 << 20]);
    desk.write("cloud.npy", &bytes);
    desk.refuses_scene(&["cloud.npy", "1050624 bytes after its header", "512 values"]);
}
