//! Named fields: expressions of others in any order, and turbulence on few voxels for a first look.

use barnard::memory::DEFAULT_LIMIT;
use barnard::scene::{Loader, Scene};

fn parsed(fields: &str, density: &str, loader: &Loader) -> Result<Scene, String> {
    let text = format!(
        r#"[camera]
kind = "perspective"
position = "0 0 9 pc"
field_of_view = "25 deg"
size = [8, 8]
{fields}
[dust]
density = "{density}"
scale = "1 /pc"
law = "gordon23"
"#
    );
    barnard_files::parse("fields.toml", "fields", text, loader).map_err(|e| e.to_string())
}

fn loader() -> Loader {
    barnard_files::in_folder(".", DEFAULT_LIMIT)
}

const TURBULENCE: &str = r#"[field.t]
kind = "turbulence"
voxels = 80
"#;

/// A field may be made of others, whatever stands first, and is what the formula is where it stands by itself.
#[test]
fn fields_are_made_of_fields() {
    let ball = r#"[field.ball]
kind = "sphere"
radius = "1 pc"
"#;
    let made = r#"[field.a]
kind = "expression"
formula = "2 * b + ball"
[field.b]
kind = "expression"
formula = "ball * (1 - x)"
"#;
    let loader = loader();
    let scene = parsed(&format!("{made}{ball}"), "3 * a", &loader).unwrap();
    let inline = parsed(ball, "3 * (2 * (ball * (1 - x)) + ball)", &loader).unwrap();
    let density = |scene: &Scene, x: f64| scene.dust.as_ref().unwrap().density.at(barnard::glam::dvec3(x, 0.2, -0.1));
    for x in [-0.7, 0.0, 0.4, 1.5] {
        assert!((density(&scene, x) - density(&inline, x)).abs() < 1e-12, "{x}");
    }
    assert!(density(&scene, 0.4) > 1.0 && density(&scene, 1.5) == 0.0);
    // Of a grid, it is a grid, and made once for all that ask for it.
    let gridded = parsed(
        &format!(
            r#"{TURBULENCE}[field.c]
kind = "expression"
formula = "2 * t"
"#
        ),
        "c",
        &loader,
    )
    .unwrap();
    assert_eq!(gridded.dust.as_ref().unwrap().density.grid().unwrap().lattice().dims, [80; 3]);
}

#[test]
fn what_cannot_be_made_is_refused() {
    let expression = |name: &str, formula: &str| {
        format!(
            r#"[field.{name}]
kind = "expression"
formula = "{formula}"
"#
        )
    };
    // Each of the one before, and of its neighbour.
    let nested = |levels: usize, formula: &str| -> String {
        let numbered = |i: usize| formula.replace("b0", &format!("b{i}")).replace("c0", &format!("c{i}"));
        let level = |i: usize| expression(&format!("b{}", i + 1), &numbered(i)) + &expression(&format!("c{}", i + 1), &numbered(i));
        let balls = ["a", "b0", "c0"]
            .map(|name| {
                format!(
                    r#"[field.{name}]
kind = "sphere"
radius = "1 pc"
"#
                )
            })
            .concat();
        balls + &(0..levels).map(level).collect::<String>()
    };
    for (fields, words) in [
        (expression("a", "2 * b") + &expression("b", "a + 1"), vec!["a, b", "depend on each other", "field.a"]),
        (expression("a", "a + 1"), vec!["depend on each other", "field.a"]),
        (
            expression("a", "bull + 1")
                + r#"[field.ball]
kind = "sphere"
radius = "1 pc"
"#,
            vec!["bull", "ball"],
        ),
        (
            expression("a", "1 - ball")
                + r#"[field.ball]
kind = "sphere"
radius = "1 pc"
"#,
            vec!["outside", "field.a"],
        ),
        (nested(40, "b0 + b0"), vec!["32", "field.b"]),
        (nested(20, "b0 * x + c0"), vec!["1000", "field.b"]),
        ((0..300).map(|i| expression(&format!("e{i}"), "2 * ball")).collect(), vec!["300", "256"]),
        (expression("a", "2 +"), vec!["not a valid expression", "field.a"]),
        ("[field.a]\nkind = \"expression\"\n".into(), vec!["formula"]),
        (
            r#"[field.a]
kind = "expresion"
formula = "b"
"#
            .into(),
            vec!["expresion", "expression"],
        ),
        (expression("a", "ball") + "of = \"ball\"\n", vec!["of", "formula"]),
    ] {
        let message = parsed(&fields, "a", &loader()).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    }
}

