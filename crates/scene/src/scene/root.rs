//! Keys of the scene itself: texts, and the tables that a scene has.

use super::band;
use crate::properties::{Key, KeyRow, NamedTables, Required, SubTable, Tables, Text};

pub(super) const NAME: Key<Text> = Key::text("name", "name of the scene").otherwise("the file's name");
pub(super) const DESCRIPTION: Key<Text> = Key::text("description", "what it shows").otherwise("");
pub(super) const CAMERA: Key<SubTable, Required> = Key::table("camera", "position of the observer")
    .required()
    .example("{ kind = \"perspective\", position = \"0 0 6 pc\", field_of_view = \"25 deg\" }");
pub(super) const FIELD: Key<NamedTables> = Key::named_tables("field", "scalar fields, [field.NAME]");
pub(super) const DUST: Key<SubTable> = Key::table("dust", "dust that absorbs and scatters");
pub(super) const EMISSION: Key<Tables> = Key::tables("emission", "emitting gas, [[emission]]");
pub(super) const GAS: Key<SubTable> = Key::table("gas", "gas ionised by the stars");
pub(super) const DETAIL: Key<SubTable> = Key::table("detail", "density structure below the voxels");
pub(super) const STAR: Key<Tables> = Key::tables("star", "stars, [[star]]");
pub(super) const STAR_TABLE: Key<Tables> = Key::tables("star_table", "stars of a CSV, [[star_table]]");
pub(super) const BACKGROUND: Key<SubTable> = Key::table("background", "what lies behind");
pub(super) const BAND: Key<Tables> = Key::tables("band", "custom passbands, [[band]]; they replace the default of `bands`");
pub(super) const SPECTROGRAPH: Key<SubTable> =
    Key::table("spectrograph", "hundreds of narrow passbands instead of `bands`: a spectral cube");
pub(super) const BOOKMARK: Key<NamedTables> = Key::named_tables("bookmark", "saved views, [bookmark.NAME]");
pub(super) const DISPLAY: Key<SubTable> = Key::table("display", "palette and stretch of pictures").otherwise("defaults");
pub(super) const OBSERVATION: Key<SubTable> = Key::table("observation", "sky position of the image, and the unit of FITS files");
pub(super) const INSTRUMENT: Key<SubTable> = Key::table("instrument", "instrument for `barnard observe`, which writes frames and a master");
pub(super) const OUTPUT: Key<SubTable> = Key::table("output", "layers and encoding of output files").otherwise("defaults");
pub(super) const METHOD: Key<SubTable> = Key::table("method", "method of spectral integrals").otherwise("defaults");
pub(super) const ANIMATION: Key<Tables> = Key::tables("animation", "animated keys, [[animation]]");
pub(super) const SEQUENCE: Key<SubTable> = Key::table("sequence", "frames of an animated scene").otherwise("defaults");

/// Keys of the scene itself.
pub(super) const ROOT: &[KeyRow] = &[
    NAME.row,
    DESCRIPTION.row,
    band::BANDS.row,
    CAMERA.row,
    FIELD.row,
    DUST.row,
    EMISSION.row,
    GAS.row,
    DETAIL.row,
    STAR.row,
    STAR_TABLE.row,
    BACKGROUND.row,
    BAND.row,
    SPECTROGRAPH.row,
    BOOKMARK.row,
    DISPLAY.row,
    OBSERVATION.row,
    INSTRUMENT.row,
    OUTPUT.row,
    METHOD.row,
    ANIMATION.row,
    SEQUENCE.row,
];
