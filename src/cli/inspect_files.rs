//! The files that `catena inspect` makes of a log: tables, plots, and complete logs.

use crate::cli::page_files::is_same;
use crate::cli::recorded::Recorded;
use crate::cli::terminal::printing::{Failure, warn};
use anyhow::{Context, bail};
use catena::drawing::files::write_with;
use catena::drawing::picture::Figure;
use catena::output::inspection::joint_values::{JointKinds, joint_kinds};
use catena::output::inspection::summary::Summary;
use catena::output::inspection::table::write_table;
use catena::output::log::reading::recovery::recover;
use catena::session::check_place;
use std::cell::Cell;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// An output must replace neither its source nor another output, and needs an existing folder.
pub(crate) fn check_outputs(log: &Path, outputs: &[&Path]) -> anyhow::Result<()> {
    for (number, output) in outputs.iter().enumerate() {
        check_place(output)?;
        if is_same(log, output) {
            bail!("the output {} is the log itself", output.display());
        }
        if let Some(other) = outputs[..number].iter().find(|other| is_same(other, output)) {
            bail!("the outputs {} and {} are the same file", other.display(), output.display());
        }
    }
    Ok(())
}

/// The kinds of the joints, as far as the log tells them.
pub(crate) fn kinds(log: &Path) -> JointKinds {
    match Recorded::open(log) {
        Ok(recorded) => joint_kinds(&recorded.loaded.model),
        Err(error) => {
            warn(format_args!("units of joints are not known: {error:#}"));
            JointKinds::new()
        }
    }
}

pub(crate) fn write_csv(log: &Path, table: &Path) -> anyhow::Result<()> {
    let kinds = kinds(log);
    write_whole(table, |out| Ok(write_table(log, &kinds, out)?))
}

/// Writes a file that is not there before all of it is.
fn write_whole(path: &Path, write: impl Fn(&mut BufWriter<File>) -> anyhow::Result<()>) -> anyhow::Result<()> {
    write_with(path, |part| {
        let write = || -> anyhow::Result<()> {
            let mut out = BufWriter::new(File::create(part)?);
            write(&mut out)?;
            Ok(out.flush()?)
        };
        write().with_context(|| format!("cannot write {}", path.display()))
    })
}

/// A recovered log does not replace a file, since that file may be a log as well.
pub(crate) fn check_absent(whole: &Path) -> anyhow::Result<()> {
    if whole.exists() {
        bail!("{} is there already", whole.display());
    }
    Ok(())
}

/// Writes a complete log of the readable part of another; returns a description of it.
pub(crate) fn recover_into(log: &Path, whole: &Path, summary: &Summary) -> Result<String, Failure> {
    let messages = Cell::new(0);
    let write = |out: &mut BufWriter<File>| {
        messages.set(recover(log, out)?);
        Ok(())
    };
    write_whole(whole, write).map_err(Failure::run)?;
    let (log, whole, messages) = (log.display(), whole.display(), messages.get());
    let missing = summary.completeness.missing();
    let of = missing.map_or(String::new(), |missing| format!(", all that can be read of {log}, which is {missing}"));
    Ok(format!("{whole}: a complete log of {messages} messages{of}\n"))
}

pub(crate) fn check_ending(plot: &Path) -> anyhow::Result<()> {
    match ending(plot).as_deref() {
        Some("svg" | "png") => Ok(()),
        _ => bail!("{}: a plot ends in .svg or .png", plot.display()),
    }
}

fn ending(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase())
}

pub(crate) fn draw(figure: &Figure, plot: &Path) -> anyhow::Result<()> {
    let drawn = if ending(plot).as_deref() == Some("png") {
        write_with(plot, |part| figure.write_png(part))
    } else {
        figure.svg().and_then(|text| catena::drawing::files::write_text(plot, &text))
    };
    Ok(drawn?)
}
