//! The files of a map: for every problem a picture as SVG and PNG, for all of them one CSV and one page.

use crate::drawing::error::ChartError;
use crate::drawing::files::{write_text, write_with};
use crate::stress::map::Map;
use crate::stress::page::page;
use crate::stress::picture::{svg, write_png};
use crate::stress::table::write_csv;
use std::path::Path;

/// Writes everything into a folder that exists, each file whole or not at all.
///
/// # Errors
/// [`ChartError::Write`] or [`ChartError::Draw`].
pub fn write(maps: &[Map], machine: &str, folder: &Path) -> Result<(), ChartError> {
    let mut pictures = Vec::new();
    for map in maps {
        let file = |ending: &str| folder.join(format!("{}.{ending}", map.thinned.problem.name));
        let picture = svg(map)?;
        write_text(&file("svg"), &picture)?;
        write_with(&file("png"), |path| write_png(map, path))?;
        pictures.push(picture);
    }
    write_text(&folder.join("cells.csv"), &write_csv(maps))?;
    write_text(&folder.join("index.html"), &page(maps, &pictures, machine))
}
