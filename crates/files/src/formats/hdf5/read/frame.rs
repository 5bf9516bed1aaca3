//! Attributes of a dataset: its unit, the names of its axes, and where they lie.
//!
//! Read are the dimension scales of HDF5, which netCDF and xarray write, and the edges of yt's containers and files.

use barnard::data::{AXIS_ORDERS, ArrayFrame, Axis};
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, RawAttribute};
use spectra::units::{Length, Quantity};

use super::FoundDataset;
use super::slabs::{Packing, Value, stored};
use crate::formats::numbers::Number;

/// Attributes that hold the unit of values.
const UNITS: [&str; 2] = ["units", "unit"];
/// Attributes of the corners of a box, by x, y and z; their unit is in an attribute of the same name and `_units`.
const EDGES: [(&str, &str); 2] = [("left_edge", "right_edge"), ("domain_left_edge", "domain_right_edge")];
/// The unit of lengths that yt takes from its files, and the attribute that says how long it is.
const CODE_LENGTH: (&str, &str) = ("code_length", "length_unit");
/// The attribute that MATLAB gives to every array of a file of version 7.3.
const MATLAB: &str = "MATLAB_class";
/// Labels of axes, steps and offset of a mesh. Source: openPMD standard 1.1.0, "Mesh Based Records".
const MESH_LABELS: &str = "axisLabels";
/// The attribute of the powers of length, mass, time, current, temperature, amount and luminous intensity in a unit, and
/// units of densities by them.
const UNIT_DIMENSION: &str = "unitDimension";
const MESH_UNITS: [([f64; 7], &str); 3] = [
    ([-3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "m-3"),
    ([-3.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], "kg/m3"),
    ([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "/m"),
];
/// Longest axis whose coordinates are read, and most elements of an attribute that is.
const LONGEST: usize = 1 << 20;
const MOST: u64 = 64;
/// Tolerance for unequal coordinate steps, relative to a step.
const EVEN: f64 = 1e-3;

/// The lower and the upper corner of a box by x, y and z, and their unit before them.
type BoxCorners = (String, Vec<f64>, Vec<f64>);

/// A dataset and the groups around it, to be asked for what they say.
pub struct DatasetPlace<'a> {
    found: &'a FoundDataset,
    /// The dimension scale of each axis, where it has one.
    scales: Vec<Option<Dataset>>,
}

impl<'a> DatasetPlace<'a> {
    /// The surroundings of a dataset.
    pub fn of(found: &'a FoundDataset) -> Self {
        Self { found, scales: scales(found) }
    }

    /// The unit of its values, as it is written, or that of a mesh of openPMD, whose values are in SI units once
    /// multiplied by `unitSI`.
    pub fn unit(&self) -> Option<String> {
        unit_of(&self.found.dataset).or_else(|| {
            let powers = self.numbers(UNIT_DIMENSION)?;
            let known = MESH_UNITS.iter().find(|(known, _)| known[..] == powers[..]);
            Some(known.map_or_else(|| format!("openPMD {UNIT_DIMENSION} {powers:?}"), |(_, name)| (*name).to_owned()))
        })
    }

    /// The factor that turns the values of a mesh of openPMD into SI units.
    fn mesh_factor(&self) -> Option<f64> {
        self.numbers(UNIT_DIMENSION)?;
        self.numbers("unitSI")?.first().copied()
    }

    /// How its numbers were packed. Sources: NetCDF Users Guide, appendix A (attribute conventions); CF 1.11, §2.5.1.
    pub fn packing(&self) -> Packing {
        let dataset = &self.found.dataset;
        let all = |name: &str| {
            let attribute = attribute_of(dataset, name)?;
            // Some programs write numbers as texts.
            if stored(&attribute.datatype).is_none() {
                return text(&attribute)?.parse().ok().map(|number| vec![number]);
            }
            Some(attribute.read_1d::<Value<f64>>().ok()?.into_iter().map(|v| v.0).collect::<Vec<f64>>())
        };
        let number = |name: &str| all(name)?.first().copied();
        let kind = stored(dataset.dtype());
        let is_unsigned =
            attribute_of(dataset, "_Unsigned").and_then(|attribute| text(&attribute)).is_some_and(|text| text.eq_ignore_ascii_case("true"));
        let bits = kind.filter(|_| is_unsigned).filter(|kind| matches!(kind.kind, Number::Int(1 | 2 | 4)));
        let unsigned = bits.map(|kind| 2f64.powi(8 * kind.size() as i32));
        // Limits and fill values of such numbers may be written as signed ones.
        let lifted = |v: f64| if v < 0.0 { v + unsigned.unwrap_or(0.0) } else { v };
        let (scale, offset) = (number("scale_factor"), number("add_offset"));
        let scale = (scale.is_some() || offset.is_some()).then(|| (scale.unwrap_or(1.0), offset.unwrap_or(0.0)));
        let scale = scale.or(self.mesh_factor().filter(|factor| *factor != 1.0).map(|factor| (factor, 0.0)));
        // A blank may be written in more digits than the values have.
        let is_single = kind.is_some_and(|kind| kind.kind == Number::Float(4));
        let rounded = |v: f64| if is_single { f64::from(v as f32) } else { v };
        let mut blank: Vec<f64> = ["_FillValue", "missing_value"].into_iter().filter_map(all).flatten().map(lifted).map(rounded).collect();
        if attribute_of(dataset, "_FillValue").is_none() {
            blank.extend(kind.and_then(|kind| default_fill(kind.kind, self.is_netcdf())).map(lifted));
        }
        let range = all("valid_range").filter(|range| range.len() == 2).map(|range| (Some(range[0]), Some(range[1])));
        let (low, high) = range.unwrap_or((number("valid_min"), number("valid_max")));
        let valid = (low.is_some() || high.is_some()).then(|| (low.map_or(f64::NEG_INFINITY, lifted), high.map_or(f64::INFINITY, lifted)));
        Packing { scale, blank, valid, unsigned }
    }

    /// True if the file was written by the netCDF library.
    fn is_netcdf(&self) -> bool {
        self.found.groups.first().is_some_and(|root| small(root.raw_attributes(), None) && root.attribute("_NCProperties").is_ok())
    }

    /// The frame of three of its axes, the slowest first.
    pub fn frame(&self, axes: [usize; 3], shape: [usize; 3]) -> ArrayFrame {
        let names = self.names(axes);
        // Dimensions without names are called so by the netCDF library.
        let is_named = names.iter().all(|name| !name.is_empty() && !name.starts_with("phony_dim"));
        let known = order_of(&names);
        // MATLAB writes its arrays with their axes reversed.
        let is_of_matlab = !is_named && attribute_of(&self.found.dataset, MATLAB).is_some();
        let order = known.unwrap_or(if is_of_matlab { "zyx" } else { "xyz" });
        let mut frame = ArrayFrame { order, unit: self.unit(), ..ArrayFrame::default() };
        if is_named && known.is_none() {
            frame.unnamed = Some(names.join(", "));
        }
        let edges = self.edges().unwrap_or_else(|problem| {
            frame.problem = Some(problem);
            None
        });
        for (i, letter) in order.chars().enumerate() {
            match self.coordinates(axes[i], shape[i]).or_else(|| Some(Ok(self.mesh_axis(axes[i])?))) {
                Some(Ok(axis)) => frame.axes[i] = Some(axis),
                Some(Err(other)) => frame.others[i] = Some(other),
                None => {
                    frame.is_by_letter |= edges.is_some() && names.iter().all(String::is_empty);
                    frame.axes[i] = edges.as_ref().and_then(|(unit, low, high)| {
                        let at = "xyz".find(letter)?;
                        let step = (high[at] - low[at]) / shape[i] as f64;
                        let usable = step.is_finite() && step != 0.0 && low[at].is_finite();
                        usable.then(|| Axis { unit: unit.clone(), step, first: low[at] + 0.5 * step })
                    });
                }
            }
        }
        frame
    }

    /// The axis of a mesh of openPMD \[m\]: cells begin at the offset, values stand at `position` within them.
    fn mesh_axis(&self, axis: usize) -> Option<Axis> {
        let numbers = |name: &str| self.numbers(name).filter(|all| all.len() == self.found.dataset.ndim());
        let slot = if self.is_fortran_mesh() { self.found.dataset.ndim() - 1 - axis } else { axis };
        let (spacing, offset) = (numbers("gridSpacing")?[slot], numbers("gridGlobalOffset")?[slot]);
        let metres = self.numbers("gridUnitSI")?.first().copied()?;
        let within = numbers("position").map_or(0.0, |position| position[slot]);
        let step = spacing * metres;
        let first = (offset + within * spacing) * metres;
        (step.is_finite() && step != 0.0 && first.is_finite()).then(|| Axis { unit: "m".into(), step, first })
    }

    /// True if the labels of an openPMD mesh are in Fortran order, the fastest axis first.
    fn is_fortran_mesh(&self) -> bool {
        self.text("dataOrder").is_some_and(|order| order.eq_ignore_ascii_case("F"))
    }

    /// The names of some axes in lower case, their labels or those of their scales; empty where they have none.
    fn names(&self, axes: [usize; 3]) -> [String; 3] {
        let labels =
            attribute_of(&self.found.dataset, "DIMENSION_LABELS").and_then(|labels| labels.read_strings().ok()).unwrap_or_default();
        // Labels of openPMD are those of the mesh, in the order of its array, or reversed where that is Fortran's.
        let mesh = self.attribute(MESH_LABELS).and_then(|labels| labels.read_strings().ok()).unwrap_or_default();
        let is_fortran = self.is_fortran_mesh();
        axes.map(|axis| {
            if let Some(label) = mesh.get(if is_fortran { mesh.len().wrapping_sub(axis + 1) } else { axis }) {
                return label.trim_matches([' ', '\0']).to_lowercase();
            }
            let label = labels.get(axis).map(String::as_str).filter(|label| !label.is_empty());
            label.or_else(|| Some(self.scales.get(axis)?.as_ref()?.name())).unwrap_or_default().to_lowercase()
        })
    }

    /// The axis that a dimension scale says, or what is wrong with its coordinates; nothing where it has none.
    fn coordinates(&self, axis: usize, count: usize) -> Option<Result<Axis, String>> {
        let scale = self.scales.get(axis)?.as_ref()?;
        stored(scale.dtype())?;
        if scale.shape() != [count as u64] || !(2..=LONGEST).contains(&count) {
            return None;
        }
        let values: Vec<f64> = scale.read_array::<Value<f64>>().ok()?.iter().map(|v| v.0).collect();
        // A dimension without coordinates has a scale of zeros.
        let (first, last) = (values[0], values[count - 1]);
        let step = (last - first) / (count - 1) as f64;
        if step == 0.0 {
            return None;
        }
        let room = EVEN * step.abs() + f64::from(f32::EPSILON) * first.abs().max(last.abs());
        let is_even = (0..count).all(|i| (values[i] - (first + i as f64 * step)).abs() <= room);
        Some(if is_even {
            Ok(Axis { unit: unit_of(scale).unwrap_or_default(), step, first })
        } else {
            Err(format!("coordinate of unequal steps (dataset \"{}\")", scale.name()))
        })
    }

    /// The unit and the corners of its box, where it or a group around it states them; corners in two units are given in
    /// that of the lower one.
    fn edges(&self) -> Result<Option<BoxCorners>, String> {
        let named = EDGES.into_iter().find_map(|(low, high)| {
            let three = |name: &str| self.numbers(name).filter(|numbers| numbers.len() == 3);
            Some(([low, high], three(low)?, three(high)?))
        });
        let Some((names, low, mut high)) = named else { return Ok(None) };
        let [unit, other] = names.map(|name| self.text(&format!("{name}_units")).unwrap_or_default());
        if !other.is_empty() && other != unit {
            let (Some(mesh_unit), Some(size)) = (Length::unit_size(&unit), Length::unit_size(&other)) else {
                return Err(format!("corners are in \"{unit}\" and in \"{other}\", which cannot be converted"));
            };
            high.iter_mut().for_each(|v| *v *= size / mesh_unit);
        }
        Ok(Some(self.in_code_length(unit, low, high)))
    }

    /// Corners in a length that the file defines, where they are in units of it.
    fn in_code_length(&self, unit: String, low: Vec<f64>, high: Vec<f64>) -> BoxCorners {
        if unit != CODE_LENGTH.0 {
            return (unit, low, high);
        }
        // What a length of one is stands in the file too.
        let (size, name) = (self.numbers(CODE_LENGTH.1), self.text(&format!("{}_units", CODE_LENGTH.1)));
        let (Some([size]), Some(name)) = (size.as_deref(), name) else { return (unit, low, high) };
        let scaled = |edge: Vec<f64>| edge.into_iter().map(|v| v * size).collect();
        (name, scaled(low), scaled(high))
    }

    /// An attribute of the dataset, or of the innermost group around it that has it.
    fn attribute(&self, name: &str) -> Option<Attribute> {
        // Asking a group for one attribute reads all of them: one with a list that is too long is passed over.
        let attribute = |group: &Group| small(group.raw_attributes(), None).then(|| group.attribute(name).ok()).flatten();
        attribute_of(&self.found.dataset, name).or_else(|| self.found.groups.iter().rev().find_map(attribute))
    }

    fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let attribute = self.attribute(name)?;
        stored(&attribute.datatype)?;
        Some(attribute.read_1d::<Value<f64>>().ok()?.into_iter().map(|v| v.0).collect())
    }

    fn text(&self, name: &str) -> Option<String> {
        text(&self.attribute(name)?)
    }
}

