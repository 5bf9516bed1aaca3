//! Named fields: expressions of others in any order, and turbulence on few voxels for a first look.

use barnard::memory::DEFAULT_LIMIT;
use barnard::scene::{Loader, Scene};

fn parsed(fields: &str, density: &str, loader: &Loader) -> Result<Scene, String> {
    let text = format!(
        "[camera]\nkind = \"perspective\"\nposition = \"0 0 9 pc\"\nfield_of_view = \"25 deg\"\nsize = [8, 8]\n{fields}\n\
         [dust]\ndensity = \"{density}\"\nscale = \"1 /pc\"\nlaw = \"gordon23\"\n"
    );
    barnard_files::parse("fields.toml", "fields", text, loader).map_err(|e| e.to_string())
}

fn loader() -> Loader {
    barnard_files::in_folder(".", DEFAULT_LIMIT)
}

const TURBULENCE: &str = "[field.t]\nkind = \"turbulence\"\nvoxels = 80\n";

/// A field may be made of others, whatever stands first, and is what the formula is where it stands by itself.
#[test]
fn fields_are_made_of_fields() {
    let ball = "[field.ball]\nkind = \"sphere\"\nradius = \"1 pc\"\n";
    let made =
        "[field.a]\nkind = \"expression\"\nformula = \"2 * b + ball\"\n[field.b]\nkind = \"expression\"\nformula = \"ball * (1 - x)\"\n";
    let loader = loader();
    let scene = parsed(&format!("{made}{ball}"), "3 * a", &loader).unwrap();
    let inline = parsed(ball, "3 * (2 * (ball * (1 - x)) + ball)", &loader).unwrap();
    let density = |scene: &Scene, x: f64| scene.dust.as_ref().unwrap().density.at(barnard::glam::dvec3(x, 0.2, -0.1));
    for x in [-0.7, 0.0, 0.4, 1.5] {
        assert!((density(&scene, x) - density(&inline, x)).abs() < 1e-12, "{x}");
    }
    assert!(density(&scene, 0.4) > 1.0 && density(&scene, 1.5) == 0.0);
    // Of a grid, it is a grid, and made once for all that ask for it.
    let gridded = parsed(&format!("{TURBULENCE}[field.c]\nkind = \"expression\"\nformula = \"2 * t\"\n"), "c", &loader).unwrap();
    assert_eq!(gridded.dust.unwrap().density.grid().unwrap().lattice().dims, [80; 3]);
}

#[test]
fn what_cannot_be_made_is_refused() {
    let expression = |name: &str, formula: &str| format!("[field.{name}]\nkind = \"expression\"\nformula = \"{formula}\"\n");
    // Each of the one before, and of its neighbour.
    let nested = |levels: usize, formula: &str| -> String {
        let of = |i: usize| formula.replace("b0", &format!("b{i}")).replace("c0", &format!("c{i}"));
        let level = |i: usize| expression(&format!("b{}", i + 1), &of(i)) + &expression(&format!("c{}", i + 1), &of(i));
        let balls = ["a", "b0", "c0"].map(|name| format!("[field.{name}]\nkind = \"sphere\"\nradius = \"1 pc\"\n")).concat();
        balls + &(0..levels).map(level).collect::<String>()
    };
    for (fields, words) in [
        (expression("a", "2 * b") + &expression("b", "a + 1"), vec!["a, b", "need each other", "field.a"]),
        (expression("a", "a + 1"), vec!["need each other", "field.a"]),
        (expression("a", "bull + 1") + "[field.ball]\nkind = \"sphere\"\nradius = \"1 pc\"\n", vec!["bull", "ball"]),
        (expression("a", "1 - ball") + "[field.ball]\nkind = \"sphere\"\nradius = \"1 pc\"\n", vec!["outside", "field.a"]),
        (nested(40, "b0 + b0"), vec!["32", "field.b"]),
        (nested(20, "b0 * x + c0"), vec!["1000", "field.b"]),
        ((0..300).map(|i| expression(&format!("e{i}"), "2 * ball")).collect(), vec!["300", "256"]),
        (expression("a", "2 +"), vec!["no expression", "field.a"]),
        ("[field.a]\nkind = \"expression\"\n".into(), vec!["formula"]),
        ("[field.a]\nkind = \"expresion\"\nformula = \"b\"\n".into(), vec!["expresion", "expression"]),
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
    let fields = format!("{TURBULENCE}[field.c]\nkind = \"expression\"\nformula = \"2 * t\"\n");
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
    assert!(!parsed(&format!("{fields}[field.ball]\nkind = \"sphere\"\nradius = \"1 pc\"\n"), "ball", &loader.roughly()).unwrap().is_rough);
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
    let grid = "[field.cloud]\nkind = \"grid\"\nfile = \"cloud.npy\"\nlow = \"-1 -1 -1 pc\"\nhigh = \"1 1 1 pc\"\n";
    let fields = format!("{grid}[field.thick]\nkind = \"expression\"\nformula = \"cloud^2 + cloud\"\n");
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
