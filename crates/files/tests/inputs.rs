//! The policy of every reader (docs/data.md): what is stated is understood or refused, what is missing is unambiguous or
//! refused, what was inferred is noted. Expected values are those of the shapes that the files are made of.

use std::path::Path;
use std::sync::Arc;

use barnard::data::{ArrayHeader, Choose, DataSource, Inputs};
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
        (with("wavelength_nm,t", nm), "unit = \"um\"", Err("has nm")),
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
        ("nm,t\n500,0,0\n550,0,8\n600,0,0\n".into(), "", Err("line 1 must have 3 names")),
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
        ("frequency,T\n500,0\n550,0.8\n600,0\n".into(), "", Err("without a unit")),
        ("nm,id,throughput\n500,1,0\n550,2,0.8\n600,3,0\n".into(), "", Ok(0.04)),
        ("nm,a,b\n500,1,0\n550,2,0.8\n600,3,0\n".into(), "", Err("column = ")),
        ("nm,a,b\n500,1,0\n550,1,0.8\n600,1,0\n".into(), "column = \"b\"", Ok(0.04)),
        ("5.0D+02 0.0D0\n5.5D+02 8.0D-1\n6.0D+02 0.0D0\n".into(), "", Ok(0.04)),
        ("500,0\n550,nan\n600,0\n".into(), "", Err("line 2")),
        ("5,000;0.0\n5,500;0.8\n6,000;0.0\n".into(), "unit = \"angstrom\"", Err("line 1")),
        ("5,000.0;0.0\n5,500.0;0.8\n6,000.0;0.0\n".into(), "unit = \"angstrom\"", Err("line 1")),
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
    let albedo = |keys: &str| format!("{dust}albedo = {{ kind = \"file\", file = \"in.csv\"{keys} }}\n");
    hold(&cases, albedo, |scene| {
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
        ("angle,p\n0,2\n90,1\n180,0\n", "", Err("without a unit")),
        ("0,2\n90,1\n180,0\n", "", Err("cos theta")),
    ];
    let phase = |keys: &str| format!("{dust}phase = {{ kind = \"tabulated\", file = \"in.csv\"{keys} }}\n");
    hold(&cases, phase, |scene| scene.dust.as_ref().unwrap().phase.at(0.0, 0.55));
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
        ("ra,dec,johnson-V [Jy]\n83.82,-5.39,5\n", "", Err("magnitude unit")),
        ("ra,dec,johnson-V,teff [furlong]\n83.82,-5.39,5,9\n", "", Err("furlong")),
        ("ra,dec,johnson-V,teff [kK]\n83.82,-5.39,5,9\n", "", Ok(x)),
        ("\u{feff}ra,dec,johnson-V\n83.82,-5.39,5\n", "", Ok(x)),
        ("ra;dec;johnson-V\n83,82;-5,39;5\n", "", Err("in.csv:2")),
        ("# ra, dec, johnson-V\n83.82,-5.39,5\n", "", Ok(x)),
        ("# ra dec johnson-V\n83.82 -5.39 5\n", "", Ok(x)),
        ("# ra, dec, johnson-V\n\n83.82,-5.39,5\n", "", Err("in.csv:3")),
        ("name,ra,dec,johnson-V\n\"Alpha,83.82,-5.39,5\nBeta,1,2,3\n", "", Err("quotation mark")),
        ("ra,dec,johnson-V,name\n83.82,-5.39,5,\"Alpha\n1,2,3,Beta\n", "", Err("quotation mark")),
        ("ra,dec,johnson-V,name\n83.82,-5.39,5,5\" star\n", "", Ok(x)),
        (
            "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: ra, unit: hourangle, datatype: float64}\n# - {name: dec, unit: rad, datatype: float64}\n# - {name: johnson-V, unit: mag, datatype: float64}\nra dec johnson-V\n5.588 -0.0940732466801 5\n",
            "",
            Ok(x),
        ),
        ("ra,dec,johnson-V\n1.462934978997,-0.0940732466801,5\n", "", Err("ra [rad]")),
        ("right_ascension,dec,johnson-V\n5.588,-5.39,5\n", "", Err("right_ascension [h]")),
        ("l,b,johnson-V\n1.46,-0.09,5\n", "", Err("l [rad]")),
        ("ra,dec,gmag\n83.82,-5.39,5\n", "", Err("ambiguous between surveys")),
        ("ra,dec,Gmag\n83.82,-5.39,5\n", "", Ok(x)),
        ("ra,dec,panstarrs-g\n83.82,-5.39,5\n", "magnitude_system = \"ab\"\n", Ok(x)),
        ("ra,dec,johnson-V,pmra,pmdec,ref_epoch\n83.82,-5.39,5,0,3600000,2016\n", "epoch = 2016\n", Ok(x)),
        ("ra,dec,johnson-V,pmra [arcsec/yr],pmdec\n83.82,-5.39,5,1,1\n", "epoch = 2020\n", Err("arcsec/yr")),
        ("ra,dec,johnson-V,pmra,pmdec\n83.82,-5.39,5,1,1\n", "epoch = 2020\n", Err("catalogue_epoch")),
        ("ra,dec,johnson-V,pmra,pmdec,ref_epoch\n83.82,-5.39,5,1,1,\n", "epoch = 2020\n", Err("out of range")),
        ("ra,dec,johnson-V\n83.82,-5.39,5\n", "epoch = 2020\n", Err("pmra")),
        ("ra,dec,johnson-V\n83.82,-95.39,5\n", "", Err("in.csv:2")),
    ];
    let catalogue_text = |keys: &str| format!("[background.catalogue]\nfile = \"in.csv\"\naxes = \"icrs\"\n{keys}");
    hold(&cases, catalogue_text, |scene| {
        let stars = &scene.background.catalogue.as_ref().unwrap().catalogue.stars;
        assert_eq!(stars.len(), 1);
        stars[0].direction.x
    });
}

