//! Messages about friction and armature that are taken from a URDF: one for each kind, without the numbers that a scene file or `--set` replaces.

use crate::mechanism::ground::words::counted;
use crate::scene::error::Element;
use crate::scene::robot::Robot;
use crate::scene::taken::{Taken, TakenNumber};
use crate::scene::warning::{Warning, WarningGroup};

/// Most links or joints that a message names.
const NAMED: usize = 6;

impl Robot {
    /// Puts the messages about the numbers that were taken among the warnings.
    pub(crate) fn tell_taken(&mut self) {
        let kinds = [(TakenNumber::Friction, "friction", "link"), (TakenNumber::Armature, "armature", "joint")];
        for (number, what, kind) in kinds {
            let all: Vec<&Taken> = self.taken.iter().filter(|one| one.number == number).collect();
            let Some(first) = all.first() else { continue };
            let name = |of: &Element| match of {
                Element::Link(name) | Element::Joint(name) => name.clone(),
                other => other.to_string(),
            };
            let mut named: Vec<String> =
                all.iter().take(NAMED).map(|one| format!("{} for {:?}", one.value, name(&one.of))).collect();
            if all.len() > NAMED {
                named.push(format!("and so on for {} more", all.len() - NAMED));
            }
            let of = counted(all.len(), kind, &format!("{kind}s"));
            let message = format!("{what} of {of} is taken from the file: {}", named.join(", "));
            let owner = (number == TakenNumber::Armature && all.len() == 1).then(|| first.of.clone());
            let warning = Warning::odd(&self.path, Some(first.line), owner, message);
            self.warnings.push(warning.in_group(WarningGroup::Taken));
        }
    }

    /// Forgets that a number was taken, because another one replaces it.
    pub(crate) fn forget_taken(&mut self, number: TakenNumber, of: &Element) {
        let before = self.taken.len();
        self.taken.retain(|one| one.number != number || one.of != *of);
        let is_told = self.warnings.iter().any(|warning| warning.group == WarningGroup::Taken);
        if self.taken.len() < before && is_told {
            self.warnings.retain(|warning| warning.group != WarningGroup::Taken);
            self.tell_taken();
        }
    }
}
