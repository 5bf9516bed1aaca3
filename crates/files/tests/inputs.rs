//! The policy of every reader (docs/data.md): what is stated is understood or refused, what is missing is unambiguous or
//! refused, what was inferred is noted. Expected values are those of the shapes that the files are made of.

use std::path::Path;
use std::sync::Arc;

use barnard::data::{Choose, DataSource, Inputs, Layout};
use barnard::scene::Scene;
use barnard_files::formats::{members, read_file, read_picture};
use barnard_files::{SceneFiles, in_folder, parse};

const CAMERA: &str = "[camera]\nkind = \"perspective\"\nposition = \"0 0 6 pc\"\nfield_of_view = \"25 deg\"\nsize = [8, 8]\n";

fn scene(folder: &Path, text: &str) -> barnard::Result<Scene> {
    parse("scene.toml", "scene", format!("{CAMERA}{text}"), &in_folder(folder, 1 << 28))
}

/// A file and keys, and what must come of them: a value, or words of an error.
type Case<'a> = (&'a str, &'a str, Result<f64, &'a str>);

/// Checks each case: `value` gives what a scene came to.
fn hold(cases: &[Case], scene_of: impl Fn(&str) -> String, value: impl Fn(&Scene) -> f64) {
    for (content, keys, expected) in cases {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("in.csv"), content).unwrap();
        let shown = &content[..content.len().min(60)];
        match (scene(folder.path(), &scene_of(keys)), expected) {
            (Ok(scene), Ok(expected)) => {
                let found = value(&scene);
                assert!((found / expected - 1.0).abs() < 1e-6, "{shown:?} {keys}: {found} is not {expected}");
            }
            (Err(error), Err(words)) => {
                let message = error.to_string();
                assert!(message.contains(words) && message.contains("in.csv"), "{shown:?} {keys}: {message}");
            }
            (Ok(scene), Err(words)) => panic!("{shown:?} {keys}: {} instead of \"{words}\"", value(&scene)),
            (Err(error), Ok(_)) => panic!("{shown:?} {keys}: {error}"),
        }
    }
}

