//! Scenes that are compiled in. Each is a file of `scenes/` and one row of [`SCENES`].

mod packed;

use std::sync::Arc;
#[cfg(not(target_family = "wasm"))]
use std::sync::LazyLock;

use spectra::SpectraError;

use barnard::error::Result;
use barnard::scene::{Loader, Scene};

use crate::scene::{Change, SceneFile};
use crate::source::{Embedded, SceneFiles};

/// One row of the catalogue of built-in scenes.
#[derive(Debug, Clone, Copy)]
pub struct BuiltinScene {
    /// The name by which a person asks for it.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// The text of the scene file.
    pub text: &'static str,
    /// The file of measured data that has to be fetched first, where there is one.
    pub needs: Option<&'static str>,
    /// A small picture of it, 16:9, JPEG; none of a scene that needs a file.
    pub thumbnail: Option<&'static [u8]>,
}

macro_rules! scene {
    ($name:literal, $summary:literal, needs $needs:expr, $thumbnail:expr) => {
        BuiltinScene {
            needs: $needs,
            name: $name,
            summary: $summary,
            text: include_str!(concat!("../../scenes/", $name, ".toml")),
            thumbnail: $thumbnail,
        }
    };
    ($name:literal, $summary:literal, needs $needs:literal) => {
        scene!($name, $summary, needs Some($needs), None)
    };
    ($name:literal, $summary:literal) => {
        scene!($name, $summary, needs None, Some(include_bytes!(concat!("../../scenes/thumbnails/", $name, ".jpg"))))
    };
}

/// All built-in scenes; the first is the one to begin with.
pub const SCENES: &[BuiltinScene] = &[
    scene!("pleiades", "seven stars of the Pleiades in a sheet of dust: a reflection nebula, Johnson BVR"),
    scene!("pillars", "pillars ionised by a cluster (density of a simulation), HST narrow bands, Hubble palette"),
    scene!("eagle", "pillars of cold gas ionised by a young cluster: HST F502N, F656N, F673N, Hubble palette"),
    scene!("orion", "the Orion Nebula, a blister on the face of its molecular cloud: [O III], H-alpha, [S II] of 3 nm"),
    scene!("emission_nebula", "an O star in the open bubble of a turbulent cloud: [O III], H-alpha, [S II] of 3 nm, Hubble palette"),
    scene!("young_cluster", "three hundred young stars in front of their cloud, multiple scattering, JWST NIRCam"),
    scene!("ring_nebula", "the Ring Nebula, a shell around a white dwarf: [O III], H-alpha, [S II] of 3 nm, Hubble palette"),
    scene!("helix", "the Helix Nebula, a disc, a torus and cometary knots around a white dwarf: [O III], H-alpha, [N II]"),
    scene!("veil", "filaments of an old supernova remnant, HST narrow bands"),
    scene!("herbig_haro", "a jet, its bow shocks and the cavities of a young star behind its disc, HST narrow bands"),
    scene!("bok_globule", "a globule like Barnard 68 in front of bulge stars, Johnson BVR"),
    scene!("six_stars", "six stars of different colours in one cloud, Johnson BVR"),
    scene!("turbulent_cloud", "a supersonic turbulent cloud (simulation) with embedded stars in the near infrared, JWST NIRCam"),
    scene!(
        "local_bubble",
        "the dust around the Sun from Gaia stars, lit by nearby hot stars; requires a file of 15.7 GB",
        needs "mean_and_std_xyz.fits"
    ),
    scene!("barres_neyret", "the model of Barres & Neyret 2023: fBm on simplex noise, extinction 1/lambda, polynomial filters, N = 100"),
];

/// Names that scenes had before, and have now.
const ALIASES: [(&str, &str); 1] = [("deck", "barres_neyret")];

#[cfg(not(target_family = "wasm"))]
macro_rules! volumes {
    ($name:literal) => {
        (concat!("volumes/", $name, ".npz"), || {
            static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| {
                let packed = include_bytes!(concat!("../../scenes/volumes/", $name, ".packed.npz"));
                packed::unpacked(packed).expect("a test unpacks every file")
            });
            &WHOLE
        })
    };
}

