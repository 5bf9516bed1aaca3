//! A bundle and the page of the explorer in one HTML file.
//!
//! The page is `barnard.html`, which `.ci/web` makes. It has a mark for the scene, one for the preview, and a title.

use barnard::error::{Error, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::Bundle;

const SCENE: &str = "<!-- scene -->";
const PREVIEW: &str = "<!-- preview -->";
const TITLE: &str = "<title>Barnard</title>";

/// Extension of the files.
pub(super) const EXTENSION: &str = "html";

impl Bundle {
    /// Page of the explorer with this scene in it: one file that a browser opens from a disk, without a network.
    ///
    /// # Errors
    /// If `page` is not the page of the explorer.
    pub fn html(&self, page: &str) -> Result<String> {
        let name = escaped(&self.name);
        let preview = if self.preview.is_empty() {
            String::new()
        } else {
            format!("<img id=\"preview\" alt=\"{name}\" src=\"data:image/jpeg;base64,{}\">", STANDARD.encode(&self.preview))
        };
        let marks = [
            (TITLE, format!("<title>{name}</title>")),
            (PREVIEW, preview),
            (
                SCENE,
                format!(
                    "<script type=\"text/plain\" id=\"barnard-bundle\" data-name=\"{name}\">{}</script>",
                    STANDARD.encode(self.encoded()?)
                ),
            ),
        ];
        let mut html = page.to_owned();
        for (mark, content) in marks {
            let place = html.find(mark).ok_or_else(|| Error::Encoding {
                format: EXTENSION,
                reason: format!("the page has no mark \"{mark}\"; use barnard.html as made by .ci/web of this version"),
            })?;
            html.replace_range(place..place + mark.len(), &content);
        }
        Ok(html)
    }
}

/// Text as the contents or an attribute of an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
