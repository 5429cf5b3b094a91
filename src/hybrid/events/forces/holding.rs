//! The efforts λ that hold joints at an instant, at the level of accelerations.
//!
//! Newton and Euler on the whole tree give the effort that each joint needs, with the accelerations `a` of the moving bodies (zero for held ones).
//! The part that its own forces do not supply is the holding effort:
//!
//! ```text
//!     λ_i = Σ_j m_j (z_j · (reaction of joint j for a) − τ_j)    z_j its axis, τ_j springs, loads and efforts
//! ```
//!
//! with the sum over the joint and all that follow it by ratios m_j; with closures or contacts by [`crate::events::forces::closed_forces`]. Source of
//! the tree: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 5.3.

use crate::events::forces::closed_forces::{ClosedForces, Closing, Load, are_unique, closed_forces};
use crate::events::forces::foreseen::Foreseen;
use crate::events::forces::returning::shares;
use crate::events::modes::mode::JointMode;
use crate::events::modes::present::Present;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::Of;
use crate::instant::holding::held::Held as Moving;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::joint::JointKind;
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::forces::total::{BodyWrench, body_wrenches, joint_efforts};
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations, body_states, place_bodies};
use crate::mechanism::motion::state::State;
use crate::reduced::{Reaction, reactions_under};
use nalgebra::DVector;
use std::sync::Arc;

/// Roundings of an effort, relative to the terms that cancel in it.
const ROUNDING: f64 = 2e-15;

/// The same of a contact, whose force is the solution of a system with others; and where some of these imply others, to a part of 1e-10.
const CONTACT_ROUNDING: f64 = 1e-13;
const SHARED_ROUNDING: f64 = 1e-9;
/// A contact that sticks on its cone slips where it lacks this part of the size of its force, or of its load where forces are not unique: more than
/// decisions leave ([`crate::events::effects::deciding`]).
const ON_CONE: f64 = 1e-11;
const ON_SHARED_CONE: f64 = 1e-7;
/// A contact is unloaded if it presses by less than this part of the force with which the bodies beside it would fall on each other. If bodies hang
/// side by side and touch, roundings of their places leave such forces.
const UNLOADED: f64 = 1e-15;

/// Rooms that are kept.
const KEPT_ROOMS: usize = 12;

/// Works out what holds the joints of one mode.
#[derive(Clone)]
pub(crate) struct Holding {
    /// Index among the elements, and degree of freedom, of each held joint.
    joints: Vec<(usize, usize)>,
    /// λ of every element joint; zero for those that are free.
    efforts: Vec<f64>,
    /// The size of what each of them is the difference of.
    sizes: Vec<f64>,
    /// λ of the closed contacts (N): normal and tangents; and the size of the terms that cancel in it, of all contacts that feel each other.
    contacts: Vec<[f64; 3]>,
    contact_sizes: Vec<f64>,
    /// Whether they stick on their cones.
    on_cone: Vec<bool>,
    /// Their moments: of rolling friction about both tangents, and of spinning friction [N m].
    moments: Vec<[f64; 3]>,
    /// The force with which each contact would press if the bodies beside it fell on each other (N).
    weights: Vec<f64>,
    /// λ' of the contacts without pressure that the closed ones keep at their places.
    returning: Vec<Returning>,
    /// m, and whether it belongs to the state and efforts of the forces.
    margin: f64,
    margin_known: bool,
    /// The state and the efforts that they were worked out for last.
    known: Option<(State, Vec<f64>)>,
    how: How,
    /// The forces of the contacts that the last step has shown.
    pub foreseen: Foreseen,
}

/// The pressure of a contact without pressure by the law of equal springs, and the bound of its roundings (N).
#[derive(Clone, Copy)]
struct Returning {
    pressure: f64,
    rounding: f64,
}

impl Returning {
    /// Of a contact that the closed ones leave free.
    const NEVER: Self = Returning { pressure: f64::NEG_INFINITY, rounding: 0.0 };
}

