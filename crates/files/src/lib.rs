//! The files of Barnard: scenes as TOML, arrays and images in the formats of the field, and the scenes that are built
//! in.
//!
//! [`load`] reads a scene file, [`builtin`] holds scenes that need none, [`SaveImage`] writes pictures, and [`formats`]
//! what they are read and written as. A scene file is turned into a tree of [`properties`](barnard::properties) by
//! [`toml`]; what it names is found by [`SceneFiles`]. The [`catalogue`] lists everything that a scene can choose, and
//! the [`manual`] of the format is printed from the same rows.

pub mod builtin;
pub mod bundle;
pub mod cache;
pub mod catalogue;
pub mod claim;
pub mod columns;
pub mod film;
pub mod formats;
mod manual;
mod opened;
mod paths;
pub mod plates;
mod scene;
mod source;
mod text_table;
pub mod toml;

pub use formats::SaveImage;
pub use manual::manual;
pub use opened::{load, load_by, open_with};
pub use scene::{Change, SceneFile, in_folder, parse, read_text};
pub use source::{SceneFiles, read_limited};

/// Error text of a file format that this build lacks.
#[cfg(not(all(feature = "hdf5", feature = "gltf")))]
fn missing_feature(format: &str, feature: &str) -> String {
    format!("{format} requires the feature {feature}: cargo build --release -F {feature}")
}
