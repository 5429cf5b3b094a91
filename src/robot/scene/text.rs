//! The XML of a file: bytes, text, document, and the first byte of each line.
//!
//! Some files in the wild are one character away from XML (a NUL at the end, blank lines before the declaration, an undeclared namespace prefix).
//! They are repaired here, and every line keeps its number.

use crate::scene::bounded::read_bounded;
use crate::scene::error::{Problem, SceneError};
use crate::scene::warning::Warning;
use roxmltree::{Document, Node};
use std::path::{Path, PathBuf};

/// The text of a file, ready to be parsed as XML.
pub(crate) struct XmlText {
    pub file: PathBuf,
    pub text: String,
    /// Byte offset at which each line begins.
    line_starts: Vec<usize>,
    pub warnings: Vec<Warning>,
}

/// The bytes of a file.
pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>, SceneError> {
    read_bounded(file).map_err(|error| {
        let problem = Box::new(Problem::Unreadable(error.to_string()));
        SceneError { file: file.to_path_buf(), line: None, element: None, problem }
    })
}

/// The text of a file.
pub fn read_text(file: &Path) -> Result<String, SceneError> {
    String::from_utf8(read_bytes(file)?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|&&byte| byte == b'\n').count();
        let problem = Box::new(Problem::NotText(valid));
        SceneError { file: file.to_path_buf(), line: Some(line), element: None, problem }
    })
}

impl XmlText {
    /// Puts right what keeps a plainly meant file from being XML.
    pub fn new(file: &Path, source: &str) -> Result<Self, SceneError> {
        let mut xml =
            XmlText { file: file.to_path_buf(), text: String::new(), line_starts: Vec::new(), warnings: Vec::new() };
        let mut text = source.strip_prefix('\u{feff}').unwrap_or(source).to_string();
        let kept = text.trim_end_matches(['\0', ' ', '\t', '\r', '\n', '\u{1a}']).len();
        if kept == 0 {
            return Err(xml.error_at(None, Problem::Empty));
        }
        if text[kept..].contains(['\0', '\u{1a}']) {
            let line = 1 + text[..kept].matches('\n').count();
            xml.warn_at(line, "control characters after the end of the file were ignored");
        }
        text.truncate(kept);
        blank_late_declaration(&mut text);
        xml.text = text;
        xml.index_lines();
        xml.declare_prefixes()?;
        Ok(xml)
    }

    /// The parsed document.
    pub fn document(&self) -> Result<Document<'_>, SceneError> {
        Document::parse(&self.text).map_err(|error| self.xml_error(&error))
    }

    /// The line on which an element starts.
    pub fn line(&self, node: Node) -> usize {
        let start = node.range().start;
        self.line_starts.partition_point(|&line_start| line_start <= start)
    }

    fn index_lines(&mut self) {
        self.line_starts =
            std::iter::once(0).chain(self.text.match_indices('\n').map(|(offset, _)| offset + 1)).collect();
    }

    /// Declares namespace prefixes that are used without a declaration: their elements are not read anyway.
    fn declare_prefixes(&mut self) -> Result<(), SceneError> {
        // Each pass finds one prefix; a file with more than this many is not a slip.
        for _ in 0..32 {
            let unknown = match Document::parse(&self.text) {
                Err(roxmltree::Error::UnknownNamespace(prefix, position)) if !prefix.is_empty() => (prefix, position),
                Err(error) => return Err(self.xml_error(&error)),
                Ok(_) => return Ok(()),
            };
            let Some(after_name) = end_of_root_name(&self.text) else { return Ok(()) };
            let (prefix, position) = unknown;
            self.text.insert_str(after_name, &format!(" xmlns:{prefix}=\"urn:undeclared:{prefix}\""));
            self.index_lines();
            self.warn_at(position.row as usize, &format!("the namespace prefix {prefix:?} is not declared"));
        }
        Ok(())
    }

    fn warn_at(&mut self, line: usize, message: &str) {
        self.warnings.push(Warning::odd(&self.file, Some(line), None, message));
    }

    fn error_at(&self, line: Option<usize>, problem: Problem) -> SceneError {
        SceneError { file: self.file.clone(), line, element: None, problem: Box::new(problem) }
    }

    fn xml_error(&self, error: &roxmltree::Error) -> SceneError {
        // The message is quoted on one line whatever characters the file puts into it.
        let message: String = error.to_string().chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        let line = match error.pos() {
            // roxmltree gives 1:1 to errors without a place; a missing end is at the end.
            _ if matches!(error, roxmltree::Error::UnclosedRootNode) => self.line_starts.len(),
            position => position.row as usize,
        };
        self.error_at(Some(line), Problem::Xml(message))
    }
}

/// The end of the name of the outermost element. Before it there are only comments and processing instructions.
fn end_of_root_name(text: &str) -> Option<usize> {
    let mut start = text.find('<')?;
    while let Some(end) = match &text[start + 1..] {
        rest if rest.starts_with("!--") => Some("-->"),
        rest if rest.starts_with('?') => Some("?>"),
        _ => None,
    } {
        start += text[start..].find(end)?;
        start += text[start..].find('<')?;
    }
    Some(start + text[start..].find([' ', '\t', '\r', '\n', '/', '>'])?)
}

/// Replaces an XML declaration that is not at the very start, where XML forbids it, by spaces.
fn blank_late_declaration(text: &mut String) {
    let start = text.len() - text.trim_start().len();
    if start == 0 || !text[start..].starts_with("<?xml ") {
        return;
    }
    if let Some(length) = text[start..].find("?>").map(|end| end + 2) {
        let blank: String = text[start..start + length].chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
        text.replace_range(start..start + length, &blank);
    }
}
