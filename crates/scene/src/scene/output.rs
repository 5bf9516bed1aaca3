//! The `[output]` table: what files hold beside a picture, and how.

use crate::error::Result;
use crate::image::{ColourSpace, Compression, Glare, LayerChannels, LayerChoice, Output, SaveOptions};
use crate::light::LightPart;
use crate::memory;
use crate::properties::{Choice, Choices, Key, KeyRow, OrDefault, Section, Table, Texts};

use super::Scene;

const LAYERS: Key<Texts, OrDefault> =
    Key::texts("layers", "layers of an .exr or a .fits: light, depth, tau, all or none").default(&[]).example("[\"all\"]");
const CHANNELS: Key<Choice<LayerChannels>, OrDefault> =
    Key::choice("channels", "contents of light layers: rgb (linear colours at the picture's exposure) or bands (radiances)").default("rgb");
const COLOR_SPACE: Key<Choice<ColourSpace>, OrDefault> =
    Key::choice("color_space", "primaries of linear colours in an .exr").default("rec709");
const PRECISION: Key<Choice<ColourPrecision>, OrDefault> =
    Key::choice("precision", "precision of colours in an .exr; radiances are always float").default("half");
const COMPRESSION: Key<Choice<Compression>, OrDefault> =
    Key::choice("compression", "compression of an .exr; pxr24 keeps 24 bits per radiance").default("zip");

pub(super) const KEYS: &[KeyRow] = &[LAYERS.row, CHANNELS.row, COLOR_SPACE.row, PRECISION.row, COMPRESSION.row];

/// Precision of the colours of an .exr.
#[derive(Clone, Copy)]
enum ColourPrecision {
    Half,
    Float,
}

impl Choices for ColourPrecision {
    const ROWS: &'static [(&'static str, Self)] = &[("half", Self::Half), ("float", Self::Float)];
}

impl Scene {
    /// Display and encoding of its images in files.
    pub fn save_options(&self) -> SaveOptions {
        SaveOptions { display: self.display.clone(), output: self.output }
    }

    /// Scene as rendered for files: without layers where no file stores them.
    ///
    /// # Errors
    /// If its image with the layers, or its glare where a file shows colours, would take more than `memory_limit` bytes.
    pub fn for_files(mut self, have_layers: bool, show_colours: bool, memory_limit: u64) -> Result<Self> {
        if !have_layers {
            self.spec.output.layers = LayerChoice::default();
        }
        let (layers, bands) = (self.output.layers, self.bands.len());
        let parts = if layers.light { LightPart::of(&self).len() } else { 0 };
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

pub(super) fn build(section: Option<&Section>) -> Result<Output> {
    let Some(section) = section else { return Ok(Output::default()) };
    section.check(KEYS)?;
    let layers = LayerChoice::by_names(&section.read(&LAYERS)?);
    let layers = layers.map_err(|message| section.error(&LAYERS, message))?;
    Ok(Output {
        layers,
        channels: section.read(&CHANNELS)?,
        colours: section.read(&COLOR_SPACE)?,
        single: matches!(section.read(&PRECISION)?, ColourPrecision::Float),
        compression: section.read(&COMPRESSION)?,
    })
}

impl Output {
    /// Reads how files hold pictures from its properties, those of a table `[output]`.
    ///
    /// # Errors
    /// If a key is unknown or a value wrong; the error states its place.
    pub fn from_properties(table: &Table) -> Result<Self> {
        build(Some(&Section::new(table, "output")))
    }
}