/// Files that built-in scenes use.
const FILES: Embedded = &[
    ("stars/local_bubble.csv", || include_bytes!("../../scenes/stars/local_bubble.csv")),
    ("stars/young_cluster.csv", || include_bytes!("../../scenes/stars/young_cluster.csv")),
    // A page reads volumes when a scene needs them.
    #[cfg(not(target_family = "wasm"))]
    volumes!("pillars_128"),
    #[cfg(not(target_family = "wasm"))]
    volumes!("turbulent_cloud_128"),
];

/// The row of the built-in scene called `name`.
///
/// # Errors
/// If there is none.
pub fn entry(name: &str) -> Result<&'static BuiltinScene> {
    let name = ALIASES.iter().find(|(before, _)| *before == name).map_or(name, |(_, now)| now);
    let known: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
    Ok(SCENES.iter().find(|s| s.name == name).ok_or_else(|| SpectraError::unknown("built-in scene", name, &known))?)
}

/// Loads the built-in scene called `name`; arrays may take `memory_limit` bytes each.
///
/// # Errors
/// If there is none.
pub fn load(name: &str, memory_limit: u64) -> Result<Scene> {
    load_by(name, memory_limit, Loader::clone)
}

/// Variant by a loader that was `prepared`, with a control for progress and interruption, or with a device.
///
/// # Errors
/// If there is none, and on interruption by the user.
pub fn load_by(name: &str, memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<Scene> {
    Ok(open(name, memory_limit, prepared)?.scene)
}

/// Variant with what it was read from.
///
/// # Errors
/// Errors of [`load_by`].
pub fn open(name: &str, memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<SceneFile> {
    open_with(name, &[], memory_limit, prepared)
}

/// Variant with other values of some keys.
///
/// # Errors
/// Errors of [`open`], and if the scene can have no such key.
pub fn open_with(name: &str, changes: &[Change], memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<SceneFile> {
    SceneFile::parse_with(&format!("built-in {name}"), name, entry(name)?.text.to_owned(), changes, prepared(&loader(memory_limit)))
}

/// Volume of a built-in scene from the packed file in which it is distributed.
///
/// # Errors
/// If the file is damaged.
pub fn unpacked_volume(packed: &[u8]) -> std::io::Result<Vec<u8>> {
    packed::unpacked(packed)
}

/// The files that built-in scenes name.
pub fn files() -> Arc<SceneFiles> {
    Arc::new(SceneFiles::embedded(FILES))
}

/// Variant with more files in memory.
pub fn files_with(given: impl IntoIterator<Item = (String, Arc<[u8]>)>) -> Arc<SceneFiles> {
    Arc::new(SceneFiles::embedded(FILES).with_given(given))
}

/// The loader that reads the files of built-in scenes, which are part of the program.
pub fn loader(memory_limit: u64) -> Loader {
    Loader::new(files(), memory_limit)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use super::*;
    use crate::formats::{Request, doubles};

    /// Mean and three values of each volume are those that numpy finds in the archives that were packed.
    #[test]
    fn volumes_are_those_of_the_runs() {
        let expected = [
            ("volumes/pillars_128.npz", "n_H", 140.01845437750598, [31.609375, 34.28125, 4.3984375]),
            ("volumes/pillars_128.npz", "x_ion", 0.5894153361878125, [1.0, 1.0, 0.0]),
            ("volumes/turbulent_cloud_128.npz", "n_H", 150.00005383836105, [14.8203125, 12.984375, 11.125]),
        ];
        for (file, name, mean, three) in expected {
            let bytes = FILES.iter().find(|(known, _)| *known == file).unwrap().1();
            let mut request = Request::new(Cursor::new(bytes), Path::new(file), Some(name), 1 << 26).unwrap();
            let (shape, values) = doubles(&mut request).unwrap();
            assert_eq!(shape, [128; 3]);
            assert_eq!([0, 3 * 128 * 128 + 40 * 128 + 77, values.len() - 1].map(|i| values[i]), three, "{file} {name}");
            let sum: f64 = values.iter().sum();
            assert!((sum / values.len() as f64 / mean - 1.0).abs() < 1e-12, "{file} {name}");
        }
    }
}
