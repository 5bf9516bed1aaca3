//! Curves of the timeline: how each value that has keys changes, and its keys, which are dragged.

use barnard::animation::{Timeline, Track};
use eframe::egui::{self, Color32, Id, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::command::{Command, Commands};
use crate::model::Model;
use barnard_explorer::edit::rounded;
use barnard_explorer::tracks::{added, dropped, moved};

/// How high a curve is, and how high all of them are before they scroll [points].
const HEIGHT: f32 = 44.0;
const MOST: f32 = 180.0;
/// Points between places of a curve.
const STEP: f32 = 3.0;
/// Grab radius of a keyframe [points].
pub(super) const GRIP: f32 = 6.0;
/// The least time between two keys [s].
const APART: f64 = 1e-3;
/// Colours of the numbers of a value, as of x, y and z.
const COLOURS: [Color32; 3] = [Color32::from_rgb(240, 120, 110), Color32::from_rgb(120, 210, 120), Color32::from_rgb(120, 170, 255)];

/// Shows the curves of all that changes.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let scene = model.document.scene().clone();
    let Some(timeline) = &scene.timeline else { return };
    let count = usize::from(timeline.has_path()) + timeline.tracks().count();
    if count == 0 {
        return;
    }
    // The panel is as high as it needs to be, up to that.
    let high = (count as f32 * (HEIGHT + ui.spacing().item_spacing.y)).min(MOST);
    egui::ScrollArea::vertical().id_salt("curves").max_height(high).min_scrolled_height(high).show(ui, |ui| {
        if timeline.has_path() {
            way(ui, model, timeline, commands);
        }
        for (i, (name, track)) in timeline.tracks().enumerate() {
            curve(ui, model, (i, name, track), commands);
        }
    });
}

/// The mark of a key.
pub(super) fn diamond(painter: &Painter, at: Pos2) {
    let points = [vec2(0.0, -GRIP), vec2(GRIP, 0.0), vec2(0.0, GRIP), vec2(-GRIP, 0.0)].map(|v| at + v).to_vec();
    painter.add(Shape::convex_polygon(points, Color32::from_rgb(120, 200, 255), Stroke::NONE));
}

/// A strip as long as the bar, with lines by the moments of its width: its rectangle, and what the pointer does there.
struct LaneStrip {
    rect: Rect,
    response: egui::Response,
    duration: f64,
    /// The least and the largest of the numbers that are drawn.
    range: (f64, f64),
}

impl LaneStrip {
    fn new(ui: &mut Ui, model: &Model, label: &str, numbers: impl Fn(f64) -> Option<Vec<f64>>) -> Self {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, label));
        let duration = model.reach();
        let count = (rect.width() / STEP).ceil().max(2.0) as usize;
        let times: Vec<f64> = (0..=count).map(|i| duration * i as f64 / count as f64).collect();
        let dims = numbers(0.0).map_or(0, |value| value.len());
        // What a track says from one key on may be another kind of value than before.
        let alike = |time: &f64| numbers(*time).filter(|value| value.len() == dims);
        let values: Vec<Vec<f64>> = times.iter().map_while(alike).collect();
        let range = values.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let strip = Self { rect, response, duration, range };
        let visuals = ui.visuals();
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
        for component in 0..dims {
            let place = |(time, value): (&f64, &Vec<f64>)| pos2(strip.x(*time), strip.y(value[component]));
            let colour = if dims == 1 { visuals.strong_text_color() } else { COLOURS[component % COLOURS.len()] };
            painter.add(Shape::line(times.iter().zip(&values).map(place).collect(), Stroke::new(1.2, colour)));
        }
        let font = egui::FontId::proportional(10.0);
        painter.text(rect.left_top() + vec2(4.0, 2.0), egui::Align2::LEFT_TOP, label, font, visuals.text_color());
        painter.vline(strip.x(model.clock.time), rect.y_range(), Stroke::new(1.0, visuals.weak_text_color()));
        strip
    }

    fn x(&self, time: f64) -> f32 {
        self.rect.left() + (time / self.duration) as f32 * self.rect.width()
    }

    /// Position of a number: below the words, and a little above the lower edge.
    fn y(&self, value: f64) -> f32 {
        let (low, high) = self.range;
        let part = if high > low { (value - low) / (high - low) } else { 0.5 };
        self.rect.bottom() - 4.0 - part as f32 * (HEIGHT - 22.0)
    }

    /// The moment at a place.
    fn time(&self, x: f32) -> f64 {
        f64::from((x - self.rect.left()) / self.rect.width()).clamp(0.0, 1.0) * self.duration
    }

    /// The number for each point upwards.
    fn a_point(&self) -> f64 {
        let (low, high) = self.range;
        let span = if high > low { high - low } else { low.abs().max(1.0) };
        span / f64::from(HEIGHT - 22.0)
    }
}

