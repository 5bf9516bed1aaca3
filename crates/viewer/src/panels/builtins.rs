//! The built-in scenes, with a small picture of each.

use barnard_files::builtin::{BuiltinScene, SCENES};
use eframe::egui::{self, ColorImage, Context, Id, TextureHandle, TextureOptions, Ui, vec2};

use crate::command::{Command, Commands};
use barnard_explorer::document::Origin;

/// Scenes side by side, and how large a picture is shown [points].
const COLUMNS: usize = 4;
const SIZE: egui::Vec2 = vec2(160.0, 90.0);

/// Shows all built-in scenes; a click opens one.
pub fn show(ui: &mut Ui, commands: &mut Commands) {
    let pictures = pictures(ui.ctx());
    egui::Grid::new("built-in scenes").spacing([10.0, 8.0]).show(ui, |ui| {
        for (i, (scene, picture)) in SCENES.iter().zip(&pictures).enumerate() {
            let clicked = ui.vertical(|ui| {
                let image = match picture {
                    Some(picture) => egui::Button::image(egui::Image::new((picture.id(), SIZE))),
                    None => egui::Button::new(scene.needs.map_or_else(String::new, |file| format!("needs {file}"))).min_size(SIZE),
                };
                ui.add(image.frame(false)).on_hover_text(scene.summary).clicked()
                    | ui.button(scene.name).on_hover_text(scene.summary).clicked()
            });
            if clicked.inner {
                commands.push(Command::Open(Origin::Builtin(scene.name)));
                ui.close();
            }
            if i % COLUMNS == COLUMNS - 1 {
                ui.end_row();
            }
        }
    });
}

/// The pictures of all scenes, read once.
fn pictures(ctx: &Context) -> Vec<Option<TextureHandle>> {
    let id = Id::unique("pictures of built-in scenes");
    if let Some(known) = ctx.data(|data| data.get_temp(id)) {
        return known;
    }
    let pictures: Vec<_> = SCENES.iter().map(|scene| picture(ctx, scene)).collect();
    ctx.data_mut(|data| data.insert_temp(id, pictures.clone()));
    pictures
}

fn picture(ctx: &Context, scene: &BuiltinScene) -> Option<TextureHandle> {
    let image = image::load_from_memory(scene.thumbnail?).ok()?.to_rgb8();
    let size = [image.width(), image.height()].map(|n| n as usize);
    Some(ctx.load_texture(scene.name, ColorImage::from_rgb(size, image.as_raw()), TextureOptions::LINEAR))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every scene that is all there has a picture of the shape in which the menu shows it.
    #[test]
    fn scenes_have_their_pictures() {
        for scene in SCENES {
            assert_eq!(scene.thumbnail.is_some(), scene.needs.is_none(), "{}", scene.name);
            let read = |bytes| image::load_from_memory(bytes).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
            if let Some(image) = scene.thumbnail.map(read) {
                assert_eq!((image.width(), image.height()), (320, 180), "{}", scene.name);
                let luma = image.to_luma8();
                let (least, most) = luma.iter().fold((255, 0), |(a, b), v| (v.min(&a).to_owned(), v.max(&b).to_owned()));
                assert!(most > least + 60, "{}: a picture that shows nothing", scene.name);
            }
        }
    }
}
