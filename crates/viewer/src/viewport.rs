//! The middle of the window: the picture, what lies over it, and the hands that move it.

use barnard::glam::DVec3;
use eframe::egui::{
    self, Align2, Color32, Context, Event, FontId, Key, Modifiers, PointerButton, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2,
};

use crate::app::App;
use crate::comparison::{Arrangement, With};
use crate::edit::{Edit, place_text};
use crate::editor::Edits;
use crate::order::AMPLIFIED;
use crate::order::Refinement;

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

/// The frame of a picture that is to be composed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Guide {
    /// No frame is drawn.
    #[default]
    None,
    /// A film or a 4k screen.
    Wide,
    /// The cinema's widest.
    Scope,
    /// A square.
    Square,
    /// The circle of a dome.
    Dome,
}

impl Guide {
    /// All of them, in the order in which G goes through them.
    pub const ALL: [Self; 5] = [Self::None, Self::Wide, Self::Scope, Self::Square, Self::Dome];

    /// The name in menus.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Wide => "16:9 (HD, 4k)",
            Self::Scope => "2.39:1",
            Self::Square => "1:1",
            Self::Dome => "dome",
        }
    }

    /// Width of the frame, of its height.
    fn shape(self) -> Option<f32> {
        match self {
            Self::None => None,
            Self::Wide => Some(16.0 / 9.0),
            Self::Scope => Some(2.39),
            Self::Square | Self::Dome => Some(1.0),
        }
    }
}

/// The state of the middle of the window between frames.
#[derive(Default)]
pub struct Viewport {
    /// The size in pixels; none before it was shown.
    pub pixels: Option<(usize, usize)>,
    /// True if places of stars and the frame of the scene's own picture are drawn.
    pub overlay: bool,
    /// The frame that is drawn over the picture.
    pub guide: Guide,
    /// The place of the pointer, as parts of width and height.
    pub pointer: Option<(f64, f64)>,
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
pub fn show(ui: &mut Ui, app: &mut App, edits: &mut Edits) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "picture"));
    let scale = ui.ctx().pixels_per_point();
    let edge = |points: f32| (points * scale).round().clamp(16.0, MAX) as usize;
    let halves = if side_by_side(app) { 2.0 } else { 1.0 };
    app.viewport.pixels = Some((edge(rect.width() / halves), edge(rect.height())));
    draw(ui, app, rect);
    let seen = if side_by_side(app) { rect.split_left_right_at_fraction(0.5).0 } else { rect };
    if let Some(sparks) = app.shown.as_ref().and_then(|shown| shown.sparks.as_ref()) {
        ui.painter().with_clip_rect(seen).image(sparks.id(), seen, WHOLE, Color32::WHITE);
    }
    hands(ui, app, &response, rect, seen, edits);
    if app.viewport.overlay {
        overlay(ui, app, seen);
    }
    guide(ui, app.viewport.guide, seen);
    labels(ui, app, rect);
}

fn side_by_side(app: &App) -> bool {
    app.comparison.is_of_pictures() && app.comparison.arrangement == Arrangement::SideBySide
}

/// The whole of a texture.
const WHOLE: Rect = Rect { min: Pos2::ZERO, max: pos2(1.0, 1.0) };

/// Draws the pictures that are there, or the black before them.
fn draw(ui: &Ui, app: &App, rect: Rect) {
    let painter = ui.painter().with_clip_rect(rect);
    let textures = app.shown.as_ref().map_or(&[][..], |shown| &shown.textures);
    match (&app.comparison.with, textures) {
        (With::Nothing, [own, ..]) | (_, [own]) => painter.image(own.id(), rect, WHOLE, Color32::WHITE),
        (_, [own, other]) if side_by_side(app) => {
            let (left, right) = rect.split_left_right_at_fraction(0.5);
            painter.image(own.id(), left, WHOLE, Color32::WHITE);
            painter.image(other.id(), right, WHOLE, Color32::WHITE)
        }
        (_, [own, other]) => {
            let x = app.comparison.edge.unwrap_or(0.5);
            let (left, right) = rect.split_left_right_at_fraction(x);
            painter.image(own.id(), left, Rect::from_min_max(WHOLE.min, pos2(x, 1.0)), Color32::WHITE);
            painter.image(other.id(), right, Rect::from_min_max(pos2(x, 0.0), WHOLE.max), Color32::WHITE);
            painter.vline(left.right(), rect.y_range(), Stroke::new(1.5, Color32::from_white_alpha(160)))
        }
        _ => painter.rect_filled(rect, 0.0, Color32::BLACK),
    };
}

