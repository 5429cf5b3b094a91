//! Quantities that a sweep can keep of a run: numbers of joints, links and energies by name.
//!
//! | name                                                    | numbers                                                                |
//! |---------------------------------------------------------|------------------------------------------------------------------------|
//! | `positions`, `velocities`                               | of all joints that move                                                |
//! | `joint.NAME.position`, `joint.NAME.velocity`            | as reports have them [rad, m, and quaternions]                         |
//! | `link.NAME.position`, `.orientation`, `.center_of_mass` | of the link frame in the world (m; w, x, y, z)                         |
//! | `link.NAME.velocity`, `.angular_velocity`               | of the centre of mass [m/s, rad/s]                                     |
//! | `energy`                                                | `energy.kinetic`, `.potential`, `.spring`, `.load`, `.total` (J)       |
//!
//! The first word of joints and links may be left out.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::joint::wxyz_from_rotation;
use crate::mechanism::motion::energy::{Energy, energy_with_forces};
use crate::mechanism::motion::event::EventKind;
use crate::model::Model;
use crate::scene::{Problem, SceneError, TomlText, UrdfJointKind, quoted};
use crate::sweep::rows::{Heading, Kind};
use crate::sweep::schema::{EventsKey, KeepTable};
use toml::Spanned;

/// One number of a run at an instant.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quantity {
    pub name: String,
    what: What,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum What {
    Position { joint: usize, number: usize },
    Velocity { joint: usize, number: usize },
    Link { link: usize, of: OfLink, number: usize },
    Energy(usize),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum OfLink {
    Position,
    Orientation,
    CenterOfMass,
    Velocity,
    AngularVelocity,
}

/// The kept quantities of every run.
#[derive(Debug)]
pub(crate) struct Kept {
    pub(super) end: Vec<Quantity>,
    pub(super) extremes: Vec<Quantity>,
    pub(super) curves: Vec<Quantity>,
    pub(super) events: EventsKey,
    /// Samples per simulated second of curves and extremes.
    rate: f64,
}

/// A state of a model, for as many quantities as there are.
pub(super) struct Instant<'i> {
    pub model: &'i Model,
    pub position: &'i [f64],
    pub velocity: &'i [f64],
    pub bodies: &'i [BodyState],
}

const LINK_NUMBERS: [(&str, OfLink, &[&str]); 5] = [
    ("position", OfLink::Position, &["x", "y", "z"]),
    ("orientation", OfLink::Orientation, &["w", "x", "y", "z"]),
    ("center_of_mass", OfLink::CenterOfMass, &["x", "y", "z"]),
    ("velocity", OfLink::Velocity, &["x", "y", "z"]),
    ("angular_velocity", OfLink::AngularVelocity, &["x", "y", "z"]),
];

const ENERGIES: [&str; 5] = ["kinetic", "potential", "spring", "load", "total"];

impl Instant<'_> {
    /// A quantity; `None` of a joint that does not move in this model.
    pub fn value(&self, quantity: &Quantity) -> Option<f64> {
        let of_joint = |joint| self.model.joint_coordinates(joint, self.position, self.velocity);
        match quantity.what {
            What::Position { joint, number } => of_joint(joint).position().get(number).copied(),
            What::Velocity { joint, number } => of_joint(joint).velocity().get(number).copied(),
            What::Link { link, of, number } => {
                let state = self.model.link_state(self.bodies, link);
                match of {
                    OfLink::Position => state.position.get(number).copied(),
                    OfLink::Orientation => wxyz_from_rotation(&state.rotation).get(number).copied(),
                    OfLink::CenterOfMass => state.center_of_mass.get(number).copied(),
                    OfLink::Velocity => state.linear_velocity.get(number).copied(),
                    OfLink::AngularVelocity => state.angular_velocity.get(number).copied(),
                }
            }
            What::Energy(which) => {
                let energy: Energy = energy_with_forces(&self.model.mechanism, self.position, self.bodies);
                [energy.kinetic, energy.potential, energy.spring, energy.load, energy.total()].get(which).copied()
            }
        }
    }
}

