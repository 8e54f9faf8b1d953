//! Values of scene files and choices, as Python has them.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use raggio_render::Choice;
use toml_edit::{Item, Value};

/// Names of a choice.
pub fn names<T: Choice>() -> Vec<&'static str> {
    T::NAMES.to_vec()
}

/// The choice of that name.
pub fn chosen<T: Choice>(name: &str) -> PyResult<T> {
    name.parse().map_err(|error| PyValueError::new_err(format!("{name:?}: {error}")))
}

/// A value of a scene file as Python's dictionaries, lists, numbers and strings.
pub fn item<'py>(py: Python<'py>, of: &Item) -> PyResult<Bound<'py, PyAny>> {
    match of {
        Item::None => Ok(py.None().into_bound(py)),
        Item::Value(of) => value(py, of),
        Item::Table(table) => {
            let found = PyDict::new(py);
            table.iter().try_for_each(|(key, of)| found.set_item(key, item(py, of)?))?;
            Ok(found.into_any())
        }
        Item::ArrayOfTables(tables) => {
            let found = PyList::empty(py);
            tables.iter().try_for_each(|table| found.append(item(py, &Item::Table(table.clone()))?))?;
            Ok(found.into_any())
        }
    }
}

fn value<'py>(py: Python<'py>, of: &Value) -> PyResult<Bound<'py, PyAny>> {
    match of {
        Value::String(text) => text.value().into_bound_py_any(py),
        Value::Integer(number) => number.value().into_bound_py_any(py),
        Value::Float(number) => number.value().into_bound_py_any(py),
        Value::Boolean(truth) => truth.value().into_bound_py_any(py),
        Value::Datetime(date) => date.value().to_string().into_bound_py_any(py),
        Value::Array(list) => {
            let items = list.iter().map(|of| value(py, of)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyTuple::new(py, items)?.into_any())
        }
        Value::InlineTable(table) => {
            let found = PyDict::new(py);
            table.iter().try_for_each(|(key, of)| found.set_item(key, value(py, of)?))?;
            Ok(found.into_any())
        }
    }
}
