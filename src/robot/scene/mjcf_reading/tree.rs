//! The elements of an MJCF file, with the elements of included files in their places.

use crate::scene::error::{Problem, SceneError};
use crate::scene::numbers::{numbers, shown};
use crate::scene::text::{XmlText, read_text};
use nalgebra::Vector3;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Deepest nesting of includes: a file that includes itself ends there.
const DEEPEST: usize = 32;

/// An element, its attributes, and where it stands.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub name: String,
    pub file: Rc<PathBuf>,
    pub line: usize,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
}

/// The outermost element of a file, whose text this is.
pub(crate) fn read_tree(path: &Path, text: &str) -> Result<Element, SceneError> {
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    read_file(path, text, &folder, 0)
}

fn read_file(path: &Path, text: &str, folder: &Path, depth: usize) -> Result<Element, SceneError> {
    let xml = XmlText::new(path, text)?;
    let document = xml.document()?;
    let root = element(&xml, &Rc::new(path.to_path_buf()), document.root_element());
    included(root, folder, depth)
}

fn element(xml: &XmlText, file: &Rc<PathBuf>, node: roxmltree::Node) -> Element {
    Element {
        name: node.tag_name().name().to_string(),
        file: file.clone(),
        line: xml.line(node),
        attributes: node.attributes().map(|one| (one.name().to_string(), one.value().to_string())).collect(),
        children: node.children().filter(roxmltree::Node::is_element).map(|child| element(xml, file, child)).collect(),
    }
}

/// The element with the children of included files in the places of the includes.
fn included(mut element: Element, folder: &Path, depth: usize) -> Result<Element, SceneError> {
    let mut children = Vec::with_capacity(element.children.len());
    for child in element.children {
        if child.name != "include" {
            children.push(included(child, folder, depth)?);
            continue;
        }
        if depth == DEEPEST {
            return Err(child.error("file", "files include each other without an end".to_string()));
        }
        let file = folder.join(child.text("file").ok_or_else(|| child.missing("file"))?);
        let text = read_text(&file).map_err(|error| child.error("file", error.to_string()))?;
        children.extend(read_file(&file, &text, folder, depth + 1)?.children);
    }
    element.children = children;
    Ok(element)
}

impl Element {
    /// An attribute.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// All children of a name.
    pub fn all<'e>(&'e self, name: &'e str) -> impl Iterator<Item = &'e Element> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The numbers of an attribute, at least `least` and at most `most` of them.
    pub fn list(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, SceneError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let count = text.split_whitespace().count();
        if !(least..=most).contains(&count) {
            let wanted = if least == most { least.to_string() } else { format!("{least} to {most}") };
            return Err(self.error(name, format!("{wanted} numbers were expected, not {count}")));
        }
        let (words, _) = numbers(text, count, false).map_err(|reason| self.error(name, reason))?;
        Ok(Some(words.iter().filter_map(|word| word.parse().ok()).collect()))
    }

    /// The number of an attribute.
    pub fn number(&self, name: &str) -> Result<Option<f64>, SceneError> {
        Ok(self.list(name, 1, 1)?.and_then(|list| list.first().copied()))
    }

    /// The three numbers of an attribute.
    pub fn vector(&self, name: &str) -> Result<Option<Vector3<f64>>, SceneError> {
        Ok(self.list(name, 3, 3)?.map(|list| Vector3::from_column_slice(&list)))
    }

    /// Whether an attribute says true or false; `None` for "auto" and where it is not there.
    pub fn flag(&self, name: &str) -> Option<bool> {
        match self.text(name)?.trim() {
            "true" => Some(true),
            "false" => Some(false),
            _ => None,
        }
    }

    /// The error that an attribute is wrong.
    pub fn error(&self, attribute: &str, reason: String) -> SceneError {
        self.refuse(Problem::Number {
            element: self.name.clone(),
            attribute: attribute.to_string(),
            text: shown(self.text(attribute).unwrap_or_default()),
            reason,
        })
    }

    /// The error that an attribute is missing.
    pub fn missing(&self, attribute: &str) -> SceneError {
        self.refuse(Problem::MissingAttribute { element: self.name.clone(), attribute: attribute.to_string() })
    }

    fn refuse(&self, problem: Problem) -> SceneError {
        SceneError { file: self.file.to_path_buf(), line: Some(self.line), element: None, problem: Box::new(problem) }
    }
}
