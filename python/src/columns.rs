//! Conversion of columns between NumPy and the library.

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use hovernav::scalar::Readable;
use hovernav::time::Time;

use crate::error::{Error, Result};

/// A `Table` of `columns`.
pub fn table<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (&'static str, Vec<f64>)>,
) -> PyResult<Bound<'py, PyAny>> {
    let all = PyDict::new(py);
    for (name, values) in columns {
        all.set_item(name, PyArray1::from_vec(py, values))?;
    }
    table_of(&all)
}

/// A `Table` of the arrays in `columns`.
pub fn table_of<'py>(columns: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyAny>> {
    columns.py().import("hovernav._table")?.getattr("Table")?.call1((columns,))
}

/// A [`table`] with read-only arrays.
pub fn read_only<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (&'static str, Vec<f64>)>,
) -> PyResult<Bound<'py, PyAny>> {
    let table = table(py, columns)?;
    for array in table.call_method0("values")?.try_iter()? {
        array?.call_method1("setflags", (false,))?;
    }
    Ok(table)
}

/// The columns `names` of `rows`.
pub fn split<const N: usize>(
    names: [&'static str; N],
    rows: impl ExactSizeIterator<Item = [f64; N]>,
) -> impl Iterator<Item = (&'static str, Vec<f64>)> {
    let mut columns: [Vec<f64>; N] = std::array::from_fn(|_| Vec::with_capacity(rows.len()));
    for row in rows {
        for (column, value) in columns.iter_mut().zip(row) {
            column.push(value);
        }
    }
    names.into_iter().zip(columns)
}

/// Codes of the NumPy types that can contain numbers: booleans, integers, floats, and objects.
const NUMBERS: &str = "biufO";

/// `value` as an array of numbers; NaN where it is masked.
fn numbers<'py>(value: &Bound<'py, PyAny>, name: &str) -> Result<Bound<'py, PyAny>> {
    let py = value.py();
    let convert = || {
        let numpy = py.import("numpy")?;
        let array = numpy.call_method1("asanyarray", (value,))?;
        let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
        if !NUMBERS.contains(&kind) {
            let found = array.getattr("dtype")?;
            return Err(PyTypeError::new_err(format!("found values of type {found}")));
        }
        let array = array.call_method("astype", ("float64",), Some(&in_place(py)?))?;
        if array.hasattr("mask")? {
            return array.call_method1("filled", (f64::NAN,));
        }
        numpy.call_method1("asarray", (array,))
    };
    convert().map_err(|error: PyErr| {
        Error::Array(format!("{name}: expected numbers: {}", error.value(py)))
    })
}

/// The keyword argument that avoids a copy of an array that already has the type.
fn in_place(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let arguments = PyDict::new(py);
    arguments.set_item("copy", false)?;
    Ok(arguments)
}

/// The shape of an array, as text.
fn shape(array: &Bound<'_, PyAny>) -> String {
    array.getattr("shape").map_or_else(|_| "no shape".into(), |shape| shape.to_string())
}

/// `value` as numbers of shape (n,).
pub fn vector<'py>(value: &Bound<'py, PyAny>, name: &str) -> Result<PyReadonlyArray1<'py, f64>> {
    let array = numbers(value, name)?;
    array
        .extract()
        .map_err(|_| Error::Array(format!("{name}: found shape {}, expected (n,)", shape(&array))))
}

/// `value` as rows of three numbers, from shape (n, 3).
pub fn triples(value: &Bound<'_, PyAny>, name: &str) -> Result<Vec<[f64; 3]>> {
    let array = numbers(value, name)?;
    let found: Option<PyReadonlyArray2<'_, f64>> = array.extract().ok();
    let found = found.filter(|found| found.as_array().ncols() == 3);
    let found = found.ok_or_else(|| {
        Error::Array(format!("{name}: found shape {}, expected (n, 3)", shape(&array)))
    })?;
    Ok(found.as_array().rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect())
}

/// `value` as three finite numbers.
pub fn triple(value: &Bound<'_, PyAny>, name: &str) -> Result<[f64; 3]> {
    value.extract().map_err(|_| {
        let found = value.repr().map_or_else(|_| "another value".into(), |text| text.to_string());
        Error::Array(format!("{name}: found {found}, expected three numbers"))
    })
}

/// Converts seconds on the clock of the sensors to a time.
pub fn time(seconds: f64) -> Result<Time> {
    Time::try_from_seconds(seconds).ok_or_else(|| {
        Error::Array(format!("time_s: found {}, expected seconds on one clock", Readable(seconds)))
    })
}