/// Triangle of height 0.8 from 500 to 600 nm: ∫ T dλ = 0.04 µm.
#[test]
fn filters_are_understood_or_refused() {
    let nm = "500,0\n550,0.8\n600,0\n";
    let angstrom = "5000,0\n5500,0.8\n6000,0\n";
    let with = |head: &str, rows: &str| format!("{head}\n{rows}");
    let texts: Vec<(String, &str, Result<f64, &str>)> = vec![
        (nm.into(), "", Ok(0.04)),
        (angstrom.into(), "", Err("unit = \"angstrom\"")),
        (angstrom.into(), "unit = \"Angstrom\"", Ok(0.04)),
        (with("wavelength_nm,t", nm), "unit = \"um\"", Err("states nm")),
        (with("lambda(A),t", angstrom), "", Ok(0.04)),
        (with("wave_ang,t", angstrom), "", Ok(0.04)),
        (with("Angstroem,t", angstrom), "", Ok(0.04)),
        (with("wave(1e-10 m),t", angstrom), "", Ok(0.04)),
        (with("wavelength [furlong],t", nm), "", Err("furlong")),
        (with("# taken at 3 um, by candle light", nm), "", Err("line 1 mentions um")),
        (with("# taken at night", nm), "", Ok(0.04)),
        (format!("\u{feff}{nm}"), "", Ok(0.04)),
        (format!("\u{feff}# note\nwavelength_nm,t\n{nm}"), "", Ok(0.04)),
        (nm.replace(',', ";"), "", Ok(0.04)),
        (nm.replace(',', "\t"), "", Ok(0.04)),
        (nm.replace(',', "  "), "", Ok(0.04)),
        ("# Wellenlaenge [nm];T\n500;0,0\n550;0,8\n600;0,0\n".into(), "", Ok(0.04)),
        ("# Wellenlaenge [nm]\tT\n500\t0,0\n550\t0,8\n600\t0,0\n".into(), "", Ok(0.04)),
        ("500,0,0\n550,0,8\n600,0,0\n".into(), "", Err("3 numbers")),
        ("nm,t\n500,0,0\n550,0,8\n600,0,0\n".into(), "", Err("line 1 does not have 3 names")),
        ("1.500;0,0\n1.550;0,8\n".into(), "", Err("line 1")),
        (nm.replace('\n', "\r\n"), "", Ok(0.04)),
        (nm.replace('\n', "\r"), "", Ok(0.04)),
        ("600,0\n550,0.8\n500,0\n".into(), "", Ok(0.04)),
        ("500,0\n600,0.8\n550,0\n".into(), "", Err("line 3 is out of order")),
        ("500,0\n550,0.8\n550,0\n".into(), "", Err("line 3 repeats")),
        ("nm,T [%]\n500,0\n550,80\n600,0\n".into(), "", Ok(0.04)),
        ("500,0\n550,80\n600,0\n".into(), "", Err("percent")),
        ("nm,T [Jy]\n500,0\n550,0.8\n600,0\n".into(), "", Err("Jy")),
        ("wavenumber [cm-1],T\n16666.6666666667,0\n18181.8181818182,0.8\n20000,0\n".into(), "", Ok(0.04)),
        ("frequency,T\n500,0\n550,0.8\n600,0\n".into(), "", Err("without its unit")),
        ("nm,id,throughput\n500,1,0\n550,2,0.8\n600,3,0\n".into(), "", Ok(0.04)),
        ("nm,a,b\n500,1,0\n550,2,0.8\n600,3,0\n".into(), "", Err("column = ")),
        ("nm,a,b\n500,1,0\n550,1,0.8\n600,1,0\n".into(), "column = \"b\"", Ok(0.04)),
        ("5.0D+02 0.0D0\n5.5D+02 8.0D-1\n6.0D+02 0.0D0\n".into(), "", Ok(0.04)),
        ("500,0\n550,nan\n600,0\n".into(), "", Err("line 2")),
        ("# %ECSV 1.0\n# ---\n# datatype:\n# - {name: w, unit: Angstrom, datatype: float64}\n# - {name: t, datatype: float64}\nw t\n5000 0\n5500 0.8\n6000 0\n".into(), "", Ok(0.04)),
        ("<?xml version=\"1.0\"?><VOTABLE><RESOURCE><TABLE><FIELD name=\"Wavelength\" unit=\"AA\" datatype=\"double\"/><FIELD name=\"Transmission\" datatype=\"double\"/><DATA><TABLEDATA><TR><TD>5000</TD><TD>0</TD></TR><TR><TD>5500</TD><TD>0.8</TD></TR><TR><TD>6000</TD><TD>0</TD></TR></TABLEDATA></DATA></TABLE></RESOURCE></VOTABLE>".into(), "", Ok(0.04)),
        ("".into(), "", Err("no rows")),
    ];
    assert!(texts.len() >= 30);
    let cases: Vec<Case> = texts.iter().map(|(text, keys, expected)| (text.as_str(), *keys, *expected)).collect();
    let area = |scene: &Scene| scene.bands[0].integrate(|_| 1.0);
    hold(&cases, |keys| format!("[[band]]\nname = \"b\"\nkind = \"file\"\nfile = \"in.csv\"\n{keys}\n"), area);
}

/// What is inferred is noted, what is stated is not.
#[test]
fn inferences_are_noted() {
    for (content, is_inferred) in [("500,0\n550,0.8\n600,0\n", true), ("nm,t\n500,0\n550,0.8\n600,0\n", false)] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("in.csv"), content).unwrap();
        let scene = scene(folder.path(), "[[band]]\nname = \"b\"\nkind = \"file\"\nfile = \"in.csv\"\n").unwrap();
        let [note] = &scene.inputs[..] else { panic!("{:?}", scene.inputs) };
        assert_eq!((note.is_inferred, note.text.contains("500.00 to 600.00 nm")), (is_inferred, true), "{}", note.text);
    }
}

