//! Schema of scene files, table by table: the manual is printed from it, the explorer edits by it.

use super::root::ROOT;
use super::{
    albedo, backends, background, band, catalogue, detail, display, dust, emission, fields, gas, glare, instrument, method, observation,
    output, spectrograph, star, star_table,
};
use crate::instrument::psf;
pub use crate::properties::KindRow;
use crate::properties::{KeyRow, Kind, Part};
use crate::{animation, camera, phase};

/// One table of a scene file.
pub struct TableRow {
    /// The table's name as it is written; NAME stands for any.
    pub title: &'static str,
    /// The place in the file, without brackets: "field.*" is any field, "star" one of many.
    pub path: &'static str,
    /// Description of the table.
    pub text: &'static str,
    /// Parts of the scene that its keys change, unless a key states others.
    pub parts: &'static [Part],
    /// Keys that it has whatever its kind.
    pub keys: &'static [KeyRow],
    /// The kinds that its key `kind` chooses from; empty where it has no such key.
    pub kinds: fn() -> Vec<KindRow>,
    /// Catalogues that its keys name: headline and name.
    pub catalogues: &'static [(&'static str, &'static str)],
}

fn kinds<T>(kinds: &'static [Kind<T>]) -> Vec<KindRow> {
    kinds.iter().map(Kind::row).collect()
}