/// The number by which netCDF fills what was never written. Source: netcdf.h, NC_FILL_*. Whole numbers may mean it only
/// in its own files.
fn default_fill(kind: Number, is_netcdf: bool) -> Option<f64> {
    match kind {
        Number::Float(4 | 8) => Some(9.969_209_968_386_869e36),
        Number::Int(2) if is_netcdf => Some(-32_767.0),
        Number::Int(4) if is_netcdf => Some(-2_147_483_647.0),
        _ => None,
    }
}

/// The order of axes by their names: each is, begins with or ends with one of x, y and z, or they are i, j and k, or
/// numbered from one.
fn order_of(names: &[String; 3]) -> Option<&'static str> {
    let by = |letters: &dyn Fn(&str) -> Option<char>| {
        let order: Option<String> = names.iter().map(|name| letters(name)).collect();
        order.and_then(|order| AXIS_ORDERS.into_iter().find(|known| *known == order))
    };
    let spatial = |c: Option<char>| c.filter(|c| "xyz".contains(*c));
    let index = |name: &str| Some(['x', 'y', 'z'][["i", "j", "k"].iter().position(|known| *known == name)?]);
    let numbered = |name: &str| Some(['x', 'y', 'z'][["1", "2", "3"].iter().position(|digit| name.ends_with(digit))?]);
    by(&|name| spatial(name.chars().next()))
        .or_else(|| by(&|name| spatial(name.chars().last())))
        .or_else(|| by(&index))
        .or_else(|| by(&numbered))
}