/// Does what the mouse says.
fn hands(ui: &Ui, app: &mut App, response: &egui::Response, rect: Rect, seen: Rect, edits: &mut Edits) {
    let ctx = ui.ctx();
    let pointer = response.hover_pos().filter(|p| seen.contains(*p));
    app.viewport.pointer = pointer.map(|p| (f64::from((p.x - seen.left()) / seen.width()), f64::from((p.y - seen.top()) / seen.height())));
    if response.drag_started() {
        app.viewport.held_at = ctx.input(|i| i.pointer.press_origin());
        let shift = ctx.input(|i| i.modifiers.shift);
        let by = |button| response.dragged_by(button);
        app.viewport.hold = match app.viewport.held_at {
            Some(origin) if by(PointerButton::Primary) && !shift => grip(app, rect, seen, origin),
            _ if by(PointerButton::Secondary) => Hold::Look,
            _ => Hold::Pan,
        };
    }
    // The frame that hears of the end hears of the last way as well.
    if let (true, Some(from), Some(to)) =
        (response.dragged() || response.drag_stopped(), app.viewport.held_at, response.interact_pointer_pos())
    {
        app.viewport.held_at = Some(to);
        let way = (to - from) / seen.width();
        let (right, down) = (f64::from(way.x), f64::from(way.y));
        match app.viewport.hold {
            Hold::Nothing => {}
            Hold::Orbit => app.flight.orbit(right, down),
            Hold::Pan => app.flight.pan(right, down),
            Hold::Look => app.flight.look(right, down),
            Hold::Star(star) => move_star(app, star, seen, to, edits),
            Hold::Edge => {
                app.comparison.edge = Some((app.comparison.edge.unwrap_or(0.5) + (to - from).x / rect.width()).clamp(0.02, 0.98));
            }
        }
    }
    if response.drag_stopped() || !ctx.input(|i| i.pointer.any_down()) {
        (app.viewport.hold, app.viewport.held_at) = (Hold::Nothing, None);
    }
    if response.hovered() {
        wheel(ctx, app);
    }
    response.clone().on_hover_cursor(match pointer.map(|p| grip(app, rect, seen, p)) {
        Some(Hold::Star(_)) => egui::CursorIcon::Grab,
        Some(Hold::Edge) => egui::CursorIcon::ResizeHorizontal,
        _ => egui::CursorIcon::Crosshair,
    });
}

/// The wheel: nearer and further; with E brighter and darker; with Ctrl wider and narrower; in flight faster and
/// slower.
fn wheel(ctx: &Context, app: &mut App) {
    let (turned, zoomed, bright) = ctx.input(|i| (f64::from(i.smooth_scroll_delta().y), f64::from(i.zoom_delta()), i.key_down(Key::E)));
    if zoomed != 1.0 {
        app.flight.widen(1.0 / zoomed);
    } else if turned != 0.0 && bright {
        app.expose(STOPS * turned);
    } else if turned != 0.0 && app.viewport.flying {
        app.flight.speed = (app.flight.speed * (WHEEL * turned).exp()).clamp(1e-6, 1e6);
        app.tell(format!("speed {} pc/s", crate::edit::rounded(app.flight.speed, 2)));
    } else if turned != 0.0 {
        app.flight.approach((-WHEEL * turned).exp());
    }
}

/// The point of the screen at which a place appears.
fn on_screen(app: &App, seen: Rect, place: DVec3) -> Option<Pos2> {
    let camera = app.flight.seen(app.viewport.pixels?);
    let (column, row) = camera.project(place)?;
    let (x, y) = (column / camera.width as f64, row / camera.height as f64);
    Some(seen.min + vec2(x as f32 * seen.width(), y as f32 * seen.height()))
}

fn grip(app: &App, rect: Rect, seen: Rect, pointer: Pos2) -> Hold {
    if app.comparison.with != With::Nothing && !side_by_side(app) {
        let x = rect.left() + app.comparison.edge.unwrap_or(0.5) * rect.width();
        if (pointer.x - x).abs() < GRIP {
            return Hold::Edge;
        }
    }
    let distance = |place: DVec3| on_screen(app, seen, place).map_or(f32::INFINITY, |p| p.distance(pointer));
    let stars = app.document.stars().iter().enumerate().map(|(i, star)| (i, distance(star.position)));
    stars.filter(|(_, d)| *d < GRIP).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(Hold::Orbit, |(i, _)| Hold::Star(i))
}

