//! Scenes that change: paths of cameras, tracks of keys, and frames, as scene files say them.

use barnard::glam::DVec3;
use barnard::scene::Scene;
use barnard::sequence::Follower;
use barnard_files::{SceneFile, builtin};

/// A scene around what is said of its changes.
fn text(camera: &str, rest: &str) -> String {
    format!(
        r#"[camera]
kind = "perspective"
field_of_view = "30 deg"
size = [8, 8]
{camera}
[field.ball]
kind = "plummer"
core = "0.3 pc"
[dust]
density = "ball"
scale = "2 mag/pc"
law = "ccm89"
[[star]]
kind = "blackbody"
temperature = "5000 K"
luminosity = "10 Lsun"
position = "0 0 0 pc"
{rest}"#
    )
}

fn read(text: String) -> Result<SceneFile, String> {
    SceneFile::parse("test.toml", "test", text, builtin::loader(1 << 30)).map_err(|e| e.to_string())
}

fn at(file: &SceneFile, time: f64) -> Scene {
    file.sequence().unwrap().scene(time).unwrap()
}

fn key(time: f64, rest: &str) -> String {
    format!(
        r#"[[camera.path.key]]
time = "{time} s"
{rest}
"#
    )
}

/// A path leads through its keys, whatever unit they are in, and a still shows the first of them.
#[test]
fn a_camera_follows_its_path() {
    let keys = [key(0.0, "position = \"0 0 4 pc\"\ntarget = \"0 0 0 pc\""), key(1.0, "position = \"4000 0 0 mpc\"")];
    // Thousandths of a parsec are no unit of length here.
    assert!(read(text("[camera.path]", &keys.concat())).unwrap_err().contains("unit of length"));
    let keys = [
        key(0.0, "position = \"0 0 4 pc\"\ntarget = \"0 0 0 pc\"\nfield_of_view = \"30 deg\""),
        key(1.0, "position = \"0.004 0 0 kpc\""),
        key(3.0, "position = \"0 0 -4 pc\"\ntarget = \"0 0 0 pc\"\nfield_of_view = \"60 deg\""),
    ];
    let file = read(text("[camera.path]\ninterpolation = \"linear\"", &keys.concat())).unwrap();
    assert_eq!(file.scene.camera.position, DVec3::new(0.0, 0.0, 4.0));
    for (time, place) in
        [(0.0, [0.0, 0.0, 4.0]), (1.0, [4.0, 0.0, 0.0]), (2.0, [2.0, 0.0, -2.0]), (3.0, [0.0, 0.0, -4.0]), (9.0, [0.0, 0.0, -4.0])]
    {
        let camera = at(&file, time).camera.clone();
        assert!(camera.position.distance(DVec3::from(place)) < 1e-12, "{time}");
        assert!(camera.forward.distance(-camera.position.normalize()) < 1e-12, "{time}");
    }
    let width = |time: f64| match at(&file, time).camera.projection {
        barnard::camera::Projection::Perspective { half_width } => 2.0 * half_width.atan().to_degrees(),
        other => panic!("{other:?}"),
    };
    assert!((width(1.5) - 45.0).abs() < 1e-9 && (width(0.0) - 30.0).abs() < 1e-9);
    let frames = file.sequence().unwrap().frames();
    assert_eq!((frames.first, frames.last(), frames.time(31)), (1, 91, 1.0));
}

/// At one speed a camera has gone a third of its way in a third of the time, and comes to rest where it is eased; without, it
/// has not.
#[test]
fn speed_is_constant_and_eased() {
    let keys = [
        key(0.0, "position = \"0 0 4 pc\"\ntarget = \"0 0 -9 pc\""),
        key(1.0, "position = \"0 0 1 pc\""),
        key(6.0, "position = \"0 0 -5 pc\""),
    ]
    .concat();
    let z = |more: &str, time: f64| at(&read(text(&format!("[camera.path]\n{more}"), &keys)).unwrap(), time).camera.position.z;
    assert!((z("constant_speed = true", 2.0) - 1.0).abs() < 1e-6 && (z("", 2.0) - 1.0).abs() > 0.5);
    let step = 1e-3;
    let speed = |more: &str, time: f64| (z(more, time + step) - z(more, time)).abs() / step;
    let eased = "constant_speed = true\nease = \"1 s\"";
    assert!(speed(eased, 0.0) < 1e-3 && speed(eased, 6.0 - step) < 1e-3 && (speed(eased, 3.0) - 1.5).abs() < 1e-3);
    assert!((speed("constant_speed = true", 0.0) - 1.5).abs() < 1e-3);
    assert!((z(eased, 6.0) + 5.0).abs() < 1e-9 && (z(eased, 0.0) - 4.0).abs() < 1e-9);
}