/// Converts the column `seconds` of `table` to times, which must strictly increase.
pub fn times(seconds: &PyReadonlyArray1<'_, f64>, table: &str) -> Result<Vec<Time>> {
    let mut times: Vec<Time> = Vec::with_capacity(seconds.as_array().len());
    for (row, &value) in seconds.as_array().iter().enumerate() {
        let rejected = |why: &str| {
            let value = Readable(value);
            Error::Array(format!("{table}: row {row}, column t_s: found {value}, {why}"))
        };
        let time = Time::try_from_seconds(value);
        let time = time.ok_or_else(|| rejected("expected seconds on one clock"))?;
        if let Some(before) = times.last().filter(|before| **before >= time) {
            let why = format!("expected a time after {} on the row before", before.seconds());
            return Err(rejected(&why));
        }
        times.push(time);
    }
    Ok(times)
}

/// A table from Python: a mapping of column names to arrays, such as a dictionary or a data frame.
pub struct Columns<'py> {
    table: &'static str,
    mapping: Bound<'py, PyAny>,
    /// Times of the rows.
    pub times: Vec<Time>,
}

impl<'py> Columns<'py> {
    /// The table `mapping`, which must have a column `t_s` and may have only the columns `known`.
    pub fn of(table: &'static str, mapping: &Bound<'py, PyAny>, known: &[&str]) -> Result<Self> {
        let is_table = mapping.cast::<PyMapping>().is_ok() || mapping.hasattr("columns")?;
        if !is_table {
            let kind = mapping.get_type();
            return Err(Error::Array(format!(
                "{table}: found {kind}, expected a dictionary of arrays or a data frame"
            )));
        }
        for name in mapping.call_method0("keys")?.try_iter()? {
            let name = name?.to_string();
            if name != "t_s" && !known.contains(&&*name) {
                return Err(Error::Array(format!(
                    "{table}: found column {name}, expected t_s, {}",
                    known.join(", ")
                )));
            }
        }
        let mapping = mapping.clone();
        let mut columns = Self { table, mapping, times: Vec::new() };
        let Some(seconds) = columns.get("t_s")? else { return Err(columns.missing("t_s")) };
        columns.times = times(&vector(&seconds, &columns.name("t_s"))?, table)?;
        Ok(columns)
    }

    fn name(&self, column: &str) -> String {
        format!("{}: column {column}", self.table)
    }

    fn get(&self, column: &str) -> Result<Option<Bound<'py, PyAny>>> {
        Ok(match self.mapping.contains(column)? {
            true => Some(self.mapping.get_item(column)?),
            false => None,
        })
    }

    /// The error for columns that are required.
    pub fn missing(&self, columns: &str) -> Error {
        Error::Array(format!("{}: found no column {columns}", self.table))
    }

    fn ensure_length(&self, column: &str, found: usize) -> Result<()> {
        let rows = self.times.len();
        if found == rows {
            return Ok(());
        }
        Err(Error::Array(format!(
            "{}: found {found} values, expected {rows}, as in t_s",
            self.name(column)
        )))
    }

    /// The values of one column; `None` if the table lacks it.
    pub fn one(&self, column: &str) -> Result<Option<Vec<f64>>> {
        let Some(values) = self.get(column)? else { return Ok(None) };
        let values = vector(&values, &self.name(column))?;
        self.ensure_length(column, values.as_array().len())?;
        Ok(Some(values.as_array().iter().copied().collect()))
    }

    /// Three columns: one array of shape (n, 3) named `group`, or three arrays named `names`. `None` if the table lacks
    /// all of them; an error if it lacks some.
    pub fn three(&self, group: &str, names: [&str; 3]) -> Result<Option<Vec<[f64; 3]>>> {
        if let Some(values) = self.get(group)? {
            for name in names {
                if self.get(name)?.is_some() {
                    let table = self.table;
                    return Err(Error::Array(format!(
                        "{table}: found columns {group} and {name}, expected one of both"
                    )));
                }
            }
            let rows = triples(&values, &self.name(group))?;
            self.ensure_length(group, rows.len())?;
            return Ok(Some(rows));
        }
        match names.map(|name| self.one(name)) {
            [Ok(Some(x)), Ok(Some(y)), Ok(Some(z))] => {
                let rows = x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]);
                Ok(Some(rows.collect()))
            }
            [Ok(None), Ok(None), Ok(None)] => Ok(None),
            each => {
                for (one, name) in each.into_iter().zip(names) {
                    if one?.is_none() {
                        return Err(self.missing(name));
                    }
                }
                Ok(None)
            }
        }
    }
}
