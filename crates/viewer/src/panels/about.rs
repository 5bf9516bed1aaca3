//! Mouse and keyboard input.

use eframe::egui::{self, Context};

/// The things that a person can do, and how.
const KEYS: &[(&str, &str)] = &[
    ("Orbit", "drag"),
    ("Pan", "Shift + drag, or middle drag"),
    ("Look around", "right drag"),
    ("Nearer, further", "wheel"),
    ("Wider, narrower", "Ctrl + wheel, or ] ["),
    ("Fly", "W A S D, R up, F down; , . roll; wheel: speed"),
    ("Frame all", "Home"),
    ("Fly into the cloud", "V"),
    ("Brighter, darker", "E + wheel, or + -"),
    ("Automatic exposure", "0"),
    ("Stars and frame", "M"),
    ("Frame guide", "G"),
    ("Timeline", "T; space plays, K sets a key of the camera"),
    ("Full screen", "F11"),
    ("Screenshot", "F12, into the working folder"),
    ("Select, move a star", "click it, drag it"),
    ("Bookmarks", "Ctrl + 1 … 9 sets, 1 … 9 opens"),
    ("Open, save, save as", "Ctrl + O, Ctrl + S, Ctrl + Shift + S"),
    ("Save the picture", "Ctrl + E"),
    ("Undo, redo", "Ctrl + Z, Ctrl + Shift + Z"),
    ("Quit", "Ctrl + Q"),
    ("This list", "F1"),
];

/// The list of keys, while it is open.
pub fn help(ctx: &Context, open: &mut bool) {
    egui::Window::new("Mouse and keys").open(open).resizable(false).show(ctx, |ui| {
        egui::Grid::new("help").num_columns(2).striped(true).spacing([20.0, 4.0]).show(ui, |ui| {
            for (what, how) in KEYS {
                ui.label(*what);
                ui.monospace(*how);
                ui.end_row();
            }
        });
        ui.separator();
        ui.label("Drag numbers, or click to type. Hover over a name for its meaning and unit.");
    });
}
