//! The line and the key of every byte of a TOML file, for messages.

use crate::scene::error::{Element, Problem, SceneError};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A table that may occur several times: its key, the keys of its names, and its element in messages.
type Named = (&'static str, &'static [&'static str], fn(&[&str]) -> Option<Element>);

const NAMED: [Named; 10] = [
    ("robot", &["name"], |names| Some(Element::Robot(names.first()?.to_string()))),
    ("body", &["name"], |names| Some(Element::Body(names.first()?.to_string()))),
    ("loop", &["name"], |names| Some(Element::Loop(names.first()?.to_string()))),
    ("spring", &["name"], |names| Some(Element::Spring(names.first()?.to_string()))),
    ("rope", &["name"], |names| Some(Element::Rope(names.first()?.to_string()))),
    ("load", &["joint", "link"], |names| Some(Element::Load(names.first()?.to_string()))),
    ("motor", &["joint"], |names| Some(Element::Motor(names.first()?.to_string()))),
    ("joint", &["name"], |names| Some(Element::Joint(names.first()?.to_string()))),
    ("obstacle", &["name"], |names| Some(Element::Obstacle(names.first()?.to_string()))),
    ("link", &["name"], |names| Some(Element::Link(names.first()?.to_string()))),
];

const PAIR: Named = ("pair", &["a", "b"], |names| match names {
    [a, b] => Some(Element::Pair(format!("{a:?} and {b:?}"))),
    _ => None,
});

/// Tables of a scene that occur once, and tables of sweep files.
const SINGLE: [&str; 3] = ["scene", "contact", "simulation"];
const OF_SWEEPS: [&str; 3] = ["sweep", "vary", "keep"];

/// The text of a TOML file.
pub struct TomlText<'t> {
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
            let mut message = plain(&error.message().split_whitespace().collect::<Vec<_>>().join(" "));
            if let Some(hint) = key.as_deref().and_then(|key| self.hint(key, &message)) {
                message = format!("{message}; {hint}");
            }
            if error.span().is_some_and(|span| begins_with_a_point(self.text, span.start)) {
                message = format!("{message}: a number needs a digit before its point, such as -0.5");
            }
            let element = error.span().and_then(|span| self.element(span.start));
            let problem = Box::new(Problem::Toml { key, message });
            SceneError { file: self.file.to_path_buf(), line, element, problem }
        })
    }

    /// Advice for a key at which the file could not be read, where the reason is likely.
    fn hint(&self, key: &str, message: &str) -> Option<String> {
        let table = key.split('.').next().unwrap_or_default();
        if table == key && message.ends_with("a sequence") {
            return Some(format!("there may be several: write [[{table}]]"));
        }
        if SINGLE.contains(&table)
            && let Some(DeValue::Array(_)) =
                DeTable::parse(self.text).ok()?.get_ref().get(table).map(|value| value.get_ref())
        {
            return Some(format!("there is only one: write [{table}]"));
        }
        let is_scene = |name: &str| SINGLE.contains(&name) || NAMED.iter().any(|named| named.0 == name);
        let expected = |name: &str| message.contains(&format!("`{name}`,"));
        if table != key || !message.starts_with("unknown field") {
            return None;
        }
        if OF_SWEEPS.contains(&table) && expected("robot") {
            return Some("this file describes a sweep: use catena sweep".to_string());
        }
        let said = "this file describes a scene: use catena simulate, or write a file with [sweep] and [[vary]] for it";
        (is_scene(table) && expected("sweep")).then(|| said.to_string())
    }

    /// The line on which a span begins, counted from 1.
    pub fn line(&self, span: &Range<usize>) -> usize {
        let before = self.text.as_bytes().get(..span.start).unwrap_or(self.text.as_bytes());
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    /// The error of a defect at a span.
    pub fn error(&self, span: &Range<usize>, element: Option<Element>, problem: Problem) -> SceneError {
        let line = Some(self.line(span));
        SceneError { file: self.file.to_path_buf(), line, element, problem: Box::new(problem) }
    }

    /// The part of the scene whose table a byte belongs to, if that says its name.
    fn element(&self, offset: usize) -> Option<Element> {
        let table = DeTable::parse(self.text).ok()?;
        let root = table.get_ref();
        let pairs = root.get("contact").and_then(|contact| contact.get_ref().as_table()?.get("pair"));
        let arrays = NAMED.iter().filter_map(|named| Some((root.get(named.0)?, named)));
        for (array, (_, keys, element)) in arrays.chain(pairs.map(|pairs| (pairs, &PAIR))) {
            let DeValue::Array(array) = array.get_ref() else { continue };
            let Some(own) = array.iter().find(|own| holds(own, offset)) else { continue };
            let own = own.get_ref().as_table()?;
            let names: Vec<&str> = keys.iter().filter_map(|key| own.get(*key)?.get_ref().as_str()).collect();
            return element(&names);
        }
        None
    }

    /// The dotted name of the innermost key that a byte belongs to.
    fn key(&self, offset: usize) -> Option<String> {
        let table = DeTable::parse(self.text).ok()?;
        let mut found = Vec::new();
        search_table(table.get_ref(), offset, &mut Vec::new(), &mut found);
        (!found.is_empty()).then(|| found.join("."))
    }
}

/// Whether the text at a byte is a number, with a sign or without, that begins with a point.
fn begins_with_a_point(text: &str, at: usize) -> bool {
    let rest = text.get(at..).unwrap_or_default().trim_start_matches(['+', '-']);
    rest.strip_prefix('.').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
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

/// Whether a byte belongs to a table of an array: to its header, or to anything in it.
fn holds(table: &Spanned<DeValue>, offset: usize) -> bool {
    let mut found = Vec::new();
    search_value(table.get_ref(), offset, &mut Vec::new(), &mut found);
    table.span().contains(&offset) || !found.is_empty()
}

/// A message of the reader in the words of scene files, instead of the words of its data types.
fn plain(message: &str) -> String {
    let Some((found, expected)) = message.rsplit_once(", expected ") else { return message.to_string() };
    let (count, many) = (expected.strip_prefix("an array of length "), expected.strip_prefix("struct "));
    let expected = match expected {
        "f64" => "a number",
        "usize" | "u64" | "u32" => "a whole number",
        "a boolean" => "true or false",
        _ if many.is_some() => "a table, { key = value, ... }",
        _ => match count {
            Some(count) => return format!("{found}, expected {count} numbers, [...]"),
            None => expected,
        },
    };
    format!("{found}, expected {expected}")
}
