//! The candidates of a step: contacts within reach, limits, friction of joints, motors with a bound.
//!
//! ```text
//!     contact:  distance ≤ h (s_a + s_b) · 5/4 + 2 g h²        s: largest speed of a body's points [m/s]
//!     limit:    gap ≤ h (|rate| · 5/4 + 2)                     [rad or m]
//! ```
//!
//! A pair that was farther apart is not looked at again until its bodies can have covered the distance.

use crate::crowd::laws::Law;
use crate::crowd::rows::{Rows, Side};
use crate::crowd::trees::Trees;
use crate::events::crowd::asleep::Asleep;
use crate::events::crowd::clearances::Clearances;
use crate::events::crowd::speeds::Speeds;
use crate::geometry::PlaceId;
use crate::instant::holding::elements::{Elements, inward};
use crate::instant::holding::touching::{Contact, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::Cores;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::event::Side as End;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{belt, tangents, touch_motion};
use nalgebra::Vector3;

/// Contacts and limits with a smaller gap are closed (m or rad).
pub(super) const CLOSED: f64 = 1e-9;
/// A contact that has pressed is closed with a gap up to this (m or rad).
const NEARLY: f64 = 1e-6;
/// Speeds grow in a step by this factor at most; more is found out at its end.
const FASTER: f64 = 1.25;
/// Impulses of a step that was shorter by more than this factor are roundings.
const LONGEST: f64 = 1e6;
/// Margins are larger than bounds by this factor, for roundings.
const ROUNDED: f64 = 1.0 + 1e-12;
/// A limit is looked at from this rate on [rad/s or m/s].
const LIMIT_RATE: f64 = 2.0;
/// A normal does not move with a freedom whose lever is this short (m): a point on an axis, to roundings.
const LEVER: f64 = 1e-13;

/// The constant data of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'s> {
    pub whole: &'s Mechanism,
    pub elements: &'s Elements,
    pub touching: &'s Touching,
}

/// By what a candidate is found again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Key {
    Touch(usize, PlaceId),
    /// A joint by its number among the elements, and whether it is its upper limit.
    Limit(usize, bool),
    Friction(usize),
    Motor(usize),
}

/// A contact, limit, joint with friction or motor that may act in a step.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub key: Key,
    /// The features, of a contact.
    pub contact: Option<Contact>,
    pub friction: f64,
    pub restitution: f64,
    /// m or rad; zero for friction and motors.
    pub gap: f64,
    /// Normal and tangents.
    pub frame: [Vector3<f64>; 3],
    /// The velocity of belts in the frame, along the tangents of a contact with friction [m/s].
    pub belt: Vector3<f64>,
    /// The bodies that it acts on, and its rows on the trees of those that are awake.
    pub ends: [Option<usize>; 2],
    pub sides: [Option<Side>; 2],
    /// Impulses that move it to the end of a step, and that make its rates there, in the frame (N s).
    pub moving: Vector3<f64>,
    pub settling: Vector3<f64>,
    /// How much faster the gap closes than its rate at the start says [m/s].
    pub curve: f64,
    /// Whether it was closed where the step before began, and its gap there over the length of the step [m/s].
    pub was_closed: bool,
    pub closing: f64,
}

/// All candidates at one instant, with their rows.
#[derive(Clone, Default)]
pub(crate) struct Contacts {
    pub list: Vec<Candidate>,
    pub rows: Rows,
}

impl Candidate {
    /// Its law in a problem of a step that lasts this long (s).
    pub fn law(&self, elements: &Elements, time: f64) -> Law {
        match self.key {
            Key::Touch(..) if self.friction > 0.0 => Law::Cone(self.friction),
            Key::Touch(..) | Key::Limit(..) => Law::Interval(0.0, f64::INFINITY),
            Key::Friction(joint) => {
                let most = time * elements.joints[joint].friction;
                Law::Interval(-most, most)
            }
            Key::Motor(motor) => {
                let most = time * elements.motors[motor].max_effort;
                Law::Interval(-most, most)
            }
        }
    }

    /// Whether it is a contact or a limit, which closes.
    pub fn closes(&self) -> bool {
        matches!(self.key, Key::Touch(..) | Key::Limit(..))
    }