/// Barnard's star, whose name this program has: from its place in 2000 to that in 2016 of Gaia DR3 (Hipparcos 2007 catalogue:
/// 269.45402305°, 4.66828815° at 1991.25, μ = −797.84, 10326.93 mas/yr; Gaia DR3: 269.44850252°, 4.73942005° at 2016.0).
#[test]
fn proper_motions_are_applied() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("in.csv"),
        "ra [deg],dec [deg],johnson-V,pmra [mas/yr],pmde\n269.45402305,4.66828815,9.5,-797.84,10326.93\n",
    )
    .unwrap();
    let star = |keys: &str| {
        let scene = scene(folder.path(), &format!("[background.catalogue]\nfile = \"in.csv\"\naxes = \"icrs\"\n{keys}")).unwrap();
        (scene.background.catalogue.as_ref().unwrap().catalogue.stars[0].direction, scene.inputs[0].text.clone())
    };
    let unit = |ra: f64, dec: f64| {
        let [(sin_l, cos_l), (sin_b, cos_b)] = [ra, dec].map(|angle| angle.to_radians().sin_cos());
        barnard::glam::DVec3::new(cos_b * cos_l, cos_b * sin_l, sin_b)
    };
    let gaia = unit(269.44850252, 4.73942005);
    let (moved, note) = star("epoch = 2016\ncatalogue_epoch = 1991.25\n");
    // Perspective acceleration is 0.4 arcsec of these 256.
    let apart = |direction: barnard::glam::DVec3| direction.distance(gaia).to_degrees() * 3600.0;
    assert!(apart(moved) < 0.6 && note.contains("moved to 2016"), "{} arcsec; {note}", apart(moved));
    let (still, note) = star("");
    assert!(apart(still) > 200.0 && note.contains("ignored"), "{} arcsec; {note}", apart(still));
}

