//! Tables and numbers for people.

use catena::output::page::PageTable;
use std::fmt::Write as _;

/// A table whose columns are as wide as their widest cell.
pub struct Table {
    /// Its title, as pages show it.
    pub title: &'static str,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these headings.
    pub fn new(title: &'static str, head: &[&str]) -> Self {
        Table { title, rows: vec![head.iter().map(ToString::to_string).collect()] }
    }

    /// Whether it has headings alone.
    pub fn is_empty(&self) -> bool {
        self.rows.len() < 2
    }

    /// The table for a page.
    pub fn on_page(&self) -> PageTable {
        let (columns, rows) =
            self.rows.split_first().map_or((Vec::new(), &[][..]), |(head, rows)| (head.clone(), rows));
        PageTable { title: self.title.to_string(), columns, rows: rows.to_vec() }
    }

    /// Adds a row, a cell for each heading.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// Writes the table, unless it has no rows.
    pub fn write(&self, out: &mut String) {
        if self.is_empty() {
            return;
        }
        let width = |column: usize| self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.rows[0].len()).map(width).collect();
        out.push('\n');
        for (index, row) in self.rows.iter().enumerate() {
            let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:<width$}"));
            let _ = writeln!(out, "  {}", cells.collect::<Vec<_>>().join("  ").trim_end());
            if index == 0 {
                let rules: Vec<String> = widths.iter().map(|&width| "─".repeat(width)).collect();
                let _ = writeln!(out, "  {}", rules.join("  "));
            }
        }
    }
}

/// Four significant digits.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    let digits = (3 - value.abs().log10().floor() as i32).max(0) as usize;
    if value.abs() < 1e-3 || value.abs() >= 1e6 { format!("{value:.3e}") } else { format!("{value:.digits$}") }
}

/// Three numbers of four significant digits.
pub fn triple(values: &nalgebra::Vector3<f64>) -> String {
    format!("{}, {}, {}", number(values.x), number(values.y), number(values.z))
}
