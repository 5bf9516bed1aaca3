//! Tables of stars: a row of a CSV is what `[[star]]` says, and errors name file, line and key.

use barnard::Result;
use barnard::scene::Star;
use barnard_files::{in_folder, parse};

const SCENE: &str = r#"[camera]
kind = "perspective"
position = "0 0 6 pc"
field_of_view = "30 deg"
size = [16, 16]
"#;

/// The stars of a scene with this table of stars, beside those of a scene in which they stand one by one.
fn stars(csv: &str, keys: &str) -> Result<Vec<Star>> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cluster.csv"), csv).unwrap();
    parsed(&format!("{SCENE}[[star_table]]\nfile = \"cluster.csv\"\n{keys}"), folder.path())
}

fn parsed(text: &str, folder: &std::path::Path) -> Result<Vec<Star>> {
    parse("test.toml", "test", text.into(), &in_folder(folder, 1 << 30)).map(|scene| scene.stars.clone())
}

fn same(ours: &[Star], theirs: &str) {
    let theirs = parsed(&format!("{SCENE}{theirs}"), std::path::Path::new("")).unwrap();
    assert_eq!(ours.len(), theirs.len());
    for (a, b) in ours.iter().zip(&theirs) {
        assert!(a.name == b.name && a.position == b.position && a.visible == b.visible, "{a:?} {b:?}");
        for l in [0.4, 0.55, 0.9] {
            assert_eq!(a.spectrum.continuum(l), b.spectrum.continuum(l));
        }
    }
}

/// Rows are stars as `[[star]]` has them: units of columns, of cells and the usual ones, other separators, columns that
/// mean nothing, comments, empty cells, keys of all.
#[test]
fn rows_are_stars() {
    let ours = stars(
        "# made by hand\nName, x [au], Y [au], z [au], temperature, luminosity [W], ra\n\n\"a, b\", 1, -2, 3e5, 9000, 1e28, 0.1\n# a pause\nc, 0, 0, 1, 5 kK, 2 Lsun, \n",
        "visible = false\n",
    );
    let one = |name: &str, place: &str, temperature: &str, luminosity: &str| {
        format!(
            r#"[[star]]
name = "{name}"
kind = "blackbody"
position = "{place}"
temperature = "{temperature}"
luminosity = "{luminosity}"
visible = false
"#
        )
    };
    same(&ours.unwrap(), &(one("a, b", "1 -2 3e5 au", "9000 K", "1e28 W") + &one("c", "0 0 1 au", "5000 K", "2 Lsun")));
    let ours = stars("x;y;z;type;magnitude;visible\n1;2;3;o9v;4.5;TRUE\n1;2;4;;5;false\n", "distance = \"400 pc\"\n");
    assert!(ours.unwrap_err().to_string().contains("\"type\" is required"));
    let ours = stars("x y z type magnitude visible\n1 2 3 o9v 4.5 TRUE\n1 2 4 a0v 5 false\n", "distance = \"400 pc\"\n");
    let one = |n: u32, z: f64, kind: &str, magnitude: f64| {
        format!(
            r#"[[star]]
name = "star_table[0][{}]"
kind = "stellar"
type = "{kind}"
position = "1 2 {z} pc"
magnitude = "{magnitude} mag"
distance = "400 pc"
visible = {}
"#,
            n - 1,
            n == 1
        )
    };
    same(&ours.unwrap(), &(one(1, 3.0, "o9v", 4.5) + &one(2, 4.0, "a0v", 5.0)));
}

/// Byte order marks, the line ends of Windows, lines of blanks, many blanks between columns, and columns that are not
/// asked for.
#[test]
fn tables_of_all_kinds_are_read() {
    let one = r#"[[star]]
name = "star_table[0][0]"
kind = "blackbody"
position = "1 2 3 pc"
temperature = "5000 K"
luminosity = "7 Lsun"
"#;
    for (csv, keys) in [
        ("\u{feff}# a, b\r\nx;y;z;temperature;luminosity\r\n   \r\n1;2;3;5000;7\r\n", ""),
        ("  x     y   z  temperature   luminosity\n   \n 1.0  2.0   3.0   5000     7\n", ""),
        ("x,y,z,temperature,luminosity,type,distance,radius\n1,2,3,5000,7,g2v,4,5\n", "columns = [\"temperature\", \"luminosity\"]\n"),
    ] {
        same(&stars(csv, keys).unwrap(), one);
    }
}

/// What is wrong is said with file, line and what would be right.
#[test]
fn mistakes_are_named() {
    let head = "x,y,z,temperature,luminosity\n";
    let many = head.to_owned() + &"0,0,0,5000,1\n".repeat(20_001);
    for (csv, keys, words) in [
        ("", "", &["no header", "cluster.csv:1"][..]),
        (head, "", &["no rows below its header"]),
        ("# nothing\nx,y,temperature\n0,0,1\n", "", &["no column \"z\"", "cluster.csv:2"]),
        ("x,y,z,temprature,luminosity\n0,0,0,5000,1\n", "", &["unknown column \"temprature\"", "\"temperature\"", "cluster.csv:1"]),
        ("x [pc],y,z,temperature,luminosity\n0,0,0,5000,1\n", "", &["different units"]),
        ("x,y,z,x\n0,0,0,0\n", "", &["two columns \"x\""]),
        (&format!("{head}0,0,0,5000,1\n\n0,0,nan,5000,1\n"), "", &["z = \"nan\" is not a number", "cluster.csv:4"]),
        (&format!("{head}0,0,0,5000 m,1\n"), "", &["unknown unit", "cluster.csv:2", "temperature"]),
        (&format!("{head}0,0,0,-5000,1\n"), "", &["must be between 1 and 1e9 K", "cluster.csv:2"]),
        (&format!("{head}0,0,0,5000\n"), "", &["has 4 cells", "cluster.csv:2"]),
        (&format!("{head}0,,0,5000,1\n"), "", &["y = \"\" is not a number", "cluster.csv:2"]),
        (&format!("name,{head}\"a\nb\",0,0,0,5000,1\nc,0,0,0,-1,1\n"), "", &["quotation mark", "cluster.csv:2"]),
        (&format!("{head}0,0,0,5000,1\n"), "kind = \"file\"\n", &["spectra from files", "test.toml"]),
        (&format!("{head}0,0,0,5000,1\n"), "columns = [\"radius\"]\n", &["no column \"radius\""]),
        (&format!("{head}0,0,0,\"50\" }}\",1\n"), "", &["cluster.csv:2"]),
        (&format!("{head}0,0,0,5000,1\n"), "temperature = \"4000 K\"\n", &["also a column of", "test.toml:8"]),
        (&format!("{head}0,0,0,5000,1\n"), "position = \"0 0 0 pc\"\n", &["unknown key \"position\""]),
        (&format!("{head}0,0,0,5000,1\n"), "kind = \"stellar\"\n", &["type", "cluster.csv:2"]),
        (&many, "", &["more than 20000 rows"]),
    ] {
        let error = stars(csv, keys).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{}: {error}", &csv[..csv.len().min(60)]);
    }
    let error = parsed(&format!("{SCENE}[[star_table]]\nfile = \"none.csv\"\n"), std::path::Path::new("")).unwrap_err().to_string();
    assert!(error.contains("none.csv") && error.contains("does not exist"), "{error}");
}
