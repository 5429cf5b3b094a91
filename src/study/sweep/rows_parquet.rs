//! Rows as Parquet: one row group a file, columns of optional values, lists of three levels as the format recommends, compressed with Zstandard.
//!
//! Source: Apache Parquet, LogicalTypes (`LIST`) and the levels of Dremel: a list that is absent has the definition level 0, an empty one 1, its
//! values 2; the first value of a row has the repetition level 0, all others 1.

use crate::sweep::rows::{Cell, Heading, Kind, Row};
use parquet::basic::{Compression, ConvertedType, Repetition, Type as PhysicalType, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::{Field, ListAccessor};
use parquet::schema::types::{Type, TypePtr};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// Writes all rows.
pub(super) fn write(headings: &[Heading], rows: &[Row], out: &mut (impl Write + Send)) -> io::Result<()> {
    let written = || -> Result<()> {
        let fields = headings.iter().map(field).collect::<Result<Vec<TypePtr>>>()?;
        let schema = Arc::new(Type::group_type_builder("row").with_fields(fields).build()?);
        let compression = Compression::ZSTD(ZstdLevel::try_new(1)?);
        let properties = WriterProperties::builder()
            .set_compression(compression)
            .set_created_by(format!("catena {}", env!("CARGO_PKG_VERSION")));
        let mut file = SerializedFileWriter::new(out, schema, Arc::new(properties.build()))?;
        let mut group = file.next_row_group()?;
        for (column, heading) in headings.iter().enumerate() {
            let cells = || rows.iter().map(|row| &row.cells[column]);
            match heading.kind {
                Kind::Count => put::<Int64Type>(&mut group, cells(), |cell| {
                    if let Cell::Count(count) = cell { Some(*count as i64) } else { None }
                })?,
                Kind::Number => put::<DoubleType>(&mut group, cells(), |cell| {
                    if let Cell::Number(number) = cell { Some(*number) } else { None }
                })?,
                Kind::Text => {
                    put::<ByteArrayType>(&mut group, cells(), |cell| {
                        if let Cell::Text(text) = cell { Some(ByteArray::from(text.as_str())) } else { None }
                    })?;
                }
                Kind::Numbers => put_lists::<DoubleType>(&mut group, cells(), |cell| {
                    if let Cell::Numbers(numbers) = cell { Some(numbers.clone()) } else { None }
                })?,
                Kind::Texts => put_lists::<ByteArrayType>(&mut group, cells(), |cell| match cell {
                    Cell::Texts(texts) => Some(texts.iter().map(|text| ByteArray::from(text.as_str())).collect()),
                    _ => None,
                })?,
            }
        }
        group.close()?;
        file.close()?;
        Ok(())
    };
    written().map_err(|error| match error {
        ParquetError::External(cause) => match cause.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(cause) => io::Error::other(cause),
        },
        error => io::Error::other(error),
    })
}

/// A column as the format describes it.
fn field(heading: &Heading) -> Result<TypePtr> {
    let single = |name: &str, kind: PhysicalType, text: bool, repetition| -> Result<TypePtr> {
        let converted = if text { ConvertedType::UTF8 } else { ConvertedType::NONE };
        Ok(Arc::new(
            Type::primitive_type_builder(name, kind)
                .with_repetition(repetition)
                .with_converted_type(converted)
                .build()?,
        ))
    };
    let list = |kind, text| -> Result<TypePtr> {
        let element = single("element", kind, text, Repetition::REQUIRED)?;
        let values = Type::group_type_builder("list")
            .with_repetition(Repetition::REPEATED)
            .with_fields(vec![element])
            .build()?;
        let outer = Type::group_type_builder(&heading.name)
            .with_repetition(Repetition::OPTIONAL)
            .with_converted_type(ConvertedType::LIST);
        Ok(Arc::new(outer.with_fields(vec![Arc::new(values)]).build()?))
    };
    match heading.kind {
        Kind::Count => single(&heading.name, PhysicalType::INT64, false, Repetition::OPTIONAL),
        Kind::Number => single(&heading.name, PhysicalType::DOUBLE, false, Repetition::OPTIONAL),
        Kind::Text => single(&heading.name, PhysicalType::BYTE_ARRAY, true, Repetition::OPTIONAL),
        Kind::Numbers => list(PhysicalType::DOUBLE, false),
        Kind::Texts => list(PhysicalType::BYTE_ARRAY, true),
    }
}

fn put<'c, T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, impl Write + Send>,
    cells: impl Iterator<Item = &'c Cell>,
    value: impl Fn(&Cell) -> Option<T::T>,
) -> Result<()> {
    let (mut values, mut defined) = (Vec::new(), Vec::new());
    for cell in cells {
        let value = value(cell);
        defined.push(i16::from(value.is_some()));
        values.extend(value);
    }
    column::<T>(group, &values, &defined, None)
}

fn put_lists<'c, T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, impl Write + Send>,
    cells: impl Iterator<Item = &'c Cell>,
    list: impl Fn(&Cell) -> Option<Vec<T::T>>,
) -> Result<()> {
    let (mut values, mut defined, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
    for cell in cells {
        let list = list(cell);
        let count = list.as_ref().map_or(0, Vec::len);
        if count == 0 {
            defined.push(i16::from(list.is_some()));
            repeated.push(0);
        }
        for value in 0..count {
            defined.push(2);
            repeated.push(i16::from(value > 0));
        }
        values.extend(list.into_iter().flatten());
    }
    column::<T>(group, &values, &defined, Some(&repeated))
}

fn column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, impl Write + Send>,
    values: &[T::T],
    defined: &[i16],
    repeated: Option<&[i16]>,
) -> Result<()> {
    let mut column =
        group.next_column()?.ok_or_else(|| ParquetError::General("more columns than headings".to_string()))?;
    column.typed::<T>().write_batch(values, Some(defined), repeated)?;
    column.close()
}

/// Reads all rows of a file that was written here.
pub(super) fn read(path: &Path, headings: &[Heading]) -> io::Result<Vec<Row>> {
    let rows = || -> Result<Vec<Row>> {
        let reader = SerializedFileReader::new(File::open(path)?)?;
        let mut rows = Vec::new();
        for row in reader.get_row_iter(None)? {
            let row = row?;
            let cells: Vec<Cell> = row
                .get_column_iter()
                .zip(headings)
                .map(|((_, field), heading)| cell(field, heading.kind))
                .collect::<Result<_>>()?;
            match cells.first() {
                Some(Cell::Count(index)) if cells.len() == headings.len() => {
                    let failed = cells.contains(&Cell::Text("failed".to_string()));
                    rows.push(Row { index: *index, failed, cells });
                }
                _ => return Err(ParquetError::General("its columns are those of another sweep".to_string())),
            }
        }
        Ok(rows)
    };
    rows().map_err(io::Error::other)
}

fn cell(field: &Field, kind: Kind) -> Result<Cell> {
    Ok(match field {
        Field::Null => Cell::Nothing,
        Field::Long(count) => Cell::Count(*count as u64),
        Field::Double(number) => Cell::Number(*number),
        Field::Str(text) => Cell::Text(text.clone()),
        Field::ListInternal(list) if kind == Kind::Texts => {
            Cell::Texts((0..list.len()).map(|index| list.get_string(index).cloned()).collect::<Result<_>>()?)
        }
        Field::ListInternal(list) => {
            Cell::Numbers((0..list.len()).map(|index| list.get_double(index)).collect::<Result<_>>()?)
        }
        other => return Err(ParquetError::General(format!("unexpected value {other}"))),
    })
}
