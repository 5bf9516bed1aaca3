//! Scenes: plain, validated data; what a TOML file says.
//!
//! Quantities are texts with units. Unknown keys are refused with the nearest known one, file and line. Every table that has a `kind` reads a catalogue; the
//! catalogues also make the manual, `docs/scene-format.md`.

mod albedo;
mod background;
mod band;
mod display;
mod dust;
mod emission;
mod kind;
mod loader;
mod manual;
mod method;
pub mod schema;
mod section;
mod star;
mod star_table;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use spectra::passband::Passband;
use toml_edit::Document;

pub use background::{Background, StarField};
pub use dust::Dust;
pub use emission::Emission;
pub use kind::{Kind, build_kind, build_kind_with, chosen};
pub use loader::{DEFAULT_MEMORY, Loader, read_limited};
pub use manual::manual;
pub use method::{MANY_BOUNCES, MAX_STEPS, Method, MethodEntry, StarDepth, methods};
pub use section::{Key, SceneText, Section, said};
pub use star::Star;

use crate::camera::{self, Camera};
use crate::error::Result;
use crate::field::{self, Expression, Field};
use crate::image::Display;

/// Everything that is in front of the telescope, and the telescope.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub description: String,
    /// Where the observer is.
    pub camera: Camera,
    /// Views that are worth going back to, by name.
    pub bookmarks: BTreeMap<String, Camera>,
    /// Dust that absorbs and scatters.
    pub dust: Option<Dust>,
    /// Gas that glows.
    pub emission: Vec<Emission>,
    /// Stars within or near the cloud: those of `[[star]]`, then those of each `[[star_table]]`.
    pub stars: Vec<Star>,
    /// What lies behind.
    pub background: Background,
    /// What the telescope lets through.
    pub bands: Vec<Passband>,
    /// How the picture is shown.
    pub display: Display,
    /// How the spectral integrals are done.
    pub method: Method,
    /// The files that were read, the scene's own first.
    pub files: Vec<std::path::PathBuf>,
    /// The text that it was read from.
    pub text: Arc<str>,
}

/// Keys of the scene itself.
const ROOT: &[Key] = &[
    Key::optional("name", "text", "the file's name", "name of the scene"),
    Key::optional("description", "text", "", "what it shows"),
    Key::optional("bands", "text or list", "johnson", "a set of passbands, or a list of embedded ones").of("passband-sets"),
    Key::required("camera", "table", "where the observer is"),
    Key::optional("field", "tables by name", "none", "scalar fields, [field.NAME]"),
    Key::optional("dust", "table", "none", "dust that absorbs and scatters"),
    Key::optional("emission", "list of tables", "none", "gas that glows, [[emission]]"),
    Key::optional("star", "list of tables", "none", "stars, [[star]]"),
    Key::optional("star_table", "list of tables", "none", "stars of a CSV, [[star_table]]"),
    Key::optional("background", "table", "none", "what lies behind"),
    Key::optional("band", "list of tables", "none", "passbands of one's own, [[band]]; they replace the default of `bands`"),
    Key::optional("bookmark", "tables by name", "none", "views that are worth going back to, [bookmark.NAME]"),
    Key::optional("display", "table", "defaults", "palette and stretch of pictures"),
    Key::optional("method", "table", "defaults", "how spectral integrals are done"),
];

/// (name, summary) of the kinds of spectrum that stars and backgrounds choose from.
pub fn star_spectra() -> impl Iterator<Item = (&'static str, &'static str)> {
    star::SPECTRA.iter().map(|k| (k.name, k.summary))
}

/// (name, summary) of the kinds of glowing gas.
pub fn emission_kinds() -> impl Iterator<Item = (&'static str, &'static str)> {
    emission::KINDS.iter().map(|k| (k.name, k.summary))
}

/// (name, summary) of the kinds of passband.
pub fn band_kinds() -> impl Iterator<Item = (&'static str, &'static str)> {
    band::KINDS.iter().map(|k| (k.name, k.summary))
}

/// The named fields of a scene.
pub struct Fields {
    named: BTreeMap<String, Arc<dyn Field>>,
    /// What stands in the scene about all of them.
    said: String,
}

impl Fields {
    fn new(root: &Section, loader: &Loader) -> Result<Self> {
        let mut fields = Self { named: BTreeMap::new(), said: String::new() };
        for (name, section) in root.named_tables("field")? {
            field::check_name(name).map_err(|e| section.error("name", e))?;
            let said = section.said();
            fields.named.insert(name.to_owned(), loader.field(&said, || field::build(&section, loader))?);
            fields.said += &format!("[{name}] {said}");
        }
        Ok(fields)
    }

    /// The field that the expression under `key` is.
    pub fn expression(&self, section: &Section, key: &str, loader: &Loader) -> Result<Arc<dyn Field>> {
        let formula = section.need_text(key)?;
        let lookup = |name: &str| {
            self.named.get(name).cloned().ok_or_else(|| {
                let known: Vec<&str> = self.named.keys().map(String::as_str).collect();
                spectra::SpectraError::unknown("field", name, &known).to_string()
            })
        };
        loader.field(&format!("{formula} of {}", self.said), || {
            let expression = Expression::parse(formula, lookup).map_err(|e| section.error(key, e))?;
            let field = section.wrap(key, expression.into_field(loader.memory_limit))?;
            if let Some(grid) = field.grid() {
                section.wrap(key, grid.check(formula))?;
            }
            Ok(field)
        })
    }
}

