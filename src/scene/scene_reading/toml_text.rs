//! The line and the key of every byte of a TOML file, for messages.

use crate::scene::error::{Element, Problem, SceneError};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// The text of a TOML file.
pub(crate) struct TomlText<'t> {
    pub file: &'t Path,
    pub text: &'t str,
}

impl TomlText<'_> {
    /// Reads the whole file.
    ///
    /// # Errors
    /// [`SceneError`] with the line and the key at fault.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        toml::from_str(self.text).map_err(|error| {
            let line = error.span().map(|span| self.line(&span));
            let key = error.span().and_then(|span| self.key(span.start));
            // One line, whatever the file puts into it.
            let mut message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
            if let Some(table) = key.as_ref().filter(|key| !key.contains('.') && message.ends_with("a sequence")) {
                message = format!("{message}; there may be several: write [[{table}]]");
            }
            let element = error.span().and_then(|span| self.obstacle(span.start));
            let problem = Box::new(Problem::Toml { key, message });
            SceneError { file: self.file.to_path_buf(), line, element, problem }
        })
    }

    /// The line on which a span begins, counted from 1.
    pub fn line(&self, span: &Range<usize>) -> usize {
        let before = self.text.as_bytes().get(..span.start).unwrap_or(self.text.as_bytes());
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    /// The error of what is wrong at a span.
    pub fn error(&self, span: &Range<usize>, element: Option<Element>, problem: Problem) -> SceneError {
        let line = Some(self.line(span));
        SceneError { file: self.file.to_path_buf(), line, element, problem: Box::new(problem) }
    }

    /// The obstacle that a byte belongs to, if it has a name.
    fn obstacle(&self, offset: usize) -> Option<Element> {
        let table = DeTable::parse(self.text).ok()?;
        let DeValue::Array(obstacles) = table.get_ref().get("obstacle")?.get_ref() else { return None };
        let own = obstacles.iter().find(|obstacle| {
            let mut found = Vec::new();
            search_value(obstacle.get_ref(), offset, &mut Vec::new(), &mut found);
            !found.is_empty()
        })?;
        let DeValue::String(name) = own.get_ref().as_table()?.get("name")?.get_ref() else { return None };
        Some(Element::Obstacle(name.to_string()))
    }

    /// The dotted name of the innermost key that a byte belongs to.
    fn key(&self, offset: usize) -> Option<String> {
        let table = DeTable::parse(self.text).ok()?;
        let mut found = Vec::new();
        search_table(table.get_ref(), offset, &mut Vec::new(), &mut found);
        (!found.is_empty()).then(|| found.join("."))
    }
}

/// The longest path of keys to a key or value that holds the byte. The span of a table is its header alone, so that no
/// branch can be left out.
fn search_table<'t>(table: &'t DeTable, offset: usize, path: &mut Vec<&'t str>, found: &mut Vec<&'t str>) {
    for (key, value) in table {
        path.push(key.get_ref());
        if (key.span().contains(&offset) || value.span().contains(&offset)) && path.len() > found.len() {
            found.clone_from(path);
        }
        search_value(value.get_ref(), offset, path, found);
        path.pop();
    }
}

fn search_value<'t>(value: &'t DeValue, offset: usize, path: &mut Vec<&'t str>, found: &mut Vec<&'t str>) {
    match value {
        DeValue::Table(table) => search_table(table, offset, path, found),
        DeValue::Array(values) => {
            for value in values.iter() {
                if value.span().contains(&offset) && path.len() > found.len() {
                    found.clone_from(path);
                }
                search_value(value.get_ref(), offset, path, found);
            }
        }
        _ => {}
    }
}