/// A key that is dragged, and what was so when it was taken hold of: scales follow the key, and texts round it.
#[derive(Clone, Copy)]
struct DraggedKey {
    key: usize,
    /// Its number, where it has one that may be between others, and the number for each point upwards.
    number: Option<f64>,
    a_point: f64,
    /// The time of the whole strip \[s\].
    duration: f64,
}

/// Points that the pointer goes up or down before a key's value goes with it.
const STIFF: f32 = 3.0;

/// The numbers of a value, and its unit.
fn words(numbers: &[f64], unit: &str) -> String {
    let numbers: Vec<String> = numbers.iter().map(|v| rounded(*v, 4)).collect();
    format!("{} {unit}", numbers.join(" "))
}

/// Path of the camera; its keys are those of the bar.
fn way(ui: &mut Ui, model: &Model, timeline: &Timeline, commands: &mut Commands) {
    let numbers = |time| timeline.position(time).map(|p| p.to_array().to_vec());
    let now = numbers(model.clock.time).map_or_else(String::new, |place| words(&place, "pc"));
    let strip = LaneStrip::new(ui, model, &format!("camera.position   {now}"), numbers);
    scrub(&strip, commands);
}

/// Goes to the moment that the pointer is at.
fn scrub(strip: &LaneStrip, commands: &mut Commands) {
    if let (true, Some(pointer)) = (strip.response.dragged() || strip.response.clicked(), strip.response.interact_pointer_pos()) {
        commands.push(Command::Seek(strip.time(pointer.x)));
    }
}

/// The curve of a track. A key is dragged; a double click adds one, a right click takes one away.
fn curve(ui: &mut Ui, model: &Model, (track, name, values): (usize, &str, &Track), commands: &mut Commands) {
    let now = values.numbers(model.clock.time).map_or_else(|| values.at(model.clock.time).to_string(), |v| words(&v, values.unit()));
    let strip = LaneStrip::new(ui, model, &format!("{name}   {now}"), |time| values.numbers(time));
    let times = values.times();
    let middle = strip.rect.center().y;
    let place = |key: usize| {
        let one = values.numbers(times[key]).filter(|v| v.len() == 1);
        pos2(strip.x(times[key]), one.map_or(middle, |v| strip.y(v[0])))
    };
    let painter = ui.painter().with_clip_rect(strip.rect.expand(2.0));
    (0..times.len()).for_each(|key| diamond(&painter, place(key)));
    strip.response.clone().on_hover_text("drag a key; double click adds one, right click deletes one");
    // Of two at one place the last one, which can go on.
    let away = |key: &usize, x: f32| (place(*key).x - x).abs();
    let nearest = |x: f32| (0..times.len()).rev().min_by(|a, b| away(a, x).total_cmp(&away(b, x))).filter(|key| away(key, x) < GRIP);
    let drag_id = Id::unique(("key held", track));
    let Some(pointer) = strip.response.interact_pointer_pos() else { return };
    let began = ui.input(|i| i.pointer.press_origin()).unwrap_or(pointer);
    if strip.response.drag_started() {
        let number = |key: usize| match values {
            Track::Numbers(_) => values.numbers(times[key]).filter(|v| v.len() == 1).map(|v| v[0]),
            Track::Said(_) => None,
        };
        let dragged = |key| DraggedKey { key, number: number(key), a_point: strip.a_point(), duration: strip.duration };
        let taken = nearest(began.x).map(dragged);
        ui.data_mut(|data| data.insert_temp(drag_id, taken));
    }
    let taken = ui.data(|data| data.get_temp::<Option<DraggedKey>>(drag_id)).flatten().filter(|drag| drag.key < times.len());
    let edit = if strip.response.secondary_clicked() {
        nearest(pointer.x).map(|key| dropped(track, key))
    } else if strip.response.double_clicked() {
        let time = (1e3 * strip.time(pointer.x)).round() / 1e3;
        let is_free = times.iter().all(|known| (known - time).abs() >= APART);
        is_free.then(|| added(track, times.partition_point(|known| *known < time), time, &values.at(time)))
    } else if let (true, Some(DraggedKey { key, number, a_point, duration })) = (strip.response.dragged(), taken) {
        let least = if key > 0 { times[key - 1] + APART } else { 0.0 };
        let most = times.get(key + 1).map_or(duration, |next| next - APART);
        let time = (1e3 * strip.time(pointer.x) * duration / strip.duration).round() / 1e3;
        let up = began.y - pointer.y;
        let number = number.filter(|_| up.abs() >= STIFF).map(|number| number + a_point * f64::from(up));
        Some(moved(track, key, time.clamp(least, most.max(least)), number))
    } else {
        scrub(&strip, commands);
        None
    };
    if let Some(edit) = edit {
        commands.push(edit);
    }
}