/// A star follows the pointer, in the plane across the line of sight that it stands in.
fn move_star(app: &App, star: usize, seen: Rect, pointer: Pos2, edits: &mut Edits) {
    let (Some(pixels), Some(star_now)) = (app.viewport.pixels, app.document.stars().get(star)) else { return };
    let camera = app.flight.seen(pixels);
    let (x, y) = ((pointer.x - seen.left()) / seen.width(), (pointer.y - seen.top()) / seen.height());
    let ray = camera.ray(f64::from(x) * camera.width as f64, f64::from(y) * camera.height as f64);
    let along = ray.direction.dot(camera.forward);
    let t = (star_now.position - ray.origin).dot(camera.forward) / along;
    if t.is_finite() && t > 0.0 {
        edits.push(Edit::set(&format!("star.{star}"), "position", place_text(ray.at(t), app.flight.distance())));
    }
}

/// Rings at stars, names of those of a catalogue, and the frame of the scene's own picture.
fn overlay(ui: &Ui, app: &App, seen: Rect) {
    let painter = ui.painter().with_clip_rect(seen);
    let colour = Color32::from_rgba_unmultiplied(120, 200, 255, 200);
    for star in app.document.stars() {
        if let Some(p) = on_screen(app, seen, star.position) {
            painter.circle_stroke(p, GRIP, Stroke::new(1.0, colour));
            painter.text(p + vec2(GRIP + 2.0, -GRIP), Align2::LEFT_BOTTOM, &star.name, FontId::proportional(12.0), colour);
        }
    }
    if let Some(pixels) = app.viewport.pixels {
        let camera = app.flight.seen(pixels);
        let scale = vec2(seen.width() / camera.width as f32, seen.height() / camera.height as f32);
        for (name, column, row) in barnard::points::names(app.document.scene(), &camera).take(NAMES) {
            let place = seen.min + vec2(column as f32, row as f32) * scale;
            painter.text(place + vec2(0.6 * GRIP, 0.0), Align2::LEFT_CENTER, name, FontId::proportional(12.0), colour);
        }
    }
    let camera = &app.flight.camera;
    let size = framed(seen.size(), camera.width as f32 / camera.height as f32);
    painter.rect_stroke(
        Rect::from_center_size(seen.center(), size),
        0.0,
        Stroke::new(1.0, colour.gamma_multiply(0.5)),
        egui::StrokeKind::Inside,
    );
}

/// The largest frame of a shape in the middle of the picture, and its thirds; all beside it is dimmed.
fn guide(ui: &Ui, guide: Guide, seen: Rect) {
    let Some(shape) = guide.shape() else { return };
    let painter = ui.painter().with_clip_rect(seen);
    let frame = Rect::from_center_size(seen.center(), framed(seen.size(), shape));
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

/// The largest size of a shape, width of its height, within another.
fn framed(within: egui::Vec2, shape: f32) -> egui::Vec2 {
    if within.x / within.y > shape { vec2(within.y * shape, within.y) } else { vec2(within.x, within.x / shape) }
}

/// Writes words onto the picture that are not part of it.
fn labels(ui: &Ui, app: &App, rect: Rect) {
    let painter = ui.painter().with_clip_rect(rect);
    let write = |place: Pos2, align: Align2, words: &str| {
        let text = painter.layout_no_wrap(words.to_owned(), FontId::proportional(13.0), Color32::from_gray(225));
        let at = align.anchor_size(place, text.size());
        painter.rect_filled(at.expand(3.0), 3.0, Color32::from_black_alpha(150));
        painter.galley(at.min, text, Color32::WHITE);
    };
    let below = pos2(rect.left() + 8.0, rect.bottom() - 8.0);
    match &app.shown {
        None => write(rect.center(), Align2::CENTER_CENTER, "planning …"),
        Some(shown) if shown.quality < Refinement::Exposed => write(below, Align2::LEFT_BOTTOM, "refining …"),
        Some(_) => {}
    }
    let names = |i: usize| {
        let picture = app.shown.as_ref()?.pictures.get(i)?;
        Some(picture.image.bands.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", "))
    };
    if let (With::Filters(_), Some(own), Some(other)) = (&app.comparison.with, names(0), names(1)) {
        write(rect.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, &own);
        write(rect.right_top() + vec2(-8.0, 8.0), Align2::RIGHT_TOP, &other);
    }
    if let (With::Recorded, Some(other)) = (&app.comparison.with, app.shown.as_ref().and_then(|shown| shown.pictures.get(1))) {
        write(rect.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, "as it is");
        write(rect.right_top() + vec2(-8.0, 8.0), Align2::RIGHT_TOP, &other.recorded_words());
    }
    if app.document.scene().camera.stereo.is_some() {
        write(rect.right_bottom() + vec2(-8.0, -8.0), Align2::RIGHT_BOTTOM, "from between both eyes");
    }
    if app.comparison.with == With::Finer {
        write(rect.right_top() + vec2(-8.0, 8.0), Align2::RIGHT_TOP, &format!("difference from a finer method, × {AMPLIFIED}"));
    }
}