/// Read roughly, turbulence has few voxels and the scene says so, wherever it is used; once it is known whole and somebody holds
/// it, it is taken as it is.
#[test]
fn turbulence_is_rough_at_first() {
    let loader = loader();
    let fields = format!(
        r#"{TURBULENCE}[field.c]
kind = "expression"
formula = "2 * t"
"#
    );
    let edge = |scene: &Scene| scene.dust.as_ref().unwrap().density.grid().unwrap().lattice().dims[0];
    for density in ["t", "3 * t + 1", "c", "c^2"] {
        let rough = parsed(&fields, density, &loader.roughly()).unwrap();
        assert!(rough.is_rough && edge(&rough) == 64, "{density}");
        let whole = parsed(&fields, density, &loader).unwrap();
        assert!(!whole.is_rough && edge(&whole) == 80, "{density}");
        let known = parsed(&fields, density, &loader.roughly()).unwrap();
        assert!(!known.is_rough && edge(&known) == 80, "{density}");
    }
    // What has few voxels anyway, and what is not asked for, is not rough.
    let few = fields.replace("80", "48");
    assert!(!parsed(&few, "t", &loader.roughly()).unwrap().is_rough);
    assert!(
        !parsed(
            &format!(
                r#"{fields}[field.ball]
kind = "sphere"
radius = "1 pc"
"#
            ),
            "ball",
            &loader.roughly()
        )
        .unwrap()
        .is_rough
    );
}

/// What densities were made of is not made again while somebody holds them: the file may be gone. What is new needs it.
#[test]
fn files_are_not_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 4, 4), }".to_owned();
    header += &" ".repeat(117 - header.len());
    let values = (0..64).flat_map(|i| (1.0 + i as f32).to_le_bytes());
    let file: Vec<u8> = b"\x93NUMPY\x01\x00\x76\x00".iter().copied().chain(header.bytes()).chain(*b"\n").chain(values).collect();
    let path = folder.path().join("cloud.npy");
    std::fs::write(&path, &file).unwrap();
    let grid = r#"[field.cloud]
kind = "grid"
file = "cloud.npy"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
"#;
    let fields = format!(
        r#"{grid}[field.thick]
kind = "expression"
formula = "cloud^2 + cloud"
"#
    );
    let loader = barnard_files::in_folder(folder.path(), DEFAULT_LIMIT);
    let first = parsed(&fields, "0.5 * thick", &loader).unwrap();
    std::fs::remove_file(&path).unwrap();
    let density = |scene: &Scene| scene.dust.clone().unwrap().density;
    let again = parsed(&fields, "0.5 * thick", &loader).unwrap();
    assert!(std::sync::Arc::ptr_eq(&density(&first), &density(&again)));
    assert_eq!(density(&again).at(barnard::glam::DVec3::splat(-0.75)), 1.0);
    for other in ["0.5 * cloud", "2 * thick"] {
        let error = parsed(&fields, other, &loader).unwrap_err();
        assert!(error.contains("cloud.npy"), "{error}");
    }
    std::fs::write(&path, &file).unwrap();
    assert_eq!(density(&parsed(&fields, "2 * thick", &loader).unwrap()).at(barnard::glam::DVec3::splat(-0.75)), 4.0);
}
