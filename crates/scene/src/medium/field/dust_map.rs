//! The measured dust of the Galaxy: what turns each published map into extinction at V \[mag/pc\].
//!
//! The Sun is at the origin of all of them; x points to the Galactic centre, y to l = 90°, z to the north Galactic pole.
//! Where nothing was measured a map is blank, which counts as no dust.

use spectra::constants::MAGNITUDES_PER_DEPTH;

use crate::data::{ArrayHeader, Axis};
use crate::error::Result;
use crate::properties::{Choices, Section};

/// One published map.
#[derive(Debug)]
pub struct DustMap {
    /// The name by which a scene asks for it.
    pub name: &'static str,
    /// Its file, and where that is to be had.
    pub source: (&'static str, &'static str),
    /// The array of its file that holds the mean.
    pub array: Option<&'static str>,
    /// Unit stated by its file, if any.
    unit: Option<&'static str>,
    /// Extinction at V that a value of one is \[mag/pc\].
    extinction: f64,
    /// Origin of the array and the edge of its voxels \[pc\], x slowest; nothing where its file says it.
    corner: Option<([f64; 3], f64)>,
}

/// All maps that are known.
pub const DUST_MAPS: &[DustMap] = &[
    // Edenhofer et al. 2024, A&A 685, A82: E of Zhang, Green & Rix 2023, per pc; A_V = 2.8 E by their extinction curve.
    DustMap {
        name: "edenhofer24",
        source: ("mean_and_std_xyz.fits", "https://doi.org/10.5281/zenodo.10658339"),
        array: Some("MEAN"),
        unit: Some("E of Zhang, Green, and Rix (2023)"),
        extinction: 2.8,
        corner: None,
    },
    // Leike, Glatzle & Ensslin 2020, A&A 639, A138: e-foldings per kpc in Gaia G. A_V = 1.20 A_G was computed from the law
    // of Fitzpatrick 1999 (R_V = 3.1) and the band of Gaia DR3 for a black body of 5800 K behind little dust; 4000 to
    // 8000 K give 1.35 to 1.11.
    DustMap {
        name: "leike20",
        source: ("mean_std.h5", "https://doi.org/10.5281/zenodo.3993082"),
        array: Some("/mean"),
        unit: None,
        extinction: 1.20 * MAGNITUDES_PER_DEPTH / 1000.0,
        corner: Some(([-370.0, -370.0, -270.0], 1.0)),
    },
    // Lallement et al. 2022, A&A 661, A147: A_0 at 550 nm, which is taken for A_V.
    DustMap {
        name: "lallement22",
        source: ("cube_ext.fits.gz", "https://cdsarc.cds.unistra.fr/ftp/J/A+A/661/A147"),
        array: None,
        unit: Some(A0_PER_PC),
        extinction: 1.0,
        corner: None,
    },
    // Vergely, Lallement & Cox 2022, A&A 664, A174: laid out as the one before.
    DustMap {
        name: "vergely22",
        source: ("explore_cube_density_values_010pc_v2.fits", "https://cdsarc.cds.unistra.fr/ftp/J/A+A/664/A174"),
        array: None,
        unit: Some(A0_PER_PC),
        extinction: 1.0,
        corner: None,
    },
];

/// Spellings of mag/pc in the cubes of Lallement and Vergely.
const A0_PER_PC: &str = "A0(550nm)/parsec";

impl Choices for &'static DustMap {
    const ROWS: &'static [(&'static str, Self)] = &[
        (DUST_MAPS[0].name, &DUST_MAPS[0]),
        (DUST_MAPS[1].name, &DUST_MAPS[1]),
        (DUST_MAPS[2].name, &DUST_MAPS[2]),
        (DUST_MAPS[3].name, &DUST_MAPS[3]),
    ];
}

impl DustMap {
    /// Metadata missing from its file.
    pub fn laid_out(&self, layout: &ArrayHeader) -> ArrayHeader {
        let mut layout = layout.clone();
        if let Some((low, step)) = self.corner {
            let frame = layout.frame.get_or_insert_default();
            frame.order = "xyz";
            frame.axes = low.map(|low| Some(Axis { unit: "pc".into(), step, first: low + 0.5 * step }));
        }
        layout
    }

    /// Extinction at V that a value of one is \[mag/pc\], after a look at what the file says of its unit.
    pub fn extinction(&self, section: &Section, stated: Option<&str>) -> Result<f64> {
        match (self.unit, stated) {
            (Some(unit), Some(stated)) if unit != stated.trim() => {
                let message = format!(
                    "its values are in \"{stated}\", those of {} in \"{unit}\"; use the file of the preset, or remove preset",
                    self.name
                );
                Err(section.error("file", message))
            }
            _ => Ok(self.extinction),
        }
    }
}
