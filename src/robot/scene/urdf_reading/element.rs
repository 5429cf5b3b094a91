//! A URDF element after repair: what the schema knows of it, and the XML it is written as for viewers.

/// An element, and the line on which it starts.
pub(crate) struct CleanElement {
    pub name: &'static str,
    pub line: usize,
    pub attributes: Vec<CleanAttribute>,
    pub children: Vec<CleanElement>,
}

/// One of its attributes.
pub(crate) struct CleanAttribute {
    pub name: &'static str,
    pub text: String,
    /// Whether the file has it; otherwise it was assumed.
    pub given: bool,
}

impl CleanElement {
    /// The text of an attribute, given or assumed.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|attribute| attribute.name == name).map(|attribute| attribute.text.as_str())
    }

    /// Whether the file itself has this attribute.
    pub fn gives(&self, name: &str) -> bool {
        self.attributes.iter().any(|attribute| attribute.name == name && attribute.given)
    }

    /// The numbers of an attribute; the schema has checked them.
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        self.attribute(name)?.split_whitespace().map(|word| word.parse().ok()).collect()
    }

    /// The number of an attribute.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.attribute(name)?.parse().ok()
    }

    /// The three numbers of an attribute.
    pub fn vector(&self, name: &str) -> Option<[f64; 3]> {
        self.numbers(name)?.try_into().ok()
    }

    /// The text of an attribute that the schema requires.
    pub fn text(&self, name: &str) -> String {
        self.attribute(name).unwrap_or_default().to_string()
    }

    /// Replaces the text of an attribute.
    pub fn set(&mut self, name: &str, text: String) {
        if let Some(attribute) = self.attributes.iter_mut().find(|attribute| attribute.name == name) {
            attribute.text = text;
        }
    }

    /// The first child with this name.
    pub fn child(&self, name: &str) -> Option<&CleanElement> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The first child with this name, to be changed.
    pub fn child_mut(&mut self, name: &str) -> Option<&mut CleanElement> {
        self.children.iter_mut().find(|child| child.name == name)
    }

    /// All children with this name.
    pub fn children_named(&self, name: &str) -> impl Iterator<Item = &CleanElement> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Whether another element says the same.
    pub fn same_as(&self, other: &CleanElement) -> bool {
        let attributes = |element: &CleanElement| -> Vec<(&str, String)> {
            element.attributes.iter().map(|attribute| (attribute.name, attribute.text.clone())).collect()
        };
        self.name == other.name
            && attributes(self) == attributes(other)
            && self.children.len() == other.children.len()
            && self.children.iter().zip(&other.children).all(|(a, b)| a.same_as(b))
    }

    /// Writes the element as XML.
    pub fn write(&self, indent: usize, out: &mut String) {
        let margin = "  ".repeat(indent);
        *out += &format!("{margin}<{}", self.name);
        for attribute in &self.attributes {
            *out += &format!(" {}=\"{}\"", attribute.name, escaped(&attribute.text));
        }
        if self.children.is_empty() {
            *out += "/>\n";
            return;
        }
        *out += ">\n";
        for child in &self.children {
            child.write(indent + 1, out);
        }
        *out += &format!("{margin}</{}>\n", self.name);
    }
}

/// XML text for an attribute value.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\n' | '\r' | '\t' => out.push(' '),
            other => out.push(other),
        }
    }
    out
}