#[derive(Clone)]
enum How {
    /// A mode without held joints and closed contacts.
    Nothing,
    /// In a tree.
    Tree(Shared<Tree>),
    /// A mechanism with closures; whether λ is unique, and the load at the last instant.
    Closed { unique: bool, last: Option<Box<Load>> },
}

/// The workspace for a tree.
#[derive(Clone)]
struct Tree {
    /// The response of the reduced mechanism.
    response: Response,
    small: State,
    small_efforts: Vec<f64>,
    small_accelerations: Vec<f64>,
    accelerations: Vec<f64>,
    bodies: Vec<BodyState>,
    motion: Vec<BodyAcceleration>,
    applied: Vec<BodyWrench>,
    reactions: Vec<Reaction>,
    own: Vec<f64>,
    /// The sum of m (|a| + |g|) over the bodies (N), and of their moments about the first body (N m). The load of a freely falling body is the
    /// difference of these terms.
    inertial: (f64, f64),
}

/// The room for a tree of a reduced mechanism.
#[derive(Clone)]
pub(crate) struct Room {
    moving: Arc<Moving>,
    tree: Shared<Tree>,
}

/// The rooms of modes that are not in use. A mode that comes back finds its own.
#[derive(Clone, Default)]
pub(crate) struct Rooms(Vec<Room>);

impl Rooms {
    /// Keeps a room; the oldest makes place for it.
    fn keep(&mut self, room: Room) {
        if self.0.len() >= KEPT_ROOMS {
            self.0.remove(0);
        }
        self.0.push(room);
    }

    /// Takes the room of a reduced mechanism.
    pub fn take(&mut self, moving: &Arc<Moving>) -> Option<Room> {
        let own = self.0.iter().position(|room| Arc::ptr_eq(&room.moving, moving))?;
        Some(self.0.remove(own))
    }

    /// Gives up all rooms.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

impl Holding {
    /// The workspace for a mode in a state, and its reduced mechanism, with the room that it had before.
    pub fn new(at: &Present, response: &mut Response, state: &State, room: Option<Room>) -> Self {
        let Present { whole, elements, mode, moving, .. } = *at;
        let joints: Vec<(usize, usize)> = (elements.joints.iter().zip(&mode.joints).enumerate())
            .filter(|(_, (_, mode))| matches!(mode, JointMode::Held { .. }))
            .map(|(index, (joint, _))| (index, joint.coordinate.freedom))
            .collect();
        let how = if joints.is_empty() && mode.contacts.is_empty() {
            How::Nothing
        } else if !(whole.loops.is_empty() && mode.contacts.is_empty() && only_pairs(whole)) {
            How::Closed { unique: are_unique(at, response, state), last: None }
        } else if let Some(Room { tree, .. }) = room {
            How::Tree(tree)
        } else {
            // Motors act through the efforts that are handed over, not as forces of the reduced mechanism.
            let mut bare = moving.mechanism.clone();
            bare.forces.joint_springs.truncate(count_springs(whole, moving));
            bare.forces.joint_dampers.truncate(count_dampers(whole, moving));
            let count = whole.bodies.len();
            How::Tree(Shared::new(Tree {
                response: Response::new(&bare),
                small: State::zero(&bare),
                small_efforts: vec![0.0; bare.velocity_count],
                small_accelerations: vec![0.0; bare.velocity_count],
                accelerations: vec![0.0; whole.velocity_count],
                bodies: vec![WORLD; count],
                motion: vec![BodyAcceleration::default(); count],
                applied: vec![BodyWrench::default(); count],
                reactions: vec![Reaction::default(); count],
                own: vec![0.0; whole.velocity_count],
                inertial: (0.0, 0.0),
            }))
        };
        let nothing = vec![0.0; elements.joints.len()];
        let contacts = vec![[0.0; 3]; mode.contacts.len()];
        Holding {
            joints,
            efforts: nothing.clone(),
            sizes: nothing,
            contacts,
            contact_sizes: vec![0.0; mode.contacts.len()],
            on_cone: mode.contacts.iter().map(|closed| closed.on_cone).collect(),
            moments: vec![[0.0; 3]; mode.contacts.len()],
            weights: Vec::new(),
            returning: vec![Returning::NEVER; mode.unpressed.len()],
            margin: f64::INFINITY,
            margin_known: false,
            known: None,
            how,
            foreseen: Foreseen::default(),
        }
    }

