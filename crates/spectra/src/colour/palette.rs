//! Palettes: which band is shown in which colour.

use super::{SRGB_FROM_XYZ, transform};
use crate::cie::matching_functions;
use crate::error::{Result, SpectraError};
use crate::passband::Passband;

/// Linear RGB = Σ_c matrix\[c\] · I_c.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    /// The RGB column of each band.
    pub columns: Vec<[f64; 3]>,
}

/// One row of the catalogue of palettes.
#[derive(Clone, Copy)]
pub struct PaletteEntry {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// Makes the columns for the bands of a scene.
    pub build: fn(&[Passband]) -> Result<Vec<[f64; 3]>>,
}

/// All palettes; a user matrix is given in the scene itself.
pub const PALETTES: &[PaletteEntry] = &[
    PaletteEntry { name: "natural", summary: "natural colours of the passbands (CIE 1931); exact for cie-xyz", build: natural },
    PaletteEntry { name: "rgb", summary: "bands by wavelength: longest third red, middle green, shortest blue", build: rgb },
    PaletteEntry { name: "sho", summary: "Hubble palette: [S II] red, H-alpha green, [O III] blue; needs three bands", build: sho },
    PaletteEntry { name: "hoo", summary: "H-alpha red, [O III] green and blue; needs these two bands", build: hoo },
    PaletteEntry { name: "grey", summary: "the mean of all bands", build: |bands| Ok(Palette::grey(bands.len()).columns) },
];

impl Palette {
    /// Mean of a number of bands.
    pub fn grey(bands: usize) -> Self {
        Self { columns: vec![[1.0 / bands as f64; 3]; bands] }
    }

    /// The palette called `name` for these bands.
    ///
    /// # Errors
    /// If there is no such palette, or it is made for other bands.
    pub fn by_name(name: &str, bands: &[Passband]) -> Result<Self> {
        let known: Vec<&str> = PALETTES.iter().map(|p| p.name).collect();
        let entry = PALETTES.iter().find(|p| p.name == name).ok_or_else(|| SpectraError::unknown("palette", name, &known))?;
        Ok(Self { columns: (entry.build)(bands)? })
    }

    /// Linear RGB of one pixel's bands.
    pub fn rgb(&self, bands: impl Iterator<Item = f64>) -> [f64; 3] {
        let mut rgb = [0.0; 3];
        for (column, value) in self.columns.iter().zip(bands) {
            (0..3).for_each(|i| rgb[i] += column[i] * value);
        }
        rgb
    }
}

/// XYZ of light spread evenly over the passband, then sRGB; colours outside of the gamut are cut at zero.
fn natural(bands: &[Passband]) -> Result<Vec<[f64; 3]>> {
    if bands.iter().map(|b| b.name()).eq(["cie-x", "cie-y", "cie-z"]) {
        return Ok((0..3).map(|j| std::array::from_fn(|i| SRGB_FROM_XYZ[i][j])).collect());
    }
    let functions = matching_functions()?;
    let columns: Vec<[f64; 3]> = bands
        .iter()
        .map(|band| {
            let total = band.integrate(|_| 1.0);
            let xyz = std::array::from_fn(|i| band.integrate(|l| functions[i].at_or_zero(l)) / total);
            transform(&SRGB_FROM_XYZ, xyz).map(|v| v.max(0.0))
        })
        .collect();
    let brightest = columns.iter().flatten().fold(0.0, |m: f64, v| m.max(*v));
    if brightest < 1e-6 {
        let message = "palette \"natural\" requires a visible passband, but the scene has none; use palette = \"rgb\"";
        return Err(SpectraError::Palette(message.into()));
    }
    Ok(columns)
}

/// Positions of the bands from blue to red, in [0, 1].
fn rank(bands: &[Passband]) -> Vec<f64> {
    let pivot: Vec<f64> = bands.iter().map(|b| b.pivot().0).collect();
    let below = |p: f64| pivot.iter().filter(|q| **q < p).count() as f64;
    pivot.iter().map(|p| if bands.len() > 1 { below(*p) / (bands.len() - 1) as f64 } else { 0.5 }).collect()
}

