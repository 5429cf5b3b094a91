//! The CSV file of a target: a time and a value on each line, after a header if there is one.
//!
//! ```text
//!     time,value          optional; neither column of a header is a number
//!     0.0,0.1             s; rad or m, rad/s or m/s, N m or N
//!     0.5,0.3
//! ```
//!
//! Lines that begin with `#` are comments. Empty lines at the end are ignored; anywhere else they are gaps, which are errors.

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::numbers::shown;
use std::path::Path;

/// A line of a table: its number, counted from 1, the time (s) and the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    pub line: usize,
    pub time: f64,
    pub value: f64,
}

/// The entries of a CSV file, which `owner` needs.
///
/// # Errors
/// [`SceneError`] with the line, for a line that is not two numbers.
pub(crate) fn entries_of_csv(text: &str, file: &Path, owner: &Element) -> Result<Vec<Entry>, SceneError> {
    let mut entries = Vec::new();
    for (place, (line, row)) in rows_of_csv(text).enumerate() {
        let refuse = |reason: String| {
            let (file, line, element) = (file.to_path_buf(), Some(line), Some(owner.clone()));
            Err(SceneError { file, line, element, problem: Box::new(Problem::Table(reason)) })
        };
        let columns: Vec<&str> = row.split(',').map(str::trim).collect();
        let &[time, value] = columns.as_slice() else {
            return match columns.len() {
                1 if columns[0].is_empty() => refuse("the line is empty; give time,value or remove it".to_string()),
                1 => refuse(format!("{:?} is one column; give time,value, separated by a comma", shown(row))),
                count => refuse(format!("{:?} has {count} columns; give two: time,value", shown(row))),
            };
        };
        match (number(time), number(value)) {
            (Some(time), Some(value)) => entries.push(Entry { line, time, value }),
            (None, None) if place == 0 && !time.is_empty() && !value.is_empty() => {}
            (given, _) => {
                let (what, text) = if given.is_none() { ("time", time) } else { ("value", value) };
                return match text {
                    "" => refuse(format!("the {what} is missing; give time,value")),
                    text => refuse(format!("the {what} {:?} is not a number", shown(text))),
                };
            }
        }
    }
    Ok(entries)
}

/// The lines of a table, each with its number from 1 on, without comments and empty lines at the end.
pub fn rows_of_csv(text: &str) -> impl Iterator<Item = (usize, &str)> {
    // Spreadsheets put a byte order mark in front.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end();
    (1..).zip(text.lines()).filter(|(_, row)| !row.trim_start().starts_with('#'))
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<(usize, f64, f64)>, String> {
        let owner = Element::Motor("elbow".to_string());
        let entries = entries_of_csv(text, Path::new("t.csv"), &owner).map_err(|error| error.to_string())?;
        Ok(entries.iter().map(|entry| (entry.line, entry.time, entry.value)).collect())
    }

    #[test]
    fn a_header_is_optional_and_so_are_marks_carriage_returns_spaces_and_empty_lines_at_the_end() {
        let expected = Ok(vec![(2, 0.0, 1.0), (3, 0.5, -2e-3)]);
        assert_eq!(read("time,value\n0,1\n0.5,-2e-3\n"), expected);
        assert_eq!(read("\u{feff}t [s], q [rad]\r\n 0 , 1\r\n0.5,\t-2e-3\r\n\r\n\n"), expected);
        assert_eq!(read("# made by hand\ntime,value\n # later\n0,1\n"), Ok(vec![(4, 0.0, 1.0)]));
        assert_eq!(read("0,1"), Ok(vec![(1, 0.0, 1.0)]));
        assert_eq!(read(""), Ok(vec![]));
    }

    #[test]
    fn what_is_not_two_numbers_is_refused_with_its_line() {
        for (text, message) in [
            ("0,1\n\n1,2", "t.csv:2: motor on \"elbow\": the line is empty"),
            ("0,1\n1,\n", "t.csv:2: motor on \"elbow\": the value is missing"),
            ("0,1\n,2\n", "t.csv:2: motor on \"elbow\": the time is missing"),
            ("0,1\n1;2\n", "t.csv:2: motor on \"elbow\": \"1;2\" is one column"),
            ("0,1\n1,2,3\n", "t.csv:2: motor on \"elbow\": \"1,2,3\" has 3 columns"),
            ("0,1\n1,two\n", "t.csv:2: motor on \"elbow\": the value \"two\" is not a number"),
            ("0,1\nt,v\n", "t.csv:2: motor on \"elbow\": the time \"t\" is not a number"),
            ("0,v\n", "t.csv:1: motor on \"elbow\": the value \"v\" is not a number"),
            (",\n", "t.csv:1: motor on \"elbow\": the time is missing"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(message) && error.lines().count() == 1, "{text:?}: {error}");
        }
    }
}
