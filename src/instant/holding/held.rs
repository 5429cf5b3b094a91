//! The mechanism of the remaining degrees of freedom while some joints are held.
//!
//! A joint that friction or a limit holds at `q = q*` is no joint: its body is part of its parent. `X` is the pose of a member in the frame of the
//! first body of its group, at `q*`,
//!
//! ```text
//!     m = Σ m_i,   c = Σ m_i c_i / m,   J = Σ X J_i Xᵀ + m_i (|d|² 1 − d dᵀ),  d = c_i − c        mass, centre, inertia
//!     F ↦ P⁻¹ X F                                                                               every frame F on a member
//! ```
//!
//! with the principal frame `P` of the group; bodies that are fixed to the world become part of it. A held rate is exactly zero, and held joints cost
//! no time. Closures whose ends are on one group are redundant and are left out; so are the forces between them.

use crate::mechanism::description::closure::{Attachment, Coordinate, JointLimit, LoopJoint, Mimic};
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::description::forces::Wrench;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::description::nonsmooth::Nonsmooth;
use crate::mechanism::motion::state::State;
use crate::model::Composite;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// Closed contacts as closures of the reduced mechanism.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Closures {
    pub touches: Vec<TouchJoint>,
    /// Points that stay where they are.
    pub anchors: Vec<LoopJoint>,
}

/// The reduced mechanism of the joints that are not held, and its place in the whole.
#[derive(Clone)]
pub(crate) struct Held {
    /// The reduced mechanism.
    pub mechanism: Mechanism,
    /// The body of the whole that heads each body.
    heads: Vec<usize>,
    /// For each body of the whole whether its joint is held, and the group that it is part of; `None` for the world.
    pub is_held: Vec<bool>,
    groups: Vec<Option<usize>>,
}

/// Place of a body of the whole: fixed in a group (or in the world), with its pose in the group's frame.
#[derive(Clone, Copy)]
struct Place {
    group: Option<usize>,
    pose: Pose,
}

impl Held {
    /// The rest of a mechanism in a state, with the joints of these bodies held where they are. It has no limits, friction, motors and contacts of
    /// its own, because these follow the mode.
    pub fn new(whole: &Mechanism, state: &State, is_held: Vec<bool>, closures: &Closures) -> Self {
        Held::build(whole, state, is_held, closures, false)
    }

    /// The same for joints that are held for ever: the rest keeps its limits, friction, motors and contacts.
    pub fn for_ever(whole: &Mechanism, state: &State, is_held: Vec<bool>) -> Self {
        Held::build(whole, state, is_held, &Closures::default(), true)
    }

    fn build(whole: &Mechanism, state: &State, is_held: Vec<bool>, closures: &Closures, for_ever: bool) -> Self {
        let places = heads_and_places(whole, state, &is_held);
        let (heads, places) = (places.0, places.1);
        let groups = heads.len();
        let mut parts: Vec<Vec<Composite>> = vec![Vec::new(); groups];
        for (body, place) in whole.bodies.iter().zip(&places) {
            if let Some(group) = place.group {
                let inertia = Matrix3::from_diagonal(&body.inertia);
                parts[group].push(Composite::part(body.mass, &inertia, &place.pose));
            }
        }
        let principal: Vec<(f64, Pose, Vector3<f64>)> = parts
            .iter()
            .zip(&heads)
            .map(|(parts, &head)| {
                // A group of one body keeps the numbers of that body to the last bit.
                if parts.len() == 1 {
                    return (whole.bodies[head].mass, Pose::identity(), whole.bodies[head].inertia);
                }
                let composite = Composite::of(parts);
                let (frame, moments) = composite.principal();
                (composite.mass, frame, moments.map(|moment| moment.max(0.0)))
            })
            .collect();
        let into = Into { places: &places, principal: &principal };
        let bodies: Vec<Body> = heads
            .iter()
            .map(|&head| {
                let body = &whole.bodies[head];
                let mut joint = body.joint.clone();
                let parent = body.parent.map(|parent| into.frame(parent, &joint.on_parent));
                if let Some((_, on_parent)) = parent {
                    joint.on_parent = on_parent;
                }
                joint.on_child = into.frame(head, &joint.on_child).1;
                let own = into.group(head).unwrap_or_default();
                Body {
                    name: body.name.clone(),
                    parent: parent.and_then(|(parent, _)| parent),
                    mass: principal[own].0,
                    inertia: principal[own].2,
                    joint,
                }
            })
            .collect();
        let mechanism = number(whole, bodies);
        let groups = places.iter().map(|place| place.group).collect();
        let mut held = Held { mechanism, heads, is_held, groups };
        held.take_over(whole, closures, &into, state);
        if for_ever {
            held.mechanism.forces.driven = whole.forces.driven;
            held.keep_nonsmooth(whole, &into);
        }
        held
    }