/// Does what the keys say: flight, frames, bookmarks, exposure.
pub fn keys(ctx: &Context, app: &mut App) {
    fly(ctx, app);
    if is_pressed(ctx, Modifiers::NONE, Key::Home) {
        frame(app);
    }
    if is_pressed(ctx, Modifiers::NONE, Key::M) {
        app.viewport.overlay = !app.viewport.overlay;
    }
    if is_pressed(ctx, Modifiers::NONE, Key::G) {
        let now = Guide::ALL.iter().position(|guide| *guide == app.viewport.guide).unwrap_or(0);
        app.viewport.guide = Guide::ALL[(now + 1) % Guide::ALL.len()];
    }
    expose(ctx, app);
    if is_pressed(ctx, Modifiers::NONE, Key::OpenBracket) {
        app.flight.widen(1.0 / 1.1);
    }
    if is_pressed(ctx, Modifiers::NONE, Key::CloseBracket) {
        app.flight.widen(1.1);
    }
    bookmarks(ctx, app);
}

/// True if a key was pressed; who asks takes it.
fn is_pressed(ctx: &Context, modifiers: Modifiers, key: Key) -> bool {
    ctx.input_mut(|i| i.consume_key(modifiers, key))
}

/// Flies while keys are held, unless a command began with one of them.
fn fly(ctx: &Context, app: &mut App) {
    let axis = |more: Key, less: Key| ctx.input(|i| f64::from(i8::from(i.key_down(more)) - i8::from(i.key_down(less))));
    let (right, up, forward) = (axis(Key::D, Key::A), axis(Key::R, Key::F), axis(Key::W, Key::S));
    let roll = axis(Key::Period, Key::Comma);
    let down = (right, up, forward, roll) != (0.0, 0.0, 0.0, 0.0);
    let is_command = |m: &Modifiers| m.command || m.alt;
    let of_command = |e: &Event| matches!(e, Event::Key { pressed: true, modifiers, .. } if is_command(modifiers));
    let command = ctx.input(|i| is_command(&i.modifiers) || i.events.iter().any(of_command));
    app.viewport.grounded = down && (app.viewport.grounded || command);
    app.viewport.flying = down && !app.viewport.grounded;
    if app.viewport.flying {
        let dt = f64::from(ctx.input(|i| i.stable_dt)).min(0.1);
        app.flight.fly(dt * right, dt * up, dt * forward);
        app.flight.roll(dt * roll);
        ctx.request_repaint();
    }
}

/// Half stops up and down, and the exposure that the picture asks for.
fn expose(ctx: &Context, app: &mut App) {
    let times = |key| ctx.input_mut(|i| i.count_and_consume_key(Modifiers::NONE, key)) as f64;
    let stops = 0.5 * (times(Key::Plus) + times(Key::Equals) - times(Key::Minus));
    if stops != 0.0 {
        app.expose(stops);
    }
    if is_pressed(ctx, Modifiers::NONE, Key::Num0) {
        app.expose_automatically();
    }
}

/// Sets bookmarks and goes to them.
fn bookmarks(ctx: &Context, app: &mut App) {
    const DIGITS: [Key; 9] = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    for (i, key) in DIGITS.into_iter().enumerate() {
        let name = (i + 1).to_string();
        if is_pressed(ctx, Modifiers::COMMAND, key) {
            app.apply(app.flight.bookmark(&name));
            app.tell(format!("bookmark {name} is set; it is saved with the scene"));
        }
        if is_pressed(ctx, Modifiers::NONE, key) && !app.go_to(&name) {
            app.tell(format!("bookmark {name} is not set; Ctrl+{name} sets it"));
        }
    }
}

/// Shows all that there is.
pub fn frame(app: &mut App) {
    let scene = app.document.scene();
    let fields = scene.dust.iter().map(|d| d.density.bounds()).chain(scene.emission.iter().map(|e| e.density.bounds()));
    if let Some(bounds) = fields.reduce(|a, b| a.union(&b)) {
        app.flight.frame(&bounds);
    }
}
