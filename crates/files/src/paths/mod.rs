//! Paths of cameras that other programs made, as tables of text: moments, places and orientations by columns whose names
//! `[camera.path]` reads. A new format is one file and one row of [`READERS`].

#[cfg(feature = "gltf")]
mod gltf;
mod gsc;

use std::path::Path;

use barnard::data::TextTable;
use barnard::error::Result;

/// Request of a path: its bytes, its own path, the files beside it that it names, and the most rows it may have.
pub(crate) struct Request<'a> {
    pub bytes: &'a [u8],
    pub path: &'a Path,
    /// The bytes of a file by its name.
    #[cfg_attr(not(feature = "gltf"), expect(dead_code, reason = "only glTF refers to other files"))]
    pub beside: &'a dyn Fn(&str) -> Result<Vec<u8>>,
    pub most_rows: usize,
}

/// One format of paths.
struct PathReader {
    extensions: &'static [&'static str],
    read: Read,
}

/// Reads a path as a table of text.
type Read = fn(&Request) -> Result<TextTable>;

const READERS: &[PathReader] = &[PathReader { extensions: &["gltf", "glb"], read: READ_GLTF }, gsc::READER];

#[cfg(feature = "gltf")]
const READ_GLTF: Read = gltf::read;
#[cfg(not(feature = "gltf"))]
const READ_GLTF: Read = |request| Err(barnard::error::Error::file(request.path, crate::missing_feature("glTF", "gltf")));

/// Path reader of a file called `name`; `None` for a text table.
pub(crate) fn reader(name: &str) -> Option<Read> {
    let extension = Path::new(name).extension()?.to_str()?.to_lowercase();
    READERS.iter().find(|reader| reader.extensions.contains(&extension.as_str())).map(|reader| reader.read)
}

/// A table of numbers, row by row; `line` is that of the first, where the file has lines.
fn table(columns: &[&str], rows: impl Iterator<Item = (usize, Vec<f64>)>) -> TextTable {
    let cells = |(line, numbers): (usize, Vec<f64>)| (line, numbers.iter().map(|v| format!("{v:?}")).collect());
    TextTable { columns: columns.iter().map(|name| (*name).to_owned()).collect(), line: 1, rows: rows.map(cells).collect() }
}