/// Magnitudes of passbands whose catalogues are not in Vega's system need their system, in catalogues, tables and stars.
#[test]
fn magnitude_systems_are_stated() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("in.csv"), "ra [deg],dec,sdss2010-g\n83.82,-5.39,5\n").unwrap();
    let star =
        "[[star]]\nkind = \"blackbody\"\ntemperature = \"6000 K\"\nposition = \"0 0 0 pc\"\nmagnitude = \"5 mag\"\ndistance = \"10 pc\"\n";
    for text in
        ["[background.catalogue]\nfile = \"in.csv\"\naxes = \"icrs\"\n".to_owned(), format!("{star}magnitude_band = \"sdss2010-g\"\n")]
    {
        let error = scene(folder.path(), &text).unwrap_err().to_string();
        assert!(error.contains("sdss2010-g") && error.contains("magnitude_system = \"ab\""), "{error}");
        scene(folder.path(), &format!("{text}magnitude_system = \"ab\"\n")).unwrap();
    }
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
        let band = spectra::passband::Passband::by_name(name).unwrap();
        let zero = spectra::sed::zero_point(&band, spectra::sed::MagnitudeSystem::Vega).unwrap();
        let flux = |(class, gain): &(usize, f64)| gain * band.integrate(|l| catalogue.classes[*class].spectrum.continuum(l));
        -2.5 * (catalogue.stars[0].shares.iter().map(flux).sum::<f64>() / zero).log10()
    };
    assert!((flux("johnson-V") - 5.0).abs() < 1e-9 && (flux("johnson-B") - 5.1).abs() < 1e-9);
    assert!(scene.inputs.iter().any(|note| note.text.contains("HYG") && note.is_inferred));
}

/// Required outcome of reading one variant of a text table.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Must {
    /// It is read right.
    Read,
    /// It is refused.
    Refuse,
    /// It is read right or refused.
    Either,
}

