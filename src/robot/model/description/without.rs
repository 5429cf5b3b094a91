//! The parts of the files that a user excludes from the simulation (`--without`).

use crate::model::description::robot_model::Model;
use crate::scene::Touching;
use std::str::FromStr;

/// Something that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// Limits of joints, which then do not stop joints. Closed loops are still assembled within them.
    Limits,
    /// Dry friction of joints.
    Friction,
    /// Viscous damping of joints; damping of springs stays.
    Damping,
    /// Motors.
    Motors,
    /// Contacts of collision shapes.
    Contact,
}

/// There is no such thing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} cannot be left out; choose from {list}", list = Left::ALL.map(Left::name).join(", "))]
pub struct UnknownLeft(pub String);

impl Left {
    /// All of them.
    pub const ALL: [Left; 5] = [Left::Limits, Left::Friction, Left::Damping, Left::Motors, Left::Contact];

    /// The name, for the command line.
    pub fn name(self) -> &'static str {
        match self {
            Left::Limits => "limits",
            Left::Friction => "friction",
            Left::Damping => "damping",
            Left::Motors => "motors",
            Left::Contact => "contact",
        }
    }
}

impl FromStr for Left {
    type Err = UnknownLeft;

    fn from_str(name: &str) -> Result<Self, UnknownLeft> {
        Left::ALL.into_iter().find(|left| left.name() == name).ok_or_else(|| UnknownLeft(name.to_string()))
    }
}

impl Model {
    /// Leaves something out of the simulation.
    pub fn without(&mut self, what: &[Left]) {
        for left in what {
            let mechanism = &mut self.mechanism;
            match left {
                Left::Limits => {
                    mechanism.nonsmooth.limits.clear();
                    self.forget_reach();
                }
                Left::Friction => mechanism.nonsmooth.friction.clear(),
                Left::Motors => {
                    mechanism.nonsmooth.motors.clear();
                    mechanism.forces.gravity_compensations.clear();
                    self.at_start.clear();
                }
                Left::Damping => {
                    let dampers = &mut mechanism.forces.joint_dampers;
                    dampers.drain(self.damping.start.min(dampers.len())..self.damping.end.min(dampers.len()));
                    self.damping.end = self.damping.start;
                }
                Left::Contact => {
                    mechanism.nonsmooth.colliders.clear();
                    mechanism.nonsmooth.pairs.clear();
                    mechanism.nonsmooth.reevings.clear();
                    // The obstacles and their meshes stay: the log carries them, so that the run can be made again.
                    self.contact.settings.touching = Some(Touching::None);
                    self.contact.owners.clear();
                    self.contact.wheels.clear();
                    self.contact.left_out.clear();
                }
            }
        }
    }
}
