//! The `[display]` table: palette and stretch of pictures.

use spectra::colour::{Palette, Stretch};
use spectra::passband::Passband;

use super::glare;
use crate::error::Result;
use crate::image::{Display, Level};
use crate::properties::{Flag, Integer, Key, KeyRow, Number, Numbers, OrDefault, Section, SubTable, Table, Text};

const PALETTE: Key<Text> =
    Key::text("palette", "assignment of bands to colours").otherwise("natural, or rgb outside the visible").of("palettes");
const MATRIX: Key<Numbers> =
    Key::numbers("matrix", "custom palette: red, green, blue of the first band, then of the next").excludes("palette");
const BALANCE: Key<Flag, OrDefault> = Key::flag("balance", "scale each band to its own white, as usual for narrow bands").default(false);
const STRETCH: Key<Text, OrDefault> = Key::text("stretch", "curve from radiance to brightness").default("asinh").of("stretches");
const STRENGTH: Key<Number> = Key::number("strength", "its parameter").not_negative().otherwise("the stretch's own");
const BLACK: Key<Number> = Key::number("black", "radiance of black [W m-2 sr-1, or of the balanced band]").not_negative().otherwise("0");
const WHITE: Key<Number> = Key::number("white", "radiance of white").not_negative().otherwise("level exceeded by the brightest 0.2 %");
const BITS: Key<Integer<u8>, OrDefault> =
    Key::integer("bits", "bits per colour of a .png, 8 or 16; a .tif has 16, a .jpg 8").range(8..=16).default(8);
const GLARE: Key<SubTable> = Key::table("glare", "glare of bright points, [display.glare]");

pub(super) const KEYS: &[KeyRow] =
    &[PALETTE.row, MATRIX.row, BALANCE.row, STRETCH.row, STRENGTH.row, BLACK.row, WHITE.row, BITS.row, GLARE.row];

pub(super) fn build(section: Option<&Section>, bands: &[Passband]) -> Result<Display> {
    let Some(section) = section else { return Ok(Display::of(bands)) };
    section.check(KEYS)?;
    let palette = match (section.read(&MATRIX)?, section.read(&PALETTE)?) {
        (Some(numbers), _) => matrix(section, &numbers, bands.len())?,
        (None, Some(name)) => section.wrap(&PALETTE, Palette::by_name(name, bands))?,
        (None, None) => Display::of(bands).palette,
    };
    let stretch = Stretch::by_name(section.read(&STRETCH)?, section.read(&STRENGTH)?);
    let level = |key| Ok::<_, crate::Error>(section.stated(key)?.map_or(Level::Auto, Level::Radiance));
    let (black, white) = (level(&BLACK)?, level(&WHITE)?);
    if let (Level::Radiance(b), Level::Radiance(w)) = (black, white)
        && w <= b
    {
        return Err(section.error(&WHITE, "white must be brighter than black"));
    }
    let (balance, stretch) = (section.read(&BALANCE)?, section.wrap(&STRETCH, stretch)?);
    let bits = section.read(&BITS)?;
    if ![8, 16].contains(&bits) {
        return Err(section.error(&BITS, format!("{bits} bits per colour are unsupported; write 8 or 16")));
    }
    let glare = section.read(&GLARE)?.map(|table| glare::build(&table)).transpose()?;
    Ok(Display { palette, balance, stretch, black, white, bits, glare })
}

impl Display {
    /// Reads a display of pictures through `bands` from its properties, those of a table `[display]`.
    ///
    /// # Errors
    /// If a key is unknown or a value wrong; the error states its place.
    pub fn from_properties(table: &Table, bands: &[Passband]) -> Result<Self> {
        build(Some(&Section::new(table, "display")), bands)
    }
}

fn matrix(section: &Section, numbers: &[f64], bands: usize) -> Result<Palette> {
    if numbers.len() != 3 * bands {
        let message = format!("a matrix for {bands} bands must have {} numbers, this one has {}", 3 * bands, numbers.len());
        return Err(section.error(&MATRIX, message));
    }
    Ok(Palette { columns: numbers.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect() })
}