/// The albedo at 500 nm, 0.7, through every reader of curves.
#[test]
fn albedos_are_understood_or_refused() {
    let dust =
        "[field.d]\nkind = \"sphere\"\nradius = \"1 pc\"\n[dust]\ndensity = \"d\"\nscale = \"1 /pc\"\nlaw = \"inverse_wavelength\"\n";
    let cases: Vec<Case> = vec![
        ("# Wellenlaenge [nm];Albedo\n400;0,6\n600;0,8\n", "", Ok(0.7)),
        ("# Wellenlaenge [nm]\tAlbedo\n400\t0,6\n600\t0,8\n", "", Ok(0.7)),
        ("wavelength_um,albedo\n0.4,0.6\n0.6,0.8\n", "", Ok(0.7)),
        ("wavelength_nm,omega\n400,0.6\n600,0.8\n", "", Ok(0.7)),
        ("nm,albedo [%]\n400,60\n600,80\n", "", Ok(0.7)),
        ("400,60\n600,80\n", "", Err("0 to 1")),
        ("4000,0.6\n6000,0.8\n", "", Err("angstrom or nm")),
        ("4000,0.6\n6000,0.8\n", ", unit = \"AA\"", Ok(0.7)),
    ];
    let of = |keys: &str| format!("{dust}albedo = {{ kind = \"file\", file = \"in.csv\"{keys} }}\n");
    hold(&cases, of, |scene| {
        let dust = scene.dust.as_ref().unwrap();
        dust.albedo.at(0.5)
    });
}

/// p at cos θ = 0 of (1 + cos θ)/4π, 1/4π, from cosines and from angles.
#[test]
fn phase_tables_are_understood_or_refused() {
    let dust = "[field.d]\nkind = \"sphere\"\nradius = \"1 pc\"\n[dust]\ndensity = \"d\"\nscale = \"1 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.5\n";
    let quarter = 0.25 / std::f64::consts::PI;
    let cases: Vec<Case> = vec![
        ("-1,0\n0,1\n1,2\n", "", Ok(quarter)),
        ("cos_theta,p\n-1,0\n0,1\n1,2\n", "", Ok(quarter)),
        ("1;2,0\n0;1,0\n-1;0,0\n", "", Ok(quarter)),
        ("theta [deg],p\n0,2\n90,1\n180,0\n", "", Ok(quarter)),
        ("theta_rad,p\n0,2\n1.570796326794897,1\n3.141592653589793,0\n", "", Ok(quarter)),
        ("# wavelength_um: 0.44, 0.55\n-1,0,0\n0,1,1\n1,2,2\n", "", Ok(quarter)),
        ("# wavelength_nm: 440, 550\n-1,0,0\n0,1,1\n1,2,2\n", "", Ok(quarter)),
        ("# wavelength_um: 0.44, x\n-1,0,0\n0,1,1\n1,2,2\n", "", Err("line 1")),
        ("# wavelength_furlong: 1, 2\n-1,0,0\n0,1,1\n1,2,2\n", "", Err("line 1")),
        ("angle,p\n0,2\n90,1\n180,0\n", "", Err("without its unit")),
        ("0,2\n90,1\n180,0\n", "", Err("cos theta")),
    ];
    let of = |keys: &str| format!("{dust}phase = {{ kind = \"tabulated\", file = \"in.csv\"{keys} }}\n");
    hold(&cases, of, |scene| scene.dust.as_ref().unwrap().phase.at(0.0, 0.55));
}

