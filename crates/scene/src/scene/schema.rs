//! Schema of scene files, table by table: the manual is printed from it, the explorer edits by it.

use super::{
    ROOT, albedo, background, band, catalogue, detail, display, dust, emission, fields, gas, glare, instrument, method, observation,
    output, spectrograph, star, star_table,
};
use crate::instrument::psf;
pub use crate::properties::KindRow;
use crate::properties::{Key, Kind};
use crate::{animation, camera, phase};

/// One table of a scene file.
pub struct TableRow {
    /// The table's name as it is written; NAME stands for any.
    pub title: &'static str,
    /// The place in the file, without brackets: "field.*" is any field, "star" one of many.
    pub path: &'static str,
    /// Description of the table.
    pub text: &'static str,
    /// Keys that it has whatever its kind.
    pub keys: &'static [Key],
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
    TableRow { title: "The scene", path: "", text: "", keys: ROOT, kinds: Vec::new, catalogues: &[] },
    TableRow {
        title: "[camera]",
        path: "camera",
        text: "Where the observer is; `kind` chooses the projection.",
        keys: camera::COMMON,
        kinds: || kinds(camera::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[camera.stereo]",
        path: "camera.stereo",
        text: "Two eyes: off-axis pairs in flat images, omni-directional stereo in images of all around. What a back end renders is both images in one.",
        keys: camera::STEREO,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[camera.path]",
        path: "camera.path",
        text: "How the camera moves: through keyframes, or along a path that another program made. What a scene shows where no frame is asked for is its first moment.",
        keys: animation::PATH,
        kinds: Vec::new,
        catalogues: &[("Interpolations", "interpolations")],
    },
    TableRow {
        title: "[[camera.path.key]]",
        path: "camera.path.key",
        text: "A keyframe: what the camera is at a moment. A key says what it changes. \
               A file has the same as columns, with a unit in brackets behind the name: `time [s]`, then `x [pc]`, `y [pc]` and `z [pc]`, \
               `target_x` or `direction_x` or `orientation_x` to `orientation_w`, `up_x` and so on, and `field_of_view [deg]`.",
        keys: animation::PATH_KEYFRAME,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[bookmark.NAME]",
        path: "bookmark.*",
        text: "A view that is worth going back to: a camera like [camera], whose `size` and `supersampling` hold where it has none of its own. \
               It can be rendered in place of the scene's own camera; the explorer goes to those that are named 1 to 9 by their digits, and sets them with Ctrl.",
        keys: camera::COMMON,
        kinds: || kinds(camera::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[field.NAME]",
        path: "field.*",
        text: "Named scalar fields. Expressions elsewhere use them by name, so products, sums and masks are written as formulas (below). An expression that uses grids lives in the voxels of the finest of them, over the box in which it can be other than zero: a sum of nested grids holds all of them, and a voxel that a mask cuts the part that is left.",
        keys: &[],
        kinds: fields::kinds,
        catalogues: &[],
    },
    TableRow {
        title: "[dust]",
        path: "dust",
        text: "Dust that absorbs and scatters.",
        keys: dust::KEYS,
        kinds: Vec::new,
        catalogues: &[("Extinction laws", "laws")],
    },
    TableRow {
        title: "[dust.albedo]",
        path: "dust.albedo",
        text: "The part of extinction that scatters.",
        keys: &[],
        kinds: || kinds(albedo::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[dust.phase]",
        path: "dust.phase",
        text: "How scattered light is spread over angle; cos θ = +1 is forward.",
        keys: &[],
        kinds: || phase::KINDS.iter().map(|k| KindRow { name: k.name, summary: k.summary, keys: k.keys }).collect(),
        catalogues: &[],
    },
    TableRow {
        title: "[[star]]",
        path: "star",
        text: "A star; `kind` chooses the shape of its spectrum, and exactly one scale says how bright it is.",
        keys: star::KEYS,
        kinds: || kinds(star::SPECTRA),
        catalogues: &[("Stellar spectra", "stars")],
    },
    TableRow {
        title: "[[star_table]]",
        path: "star_table",
        text: "Stars of a CSV, one a row. Columns are named like the keys of [[star]], `position` being x, y and z; a unit may stand behind the name, as in `temperature [K]`, \
               and, but for places, in the cell; otherwise lengths are in pc, radii in Rsun, temperatures in K, luminosities in Lsun, magnitudes in mag. An empty cell says nothing; other columns are left out. \
               Any key of [[star]] beside `file` holds for all of its stars. `kind` is \"stellar\" where there is a column `type`, \
               \"blackbody\" otherwise. Columns are parted by commas, semicolons, tabs or blanks; lines that begin with `#` are skipped.",
        keys: star_table::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[[emission]]",
        path: "emission",
        text: "Gas that glows.",
        keys: emission::KEYS,
        kinds: || kinds(emission::KINDS),
        catalogues: &[("Line lists", "line-lists")],
    },
    TableRow {
        title: "[gas]",
        path: "gas",
        text: "Gas that the scene's stars ionise: which part of it is, how warm it is, and which lines it shines in through the passbands follow from its density and the stars ([docs/gas.md](gas.md)).",
        keys: gas::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[background]",
        path: "background",
        text: "What lies behind the cloud: with a `kind` (the spectra of stars, above) an even light, with `[background.stars]` a field of stars.",
        keys: background::UNIFORM_KEYS,
        kinds: || kinds(star::SPECTRA),
        catalogues: &[],
    },
    TableRow {
        title: "[background.stars]",
        path: "background.stars",
        text: "Stars at infinity, the same from every camera.",
        keys: background::STAR_KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[background.catalogue]",
        path: "background.catalogue",
        text: "Stars of a CSV at infinity, where they are on the sky. Columns: `ra` and `dec`, or `glon` and `glat` (numbers in degrees, or texts such as 18h18m48s),                `magnitude` or the name of a passband (`johnson-V`; Gaia's `phot_g_mean_mag`, `phot_bp_mean_mag` and `phot_rp_mean_mag` are known), a second magnitude, `temperature` or `type` for the colour, and `name`;                other columns are left out, and rows without a magnitude. A star whose colour is a second magnitude has both.",
        keys: catalogue::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[detail]",
        path: "detail",
        text: "Noise that continues the spectrum of dust and gas below their voxels, where a pixel sees finer than those: a grid of 128 voxels does not show its edges from near by. It multiplies what eyes see of densities, and keeps their mean; depths of stars and light that scatters more than once are those without it ([docs/method.md](method.md)).",
        keys: detail::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[[band]]",
        path: "band",
        text: "Passbands of one's own, beside the sets and embedded passbands of `bands`.",
        keys: band::KEYS,
        kinds: || kinds(band::KINDS),
        catalogues: &[("Sets of passbands", "passband-sets"), ("Families of embedded passbands", "passband-families")],
    },
    TableRow {
        title: "[spectrograph]",
        path: "spectrograph",
        text: "Hundreds of narrow passbands side by side, which share one march; FITS files hold them as a cube with a spectral axis ([docs/observing.md](observing.md)).",
        keys: spectrograph::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[display]",
        path: "display",
        text: "Palette and stretch of pictures; they never touch the radiance.",
        keys: display::KEYS,
        kinds: Vec::new,
        catalogues: &[("Palettes", "palettes"), ("Stretches", "stretches")],
    },
    TableRow {
        title: "[display.glare]",
        path: "display.glare",
        text: "What a telescope or an eye makes of bright points in a picture: spikes, rings, a halo, seeing. It is spread in linear light over all that the picture shows; radiances stay what they are.",
        keys: glare::KEYS,
        kinds: Vec::new,
        catalogues: &[("Optics", "optics")],
    },
    TableRow {
        title: "[observation]",
        path: "observation",
        text: "Where on the sky the picture is taken: images then have world coordinates (RA and Dec or Galactic; TAN, ARC of a dome, CAR of an image of all around), and FITS files the unit that is asked for. Nothing that is rendered depends on it; other files hold radiances.",
        keys: observation::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[instrument]",
        path: "instrument",
        text: "What records the picture: a telescope, the air, a detector and its noise. `barnard observe` makes frames of counts and a master of it, with errors and a mask ([docs/observing.md](observing.md)); `barnard render` shows what is there.",
        keys: instrument::KEYS,
        kinds: Vec::new,
        catalogues: &[("Instruments", "instruments")],
    },
    TableRow {
        title: "[[instrument.psf]]",
        path: "instrument.psf",
        text: "What spreads the light of a point: several act one after the other. Where there is none, the preset's, or diffraction alone.",
        keys: &[],
        kinds: || kinds(psf::KINDS),
        catalogues: &[],
    },
    TableRow {
        title: "[output]",
        path: "output",
        text: "What files hold beside the picture, and how. Layers say what its light comes from and where: `scattered`, `emission.NAME` of each gas, `background` and `stars`, whose sum is the picture, `depth` and `tau` ([docs/shows.md](shows.md)).",
        keys: output::KEYS,
        kinds: Vec::new,
        catalogues: &[],
    },
    TableRow {
        title: "[method]",
        path: "method",
        text: "How spectral integrals are done.",
        keys: method::KEYS,
        kinds: Vec::new,
        catalogues: &[("Methods", "methods")],
    },
    TableRow {
        title: "[[animation]]",
        path: "animation",
        text: "A key of the scene that changes from moment to moment: a star's temperature, the dust's scale, the white of the picture. Numbers go from key to key, with units and in lists too; whatever else can be said changes in steps.",
        keys: animation::TRACK,
        kinds: Vec::new,
        catalogues: &[("Interpolations", "interpolations")],
    },
    TableRow {
        title: "[sequence]",
        path: "sequence",
        text: "Which moments of a scene that changes become frames; `barnard render --frames` renders them.",
        keys: animation::SEQUENCE,
        kinds: Vec::new,
        catalogues: &[],
    },
];

impl TableRow {
    /// The row of a table called `path`; none where a scene has no such table.
    pub fn named(path: &str) -> Option<&'static TableRow> {
        let is = |row: &&TableRow| match row.path.strip_suffix(".*") {
            Some(parent) => path.strip_prefix(parent).is_some_and(|rest| rest.starts_with('.')),
            None => row.path == path,
        };
        TABLES.iter().find(is)
    }

    /// The keys of one kind; those of every kind alone where there is no such kind.
    pub fn keys_of(&self, kind: Option<&str>) -> impl Iterator<Item = &'static Key> {
        let own = (self.kinds)().into_iter().find(|k| Some(k.name) == kind).map_or(&[] as &[Key], |k| k.keys);
        own.iter().chain(self.keys)
    }
}
