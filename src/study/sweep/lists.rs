//! The CSV file of a list of runs: key paths in the first line, numbers in all others, one line a run. Lines that begin with `#` are comments.

use crate::scene::{Problem, SceneError, rows_of_csv};
use std::path::Path;

/// A list of runs.
pub(super) struct List {
    /// The key paths.
    pub keys: Vec<String>,
    /// The line of the key paths, counted from 1.
    pub header: usize,
    /// The numbers, line after line.
    pub numbers: Vec<f64>,
    /// The line of each run in the file, counted from 1.
    pub lines: Vec<usize>,
}

/// Reads a list.
///
/// # Errors
/// [`SceneError`] with the line, if a line does not have one finite number for each key path.
pub(super) fn read_list(text: &str, file: &Path) -> Result<List, SceneError> {
    let refuse = |line: usize, reason: String| SceneError {
        file: file.to_path_buf(),
        line: Some(line),
        element: None,
        problem: Box::new(Problem::Table(reason)),
    };
    let mut rows = rows_of_csv(text);
    let (first, header) = rows.next().unwrap_or((1, ""));
    let keys: Vec<String> = header.split(',').map(|key| key.trim().trim_matches('"').to_string()).collect();
    if let Some(number) = keys.iter().find(|key| key.is_empty() || key.parse::<f64>().is_ok()) {
        return Err(refuse(
            first,
            format!("{number:?} is no key path; the first line names what the numbers below are, such as link1.mass"),
        ));
    }
    let (mut numbers, mut lines) = (Vec::new(), Vec::new());
    for (line, text) in rows {
        lines.push(line);
        let before = numbers.len();
        for cell in text.split(',').map(str::trim) {
            match cell.parse::<f64>() {
                Ok(number) if !number.is_nan() => numbers.push(number),
                _ => return Err(refuse(line, format!("{cell:?} is not a number"))),
            }
        }
        let count = numbers.len() - before;
        if count != keys.len() {
            return Err(refuse(line, format!("{count} numbers for {} key paths", keys.len())));
        }
    }
    if numbers.is_empty() {
        return Err(refuse(first + 1, "there are no numbers below the key paths".to_string()));
    }
    Ok(List { keys, header: first, numbers, lines })
}
