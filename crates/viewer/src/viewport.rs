//! The middle of the window: the picture, what lies over it, and the hands that move it.

use barnard::camera::Camera;
use barnard::glam::DVec3;
use eframe::egui::{
    self, Align2, Color32, Context, Event, FontId, Key, Modifiers, PointerButton, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2,
};

use crate::command::{Command, Commands};
use crate::layout::{Guide, Side};
use crate::model::Model;
use crate::panels::reveal;
use barnard_explorer::comparison::{Arrangement, With};
use barnard_explorer::edit::{Edit, place_text};
use barnard_explorer::order::AMPLIFIED;
use barnard_explorer::order::Refinement;

/// Most pixels along an edge of a picture in the window.
const MAX: f32 = 4096.0;
/// The distance within which the pointer takes hold of something [points].
const GRIP: f32 = 10.0;
/// Most names of stars of a catalogue, the brightest.
const NAMES: usize = 100;
/// Change of distance, and of brightness in stops, in one point of the wheel.
const WHEEL: f64 = 0.003;
const STOPS: f64 = 0.01;

/// The thing that the pointer holds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Hold {
    #[default]
    Nothing,
    /// The view: around what it shows, across it, or the eye itself.
    Orbit,
    Pan,
    Look,
    Star(usize),
    Edge,
}

/// The state of the middle of the window between frames.
#[derive(Default)]
pub struct Viewport {
    /// The size in pixels; none before it was shown.
    pub pixels: Option<(usize, usize)>,
    hold: Hold,
    /// The place to which what it holds has been brought.
    held_at: Option<Pos2>,
    flying: bool,
    /// A key of flight was pressed as part of a command, and is still down: S of Ctrl+S, held longer than Ctrl.
    grounded: bool,
}

impl Viewport {
    /// True if a hand is on the view.
    pub fn is_moving(&self) -> bool {
        self.hold != Hold::Nothing || self.flying
    }

    /// Keys are for something else.
    pub fn land(&mut self) {
        self.flying = false;
    }
}

/// Draws the pictures and lets them be moved.
pub fn show(ui: &mut Ui, hand: &mut Viewport, model: &Model, commands: &mut Commands) {
    let area = ui.available_rect_before_wrap();
    let scale = ui.ctx().pixels_per_point();
    let edge = |points: f32| (points * scale).round().clamp(16.0, MAX) as usize;
    let halves = if side_by_side(model) { 2.0 } else { 1.0 };
    let rect = if model.layout.fills { area } else { framed(area, halves * aspect(&model.flight.camera)) };
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "picture"));
    hand.pixels = Some((edge(rect.width() / halves), edge(rect.height())));
    draw(ui, model, rect);
    let seen = if side_by_side(model) { rect.split_left_right_at_fraction(0.5).0 } else { rect };
    if let Some(sparks) = model.shown.as_ref().and_then(|shown| shown.sparks.as_ref()) {
        ui.painter().with_clip_rect(seen).image(sparks.id(), seen, WHOLE, Color32::WHITE);
    }
    hands(ui, hand, model, &response, (rect, seen), commands);
    if let Some(star) = model.selected.and_then(|i| model.document.stars().get(i)) {
        ring(&ui.painter().with_clip_rect(seen), on_screen(hand, model, seen, star.position), &star.name);
    }
    if model.layout.overlay {
        overlay(ui, hand, model, seen);
    }
    guide(ui, model.layout.guide, seen);
    labels(ui, model, rect);
}

/// Width of a camera's picture, of its height.
pub fn aspect(camera: &Camera) -> f32 {
    camera.width as f32 / camera.height as f32
}

/// The largest rectangle of a given width, of its height, in the middle of an area.
pub fn framed(area: Rect, aspect: f32) -> Rect {
    let width = area.width().min(area.height() * aspect);
    Rect::from_center_size(area.center(), vec2(width, width / aspect))
}

fn side_by_side(model: &Model) -> bool {
    model.comparison.is_of_pictures() && model.comparison.arrangement == Arrangement::SideBySide
}

/// The whole of a texture.
const WHOLE: Rect = Rect { min: Pos2::ZERO, max: pos2(1.0, 1.0) };