/// A quaternion turns the camera, as a direction or a target would; between two it turns evenly.
#[test]
fn orientations_turn_the_camera() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let keys = |first: &str, second: &str| [key(0.0, &format!("position = \"0 0 4 pc\"\n{first}")), key(2.0, second)].concat();
    let camera =
        |first: &str, second: &str, time: f64| at(&read(text("[camera.path]", &keys(first, second))).unwrap(), time).camera.clone();
    // A quarter to the left about y, whichever of two signs stands for it.
    for sign in [1.0, -1.0] {
        let (none, left) = ("orientation = [0, 0, 0, 1]".to_owned(), format!("orientation = [0, {}, 0, {}]", sign * half, sign * half));
        let turned = |time: f64| camera(&none, &left, time).forward;
        assert!(turned(0.0).distance(-DVec3::Z) < 1e-12 && turned(2.0).distance(-DVec3::X) < 1e-12, "{sign}");
        assert!(turned(1.0).distance(DVec3::new(-half, 0.0, -half)) < 1e-12, "{sign}");
    }
    let up = camera(&format!("orientation = [0, 0, {half}, {half}]"), "position = \"0 0 4 pc\"", 0.0).up;
    assert!(up.distance(-DVec3::X) < 1e-12);
    let direction = camera("direction = [2, 0, 0]", "direction = [0, 0, -1]", 0.0).forward;
    assert!(direction.distance(DVec3::X) < 1e-12);
}

/// What goes with a key of the scene: a star's temperature, the dust, the exposure, and what changes in steps.
#[test]
fn any_key_changes() {
    let tracks = r#"[[animation]]
of = "star[0].temperature"
times = ["0 s", "2 s"]
values = ["5000 K", "9000 K"]
[[animation]]
of = "dust.law"
times = ["0 s", "1 s"]
values = ["ccm89", "gordon23"]
interpolation = "step"
[[animation]]
of = "display.white"
times = ["1 s", "3 s"]
values = [1e-8, 3e-8]
[sequence]
first_frame = 100
duration = "10 s"
"#;
    let file = read(text("position = \"0 0 4 pc\"", tracks)).unwrap();
    let white = |time: f64| match at(&file, time).display.white {
        barnard::image::Level::Radiance(white) => white,
        barnard::image::Level::Auto => f64::NAN,
    };
    assert!((white(2.0) - 2e-8).abs() < 1e-20 && white(0.0) == 1e-8);
    let law = |time: f64| at(&file, time).dust.as_ref().unwrap().extinction.name.clone();
    assert!(law(0.5).contains("ccm89") && law(1.5).contains("gordon23"), "{} {}", law(0.5), law(1.5));
    let ratio = at(&file, 2.0).stars[0].spectrum.continuum(0.4) / at(&file, 0.0).stars[0].spectrum.continuum(0.4);
    assert!(ratio > 1.5, "{ratio}");
    let frames = file.sequence().unwrap().frames();
    assert_eq!((frames.first, frames.last()), (100, 400));
}

/// A camera that moves keeps the fields, and so does a star that changes.
#[test]
fn what_stays_is_kept() {
    let keys = [key(0.0, "position = \"0 0 4 pc\"\ntarget = \"0 0 0 pc\""), key(2.0, "position = \"4 0 0 pc\"")].concat();
    let track = r#"[[animation]]
of = "star[0].luminosity"
times = ["0.5 s", "2 s"]
values = ["10 Lsun", "20 Lsun"]
"#;
    let file = read(text("[camera.path]", &format!("{keys}{track}"))).unwrap();
    let sequence = file.sequence().unwrap();
    let mut follower = Follower::new(&sequence);
    let control = &barnard::Control::default();
    let (a, b) = (follower.scene(0.0, control).unwrap(), follower.scene(1.0, control).unwrap());
    assert!(std::sync::Arc::ptr_eq(&a.dust.as_ref().unwrap().density, &b.dust.as_ref().unwrap().density) && a.camera != b.camera);
}