impl Kept {
    /// The quantities that a table keeps of the runs of a model, sampled at its rate or else at `rate`.
    pub(super) fn new(model: &Model, table: &KeepTable, rate: f64, text: &TomlText) -> Result<Self, SceneError> {
        let groups = groups(model);
        let named = |key: &str, names: &[Spanned<String>]| -> Result<Vec<Quantity>, SceneError> {
            let mut all: Vec<Quantity> = Vec::new();
            for name in names {
                let found = find(&groups, name.get_ref()).map_err(|message| {
                    let problem = Problem::Toml { key: Some(key.to_string()), message };
                    text.error(&name.span(), None, problem)
                })?;
                for quantity in found {
                    if !all.contains(quantity) {
                        all.push(quantity.clone());
                    }
                }
            }
            Ok(all)
        };
        let end = match &table.end {
            Some(names) => named("keep.end", names)?,
            None => ["positions", "velocities"]
                .iter()
                .flat_map(|name| find(&groups, name).unwrap_or_default().to_vec())
                .collect(),
        };
        let (extremes, curves) = (named("keep.extremes", &table.extremes)?, named("keep.curves", &table.curves)?);
        let rate = match &table.rate {
            Some(given) if !(given.get_ref().is_finite() && *given.get_ref() > 0.0 && *given.get_ref() <= 1e6) => {
                let message = format!("{} must be greater than zero and at most 1e6", given.get_ref());
                return Err(text.error(
                    &given.span(),
                    None,
                    Problem::Toml { key: Some("keep.rate".to_string()), message },
                ));
            }
            Some(given) => *given.get_ref(),
            None => rate,
        };
        Ok(Kept { end, extremes, curves, events: table.events, rate })
    }

    /// Samples per simulated second, if there is anything to be sampled.
    pub(super) fn rate(&self) -> Option<f64> {
        (!self.curves.is_empty() || !self.extremes.is_empty()).then_some(self.rate)
    }

    /// How many samples a run of this duration (s) has.
    pub(super) fn samples(&self, duration: f64) -> f64 {
        self.rate().map_or(0.0, |rate| (rate * duration).floor() + 2.0)
    }

    /// About how many numbers a row has, beside the varied ones.
    pub(super) fn numbers(&self, varied: usize, duration: f64) -> u64 {
        let curves = if self.curves.is_empty() { 0.0 } else { (1 + self.curves.len()) as f64 * self.samples(duration) };
        (8 + varied + self.end.len() + 4 * self.extremes.len() + EventKind::ALL.len()) as u64 + curves as u64
    }

    /// The columns, in the order in which a row has them.
    pub(super) fn headings(&self) -> Vec<Heading> {
        let mut all: Vec<Heading> = Vec::new();
        let mut put = |name: String, kind| all.push(Heading::new(name, kind));
        self.end.iter().for_each(|quantity| put(format!("end.{}", quantity.name), Kind::Number));
        for quantity in &self.extremes {
            for what in ["min", "min_time", "max", "max_time"] {
                put(format!("{what}.{}", quantity.name), Kind::Number);
            }
        }
        if self.events != EventsKey::None {
            EventKind::ALL.iter().for_each(|kind| put(format!("events.{}", kind.name()), Kind::Count));
        }
        if self.events == EventsKey::List {
            put("event.time".to_string(), Kind::Numbers);
            put("event.kind".to_string(), Kind::Texts);
            put("event.what".to_string(), Kind::Texts);
            put("event.impulse".to_string(), Kind::Numbers);
        }
        if !self.curves.is_empty() {
            put("curve.time".to_string(), Kind::Numbers);
        }
        self.curves.iter().for_each(|quantity| put(format!("curve.{}", quantity.name), Kind::Numbers));
        all
    }
}