/// Draws the pictures that are there, or the black before them.
fn draw(ui: &Ui, model: &Model, rect: Rect) {
    let painter = ui.painter().with_clip_rect(rect);
    let textures = model.shown.as_ref().map_or(&[][..], |shown| &shown.textures);
    match (&model.comparison.with, textures) {
        (With::Nothing, [texture, ..]) | (_, [texture]) => painter.image(texture.id(), rect, WHOLE, Color32::WHITE),
        (_, [first, other]) if side_by_side(model) => {
            let (left, right) = rect.split_left_right_at_fraction(0.5);
            painter.image(first.id(), left, WHOLE, Color32::WHITE);
            painter.image(other.id(), right, WHOLE, Color32::WHITE)
        }
        (_, [first, other]) => {
            let x = model.comparison.edge.unwrap_or(0.5);
            let (left, right) = rect.split_left_right_at_fraction(x);
            painter.image(first.id(), left, Rect::from_min_max(WHOLE.min, pos2(x, 1.0)), Color32::WHITE);
            painter.image(other.id(), right, Rect::from_min_max(pos2(x, 0.0), WHOLE.max), Color32::WHITE);
            painter.vline(left.right(), rect.y_range(), Stroke::new(1.5, Color32::from_white_alpha(160)))
        }
        _ => painter.rect_filled(rect, 0.0, Color32::BLACK),
    };
}

/// Does what the mouse says.
fn hands(ui: &Ui, hand: &mut Viewport, model: &Model, response: &egui::Response, (rect, seen): (Rect, Rect), commands: &mut Commands) {
    let ctx = ui.ctx();
    let pointer = response.hover_pos().filter(|p| seen.contains(*p));
    let part = |p: Pos2| (f64::from((p.x - seen.left()) / seen.width()), f64::from((p.y - seen.top()) / seen.height()));
    if pointer.map(part) != model.pointer {
        commands.push(Command::Point(pointer.map(part)));
    }
    if response.drag_started() {
        hand.held_at = ctx.input(|i| i.pointer.press_origin());
        let shift = ctx.input(|i| i.modifiers.shift);
        let by = |button| response.dragged_by(button);
        hand.hold = match hand.held_at {
            Some(origin) if by(PointerButton::Primary) && !shift => grip(hand, model, rect, seen, origin),
            _ if by(PointerButton::Secondary) => Hold::Look,
            _ => Hold::Pan,
        };
    }
    // The frame that receives the end receives the last movement as well.
    if let (true, Some(from), Some(to)) = (response.dragged() || response.drag_stopped(), hand.held_at, response.interact_pointer_pos()) {
        hand.held_at = Some(to);
        let way = (to - from) / seen.width();
        let (right, down) = (f64::from(way.x), f64::from(way.y));
        match hand.hold {
            Hold::Nothing => {}
            Hold::Orbit => commands.fly(move |flight| flight.orbit(right, down)),
            Hold::Pan => commands.fly(move |flight| flight.pan(right, down)),
            Hold::Look => commands.fly(move |flight| flight.look(right, down)),
            Hold::Star(star) => move_star((hand, model), star, seen, to, commands),
            Hold::Edge => {
                let edge = model.comparison.edge.unwrap_or(0.5) + (to - from).x / rect.width();
                commands.push(Command::MoveEdge(edge.clamp(0.02, 0.98)));
            }
        }
    }
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.clicked()) {
        select(ctx, grip(hand, model, rect, seen, pointer), model, commands);
    }
    if response.drag_stopped() || !ctx.input(|i| i.pointer.any_down()) {
        (hand.hold, hand.held_at) = (Hold::Nothing, None);
    }
    if response.hovered() {
        wheel(ctx, hand, model, commands);
    }
    response.clone().on_hover_cursor(match pointer.map(|p| grip(hand, model, rect, seen, p)) {
        Some(Hold::Star(_)) => egui::CursorIcon::Grab,
        Some(Hold::Edge) => egui::CursorIcon::ResizeHorizontal,
        _ => egui::CursorIcon::Crosshair,
    });
}