/// Wrong paths, tracks and sequences are told with their line and what would be right.
#[test]
fn wrong_changes_are_told() {
    let still = "position = \"0 0 4 pc\"";
    let two = [key(0.0, "position = \"0 0 4 pc\""), key(1.0, "position = \"0 0 5 pc\"")].concat();
    let track = |place: &str, times: &str, values: &str| {
        format!(
            r#"[[animation]]
of = "{place}"
times = {times}
values = {values}
"#
        )
    };
    let (times, values) = ("[\"0 s\", \"1 s\"]", "[\"1 K\", \"2 K\"]");
    let wrong: &[(&str, String, &[&str])] = &[
        ("[camera.path]", String::new(), &["no keys", "two or more"]),
        ("[camera.path]", key(0.0, "position = \"0 0 4 pc\""), &["one key"]),
        (
            "[camera.path]",
            [key(1.0, "position = \"0 0 4 pc\""), key(0.5, "position = \"0 0 5 pc\"")].concat(),
            &["sort keys by time", "0.5 s"],
        ),
        ("[camera.path]", [key(1.0, "position = \"0 0 4 pc\""), key(1.0, "position = \"0 0 5 pc\"")].concat(), &["sort keys by time"]),
        ("[camera.path]", [key(-1.0, "position = \"0 0 4 pc\""), key(1.0, "")].concat(), &["0 s or later"]),
        ("[camera.path]", [key(0.0, "position = \"0 0 nan pc\""), key(1.0, "")].concat(), &["position such as"]),
        ("[camera.path]", [key(0.0, "position = \"0 0 4 pc\"\nup = [nan, 0, 0]"), key(1.0, "")].concat(), &["list of numbers"]),
        ("[camera.path]", [key(0.0, "position = \"0 0 4 pc\"\nup = [0, 0, 0]"), key(1.0, "")].concat(), &["points nowhere"]),
        ("[camera.path]", [key(0.0, "position = \"0 0 4 pc\"\norientation = [0, 0, 1]"), key(1.0, "")].concat(), &["4 numbers"]),
        ("[camera.path]", [key(0.0, "position = \"0 0 4 pc\"\nposition_x = 1"), key(1.0, "")].concat(), &["unknown key", "known: time"]),
        ("[camera.path]", [key(0.0, "position = \"0 0 0 pc\""), key(1.0, "")].concat(), &["same position"]),
        (
            "[camera.path]",
            [key(0.0, "position = \"0 0 4 pc\"\ntarget = \"0 0 0 pc\"\ndirection = [0, 0, 1]"), key(1.0, "")].concat(),
            &["both target and direction"],
        ),
        (
            "[camera.path]",
            [key(0.0, "position = \"0 0 4 pc\""), key(1.0, "aperture = \"180 deg\"")].concat(),
            &["\"aperture\" requires kind fisheye", "perspective"],
        ),
        ("[camera.path]\nease = \"0.6 s\"", two.clone(), &["ease", "half of the path"]),
        (
            "[camera.path]\nconstant_speed = true",
            [key(0.0, "target = \"0 0 4 pc\""), key(1.0, "target = \"0 0 5 pc\"")].concat(),
            &["does not move"],
        ),
        ("[camera.path]\ninterpolation = \"cubic\"", two.clone(), &["catmull_rom, bezier"]),
        ("[camera.path]\nunit = \"1 pc\"", two.clone(), &["unit", "requires file"]),
        ("[camera.path]\nfile = \"a.csv\"", two.clone(), &["file"]),
        ("[camera.path]\nfile = \"missing.csv\"", String::new(), &["missing.csv"]),
        (still, track("star[1].temperature", times, values), &["star[1] does not exist", "test.toml:19"]),
        (still, track("star[0].temprature", times, values), &["temprature", "temperature"]),
        (still, track("sequence.shutter", times, values), &["cannot be animated"]),
        (still, track("star[0].temperature", times, "[\"1 K\", \"2 kK\"]"), &["same form and unit"]),
        (still, track("star[0].temperature", "[\"1 s\", \"0 s\"]", values), &["0 s is not later"]),
        (still, track("star[0].temperature", times, "[\"1 K\"]"), &["2 times have 1 values"]),
        (still, "[sequence]\nframes_per_second = 0".into(), &["above zero"]),
        (still, "[sequence]\nduration = \"-1 s\"".into(), &["duration"]),
        (still, "[sequence]\nduration = \"1e30 s\"".into(), &["duration"]),
        (still, "[sequence]\nshutter = \"400 deg\"".into(), &["between 0 and 360 deg"]),
        (
            still,
            r#"[bookmark.1]
kind = "perspective"
position = "0 0 4 pc"
field_of_view = "30 deg"
[bookmark.1.path]
"#
            .into(),
            &["bookmark cannot have a path"],
        ),
    ];
    for (camera, rest, words) in wrong {
        let error = read(text(camera, rest)).map(|_| ()).unwrap_err();
        assert!(words.iter().all(|word| error.contains(word)), "{camera} {rest}: {error}");
    }
}