    /// Limits, friction, motors and contacts of the joints and bodies that move.
    fn keep_nonsmooth(&mut self, whole: &Mechanism, into: &Into) {
        let mut nonsmooth = whole.nonsmooth.clone();
        let mut limits = whole.limits.clone();
        let coordinate = |of: &mut Coordinate| self.coordinate(whole, *of).map(|own| *of = own).is_some();
        let keep = |limit: &mut JointLimit| coordinate(&mut limit.coordinate);
        limits.retain_mut(keep);
        nonsmooth.limits.retain_mut(keep);
        nonsmooth.friction.retain_mut(|friction| coordinate(&mut friction.coordinate));
        nonsmooth.motors.retain_mut(|motor| coordinate(&mut motor.coordinate));
        nonsmooth.speeds.retain_mut(|speed| coordinate(&mut speed.coordinate));
        for collider in &mut nonsmooth.colliders {
            if let Some(body) = collider.body {
                let surface = collider.pose.rotation.inverse() * collider.surface_velocity;
                (collider.body, collider.pose) = into.frame(body, &collider.pose);
                collider.surface_velocity = collider.pose.rotation * surface;
            }
        }
        let colliders = &nonsmooth.colliders;
        nonsmooth.pairs.retain_mut(|pair| colliders[pair.a].body != colliders[pair.b].body);
        (self.mechanism.limits, self.mechanism.nonsmooth) = (limits, nonsmooth);
    }

    /// Closures and forces of the reduced mechanism.
    fn take_over(&mut self, whole: &Mechanism, closures: &Closures, into: &Into, state: &State) {
        let coordinate = |of: Coordinate| self.coordinate(whole, of);
        let freedom = |freedom: usize| self.freedom(whole, freedom);
        let attachment = |end: &Attachment| match end.body {
            None => *end,
            Some(body) => {
                let (body, frame) = into.frame(body, &end.frame);
                Attachment { body, frame }
            }
        };
        let mut forces = whole.forces.clone();
        // Limits alone are no efforts, and cost no time between events.
        let Nonsmooth { friction, motors, .. } = &whole.nonsmooth;
        forces.driven |= !friction.is_empty() || !motors.is_empty();
        forces.joint_dampers.retain_mut(|damper| freedom(damper.freedom).map(|own| damper.freedom = own).is_some());
        forces
            .joint_springs
            .retain_mut(|spring| coordinate(spring.coordinate).map(|own| spring.coordinate = own).is_some());
        forces.joint_loads.retain_mut(|load| freedom(load.freedom).map(|own| load.freedom = own).is_some());
        forces.point_springs.retain_mut(|spring| {
            (spring.a, spring.b) = (attachment(&spring.a), attachment(&spring.b));
            spring.a.body != spring.b.body
        });
        forces.wrenches = (whole.forces.wrenches.iter())
            .filter_map(|wrench| {
                let at = Pose::from_parts(Translation3::from(wrench.point), Rotation3::identity());
                let (body, frame) = into.frame(wrench.body, &at);
                Some(Wrench { body: body?, point: frame.translation.vector, ..*wrench })
            })
            .collect();
        forces.joint_courses.retain_mut(|load| freedom(load.freedom).map(|own| load.freedom = own).is_some());
        let holding = &mut forces.gravity_compensations;
        holding.retain_mut(|holding| freedom(holding.freedom).map(|own| holding.freedom = own).is_some());
        let at = |body: usize, point: &Vector3<f64>| {
            let (body, frame) = into.frame(body, &Pose::from_parts(Translation3::from(*point), Rotation3::identity()));
            body.map(|body| (body, frame))
        };
        forces.link_loads.retain_mut(|load| match at(load.body, &load.point) {
            Some((body, frame)) => {
                (load.body, load.point) = (body, frame.translation.vector);
                if load.turns {
                    (load.force, load.torque) = (frame.rotation * load.force, frame.rotation * load.torque);
                }
                true
            }
            None => false,
        });
        forces.drags.retain_mut(|drag| match at(drag.body, &drag.point) {
            Some((body, frame)) => {
                (drag.body, drag.point) = (body, frame.translation.vector);
                true
            }
            None => false,
        });
        let mut loops = whole.loops.clone();
        loops.extend_from_slice(&closures.anchors);
        loops.retain_mut(|joint| {
            (joint.a, joint.b) = (attachment(&joint.a), attachment(&joint.b));
            joint.a.body != joint.b.body
        });
        let mut touches = closures.touches.clone();
        touches.retain_mut(|joint| joint.move_to(attachment));
        let mut mimics = whole.mimics.clone();
        mimics.retain_mut(|mimic| match (coordinate(mimic.follower), coordinate(mimic.leader)) {
            _ if !mimic.more.is_empty() => {
                let left = left_of(mimic, state, &coordinate);
                left.is_some_and(|left| {
                    *mimic = left;
                    true
                })
            }
            (Some(follower), Some(leader)) => {
                (mimic.follower, mimic.leader) = (follower, leader);
                true
            }
            _ => false,
        });
        debug_assert_eq!(self.is_held.len(), whole.bodies.len());
        let mechanism = &mut self.mechanism;
        mechanism.forces = forces;
        mechanism.loops = loops;
        mechanism.touches = touches;
        mechanism.mimics = mimics;
        mechanism.nonsmooth = Nonsmooth::default();
    }

