//! A valid URDF, from the XML document: only elements of the schema, only valid numbers.
//!
//! If the intent is plain, the file is repaired and a warning says so. Otherwise the first error ends the reading. The result is also written out
//! again as XML for viewers.

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::numbers::{numbers, shown};
use crate::scene::text::XmlText;
use crate::scene::urdf_reading::element::{CleanAttribute, CleanElement};
use crate::scene::urdf_reading::schema::{Attribute, Content, Count, GEOMETRY, Presence, Schema};
use crate::scene::urdf_reading::surface_friction::beside_friction;
use crate::scene::urdf_reading::transmissions::says_rotor;
use crate::scene::warning::Warning;
use roxmltree::Node;
use std::path::Path;

/// Elements and attributes that are not read, each kind once, in order of appearance.
pub(crate) struct Ignored {
    /// For instance `<gazebo>` or `drake_ignore="..." of <link>`.
    pub what: String,
    pub line: usize,
    pub count: usize,
}

/// The result of cleaning.
pub(crate) struct Cleaned {
    pub robot: CleanElement,
    pub warnings: Vec<Warning>,
    pub ignored: Vec<Ignored>,
}

/// Reads the document by the schema.
pub(crate) fn clean(xml: &XmlText, schema: &'static Schema) -> Result<Cleaned, SceneError> {
    let document = xml.document()?;
    let root = document.root_element();
    let mut cleaner = Cleaner {
        xml,
        namespace: root.tag_name().namespace().map(str::to_string),
        owner: None,
        warnings: Vec::new(),
        ignored: Vec::new(),
    };
    if root.tag_name().name() != schema.name {
        let problem = match root.tag_name().name() {
            "sdf" => Problem::Sdf,
            "mujoco" => Problem::ModelOfMujoco,
            other => Problem::NotRobot(shown(other)),
        };
        return Err(cleaner.error(root, problem));
    }
    cleaner.refuse_xacro(root)?;
    let robot = cleaner.element(root, schema)?;
    Ok(Cleaned { robot, warnings: cleaner.warnings, ignored: cleaner.ignored })
}

struct Cleaner<'x> {
    xml: &'x XmlText,
    /// Namespace of `<robot>` itself, which is also the namespace of its elements.
    namespace: Option<String>,
    /// The link or joint being read.
    owner: Option<Element>,
    warnings: Vec<Warning>,
    ignored: Vec<Ignored>,
}

