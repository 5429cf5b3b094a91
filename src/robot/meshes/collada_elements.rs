//! The elements of a Collada file, and their content.

use crate::meshes::error::MeshError;
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// The elements of a file by their identifiers.
pub(super) struct Elements<'d> {
    root: Node<'d, 'd>,
    by_id: HashMap<&'d str, Node<'d, 'd>>,
}

impl<'d> Elements<'d> {
    pub(super) fn new(document: &'d Document<'d>) -> Self {
        let mut by_id = HashMap::new();
        for node in document.descendants().filter(Node::is_element) {
            if let Some(id) = node.attribute("id") {
                // Some writers use a name twice; other readers take the first.
                by_id.entry(id).or_insert(node);
            }
        }
        Elements { root: document.root_element(), by_id }
    }

    /// The outermost element.
    pub(super) fn root(&self) -> Node<'d, 'd> {
        self.root
    }

    /// The element that an attribute (`#name`) stands for.
    pub(super) fn target(&self, node: Node, attribute: &str) -> Option<Node<'d, 'd>> {
        self.by_id.get(node.attribute(attribute)?.trim_start_matches('#')).copied()
    }

    /// The element of this name.
    pub(super) fn named(&self, id: &str) -> Option<Node<'d, 'd>> {
        self.by_id.get(id).copied()
    }
}

/// The first child of this name.
pub(super) fn child<'d>(node: Node<'d, 'd>, name: &str) -> Option<Node<'d, 'd>> {
    children(node, name).next()
}

/// The children of this name.
pub(super) fn children<'d, 'n>(node: Node<'d, 'd>, name: &'n str) -> impl Iterator<Item = Node<'d, 'd>> + use<'d, 'n> {
    node.children().filter(move |child| is_named(*child, name))
}

/// The numbers in an element.
///
/// # Errors
/// The error names the line of a word that is no number.
pub(super) fn numbers<T: std::str::FromStr>(node: Node) -> Result<Vec<T>, MeshError> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    words.map(|word| word.parse().map_err(|_| wrong(node, &format!("{word:?} is not a number")))).collect()
}

/// The error of a malformed element.
pub(super) fn wrong(node: Node, what: &str) -> MeshError {
    let line = node.document().text_pos_at(node.range().start).row as usize;
    MeshError::Line { line, what: format!("<{}>: {what}", node.tag_name().name()) }
}

/// Whether an element has this name; namespaces, which some files lack, do not matter.
pub(super) fn is_named(node: Node, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}
