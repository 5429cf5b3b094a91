//! Height fields of MJCF as meshes.
//!
//! A field of r rows and c columns has the heights `z_ij = Z (d_ij − min d)/(max d − min d)` above its frame, at
//!
//! ```text
//!     x_j = X (2 j/(c − 1) − 1),   y_i = Y (2 i/(r − 1) − 1)          size = (X, Y, Z, B) in m
//! ```
//!
//! Each cell is two triangles, on both sides of the line from `(i, j)` to `(i + 1, j + 1)`, as MuJoCo 4.0 has them. Sides and a bottom at −B close the
//! solid. The rows of `elevation` are read from the largest y down; those of a file, which has r and c as integers of 32 bits before its numbers of 32
//! bits, from the smallest one up.

use crate::scene::bounded::read_bounded;
use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::tree::Element;
use std::fmt::Write;
use std::path::Path;

/// Most heights of a field.
const MOST: usize = 1_000_000;

/// A height field, read.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    /// The name of the file that its mesh would have.
    pub file: String,
    rows: usize,
    columns: usize,
    /// Heights above the frame (m), row by row from the smallest y up.
    heights: Vec<f64>,
    /// X, Y and B (m).
    size: [f64; 3],
}

impl Field {
    /// A height field among the assets, from its file if it has one, with its name; `None` if it is a picture.
    pub fn read(asset: &Element, file: Option<&Path>) -> Result<Option<(String, Field)>, SceneError> {
        let size = asset.list("size", 4, 4)?.ok_or_else(|| asset.missing("size"))?;
        let &[x, y, z, base] = size.as_slice() else { return Err(asset.missing("size")) };
        if !(x > 0.0 && y > 0.0 && z > 0.0 && base > 0.0) {
            return Err(asset.error("size", "all four numbers must be greater than zero".to_string()));
        }
        let (rows, columns, mut heights) = match file {
            Some(file) if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) => {
                return Ok(None);
            }
            Some(file) => {
                let bytes = read_bounded(file).map_err(|error| error.to_string());
                from_bytes(&bytes.map_err(|reason| asset.error("file", reason))?)
                    .ok_or_else(|| asset.error("file", "it is no height field of MuJoCo".to_string()))?
            }
            None => {
                let count = |name: &str| -> Result<usize, SceneError> {
                    let count = asset.number(name)?.ok_or_else(|| asset.missing(name))?;
                    match (2.0..=MOST as f64).contains(&count) && count.fract() == 0.0 {
                        true => Ok(count as usize),
                        false => Err(asset.error(name, format!("a whole number from 2 to {MOST} is wanted"))),
                    }
                };
                let (rows, columns) = (count("nrow")?, count("ncol")?);
                if rows * columns > MOST {
                    return Err(asset.error("nrow", format!("a field has at most {MOST} heights")));
                }
                let flat = || vec![0.0; rows * columns];
                let given = asset.list("elevation", rows * columns, rows * columns)?.unwrap_or_else(flat);
                (rows, columns, given.rchunks(columns).flatten().copied().collect())
            }
        };
        let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let range = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max) - least;
        let scale = if range > 0.0 { z / range } else { 0.0 };
        heights.iter_mut().for_each(|height| *height = scale * (*height - least));
        let stem = file.and_then(Path::file_stem).map(|stem| stem.to_string_lossy());
        let name = asset.text("name").map(str::to_string).or(stem.map(|stem| stem.into_owned())).unwrap_or_default();
        let file = format!("{}.hfield.obj", name.replace(['/', '\\'], "_"));
        Ok(Some((name, Field { file, rows, columns, heights, size: [x, y, base] })))
    }

    /// Its solid as an OBJ file.
    pub fn obj(&self) -> String {
        let Field { rows, columns, heights, size: [x, y, base], .. } = self;
        let (rows, columns) = (*rows, *columns);
        let at = |index: usize, count: usize| 2.0 * index as f64 / (count - 1) as f64 - 1.0;
        let mut text = String::new();
        // Writing into a String cannot fail. Corners above, and the edge below them.
        for (index, height) in heights.iter().enumerate() {
            let (row, column) = (index / columns, index % columns);
            let _ = writeln!(text, "v {:?} {:?} {height:?}", x * at(column, columns), y * at(row, rows));
        }
        let edge = self.edge();
        for index in &edge {
            let (row, column) = (index / columns, index % columns);
            let _ = writeln!(text, "v {:?} {:?} {:?}", x * at(column, columns), y * at(row, rows), -base);
        }
        // Corners count from one.
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let [a, b] = [row, row + 1].map(|row| row * columns + column + 1);
                let _ = writeln!(text, "f {a} {} {}\nf {a} {} {b}", a + 1, b + 1, b + 1);
            }
        }
        let below = |place: usize| heights.len() + place % edge.len() + 1;
        for (place, here) in edge.iter().enumerate() {
            let next = edge[(place + 1) % edge.len()];
            let (low, low_next) = (below(place), below(place + 1));
            let _ = writeln!(text, "f {} {low} {low_next}\nf {} {low_next} {}", here + 1, here + 1, next + 1);
            if place > 0 && place + 1 < edge.len() {
                let _ = writeln!(text, "f {} {low_next} {low}", below(0));
            }
        }
        text
    }

    /// The corners of the edge, against the clock from above.
    fn edge(&self) -> Vec<usize> {
        let (rows, columns) = (self.rows, self.columns);
        let last = (rows - 1) * columns;
        let down = (1..rows).rev().map(|row| row * columns);
        let up = (0..rows - 1).map(|row| row * columns + columns - 1);
        (0..columns - 1).chain(up).chain((last + 1..last + columns).rev()).chain(down).collect()
    }
}

/// Rows, columns and numbers of a file.
fn from_bytes(bytes: &[u8]) -> Option<(usize, usize, Vec<f64>)> {
    let mut words = bytes.chunks_exact(4).filter_map(|word| <[u8; 4]>::try_from(word).ok());
    let mut count = || words.next().map(i32::from_le_bytes).and_then(|count| usize::try_from(count).ok());
    let (rows, columns) = (count()?, count()?);
    let numbers: Vec<f64> = words.map(|word| f64::from(f32::from_le_bytes(word))).collect();
    let fits = rows >= 2 && columns >= 2 && rows.checked_mul(columns) == Some(numbers.len()) && numbers.len() <= MOST;
    (fits && numbers.iter().all(|number| number.is_finite())).then_some((rows, columns, numbers))
}
