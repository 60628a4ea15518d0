//! Parquet: the columns of `solution.csv` as 64-bit floats.

use std::io::Write as _;
use std::sync::Arc;

use hovernav::ekf::Solution;
use hovernav_dataset::{SOLUTION_COLUMNS, solution_row};
use parquet::basic::{Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::{ExportError, Out, Sink};

/// Number of rows in a group, which bounds the memory.
const ROWS: usize = 65_536;

impl From<ParquetError> for ExportError {
    fn from(error: ParquetError) -> Self {
        Self::Library(error.to_string())
    }
}

pub struct Parquet<'w> {
    file: SerializedFileWriter<Out<'w>>,
    /// The current group, column by column.
    columns: Vec<Vec<f64>>,
}

impl<'w> Parquet<'w> {
    pub fn new(out: Out<'w>) -> Result<Self, ExportError> {
        let fields = SOLUTION_COLUMNS.iter().map(|name| {
            let field = Type::primitive_type_builder(name, PhysicalType::DOUBLE);
            field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
        });
        let fields = fields.collect::<Result<Vec<_>, _>>()?;
        let schema = Arc::new(Type::group_type_builder("solution").with_fields(fields).build()?);
        let properties = Arc::new(WriterProperties::builder().build());
        let file = SerializedFileWriter::new(out, schema, properties)?;
        Ok(Self { file, columns: vec![Vec::new(); SOLUTION_COLUMNS.len()] })
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Writes the current group, and begins the next.
    fn end_group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.file.next_row_group()?;
        for column in &mut self.columns {
            let Some(mut writer) = group.next_column()? else { break };
            writer.typed::<DoubleType>().write_batch(column, None, None)?;
            writer.close()?;
            column.clear();
        }
        group.close()?;
        Ok(())
    }
}

impl Sink for Parquet<'_> {
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        for (column, value) in self.columns.iter_mut().zip(solution_row(solution)) {
            column.push(value);
        }
        if self.rows() == ROWS {
            self.end_group()?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        if self.rows() > 0 {
            self.end_group()?;
        }
        Ok(self.file.into_inner()?.flush()?)
    }
}
