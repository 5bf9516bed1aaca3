//! Pictures as states that pickles hold: numbers and words as they are, and the part of the scene that says how pictures are shown.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use barnard::backend::describe;
use barnard::image::{Band, ImagePart, Layer, LayerContent, Moment, PixelScale, Plane, PointSource, Samples, SpectralAxis, View};
use barnard::keywords::{Keyword, Value};
use barnard::observation::InUnit;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use spectra::colour::Palette;

use crate::image::Image;
use crate::report;
use crate::scene::{Owner, Reader};
use crate::tree;

/// Parts of a scene that a picture does not need: all that it was computed from.
const COMPUTED: [&str; 12] =
    ["dust", "gas", "emission", "star", "star_table", "background", "field", "detail", "animation", "sequence", "method", "bookmark"];

/// A keyword: name, text, number, whole number, comment.
type KeywordState = (String, Option<String>, Option<f64>, Option<i64>, String);
/// A band: name, pivot, width, how it counts, what its unit multiplies by, zero of its magnitudes, true for standard errors, keywords.
type Described = (String, Option<f64>, Option<f64>, Option<String>, Option<f64>, Option<f64>, bool, Vec<KeywordState>);
/// Channels: middle of the first, width, count, wavelength at rest, resolving power.
type BandScale = (f64, f64, usize, Option<f64>, Option<f64>);
/// Columns of a palette, whether bands are balanced, black and white where they are numbers.
type DisplayState = (Vec<[f64; 3]>, bool, Option<f64>, Option<f64>);
/// A layer: name, number of its content, samples.
type Layered<'py> = (String, usize, Bound<'py, PyAny>);

const CONTENTS: [LayerContent; 4] = [LayerContent::Light, LayerContent::Depth, LayerContent::OpticalDepth, LayerContent::Mask];
const SCALES: [fn(f64) -> PixelScale; 5] =
    [PixelScale::Angle, PixelScale::Length, PixelScale::Equidistant, PixelScale::PlateCarree, PixelScale::OnCube];

/// All that a picture is.
#[derive(IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
struct ImageState<'py> {
    tree: Bound<'py, PyDict>,
    folder: Option<PathBuf>,
    limit: u64,
    size: (usize, usize),
    bands: Vec<Described>,
    spectral: Option<BandScale>,
    samples: Bound<'py, PyAny>,
    views: (usize, usize),
    pixel: Option<(usize, f64)>,
    axis: (f64, f64),
    part: Option<(usize, usize, (usize, usize))>,
    circle: Option<f64>,
    view: Option<[[[f64; 4]; 4]; 2]>,
    points: Vec<(f64, f64, Vec<f64>)>,
    moment: Option<(i64, f64, f64)>,
    report: report::ReportState,
    notes: Vec<(String, String)>,
    keywords: Vec<KeywordState>,
    shown: DisplayState,
    layers: Vec<Layered<'py>>,
    warnings: Vec<String>,
}

/// Picture as a dictionary for pickling.
#[pyfunction]
pub fn state<'py>(py: Python<'py>, picture: &Image) -> PyResult<Bound<'py, PyAny>> {
    let (image, words) = (&picture.image, &picture.scene.words);
    let tree = tree::dictionary(py, &words.table)?;
    for key in COMPUTED {
        if tree.contains(key)? {
            tree.del_item(key)?;
        }
    }
    let pixel = image.pixel.map(|pixel| match pixel {
        PixelScale::Angle(step) => (0, step),
        PixelScale::Length(step) => (1, step),
        PixelScale::Equidistant(step) => (2, step),
        PixelScale::PlateCarree(step) => (3, step),
        PixelScale::OnCube(step) => (4, step),
    });
    let display = &picture.options.display;
    let layer = |stated: &Layer| {
        let content = CONTENTS.iter().position(|content| *content == stated.content).unwrap_or_default();
        Ok((stated.name.clone(), content, flat(py, &stated.samples)))
    };
    let state = ImageState {
        tree,
        folder: words.folder.as_ref().map(std::path::absolute).transpose()?,
        limit: words.limit,
        size: (image.width, image.height),
        bands: image.bands.iter().map(described).collect(),
        spectral: image.spectral.map(|axis| (axis.first_um, axis.step_um, axis.count, axis.rest_um, axis.resolving_power)),
        samples: flat(py, &image.samples),
        views: image.views,
        pixel,
        axis: image.axis,
        part: image.part.map(|part| (part.column, part.row, part.whole)),
        circle: image.circle,
        view: image.view.map(|view| [view.world_to_camera, view.world_to_screen]),
        points: image.points.iter().map(|point| (point.column, point.row, point.flux.clone())).collect(),
        moment: image.moment.map(|moment| (moment.frame, moment.time_s, moment.per_second)),
        report: report::ReportState::from(&image.report),
        notes: image.notes.clone(),
        keywords: image.keywords.iter().map(words_of).collect(),
        shown: (display.palette.columns.clone(), display.balance, display.black.radiance(), display.white.radiance()),
        layers: image.layers.iter().map(layer).collect::<PyResult<_>>()?,
        warnings: picture.warnings.clone(),
    };
    Ok(state.into_pyobject(py)?.into_any())
}

