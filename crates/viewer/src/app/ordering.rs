//! Requests to the render thread.

use std::sync::Arc;
use std::time::Duration;

use barnard::camera::Camera;
use eframe::egui::{Context, Pos2, Rect, Vec2, vec2};

use super::App;
use crate::viewport::{aspect, framed};
use barnard_explorer::comparison::{Comparison, With};
use barnard_explorer::document::Document;
use barnard_explorer::flight::Flight;
use barnard_explorer::order::{Order, Refinement, View};

/// The time for which nothing may have moved before finer pictures are made [s].
const REST: f64 = 0.15;
/// Size of the central panel in a new window [points].
const FIRST: Vec2 = vec2(604.0, 744.0);

/// The last order, to be compared with what is asked for now.
pub(super) struct Ordered {
    pub(super) number: u64,
    views: Vec<View>,
    camera: Camera,
    exposure: u64,
    settles: bool,
    pub(super) moving: bool,
}

impl Ordered {
    /// The quality of its last picture at rest.
    pub(super) fn finest(&self) -> Refinement {
        if self.settles { Refinement::Settled } else { Refinement::Full }
    }
}

/// A first look at a document, before there is a window.
pub fn first_look(document: &Document, memory_limit: u64) -> Order {
    let (view, flight) = (View::of(document), Flight::of(document.scene()));
    let frame = framed(Rect::from_min_size(Pos2::ZERO, FIRST), aspect(&flight.camera)).size();
    Order {
        views: vec![view],
        camera: flight.seen((frame.x.round() as usize, frame.y.round() as usize)),
        moving: true,
        settles: false,
        difference: false,
        exposure: 0,
        memory_limit,
    }
}

impl App {
    /// Asks for what is to be seen, where that is not what was asked for last.
    pub(super) fn order(&mut self, ctx: &Context) {
        let now = ctx.input(|i| i.time);
        let Some(size) = self.viewport.pixels else { return };
        let views = match self.model.comparison.views(&self.model.document) {
            Ok(views) => views,
            Err(error) => {
                self.model.comparison = Comparison::default();
                self.model.complain(error);
                return;
            }
        };
        let same_views =
            |o: &Ordered| o.views.len() == views.len() && o.views.iter().zip(&views).all(|(a, b)| Arc::ptr_eq(&a.scene, &b.scene));
        let camera = self.model.flight.seen(size);
        let settles = self.model.document.is_final();
        let same = self
            .ordered
            .as_ref()
            .is_some_and(|o| o.camera == camera && o.exposure == self.model.exposure && o.settles == settles && same_views(o));
        if !same {
            self.moved = now;
            if !std::mem::take(&mut self.has_exact_gas) {
                self.changed = now;
            }
        }
        let moving = self.ordered.is_some() && (now - self.moved < REST || self.viewport.is_moving() || self.model.clock.playing);
        if moving {
            // Whatever draws the next frame, one comes when rest is reached.
            ctx.request_repaint_after(Duration::from_secs_f64((REST - (now - self.moved)).clamp(0.01, REST)));
        }
        if same && self.ordered.as_ref().is_some_and(|o| o.moving == moving) {
            return;
        }
        // What keys say of the camera they alone change.
        if !moving && !self.model.document.moves_camera() && self.model.flight.camera != self.model.document.scene().camera {
            // What was flown to is written down, and seen as it is written.
            let edit = self.model.flight.edit();
            if self.flight_is_new() {
                self.model.apply(edit);
                let scene = self.model.document.scene().clone();
                self.model.flight.take(&scene, &scene.camera);
                self.model.document.rest();
                ctx.request_repaint();
                return;
            }
        }
        let difference = self.model.comparison.with == With::Finer;
        let order = Order {
            views: views.clone(),
            camera: camera.clone(),
            moving,
            settles,
            difference,
            exposure: self.model.exposure,
            memory_limit: self.memory_limit,
        };
        self.ordered = Some(Ordered { number: self.engine.submit(order), views, camera, exposure: self.model.exposure, settles, moving });
    }

    /// True if the view differs from the document's by more than the digits that it is written with.
    fn flight_is_new(&self) -> bool {
        let (a, b) = (&self.model.flight.camera, &self.model.document.scene().camera);
        let scale = 1e-5 * self.model.flight.distance();
        a.position.distance(b.position) > scale
            || a.forward.distance(b.forward) > 1e-5
            || a.up.distance(b.up) > 1e-5
            || format!("{:?}", a.projection) != format!("{:?}", b.projection)
    }
}
