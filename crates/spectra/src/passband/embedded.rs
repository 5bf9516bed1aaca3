//! Passbands that ship, and the sets they are used in.

use std::sync::OnceLock;

use super::{Counting, Passband};
use crate::embedded::{rows, with_provenance};
use crate::error::{Result, SpectraError};
use crate::table::Table;

/// A file of throughput curves.
#[derive(Debug, Clone, Copy)]
pub struct Family {
    /// The prefix of the names of its bands.
    pub name: &'static str,
    /// The instrument, what its detector counts, and caveats, in one line.
    pub summary: &'static str,
    /// True if magnitudes in its bands are Vega magnitudes by convention.
    pub is_vega: bool,
    text: &'static str,
}

macro_rules! family {
    ($name:literal, $file:literal, $summary:literal) => {
        family!($name, $file, $summary, false)
    };
    ($name:literal, $file:literal, $summary:literal, $is_vega:literal) => {
        Family { name: $name, summary: $summary, is_vega: $is_vega, text: include_str!(concat!("../../data/passbands/", $file, ".csv")) }
    };
}

/// All files of curves.
pub const FAMILIES: &[Family] = &[
    family!("johnson", "johnson", "Johnson UBV and Cousins RI as Bessell & Murphy 2012 found them, photon", true),
    family!("bessell", "bessell", "Bessell 1990 UBVRI, energy", true),
    family!("sdss2010", "sdss2010", "SDSS ugriz with airmass 1.3, photon, absolute"),
    family!("panstarrs", "panstarrs", "Pan-STARRS 1 with airmass 1.2, photon"),
    family!("gaiadr3", "gaiadr3", "Gaia DR3 G, BP, RP, photon", true),
    family!("lsst2023", "lsst2023", "Rubin Observatory ugrizy with atmosphere, photon"),
    family!("twomass", "twomass", "2MASS JHKs, photon", true),
    family!("wise2010", "wise2010", "WISE W1 to W4, photon", true),
    family!("euclid", "euclid", "Euclid VIS and NISP, photon"),
    family!("galex", "galex", "GALEX FUV and NUV, photon"),
    family!("hst-acs-wfc", "hst_acs_wfc", "HST ACS/WFC, total throughput, photon"),
    family!("hst-wfc3", "hst_wfc3", "HST WFC3, total throughput, photon"),
    family!("hst-wfpc2", "hst_wfpc2", "HST WFPC2, total throughput (f656n filter only), photon"),
    family!("jwst-nircam", "jwst_nircam", "JWST NIRCam, total throughput 2016, photon"),
    family!("jwst-miri", "jwst_miri", "JWST MIRI, total throughput 2017, photon"),
    family!("amateur", "amateur", "idealised narrow bands of 3 to 12 nm, photon"),
];

/// The family of an embedded passband, by the beginning of its name.
pub fn family(name: &str) -> Option<&'static Family> {
    FAMILIES.iter().filter(|family| name.starts_with(family.name)).max_by_key(|family| family.name.len())
}

/// A named set of bands.
#[derive(Debug, Clone, Copy)]
pub struct SetEntry {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// The bands, from blue to red.
    pub bands: &'static [&'static str],
}

/// All sets.
pub const SETS: &[SetEntry] = &[
    SetEntry {
        name: "johnson",
        summary: "Johnson B, V and Cousins R: the classical colours",
        bands: &["johnson-B", "johnson-V", "cousins-R"],
    },
    SetEntry {
        name: "johnson-cousins",
        summary: "Johnson UBV and Cousins RI",
        bands: &["johnson-U", "johnson-B", "johnson-V", "cousins-R", "cousins-I"],
    },
    SetEntry { name: "bessell", summary: "Bessell 1990 UBVRI", bands: &["bessell-U", "bessell-B", "bessell-V", "bessell-R", "bessell-I"] },
    SetEntry { name: "sdss", summary: "SDSS ugriz", bands: &["sdss2010-u", "sdss2010-g", "sdss2010-r", "sdss2010-i", "sdss2010-z"] },
    SetEntry {
        name: "panstarrs",
        summary: "Pan-STARRS 1 grizy",
        bands: &["panstarrs-g", "panstarrs-r", "panstarrs-i", "panstarrs-z", "panstarrs-y"],
    },
    SetEntry { name: "gaia", summary: "Gaia DR3 BP, G, RP", bands: &["gaiadr3-BP", "gaiadr3-G", "gaiadr3-RP"] },
    SetEntry {
        name: "lsst",
        summary: "Rubin Observatory ugrizy",
        bands: &["lsst2023-u", "lsst2023-g", "lsst2023-r", "lsst2023-i", "lsst2023-z", "lsst2023-y"],
    },
    SetEntry { name: "2mass", summary: "2MASS J, H, Ks", bands: &["twomass-J", "twomass-H", "twomass-Ks"] },
    SetEntry { name: "wise", summary: "WISE W1 to W4", bands: &["wise2010-W1", "wise2010-W2", "wise2010-W3", "wise2010-W4"] },
    SetEntry { name: "euclid", summary: "Euclid VIS, Y, J, H", bands: &["euclid-VIS", "euclid-Y", "euclid-J", "euclid-H"] },
    SetEntry { name: "galex", summary: "GALEX FUV and NUV", bands: &["galex-fuv", "galex-nuv"] },
    SetEntry {
        name: "hst-wfc3",
        summary: "HST WFC3: broad F438W, F555W, F814W and narrow F502N, F656N, F673N",
        bands: &["hst-wfc3-f438w", "hst-wfc3-f502n", "hst-wfc3-f555w", "hst-wfc3-f656n", "hst-wfc3-f673n", "hst-wfc3-f814w"],
    },
    SetEntry {
        name: "hst-wfc3-broad",
        summary: "HST WFC3 broad bands F438W, F555W, F814W",
        bands: &["hst-wfc3-f438w", "hst-wfc3-f555w", "hst-wfc3-f814w"],
    },
    SetEntry {
        name: "hst-wfc3-sho",
        summary: "HST WFC3 narrow bands F502N, F656N, F673N: the Hubble palette",
        bands: &["hst-wfc3-f502n", "hst-wfc3-f656n", "hst-wfc3-f673n"],
    },
    SetEntry {
        name: "hst-acs",
        summary: "HST ACS/WFC F435W, F606W, F814W",
        bands: &["hst-acs-wfc-f435w", "hst-acs-wfc-f606w", "hst-acs-wfc-f814w"],
    },
    SetEntry {
        name: "jwst-nircam",
        summary: "JWST NIRCam wide bands F090W to F444W",
        bands: &[
            "jwst-nircam-f090w",
            "jwst-nircam-f150w",
            "jwst-nircam-f200w",
            "jwst-nircam-f277w",
            "jwst-nircam-f356w",
            "jwst-nircam-f444w",
        ],
    },
    SetEntry {
        name: "jwst-miri",
        summary: "JWST MIRI F560W, F770W, F1130W, F1500W",
        bands: &["jwst-miri-f560w", "jwst-miri-f770w", "jwst-miri-f1130w", "jwst-miri-f1500w"],
    },
    SetEntry {
        name: "sho-3nm",
        summary: "amateur [O III], H-alpha, [S II] of 3 nm",
        bands: &["amateur-oiii-3nm", "amateur-ha-3nm", "amateur-sii-3nm"],
    },
    SetEntry {
        name: "sho-7nm",
        summary: "amateur [O III], H-alpha, [S II] of 7 nm",
        bands: &["amateur-oiii-7nm", "amateur-ha-7nm", "amateur-sii-7nm"],
    },
    SetEntry { name: "hoo-3nm", summary: "amateur [O III] and H-alpha of 3 nm", bands: &["amateur-oiii-3nm", "amateur-ha-3nm"] },
    SetEntry { name: "cie-xyz", summary: "CIE 1931 colour matching functions: what the eye sees", bands: &["cie-x", "cie-y", "cie-z"] },
];

