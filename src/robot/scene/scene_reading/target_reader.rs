//! Targets of motors: from a number, a list in the scene file, a CSV file beside it, or a formula of time.

use crate::mechanism::description::formula::Formula;
use crate::mechanism::description::target::{Interpolation, Target};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::joint_settings::{TableFile, TargetTable};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::joint_schema::TargetKey;
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::scene_reading::scene_numbers::{Quantity, Unit};
use crate::scene::scene_reading::target_csv::{Entry, entries_of_csv};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Reads a value of a target, whose place is for messages.
pub(crate) type ReadValue<'v> = dyn Fn(Quantity, &Range<usize>) -> Result<f64, SceneError> + 'v;

impl CouplingReader<'_> {
    /// The target of a motor, whose numbers `value` reads, and its table if it is no number. Its CSV file, if it has one, joins `tables`.
    pub fn target(
        &self,
        key: &Spanned<TargetKey>,
        value: &ReadValue,
        interpolation: Interpolation,
        owner: &Element,
        files: &mut dyn SceneFiles,
        tables: &mut Vec<TableFile>,
    ) -> Result<(Target, Option<TargetTable>), SceneError> {
        let span = key.span();
        let (entries, file): (Vec<Entry>, PathBuf) = match key.get_ref() {
            TargetKey::Number(given) => return Ok((Target::constant(value(*given, &span)?), None)),
            TargetKey::Start => return Ok((Target::constant(0.0), None)),
            TargetKey::Formula { text, parameters } => return self.formula(text, parameters, owner),
            TargetKey::Entries(entries) => (self.entries(entries, value, owner)?, self.text.file.to_path_buf()),
            TargetKey::File(name) => {
                let path = self.text.file.parent().unwrap_or(Path::new("")).join(name);
                let text = match tables.iter().find(|table| table.path == path) {
                    Some(known) => known.text.clone(),
                    None => {
                        let text = files.text(&path).map_err(|error| match *error.problem {
                            // Whose fault it is that there is no such file stands in the scene.
                            Problem::Unreadable(_) => {
                                let (key, message) = (None, error.to_string());
                                self.text.error(&span, Some(owner.clone()), Problem::Toml { key, message })
                            }
                            _ => error,
                        })?;
                        tables.push(TableFile { path: path.clone(), text: text.clone() });
                        text
                    }
                };
                (entries_of_csv(&text, &path, owner)?, path)
            }
        };
        let points = entries.iter().map(|entry| (entry.time, entry.value)).collect();
        let table = TargetTable { points, interpolation };
        let target = table.target().map_err(|(entry, reason)| {
            let line = entry.and_then(|entry| entries.get(entry)).map(|entry| entry.line);
            let line = line.or((file == self.text.file).then(|| self.text.line(&span)));
            let element = Some(owner.clone());
            SceneError { file: file.clone(), line, element, problem: Box::new(Problem::Table(reason)) }
        })?;
        Ok((target, Some(table)))
    }

    /// A formula with its parameters, which is a number where the run starts.
    fn formula(
        &self,
        text: &Spanned<String>,
        parameters: &[(String, f64)],
        owner: &Element,
    ) -> Result<(Target, Option<TargetTable>), SceneError> {
        let refuse = |reason| Err(self.text.error(&text.span(), Some(owner.clone()), Problem::Table(reason)));
        match Formula::new(text.get_ref(), parameters) {
            Err(error) => refuse(error.to_string()),
            Ok(formula) => match formula.check_start() {
                Err(reason) => refuse(reason),
                Ok(()) => Ok((Target::formula(formula), None)),
            },
        }
    }

    /// The entries of a list in the scene file.
    fn entries(
        &self,
        list: &[Spanned<Vec<Quantity>>],
        value: &ReadValue,
        owner: &Element,
    ) -> Result<Vec<Entry>, SceneError> {
        let entry = |entry: &Spanned<Vec<Quantity>>| match entry.get_ref().as_slice() {
            &[Quantity { number: time, unit: Unit::Unwritten }, given] => {
                let (line, value) = (self.text.line(&entry.span()), value(given, &entry.span())?);
                Ok(Entry { line, time, value })
            }
            [_, _] => {
                let reason = "the time of an entry of its target is a number in seconds".to_string();
                Err(self.text.error(&entry.span(), Some(owner.clone()), Problem::Table(reason)))
            }
            numbers => {
                let reason = format!("an entry of its target has {} numbers; give [time, value]", numbers.len());
                Err(self.text.error(&entry.span(), Some(owner.clone()), Problem::Table(reason)))
            }
        };
        list.iter().map(entry).collect()
    }
}
