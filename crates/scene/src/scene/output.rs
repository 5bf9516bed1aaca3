//! The `[output]` table: what files hold beside a picture, and how.

use crate::error::Result;
use crate::image::{ColourSpace, Compression, Glare, LayerChannels, LayerChoice, Output};
use crate::light::Part;
use crate::memory;
use crate::properties::{Key, Section, Table};

use super::Scene;

pub(super) const KEYS: &[Key] = &[
    Key::optional("layers", "list of texts", "[]", "layers of an .exr or a .fits: light, depth, tau, all or none"),
    Key::optional(
        "channels",
        "text",
        "rgb",
        "contents of light layers: rgb (linear colours at the picture's exposure) or bands (radiances)",
    ),
    Key::optional("color_space", "text", "rec709", "primaries of linear colours in an .exr: rec709 or acescg"),
    Key::optional("precision", "text", "half", "precision of colours in an .exr: half or float; radiances are always float"),
    Key::optional(
        "compression",
        "text",
        "zip",
        "compression of an .exr: none, rle, zips, zip, piz or pxr24; pxr24 keeps 24 bits per radiance",
    ),
];

impl Scene {
    /// Scene as rendered for files: without layers where no file stores them.
    ///
    /// # Errors
    /// If its image with the layers, or its glare where a file shows colours, would take more than `memory_limit` bytes.
    pub fn for_files(mut self, have_layers: bool, show_colours: bool, memory_limit: u64) -> Result<Self> {
        if !have_layers {
            self.output.layers = LayerChoice::default();
        }
        let (layers, bands) = (self.output.layers, self.bands.len());
        let parts = if layers.light { Part::of(&self).len() } else { 0 };
        let values = bands * (1 + parts) + 2 * usize::from(layers.depth) + 2 * usize::from(layers.tau);
        let what = if layers.is_any() { "the image with its layers" } else { "the image" };
        memory::check(what, self.image_bytes(values), memory_limit)?;
        if show_colours && self.display.glare.is_some() {
            let glare = Glare::bytes(self.camera.width, self.camera.height, bands);
            memory::check("the picture with its glare", self.image_bytes(bands).saturating_add(glare), memory_limit)?;
        }
        Ok(self)
    }
}

/// The value that a key names; the default where it is not said.
pub(super) fn named<T: Copy + Default>(section: &Section, key: &str, rows: &'static [(&'static str, T)]) -> Result<T> {
    let names: Vec<&'static str> = rows.iter().map(|(name, _)| *name).collect();
    let name = section.choice(key, &names)?;
    Ok(rows.iter().find(|(own, _)| Some(*own) == name).map_or_else(T::default, |(_, value)| *value))
}

pub(super) fn build(section: Option<&Section>) -> Result<Output> {
    let Some(section) = section else { return Ok(Output::default()) };
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let layers = LayerChoice::named(&section.texts("layers")?.unwrap_or_default());
    let layers = layers.map_err(|message| section.error("layers", message))?;
    Ok(Output {
        layers,
        channels: named(section, "channels", LayerChannels::ROWS)?,
        colours: named(section, "color_space", ColourSpace::ROWS)?,
        single: section.choice("precision", &["half", "float"])? == Some("float"),
        compression: named(section, "compression", Compression::ROWS)?,
    })
}

impl Output {
    /// Reads how files hold pictures from its properties, those of a table `[output]`.
    ///
    /// # Errors
    /// If a key is unknown or a value wrong; its place is said.
    pub fn from_properties(table: &Table) -> Result<Self> {
        build(Some(&Section::new(table, "output")))
    }
}