/// An attribute of a dataset, where it is no longer than those that are read here.
fn attribute_of(dataset: &Dataset, name: &str) -> Option<Attribute> {
    small(dataset.raw_attributes(), Some(name)).then(|| dataset.attribute(name).ok()).flatten()
}

/// True if the attributes of a name, or all, hold few elements: each of a list may be as long as the file.
fn small(attributes: hdf5_reader::error::Result<Vec<RawAttribute>>, name: Option<&str>) -> bool {
    let few = |attribute: &RawAttribute| {
        let is_list = matches!(attribute.message().datatype, Datatype::VarLen { .. } | Datatype::String { .. });
        !is_list || attribute.message().dataspace.num_elements().is_ok_and(|count| count <= MOST)
    };
    attributes.is_ok_and(|all| all.iter().filter(|attribute| name.is_none_or(|name| attribute.name() == name)).all(few))
}

/// The unit that a dataset says.
fn unit_of(dataset: &Dataset) -> Option<String> {
    UNITS.iter().find_map(|name| text(&attribute_of(dataset, name)?))
}

/// A text that is not empty.
fn text(attribute: &Attribute) -> Option<String> {
    let text = attribute.read_string().or_else(|_| attribute.read_strings().map(|all| all.concat())).ok()?;
    Some(text.trim_matches([' ', '\0']).to_owned()).filter(|text| !text.is_empty())
}

/// The dimension scales of a dataset. Source: HDF5 Dimension Scale Specification, `DIMENSION_LIST`: for each axis a list
/// of references to datasets, which are their addresses.
fn scales(found: &FoundDataset) -> Vec<Option<Dataset>> {
    const ADDRESS: usize = 8;
    let dataset = &found.dataset;
    let Some(list) = attribute_of(dataset, "DIMENSION_LIST") else { return Vec::new() };
    let reference = |entry: &[u8]| {
        let addresses = dataset.resolve_vlen_reference_bytes(entry, ADDRESS).ok()?;
        let address = u64::from_le_bytes(*addresses.first_chunk::<ADDRESS>()?);
        // One dataset that cannot be opened does not hide the others.
        let opened = |group: &Group| {
            group.member_names().unwrap_or_default().1.into_iter().filter_map(|name| group.dataset(&name).ok()).collect::<Vec<_>>()
        };
        found.groups.iter().rev().find_map(|group| opened(group).into_iter().find(|scale| scale.address() == address))
    };
    list.raw_data.chunks_exact(dataset.vlen_reference_size()).take(dataset.ndim()).map(reference).collect()
}