    /// Gives the room for a tree back, at the end of a mode with this reduced mechanism.
    pub fn give_back(&mut self, moving: &Arc<Moving>, rooms: &mut Rooms) {
        if let How::Tree(tree) = std::mem::replace(&mut self.how, How::Nothing) {
            rooms.keep(Room { moving: moving.clone(), tree });
        }
    }

    /// Whether the efforts are unique.
    pub fn is_unique(&self) -> bool {
        !matches!(self.how, How::Closed { unique: false, .. })
    }

    /// λ of a joint [N m or N].
    pub fn of(&self, joint: usize) -> f64 {
        self.efforts[joint]
    }

    /// Bound of the roundings of a joint's effort [N m or N].
    pub fn rounding(&self, joint: usize) -> f64 {
        ROUNDING * self.sizes[joint].max(1.0)
    }

    /// λ of a closed contact (N): along its normal and its tangents.
    pub fn of_contact(&self, contact: usize) -> [f64; 3] {
        self.contacts[contact]
    }

    /// Moments of a closed contact: of rolling friction about both tangents, and of spinning friction [N m].
    pub fn moments_of(&self, contact: usize) -> [f64; 3] {
        self.moments[contact]
    }

    /// The pressure that a contact without pressure would have by the law of equal springs, beyond the roundings of pressures (N).
    pub fn of_unpressed(&self, unpressed: usize) -> f64 {
        self.returning[unpressed].pressure - self.returning[unpressed].rounding
    }

    /// Bound of the roundings of that pressure (N).
    pub fn rounding_of_unpressed(&self, unpressed: usize) -> f64 {
        self.returning[unpressed].rounding
    }

    /// Whether a contact carries only roundings of its weights.
    pub fn is_unloaded(&self, contact: usize) -> bool {
        let [pressure, ..] = self.contacts[contact];
        self.weights.get(contact).is_some_and(|weight| pressure.abs() <= UNLOADED * weight)
    }

    /// Bound of the roundings of the force of a closed contact (N).
    pub fn rounding_of_contact(&self, contact: usize) -> f64 {
        CONTACT_ROUNDING * self.contact_sizes[contact]
    }

    /// By how much the force of a contact that sticks may lie outside its cone (N): by roundings, or by more where it began on its cone.
    pub fn beyond_cone(&self, contact: usize) -> f64 {
        let part = match (self.on_cone[contact], self.is_unique()) {
            (false, _) => CONTACT_ROUNDING,
            (true, true) => ON_CONE,
            (true, false) => ON_SHARED_CONE,
        };
        part * self.contact_sizes[contact]
    }

    /// Bound of the roundings of its pressure (N).
    pub fn rounding_of_pressure(&self, contact: usize) -> f64 {
        let part = if self.is_unique() { CONTACT_ROUNDING } else { SHARED_ROUNDING };
        part * self.contact_sizes[contact]
    }

    /// m: not negative while some efforts can hold all, but for roundings; of the instant at which it was worked out last.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// The forces of the closed contacts in a state under these efforts, if they were worked out for them last.
    pub fn recall(&self, state: &State, efforts: &[f64]) -> Option<&[[f64; 3]]> {
        let same = |(known, before): &(State, Vec<f64>)| {
            let of_state = known.position == state.position && known.velocity == state.velocity;
            of_state && known.time == state.time && before == efforts
        };
        self.known.as_ref().is_some_and(same).then_some(&self.contacts)
    }