/// The wheel: nearer and further; with E brighter and darker; with Ctrl wider and narrower; in flight faster and
/// slower.
fn wheel(ctx: &Context, hand: &Viewport, model: &Model, commands: &mut Commands) {
    let (turned, zoomed, bright) = ctx.input(|i| (f64::from(i.smooth_scroll_delta().y), f64::from(i.zoom_delta()), i.key_down(Key::E)));
    if zoomed != 1.0 {
        commands.fly(move |flight| flight.widen(1.0 / zoomed));
    } else if turned != 0.0 && bright {
        commands.push(Command::Expose(STOPS * turned));
    } else if turned != 0.0 && hand.flying {
        let speed = (model.flight.speed * (WHEEL * turned).exp()).clamp(1e-6, 1e6);
        commands.fly(move |flight| flight.speed = speed);
        commands.push(Command::Tell(format!("speed {} pc/s", barnard_explorer::edit::rounded(speed, 2))));
    } else if turned != 0.0 {
        commands.fly(move |flight| flight.approach((-WHEEL * turned).exp()));
    }
}

/// The point of the screen at which a place appears.
fn on_screen(hand: &Viewport, model: &Model, seen: Rect, place: DVec3) -> Option<Pos2> {
    let camera = model.flight.seen(hand.pixels?);
    let (column, row) = camera.project(place)?;
    let (x, y) = (column / camera.width as f64, row / camera.height as f64);
    Some(seen.min + vec2(x as f32 * seen.width(), y as f32 * seen.height()))
}

fn grip(hand: &Viewport, model: &Model, rect: Rect, seen: Rect, pointer: Pos2) -> Hold {
    if model.comparison.with != With::Nothing && !side_by_side(model) {
        let x = rect.left() + model.comparison.edge.unwrap_or(0.5) * rect.width();
        if (pointer.x - x).abs() < GRIP {
            return Hold::Edge;
        }
    }
    let distance = |place: DVec3| on_screen(hand, model, seen, place).map_or(f32::INFINITY, |p| p.distance(pointer));
    let stars = model.document.stars().iter().enumerate().map(|(i, star)| (i, distance(star.position)));
    stars.filter(|(_, d)| *d < GRIP).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(Hold::Orbit, |(i, _)| Hold::Star(i))
}

/// Marks the star under the pointer and opens its keys; a click beside all stars marks none.
fn select(ctx: &Context, grip: Hold, model: &Model, commands: &mut Commands) {
    let Hold::Star(star) = grip else { return commands.push(Command::Select(None)) };
    commands.push(Command::Select(Some(star)));
    let width = ctx.content_rect().width();
    if !model.layout.shows(Side::Scene, width) {
        commands.lay_out(move |layout| layout.toggle(Side::Scene, width));
    }
    reveal(ctx, "star", star);
}

/// A star follows the pointer, in the plane across the line of sight that it stands in.
fn move_star((hand, model): (&Viewport, &Model), star: usize, seen: Rect, pointer: Pos2, commands: &mut Commands) {
    let (Some(pixels), Some(star_now)) = (hand.pixels, model.document.stars().get(star)) else { return };
    let camera = model.flight.seen(pixels);
    let (x, y) = ((pointer.x - seen.left()) / seen.width(), (pointer.y - seen.top()) / seen.height());
    let ray = camera.ray(f64::from(x) * camera.width as f64, f64::from(y) * camera.height as f64);
    let along = ray.direction.dot(camera.forward);
    let t = (star_now.position - ray.origin).dot(camera.forward) / along;
    if t.is_finite() && t > 0.0 {
        commands.push(Edit::set(&format!("star.{star}"), "position", place_text(ray.at(t), model.flight.distance())));
    }
}

/// Colour of marks over the picture.
fn mark_colour() -> Color32 {
    Color32::from_rgba_unmultiplied(120, 200, 255, 200)
}

/// A ring at a star with its name, where it is seen.
fn ring(painter: &egui::Painter, place: Option<Pos2>, name: &str) {
    let Some(p) = place else { return };
    let colour = mark_colour();
    painter.circle_stroke(p, GRIP, Stroke::new(1.0, colour));
    painter.text(p + vec2(GRIP + 2.0, -GRIP), Align2::LEFT_BOTTOM, name, FontId::proportional(12.0), colour);
}

