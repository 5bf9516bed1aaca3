//! Leaving a scene or the window: asked about where something would be lost.

use eframe::egui::{self, Context, ViewportCommand};

use super::App;
use barnard_explorer::document::Document;

/// The wish of the user that waits until what is there is kept.
pub(super) enum Leaving {
    Window,
    For(Box<Document>),
}

/// The answer of the user.
enum Answer {
    Save,
    Discard,
    Stop,
    Cancel,
}

impl App {
    /// Lets the window close, unless something would be lost.
    pub(super) fn close(&mut self, ctx: &Context) {
        if !ctx.input(|i| i.viewport().close_requested()) || self.session.is_closed() {
            return;
        }
        if self.export.is_some() || self.model.document.is_changed() {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.leaving = Some(Leaving::Window);
        } else {
            self.session.close();
        }
    }

    /// Asks about a picture that is being saved, then about changes; goes when nothing is left to ask.
    pub(super) fn ask_before_leaving(&mut self, ctx: &Context) {
        if self.files.is_open() {
            return;
        }
        let export = self.export.as_ref().filter(|_| matches!(self.leaving, Some(Leaving::Window)));
        let (question, answers) = match (&self.leaving, export) {
            (None, _) => return,
            (Some(_), Some(export)) => {
                (format!("{} is being saved.", export.path.display()), vec![("Stop it", Answer::Stop), ("Wait", Answer::Cancel)])
            }
            (Some(_), None) if self.model.document.is_changed() => {
                let answers = vec![("Save", Answer::Save), ("Discard", Answer::Discard), ("Cancel", Answer::Cancel)];
                (format!("Save the changes of {}?", self.model.document.origin().name()), answers)
            }
            (Some(_), None) => return self.leave(ctx),
        };
        let mut answer = None;
        let modal = egui::Modal::new(egui::Id::unique("leaving")).show(ctx, |ui| {
            ui.heading(question);
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                for (words, means) in answers {
                    if ui.button(words).clicked() {
                        answer = Some(means);
                    }
                }
            });
        });
        match answer.or(modal.should_close().then_some(Answer::Cancel)) {
            Some(Answer::Save) => self.save(),
            Some(Answer::Discard) => self.leave(ctx),
            Some(Answer::Stop) => {
                if let Some(export) = &self.export {
                    export.stop();
                }
            }
            Some(Answer::Cancel) => self.leaving = None,
            None => {}
        }
    }

    fn leave(&mut self, ctx: &Context) {
        self.session.forget_recovery();
        match self.leaving.take() {
            Some(Leaving::Window) => {
                self.session.close();
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            // As it is now: what was saved just before may be this very file.
            Some(Leaving::For(document)) => match Document::of(document.origin(), self.memory_limit) {
                Ok(document) => self.take(document),
                Err(error) => self.model.complain(error),
            },
            None => {}
        }
    }
}
