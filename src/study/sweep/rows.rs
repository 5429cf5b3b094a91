//! The rows of a sweep's table and their columns.

use serde::{Deserialize, Serialize};

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A number that counts.
    Count,
    /// A number.
    Number,
    /// Words.
    Text,
    /// Numbers, one after the other.
    Numbers,
    /// Words, one after the other.
    Texts,
}

/// A column of the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heading {
    /// Its name.
    pub name: String,
    /// The type of its cells.
    pub kind: Kind,
}

impl Heading {
    pub(crate) fn new(name: impl Into<String>, kind: Kind) -> Self {
        Heading { name: name.into(), kind }
    }
}

/// The content of a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// The value is not known.
    Nothing,
    /// A number that counts.
    Count(u64),
    /// A number.
    Number(f64),
    /// Words.
    Text(String),
    /// Numbers.
    Numbers(Vec<f64>),
    /// Words.
    Texts(Vec<String>),
}

/// A run: its numbers, and its kept quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its index in the sweep.
    pub index: u64,
    /// Whether it failed.
    pub failed: bool,
    /// One for each column; the first is the index.
    pub cells: Vec<Cell>,
}

impl Row {
    /// Adds it to the bytes of a journal.
    pub(crate) fn encode(&self, out: &mut Vec<u8>) {
        out.extend(self.index.to_le_bytes());
        out.push(u8::from(self.failed));
        for cell in &self.cells {
            match cell {
                Cell::Nothing => out.push(0),
                Cell::Count(count) => {
                    out.push(1);
                    out.extend(count.to_le_bytes());
                }
                Cell::Number(number) => {
                    out.push(2);
                    out.extend(number.to_le_bytes());
                }
                Cell::Text(text) => {
                    out.push(3);
                    put_text(text, out);
                }
                Cell::Numbers(numbers) => {
                    out.push(4);
                    out.extend((numbers.len() as u32).to_le_bytes());
                    numbers.iter().for_each(|number| out.extend(number.to_le_bytes()));
                }
                Cell::Texts(texts) => {
                    out.push(5);
                    out.extend((texts.len() as u32).to_le_bytes());
                    texts.iter().for_each(|text| put_text(text, out));
                }
            }
        }
    }

    /// Reads it back; `None` if it is no row.
    pub(crate) fn decode(bytes: &[u8]) -> Option<Row> {
        let mut bytes = Bytes(bytes);
        let index = u64::from_le_bytes(bytes.array()?);
        let failed = bytes.array::<1>()?[0] != 0;
        let mut cells = Vec::new();
        while !bytes.0.is_empty() {
            cells.push(match bytes.array::<1>()?[0] {
                0 => Cell::Nothing,
                1 => Cell::Count(u64::from_le_bytes(bytes.array()?)),
                2 => Cell::Number(f64::from_le_bytes(bytes.array()?)),
                3 => Cell::Text(bytes.text()?),
                4 => {
                    let count = u32::from_le_bytes(bytes.array()?);
                    Cell::Numbers((0..count).map(|_| bytes.array().map(f64::from_le_bytes)).collect::<Option<_>>()?)
                }
                5 => {
                    let count = u32::from_le_bytes(bytes.array()?);
                    Cell::Texts((0..count).map(|_| bytes.text()).collect::<Option<_>>()?)
                }
                _ => return None,
            });
        }
        Some(Row { index, failed, cells })
    }
}

fn put_text(text: &str, out: &mut Vec<u8>) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

/// The bytes that are left to be read.
struct Bytes<'b>(&'b [u8]);

impl Bytes<'_> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn text(&mut self) -> Option<String> {
        let length = u32::from_le_bytes(self.array()?) as usize;
        let (text, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        String::from_utf8(text.to_vec()).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_read_back_from_its_bytes_and_no_row_from_a_part_of_them() {
        let row = Row {
            index: 1 << 40,
            failed: true,
            cells: vec![
                Cell::Count(3),
                Cell::Nothing,
                Cell::Number(-0.1),
                Cell::Text("näher, \"dran\"".into()),
                Cell::Numbers(vec![1.0, f64::INFINITY]),
                Cell::Texts(vec!["a|b".into(), String::new()]),
            ],
        };
        let mut bytes = Vec::new();
        row.encode(&mut bytes);
        assert_eq!(Row::decode(&bytes), Some(row));
        assert_eq!(Row::decode(&bytes[..bytes.len() - 1]), None);
        assert_eq!(Row::decode(&[9; 40]), None);
    }
}