    /// The body of the whole that heads a body of the reduced mechanism.
    pub fn head(&self, body: usize) -> usize {
        self.heads[body]
    }

    /// The body of the reduced mechanism that a body of the whole heads; `None` if its joint is held.
    pub fn headed_by(&self, body: usize) -> Option<usize> {
        self.heads.binary_search(&body).ok()
    }

    /// The group of a body of the whole: a body of the reduced mechanism, or the world.
    pub fn group(&self, body: usize) -> Option<usize> {
        self.groups[body]
    }

    /// Whether every joint is held.
    pub fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    /// The coordinate of the reduced mechanism for one of the whole; `None` if it is held.
    pub fn coordinate(&self, whole: &Mechanism, of: Coordinate) -> Option<Coordinate> {
        let body = self.heads.binary_search(&of.body).ok()?;
        let (from, to) = (&whole.bodies[of.body].joint, &self.mechanism.bodies[body].joint);
        Some(Coordinate {
            body,
            position: of.position - from.position_index + to.position_index,
            freedom: of.freedom - from.velocity_index + to.velocity_index,
        })
    }

    /// The degree of freedom of the reduced mechanism for one of the whole; `None` if it is held.
    pub fn freedom(&self, whole: &Mechanism, of: usize) -> Option<usize> {
        let head = whole.body_of_freedom(of)?;
        let body = self.heads.binary_search(&head).ok()?;
        Some(of - whole.bodies[head].joint.velocity_index + self.mechanism.bodies[body].joint.velocity_index)
    }

    /// Copies entries of position vectors of the whole into position vectors of the reduced mechanism.
    pub fn gather_positions(&self, whole: &Mechanism, from: &[f64], into: &mut [f64]) {
        for (&head, body) in self.heads.iter().zip(&self.mechanism.bodies) {
            into[body.joint.position_range()].copy_from_slice(&from[whole.bodies[head].joint.position_range()]);
        }
    }

    /// Copies entries of velocity vectors of the whole into velocity vectors of the reduced mechanism.
    pub fn gather_velocities(&self, whole: &Mechanism, from: &[f64], into: &mut [f64]) {
        for (&head, body) in self.heads.iter().zip(&self.mechanism.bodies) {
            into[body.joint.velocity_range()].copy_from_slice(&from[whole.bodies[head].joint.velocity_range()]);
        }
    }

    /// Copies entries of position vectors of the reduced mechanism to their places in the whole.
    pub fn spread_positions(&self, whole: &Mechanism, from: &[f64], into: &mut [f64]) {
        for (&head, body) in self.heads.iter().zip(&self.mechanism.bodies) {
            into[whole.bodies[head].joint.position_range()].copy_from_slice(&from[body.joint.position_range()]);
        }
    }

    /// The same of velocity vectors; held joints get zero.
    pub fn spread_velocities(&self, whole: &Mechanism, from: &[f64], into: &mut [f64]) {
        for (body, &held) in whole.bodies.iter().zip(&self.is_held) {
            if held {
                into[body.joint.velocity_range()].fill(0.0);
            }
        }
        for (&head, body) in self.heads.iter().zip(&self.mechanism.bodies) {
            into[whole.bodies[head].joint.velocity_range()].copy_from_slice(&from[body.joint.velocity_range()]);
        }
    }

