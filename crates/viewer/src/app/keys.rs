//! Keys of the whole window: undo, help, and the commands of the file menu.

use eframe::egui::{Context, Key, Modifiers, ViewportCommand};

use super::{App, is_full};
use crate::command::{Command, Commands};
use crate::files::Purpose;
use crate::viewport;

impl App {
    /// Does what the keys say that are no commands of menus.
    pub(super) fn keys(&mut self, ctx: &Context, commands: &mut Commands) {
        let pressed = |modifiers, key| ctx.input_mut(|i| i.consume_key(modifiers, key));
        // A slow frame can hold several.
        let times = |modifiers, key| ctx.input_mut(|i| i.count_and_consume_key(modifiers, key));
        for _ in 0..times(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) + times(Modifiers::COMMAND, Key::Y) {
            commands.push(Command::Redo);
        }
        for _ in 0..times(Modifiers::COMMAND, Key::Z) {
            commands.push(Command::Undo);
        }
        if pressed(Modifiers::NONE, Key::F1) {
            self.model.layout.help = !self.model.layout.help;
        }
        if pressed(Modifiers::NONE, Key::F11) {
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!is_full(ctx)));
        }
        if self.model.layout.help && pressed(Modifiers::NONE, Key::Escape) {
            self.model.layout.help = false;
        }
        if is_full(ctx) && pressed(Modifiers::NONE, Key::Escape) {
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
        }
        if pressed(Modifiers::NONE, Key::F12) {
            self.model.screenshot();
        }
        self.moment_keys(ctx, commands);
        viewport::keys(ctx, &mut self.viewport, commands);
    }

    /// Keys of the file menu, which hold while something is typed as well: that is taken first.
    pub(super) fn menu_keys(&mut self, ctx: &Context, commands: &mut Commands) {
        const SHIFTED: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };
        const COMMANDS: [(Modifiers, Key); 5] = [
            (Modifiers::COMMAND, Key::O),
            (SHIFTED, Key::S),
            (Modifiers::COMMAND, Key::S),
            (Modifiers::COMMAND, Key::E),
            (Modifiers::COMMAND, Key::Q),
        ];
        let pressed = COMMANDS.into_iter().find(|(modifiers, key)| ctx.input_mut(|i| i.consume_key(*modifiers, *key)));
        if let (Some(_), Some(typed)) = (pressed, ctx.memory(|m| m.focused())) {
            ctx.memory_mut(|m| m.surrender_focus(typed));
            self.later = pressed;
            ctx.request_repaint();
            return;
        }
        match pressed.or(self.later.take()) {
            Some((_, Key::O)) => commands.push(Command::Ask(Purpose::Open)),
            Some((SHIFTED, Key::S)) => commands.push(Command::Ask(Purpose::SaveScene)),
            Some((_, Key::S)) => commands.push(Command::Save),
            Some((_, Key::E)) => commands.push(Command::Ask(Purpose::SavePicture)),
            Some((_, Key::Q)) => ctx.send_viewport_cmd(ViewportCommand::Close),
            _ => {}
        }
    }

    /// Keys of the timeline: K sets one, the space bar plays.
    fn moment_keys(&mut self, ctx: &Context, commands: &mut Commands) {
        let pressed = |key| ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        if pressed(Key::K) {
            self.model.layout.timeline = true;
            commands.push(Command::SetKey);
        }
        if pressed(Key::V) {
            commands.push(Command::Visit);
        }
        if pressed(Key::Space) && self.model.document.scene().timeline.is_some() {
            commands.push(Command::Play);
        }
        if pressed(Key::T) {
            self.model.layout.timeline = !self.model.layout.timeline;
        }
    }

    /// Goes on by itself, at the pace of the clock on the wall; at the end it stands.
    pub(super) fn tick(&mut self, ctx: &Context) {
        if !self.model.clock.playing {
            return;
        }
        let (step, end) = (f64::from(ctx.input(|i| i.stable_dt)).min(0.5), self.model.duration().unwrap_or(0.0));
        let time = (self.model.clock.time + step).min(end.max(self.model.clock.time));
        self.model.clock.playing = time < end;
        self.model.seek(time);
        ctx.request_repaint();
    }
}