impl Cleaner<'_> {
    /// Elements of xacro directly under the root mean that the file is a source, not a URDF.
    fn refuse_xacro(&self, root: Node) -> Result<(), SceneError> {
        let is_xacro = |node: &Node| {
            node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"))
                && Some(node.tag_name().namespace()) != Some(self.namespace.as_deref())
        };
        match root.children().find(|node| node.is_element() && is_xacro(node)) {
            Some(node) => Err(self.error(node, Problem::Xacro(format!("<xacro:{}>", node.tag_name().name())))),
            None => Ok(()),
        }
    }

    /// One element with all that the schema knows of it.
    fn element(&mut self, node: Node, schema: &'static Schema) -> Result<CleanElement, SceneError> {
        let is_owner = matches!(schema.name, "link" | "joint" | "loop_joint");
        if is_owner {
            self.owner = owner_of(node, schema.name);
        }
        let mut element = CleanElement {
            name: schema.name,
            line: self.xml.line(node),
            attributes: self.attributes(node, schema)?,
            children: Vec::new(),
        };
        for child in node.children().filter(Node::is_element) {
            let known = schema.children.iter().find(|known| known.schema.name == child.tag_name().name());
            match known.filter(|_| child.tag_name().namespace() == self.namespace.as_deref()) {
                Some(known) => self.child(child, known.schema, known.count, &mut element)?,
                None if says_rotor(child) => {}
                None => match beside_friction(child) {
                    Some(beside) => beside.into_iter().for_each(|(node, what, of)| self.ignore(node, what, &of)),
                    None => self.ignore(child, format!("<{}>", qualified(child)), schema.name),
                },
            }
        }
        for known in schema.children.iter().filter(|known| known.count == Count::One) {
            if element.child(known.schema.name).is_none() {
                let (parent, missing) = (schema.name.to_string(), known.schema.name.to_string());
                return Err(self.error(node, Problem::MissingElement { parent, element: missing }));
            }
        }
        if is_owner {
            self.owner = None;
        }
        Ok(element)
    }

    /// Reads a child element into its parent, unless it is a shape or material that cannot be shown.
    fn child(
        &mut self,
        node: Node,
        schema: &'static Schema,
        count: Count,
        parent: &mut CleanElement,
    ) -> Result<(), SceneError> {
        if matches!(schema.name, "visual" | "collision")
            && let Some(reason) = unusable_geometry(node)
        {
            self.warn(node, format!("its <{}> was left out: {reason}", schema.name));
            return Ok(());
        }
        let child = match self.element(node, schema) {
            // A colour is not worth refusing a robot for.
            Err(error) if schema.name == "material" => {
                self.warn(node, format!("its <material> was left out: {}", error.problem));
                return Ok(());
            }
            child => child?,
        };
        let first = if count == Count::Any { None } else { parent.child(schema.name) };
        match first {
            Some(first) if first.same_as(&child) || schema.name == "material" => {
                let message =
                    format!("<{}> is given twice (first on line {}); the first is used", child.name, first.line);
                self.warn(node, message);
            }
            Some(first) => {
                let (parent, element) = (parent.name.to_string(), child.name.to_string());
                let problem = Problem::RepeatedElement { parent, element, first_line: first.line };
                return Err(self.error(node, problem));
            }
            None => parent.children.push(child),
        }
        Ok(())
    }

    /// The attributes of an element that the schema knows.
    fn attributes(&mut self, node: Node, schema: &'static Schema) -> Result<Vec<CleanAttribute>, SceneError> {
        let mut clean = Vec::new();
        for attribute in schema.attributes {
            // An empty name is no name.
            let value = node
                .attribute(attribute.name)
                .filter(|value| !(value.trim().is_empty() && attribute.content == Content::Text));
            match (value, attribute.presence) {
                (Some(value), _) => {
                    let text = self.content(node, schema, attribute, value)?;
                    clean.push(CleanAttribute { name: attribute.name, text, given: true });
                }
                (None, Presence::Optional) => {}
                (None, Presence::Default(default)) => {
                    clean.push(CleanAttribute { name: attribute.name, text: default.to_string(), given: false });
                }
                (None, Presence::Required) => {
                    let (element, attribute) = (schema.name.to_string(), attribute.name.to_string());
                    return Err(self.error(node, Problem::MissingAttribute { element, attribute }));
                }
                (None, Presence::Assumed(assumed)) => {
                    let consequence =
                        if attribute.content == Content::Limit { "no limit is assumed" } else { "0 is assumed" };
                    self.warn(node, format!("<{}> has no {}; {consequence}", schema.name, attribute.name));
                    clean.push(CleanAttribute { name: attribute.name, text: assumed.to_string(), given: false });
                }
            }
        }
        for given in node.attributes() {
            let known = given.namespace().is_none() && schema.attributes.iter().any(|a| a.name == given.name());
            if !known {
                self.ignore(node, format!("{}=\"...\"", shown(given.name())), schema.name);
            }
        }
        Ok(clean)
    }

    /// The value of an attribute, with its numbers checked and separated by spaces.
    fn content(
        &mut self,
        node: Node,
        schema: &Schema,
        attribute: &Attribute,
        value: &str,
    ) -> Result<String, SceneError> {
        let count = match attribute.content {
            Content::Text => return Ok(value.replace(['\n', '\r', '\t'], " ")),
            Content::Numbers(count) => count,
            Content::Limit => 1,
        };
        let infinite_allowed = attribute.content == Content::Limit;
        match numbers(value, count, infinite_allowed) {
            Ok((numbers, commas)) => {
                if commas {
                    let (element, name, text) = (schema.name, attribute.name, shown(value));
                    let message = format!("<{element} {name}=\"{text}\">: the commas were read as spaces");
                    self.warn(node, message);
                }
                Ok(numbers.join(" "))
            }
            Err(reason) => Err(self.error(
                node,
                Problem::Number {
                    element: schema.name.to_string(),
                    attribute: attribute.name.to_string(),
                    text: shown(value),
                    reason,
                },
            )),
        }
    }

    fn ignore(&mut self, node: Node, what: String, parent: &str) {
        let what = if parent == "robot" { what } else { format!("{what} of <{parent}>") };
        let line = self.xml.line(node);
        match self.ignored.iter_mut().find(|ignored| ignored.what == what) {
            Some(ignored) => ignored.count += 1,
            None => self.ignored.push(Ignored { what, line, count: 1 }),
        }
    }

    fn warn(&mut self, node: Node, message: String) {
        let line = Some(self.xml.line(node));
        self.warnings.push(Warning::odd(&self.xml.file, line, self.owner.clone(), message));
    }

    fn error(&self, node: Node, problem: Problem) -> SceneError {
        let (file, line) = (self.xml.file.clone(), Some(self.xml.line(node)));
        SceneError { file, line, element: self.owner.clone(), problem: Box::new(problem) }
    }
}

/// The link, joint or loop that a node is, if it has a name.
fn owner_of(node: Node, kind: &str) -> Option<Element> {
    let name = node.attribute("name")?.to_string();
    Some(match kind {
        "link" => Element::Link(name),
        "joint" => Element::Joint(name),
        _ => Element::Loop(name),
    })
}

/// The name of an element with the prefix it was written with.
fn qualified(node: Node) -> String {
    let name = shown(node.tag_name().name());
    match node.tag_name().namespace().and_then(|uri| node.lookup_prefix(uri)) {
        Some(prefix) => format!("{prefix}:{name}"),
        None => name,
    }
}

/// Why a visual or collision cannot be used although the rest of the robot can.
fn unusable_geometry(shape: Node) -> Option<String> {
    let elements = |node: Node| node.children().filter(|child| child.is_element()).count();
    let geometry = shape.children().find(|child| child.tag_name().name() == GEOMETRY.name);
    let Some(geometry) = geometry.filter(|geometry| elements(*geometry) > 0) else {
        return Some("it has no geometry".to_string());
    };
    let known = |node: &Node| {
        let ours = node.tag_name().namespace() == geometry.tag_name().namespace();
        ours && GEOMETRY.children.iter().any(|known| known.schema.name == node.tag_name().name())
    };
    let mut forms = geometry.children().filter(Node::is_element).filter(known);
    let Some(form) = forms.next() else {
        let name = geometry.first_element_child().map_or(String::new(), qualified);
        return Some(format!("<{name}> is no geometry of URDF"));
    };
    if let Some(other) = forms.find(|other| other.tag_name() != form.tag_name()) {
        let [one, two] = [form, other].map(|form| form.tag_name().name());
        return Some(format!("its geometry is a <{one}> and a <{two}>, and must be one of them"));
    }
    let no_file = form.attribute("filename").is_none_or(|name| name.trim().is_empty());
    (form.tag_name().name() == "mesh" && no_file).then(|| "its mesh has no filename".to_string())
}

/// The error about this file, line and link or joint.
pub(crate) fn error_at(file: &Path, line: usize, element: Option<Element>, problem: Problem) -> SceneError {
    SceneError { file: file.to_path_buf(), line: Some(line), element, problem: Box::new(problem) }
}