/// Keyframes of a CSV are those of the same tables, in whatever units its columns are.
#[test]
fn a_csv_is_a_path() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let loader = || barnard_files::in_folder(folder.path(), 1 << 30);
    let of_file = |name: &str| {
        let text = text(&format!("[camera.path]\nfile = \"{name}\""), "");
        SceneFile::parse("test.toml", "test", text, loader()).map_err(|e| e.to_string())
    };
    write(
        "a.csv",
        "# a flight\ntime [min], x [kpc], y [kpc], z [kpc], target_x, target_y, target_z, field_of_view [rad]\n0, 0, 0, 0.004, 0, 0, 0, 0.5\n0.05, 0.004, 0, 0, 0.1, 0.2, 0, 0.7\n0.1, 0, 0, -0.004, 0, 0, 0, 0.5\n",
    );
    let tables = [
        key(0.0, "position = \"0 0 4 pc\"\ntarget = \"0 0 0 pc\"\nfield_of_view = \"0.5 rad\""),
        key(3.0, "position = \"4 0 0 pc\"\ntarget = \"0.1 0.2 0 pc\"\nfield_of_view = \"0.7 rad\""),
        key(6.0, "position = \"0 0 -4 pc\"\ntarget = \"0 0 0 pc\"\nfield_of_view = \"0.5 rad\""),
    ];
    let tables = read(text("[camera.path]", &tables.concat())).unwrap();
    for time in [0.0, 1.1, 3.0, 4.7, 6.0] {
        let (csv, of_tables) = (at(&of_file("a.csv").unwrap(), time).camera.clone(), at(&tables, time).camera.clone());
        assert!(csv.position.distance(of_tables.position) < 1e-12 && csv.forward.distance(of_tables.forward) < 1e-12, "{time}");
        assert_eq!(csv.projection, of_tables.projection, "{time}");
    }
    // A row without a target goes on between its neighbours.
    write("m.csv", "time [s],x [pc],y [pc],z [pc],target_x [pc],target_y [pc],target_z [pc]\n0,0,0,4,0,0,0\n1,0,0,3,,,\n2,0,0,2,0,0,0\n");
    assert!(at(&of_file("m.csv").unwrap(), 1.0).camera.forward.distance(DVec3::NEG_Z) < 1e-12);
    for (name, text, words) in [
        ("b.csv", "time,x,y\n0,1,2\n1,2,3\n", "columns x, y, z"),
        ("c.csv", "x,y,z\n0,1,2\n1,2,3\n", "time [s]"),
        ("d.csv", "time,x,y,z\n0,1,2,3\n1,2,3,four\n", "d.csv:3, z"),
        ("e.csv", "time,x [parsec],y [parsec],z [parsec]\n0,1,2,3\n1,2,3,4\n", "unknown unit"),
        ("f.csv", "time,x,y,z\n1,1,2,3\n0.5,2,3,4\n", "sort keys by time"),
        ("g.csv", "time,x,y,z\n1,1,2,3\n", "one key"),
        ("h.csv", "time\n0\n1\n", "not columns of a camera path"),
        ("j.csv", "time,x,y,z,target-x\n0,1,2,3,4\n1,2,3,4,5\n", "did you mean \"target_x\""),
        ("k.csv", "time,x [ly],y,z\n0,1,2,3\n1,2,3,4\n", "different units"),
        ("l.csv", "time,x,y,z\n0,1,,3\n1,2,3,4\n", "\"\" is not a number"),
        ("i.csv", "time,x,y,z\n0,1,2,nan\n1,2,3,4\n", "not a number"),
    ] {
        write(name, text);
        let error = of_file(name).map(|_| ()).unwrap_err();
        assert!(error.contains(words), "{name}: {error}");
    }
}