/// The catalogue's star at right ascension 83.82°, declination −5.39°: x of its direction is cos b cos l.
#[test]
fn catalogues_are_understood_or_refused() {
    let [l, b] = [83.82f64, -5.39f64].map(f64::to_radians);
    let x = b.cos() * l.cos();
    let hyg = "id,hip,hd,hr,gl,bf,proper,ra,dec,dist,pmra,pmdec,rv,mag,absmag,spect,ci\n0,,,,,,Sol,0,0,0,0,0,0,-26.7,4.85,G2V,0.656\n1,1,,,,,A,5.588,-5.39,100,0,0,0,5,0,B5V,0.1\n";
    let cases: Vec<Case> = vec![
        ("ra,dec,johnson-V\n83.82,-5.39,5\n", "", Ok(x)),
        ("RA [deg],Dec [deg],Vmag\n83.82,-5.39,5\n", "", Ok(x)),
        ("ra_deg,dec_deg,Vmag\n83.82,-5.39,5\n", "", Ok(x)),
        ("RA [h],dec,johnson-V\n5.588,-5.39,5\n", "", Ok(x)),
        ("ra (hours),dec (deg),johnson-V\n5.588,-5.39,5\n", "", Ok(x)),
        ("RA [hourangle],dec,johnson-V\n5.588,-5.39,5\n", "", Ok(x)),
        ("ra_hours,dec,johnson-V\n5.588,-5.39,5\n", "", Ok(x)),
        ("ra [rad],dec [rad],johnson-V\n1.462934978997,-0.0940732466801,5\n", "", Ok(x)),
        ("ra,dec,johnson-V\n05:35:16.8,-05:23:24,5\n", "", Ok(x)),
        ("RAJ2000;DEJ2000;Vmag\n\"h:m:s\";\"d:m:s\";mag\n05 35 16.8;-05 23 24;5\n", "", Ok(x)),
        (hyg, "", Ok(x)),
        ("ra [furlong],dec,johnson-V\n83.82,-5.39,5\n", "", Err("furlong")),
        ("ra,dec,johnson-V\n5.588,-5.39,5\n", "", Err("ra [h]")),
        ("ra [deg],dec,johnson-V\n5.588,-5.39,5\n", "", Ok(b.cos() * 5.588f64.to_radians().cos())),
        ("ra,dec,johnson-V [Jy]\n83.82,-5.39,5\n", "", Err("magnitudes")),
        ("ra,dec,johnson-V,teff [furlong]\n83.82,-5.39,5,9\n", "", Err("furlong")),
        ("ra,dec,johnson-V,teff [kK]\n83.82,-5.39,5,9\n", "", Ok(x)),
        ("\u{feff}ra,dec,johnson-V\n83.82,-5.39,5\n", "", Ok(x)),
        ("ra;dec;johnson-V\n83,82;-5,39;5\n", "", Err("in.csv:2")),
        ("ra,dec,johnson-V\n83.82,-95.39,5\n", "", Err("in.csv:2")),
    ];
    let of = |keys: &str| format!("[background.catalogue]\nfile = \"in.csv\"\naxes = \"icrs\"\n{keys}");
    hold(&cases, of, |scene| {
        let stars = &scene.background.catalogue.as_ref().unwrap().catalogue.stars;
        assert_eq!(stars.len(), 1);
        stars[0].direction.x
    });
}

/// The colour index of HYG gives B − V: 0.1 mag.
#[test]
fn hyg_has_colours() {
    let folder = tempfile::tempdir().unwrap();
    let rows = "id,hip,proper,ra,dec,dist,mag,absmag,ci\n1,1,A,5.588,-5.39,100,5,0,0.1\n";
    std::fs::write(folder.path().join("in.csv"), rows).unwrap();
    let scene = scene(folder.path(), "[background.catalogue]\nfile = \"in.csv\"\naxes = \"icrs\"\n").unwrap();
    let catalogue = &scene.background.catalogue.as_ref().unwrap().catalogue;
    let flux = |name: &str| {
        let band = spectra::passband::Passband::named(name).unwrap();
        let zero = spectra::sed::zero_point(&band, spectra::sed::MagnitudeSystem::Vega).unwrap();
        let of = |(class, gain): &(usize, f64)| gain * band.integrate(|l| catalogue.classes[*class].spectrum.continuum(l));
        -2.5 * (catalogue.stars[0].shares.iter().map(of).sum::<f64>() / zero).log10()
    };
    assert!((flux("johnson-V") - 5.0).abs() < 1e-9 && (flux("johnson-B") - 5.1).abs() < 1e-9);
    assert!(scene.inputs.iter().any(|note| note.text.contains("HYG") && note.is_inferred));
}