/// Rings at stars, names of those of a catalogue, and the frame of the scene's own picture.
fn overlay(ui: &Ui, hand: &Viewport, model: &Model, seen: Rect) {
    let (painter, colour) = (ui.painter().with_clip_rect(seen), mark_colour());
    for star in model.document.stars() {
        ring(&painter, on_screen(hand, model, seen, star.position), &star.name);
    }
    if let Some(pixels) = hand.pixels {
        let camera = model.flight.seen(pixels);
        let scale = vec2(seen.width() / camera.width as f32, seen.height() / camera.height as f32);
        for (name, column, row) in barnard::points::names(model.document.scene(), &camera).take(NAMES) {
            let place = seen.min + vec2(column as f32, row as f32) * scale;
            painter.text(place + vec2(0.6 * GRIP, 0.0), Align2::LEFT_CENTER, name, FontId::proportional(12.0), colour);
        }
    }
    let frame = framed(seen, aspect(&model.flight.camera));
    painter.rect_stroke(frame, 0.0, Stroke::new(1.0, colour.gamma_multiply(0.5)), egui::StrokeKind::Inside);
}

/// The largest frame of a shape in the middle of the picture, and its thirds; all beside it is dimmed.
fn guide(ui: &Ui, guide: Guide, seen: Rect) {
    let Some(shape) = guide.shape() else { return };
    let painter = ui.painter().with_clip_rect(seen);
    let frame = framed(seen, shape);
    let stroke = Stroke::new(1.0, Color32::from_white_alpha(140));
    if guide == Guide::Dome {
        painter.circle_stroke(frame.center(), 0.5 * frame.width(), stroke);
        // Half way up, and the axes.
        painter.circle_stroke(frame.center(), 0.25 * frame.width(), Stroke::new(1.0, Color32::from_white_alpha(60)));
    } else {
        let dim = Color32::from_black_alpha(120);
        let beside = [
            Rect::from_min_max(seen.min, pos2(frame.left(), seen.bottom())),
            Rect::from_min_max(pos2(frame.right(), seen.top()), seen.max),
            Rect::from_min_max(pos2(frame.left(), seen.top()), frame.right_top()),
            Rect::from_min_max(frame.left_bottom(), pos2(frame.right(), seen.bottom())),
        ];
        for rect in beside {
            painter.rect_filled(rect, 0.0, dim);
        }
        painter.rect_stroke(frame, 0.0, stroke, egui::StrokeKind::Inside);
    }
    let third = Stroke::new(1.0, Color32::from_white_alpha(50));
    for part in [1.0 / 3.0, 2.0 / 3.0] {
        painter.vline(frame.left() + part * frame.width(), frame.y_range(), third);
        painter.hline(frame.x_range(), frame.top() + part * frame.height(), third);
    }
}

/// Writes words onto the picture that are not part of it.
fn labels(ui: &Ui, model: &Model, rect: Rect) {
    let painter = ui.painter().with_clip_rect(rect);
    let write = |place: Pos2, align: Align2, words: &str| {
        let text = painter.layout_no_wrap(words.to_owned(), FontId::proportional(13.0), Color32::from_gray(225));
        let at = align.anchor_size(place, text.size());
        painter.rect_filled(at.expand(3.0), 3.0, Color32::from_black_alpha(150));
        painter.galley(at.min, text, Color32::WHITE);
    };
    let below = pos2(rect.left() + 8.0, rect.bottom() - 8.0);
    match &model.shown {
        None => write(rect.center(), Align2::CENTER_CENTER, "planning …"),
        Some(shown) if shown.quality < Refinement::Exposed => write(below, Align2::LEFT_BOTTOM, "refining …"),
        Some(_) => {}
    }
    let names = |i: usize| {
        let picture = model.shown.as_ref()?.pictures.get(i)?;
        Some(picture.image.bands.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", "))
    };
    if let (With::Filters(_), Some(first), Some(other)) = (&model.comparison.with, names(0), names(1)) {
        write(rect.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, &first);
        write(rect.right_top() + vec2(-8.0, 8.0), Align2::RIGHT_TOP, &other);
    }
    if let (With::Recorded, Some(other)) = (&model.comparison.with, model.shown.as_ref().and_then(|shown| shown.pictures.get(1))) {
        write(rect.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, "as it is");
        write(rect.right_top() + vec2(-8.0, 8.0), Align2::RIGHT_TOP, &other.recorded_words());
    }
    if model.document.scene().camera.stereo.is_some() {
        write(rect.right_bottom() + vec2(-8.0, -8.0), Align2::RIGHT_BOTTOM, "from between both eyes");
    }
    if model.comparison.with == With::Finer {
        write(rect.right_top() + vec2(-8.0, 8.0), Align2::RIGHT_TOP, &format!("difference from a finer method, × {AMPLIFIED}"));
    }
}

