//! Arrays of NumPy as data that scenes name, in the memory in which they are.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use barnard::data::{Array, ArrayHeader, Choose, DataSource, Numbers, Shared, TextTable};
use barnard::{Error, Result, memory};
use barnard_files::SceneFiles;
use barnard_files::formats::part_of;
use numpy::{Element, PyArray3, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use spectra::curve::Columns;

/// The memory of an array that nobody writes into, held by a reference to the array.
struct LockedArray<T: 'static> {
    _array: Py<PyArray3<T>>,
    start: *const T,
    length: usize,
}

// SAFETY: the memory is only read, by whoever holds it and by Python, which cannot write into it: the array is marked so.
unsafe impl<T: Sync> Send for LockedArray<T> {}
// SAFETY: as above.
unsafe impl<T: Sync> Sync for LockedArray<T> {}

impl<T> AsRef<[T]> for LockedArray<T> {
    fn as_ref(&self) -> &[T] {
        // SAFETY: the array was contiguous and of this number of elements when it was taken, and lives as long as its reference.
        unsafe { std::slice::from_raw_parts(self.start, self.length) }
    }
}

/// The numbers of a contiguous array that cannot be written into.
fn locked<T: Element + Send + Sync + 'static>(array: &Bound<PyArray3<T>>) -> PyResult<Shared<T>> {
    if !array.is_contiguous() && !array.is_fortran_contiguous() {
        return Err(PyTypeError::new_err("the array is not contiguous"));
    }
    let writeable: bool = array.getattr("flags")?.getattr("writeable")?.extract()?;
    if writeable {
        return Err(PyTypeError::new_err("the array can be written into"));
    }
    Ok(Shared::of(LockedArray { _array: array.clone().unbind(), start: array.data().cast_const(), length: array.len() }))
}

/// An array that a scene can name.
#[derive(Debug, Clone)]
struct NamedArray {
    /// Name in messages.
    label: String,
    shape: [usize; 3],
    fortran: bool,
    data: Numbers,
}

/// Arrays by name, and files of a folder for all other names.
#[derive(Debug)]
pub struct Arrays {
    named: Mutex<HashMap<String, NamedArray>>,
    files: Arc<SceneFiles>,
}

impl Arrays {
    /// No arrays; files are those of `folder`, or those that are built in.
    pub fn new(folder: Option<PathBuf>) -> Self {
        let files = folder.map_or_else(barnard_files::builtin::files, |folder| Arc::new(SceneFiles::in_folder(folder)));
        Self { named: Mutex::default(), files }
    }

    /// Takes an array of doubles or singles, contiguous and read-only, under a name.
    pub fn add(&self, name: String, label: String, array: &Bound<PyAny>) -> PyResult<()> {
        let (shape, fortran, data) = if let Ok(array) = array.cast::<PyArray3<f32>>() {
            (array.shape(), !array.is_c_contiguous(), Numbers::Single(locked(array)?))
        } else if let Ok(array) = array.cast::<PyArray3<f64>>() {
            (array.shape(), !array.is_c_contiguous(), Numbers::Double(locked(array)?))
        } else {
            return Err(PyTypeError::new_err(format!("{label}: a field is an array of three axes of float32 or float64")));
        };
        let shape = [shape[0], shape[1], shape[2]];
        self.named.lock().unwrap_or_else(PoisonError::into_inner).insert(name, NamedArray { label, shape, fortran, data });
        Ok(())
    }

    /// Lets go of all arrays but those of these names.
    pub fn keep(&self, names: &[String]) {
        self.named.lock().unwrap_or_else(PoisonError::into_inner).retain(|name, _| names.contains(name));
    }

    fn named(&self, name: &str) -> Option<NamedArray> {
        self.named.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
    }
}

impl DataSource for Arrays {
    fn label(&self, name: &str) -> String {
        self.named(name).map_or_else(|| self.files.label(name), |array| array.label)
    }

    fn text(&self, name: &str, memory_limit: u64) -> Result<Cow<'static, str>> {
        self.files.text(name, memory_limit)
    }

    fn bytes(&self, name: &str, memory_limit: u64) -> Result<Vec<u8>> {
        self.files.bytes(name, memory_limit)
    }

    fn columns(&self, name: &str, memory_limit: u64) -> Result<Columns> {
        self.files.columns(name, memory_limit)
    }

    fn table(&self, name: &str, most_rows: usize, memory_limit: u64) -> Result<TextTable> {
        self.files.table(name, most_rows, memory_limit)
    }

    fn picture(&self, name: &str, hdu: Option<&str>, memory_limit: u64) -> Result<([usize; 2], Vec<f64>)> {
        self.files.picture(name, hdu, memory_limit)
    }

    fn array(&self, name: &str, member: Option<&str>, choose: Choose, memory_limit: u64) -> Result<Array> {
        let Some(NamedArray { label, shape, fortran, data }) = self.named(name) else {
            return self.files.array(name, member, choose, memory_limit);
        };
        if let Some(member) = member {
            return Err(Error::file(label, format!("is one array without a name; leave out array = \"{member}\"")));
        }
        let part = choose(&ArrayHeader { shape, frame: None })?;
        if !part.is_whole(shape) {
            let data = part_of(&data, shape, fortran, &part, label.as_ref(), memory_limit)?;
            return Ok(Array { shape: part.shape(), data, fortran });
        }
        let cells = shape.iter().fold(1u64, |cells, edge| cells.saturating_mul(*edge as u64));
        memory::check(&label, cells.saturating_mul(4), memory_limit)?;
        Ok(Array { shape, data, fortran })
    }
}
