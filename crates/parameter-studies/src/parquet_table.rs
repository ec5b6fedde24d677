//! The table of a study as Parquet.

use crate::Error;
use crate::table::{Column, Data, Table};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::sync::Arc;

/// Rows of a row group.
const ROWS: usize = 131_072;

impl Table {
    /// As Parquet, without compression.
    pub(crate) fn parquet(&self) -> Result<Vec<u8>, Error> {
        let field = |column: &Column| {
            let (physical, logical) = match column.data {
                Data::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
                Data::Real(_) => (Physical::DOUBLE, None),
                Data::Whole(_) => (Physical::INT32, None),
            };
            let repetition = match column.required {
                true => Repetition::REQUIRED,
                false => Repetition::OPTIONAL,
            };
            let built = Type::primitive_type_builder(&column.name, physical)
                .with_repetition(repetition)
                .with_logical_type(logical)
                .build()?;
            Ok::<_, Error>(Arc::new(built))
        };
        let fields = self.columns.iter().map(field).collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("study").with_fields(fields).build()?;
        let properties = Arc::new(WriterProperties::builder().build());
        let mut bytes = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), properties)?;
        let mut from = 0;
        while from < self.len() {
            let rows = from..(from + ROWS).min(self.len());
            let mut group = writer.next_row_group()?;
            for column in &self.columns {
                column.write(rows.clone(), &mut group)?;
            }
            group.close()?;
            from = rows.end;
        }
        writer.close()?;
        Ok(bytes)
    }
}

impl Column {
    fn write<W: std::io::Write + Send>(
        &self,
        rows: std::ops::Range<usize>,
        group: &mut SerializedRowGroupWriter<'_, W>,
    ) -> Result<(), Error> {
        let Some(mut writer) = group.next_column()? else {
            return Ok(());
        };
        macro_rules! write {
            ($data:expr, $type:ty, $value:expr) => {{
                let rows = $data.get(rows).unwrap_or_default();
                let levels: Vec<i16> = rows.iter().map(|value| i16::from(value.is_some())).collect();
                let values: Vec<_> = rows.iter().flatten().map($value).collect();
                let levels = (!self.required).then_some(levels.as_slice());
                writer.typed::<$type>().write_batch(&values, levels, None)?;
            }};
        }
        match &self.data {
            Data::Text(data) => write!(data, ByteArrayType, |text: &Arc<str>| ByteArray::from(&**text)),
            Data::Real(data) => write!(data, DoubleType, |value: &f64| *value),
            Data::Whole(data) => write!(data, Int32Type, |value: &i32| *value),
        }
        writer.close()?;
        Ok(())
    }
}