/// Does what the keys say: flight, frames, bookmarks, exposure.
pub fn keys(ctx: &Context, hand: &mut Viewport, commands: &mut Commands) {
    fly(ctx, hand, commands);
    if is_pressed(ctx, Modifiers::NONE, Key::Home) {
        commands.push(Command::FrameAll);
    }
    if is_pressed(ctx, Modifiers::NONE, Key::M) {
        commands.lay_out(|layout| layout.overlay = !layout.overlay);
    }
    if is_pressed(ctx, Modifiers::NONE, Key::G) {
        commands.lay_out(|layout| {
            let now = Guide::ALL.iter().position(|guide| *guide == layout.guide).unwrap_or(0);
            layout.guide = Guide::ALL[(now + 1) % Guide::ALL.len()];
        });
    }
    expose(ctx, commands);
    if is_pressed(ctx, Modifiers::NONE, Key::OpenBracket) {
        commands.fly(|flight| flight.widen(1.0 / 1.1));
    }
    if is_pressed(ctx, Modifiers::NONE, Key::CloseBracket) {
        commands.fly(|flight| flight.widen(1.1));
    }
    bookmarks(ctx, commands);
}

/// True if a key was pressed; who asks takes it.
fn is_pressed(ctx: &Context, modifiers: Modifiers, key: Key) -> bool {
    ctx.input_mut(|i| i.consume_key(modifiers, key))
}

/// Flies while keys are held, unless a command began with one of them.
fn fly(ctx: &Context, hand: &mut Viewport, commands: &mut Commands) {
    let axis = |more: Key, less: Key| ctx.input(|i| f64::from(i8::from(i.key_down(more)) - i8::from(i.key_down(less))));
    let (right, up, forward) = (axis(Key::D, Key::A), axis(Key::R, Key::F), axis(Key::W, Key::S));
    let roll = axis(Key::Period, Key::Comma);
    let down = (right, up, forward, roll) != (0.0, 0.0, 0.0, 0.0);
    let is_command = |m: &Modifiers| m.command || m.alt;
    let of_command = |e: &Event| matches!(e, Event::Key { pressed: true, modifiers, .. } if is_command(modifiers));
    let command = ctx.input(|i| is_command(&i.modifiers) || i.events.iter().any(of_command));
    hand.grounded = down && (hand.grounded || command);
    hand.flying = down && !hand.grounded;
    if hand.flying {
        let dt = f64::from(ctx.input(|i| i.stable_dt)).min(0.1);
        commands.fly(move |flight| {
            flight.fly(dt * right, dt * up, dt * forward);
            flight.roll(dt * roll);
        });
        ctx.request_repaint();
    }
}

/// Half stops up and down, and the exposure that the picture asks for.
fn expose(ctx: &Context, commands: &mut Commands) {
    let times = |key| ctx.input_mut(|i| i.count_and_consume_key(Modifiers::NONE, key)) as f64;
    let stops = 0.5 * (times(Key::Plus) + times(Key::Equals) - times(Key::Minus));
    if stops != 0.0 {
        commands.push(Command::Expose(stops));
    }
    if is_pressed(ctx, Modifiers::NONE, Key::Num0) {
        commands.push(Command::ExposeAutomatically);
    }
}

/// Sets bookmarks and goes to them.
fn bookmarks(ctx: &Context, commands: &mut Commands) {
    const DIGITS: [Key; 9] = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    for (i, key) in DIGITS.into_iter().enumerate() {
        let name = (i + 1).to_string();
        if is_pressed(ctx, Modifiers::COMMAND, key) {
            commands.push(Command::SetBookmark(name.clone()));
        }
        if is_pressed(ctx, Modifiers::NONE, key) {
            commands.push(Command::GoTo(name));
        }
    }
}
