//! Defaults of MJCF: classes of attributes, each with the attributes of the class around it.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::tree::Element;
use std::collections::HashMap;

/// The class of what names none.
const MAIN: &str = "main";

/// Attributes that express one setting in different ways: one of an element replaces all of its class.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// The attributes of each kind of element, class by class.
#[derive(Default)]
pub(crate) struct Defaults {
    classes: HashMap<String, HashMap<String, Vec<(String, String)>>>,
}

impl Defaults {
    /// Those of a file.
    pub fn of(root: &Element) -> Self {
        let mut defaults = Defaults::default();
        defaults.classes.insert(MAIN.to_string(), HashMap::new());
        for outermost in root.all("default") {
            defaults.add(outermost, MAIN);
        }
        defaults
    }

    /// Refuses a class that the file does not define, in an element or in one within it.
    pub fn check(&self, element: &Element) -> Result<(), SceneError> {
        for attribute in ["class", "childclass"] {
            if let Some(class) = element.text(attribute).filter(|class| !self.classes.contains_key(*class)) {
                return Err(element.error(attribute, format!("there is no class {class:?} among the defaults")));
            }
        }
        element.children.iter().try_for_each(|child| self.check(child))
    }

    fn add(&mut self, element: &Element, around: &str) {
        let class = element.text("class").unwrap_or(MAIN).to_string();
        let mut kinds = self.classes.get(&class).or_else(|| self.classes.get(around)).cloned().unwrap_or_default();
        for child in element.children.iter().filter(|child| child.name != "default") {
            let known = kinds.entry(child.name.clone()).or_default();
            *known = merged(known, &child.attributes);
        }
        self.classes.insert(class.clone(), kinds);
        for nested in element.all("default") {
            self.add(nested, &class);
        }
    }

    /// An element with the attributes of its class, or else of the class `inherited` from the bodies around it, that it does not give.
    pub fn applied(&self, element: &Element, inherited: Option<&str>) -> Element {
        let class = element.text("class").or(inherited).unwrap_or(MAIN);
        let kinds = self.classes.get(class).or_else(|| self.classes.get(MAIN));
        let of_class = kinds.and_then(|kinds| kinds.get(&element.name));
        let attributes = of_class.map_or_else(|| element.attributes.clone(), |own| merged(own, &element.attributes));
        Element { attributes, ..element.clone() }
    }
}

/// Attributes, with those of `own` before those of a class.
fn merged(of_class: &[(String, String)], own: &[(String, String)]) -> Vec<(String, String)> {
    let turns = |name: &str| ORIENTATIONS.contains(&name);
    let own_turn = own.iter().any(|(name, _)| turns(name));
    let is_replaced = |name: &str| own.iter().any(|(other, _)| other == name) || (own_turn && turns(name));
    let kept = of_class.iter().filter(|(name, _)| !is_replaced(name)).cloned();
    kept.chain(own.iter().cloned()).collect()
}