/// A FITS header of these cards, padded, before data.
fn fits(cards: &[&str], data: &[u8]) -> Vec<u8> {
    let padded = |bytes: &mut Vec<u8>, fill: u8| bytes.resize(bytes.len().next_multiple_of(2880), fill);
    let mut file: Vec<u8> = cards.iter().chain(&["END"]).flat_map(|card| format!("{card:<80}").into_bytes()).collect();
    padded(&mut file, b' ');
    file.extend_from_slice(data);
    padded(&mut file, 0);
    file
}

/// A cube of singles, 2 × 3 × 4 along its pixel axes, value 1 at its first pixel.
fn cube(more: &[&str]) -> Vec<u8> {
    let mut cards = vec!["SIMPLE  =                    T", "BITPIX  =                  -32", "NAXIS   =                    3"];
    cards.extend(["NAXIS1  =                    2", "NAXIS2  =                    3", "NAXIS3  =                    4"]);
    cards.extend_from_slice(more);
    let mut values = [0f32; 24];
    values[0] = 1.0;
    fits(&cards, &values.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<u8>>())
}

const PLAIN: [&str; 9] = [
    "CRPIX1  =                  1.0",
    "CRVAL1  =                  0.0",
    "CDELT1  =                  1.0",
    "CRPIX2  =                  1.0",
    "CDELT2  =                  1.0",
    "CUNIT2  = 'pc      '",
    "CRPIX3  =                  1.0",
    "CDELT3  =                  1.0",
    "CUNIT3  = 'pc      '",
];

/// What the field of a cube with these cards is at a place [pc], or the error.
fn cube_at(more: &[&str], place: [f64; 3]) -> Result<f64, String> {
    let folder = tempfile::tempdir().unwrap();
    let cards: Vec<&str> = PLAIN.iter().chain(&["CUNIT1  = 'pc      '"]).chain(more).copied().collect();
    let cards: Vec<&str> = cards.iter().filter(|card| !more.iter().any(|own| own[..8] == card[..8] && own != *card)).copied().collect();
    std::fs::write(folder.path().join("in.fits"), cube(&cards)).unwrap();
    let text = "[field.d]\nkind = \"grid\"\nfile = \"in.fits\"\n[dust]\ndensity = \"d\"\nscale = \"1 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.5\n";
    let scene = scene(folder.path(), text).map_err(|e| e.to_string())?;
    Ok(scene.dust.unwrap().density.at(barnard::glam::DVec3::from(place)))
}

