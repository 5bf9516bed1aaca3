//! Writes docs/gas_film.png: the built-in emission nebula while its star heats up, from 20 to 50 kK at one luminosity. All frames
//! have the same colours and the same white.
//!
//! `cargo run --release -p barnard-study --example film`

use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner};
use barnard_files::builtin;
use barnard_files::formats::{encode_png, replace};

/// Temperatures of the star \[kK\], three frames in a row.
const TEMPERATURES: [u32; 6] = [20, 25, 30, 35, 40, 50];
const IN_A_ROW: usize = 3;
/// Pixels of a frame, columns and rows.
const SIZE: (usize, usize) = (480, 270);
/// [S II] red, Hα green and red, [O III] blue, about as bright as each other at 35 kK.
const DISPLAY: &str = "[display]\nmatrix = [0, 0.12, 0.6, 0, 0.2, 0.0, 4.0, 0.3, 0]\nstretch = \"asinh\"\nstrength = 12\nwhite = 8e-6\n";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = builtin::entry("emission_nebula")?.text;
    let (before, rest) = scene.split_once("[display]").ok_or("the scene has a display")?;
    let (_, after) = rest.split_once("\n[method]").ok_or("and a method")?;
    let scene = format!("{before}{DISPLAY}[method]{after}");
    let scene = scene.replace("size = [1920, 1080]", &format!("size = [{}, {}]", SIZE.0, SIZE.1));
    let width = SIZE.0 * IN_A_ROW;
    let mut pixels = vec![0; 3 * width * SIZE.1 * TEMPERATURES.len().div_ceil(IN_A_ROW)];
    for (frame, temperature) in TEMPERATURES.into_iter().enumerate() {
        let text = scene.replace("\"38000 K\"", &format!("\"{temperature}000 K\""));
        let scene = barnard_files::parse("film", "film", text, &builtin::loader(DEFAULT_LIMIT))?;
        let control = Control::default();
        let plan = Planner::new(&Options::within(DEFAULT_LIMIT)).plan(&scene, None, &control)?;
        let (image, _) = Renderer::new(&mut cpu::Cpu).render(&plan, &control)?;
        let corner = (frame / IN_A_ROW * SIZE.1 * width + frame % IN_A_ROW * SIZE.0) * 3;
        for (row, bytes) in scene.display.tone(&image).bytes(&image).chunks(SIZE.0).enumerate() {
            let at = corner + 3 * row * width;
            pixels[at..at + 3 * SIZE.0].copy_from_slice(bytes.as_flattened());
        }
        println!("{temperature} kK: {}", scene.ionised().iter().flat_map(|gas| gas.notes()).collect::<Vec<_>>().join("; "));
    }
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/gas_film.png");
    let notes = [("Description".into(), "The built-in emission nebula, its star at 20, 25, 30, 35, 40 and 50 kK".into())];
    replace(&path, &encode_png((width, pixels.len() / 3 / width), &pixels, &notes)?)?;
    Ok(())
}
