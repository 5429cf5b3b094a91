//! Targets of motors: from a number, a list in the scene file, or a CSV file beside it.

use crate::mechanism::description::target::{Interpolation, Target, TargetError};
use crate::scene::coupling_reader::CouplingReader;
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::joint_schema::TargetKey;
use crate::scene::joint_settings::TableFile;
use crate::scene::scene_files::SceneFiles;
use crate::scene::target_csv::{Entry, entries_of_csv};
use std::path::{Path, PathBuf};
use toml::Spanned;

impl CouplingReader<'_> {
    /// The target of a motor; its CSV file, if it has one, joins `tables`.
    pub fn target(
        &self,
        key: &Spanned<TargetKey>,
        interpolation: Interpolation,
        owner: &Element,
        files: &mut dyn SceneFiles,
        tables: &mut Vec<TableFile>,
    ) -> Result<Target, SceneError> {
        let span = key.span();
        let (entries, file): (Vec<Entry>, PathBuf) = match key.get_ref() {
            TargetKey::Number(value) => return Ok(Target::constant(*value)),
            TargetKey::Entries(entries) => (self.entries(entries, owner)?, self.text.file.to_path_buf()),
            TargetKey::File(name) => {
                let path = self.text.file.parent().unwrap_or(Path::new("")).join(name);
                let text = match tables.iter().find(|table| table.path == path) {
                    Some(known) => known.text.clone(),
                    None => {
                        let text = files.text(&path).map_err(|error| match *error.problem {
                            // Whose fault it is that there is no such file stands in the scene.
                            Problem::Unreadable(_) => {
                                let (key, message) = (Some("motor.target".to_string()), error.to_string());
                                self.text.error(&span, None, Problem::Toml { key, message })
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
        let points: Vec<(f64, f64)> = entries.iter().map(|entry| (entry.time, entry.value)).collect();
        let refuse = |line: Option<usize>, reason: String| {
            let line = line.or((file == self.text.file).then(|| self.text.line(&span)));
            let element = Some(owner.clone());
            SceneError { file: file.clone(), line, element, problem: Box::new(Problem::Table(reason)) }
        };
        let target = Target::table(&points, interpolation).map_err(|error| {
            let line = match error {
                TargetError::Empty => None,
                TargetError::NotFinite { index, .. } | TargetError::Order { index, .. } => {
                    entries.get(index - 1).map(|entry| entry.line)
                }
            };
            refuse(line, format!("its target: {error}"))
        })?;
        for (entry, pair) in entries.iter().skip(1).zip(points.windows(2)) {
            let middle = 0.5 * pair[0].0 + 0.5 * pair[1].0;
            if !target.value(middle).is_finite() || !target.rate(middle).is_finite() {
                let reason = "its target changes so much from the entry before that its rate is infinite".to_string();
                return Err(refuse(Some(entry.line), reason));
            }
        }
        Ok(target)
    }

    /// The entries of a list in the scene file.
    fn entries(&self, list: &[Spanned<Vec<f64>>], owner: &Element) -> Result<Vec<Entry>, SceneError> {
        let entry = |entry: &Spanned<Vec<f64>>| match entry.get_ref().as_slice() {
            &[time, value] => Ok(Entry { line: self.text.line(&entry.span()), time, value }),
            numbers => {
                let reason = format!("an entry of its target has {} numbers; give [time, value]", numbers.len());
                Err(self.text.error(&entry.span(), Some(owner.clone()), Problem::Table(reason)))
            }
        };
        list.iter().map(entry).collect()
    }
}
