//! Rows as CSV (RFC 4180, lines end with `\n`): names in the first line; numbers with as many digits as tell them from all others. Lists are JSON, in
//! which NaN and infinities are `null`. Unknown values are empty.

use crate::drawing::comma_separated::field;
use crate::sweep::rows::{Cell, Heading, Row};
use std::io::{self, Write};

/// Writes the names.
pub(super) fn heading(headings: &[Heading], out: &mut impl Write) -> io::Result<()> {
    for (index, heading) in headings.iter().enumerate() {
        if index > 0 {
            out.write_all(b",")?;
        }
        out.write_all(field(&heading.name).as_bytes())?;
    }
    out.write_all(b"\n")
}

/// Writes a row.
pub(super) fn row(row: &Row, out: &mut impl Write) -> io::Result<()> {
    for (index, cell) in row.cells.iter().enumerate() {
        if index > 0 {
            out.write_all(b",")?;
        }
        match cell {
            Cell::Nothing => {}
            Cell::Count(count) => write!(out, "{count}")?,
            Cell::Number(number) if number.is_finite() => serde_json::to_writer(&mut *out, number)?,
            Cell::Number(number) => write!(
                out,
                "{}",
                if number.is_nan() {
                    "nan"
                } else if *number > 0.0 {
                    "inf"
                } else {
                    "-inf"
                }
            )?,
            Cell::Text(said) => out.write_all(field(said).as_bytes())?,
            Cell::Numbers(numbers) => out.write_all(field(&serde_json::to_string(numbers)?).as_bytes())?,
            Cell::Texts(texts) => out.write_all(field(&serde_json::to_string(texts)?).as_bytes())?,
        }
    }
    out.write_all(b"\n")
}
