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
/// Options are the keys of a field of kind "grid" (docs/data.md). Number densities are written in cm-3,
/// extinctions in mag/pc.
///
/// Examples:
///   barnard convert smoke.vdb smoke.fits --scale "1 pc"
///   barnard convert gas.h5 gas.vdb --array /gas/density --every 2
///   barnard convert map.fits part.fits --low "-50 -50 -50 pc" --high "50 50 50 pc"
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Convert {
    /// Input file: .vdb, .h5, .nc, .fits, .npy, .npz
    input: PathBuf,
    /// Output file: .vdb, .fits, .h5, .npy
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
    /// Unit of length of files without one
    #[arg(long, value_name = "LENGTH")]
    scale: Option<String>,
    /// Centre of the box of the whole array
    #[arg(long, value_name = "X Y Z UNIT", allow_hyphen_values = true)]
    centre: Option<String>,
    /// Number of voxels per axis to average into one
    #[arg(long, value_name = "N")]
    every: Option<i64>,
    /// Memory limit of the grid, met by averaging voxels (key memory of a field), such as "512 MiB"
    #[arg(long, value_name = "SIZE")]
    fit: Option<String>,
    /// Published dust map of the Galaxy: edenhofer24, leike20, lallement22, vergely22
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Unit of the values
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,
    /// Gas mass per hydrogen nucleus in hydrogen masses, for mass densities such as g/cm3: 1.4 for solar abundances
    #[arg(long, value_name = "NUMBER")]
    mass_per_h: Option<f64>,
    /// Storage precision in sparse blocks: single, half or byte
    #[arg(long, value_name = "KIND")]
    storage: Option<String>,
    /// Factor of all values
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    factor: Option<f64>,
    /// Set blank, NaN and negative voxels to zero instead of an error
    #[arg(long)]
    clip: bool,
    /// Ignore the file's coordinates and use --low and --high, or --voxel
    #[arg(long)]
    no_wcs: bool,
    /// Name of the grid in the output file
    #[arg(long, value_name = "NAME", default_value = "density")]
    name: String,
    /// Memory limit of reading and writing the grid [GiB]
    #[arg(long, default_value_t = 16.0, value_name = "GIB")]
    memory: f64,
}

impl Convert {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        grid_writer(&self.output)?;
        check_replaceable(&self.output)?;
        if self.input.canonicalize().is_ok_and(|input| self.output.canonicalize().is_ok_and(|output| input == output)) {
            bail!("{}: the output is the input; choose another name", self.output.display());
        }
        let is_name = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
        if self.name.is_empty() || self.name.len() > LONGEST_NAME || !self.name.chars().all(is_name) {
            bail!("--name \"{}\" is invalid; use up to {LONGEST_NAME} letters, digits, _, - and .", self.name);
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
        let Some(input) = self.input.to_str() else { bail!("{}: the path is not UTF-8; rename the file", self.input.display()) };
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
