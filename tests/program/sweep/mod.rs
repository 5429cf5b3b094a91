//! `catena sweep`: what varies, what is kept, and that rows depend on nothing but the sweep and their index.

mod errors;
mod folders;
#[cfg(unix)]
mod machines;
#[cfg(feature = "parquet")]
mod parquet;
mod rows;

use crate::common::command::{self, catena, text};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A pendulum of one joint, in runs of 0.3 s.
const HEAD: &str =
    "[sweep]\nscene = \"pendulum.urdf\"\nsamples = 1\n[simulation]\nduration = 0.3\nstages = 3\nstep = 0.01\n";

/// Six masses times four drawn starts.
const MIXED: &str = "[sweep]\nscene = \"pendulum.urdf\"\nsamples = 4\nseed = 3\nrows_per_file = 10\n\
    [simulation]\nduration = 0.3\nstages = 3\nstep = 0.01\n\
    [[vary]]\nkey = \"rod.mass\"\nlinear = { from = 0.5, to = 3.0, count = 6 }\n\
    [[vary]]\nkey = \"positions.hinge\"\nuniform = [-1.0, 1.0]\n";

/// A folder of this test's own with a pendulum and a sweep in it.
fn folder(name: &str, sweep: &str) -> PathBuf {
    let folder = command::folder(name);
    std::fs::write(folder.join("sweep.toml"), sweep).expect("the sweep is written");
    folder
}

/// Makes a sweep with more options, which must go well.
fn sweep(folder: &Path, options: &[&str]) {
    let arguments = [&["sweep", "sweep.toml", "--format", "csv"], options].concat();
    let output = catena(folder, &arguments).output().expect("catena runs");
    assert_eq!(output.status.code(), Some(0), "{options:?}: {}", text(&output.stderr));
}

/// All complete files of rows, by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("the folder is there").map(|entry| entry.unwrap());
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names
        .filter(|name| name.starts_with("rows-"))
        .map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap()))
        .collect()
}

/// The rows of all files by column.
fn table(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let mut rows = Vec::new();
    for bytes in files(folder).into_values() {
        let text = String::from_utf8(bytes).expect("UTF-8");
        let mut lines = text.lines().map(cells);
        let names = lines.next().expect("names");
        rows.extend(lines.map(|cells| {
            assert_eq!(cells.len(), names.len(), "{cells:?}");
            names.iter().cloned().zip(cells).collect()
        }));
    }
    rows
}

/// The cells of a line.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '"' if quoted && characters.peek() == Some(&'"') => cells.last_mut().unwrap().extend(characters.next()),
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            other => cells.last_mut().unwrap().push(other),
        }
    }
    cells
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    let cell = row.get(column).unwrap_or_else(|| panic!("there is no column {column} in {row:?}"));
    cell.parse().unwrap_or_else(|_| panic!("{column}: {cell:?}"))
}