/// All tables, in the order of the manual.
pub const TABLES: &[TableRow] = &[
    TableRow { title: "The scene", path: "", parts: &[], text: "", keys: ROOT, kinds: Vec::new, catalogues: &[] },
    TableRow {
        title: "[camera]",
        path: "camera",
        parts: &[Part::View],
        text: "The observer's camera; `kind` selects the projection.",
        keys: camera::COMMON,
        kinds: || kinds(camera::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[camera.stereo]",
        path: "camera.stereo",
        parts: &[Part::View],
        text: "Stereo: off-axis pairs in flat images, omni-directional stereo in 360° images. One image contains both eyes.",
        keys: camera::STEREO,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[camera.path]",
        path: "camera.path",
        parts: &[],
        text: "Camera path: keyframes, or a path from another program. Without a requested frame, a scene shows its first moment.",
        keys: animation::PATH,
        kinds: Vec::new,
        catalogues: &[("Interpolations", "interpolations")],
    },
    TableRow {
        title: "[[camera.path.key]]",
        path: "camera.path.key",
        parts: &[],
        text: "A keyframe of the camera, with only the values that it sets. \
               In files these are columns, with units in brackets: `time [s]`, then `x [pc]`, `y [pc]` and `z [pc]`, \
               `target_x` or `direction_x` or `orientation_x` to `orientation_w`, `up_x` and so on, and `field_of_view [deg]`.",
        keys: animation::PATH_KEYFRAME,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[bookmark.NAME]",
        path: "bookmark.*",
        parts: &[],
        text: "A saved view: a camera like [camera], whose `size` and `supersampling` are the defaults. \
               `--bookmark` renders it. In the explorer, digits select bookmarks named 1 to 9, and Ctrl with a digit sets one.",
        keys: camera::COMMON,
        kinds: || kinds(camera::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[field.NAME]",
        path: "field.*",
        parts: &[Part::Space],
        text: "Named scalar fields, used by name in expressions such as products, sums and masks (below). Expressions of grids use the voxels of the finest grid, over the box in which they can be nonzero. Sums of nested grids contain all of them, and voxels cut by a mask contain the remaining fraction.",
        keys: &[],
        kinds: fields::kinds,
        catalogues: &[],
    },
    TableRow {
        title: "[dust]",
        path: "dust",
        parts: &[Part::Spectra],
        text: "Dust that absorbs and scatters.",
        keys: dust::KEYS,
        kinds: Vec::new,
        catalogues: &[("Extinction laws", "laws")],
    },
    TableRow {
        title: "[dust.albedo]",
        path: "dust.albedo",
        parts: &[Part::Spectra],
        text: "The scattered fraction of extinction.",
        keys: &[],
        kinds: || kinds(albedo::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[dust.phase]",
        path: "dust.phase",
        parts: &[Part::Space],
        text: "Angular distribution of scattered light; cos θ = +1 is forward.",
        keys: &[],
        kinds: || phase::KINDS.iter().map(|k| KindRow { name: k.name, summary: k.summary, keys: k.keys }).collect(),
        catalogues: &[],
    },
    TableRow {
        title: "[[star]]",
        path: "star",
        parts: &[Part::Spectra],
        text: "A star; `kind` selects the shape of its spectrum, and exactly one scale its brightness.",
        keys: star::KEYS,
        kinds: || kinds(star::SPECTRA),
        catalogues: &[("Stellar spectra", "stars")],
    },
    TableRow {
        title: "[[star_table]]",
        path: "star_table",
        parts: &[Part::Stars, Part::Spectra],
        text: "Stars of a CSV file, one per row. Columns have the names of [[star]] keys, with x, y and z for `position`; units may follow the name, as in `temperature [K]`, \
               or, except for positions, be in the cell. Defaults are pc for lengths, Rsun for radii, K, Lsun and mag. Empty cells and other columns are ignored. \
               Any key of [[star]] next to `file` applies to all stars. `kind` is \"stellar\" if there is a column `type`, \
               \"blackbody\" otherwise. Separators are commas, semicolons, tabs or blanks; lines that begin with `#` are skipped.",
        keys: star_table::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[[emission]]",
        path: "emission",
        parts: &[Part::Spectra],
        text: "Gas that glows.",
        keys: emission::KEYS,
        kinds: || kinds(emission::KINDS),
        catalogues: &[("Line lists", "line-lists")],
    },
    TableRow {
        title: "[gas]",
        path: "gas",
        parts: &[Part::Space, Part::Spectra],
        text: "Gas ionised by the scene's stars: ionisation, temperature and emission lines follow from its density and the stars ([docs/gas.md](gas.md)).",
        keys: gas::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[background]",
        path: "background",
        parts: &[Part::Spectra],
        text: "Background of the cloud: with a `kind` (the spectra of stars, above) a uniform light, with `[background.stars]` a field of stars.",
        keys: background::UNIFORM_KEYS,
        kinds: || kinds(star::SPECTRA),
        catalogues: &[],
    },
    TableRow {
        title: "[background.stars]",
        path: "background.stars",
        parts: &[Part::Spectra],
        text: "Stars at infinity, the same from every camera. A picture shows the brightest 100 000 in view, or one per two pixels if that is more.",
        keys: background::STAR_KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[background.catalogue]",
        path: "background.catalogue",
        parts: &[Part::Spectra],
        text: "Stars of a CSV file at infinity, at their sky positions. Columns: `ra` and `dec`, or `glon` and `glat` (numbers in degrees, or texts such as 18h18m48s), `magnitude` or the name of a passband (`johnson-V`; or Gaia's `phot_g_mean_mag`, `phot_bp_mean_mag`, `phot_rp_mean_mag`), a second magnitude, `temperature` or `type` for the colour, and `name`; other columns and rows without a magnitude are ignored. A star with two magnitudes has exactly both.",
        keys: catalogue::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[detail]",
        path: "detail",
        parts: &[Part::Space],
        text: "Displacement of dust and gas below their voxels where pixels resolve it, so that edges and fronts are rough at all lengths and voxels stay invisible close to the cloud. It moves what the camera sees, without a change of its mean; ionised gas, star depths and multiple scattering ignore it ([docs/method.md](method.md)).",
        keys: detail::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[[band]]",
        path: "band",
        parts: &[Part::Spectra, Part::Display],
        text: "Custom passbands, in addition to the sets and embedded passbands of `bands`.",
        keys: band::KEYS,
        kinds: || kinds(band::KINDS),
        catalogues: &[("Sets of passbands", "passband-sets"), ("Families of embedded passbands", "passband-families")],
    },
    TableRow {
        title: "[spectrograph]",
        path: "spectrograph",
        parts: &[Part::Spectra, Part::Display],
        text: "Hundreds of adjacent narrow passbands that share one march; FITS files store them as a cube with a spectral axis ([docs/observing.md](observing.md)).",
        keys: spectrograph::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[display]",
        path: "display",
        parts: &[Part::Display],
        text: "Palette and stretch of display pictures; radiances do not depend on them.",
        keys: display::KEYS,
        kinds: Vec::new,
        catalogues: &[("Palettes", "palettes"), ("Stretches", "stretches")],
    },
    TableRow {
        title: "[display.glare]",
        path: "display.glare",
        parts: &[Part::Display],
        text: "Glare of bright points by a telescope or an eye: spikes, rings, a halo, seeing. It is applied to linear display colours; radiances do not depend on it.",
        keys: glare::KEYS,
        kinds: Vec::new,
        catalogues: &[("Optics", "optics")],
    },
    TableRow {
        title: "[observation]",
        path: "observation",
        parts: &[Part::Observation],
        text: "Sky position of the image and unit of FITS files. Images then have world coordinates (equatorial or Galactic; projection TAN, ARC for domes, CAR for 360° images). Radiances do not depend on it; other files have radiances.",
        keys: observation::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[instrument]",
        path: "instrument",
        parts: &[Part::Instrument],
        text: "Telescope, atmosphere and detector with noise. `barnard observe` writes frames of counts and a master with errors and a mask ([docs/observing.md](observing.md)); `barnard render` ignores it.",
        keys: instrument::KEYS,
        kinds: Vec::new,
        catalogues: &[("Instruments", "instruments")],
    },
    TableRow {
        title: "[[instrument.psf]]",
        path: "instrument.psf",
        parts: &[Part::Instrument],
        text: "Point-spread functions, applied in sequence. Default: those of the preset, otherwise diffraction.",
        keys: &[],
        kinds: || kinds(psf::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[output]",
        path: "output",
        parts: &[Part::Output],
        text: "Layers and encoding of output files. Layers separate the light by origin: `scattered`, `emission.NAME` of each gas, `background` and `stars`, whose sum is the picture; also `depth` and `tau` ([docs/shows.md](shows.md)).",
        keys: output::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[method]",
        path: "method",
        parts: &[Part::Method],
        text: "Method of spectral integrals.",
        keys: method::KEYS,
        kinds: Vec::new,
        catalogues: &[("Methods", "methods")],
    },
    TableRow {
        title: "[method.path]",
        path: "method.path",
        parts: &[Part::Backend],
        text: "Options of `--backend path`, the Monte Carlo path tracer.",
        keys: backends::PATH,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[method.reference]",
        path: "method.reference",
        parts: &[Part::Backend],
        text: "Options of `--backend reference`, the adaptive integrator.",
        keys: backends::REFERENCE,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[method.gpu]",
        path: "method.gpu",
        parts: &[Part::Backend],
        text: "Options of `--backend gpu` and `auto`.",
        keys: backends::GPU,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[[animation]]",
        path: "animation",
        parts: &[],
        text: "An animated key of the scene, such as a star's temperature, the dust's scale or the white level. Numbers are interpolated, with units and in lists; other values change in steps.",
        keys: animation::TRACK,
        kinds: Vec::new,
        catalogues: &[("Interpolations", "interpolations")],
    },
    TableRow {
        title: "[sequence]",
        path: "sequence",
        parts: &[],
        text: "Frames of an animated scene; `barnard render --frames` renders them.",
        keys: animation::SEQUENCE,
        kinds: Vec::new,
        catalogues: &[],
    },
];

impl TableRow {
    /// The row of a table called `path`; none where a scene has no such table.
    pub fn by_name(path: &str) -> Option<&'static TableRow> {
        let is = |row: &&TableRow| match row.path.strip_suffix(".*") {
            Some(parent) => path.strip_prefix(parent).is_some_and(|rest| rest.starts_with('.')),
            None => row.path == path,
        };
        TABLES.iter().find(is)
    }

    /// The keys of one kind; those of every kind alone where there is no such kind.
    pub fn keys_of(&self, kind: Option<&str>) -> impl Iterator<Item = &'static KeyRow> {
        let keys = (self.kinds)().into_iter().find(|k| Some(k.name) == kind).map_or(&[] as &[KeyRow], |k| k.keys);
        keys.iter().chain(self.keys)
    }
}