/// A camera path of Gaia Sky: a frame a line, 10^9 m a unit of length, 60 frames a second where the file says no other.
#[test]
fn paths_of_gaia_sky() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let of_file = |name: &str| {
        let text = text(&format!("[camera.path]\ninterpolation = \"linear\"\nfile = \"{name}\""), "");
        SceneFile::parse("test.toml", "test", text, barnard_files::in_folder(folder.path(), 1 << 30)).map_err(|e| e.to_string())
    };
    // A parsec is 3.0856775814913673e16 m (IAU 2015 resolution B2).
    let pc = 3.085_677_581_491_367e7;
    let rows = format!(
        "#fps 20.0\n# time_ms,pos,dir,up\n1700000000000,0.0,0.0,{},0.0,0.0,-2.0,0.0,1.0,0.0\n1700000000050 {} 0.0 {} -1.0 0.0 -1.0 0.0 1.0 0.0\n2026-01-01T00:00:00Z, {}, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0\n",
        4.0 * pc,
        2.0 * pc,
        2.0 * pc,
        4.0 * pc
    );
    write("a.gsc", &rows);
    let file = of_file("a.gsc").unwrap();
    for (time, place, forward) in [
        (0.0, [0.0, 0.0, 4.0], DVec3::NEG_Z),
        (0.05, [2.0, 0.0, 2.0], DVec3::new(-1.0, 0.0, -1.0)),
        (0.075, [3.0, 0.0, 1.0], DVec3::new(-1.0 - 0.5f64.sqrt(), 0.0, -(0.5f64.sqrt()))),
        (0.1, [4.0, 0.0, 0.0], DVec3::NEG_X),
    ] {
        let camera = at(&file, time).camera.clone();
        assert!(camera.position.distance(DVec3::from(place)) < 1e-9, "{time} {}", camera.position);
        assert!(camera.forward.distance(forward.normalize()) < 1e-9 && camera.up.distance(DVec3::Y) < 1e-9, "{time} {}", camera.forward);
    }
    write("b.gsc", &rows.replace("#fps 20.0\n", ""));
    assert!((of_file("b.gsc").unwrap().sequence().unwrap().frames().count, 1.0) == (2, 1.0));
    for (name, text, words) in [
        ("c.gsc", "#fps zero\n".to_owned(), "not a number of frames"),
        ("d.gsc", "0,1,2,3\n".to_owned(), "d.gsc:1"),
        ("e.gsc", "0,1,2,3,4,5,x,7,8,9\n".to_owned(), "\"x\" is not a number"),
        ("f.gsc", String::new(), "no keys"),
    ] {
        write(name, &text);
        let error = of_file(name).map(|_| ()).unwrap_err();
        assert!(error.contains(words), "{name}: {error}");
    }
}

/// Node, path, interpolation, times and values of an animation's channel.
type Channel<'a> = (usize, &'a str, &'a str, &'a [f32], &'a [f32]);

/// A glTF with a camera below a node, written by hand after the specification, and its buffer.
fn gltf(channels: &[Channel]) -> (String, Vec<u8>) {
    let mut bytes = Vec::new();
    let (mut views, mut accessors, mut samplers, mut targets) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (node, path, interpolation, times, values) in channels {
        for (numbers, dims) in [(times, 1), (values, if *path == "rotation" { 4 } else { 3 })] {
            let view = format!("{{\"buffer\": 0, \"byteOffset\": {}, \"byteLength\": {}}}", bytes.len(), 4 * numbers.len());
            bytes.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
            let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][dims - 1];
            // Moments have to say their bounds.
            let bounds =
                if dims == 1 { format!(", \"min\": [{}], \"max\": [{}]", numbers[0], numbers[numbers.len() - 1]) } else { String::new() };
            accessors.push(format!(
                "{{\"bufferView\": {}, \"componentType\": 5126, \"count\": {}, \"type\": \"{kind}\"{bounds}}}",
                views.len(),
                numbers.len() / dims
            ));
            views.push(view);
        }
        targets.push(format!("{{\"sampler\": {}, \"target\": {{\"node\": {node}, \"path\": \"{path}\"}}}}", samplers.len()));
        let last = accessors.len();
        samplers.push(format!("{{\"input\": {}, \"output\": {}, \"interpolation\": \"{interpolation}\"}}", last - 2, last - 1));
    }
    let json = format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"scene\": 0, \"scenes\": [{{\"nodes\": [0]}}], \
         \"nodes\": [{{\"children\": [1], \"translation\": [1, 0, 0]}}, {{\"camera\": 0, \"translation\": [0, 0, 3]}}], \
         \"cameras\": [{{\"type\": \"perspective\", \"perspective\": {{\"yfov\": 0.5, \"znear\": 0.1}}}}], \
         \"buffers\": [{{\"uri\": \"a.bin\", \"byteLength\": {}}}], \"bufferViews\": [{}], \"accessors\": [{}], \
         \"animations\": [{{\"samplers\": [{}], \"channels\": [{}]}}]}}",
        bytes.len(),
        views.join(", "),
        accessors.join(", "),
        samplers.join(", "),
        targets.join(", ")
    );
    (json, bytes)
}