/// The picture of a state.
#[pyfunction]
pub fn restored(py: Python, state: &Bound<PyAny>) -> PyResult<Image> {
    let state: ImageState = state.extract()?;
    let reader = Reader::new(py, state.folder, state.limit)?;
    let scene: Owner = reader.read(py, &state.tree, "scene")?.0;
    let band = |(name, pivot_um, width_um, counting, times, zero, is_error, keywords): Described| {
        let in_unit = times.map(InUnit::Times).or(zero.map(|zero| InUnit::Magnitudes { zero }));
        let keywords = keywords.into_iter().map(keyword).collect();
        let plane = if is_error { Plane::StandardError } else { Plane::Radiance };
        Band { name, plane, pivot_um, width_um, counting: counting.map(lasting), in_unit, keywords }
    };
    let layer = |(name, content, values): Layered| {
        let content = *CONTENTS.get(content).ok_or_else(|| PyValueError::new_err("a layer of no known content"))?;
        Ok(Layer { name, content, samples: samples(&values)? })
    };
    let bands: Vec<Band> = state.bands.into_iter().map(band).collect();
    let all = samples(&state.samples)?;
    if Some(all.len()) != state.size.0.checked_mul(state.size.1).and_then(|count| count.checked_mul(bands.len())) {
        return Err(PyValueError::new_err("a picture whose samples do not have its size"));
    }
    let pixel = state.pixel.and_then(|(kind, step)| SCALES.get(kind).map(|scale| scale(step)));
    let (columns, balance, black, white) = state.shown;
    let image = describe(&scene, &scene.camera, all);
    let mut options = scene.save_options();
    options.display =
        barnard::image::Display { palette: Palette { columns }, balance, black: black.into(), white: white.into(), ..options.display };
    let image = barnard::Image {
        width: state.size.0,
        height: state.size.1,
        bands,
        spectral: state.spectral.map(|(first_um, step_um, count, rest_um, resolving_power)| SpectralAxis {
            first_um,
            step_um,
            count,
            rest_um,
            resolving_power,
        }),
        views: state.views,
        pixel,
        axis: state.axis,
        part: state.part.map(|(column, row, whole)| ImagePart { column, row, whole }),
        circle: state.circle,
        view: state.view.map(|[world_to_camera, world_to_screen]| View { world_to_camera, world_to_screen }),
        points: state.points.into_iter().map(|(column, row, flux)| PointSource { column, row, flux }).collect(),
        moment: state.moment.map(|(frame, time_s, per_second)| Moment { frame, time_s, per_second }),
        report: state.report.into(),
        notes: state.notes,
        keywords: state.keywords.into_iter().map(keyword).collect(),
        layers: state.layers.into_iter().map(layer).collect::<PyResult<_>>()?,
        ..image
    };
    Ok(Image { scene, image, options, warnings: state.warnings })
}

fn described(band: &Band) -> Described {
    let (times, zero) = match band.in_unit {
        Some(InUnit::Times(times)) => (Some(times), None),
        Some(InUnit::Magnitudes { zero }) => (None, Some(zero)),
        None => (None, None),
    };
    let keywords = band.keywords.iter().map(words_of).collect();
    let counting = band.counting.map(str::to_owned);
    (band.name.clone(), band.pivot_um, band.width_um, counting, times, zero, band.plane == Plane::StandardError, keywords)
}

fn words_of(keyword: &Keyword) -> KeywordState {
    let (text, number, whole) = match &keyword.value {
        Value::Text(text) => (Some(text.clone()), None, None),
        Value::Number(number) => (None, Some(*number), None),
        Value::Integer(whole) => (None, None, Some(*whole)),
    };
    (keyword.name.to_owned(), text, number, whole, keyword.comment.to_owned())
}

fn keyword((name, text, number, whole, comment): KeywordState) -> Keyword {
    let value = match (text, number, whole) {
        (Some(text), ..) => Value::Text(text),
        (_, Some(number), _) => Value::Number(number),
        (.., whole) => Value::Integer(whole.unwrap_or_default()),
    };
    Keyword { name: lasting(name), value, comment: lasting(comment) }
}

/// A text that lasts as long as the program, as names of keywords do; each is kept once.
fn lasting(text: String) -> &'static str {
    static KNOWN: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    match known.get(text.as_str()) {
        Some(known) => known,
        None => {
            let leaked: &'static str = text.leak();
            known.insert(leaked);
            leaked
        }
    }
}

fn flat<'py>(py: Python<'py>, samples: &Samples) -> Bound<'py, PyAny> {
    match samples {
        Samples::Single(values) => PyArray1::from_slice(py, values).into_any(),
        Samples::Double(values) => PyArray1::from_slice(py, values).into_any(),
    }
}

fn samples(values: &Bound<PyAny>) -> PyResult<Samples> {
    match values.cast::<PyArray1<f32>>() {
        Ok(single) => Ok(Samples::Single(single.to_vec()?)),
        Err(_) => Ok(Samples::Double(values.cast::<PyArray1<f64>>()?.to_vec()?)),
    }
}