    /// The state of the reduced mechanism.
    pub fn gather(&self, whole: &Mechanism, state: &State) -> State {
        let mut own = State::zero(&self.mechanism);
        own.time = state.time;
        self.gather_positions(whole, &state.position, &mut own.position);
        self.gather_positions(whole, &state.compensation, &mut own.compensation);
        self.gather_velocities(whole, &state.velocity, &mut own.velocity);
        own
    }

    /// Moves the state of the whole to the state of the reduced mechanism.
    pub fn spread(&self, whole: &Mechanism, own: &State, state: &mut State) {
        state.time = own.time;
        self.spread_positions(whole, &own.position, &mut state.position);
        self.spread_positions(whole, &own.compensation, &mut state.compensation);
        self.spread_velocities(whole, &own.velocity, &mut state.velocity);
    }
}

/// A relation of several joints with its coordinates in the reduced mechanism, where held joints are part of its offset; `None` if all are held.
fn left_of(mimic: &Mimic, state: &State, coordinate: &impl Fn(Coordinate) -> Option<Coordinate>) -> Option<Mimic> {
    let mut offset = mimic.offset;
    let mut moving: Vec<(Coordinate, f64)> = Vec::new();
    for (own, coefficient) in mimic.terms() {
        match coordinate(own) {
            Some(own) => moving.push((own, coefficient)),
            None => offset -= coefficient * (state.position[own.position] + state.compensation[own.position]),
        }
    }
    let &(follower, of_follower) = moving.iter().find(|(_, coefficient)| *coefficient != 0.0)?;
    let leaders = moving.into_iter().filter(|(own, _)| *own != follower);
    let mut ratios = leaders.map(|(own, coefficient)| (own, -coefficient / of_follower));
    // One that is left alone follows itself no times.
    let (leader, multiplier) = ratios.next().unwrap_or((follower, 0.0));
    let (name, offset, more) = (mimic.name.clone(), offset / of_follower, ratios.collect());
    Some(Mimic { name, follower, leader, multiplier, offset, more, over_time: mimic.over_time.clone() })
}

/// The bodies that head groups, and the place of every body.
fn heads_and_places(whole: &Mechanism, state: &State, is_held: &[bool]) -> (Vec<usize>, Vec<Place>) {
    let mut heads = Vec::new();
    let mut places: Vec<Place> = Vec::with_capacity(whole.bodies.len());
    for (index, body) in whole.bodies.iter().enumerate() {
        if !is_held[index] {
            places.push(Place { group: Some(heads.len()), pose: Pose::identity() });
            heads.push(index);
            continue;
        }
        let joint = &body.joint;
        let range = joint.position_range();
        let (translation, turn) = joint.displacement(&state.position[range.clone()], &state.compensation[range]);
        let across = Pose::from_parts(Translation3::from(translation), Rotation3::from_matrix_unchecked(turn));
        let on_parent = joint.on_parent * across * joint.on_child.inverse();
        places.push(match body.parent {
            None => Place { group: None, pose: on_parent },
            Some(parent) => Place { group: places[parent].group, pose: places[parent].pose * on_parent },
        });
    }
    (heads, places)
}

/// A mechanism of these bodies, which are depth first because the bodies of the whole are.
fn number(whole: &Mechanism, mut bodies: Vec<Body>) -> Mechanism {
    let (mut position_count, mut velocity_count) = (0, 0);
    for body in &mut bodies {
        (body.joint.position_index, body.joint.velocity_index) = (position_count, velocity_count);
        position_count += body.joint.kind.position_count();
        velocity_count += body.joint.kind.velocity_count();
    }
    Mechanism {
        name: whole.name.clone(),
        gravity: whole.gravity,
        bodies,
        loops: Vec::new(),
        touches: Vec::new(),
        mimics: Vec::new(),
        forces: Default::default(),
        limits: Vec::new(),
        nonsmooth: Nonsmooth::default(),
        position_count,
        velocity_count,
    }
}

/// Maps from the bodies of the whole into the groups.
struct Into<'p> {
    places: &'p [Place],
    /// Mass, principal frame and moments of each group.
    principal: &'p [(f64, Pose, Vector3<f64>)],
}

impl Into<'_> {
    fn group(&self, body: usize) -> Option<usize> {
        self.places[body].group
    }

    /// A frame on a body, on its group or in the world.
    fn frame(&self, body: usize, frame: &Pose) -> (Option<usize>, Pose) {
        let Place { group, pose } = self.places[body];
        let placed = pose * frame;
        match group {
            None => (None, placed),
            Some(own) => (group, self.principal[own].1.inv_mul(&placed)),
        }
    }
}
