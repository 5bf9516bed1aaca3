//! Keys of the whole window: undo, help, and the commands of the file menu.

use eframe::egui::{Context, Key, Modifiers, ViewportCommand};

use super::App;
use crate::files::Purpose;

impl App {
    /// Does what the keys say that are no commands of menus.
    pub(super) fn keys(&mut self, ctx: &Context) {
        let pressed = |modifiers, key| ctx.input_mut(|i| i.consume_key(modifiers, key));
        // A slow frame can hold several.
        let times = |modifiers, key| ctx.input_mut(|i| i.count_and_consume_key(modifiers, key));
        for _ in 0..times(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) + times(Modifiers::COMMAND, Key::Y) {
            self.step(true);
        }
        for _ in 0..times(Modifiers::COMMAND, Key::Z) {
            self.step(false);
        }
        if pressed(Modifiers::NONE, Key::F1) {
            self.layout.help = !self.layout.help;
        }
        if pressed(Modifiers::NONE, Key::F11) {
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!self.is_full(ctx)));
        }
        if self.layout.help && pressed(Modifiers::NONE, Key::Escape) {
            self.layout.help = false;
        }
        if self.is_full(ctx) && pressed(Modifiers::NONE, Key::Escape) {
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
        }
        if pressed(Modifiers::NONE, Key::F12) {
            self.screenshot();
        }
        self.moment_keys(ctx);
        crate::viewport::keys(ctx, self);
    }

    /// Keys of the file menu, which hold while something is typed as well: that is taken first.
    pub(super) fn commands(&mut self, ctx: &Context) {
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
            Some((_, Key::O)) => self.files.ask(Purpose::Open, &self.document),
            Some((SHIFTED, Key::S)) => self.files.ask(Purpose::SaveScene, &self.document),
            Some((_, Key::S)) => self.save(),
            Some((_, Key::E)) => self.files.ask(Purpose::SavePicture, &self.document),
            Some((_, Key::Q)) => ctx.send_viewport_cmd(ViewportCommand::Close),
            _ => {}
        }
    }
}