fn rgb(bands: &[Passband]) -> Result<Vec<[f64; 3]>> {
    if bands.len() == 1 {
        return Ok(vec![[1.0; 3]]);
    }
    // Tents over rank: red at 1, green at ½, blue at 0; each colour's bands add up to one.
    let tent = |r: f64, at: f64| (1.0 - 2.0 * (r - at).abs()).max(0.0);
    let raw: Vec<[f64; 3]> = rank(bands).iter().map(|r| [tent(*r, 1.0), tent(*r, 0.5), tent(*r, 0.0)]).collect();
    if bands.len() == 2 {
        return Ok(raw.iter().map(|c| [c[0], 0.5 * (c[0] + c[2]), c[2]]).collect());
    }
    let sums: [f64; 3] = std::array::from_fn(|i| raw.iter().map(|c| c[i]).sum::<f64>().max(1e-12));
    Ok(raw.iter().map(|c| std::array::from_fn(|i| c[i] / sums[i])).collect())
}

fn sho(bands: &[Passband]) -> Result<Vec<[f64; 3]>> {
    by_rank("sho", bands, &[[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
}

fn hoo(bands: &[Passband]) -> Result<Vec<[f64; 3]>> {
    const OXYGEN: [f64; 3] = [0.0, 1.0, 1.0];
    const HYDROGEN: [f64; 3] = [1.0, 0.0, 0.0];
    let near = |lambda_um: f64| {
        let apart = |band: &&Passband| (band.pivot().0 - lambda_um).abs();
        let nearest = bands.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.filter(|band| apart(band) < NEAR_UM && band.width().0 < 2.0 * NEAR_UM).map(Passband::name)
    };
    match (near(0.500_82), near(0.656_46)) {
        (Some(oxygen), Some(hydrogen)) if bands.len() > 2 => {
            let colour = |band: &Passband| match band.name() {
                name if name == oxygen => OXYGEN,
                name if name == hydrogen => HYDROGEN,
                _ => [0.0; 3],
            };
            Ok(bands.iter().map(colour).collect())
        }
        _ => by_rank("hoo", bands, &[OXYGEN, HYDROGEN]),
    }
}

/// Largest distance between a line and its band, and half of the largest width of the band \[µm\].
const NEAR_UM: f64 = 0.008;

/// A palette of one colour for each band, from blue to red.
fn by_rank(name: &str, bands: &[Passband], colours: &[[f64; 3]]) -> Result<Vec<[f64; 3]>> {
    if bands.len() != colours.len() {
        return Err(SpectraError::Palette(format!(
            "palette \"{name}\" needs {} bands, the scene has {}; use palette = \"rgb\"",
            colours.len(),
            bands.len()
        )));
    }
    Ok(rank(bands).iter().map(|r| colours[(r * (colours.len() - 1) as f64).round() as usize]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passband::set;

    #[test]
    fn every_palette_builds() {
        for entry in PALETTES {
            let name = match entry.name {
                "hoo" => "hoo-3nm",
                "sho" => "sho-3nm",
                _ => "johnson",
            };
            assert!(Palette::by_name(entry.name, &set(name).unwrap()).is_ok(), "{}", entry.name);
        }
    }

    /// Scenes of the Hubble palette have both lines of HOO: sulphur stays dark.
    #[test]
    fn hoo_finds_its_lines_among_more() {
        for name in ["sho-3nm", "hst-wfc3-sho"] {
            let bands = set(name).unwrap();
            let palette = Palette::by_name("hoo", &bands).unwrap();
            for (band, column) in bands.iter().zip(&palette.columns) {
                let wanted = match band.pivot().nm() {
                    nm if nm < 510.0 => [0.0, 1.0, 1.0],
                    nm if nm < 660.0 => [1.0, 0.0, 0.0],
                    _ => [0.0; 3],
                };
                assert_eq!(*column, wanted, "{}", band.name());
            }
        }
        assert!(Palette::by_name("hoo", &set("johnson").unwrap()).is_err());
    }

    #[test]
    fn johnson_is_blue_green_red() {
        for name in ["natural", "rgb"] {
            let columns = Palette::by_name(name, &set("johnson").unwrap()).unwrap().columns;
            assert!(columns[0][2] > columns[0][0] && columns[1][1] > columns[1][2] && columns[2][0] > columns[2][2], "{name} {columns:?}");
        }
    }

    #[test]
    fn hubble_palette_is_sho() {
        let palette = Palette::by_name("sho", &set("sho-3nm").unwrap()).unwrap();
        assert_eq!(palette.rgb([0.1, 0.2, 0.3].into_iter()), [0.3, 0.2, 0.1]);
        assert!(Palette::by_name("sho", &set("johnson-cousins").unwrap()).is_err());
    }

    #[test]
    fn infrared_has_no_natural_colour() {
        assert!(Palette::by_name("natural", &set("2mass").unwrap()).is_err());
    }
}
