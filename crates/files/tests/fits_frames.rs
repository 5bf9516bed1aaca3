//! What a FITS cube says of its own values and frame is read, or said: it is never passed over.

use barnard::data::ArrayHeader;
use barnard::field::Field;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;

/// A cube of 4 × 2 × 2 elements along x, y, z, value 7, with these cards.
fn cube(cards: &[&str]) -> Vec<u8> {
    let fixed = ["SIMPLE  =                    T", "BITPIX  =                  -32", "NAXIS   =                    3"];
    let axes = ["NAXIS1  =                    4", "NAXIS2  =                    2", "NAXIS3  =                    2"];
    let mut bytes: Vec<u8> = fixed.iter().chain(&axes).chain(cards).chain(&["END"]).flat_map(|c| format!("{c:<80}").into_bytes()).collect();
    bytes.resize(bytes.len().next_multiple_of(2880), b' ');
    bytes.extend((0..16).flat_map(|_| 7f32.to_be_bytes()));
    bytes.resize(bytes.len().next_multiple_of(2880), 0);
    bytes
}

/// The density of a scene whose dust is such a cube; `keys` stand in its table.
fn density(cards: &[&str], keys: &str) -> Result<std::sync::Arc<dyn Field>, String> {
    crate::support::density("cube.fits", &cube(cards), keys, DEFAULT_LIMIT)
}

const BOX: &str = "low = \"-2 -1 -1 pc\"\nhigh = \"2 1 1 pc\"";
const FRAME: [&str; 6] = ["CDELT1  = 1.0", "CDELT2  = 1.0E-3", "CDELT3  = 2.0", "CUNIT1  = 'pc'", "CUNIT2  = 'kpc'", "CUNIT3  = 'pc'"];

#[test]
fn units_are_read() {
    let at = |cards: &[&str], keys: &str| density(cards, &format!("{BOX}\n{keys}")).map(|field| field.at(DVec3::ZERO));
    let close = |value: Result<f64, String>, expected: f64| assert!((value.clone().unwrap() / expected - 1.0).abs() < 1e-6, "{value:?}");
    close(at(&[], ""), 7.0);
    for unit in ["cm-3", "cm^-3", "cm**-3", "1/cm3", "cm^(-3)", "cm^{-3}"] {
        close(at(&[&format!("BUNIT   = '{unit}'")], ""), 7.0);
    }
    close(at(&["BUNIT   = 'm-3'"], ""), 7e-6);
    for unit in ["m-3", "m⁻³", "m^(-3)"] {
        close(at(&[], &format!("unit = \"{unit}\"")), 7e-6);
    }
    // Values are scaled before they are rounded: 7 pc-3 is too little for single precision, 7e57 pc-3 is not too much.
    close(at(&[], "unit = \"pc-3\"\nfactor = 1e57"), 7e57 * 3.085_677_581_491_367e18_f64.powi(-3));
    let little = at(&[], "unit = \"pc-3\"").unwrap_err();
    assert!(little.contains("single precision"), "{little}");
    let much = at(&[], "factor = 1e40\nclip = true").unwrap_err();
    assert!(much.contains("inf"), "{much}");
    for unknown in ["1e6 m-3", "kpc-3", "K"] {
        let message = at(&[], &format!("unit = \"{unknown}\"")).unwrap_err();
        assert!(message.contains("remove `unit`"), "{message}");
    }
    close(at(&["BUNIT   = 'm-3'"], "unit = \"/m3\""), 7e-6);
    // What is no number density is taken as it is, once somebody says so.
    let temperature = at(&["BUNIT   = 'K'"], "").unwrap_err();
    assert!(temperature.contains("unit is \"K\"") && temperature.contains("unit = \"K\""), "{temperature}");
    close(at(&["BUNIT   = 'K'"], "unit = \"K\""), 7.0);
    let wrong = at(&["BUNIT   = 'm-3'"], "unit = \"cm-3\"").unwrap_err();
    assert!(wrong.contains("m-3") && wrong.contains("correct or remove one"), "{wrong}");
}