/// Cards that are no numbers are refused, matrices that swap or turn axes by right angles followed, others refused by
/// name. The pixel (1, 1, 1) of value one lies at the origin.
#[test]
fn fits_frames_are_understood_or_refused() {
    let at_origin = |more: &[&str]| cube_at(more, [0.0; 3]);
    let cases: Vec<(Vec<&str>, Result<f64, &str>)> = vec![
        (vec![], Ok(1.0)),
        (vec!["CRPIX1  =                 1.0,"], Err("CRPIX1 = 1.0, is not a number")),
        (vec!["CDELT2  =             1,000000"], Err("CDELT2")),
        (vec!["CRVAL3  = 'zero    '"], Err("CRVAL3")),
        (vec!["CRPIX1  =                 1.D0"], Ok(1.0)),
        (vec!["PC1_2   =             1.22E-16"], Ok(1.0)),
        (vec!["PC1_2   =                  0.5"], Err("rotated or sheared")),
        (vec!["PC001002=                  0.5"], Err("rotated or sheared")),
        (vec!["CROTA2  =                 30.0"], Err("rotated or sheared")),
        (vec!["CROTA3  =                 30.0"], Err("CROTA3")),
        (vec!["CROTA2  =                180.0"], Ok(1.0)),
        (vec!["CTYPE3  = 'VELOCITY'", "CUNIT3  = 'm/s     '"], Err("velocity")),
        (vec!["CTYPE3  = 'LAMBDA  '", "CUNIT3  = 'um      '"], Err("wavelength")),
        (vec!["CTYPE3  = 'ENERGY  '", "CUNIT3  = 'keV     '"], Err("photon energy")),
        (vec!["CTYPE3  = 'TIME    '", "CUNIT3  = 's       '"], Err("time")),
        (vec!["CTYPE3  = '        '", "CUNIT3  = 'Angstrom'"], Err("wavelength")),
        (vec!["CTYPE3  = 'STOKES  '"], Err("polarisation")),
    ];
    for (more, expected) in cases {
        match (at_origin(&more), expected) {
            (Ok(found), Ok(expected)) => assert!((found - expected).abs() < 1e-6, "{more:?}: {found}"),
            (Err(error), Err(words)) => assert!(error.contains(words) && error.contains("in.fits"), "{more:?}: {error}"),
            (found, expected) => panic!("{more:?}: {found:?} instead of {expected:?}"),
        }
    }
    // x along the second pixel axis and y along the first: the array's neighbour along its second axis is at x = 1.
    let swapped = [
        "PC1_1   =                  0.0",
        "PC1_2   =                  1.0",
        "PC2_1   =                  1.0",
        "PC2_2   =                  0.0",
    ];
    assert!((cube_at(&swapped, [0.0; 3]).unwrap() - 1.0).abs() < 1e-6);
    let folder = tempfile::tempdir().unwrap();
    let cards: Vec<&str> = PLAIN.iter().chain(&["CUNIT1  = 'pc      '"]).chain(&swapped).copied().collect();
    std::fs::write(folder.path().join("in.fits"), cube(&cards)).unwrap();
    let mut order = "";
    read_file(
        &folder.path().join("in.fits"),
        None,
        &mut |layout: &Layout| {
            order = layout.frame.as_ref().unwrap().order;
            Ok(layout.whole())
        },
        1 << 20,
    )
    .unwrap();
    assert_eq!(order, "zxy");
}

/// Unsigned 64-bit integers keep all of their digits: values 5, 15, 25, ...
#[test]
fn unsigned_integers_keep_their_digits() {
    let folder = tempfile::tempdir().unwrap();
    let cards = [
        "SIMPLE  =                    T",
        "BITPIX  =                   64",
        "NAXIS   =                    3",
        "NAXIS1  =                    2",
        "NAXIS2  =                    3",
        "NAXIS3  =                    4",
        "BZERO   =  9223372036854775808",
    ];
    let data: Vec<u8> = (0..24u64).flat_map(|i| ((10 * i + 5) ^ (1 << 63)).to_be_bytes()).collect();
    let path = folder.path().join("u64.fits");
    std::fs::write(&path, fits(&cards, &data)).unwrap();
    let array = read_file(&path, None, &mut |layout: &Layout| Ok(layout.whole()), 1 << 20).unwrap();
    assert_eq!(array.data.doubles(), (0..24).map(|i| f64::from(10 * i + 5)).collect::<Vec<f64>>());
}

/// The first image of a file of several, as WebbPSF writes them, or the one that is named.
#[test]
fn kernels_of_several_hdus_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("psf.fits");
    let image = |first: &str, name: &str, edge: usize, value: f32| {
        let size = format!("{edge}");
        let cards = [
            format!("{first:<8}"),
            "BITPIX  =                  -32".into(),
            "NAXIS   =                    2".into(),
            format!("NAXIS1  = {size:>20}"),
            format!("NAXIS2  = {size:>20}"),
            "PCOUNT  =                    0".into(),
            "GCOUNT  =                    1".into(),
            format!("EXTNAME = '{name}'"),
        ];
        let cards: Vec<&str> = cards.iter().map(String::as_str).collect();
        fits(&cards, &std::iter::repeat_n(value.to_be_bytes(), edge * edge).flatten().collect::<Vec<u8>>())
    };
    let file = [image("SIMPLE  =                    T", "OVERSAMP", 8, 1.0), image("XTENSION= 'IMAGE   '", "DET_SAMP", 2, 2.0)].concat();
    std::fs::write(&path, file).unwrap();
    let of = |hdu| read_picture(&path, hdu, 1 << 20).map(|(size, values)| (size, values[0]));
    assert_eq!(of(None).unwrap(), ([8, 8], 1.0));
    assert_eq!(of(Some("det_samp")).unwrap(), ([2, 2], 2.0));
    assert_eq!(of(Some("1")).unwrap(), ([2, 2], 2.0));
    assert!(of(Some("OTHER")).unwrap_err().to_string().contains("has no HDU \"OTHER\""));
}

