//! `barnard convert`

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::bail;
use barnard::data::Inputs;
use barnard::field::load;
use barnard::properties::{Section, Table, Value};
use barnard_files::SceneFiles;
use barnard_files::formats::{GridFile, check_replaceable, grid_writer, save_grid};
use clap::Args;

use crate::source::memory_limit;

/// Longest name of a grid.
const LONGEST_NAME: usize = 60;

/// Reads a grid of one format and writes it in another, in parsecs.
///
/// The keys of a field of kind "grid" are options; docs/data.md says what they do. Number densities are written in cm-3,
/// extinctions in mag/pc.
///
/// Examples:
///   barnard convert smoke.vdb smoke.fits --scale "1 pc"
///   barnard convert gas.h5 gas.vdb --array /gas/density --every 2
///   barnard convert map.fits part.fits --low "-50 -50 -50 pc" --high "50 50 50 pc"
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Convert {
    /// The file that is read: .vdb, .h5, .nc, .fits, .npy, .npz
    input: PathBuf,
    /// The file that is written: .vdb, .fits, .h5, .npy
    output: PathBuf,
    /// Grid of a .vdb, dataset of an HDF5 file, array of an .npz, HDU of a FITS file
    #[arg(long, value_name = "NAME")]
    array: Option<String>,
    /// Axes of the array, slowest first, such as zyx
    #[arg(long, value_name = "ORDER")]
    axes: Option<String>,
    /// Lowest corner of the box or the part, such as "-1 -1 -1 pc"
    #[arg(long, value_name = "X Y Z UNIT", allow_hyphen_values = true)]
    low: Option<String>,
    /// Highest corner
    #[arg(long, value_name = "X Y Z UNIT", allow_hyphen_values = true)]
    high: Option<String>,
    /// Edge of a cubic voxel, such as "0.01 pc"
    #[arg(long, value_name = "LENGTH")]
    voxel: Option<String>,
    /// Unit of length for files whose lengths have none
    #[arg(long, value_name = "LENGTH")]
    scale: Option<String>,
    /// Middle of the box of all of the array
    #[arg(long, value_name = "X Y Z UNIT", allow_hyphen_values = true)]
    centre: Option<String>,
    /// So many voxels along each axis become one, their mean
    #[arg(long, value_name = "N")]
    every: Option<i64>,
    /// The grid is made as coarse as it must be to take no more than this (the key memory of a field), such as "512 MiB"
    #[arg(long, value_name = "SIZE")]
    fit: Option<String>,
    /// A measured map of the Galaxy's dust: edenhofer24, leike20, lallement22, vergely22
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Unit of the values
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,
    /// Mass of the gas per hydrogen nucleus in hydrogen atoms, for mass densities such as g/cm3: 1.4 for solar abundances
    #[arg(long, value_name = "NUMBER")]
    mass_per_h: Option<f64>,
    /// Storage precision in sparse blocks: single, half or byte
    #[arg(long, value_name = "KIND")]
    storage: Option<String>,
    /// Every value is multiplied by it
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    factor: Option<f64>,
    /// Blank, NaN and negative voxels become zero instead of an error
    #[arg(long)]
    clip: bool,
    /// The file's own frame is not read: --low and --high, or --voxel, say better
    #[arg(long)]
    no_wcs: bool,
    /// Name of the grid in the file that is written
    #[arg(long, value_name = "NAME", default_value = "density")]
    name: String,
    /// Most memory that the grid, and writing it, may take [GiB]
    #[arg(long, default_value_t = 16.0, value_name = "GIB")]
    memory: f64,
}

impl Convert {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        grid_writer(&self.output)?;
        check_replaceable(&self.output)?;
        if self.input.canonicalize().is_ok_and(|input| self.output.canonicalize().is_ok_and(|output| input == output)) {
            bail!("{}: is what is read; choose another name for the output", self.output.display());
        }
        let is_name = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
        if self.name.is_empty() || self.name.len() > LONGEST_NAME || !self.name.chars().all(is_name) {
            bail!("--name \"{}\" is no name: up to {LONGEST_NAME} letters, digits, _, - and . are one in every format", self.name);
        }
        let keys = self.keys()?;
        let memory_limit = memory_limit(self.memory)?;
        let inputs = Inputs::new(Arc::new(SceneFiles::in_folder(".")), memory_limit);
        let loaded = load(&Section::new(&keys, "convert"), &inputs)?;
        save_grid(&self.output, &GridFile { grid: &loaded.grid, unit: loaded.unit.as_deref(), name: &self.name, memory_limit })?;
        let lattice = loaded.grid.lattice();
        let ([x, y, z], bounds) = (lattice.dims, lattice.bounds);
        let corner = |p: barnard::glam::DVec3| format!("{} {} {} pc", p.x, p.y, p.z);
        say!("wrote {}", self.output.display());
        say!("  voxels      {x} x {y} x {z}");
        say!("  low         {}", corner(bounds.low));
        say!("  high        {}", corner(bounds.high));
        say!("  unit        {}", loaded.unit.as_deref().unwrap_or("none is known"));
        let largest = loaded.grid.largest([0..x, 0..y, 0..z]);
        say!("  largest     {largest:e}");
        Ok(ExitCode::SUCCESS)
    }

    /// The options as the keys of a field.
    fn keys(&self) -> anyhow::Result<Table> {
        let mut keys = Table::new(None);
        let Some(input) = self.input.to_str() else { bail!("{}: a path that is no UTF-8 cannot be read", self.input.display()) };
        keys.insert("file", Value::Text(input.to_owned()));
        let texts = [
            ("array", &self.array),
            ("axes", &self.axes),
            ("low", &self.low),
            ("high", &self.high),
            ("voxel", &self.voxel),
            ("scale", &self.scale),
            ("centre", &self.centre),
            ("memory", &self.fit),
            ("preset", &self.preset),
            ("unit", &self.unit),
            ("storage", &self.storage),
        ];
        for (key, value) in texts.into_iter().filter_map(|(key, value)| Some((key, value.clone()?))) {
            keys.insert(key, Value::Text(value));
        }
        if let Some(every) = self.every {
            keys.insert("every", Value::Integer(every));
        }
        for (key, number) in [("factor", self.factor), ("mass_per_h", self.mass_per_h)] {
            number.into_iter().for_each(|number| keys.insert(key, Value::Number(number)));
        }
        if self.clip {
            keys.insert("clip", Value::Flag(true));
        }
        if self.no_wcs {
            keys.insert("wcs", Value::Flag(false));
        }
        Ok(keys)
    }
}