    /// Whether it is one that is closed.
    pub fn is_closed(&self) -> bool {
        self.closes() && self.gap <= CLOSED
    }

    /// Whether it acts on the rates at the end of a step: it is closed, it has pressed and the gap did not close to the last digits, or it has no gap.
    pub fn settles(&self) -> bool {
        !self.closes() || self.gap <= if self.moving.x > 0.0 { NEARLY } else { CLOSED }
    }

    /// An impulse in the axes of the world, from its frame.
    fn in_world(&self, impulse: &Vector3<f64>) -> Vector3<f64> {
        if self.contact.is_none() {
            return *impulse;
        }
        self.frame[0] * impulse.x + self.frame[1] * impulse.y + self.frame[2] * impulse.z
    }

    fn in_frame(&self, impulse: &Vector3<f64>) -> Vector3<f64> {
        match (&self.contact, self.friction > 0.0) {
            (None, _) => *impulse,
            (Some(_), false) => Vector3::new(self.frame[0].dot(impulse), 0.0, 0.0),
            (Some(_), true) => Vector3::from(self.frame.map(|axis| axis.dot(impulse))),
        }
    }

    /// Whether the next step has about the same curvature: so have points on curved paths, but not the corners of one face.
    fn keeps_curve(&self, trees: &Trees) -> bool {
        let Some(Contact { joint, .. }) = &self.contact else { return false };
        match joint.touch.pairing().map(|pairing| pairing.cores) {
            Some(Cores::Points | Cores::LinePoint) => true,
            _ => {
                let alone =
                    |body: Option<usize>| body.is_none_or(|body| trees.trees[trees.of_body[body]].bodies.len() > 1);
                (joint.a.body.is_none() || joint.b.body.is_none()) && alone(joint.a.body) && alone(joint.b.body)
            }
        }
    }
}

/// Whether a motor pulls within a bound at every instant, so that it needs a row of its own.
pub(crate) fn has_row(motor: &Motor) -> bool {
    let (stiffness, damping) = motor.law.gains();
    motor.period == 0.0 && motor.max_effort.is_finite() && stiffness + damping > 0.0
}

impl Contacts {
    /// Finds all candidates for a step of this length (s), in a state that places the bodies, which are at most so fast. Sleeping bodies have no
    /// candidates among each other or with the world.
    pub fn find(
        &mut self,
        scene: Scene,
        asleep: &Asleep,
        state: &State,
        (bodies, speeds): (&[BodyState], &Speeds),
        step: f64,
        clearances: &mut Clearances,
    ) {
        self.list.clear();
        let Scene { whole, elements, touching } = scene;
        let fall = 2.0 * whole.gravity.norm() * step * step + 2.0 * CLOSED;
        clearances.see(bodies);
        let near = &mut clearances.near;
        let new = near.see(&touching.pairs, bodies, |body| {
            let fastest = speeds.of(body, touching.pairs.reach_of(body));
            ROUNDED * (FASTER * step * fastest + 0.5 * fall)
        });
        if new {
            // Others part where some come near.
            let parted = near.leave_out(&touching.pairs);
            clearances.keep_near(parted);
        }
        for place in 0..clearances.near.pairs().len() {
            let pair = clearances.near.pairs()[place];
            let of = &touching.pairs[pair];
            if of.bodies.into_iter().all(|body| asleep.holds(body)) {
                continue;
            }
            let within = FASTER * step * speeds.closing(of) + fall;
            if clearances.is_beyond(pair, of, within) {
                continue;
            }
            let mut near = clearances.look(pair, touching, bodies, within);
            // A pair that touches already may have several normals, and the distance has one of them by roundings.
            if near.iter().any(|contact| touch_motion(&contact.joint, bodies).gap <= CLOSED) {
                near = touching.slowest(pair, bodies, [CLOSED, within], near, fall / step);
            }
            for contact in near {
                self.list.push(Candidate::touch(contact, of.friction, of.restitution, bodies));
            }
        }
        for (index, joint) in elements.joints.iter().enumerate() {
            let body = joint.coordinate.body;
            if asleep.holds(Some(body)) {
                continue;
            }
            let plain = Candidate::of_joint(Key::Friction(index), body, joint.restitution, 0.0);
            if joint.friction > 0.0 {
                self.list.push(plain.clone());
            }
            for side in joint.sides() {
                let gap = joint.gap(side, joint.position(state));
                if gap <= step * (FASTER * joint.rate(state).abs() + LIMIT_RATE) {
                    self.list.push(Candidate { key: Key::Limit(index, side == End::Upper), gap, ..plain.clone() });
                }
            }
        }
        for (index, motor) in elements.motors.iter().enumerate().filter(|(_, motor)| has_row(motor)) {
            let body = motor.coordinate.body;
            if !asleep.holds(Some(body)) {
                self.list.push(Candidate::of_joint(Key::Motor(index), body, 0.0, 0.0));
            }
        }
    }