/// Variants of one table, valid and damaged, by column names and rows of numbers.
fn forms(names: &[&str], rows: &[&[&str]]) -> Vec<(&'static str, Vec<u8>, Must)> {
    use Must::{Either, Read, Refuse};
    let cells = |separator: &str, cell: &dyn Fn(&str) -> String| -> String {
        let line = |row: &[&str]| row.iter().map(|word| cell(word)).collect::<Vec<_>>().join(separator) + "\n";
        rows.iter().map(|row| line(row)).collect()
    };
    let joined = |separator: &str| names.join(separator) + "\n";
    let same = |cell: &str| cell.to_owned();
    let plain = joined(",") + &cells(",", &same);
    let body = cells(",", &same);
    let is_number = |cell: &str| cell.parse::<f64>().is_ok();
    let numbers = |make: &dyn Fn(f64) -> String| {
        let cell = |word: &str| word.parse::<f64>().map_or(word.to_owned(), make);
        joined(";") + &cells(";", &cell)
    };
    let commas = |word: &str| if is_number(word) { word.replace('.', ",") } else { word.to_owned() };
    let first_row = body.lines().next().unwrap();
    let last_number = rows[0].iter().rposition(|cell| is_number(cell)).unwrap();
    let spoilt = |with: &str| {
        let row: Vec<&str> = rows[0].iter().enumerate().map(|(i, cell)| if i == last_number { with } else { *cell }).collect();
        plain.replacen(first_row, &row.join(","), 1)
    };
    let ecsv_columns: String = names
        .iter()
        .map(|name| {
            let (base, unit) = name.trim_end_matches(']').split_once(" [").unwrap_or((name, ""));
            let unit = if unit.is_empty() { String::new() } else { format!("unit: {unit}, ") };
            format!("# - {{name: {base}, {unit}datatype: float64}}\n")
        })
        .collect();
    let bare: Vec<&str> = names.iter().map(|name| name.split(" [").next().unwrap()).collect();
    let ecsv =
        format!("# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n{ecsv_columns}# schema: astropy-2.0\n{}\n{body}", bare.join(","));
    let bytes = |text: String| text.into_bytes();
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain(plain.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    vec![
        ("plain", bytes(plain.clone()), Read),
        ("byte-order mark", bytes(format!("\u{feff}{plain}")), Read),
        ("CR LF", bytes(plain.replace('\n', "\r\n")), Read),
        ("CR", bytes(plain.replace('\n', "\r")), Read),
        ("no end of line", bytes(plain.trim_end().to_owned()), Read),
        ("semicolons", bytes(joined(";") + &cells(";", &same)), Read),
        ("tabs", bytes(joined("\t") + &cells("\t", &same)), Read),
        ("blanks behind separators", bytes(plain.replace(',', " , ")), Read),
        ("comments between", bytes(format!("# made by hand\n{}", plain.replacen('\n', "\n# a pause\n", 1))), Read),
        ("empty lines", bytes(plain.replace('\n', "\n\n")), Read),
        ("lines of blanks", bytes(plain.replace('\n', "\n   \n")), Read),
        ("quoted cells", bytes(joined(",") + &cells(",", &|cell| format!("\"{cell}\""))), Read),
        ("names behind #", bytes(format!("# {plain}")), if rows[0].iter().all(|cell| is_number(cell)) { Read } else { Either }),
        ("exponents", bytes(numbers(&|v| format!("{v:e}"))), Read),
        ("ECSV", bytes(ecsv), Read),
        ("plus signs", bytes(numbers(&|v| format!("{v:+}"))), Either),
        ("Fortran exponents", bytes(numbers(&|v| format!("{v:e}").replace('e', "D"))), Either),
        ("decimal commas", bytes(joined(";") + &cells(";", &commas)), Either),
        ("decimal commas by tabs", bytes(joined("\t") + &cells("\t", &commas)), Either),
        ("decimal commas by commas", bytes(joined(",") + &cells(",", &commas)), Either),
        ("Unicode minus", bytes(plain.replace('-', "−")), Either),
        ("separators at the end", bytes(plain.replace('\n', ",\n")), Either),
        ("names in capitals", bytes(plain.replacen(&joined(","), &joined(",").to_uppercase(), 1)), Either),
        ("thousands", bytes(spoilt("\"1,234.5\"")), Refuse),
        ("thousands by blanks", bytes(spoilt("1 234.5")), Refuse),
        ("empty", Vec::new(), Refuse),
        ("names alone", bytes(joined(",")), Refuse),
        ("comments alone", bytes("# a\n# b\n".into()), Refuse),
        ("a cell too few", bytes(plain.replacen(first_row, first_row.rsplit_once(',').unwrap().0, 1)), Refuse),
        ("a cell too many", bytes(plain.replacen(first_row, &format!("{first_row},7,8"), 1)), Refuse),
        ("a word for a number", bytes(spoilt("many")), Refuse),
        ("not a number", bytes(spoilt("nan")), Either),
        ("endless", bytes(spoilt("inf")), Refuse),
        ("beyond all numbers", bytes(spoilt("1e999")), Refuse),
        ("an open quotation mark", bytes(plain.replacen(first_row, &format!("\"{first_row}"), 1)), Either),
        ("UTF-16", utf16, Refuse),
        ("Latin 1", [plain.as_bytes(), b"\xe9"].concat(), Refuse),
        ("zeros", vec![0; 4096], Refuse),
    ]
}

/// Every reader of text gets the same table in many forms, and damaged: each is right, or refused with the name of the
/// file and the place in it.
#[test]
fn all_readers_of_text_are_right_or_refuse() {
    const DUST: &str =
        "[field.d]\nkind = \"sphere\"\nradius = \"1 pc\"\n[dust]\ndensity = \"d\"\nscale = \"1 /pc\"\nlaw = \"inverse_wavelength\"\n";
    const STAR: &str = "[[star]]\nposition = \"0 0 0 pc\"\nluminosity = \"1 Lsun\"\n";
    type Row = (&'static str, &'static [&'static str], &'static [&'static [&'static str]], String, fn(&Scene) -> f64, f64);
    let direction = 83.82f64.to_radians().cos() * (-5.39f64).to_radians().cos();
    let readers: [Row; 7] = [
        (
            "filter",
            &["wavelength [nm]", "throughput"],
            &[&["500.5", "0.25"], &["550.5", "0.75"], &["600.5", "0.25"]],
            "[[band]]\nname = \"b\"\nkind = \"file\"\nfile = \"in.csv\"\n".into(),
            |scene| scene.bands[0].integrate(|_| 1.0),
            0.05,
        ),
        (
            "spectrum",
            &["wavelength [nm]", "flux"],
            &[&["300.5", "1.5"], &["650.5", "1.5"], &["1000.5", "4.5"]],
            format!("{STAR}kind = \"file\"\nfile = \"in.csv\"\n"),
            |scene| scene.stars[0].spectrum.continuum(0.8255) / scene.stars[0].spectrum.continuum(0.5005),
            2.0,
        ),
        (
            "albedo",
            &["wavelength [nm]", "albedo"],
            &[&["400.5", "0.625"], &["600.5", "0.875"]],
            format!("{DUST}albedo = {{ kind = \"file\", file = \"in.csv\" }}\n"),
            |scene| scene.dust.as_ref().unwrap().albedo.at(0.5005),
            0.75,
        ),
        (
            "phase",
            &["cos_theta", "p"],
            &[&["-1.0", "0.5"], &["0.0", "1.5"], &["1.0", "2.5"]],
            format!("{DUST}albedo = 0.5\nphase = {{ kind = \"tabulated\", file = \"in.csv\" }}\n"),
            |scene| scene.dust.as_ref().unwrap().phase.at(0.0, 0.55) * 4.0 * std::f64::consts::PI,
            1.0,
        ),
        (
            "catalogue",
            &["ra [deg]", "dec [deg]", "johnson-V"],
            &[&["183.5", "25.5", "5.5"], &["83.82", "-5.39", "9.5"]],
            "[background.catalogue]\nfile = \"in.csv\"\naxes = \"icrs\"\n".into(),
            // The second row is the fainter star, the last; a star without a magnitude is left out.
            |scene| scene.background.catalogue.as_ref().unwrap().catalogue.stars.last().unwrap().direction.x,
            direction,
        ),
        (
            "star table",
            &["x [pc]", "y [pc]", "z [pc]", "temperature [K]", "luminosity [Lsun]"],
            &[&["0.5", "-1.25", "1.5", "9000.5", "2.5"], &["1.5", "1.5", "1.5", "5000.5", "1.5"]],
            "[[star_table]]\nfile = \"in.csv\"\n".into(),
            |scene| scene.stars[0].position.x - scene.stars[0].position.y,
            1.75,
        ),
        (
            "path",
            &["time [s]", "x [pc]", "y [pc]", "z [pc]"],
            &[&["0.0", "0.5", "-1.25", "5.5"], &["1.5", "1.5", "1.5", "4.5"]],
            "[camera.path]\nfile = \"in.csv\"\n".into(),
            |scene| scene.camera.position.x - scene.camera.position.y,
            1.75,
        ),
    ];
    let mut wrong = Vec::new();
    for (reader, names, rows, text, value, expected) in readers {
        let forms = forms(names, rows);
        assert!(forms.len() >= 30);
        for (form, bytes, must) in forms {
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(folder.path().join("in.csv"), &bytes).unwrap();
            match scene(folder.path(), &text) {
                Ok(scene) => {
                    let found = value(&scene);
                    if must == Must::Refuse || (found / expected - 1.0).abs() > 1e-5 {
                        wrong.push(format!("{reader}, {form}: read as {found}, where {expected} is right ({must:?})"));
                    }
                }
                Err(error) => {
                    let message = error.to_string();
                    if must == Must::Read || !message.contains("in.csv") || message.len() < 30 {
                        wrong.push(format!("{reader}, {form}: {message} ({must:?})"));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A kernel of EXR is padded to its display window, and cut by it: a point in column 3, row 4 of 8 x 6 pixels.
#[test]
fn kernels_of_exr_fill_their_display_window() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("psf.exr");
    let write = |first: (i32, i32), size: (usize, usize), window: ((i32, i32), (usize, usize)), point: usize| {
        let values = (0..size.0 * size.1).map(|i| if i == point { 1.0 } else { 0.25 }).collect::<Vec<f32>>();
        let channels = AnyChannels::sort([AnyChannel::new("Y", FlatSamples::F32(values))].into_iter().collect());
        let mut attributes = LayerAttributes::named("psf");
        attributes.layer_position = Vec2(first.0, first.1);
        let mut image = Image::from_layer(Layer::new(size, attributes, Encoding::UNCOMPRESSED, channels));
        image.attributes.display_window = IntegerBounds { position: Vec2(window.0.0, window.0.1), size: Vec2(window.1.0, window.1.1) };
        image.write().to_file(&path).unwrap();
        read_picture(&path, None, 1 << 20).unwrap()
    };
    let whole = |(first, size): ((i32, i32), (usize, usize))| {
        let inside = |x: i32, y: i32| (first.0..first.0 + size.0 as i32).contains(&x) && (first.1..first.1 + size.1 as i32).contains(&y);
        let value = |x: i32, y: i32| {
            if (x, y) == (3, 4) {
                1.0
            } else if inside(x, y) {
                0.25
            } else {
                0.0
            }
        };
        (0..6).flat_map(|y| (0..8).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect::<Vec<f64>>()
    };
    // All of it; a part within it; more than it on all sides; a display window that does not begin at zero.
    for (first, size, window, point) in [
        ((0, 0), (8, 6), (0, 0), 4 * 8 + 3),
        ((2, 3), (4, 2), (0, 0), 4 + 1),
        ((-1, -2), (12, 9), (0, 0), 6 * 12 + 4),
        ((12, 3), (4, 2), (10, 0), 4 + 1),
    ] {
        let found = write(first, size, (window, (8, 6)), point);
        assert_eq!(found, ([8, 6], whole(((first.0 - window.0, first.1 - window.1), size))), "{first:?} {size:?}");
    }
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

/// Field of a cube with these cards at a position [pc], or the error.
fn cube_at(more: &[&str], place: [f64; 3]) -> Result<f64, String> {
    let folder = tempfile::tempdir().unwrap();
    let cards: Vec<&str> = PLAIN.iter().chain(&["CUNIT1  = 'pc      '"]).chain(more).copied().collect();
    let cards: Vec<&str> = cards.iter().filter(|card| !more.iter().any(|new| new[..8] == card[..8] && new != *card)).copied().collect();
    std::fs::write(folder.path().join("in.fits"), cube(&cards)).unwrap();
    let text = "[field.d]\nkind = \"grid\"\nfile = \"in.fits\"\n[dust]\ndensity = \"d\"\nscale = \"1 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.5\n";
    let scene = scene(folder.path(), text).map_err(|e| e.to_string())?;
    Ok(scene.dust.as_ref().unwrap().density.at(barnard::glam::DVec3::from(place)))
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
        &mut |layout: &ArrayHeader| {
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
    let array = read_file(&path, None, &mut |layout: &ArrayHeader| Ok(layout.whole()), 1 << 20).unwrap();
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
    let first_pixel = |hdu| read_picture(&path, hdu, 1 << 20).map(|(size, values)| (size, values[0]));
    assert_eq!(first_pixel(None).unwrap(), ([8, 8], 1.0));
    assert_eq!(first_pixel(Some("det_samp")).unwrap(), ([2, 2], 2.0));
    assert_eq!(first_pixel(Some("1")).unwrap(), ([2, 2], 2.0));
    assert!(first_pixel(Some("OTHER")).unwrap_err().to_string().contains("has no HDU \"OTHER\""));
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
#[cfg_attr(not(feature = "hdf5"), ignore = "needs the feature hdf5")]
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
