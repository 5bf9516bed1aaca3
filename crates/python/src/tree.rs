//! Scenes as trees of Python's own values: dictionaries, lists, texts, numbers, truth values, and quantities as (number, unit).

use barnard::properties::{Property, Table, Value};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

use crate::error::raised;

/// Tables and lists within each other that are followed.
const DEEPEST: usize = 32;

/// The table that a dictionary is.
pub fn table(dictionary: &Bound<PyDict>) -> PyResult<Table> {
    table_at(dictionary, 0)
}

fn table_at(dictionary: &Bound<PyDict>, depth: usize) -> PyResult<Table> {
    let mut table = Table::default();
    for (key, value) in dictionary {
        let key: String = key.extract().map_err(|_| PyTypeError::new_err(format!("the key {key} of a scene is no text")))?;
        let value = value_at(&key, &value, depth + 1)?;
        table.insert(key, value);
    }
    Ok(table)
}

fn value_at(key: &str, value: &Bound<PyAny>, depth: usize) -> PyResult<Value> {
    if depth > DEEPEST {
        return Err(PyValueError::new_err(format!("{key}: tables are more than {DEEPEST} deep within each other")));
    }
    // Truth values are whole numbers to Python.
    if let Ok(flag) = value.cast::<PyBool>() {
        Ok(Value::Flag(flag.is_true()))
    } else if let Ok(text) = value.cast::<PyString>() {
        Ok(Value::Text(text.to_str()?.to_owned()))
    } else if value.is_instance_of::<PyInt>() {
        let number = value.extract().map_err(|_| PyValueError::new_err(format!("{key}: {value} has too many digits")))?;
        Ok(Value::Integer(number))
    } else if let Ok(number) = value.cast::<PyFloat>() {
        Ok(Value::Number(number.value()))
    } else if let Ok(quantity) = value.cast::<PyTuple>() {
        let unit: String = quantity.get_item(1)?.extract()?;
        let numbers = quantity.get_item(0)?;
        let numbers = numbers.extract::<f64>().map_or_else(|_| numbers.extract(), |number| Ok(vec![number]))?;
        Ok(Value::Quantity(numbers, unit))
    } else if let Ok(list) = value.cast::<PyList>() {
        let item = |item: Bound<PyAny>| Ok(Property::from(value_at(key, &item, depth + 1)?));
        Ok(Value::List(list.iter().map(item).collect::<PyResult<_>>()?))
    } else if let Ok(dictionary) = value.cast::<PyDict>() {
        Ok(Value::Table(table_at(dictionary, depth)?))
    } else {
        Err(PyTypeError::new_err(format!("{key}: {} is no value of a scene", value.get_type())))
    }
}

/// The dictionary that a table is.
pub fn dictionary<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let dictionary = PyDict::new(py);
    for (key, property) in table.iter() {
        dictionary.set_item(key, object(py, &property.value)?)?;
    }
    Ok(dictionary)
}

fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Text(text) => PyString::new(py, text).into_any(),
        Value::Quantity(numbers, unit) => match numbers[..] {
            [number] => (number, unit).into_pyobject(py)?.into_any(),
            _ => (PyTuple::new(py, numbers)?, unit).into_pyobject(py)?.into_any(),
        },
        Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        Value::Number(number) => PyFloat::new(py, *number).into_any(),
        Value::Flag(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Value::List(items) => {
            let items = items.iter().map(|item| object(py, &item.value)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_any()
        }
        Value::Table(table) => dictionary(py, table)?.into_any(),
    })
}

/// A parameter of a scene.
#[derive(IntoPyObject)]
pub struct Parameter<'py> {
    path: String,
    value: Bound<'py, PyAny>,
    unit: String,
    low: f64,
    high: f64,
    r#type: String,
    summary: &'static str,
    is_default: bool,
}

/// All parameters of a scene's tree.
#[pyfunction]
pub fn parameters<'py>(py: Python<'py>, tree: &Bound<'py, PyDict>) -> PyResult<Vec<Parameter<'py>>> {
    let row = |parameter: barnard::scene::Parameter| {
        let ((low, high), numbers) = (parameter.range(), parameter.numbers());
        let (value, unit) = match numbers {
            Some((numbers, unit)) if !unit.is_empty() => match numbers[..] {
                [number] => (number.into_pyobject(py)?.into_any(), unit),
                _ => (PyList::new(py, numbers)?.into_any(), unit),
            },
            _ => (object(py, &parameter.value)?, String::new()),
        };
        let (summary, is_default) = (parameter.key.summary, !parameter.is_stated);
        Ok(Parameter { path: parameter.path, value, unit, low, high, r#type: parameter.key.type_words(), summary, is_default })
    };
    barnard::scene::parameters(&table(tree)?).into_iter().map(row).collect()
}

/// The tree of a scene's text; `file` is its name in messages.
#[pyfunction]
pub fn from_toml<'py>(py: Python<'py>, file: &str, text: &str) -> PyResult<Bound<'py, PyDict>> {
    let table = barnard_files::toml::properties(file, text).map_err(|error| raised(py, error))?;
    dictionary(py, &table)
}

/// The text of a scene's tree.
#[pyfunction]
pub fn to_toml(tree: &Bound<PyDict>) -> PyResult<String> {
    Ok(barnard_files::toml::text(&table(tree)?))
}