    /// Works them out for a state of the whole under efforts from outside, of friction and of motors: one entry a degree of freedom.
    pub fn evaluate(&mut self, at: &Present, response: &mut Response, state: &State, efforts: &[f64]) {
        if self.recall(state, efforts).is_some() {
            return;
        }
        let same = |known: &State| known.position == state.position && known.velocity == state.velocity;
        let stands = self.known.as_ref().is_some_and(|(known, _)| same(known));
        match &mut self.known {
            Some((known, before)) => {
                known.copy_from(state);
                before.copy_from_slice(efforts);
            }
            none => *none = Some((state.clone(), efforts.to_vec())),
        }
        self.margin_known = false;
        let Present { whole, elements, moving, mode, .. } = *at;
        let Holding { joints, efforts: found, sizes, how, .. } = self;
        match how {
            How::Nothing => {}
            How::Tree(tree) => {
                tree.evaluate(whole, moving, state, efforts);
                for &(joint, _) in joints.iter() {
                    // A follower adds its needed effort to its leader, by their ratio.
                    (found[joint], sizes[joint]) = (0.0, 0.0);
                    for member in &elements.joints[joint].members {
                        let at = member.coordinate;
                        let (needed, size) = tree.needed(whole, at.body);
                        found[joint] += member.factor * (needed - efforts[at.freedom]);
                        sizes[joint] += member.factor.abs() * (size + efforts[at.freedom].abs());
                    }
                }
            }
            How::Closed { unique, last } => {
                let held = match last.take().filter(|_| stands) {
                    Some(load) => {
                        let mut held = load.held;
                        held.drive(at, response, state, efforts);
                        held
                    }
                    None => Closing::at(at, response, state, efforts),
                };
                let forces = closed_forces(at, held, *unique);
                let ClosedForces { joints, contacts, moments, weights, sizes: of_contacts, load } = forces;
                for (joint, effort, size) in joints {
                    (found[joint], sizes[joint]) = (effort, size);
                }
                (self.contacts, self.weights, self.contact_sizes) = (contacts, weights, of_contacts);
                self.moments = moments;
                if !mode.unpressed.is_empty() {
                    let bodies = body_states(whole, state);
                    let closed = mode.contacts.iter().map(|closed| &closed.contact.joint);
                    let open = mode.unpressed.iter().map(|contact| &contact.joint);
                    let shares = shares(whole, response, state, &bodies, closed, open);
                    let pressed = |share: &DVector<f64>| {
                        let mut of = Returning { pressure: 0.0, rounding: 0.0 };
                        for (part, ([pressure, ..], size)) in
                            share.iter().zip(self.contacts.iter().zip(&self.contact_sizes))
                        {
                            if *part != 0.0 {
                                of.pressure += part * pressure;
                                of.rounding = of.rounding.max(SHARED_ROUNDING * size);
                            }
                        }
                        of
                    };
                    let each = shares.iter().map(|share| share.as_ref().map_or(Returning::NEVER, pressed));
                    self.returning.clear();
                    self.returning.extend(each);
                }
                *last = Some(Box::new(load));
            }
        }
    }

    /// Works out m where the efforts were worked out last, which may take as long; `alone`: of which contacts pressures are looked at alone, too.
    pub fn evaluate_margin(&mut self, alone: impl Fn(usize) -> bool) {
        if let How::Closed { last: Some(load), unique: false } = &self.how
            && !self.margin_known
        {
            let own = |contact: usize| if alone(contact) { self.rounding_of_pressure(contact) } else { 0.0 };
            self.margin = load.margin(own, |of, size| match of {
                Of::Contact(contact) => self.beyond_cone(contact),
                Of::Joint(_) | Of::Moment { .. } => CONTACT_ROUNDING * size,
            });
            self.margin_known = true;
        }
    }

