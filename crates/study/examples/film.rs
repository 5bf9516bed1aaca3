//! Writes docs/gas_film.png: the built-in H II region while its star heats up, from 20 to 50 kK at one luminosity. All frames
//! have the same colours and the same white.
//!
//! `cargo run --release -p barnard-study --example film`

use barnard::backend::cpu;
use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Plan};
use barnard_files::builtin;
use barnard_files::formats::{encode_png, replace};

/// Temperatures of the star \[kK\], three frames in a row.
const TEMPERATURES: [u32; 6] = [20, 25, 30, 35, 40, 50];
const IN_A_ROW: usize = 3;
/// Pixels along the edge of a frame.
const EDGE: usize = 360;
/// Voxels along an edge: fewer than the scene's own show no less at this size.
const VOXELS: usize = 192;
/// [S II] red, Hα green and red, [O III] blue, about as bright as each other at 35 kK.
const DISPLAY: &str =
    "[display]\nmatrix = [0, 0.15, 1.0, 0, 0.22, 0.0, 2.4, 0.35, 0]\nstretch = \"asinh\"\nstrength = 12\nwhite = 1.5e-6\n";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = builtin::entry("hii_region")?.text;
    let (before, rest) = scene.split_once("[display]").ok_or("the scene has a display")?;
    let (_, after) = rest.split_once("\n[").ok_or("and a method")?;
    let scene = format!("{before}{DISPLAY}[{after}").replace("voxels = 256", &format!("voxels = {VOXELS}"));
    let scene = scene.replace("size = [768, 768]", &format!("size = [{EDGE}, {EDGE}]"));
    let width = EDGE * IN_A_ROW;
    let mut pixels = vec![0; 3 * width * EDGE * TEMPERATURES.len().div_ceil(IN_A_ROW)];
    for (frame, temperature) in TEMPERATURES.into_iter().enumerate() {
        let text = scene.replace("\"35000 K\"", &format!("\"{temperature}000 K\""));
        let scene = barnard_files::parse("film", "film", text, &builtin::loader(DEFAULT_LIMIT))?;
        let control = Control::default();
        let plan = Plan::new(&scene, &Options::within(DEFAULT_LIMIT), &control)?;
        let (image, _) = cpu::render(&scene, &plan, &control)?;
        let corner = (frame / IN_A_ROW * EDGE * width + frame % IN_A_ROW * EDGE) * 3;
        for (row, bytes) in scene.display.tone(&image).bytes(&image).chunks(EDGE).enumerate() {
            let at = corner + 3 * row * width;
            pixels[at..at + 3 * EDGE].copy_from_slice(bytes.as_flattened());
        }
        println!("{temperature} kK: {}", scene.gas.iter().flat_map(|gas| gas.told()).collect::<Vec<_>>().join("; "));
    }
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/gas_film.png");
    let notes = [("Description".into(), "The built-in H II region, its star at 20, 25, 30, 35, 40 and 50 kK".into())];
    replace(&path, &encode_png((width, pixels.len() / 3 / width), &pixels, &notes)?)?;
    Ok(())
}