/// A FITS table with units, as synphot writes it: WAVELENGTH in ANGSTROMS, THROUGHPUT.
#[test]
fn fits_tables_are_curves() {
    let folder = tempfile::tempdir().unwrap();
    let empty = fits(&["SIMPLE  =                    T", "BITPIX  =                    8", "NAXIS   =                    0"], &[]);
    let table = |unit: &str| {
        let unit = format!("TUNIT1  = '{unit}'");
        let cards = [
            "XTENSION= 'BINTABLE'",
            "BITPIX  =                    8",
            "NAXIS   =                    2",
            "NAXIS1  =                   12",
            "NAXIS2  =                    3",
            "PCOUNT  =                    0",
            "GCOUNT  =                    1",
            "TFIELDS =                    2",
            "TTYPE1  = 'WAVELENGTH'",
            "TFORM1  = 'D       '",
            unit.as_str(),
            "TTYPE2  = 'THROUGHPUT'",
            "TFORM2  = 'E       '",
        ];
        let rows = [(5000f64, 0f32), (5500.0, 0.8), (6000.0, 0.0)];
        let data: Vec<u8> = rows.iter().flat_map(|(x, y)| [&x.to_be_bytes()[..], &y.to_be_bytes()[..]].concat()).collect();
        [empty.clone(), fits(&cards, &data)].concat()
    };
    let text = "[[band]]\nname = \"b\"\nkind = \"file\"\nfile = \"in.fits\"\n";
    std::fs::write(folder.path().join("in.fits"), table("ANGSTROMS")).unwrap();
    let area = scene(folder.path(), text).unwrap().bands[0].integrate(|_| 1.0);
    assert!((area / 0.04 - 1.0).abs() < 1e-6, "{area}");
    std::fs::write(folder.path().join("in.fits"), table("furlong")).unwrap();
    assert!(scene(folder.path(), text).unwrap_err().to_string().contains("furlong"));
}

/// Classic netCDF is named with its remedy.
#[test]
fn classic_netcdf_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("classic.nc");
    std::fs::write(&path, b"CDF\x01 and so on").unwrap();
    let error = members(&path, 1 << 20).unwrap_err().to_string();
    assert!(error.contains("netCDF 3") && error.contains("nccopy -k nc4"), "{error}");
}

/// Sources that are no files of a folder read texts by the same rules.
#[test]
fn every_source_reads_columns() {
    #[derive(Debug)]
    struct Text;
    impl DataSource for Text {
        fn label(&self, name: &str) -> String {
            name.to_owned()
        }
        fn text(&self, _: &str, _: u64) -> barnard::Result<std::borrow::Cow<'static, str>> {
            Ok("nm;t\n500;0,1\n600;0,2\n".into())
        }
        fn table(&self, name: &str, rows: usize, limit: u64) -> barnard::Result<barnard::data::TextTable> {
            SceneFiles::embedded(&[]).table(name, rows, limit)
        }
        fn array(&self, name: &str, member: Option<&str>, choose: Choose, limit: u64) -> barnard::Result<barnard::data::Array> {
            SceneFiles::embedded(&[]).array(name, member, choose, limit)
        }
    }
    let columns = Inputs::new(Arc::new(Text), 1 << 20).columns("x").unwrap();
    assert_eq!(columns.rows[1].1, [600.0, 0.2]);
}
