//! How fast the explorer answers, and whether it keeps its memory: `cargo bench -p barnard-viewer [-- FRAMES] [gpu]`.
//!
//! Previews are counted at 640 × 360 of the reflection nebula beside this file, as the worker makes them while somebody moves;
//! frames of edits go through the whole window, without a screen. With `gpu` the worker has a graphics processor.

use std::time::{Duration, Instant};

use barnard::backend::cpu;
use barnard_explorer::document::Document;
use barnard_explorer::edit::{Edit, place_text, significant};
use barnard_explorer::flight::Flight;
use barnard_explorer::order::{Order, Refinement, View};
use barnard_gpu::Gpu;
use barnard_viewer::app::App;
use barnard_viewer::engine::Engine;
use barnard_viewer::session::Session;
use eframe::egui::vec2;
use egui_kittest::Harness;

const LIMIT: u64 = 8 << 30;
const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/reflection_nebula.toml");
/// Duration of the preview count [s].
const COUNTED: f64 = 5.0;

/// The edit of a frame, for a star that stood there.
type Change = fn(usize, barnard::glam::DVec3) -> Edit;

fn main() {
    let started = Instant::now();
    let document = Document::open(SCENE.as_ref(), LIMIT).expect("the scene beside this bench");
    let engine = Engine::start(cpu::ENTRY, None, || ());
    if std::env::args().any(|a| a == "gpu") {
        let gpu = Gpu::open().expect("a graphics adapter");
        println!("on {}", gpu.adapter.name);
        engine.lend(gpu);
    }
    let mut flight = Flight::of(document.scene());
    first_picture(&engine, &document, &flight, started);
    let star = document.scene().stars[0].position;
    previews(&engine, "orbit", document, |_, _, flight| flight.orbit(0.004, 0.0), &mut flight);
    let edits: [(&str, Change); 4] = [
        ("temperature of a star", |i, _| Edit::set("star.0", "temperature", format!("{} K", 8000 + 100 * (i % 200)))),
        ("place of a star", |i, p| Edit::set("star.0", "position", place_text(p + 0.002 * (i % 100) as f64, 1.0))),
        ("scale of the dust", |i, _| Edit::set("dust", "scale", format!("{} mag/pc", significant(4.0 + 0.05 * (i % 100) as f64)))),
        ("stretch", |i, _| Edit::set("display", "strength", 20.0 + (i % 100) as f64)),
    ];
    for (name, edit) in edits {
        let document = Document::open(SCENE.as_ref(), LIMIT).expect("the scene beside this bench");
        let change = |i: usize, d: &mut Document, _: &mut Flight| d.apply(edit(i, star)).expect("an edit that a scene can have");
        let mut flight = Flight::of(document.scene());
        previews(&engine, name, document, change, &mut flight);
    }
    drop(engine);
    let frames = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(2000);
    soak(frames);
}

fn order(document: &Document, flight: &Flight) -> Order {
    let view = View::of(document);
    Order {
        views: vec![view],
        camera: flight.seen((640, 360)),
        moving: true,
        settles: true,
        difference: false,
        exposure: 0,
        memory_limit: LIMIT,
    }
}

/// Waits for the frame of an order.
fn wait(engine: &Engine, number: u64) -> Refinement {
    loop {
        if let Some(frame) = engine.frames().find(|f| f.number == number) {
            frame.pictures.expect("a picture");
            return frame.quality;
        }
        std::thread::sleep(Duration::from_micros(300));
    }
}

fn first_picture(engine: &Engine, document: &Document, flight: &Flight, started: Instant) {
    wait(engine, engine.submit(order(document, flight)));
    println!("first picture of {SCENE}: {:.2} s after the scene was asked for", started.elapsed().as_secs_f64());
}

fn previews(engine: &Engine, name: &str, mut document: Document, change: impl Fn(usize, &mut Document, &mut Flight), flight: &mut Flight) {
    wait(engine, engine.submit(order(&document, flight)));
    let (start, mut frames, mut slowest) = (Instant::now(), 0, 0.0f64);
    while start.elapsed().as_secs_f64() < COUNTED {
        let one = Instant::now();
        change(frames, &mut document, flight);
        wait(engine, engine.submit(order(&document, flight)));
        slowest = slowest.max(one.elapsed().as_secs_f64());
        frames += 1;
    }
    let rate = frames as f64 / start.elapsed().as_secs_f64();
    println!("{name}: {rate:.1} previews/s at 640 x 360, slowest {:.0} ms", 1e3 * slowest);
}

/// Memory that the process has [MiB]; NaN where nobody tells.
fn resident() -> f64 {
    let read = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/self/statm").ok()?;
        Some(text.split(' ').nth(1)?.parse::<f64>().ok()? * 4096.0 / f64::from(1 << 20))
    };
    read().unwrap_or(f64::NAN)
}

/// Frames of the whole window, each with an edit.
fn soak(frames: usize) {
    let document = Document::open(SCENE.as_ref(), LIMIT).expect("the scene beside this bench");
    let app = App::new(document, Engine::start(cpu::ENTRY, None, || ()), Session::new(None), LIMIT);
    let mut harness =
        Harness::builder().with_size(vec2(900.0, 360.0)).with_max_steps(1).build_ui_state(|ui, app: &mut App| app.ui(ui), app);
    let start = Instant::now();
    for i in 0..=frames {
        let app = harness.state_mut();
        app.model.apply(Edit::set("star.0", "temperature", format!("{} K", 8000 + i % 9000)));
        app.model.apply(Edit::set("dust", "scale", format!("{} mag/pc", significant(4.0 + 0.05 * (i % 100) as f64))));
        app.model.document.rest();
        app.model.flight.orbit(0.01, 0.001);
        harness.step();
        if i % (frames / 10).max(1) == 0 {
            println!("{i} frames of edits: {:.0} MiB, {:.0} s", resident(), start.elapsed().as_secs_f64());
        }
    }
}