/// An animated camera of glTF, in the frame of a parent that turns, by all interpolations.
#[test]
#[cfg_attr(not(feature = "gltf"), ignore = "needs the feature gltf")]
fn cameras_of_gltf() {
    let folder = tempfile::tempdir().unwrap();
    let read = |(json, bytes): (String, Vec<u8>)| {
        std::fs::write(folder.path().join("a.gltf"), json).unwrap();
        std::fs::write(folder.path().join("a.bin"), bytes).unwrap();
        let text = text(
            r#"[camera.path]
interpolation = "linear"
unit = "2 pc"
file = "a.gltf""#,
            "",
        );
        SceneFile::parse("test.toml", "test", text, barnard_files::in_folder(folder.path(), 1 << 30)).map_err(|e| e.to_string())
    };
    // The parent turns by a quarter about y from second 1 to 3; the camera, 3 ahead of it along z, goes along.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turn: &[f32] = &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half];
    let file = read(gltf(&[(0, "rotation", "LINEAR", &[1.0, 3.0], turn)])).unwrap();
    for (time, angle) in [(0.0, 0.0f64), (0.5, 22.5), (1.0, 45.0), (2.0, 90.0)] {
        let (sin, cos) = angle.to_radians().sin_cos();
        let camera = at(&file, time).camera.clone();
        let place = DVec3::new(2.0 + 6.0 * sin, 0.0, 6.0 * cos);
        assert!(camera.position.distance(place) < 2e-6, "{time} {}", camera.position);
        assert!(camera.forward.distance(DVec3::new(-sin, 0.0, -cos)) < 1e-6, "{time} {}", camera.forward);
    }
    // A cubic from rest to rest, and a step.
    let spline: &[f32] = &[0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 3.0, 0.0, 0.0, 0.0];
    let file = read(gltf(&[(1, "translation", "CUBICSPLINE", &[0.0, 2.0], spline)])).unwrap();
    let x = |file: &SceneFile, time: f64| at(file, time).camera.position.x;
    for u in [0.0, 0.25, 0.5, 1.0f64] {
        assert!((x(&file, 2.0 * u) - 2.0 - 8.0 * (3.0 * u * u - 2.0 * u * u * u)).abs() < 1e-3, "{u} {}", x(&file, 2.0 * u));
    }
    let file = read(gltf(&[(1, "translation", "STEP", &[0.0, 2.0], &[0.0, 0.0, 3.0, 4.0, 0.0, 3.0])])).unwrap();
    assert_eq!((x(&file, 1.9), x(&file, 2.0)), (2.0, 10.0));
    // What is no path is told, and nothing of it is trusted.
    let (json, bytes) = gltf(&[(0, "rotation", "LINEAR", &[1.0, 3.0], turn)]);
    for (broken, words) in [
        (json.replace("\"count\": 2", "\"count\": 4000000000"), "outside of its buffer"),
        (json.replace("\"byteOffset\": 8", "\"byteOffset\": 4000000000"), "outside of its buffer"),
        (json.replace("\"camera\": 0, ", ""), "no animated camera"),
        (json.replace("\"node\": 0", "\"node\": 7"), "not a glTF"),
        (json.replace("5126", "5121"), "floats"),
        (json.replace("a.bin", "b.bin"), "b.bin"),
        (json.replace("a.bin", "data:application/octet-stream;base64,A?"), "base64"),
        (json.replace("\"children\": [1]", "\"children\": [0, 1]"), "cycle"),
        ("{".into(), "not a glTF"),
    ] {
        let result = read((broken.clone(), bytes.clone()));
        assert!(result.as_ref().is_err_and(|error| error.contains(words)), "{broken}: {:?}", result.map(|_| ()));
    }
    let nowhere = read(gltf(&[(0, "rotation", "LINEAR", &[1.0, f32::NAN], turn)]));
    assert!(nowhere.is_err());
}