/// The passbands of the set called `name`.
///
/// # Errors
/// If there is no such set.
pub fn set(name: &str) -> Result<Vec<Passband>> {
    let known: Vec<&str> = SETS.iter().map(|s| s.name).collect();
    let entry = SETS.iter().find(|s| s.name == name).ok_or_else(|| SpectraError::unknown("passband set", name, &known))?;
    entry.bands.iter().map(|b| Passband::by_name(b)).collect()
}

/// The place of one curve in its file.
struct CurveSection {
    name: &'static str,
    counting: &'static str,
    body: &'static str,
}

fn sections() -> &'static [CurveSection] {
    static SECTIONS: OnceLock<Vec<CurveSection>> = OnceLock::new();
    SECTIONS.get_or_init(|| FAMILIES.iter().flat_map(|f| f.text.split("\n@ ").skip(1).filter_map(section)).collect())
}

/// "NAME COUNTING …", then rows.
fn section(text: &'static str) -> Option<CurveSection> {
    let (head, body) = text.split_once('\n')?;
    let mut words = head.split_whitespace();
    Some(CurveSection { name: words.next()?, counting: words.next()?, body })
}

const CIE: [&str; 3] = ["cie-x", "cie-y", "cie-z"];

/// The names of all embedded passbands.
pub fn names() -> Vec<&'static str> {
    sections().iter().map(|s| s.name).chain(CIE).collect()
}

pub(super) fn named(name: &str) -> Result<Passband> {
    if let Some(i) = CIE.iter().position(|n| *n == name) {
        let table = crate::cie::matching_functions()?[i].clone();
        return Passband::new(name, Counting::Energy, table);
    }
    for family in FAMILIES {
        with_provenance(family.name, family.text)?;
    }
    let section = sections().iter().find(|s| s.name == name).ok_or_else(|| SpectraError::unknown("passband", name, &names()))?;
    let (x, y) = rows(name, section.body, 2)?.iter().map(|r| (r[0] * 1e-3, r[1])).unzip();
    Passband::new(name, Counting::by_name(section.counting)?, Table::new(name, x, y)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every curve states the pivot that another program found in closed form, piece by piece between the samples.
    #[test]
    fn every_pivot_is_the_stated_one() {
        let mut count = 0;
        for family in FAMILIES {
            for head in family.text.lines().filter_map(|l| l.strip_prefix("@ ")) {
                let words: Vec<&str> = head.split_whitespace().collect();
                let stated: f64 = words[2].strip_prefix("pivot_nm=").unwrap().parse().unwrap();
                let band = Passband::by_name(words[0]).unwrap();
                assert!((band.pivot().nm() / stated - 1.0).abs() < 1e-7, "{}: {} {stated}", words[0], band.pivot().nm());
                count += 1;
            }
        }
        assert_eq!(count, 206);
    }

    #[test]
    fn every_set_loads_from_blue_to_red() {
        for entry in SETS {
            let bands = set(entry.name).unwrap();
            if entry.name != "cie-xyz" {
                assert!(bands.windows(2).all(|b| b[0].pivot().0 < b[1].pivot().0), "{}", entry.name);
            }
        }
    }

    #[test]
    fn unknown_passbands_are_answered() {
        let message = Passband::by_name("hst-wfc3-f656").unwrap_err().to_string();
        assert!(message.contains("hst-wfc3-f656n"), "{message}");
    }
}