#[test]
fn frames_are_read() {
    let box_of = |cards: &[&str], keys: &str| density(cards, keys).map(|field| field.bounds());
    // CRPIX is 0 where it is not said (FITS standard 4.0, table 22): the first element lies one step beyond CRVAL.
    let bounds = box_of(&FRAME, "").unwrap();
    assert!(
        (bounds.low - DVec3::new(0.5, 0.5, 1.0)).length() < 1e-12 && (bounds.high - DVec3::new(4.5, 2.5, 5.0)).length() < 1e-12,
        "{bounds:?}"
    );
    let placed: Vec<&str> = FRAME.into_iter().chain(["CRPIX1  = 2.5", "CRVAL1  = 10.0"]).collect();
    let moved = box_of(&placed, "").unwrap();
    assert!((moved.low.x - 8.0).abs() < 1e-12 && (moved.high.x - 12.0).abs() < 1e-12, "{moved:?}");
    // The scene may place the same box elsewhere, but not make it another size without a word.
    let same = box_of(&FRAME, "low = \"-2 -1 -2 pc\"\nhigh = \"2 1 2 pc\"").unwrap();
    assert_eq!(same.low, DVec3::new(-2.0, -1.0, -2.0));
    let other = box_of(&FRAME, BOX).unwrap_err();
    assert!(
        other.contains("4.0000 x 2.0000 x 2.0000 pc") && other.contains("4.0000 x 2.0000 x 4.0000 pc") && other.contains("wcs = false"),
        "{other}"
    );
    assert_eq!(box_of(&FRAME, &format!("{BOX}\nwcs = false")).unwrap().low, DVec3::new(-2.0, -1.0, -1.0));
    let backwards: Vec<&str> = FRAME.into_iter().map(|c| if c.starts_with("CDELT1") { "CDELT1  = -1.0" } else { c }).collect();
    let no_flag = box_of(&FRAME, "wcs = \"no\"").unwrap_err();
    assert!(no_flag.contains("wcs") && no_flag.contains("true"), "{no_flag}");
    let turned_round = box_of(&backwards, "").unwrap();
    assert!((turned_round.low.x + 4.5).abs() < 1e-12 && (turned_round.high.x + 0.5).abs() < 1e-12, "{turned_round:?}");
    // A frame on the sky is no box: the scene must say one.
    let sky = ["CDELT1  = 0.1", "CDELT2  = 0.1", "CDELT3  = 0.1", "CUNIT1  = 'deg'", "CUNIT2  = 'deg'"];
    let none = box_of(&sky, "").unwrap_err();
    assert!(none.contains("axis x has the unknown length unit \"deg\"") && box_of(&sky, BOX).is_ok(), "{none}");
    // An axis of velocities is none of a volume, whatever box the scene states.
    let velocities: Vec<&str> = sky.into_iter().chain(["CUNIT3  = 'm/s'"]).collect();
    for keys in ["", BOX] {
        let message = box_of(&velocities, keys).unwrap_err();
        assert!(message.contains("velocity (CUNIT3 m/s)") && message.contains("wcs = false"), "{message}");
    }
    assert!(box_of(&velocities, &format!("{BOX}\nwcs = false")).is_ok());
    // What the file itself says to be no length is no side of a box, unless somebody says so.
    for (card, what) in [
        ("CTYPE3  = 'VRAD    '", "velocity (CTYPE3 VRAD)"),
        ("CTYPE1  = 'RA---TAN'", "sky (CTYPE1 RA---TAN)"),
        ("CTYPE3  = 'FREQ'", "frequency"),
    ] {
        let cards: Vec<&str> = FRAME.into_iter().chain([card]).collect();
        for keys in ["", BOX] {
            let message = box_of(&cards, keys).unwrap_err();
            assert!(message.contains(what) && message.contains("wcs = false"), "{message}");
        }
        assert!(box_of(&cards, &format!("{BOX}\nwcs = false")).is_ok());
    }
    let named: Vec<&str> = FRAME.into_iter().chain(["CTYPE1  = 'X'", "CTYPE2  = 'RADIUS'"]).collect();
    assert!(box_of(&named, "").is_ok());
    // Turned axes are none of the box's.
    let turned: Vec<&str> = FRAME.into_iter().chain(["CROTA2  = 30.0"]).collect();
    assert!(box_of(&turned, "").is_err() && box_of(&turned, BOX).is_err() && box_of(&turned, &format!("{BOX}\nwcs = false")).is_ok());
}

/// Frames that no number can be reckoned with are refused by name, also where the scene itself says them.
#[test]
fn impossible_frames_are_refused() {
    let spectral = |step: &str, unit: &str, first: &str| {
        let cards: Vec<String> = (1..=3)
            .flat_map(|i| [format!("CDELT{i}  = {step}"), format!("CUNIT{i}  = '{unit}'"), format!("CRVAL{i}  = {first}")])
            .collect();
        density(&cards.iter().map(String::as_str).collect::<Vec<_>>(), "").map(|field| field.bounds())
    };
    for (step, unit, first) in [("1E308", "Mpc", "0.0"), ("1E-310", "cm", "0.0"), ("1.0", "pc", "1E20"), ("1E-15", "pc", "1.0")] {
        let message = spectral(step, unit, first).unwrap_err();
        assert!(message.contains("out of range"), "{step} {unit} {first}: {message}");
    }
    let refused = density(&[], "low = \"0 0 0 pc\"\nhigh = \"1e-320 1e-320 1e-320 pc\"").map(|_| ()).unwrap_err();
    assert!(refused.contains("out of range"), "{refused}");
    assert!(spectral("1.0", "lyr", "5.0").is_ok() && spectral("1E-3", "au", "0.0").is_ok());
}

#[test]
fn tables_are_named() {
    let table = |cards: &[&str]| {
        let head: Vec<u8> = ["SIMPLE  =                    T", "BITPIX  =                    8", "NAXIS   =                    0", "END"]
            .iter()
            .flat_map(|c| format!("{c:<80}").into_bytes())
            .collect();
        let fixed = [
            "XTENSION= 'BINTABLE'",
            "BITPIX  =                    8",
            "NAXIS   =                    2",
            "NAXIS1  =                    8",
            "NAXIS2  =                    1",
        ];
        let header_bytes: Vec<u8> = fixed.iter().chain(cards).chain(&["END"]).flat_map(|c| format!("{c:<80}").into_bytes()).collect();
        let padded = |mut bytes: Vec<u8>| {
            bytes.resize(bytes.len().next_multiple_of(2880), b' ');
            bytes
        };
        let bytes = [padded(head), padded(header_bytes), padded(vec![0; 8])].concat();
        let (path, whole) = (std::path::Path::new("map.fits"), &mut |layout: &ArrayHeader| Ok(layout.whole()));
        barnard_files::formats::read_array(std::io::Cursor::new(bytes.to_vec()), path, None, whole, 1 << 30).unwrap_err().to_string()
    };
    assert!(table(&["PIXTYPE = 'HEALPIX '", "NSIDE   =                  256"]).contains("HEALPix map of the sky (NSIDE 256)"));
    assert!(table(&["EXTNAME = 'STARS'"]).contains("HDU \"STARS\" is a table"));
}
