//! Defaults of MJCF: classes of attributes, each with the attributes of the class around it.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::actuator_kinds::{ActuatorLaw, is_actuator};
use crate::scene::mjcf_reading::tree::Element;
use std::collections::HashMap;

/// The class of what names none.
const MAIN: &str = "main";

/// Attributes that express one setting in different ways: one of an element replaces all of its class.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// The set of attributes that all kinds of actuators share.
const ACTUATOR: &str = "actuator";

/// A class of defaults.
#[derive(Clone, Default)]
struct Class {
    /// The attributes of each kind of element.
    kinds: HashMap<String, Vec<(String, String)>>,
    law: ActuatorLaw,
    /// The class around it.
    around: Option<String>,
}

/// The attributes of each kind of element, class by class.
#[derive(Default)]
pub(crate) struct Defaults {
    classes: HashMap<String, Class>,
}

impl Defaults {
    /// Those of a file.
    pub fn of(root: &Element) -> Result<Self, SceneError> {
        let mut defaults = Defaults::default();
        defaults.classes.insert(MAIN.to_string(), Class::default());
        root.all("default").try_for_each(|outermost| defaults.add(outermost, MAIN))?;
        Ok(defaults)
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

    fn add(&mut self, element: &Element, around: &str) -> Result<(), SceneError> {
        let name = element.text("class").unwrap_or(MAIN).to_string();
        let inner = || {
            let outer = self.classes.get(around).cloned().unwrap_or_default();
            Class { around: Some(around.to_string()), ..outer }
        };
        let mut class = self.classes.get(&name).cloned().unwrap_or_else(inner);
        for child in element.children.iter().filter(|child| child.name != "default") {
            let mut kind = child.name.as_str();
            if is_actuator(kind) {
                class.law = self.law_for(kind, &class).with(child)?;
                kind = ACTUATOR;
            }
            let known = class.kinds.entry(kind.to_string()).or_default();
            *known = merged(known, &child.attributes);
        }
        self.classes.insert(name.clone(), class);
        element.all("default").try_for_each(|nested| self.add(nested, &name))
    }

    /// The settings that an actuator of a kind begins with.
    fn law_for(&self, kind: &str, class: &Class) -> ActuatorLaw {
        let mut at = Some(class);
        while let Some(one) = at {
            if one.law.serves(kind) {
                return one.law.clone();
            }
            at = one.around.as_ref().and_then(|around| self.classes.get(around));
        }
        ActuatorLaw::default()
    }

    /// An element with the attributes of its class, or else of the class `inherited` from the bodies around it, that it does not give.
    pub fn applied(&self, element: &Element, inherited: Option<&str>) -> Element {
        self.applied_as(&element.name, element, inherited)
    }

    /// An element with the attributes that its class has for elements of a kind.
    pub fn applied_as(&self, kind: &str, element: &Element, inherited: Option<&str>) -> Element {
        let of_class = self.class(element, inherited).and_then(|class| class.kinds.get(kind));
        let attributes = of_class.map_or_else(|| element.attributes.clone(), |own| merged(own, &element.attributes));
        Element { attributes, ..element.clone() }
    }

    /// An actuator with the attributes of its class that it does not give, and its settings.
    pub fn actuator(&self, element: &Element) -> Result<(Element, ActuatorLaw), SceneError> {
        let law =
            self.class(element, None).map_or_else(ActuatorLaw::default, |class| self.law_for(&element.name, class));
        Ok((self.applied_as(ACTUATOR, element, None), law.with(element)?))
    }

    fn class(&self, element: &Element, inherited: Option<&str>) -> Option<&Class> {
        let name = element.text("class").or(inherited).unwrap_or(MAIN);
        self.classes.get(name).or_else(|| self.classes.get(MAIN))
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