    /// The candidates that a test keeps, with their numbers and sides.
    pub fn sides<'c>(
        &'c self,
        keeps: impl Fn(&Candidate) -> bool + Clone + 'c,
    ) -> impl Iterator<Item = (usize, [Option<Side>; 2])> + Clone + 'c {
        let all = self.list.iter().enumerate();
        all.filter(move |(_, candidate)| keeps(candidate)).map(|(number, candidate)| (number, candidate.sides))
    }

    /// Fills the rows of the candidates from a number on, with trees that are placed in the same state. A contact along whose normal no freedom moves, as between
    /// wheels whose axles are held apart, is no candidate: no impulse changes its rate, and any would do.
    pub fn fill_rows(&mut self, scene: Scene, asleep: &Asleep, trees: &Trees, bodies: &[BodyState], first: usize) {
        if first == 0 {
            self.rows.clear();
        }
        let mut kept = first;
        for number in first..self.list.len() {
            let mark = self.rows.mark();
            let sides = self.list[number].add_rows(&mut self.rows, scene, trees, bodies);
            let moves = |side: &Side| self.rows.row(side, 0).1.iter().any(|entry| entry.abs() > LEVER);
            if self.list[number].contact.is_some() && !sides.iter().flatten().any(moves) {
                self.rows.go_back(mark);
                continue;
            }
            if kept < number {
                self.list.swap(kept, number);
            }
            self.list[kept].sides = sides.map(|side| side.filter(|side| !asleep.has(side.tree)));
            kept += 1;
        }
        self.list.truncate(kept);
    }

    /// The rows of the same candidates where trees and bodies are at other places, each where it was in the rows here.
    pub fn rows_at(&self, scene: Scene, trees: &Trees, bodies: &[BodyState]) -> Rows {
        let mut rows = self.rows.with_its_room();
        for candidate in &self.list {
            candidate.add_rows(&mut rows, scene, trees, bodies);
        }
        rows
    }

    /// The deepest overlap of all candidates (m or rad).
    pub fn deepest(&self) -> f64 {
        let closing = self.list.iter().filter(|candidate| candidate.closes());
        closing.fold(0.0, |deepest, candidate| deepest.max(-candidate.gap))
    }

    /// The normal rate of a candidate at rates of all freedoms [m/s or rad/s].
    pub fn closing_rate(&self, number: usize, trees: &Trees, rates: &[f64]) -> f64 {
        let along = |side: &Side| {
            let (columns, entries) = self.rows.row(side, 0);
            let freedoms = &trees.trees[side.tree].freedoms;
            columns.iter().zip(entries).map(|(&column, entry)| entry * rates[freedoms[column]]).sum::<f64>()
        };
        self.list[number].sides.iter().flatten().map(along).sum()
    }

    /// Takes impulses and curvatures from the candidates of the step before, which lasted this long (s), for steps that are longer by a factor. Those of a
    /// step that was far shorter are roundings, and are left out.
    pub fn warm(&mut self, before: &Contacts, step: f64, longer: f64, trees: &Trees) {
        let longer = if longer > LONGEST { 0.0 } else { longer };
        let mut keys: Vec<(Key, usize)> =
            before.list.iter().enumerate().map(|(number, candidate)| (candidate.key, number)).collect();
        keys.sort_unstable();
        for candidate in &mut self.list {
            let Ok(place) = keys.binary_search_by(|(key, _)| key.cmp(&candidate.key)) else { continue };
            let old = &before.list[keys[place].1];
            candidate.moving = candidate.in_frame(&old.in_world(&old.moving)) * longer;
            candidate.settling = candidate.in_frame(&old.in_world(&old.settling)) * longer;
            candidate.was_closed = old.is_closed();
            candidate.closing = old.gap / step;
            candidate.curve = if candidate.keeps_curve(trees) { old.curve * longer } else { 0.0 };
        }
    }
}

