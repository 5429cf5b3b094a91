//! The files of a chart: for every scene two pictures as SVG and PNG, for all of them one CSV, one page and one text table.

use crate::chart::energy::energy_picture;
use crate::chart::page::page;
use crate::chart::report::{ENERGY, Report};
use crate::chart::table::write_csv;
use crate::chart::work_precision::work_precision_picture;
use crate::drawing::error::ChartError;
use crate::drawing::files::{write_text, write_with};
use std::path::Path;

impl Report {
    /// Writes every file into a folder that exists, each whole or not at all.
    ///
    /// # Errors
    /// [`ChartError::Write`] or [`ChartError::Draw`].
    pub fn write(&self, folder: &Path) -> Result<(), ChartError> {
        let mut pictures = Vec::new();
        for chart in &self.scenes {
            let work = work_precision_picture(chart, &self.foreign);
            let energy = energy_picture(&chart.name, chart.duration, &chart.energies, &chart.measurements);
            let mut drawn = Vec::new();
            for (picture, ending) in [(work, ""), (energy, ENERGY)] {
                let file = |kind: &str| folder.join(format!("{}{ending}.{kind}", chart.name));
                let svg = picture.svg()?;
                write_text(&file("svg"), &svg)?;
                write_with(&file("png"), |path| picture.write_png(path))?;
                drawn.push(svg);
            }
            pictures.push(drawn);
        }
        write_text(&folder.join("measurements.csv"), &write_csv(&self.measurements()))?;
        write_text(&folder.join("index.html"), &page(self, &pictures))
    }
}
