//! The `[display]` table: palette and stretch of pictures.

use spectra::colour::{Palette, Stretch};
use spectra::passband::Passband;

use super::glare;
use crate::error::Result;
use crate::image::{Display, Level};
use crate::properties::{Key, Section, Table};

pub(super) const KEYS: &[Key] = &[
    Key::optional("palette", "text", "natural, or rgb outside the visible", "assignment of bands to colours").of("palettes"),
    Key::optional("matrix", "list of numbers", "none", "custom palette: red, green, blue of the first band, then of the next"),
    Key::optional("balance", "boolean", "false", "scale each band to its own white, as usual for narrow bands"),
    Key::optional("stretch", "text", "asinh", "curve from radiance to brightness").of("stretches"),
    Key::optional("strength", "number", "the stretch's own", "its parameter"),
    Key::optional("black", "number", "0", "radiance of black [W m-2 sr-1, or of the balanced band]"),
    Key::optional("white", "number", "level exceeded by the brightest 0.2 %", "radiance of white"),
    Key::optional("bits", "integer", "8", "bits per colour of a .png, 8 or 16; a .tif has 16, a .jpg 8"),
    Key::optional("glare", "table", "none", "glare of bright points, [display.glare]"),
];

pub(super) fn build(section: Option<&Section>, bands: &[Passband]) -> Result<Display> {
    let Some(section) = section else { return Ok(Display::of(bands)) };
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let palette = match (section.numbers("matrix")?, section.text("palette")?) {
        (Some(_), Some(_)) => return Err(section.error("matrix", "palette and matrix exclude each other; remove one")),
        (Some(numbers), None) => matrix(section, &numbers, bands.len())?,
        (None, Some(name)) => section.wrap("palette", Palette::named(name, bands))?,
        (None, None) => Display::of(bands).palette,
    };
    let stretch = Stretch::named(section.text("stretch")?.unwrap_or("asinh"), section.number("strength", 0.0..=f64::MAX)?);
    let level = |key| Ok::<_, crate::Error>(section.number(key, 0.0..=f64::MAX)?.map_or(Level::Auto, Level::Radiance));
    let (black, white) = (level("black")?, level("white")?);
    if let (Level::Radiance(b), Level::Radiance(w)) = (black, white)
        && w <= b
    {
        return Err(section.error("white", "white must be brighter than black"));
    }
    let bits = section.integer("bits", 8..=16)?.unwrap_or(8) as u8;
    if ![8, 16].contains(&bits) {
        return Err(section.error("bits", format!("{bits} bits per colour are unsupported; write 8 or 16")));
    }
    let (balance, stretch) = (section.flag("balance")?.unwrap_or(false), section.wrap("stretch", stretch)?);
    let glare = section.table("glare")?.map(|own| glare::build(&own)).transpose()?;
    Ok(Display { palette, balance, stretch, black, white, bits, glare })
}

impl Display {
    /// Reads a display of pictures through `bands` from its properties, those of a table `[display]`.
    ///
    /// # Errors
    /// If a key is unknown or a value wrong; its place is said.
    pub fn from_properties(table: &Table, bands: &[Passband]) -> Result<Self> {
        build(Some(&Section::new(table, "display")), bands)
    }
}

fn matrix(section: &Section, numbers: &[f64], bands: usize) -> Result<Palette> {
    if numbers.len() != 3 * bands {
        let message = format!("a matrix for {bands} bands must have {} numbers, this one has {}", 3 * bands, numbers.len());
        return Err(section.error("matrix", message));
    }
    Ok(Palette { columns: numbers.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect() })
}