impl Candidate {
    /// A contact of these bodies.
    pub fn touch(contact: Contact, friction: f64, restitution: f64, bodies: &[BodyState]) -> Self {
        let touch = touch_motion(&contact.joint, bodies);
        let [first, second] = tangents(&touch.normal);
        let carried = if friction > 0.0 && contact.joint.is_belt() {
            let belt = belt(&contact.joint, bodies, &touch.normal);
            Vector3::new(0.0, belt.dot(&first), belt.dot(&second))
        } else {
            Vector3::zeros()
        };
        Candidate {
            frame: [touch.normal, first, second],
            belt: carried,
            gap: touch.gap,
            friction,
            key: Key::Touch(contact.pair, contact.features),
            ends: [contact.joint.a.body, contact.joint.b.body],
            contact: Some(contact),
            ..Candidate::of_joint(Key::Friction(0), 0, restitution, 0.0)
        }
    }

    /// Adds its rows, with trees and bodies at the same places; the normal is the one there, and the tangents are the nearest to the tangents of its frame.
    fn add_rows(&self, rows: &mut Rows, scene: Scene, trees: &Trees, bodies: &[BodyState]) -> [Option<Side>; 2] {
        match (&self.contact, self.key) {
            (Some(contact), _) => {
                let touch = touch_motion(&contact.joint, bodies);
                let first = (self.frame[1] - touch.normal * touch.normal.dot(&self.frame[1])).normalize();
                let second = touch.normal.cross(&first);
                let count = if self.friction > 0.0 { 3 } else { 1 };
                let along = [touch.normal, first, second];
                rows.between([contact.joint.a.body, contact.joint.b.body], &touch.point, &along[..count], trees)
            }
            (None, Key::Limit(joint, upper)) => {
                let sign = inward(if upper { End::Upper } else { End::Lower });
                [Some(rows.of_freedom(scene.elements.joints[joint].coordinate.freedom, sign, trees)), None]
            }
            (None, Key::Friction(joint)) => {
                [Some(rows.of_freedom(scene.elements.joints[joint].coordinate.freedom, 1.0, trees)), None]
            }
            (None, Key::Motor(motor)) => {
                [Some(rows.of_freedom(scene.elements.motors[motor].coordinate.freedom, 1.0, trees)), None]
            }
            (None, Key::Touch(..)) => [None, None],
        }
    }

    /// The same candidate in another state.
    pub fn at(&self, elements: &Elements, state: &State, bodies: &[BodyState]) -> Self {
        match (&self.contact, self.key) {
            (Some(contact), _) => Candidate::touch(contact.clone(), self.friction, self.restitution, bodies),
            (None, Key::Limit(joint, upper)) => {
                let joint = &elements.joints[joint];
                let gap = joint.gap(if upper { End::Upper } else { End::Lower }, joint.position(state));
                Candidate::of_joint(self.key, joint.coordinate.body, self.restitution, gap)
            }
            (None, _) => Candidate::of_joint(self.key, self.ends[0].unwrap_or_default(), self.restitution, 0.0),
        }
    }

    fn of_joint(key: Key, body: usize, restitution: f64, gap: f64) -> Self {
        Candidate {
            key,
            contact: None,
            friction: 0.0,
            restitution,
            gap,
            frame: [Vector3::x(), Vector3::y(), Vector3::z()],
            belt: Vector3::zeros(),
            ends: [Some(body), None],
            sides: [None, None],
            moving: Vector3::zeros(),
            settling: Vector3::zeros(),
            curve: 0.0,
            was_closed: false,
            closing: 0.0,
        }
    }
}