    /// Takes the answer of the forces to efforts in the position for which they were worked out last, if they are unique.
    pub fn learn(&mut self, position: &[f64]) {
        if let How::Closed { unique: true, last: Some(load) } = &self.how {
            self.foreseen.learn(position, &load.held);
        }
    }

    /// Whether some admissible forces hold all in a state under these efforts, so far as that was worked out for them last.
    pub fn holds_all(&self, state: &State, efforts: &[f64]) -> bool {
        self.margin_known && self.margin > 0.0 && self.recall(state, efforts).is_some()
    }
}

/// Whether no joint follows several others.
fn only_pairs(whole: &Mechanism) -> bool {
    whole.mimics.iter().all(|mimic| mimic.more.is_empty())
}

/// The springs and dampers of the reduced mechanism that were forces of the whole; springs and dampers of motors come after them.
fn count_springs(whole: &Mechanism, moving: &Moving) -> usize {
    whole.forces.joint_springs.iter().filter(|spring| moving.coordinate(whole, spring.coordinate).is_some()).count()
}

fn count_dampers(whole: &Mechanism, moving: &Moving) -> usize {
    let moves = |freedom: usize| whole.body_of_freedom(freedom).is_some_and(|body| !moving.is_held[body]);
    whole.forces.joint_dampers.iter().filter(|damper| moves(damper.freedom)).count()
}

impl Tree {
    fn evaluate(&mut self, whole: &Mechanism, moving: &Moving, state: &State, efforts: &[f64]) {
        let Tree { response, small, small_efforts, small_accelerations, accelerations, .. } = self;
        if !moving.is_empty() {
            moving.gather_positions(whole, &state.position, &mut small.position);
            moving.gather_positions(whole, &state.compensation, &mut small.compensation);
            moving.gather_velocities(whole, &state.velocity, &mut small.velocity);
            small.time = state.time;
            moving.gather_velocities(whole, efforts, small_efforts);
            response.accelerations(small, small_efforts, small_accelerations);
        }
        moving.spread_velocities(whole, small_accelerations, accelerations);
        let Tree { bodies, motion, applied, reactions, own, .. } = self;
        place_bodies(whole, state, bodies);
        body_accelerations(whole, bodies, &state.velocity, &self.accelerations, motion);
        body_wrenches(whole, state.time, bodies, applied);
        reactions_under(whole, bodies, motion, applied, reactions);
        joint_efforts(whole, state.time, (&state.position, &state.velocity), bodies, own);
        self.inertial = (0.0, 0.0);
        let falls = |body: &Body| body.parent.is_none() && body.joint.kind == JointKind::Floating;
        if !whole.bodies.iter().any(falls) {
            return;
        }
        for (body, (placed, (acceleration, turning))) in whole.bodies.iter().zip(bodies.iter().zip(&*motion)) {
            let force = body.mass * (acceleration.norm() + whole.gravity.norm());
            let arm = (placed.position - bodies[0].position).norm();
            self.inertial.0 += force;
            self.inertial.1 += force * arm + body.inertia.amax() * turning.norm();
        }
    }

    /// The effort that the joint of a body has to carry along its axis besides its own springs and loads, and the size of its whole load.
    fn needed(&self, whole: &Mechanism, body: usize) -> (f64, f64) {
        let joint = &whole.bodies[body].joint;
        let axis = self.bodies[body].rotation * joint.on_child.rotation.matrix().column(2);
        let Reaction { force, torque, .. } = &self.reactions[body];
        let carried = if joint.kind == JointKind::Prismatic { axis.dot(force) } else { axis.dot(torque) };
        let (forces, moments) = self.inertial;
        let size = if joint.kind == JointKind::Prismatic {
            force.norm() + forces
        } else {
            torque.norm() + moments + forces * (self.reactions[body].anchor - self.bodies[0].position).norm()
        };
        (carried - self.own[joint.velocity_index], size + self.own[joint.velocity_index].abs())
    }
}
