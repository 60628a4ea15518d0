//! Parquet: the columns of `solution.csv` as 64-bit floats.

use std::io::Write;
use std::sync::Arc;

use hovernav::ekf::Solution;
use hovernav_log::{SOLUTION_COLUMNS, solution_row};
use parquet::basic::{Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::{Export, ExportError};

/// Rows of one group, so that memory stays bounded.
const ROWS: usize = 65_536;

impl From<ParquetError> for ExportError {
    fn from(error: ParquetError) -> Self {
        Self::Library(error.to_string())
    }
}

pub fn write(export: &Export<'_>, out: &mut (impl Write + Send)) -> Result<(), ExportError> {
    let fields = SOLUTION_COLUMNS.iter().map(|name| {
        let field = Type::primitive_type_builder(name, PhysicalType::DOUBLE);
        field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("solution").with_fields(fields).build()?);
    let properties = Arc::new(WriterProperties::builder().build());
    let mut file = SerializedFileWriter::new(out, schema, properties)?;
    for solutions in export.solutions.chunks(ROWS) {
        let mut columns: Vec<Vec<f64>> =
            vec![Vec::with_capacity(solutions.len()); SOLUTION_COLUMNS.len()];
        for row in solutions.iter().map(|solution: &Solution| solution_row(solution)) {
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
        }
        let mut group = file.next_row_group()?;
        for column in &columns {
            let Some(mut writer) = group.next_column()? else { break };
            writer.typed::<DoubleType>().write_batch(column, None, None)?;
            writer.close()?;
        }
        group.close()?;
    }
    file.close()?;
    Ok(())
}