/// The quantities of a name.
struct Group {
    name: String,
    short: String,
    quantities: Vec<Quantity>,
}

fn group(head: &str, rest: &str, numbers: &[&str], what: impl Fn(usize) -> What) -> Group {
    let name = format!("{head}.{rest}");
    let quantity = |(number, of): (usize, &&str)| {
        let name = if of.is_empty() { name.clone() } else { format!("{name}.{of}") };
        Quantity { name, what: what(number) }
    };
    let quantities = numbers.iter().enumerate().map(quantity).collect();
    Group { name, short: rest.to_string(), quantities }
}

/// All names of a model.
fn groups(model: &Model) -> Vec<Group> {
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for (joint, record) in model.joints.iter().enumerate().filter(|(_, record)| record.body.is_some()) {
        let (of_position, of_velocity): (&[&str], &[&str]) = match record.kind {
            UrdfJointKind::Planar => (&["x", "y", "angle"], &["vx", "vy", "rate"]),
            UrdfJointKind::Spherical => (&["w", "x", "y", "z"], &["wx", "wy", "wz"]),
            UrdfJointKind::Floating => {
                (&["x", "y", "z", "qw", "qx", "qy", "qz"], &["vx", "vy", "vz", "wx", "wy", "wz"])
            }
            _ => (&[""], &[""]),
        };
        let name = &record.name;
        positions
            .push(group("joint", &format!("{name}.position"), of_position, |number| What::Position { joint, number }));
        velocities
            .push(group("joint", &format!("{name}.velocity"), of_velocity, |number| What::Velocity { joint, number }));
    }
    let together = |name: &str, parts: &[Group]| Group {
        name: name.to_string(),
        short: name.to_string(),
        quantities: parts.iter().flat_map(|part| part.quantities.iter().cloned()).collect(),
    };
    let energies: Vec<Group> = ENERGIES
        .iter()
        .enumerate()
        .map(|(index, name)| group("energy", name, &[""], |_| What::Energy(index)))
        .collect();
    let mut all =
        vec![together("positions", &positions), together("velocities", &velocities), together("energy", &energies)];
    all.extend(positions.into_iter().chain(velocities).chain(energies));
    for (link, record) in model.links.iter().enumerate() {
        for (what, of, numbers) in LINK_NUMBERS {
            all.push(group("link", &format!("{}.{what}", record.name), numbers, |number| What::Link {
                link,
                of,
                number,
            }));
        }
    }
    all
}

/// The quantities of a name, or of one number of it; or the defect of the name.
fn find<'g>(groups: &'g [Group], name: &str) -> Result<&'g [Quantity], String> {
    if let Some(found) = groups.iter().find(|group| group.name == name) {
        return Ok(&found.quantities);
    }
    let single = groups.iter().flat_map(|group| &group.quantities).find(|quantity| quantity.name == name);
    if let Some(single) = single {
        return Ok(std::slice::from_ref(single));
    }
    let short: Vec<&Group> = groups.iter().filter(|group| group.short == name).collect();
    match short[..] {
        [one] => Ok(&one.quantities),
        [] => {
            let likeness = |group: &Group| {
                let like = |own: &str| strsim::normalized_damerau_levenshtein(own, name);
                like(&group.name).max(like(&group.short))
            };
            let mut like: Vec<(f64, &Group)> = groups.iter().map(|group| (likeness(group), group)).collect();
            like.sort_by(|(one, _), (other, _)| other.total_cmp(one));
            let near: Vec<&str> = like.iter().take(3).map(|(_, group)| group.name.as_str()).collect();
            Err(format!("there is no {name:?} to keep; the nearest are {}", quoted(&near)))
        }
        ref several => {
            let names: Vec<&str> = several.iter().map(|group| group.name.as_str()).collect();
            Err(format!("{name:?} may mean {}; write it whole", quoted(&names)))
        }
    }
}
