//! The key paths of the numbers of loads, drag and relations of joints.

use crate::scene::description::Scene;
use crate::scene::loads::{Factor, LoadKind};
use crate::scene::parameters::Range;
use crate::scene::parameters::keys::Keys;
use crate::scene::parameters::place::{LoadNumber, Place};

/// The numbers of drag, in their order.
pub(crate) const DRAG: [&str; 4] = ["linear", "quadratic", "angular", "angular_quadratic"];

/// The name of a load or drag: the name of its part, or where that is not enough its number.
fn name<'n>(on: &str, number: usize, mut all: impl Iterator<Item = &'n String>) -> String {
    let alone = all.by_ref().filter(|other| *other == on).count() == 1;
    if alone { on.to_string() } else { (number + 1).to_string() }
}

impl Keys {
    /// Relations of joints.
    pub(crate) fn relations(&mut self, scene: &Scene) {
        for (coupling, one) in scene.couplings.iter().enumerate() {
            for (term, (joint, _)) in one.terms.iter().enumerate() {
                let joint = format!("{}{}", scene.robots[joint.robot].prefix, joint.joint);
                let key = format!("{}.joints.{joint}", one.name);
                self.put("coupling", &key, Range::Finite, Place::CouplingTerm { coupling, term });
            }
            self.put("coupling", &format!("{}.offset", one.name), Range::Finite, Place::CouplingOffset(coupling));
        }
    }

    /// Loads, then drag.
    pub(crate) fn loads(&mut self, scene: &Scene) {
        for (load, one) in scene.loads.iter().enumerate() {
            let name = name(&one.on, load, scene.loads.iter().map(|other| &other.on));
            let mut put = |what: &str, range, place| self.put("load", &format!("{name}.{what}"), range, place);
            if let LoadKind::Joint { .. } = one.kind {
                put("effort", Range::Finite, Place::LoadEffort(load));
            }
            let number = |what| Place::Load { load, what };
            if one.from.is_some() {
                put("from", Range::Finite, number(LoadNumber::From));
            }
            if one.until.is_some() {
                put("until", Range::Finite, number(LoadNumber::Until));
            }
            match &one.factor {
                Factor::None => {}
                Factor::Number(_) => put("factor", Range::Finite, number(LoadNumber::Factor)),
                Factor::Wave(_) => {
                    put("wave.mean", Range::Finite, number(LoadNumber::Mean));
                    put("wave.amplitude", Range::Finite, number(LoadNumber::Amplitude));
                    put("wave.frequency", Range::Finite, number(LoadNumber::Frequency));
                    put("wave.phase", Range::Finite, number(LoadNumber::Phase));
                }
                Factor::Formula(formula) => {
                    for (index, (parameter, _)) in formula.parameters().iter().enumerate() {
                        put(&format!("factor.{parameter}"), Range::Finite, Place::FactorParameter { load, index });
                    }
                }
                Factor::Table(table) => {
                    for entry in 0..table.points.len() {
                        let called = |what: &str| format!("factor.{}.{what}", entry + 1);
                        put(&called("time"), Range::Finite, Place::FactorTime { load, entry });
                        put(&called("value"), Range::Finite, Place::FactorValue { load, entry });
                    }
                }
            }
            if let LoadKind::Link { .. } = one.kind {
                self.vector("load", &format!("{name}.force"), Range::Finite, |axis| Place::LoadForce { load, axis });
                self.vector("load", &format!("{name}.torque"), Range::Finite, |axis| Place::LoadTorque { load, axis });
                let place = |axis| Place::LoadPosition { load, axis };
                self.vector("load", &format!("{name}.position"), Range::Finite, place);
            }
        }
        for (drag, one) in scene.drags.iter().enumerate() {
            let name = name(&one.on, drag, scene.drags.iter().map(|other| &other.on));
            for (number, what) in DRAG.iter().enumerate() {
                self.put("drag", &format!("{name}.{what}"), Range::NotNegative, Place::Drag { drag, number });
            }
            let place = |axis| Place::DragPosition { drag, axis };
            self.vector("drag", &format!("{name}.position"), Range::Finite, place);
        }
    }
}