impl Scene {
    /// Reads the scene file at `path`; arrays may take `memory_limit` bytes each.
    pub fn load(path: &Path, memory_limit: u64) -> Result<Self> {
        let text = Self::read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let mut scene = Self::parse(&path.display().to_string(), &name, text, &Loader::in_folder(folder, memory_limit))?;
        scene.files.insert(0, path.to_owned());
        Ok(scene)
    }

    /// The text of the scene file at `path`.
    pub fn read_text(path: &Path) -> Result<String> {
        const LONGEST: u64 = 4 << 20;
        let bytes = read_limited(path, LONGEST)?;
        String::from_utf8(bytes).map_err(|_| crate::Error::file(path, "is no text in UTF-8; a scene is a TOML file"))
    }

    /// Reads a scene from its text; `file` is its name in messages, `name` the scene's default name.
    pub fn parse(file: &str, name: &str, text: String, loader: &Loader) -> Result<Self> {
        let source = SceneText { file: file.to_owned(), text };
        let document = Document::parse(source.text.as_str()).map_err(|e| source.error(e.span(), "TOML", e.message().trim().to_owned()))?;
        let root = Section::new(&source, document.as_table(), None, "");
        let known: Vec<&str> = ROOT.iter().map(|k| k.name).collect();
        root.check_keys(&known)?;
        Self::build(&root, source.text.as_str(), name, loader)
    }

    fn build(root: &Section, text: &str, name: &str, loader: &Loader) -> Result<Self> {
        let need = |key: &str| root.table(key)?.ok_or_else(|| root.error(key, format!("table [{key}] is missing")));
        let camera = camera::build(&need("camera")?, loader)?;
        let bookmark = |(name, section): (&str, Section)| Ok((name.to_owned(), camera::bookmark(&section, loader, &camera)?));
        let bookmarks = root.named_tables("bookmark")?.into_iter().map(bookmark).collect::<Result<_>>()?;
        let fields = Fields::new(root, loader)?;
        let bands = band::build(root, loader)?;
        let dust = root.table("dust")?.map(|s| dust::build(&s, loader, &fields)).transpose()?;
        let emission = root.tables("emission")?.iter().map(|s| emission::build(s, loader, &fields)).collect::<Result<Vec<_>>>()?;
        let mut stars = root.tables("star")?.iter().map(|s| star::build(s, loader)).collect::<Result<Vec<_>>>()?;
        for table in root.tables("star_table")? {
            stars.extend_from_slice(&loader.stars(&table.said(), || star_table::build(&table, loader))?);
        }
        let background = root.table("background")?.map(|s| background::build(&s, loader)).transpose()?;
        let display = display::build(root.table("display")?.as_ref(), &bands)?;
        let method = method::build(root.table("method")?.as_ref())?;
        let scene = Self {
            name: root.text("name")?.unwrap_or(name).to_owned(),
            description: root.text("description")?.unwrap_or("").to_owned(),
            camera,
            bookmarks,
            dust,
            emission,
            stars,
            background: background.unwrap_or_default(),
            bands,
            display,
            method,
            files: loader.files(),
            text: text.into(),
        };
        scene.check(root)?;
        Ok(scene)
    }

    /// What no single table can check: spectra and laws must reach over every passband.
    fn check(&self, root: &Section) -> Result<()> {
        let key = if root.has("band") { "band" } else { "bands" };
        for band in &self.bands {
            let (low, high) = band.support_um();
            let what = format!("passband {}", band.name());
            if let Some(dust) = &self.dust {
                root.wrap(key, dust.extinction.check(&what, low, high))?;
            }
            for spectrum in self.spectra() {
                root.wrap(key, spectrum.check(&what, low, high))?;
            }
        }
        let dust = self.dust.iter().map(|dust| ("dust", &dust.density));
        for (key, density) in dust.chain(self.emission.iter().map(|gas| ("emission", &gas.density))) {
            if let Some(fault) = density.bounds().fault() {
                return Err(root.error(key, fault));
            }
        }
        let parallel = |camera: &Camera| matches!(camera.projection, camera::Projection::Orthographic { .. });
        if self.background.star_field.is_some() && std::iter::once(&self.camera).chain(self.bookmarks.values()).any(parallel) {
            return Err(
                root.error("background", "a star field lies on the sky and needs kind = \"perspective\" in [camera] and in every bookmark")
            );
        }
        Ok(())
    }

    /// SHA-256 of the text that the scene was read from, in hexadecimal digits.
    pub fn digest(&self) -> String {
        use sha2::{Digest, Sha256};
        Sha256::digest(self.text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Every spectrum in the scene.
    fn spectra(&self) -> impl Iterator<Item = &spectra::spectrum::Spectrum> {
        let stars = self.stars.iter().map(|s| &s.spectrum);
        stars.chain(self.emission.iter().map(|e| &e.spectrum)).chain(self.background.spectrum.iter())
    }
}
