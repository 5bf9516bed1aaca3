//! The timeline: the moment that is shown, keys of the camera, and how numbers change.

use eframe::egui::{self, Sense, Stroke, Ui, pos2, vec2};

use super::curves::{self, GRIP, diamond};
use crate::command::{Command, Commands};
use crate::model::Model;
use barnard_explorer::edit::rounded;
use barnard_explorer::tracks::{begun, possible};

/// How high the bar is [points].
const HEIGHT: f32 = 26.0;

/// Shows the timeline.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    ui.horizontal(|ui| {
        let playing = model.clock.playing;
        if ui.button(if playing { "Pause" } else { "Play" }).on_hover_text("space bar").clicked() {
            commands.push(Command::Play);
        }
        let mut time = model.clock.time;
        let label = ui.label("moment");
        let range = 0.0..=model.reach();
        let drag = egui::DragValue::new(&mut time).range(range).speed(0.02).suffix(" s").max_decimals(3).update_while_editing(false);
        if ui.add(drag).labelled_by(label.id).changed() {
            commands.push(Command::Seek(time));
        }
        let words = match model.duration().zip(model.frame_shown()) {
            Some((duration, frame)) => format!("of {} s · frame {frame}", rounded(duration, 4)),
            None => "nothing changes yet".into(),
        };
        ui.label(words);
        ui.separator();
        if ui.button("Set key").on_hover_text("set a camera key from the view at this time (K)").clicked() {
            commands.push(Command::SetKey);
        }
        let keys = model.keyframes();
        if ui.add_enabled(!keys.is_empty(), egui::Button::new("Take key away")).on_hover_text("the nearest key").clicked() {
            commands.push(Command::DropKey);
        }
        let bookmarks = model.document.scene().bookmarks.len();
        let button = ui.add_enabled(bookmarks > 1, egui::Button::new("Keys of bookmarks"));
        if button.on_hover_text("make a path along all bookmarks, three seconds each").clicked() {
            commands.push(Command::KeysOfBookmarks);
        }
        ui.menu_button("Animate", |ui| of_any(ui, model, commands))
            .response
            .on_hover_text("animate a key of the scene from its current value");
    });
    bar(ui, model, commands);
    curves::show(ui, model, commands);
}

/// The keys of the scene that could change and do not yet.
fn of_any(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let scene = model.document.scene().clone();
    let known: Vec<&str> = scene.timeline.iter().flat_map(|timeline| timeline.tracks().map(|(name, _)| name)).collect();
    let free = possible(model.document.toml().as_table()).into_iter().filter(|(name, _)| !known.contains(&name.as_str()));
    egui::ScrollArea::vertical().max_height(400.0).show(ui, |ui| {
        for (name, value) in free {
            if ui.button(&name).on_hover_text(value.to_string()).clicked() {
                // What takes no fractions, or is a name that begins with a digit, holds from key to key.
                let begin = |holds| begun(&name, value.clone(), model.clock.time, holds);
                let holds = model.document.variant(begin(false)).is_err();
                commands.push(begin(holds));
            }
        }
    });
}

/// The bar that is scrubbed, with a mark at each key.
fn bar(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, "timeline"));
    let duration = model.reach();
    let at = |time: f64| rect.left() + (time / duration) as f32 * rect.width();
    let painter = ui.painter().with_clip_rect(rect.expand(2.0));
    let visuals = ui.visuals();
    painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
    // A line each second, or each ten.
    let every = [1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0].into_iter().find(|every| duration / every < 40.0).unwrap_or(600.0);
    let weak = visuals.weak_text_color();
    for i in 0..=(duration / every) as usize {
        let x = at(every * i as f64);
        painter.vline(x, rect.top() + 0.7 * HEIGHT..=rect.bottom(), Stroke::new(1.0, weak));
        painter.text(
            pos2(x + 2.0, rect.bottom()),
            egui::Align2::LEFT_BOTTOM,
            rounded(every * i as f64, 4),
            egui::FontId::proportional(9.0),
            weak,
        );
    }
    // What lies behind the end is dim.
    let end = egui::Rect::from_min_max(pos2(at(model.duration().unwrap_or(duration)), rect.top()), rect.max);
    painter.rect_filled(end, 0.0, visuals.panel_fill.gamma_multiply(0.7));
    let keys = model.keyframes();
    for key in &keys {
        diamond(&painter, pos2(at(*key), rect.top() + 0.32 * HEIGHT));
    }
    painter.vline(at(model.clock.time), rect.y_range(), Stroke::new(2.0, visuals.strong_text_color()));
    if let (true, Some(pointer)) = (response.dragged() || response.clicked(), response.interact_pointer_pos()) {
        let time = f64::from((pointer.x - rect.left()) / rect.width()).clamp(0.0, 1.0) * duration;
        // A click beside a key means the key, another place the nearest frame.
        let near = keys.iter().copied().find(|key| (at(*key) - pointer.x).abs() < GRIP);
        commands.push(Command::Seek(near.filter(|_| response.clicked()).unwrap_or_else(|| model.nearest_frame(time))));
    }
}
