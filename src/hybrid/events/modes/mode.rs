//! A mode: what every element does between two events.
//!
//! | element | state | effort on the joint |
//! |---|---|---|
//! | joint | free, sliding with sign σ | `−σ τ_f` |
//! | joint | held by friction | whatever holds it, `λ ∈ [−τ_f, τ_f]` |
//! | joint | held on its lower limit | `λ ∈ [−τ_f, ∞)` |
//! | joint | held on its upper limit | `λ ∈ (−∞, τ_f]` |
//! | motor | unbounded | `kp (r − q) + kd (ṙ − q̇)` |
//! | motor | at its bound | `± bound` |
//! | motor | sampled | as worked out at the last tick |
//! | contact | sliding along t | `λ (n − μ t)`, λ ≥ 0 |
//! | contact | sticking, or rolling | whatever holds it, `|λ_T| ≤ μ λ_N` |
//! | its rolling friction | turning along t | the moment `−ρ λ_N t` |
//! | the same | not turning | whatever holds it, `|τ| ≤ ρ λ_N`; likewise spinning friction with σ |

use crate::instant::holding::elements::{ElementJoint, Elements};
use crate::instant::holding::held::Closures;
use crate::instant::holding::touching::{Contact, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use crate::mechanism::description::contact::{Feature, Grip, Moment, Moments, TouchJoint};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::{Rotation3, Translation3, Vector3};

/// The mode of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointMode {
    /// It moves; its friction, if it has any, against this direction.
    Free {
        /// σ: 1 or −1; 0 without friction.
        sliding: i8,
    },
    /// It is held, by friction alone or on a limit.
    Held {
        /// The limit.
        on: Option<Side>,
    },
}

/// The mode of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotorMode {
    /// Its law without bound.
    Unbounded,
    /// At its bound, with this sign.
    Saturated(i8),
    /// A given effort, until the next tick [N m or N].
    Given(f64),
}

/// A contact that is closed.
#[derive(Clone, Debug, PartialEq)]
pub struct Closed {
    pub contact: Contact,
    /// The direction in which it begins to slide, in the world; `None` while it sticks or rolls.
    pub slides: Option<Vector3<f64>>,
    /// Whether it sticks with all the friction that it has, because its slip would not be accelerated: as a box that rides on another one while the
    /// friction is the same everywhere.
    pub on_cone: bool,
    /// Its rolling and spinning friction.
    pub moments: Moments,
}

/// The modes of all elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    pub joints: Vec<JointMode>,
    pub motors: Vec<MotorMode>,
    /// Those that are closed; all others are open.
    pub contacts: Vec<Closed>,
    /// Pairs that touch without pressing, because others keep their gaps at zero ([`crate::events::effects::immobile`]).
    pub idle: Vec<usize>,
    /// Contacts whose gaps loops alone keep at zero ([`crate::instant::holding::kept_by_loops`]); they are not among the closed ones.
    pub kept: Vec<Contact>,
    /// Contacts without pressure whose gaps the closed ones keep at zero, while friction follows the pressures of these
    /// ([`crate::events::forces::returning`]).
    pub unpressed: Vec<Contact>,
    /// Contacts between closed ones on seams of a plane of several obstacles, which do not press ([`crate::events::effects::seams`]).
    pub seams: Vec<Contact>,
}

impl Mode {
    /// The contacts at which a pair touches: closed ones, contacts that loops keep, and contacts on seams beside them.
    pub fn touching(&self, pair: usize) -> impl Iterator<Item = &Contact> + Clone {
        let own = move |contact: &&Contact| contact.pair == pair;
        let all = self.contacts.iter().map(|closed| &closed.contact).chain(&self.kept).filter(own);
        let beside = all.clone().next().map_or(&[][..], |_| &self.seams);
        all.chain(beside.iter().filter(own))
    }

    /// Whether a pair touches in the mode: by a closed contact, or by one that loops keep.
    pub fn touches(&self, pair: usize) -> bool {
        self.touching(pair).next().is_some()
    }

    /// Whether others than closed contacts of a pair keep its gap at zero somewhere, without a force.
    pub fn is_idle(&self, pair: usize) -> bool {
        self.idle.contains(&pair) || self.kept.iter().chain(&self.seams).any(|contact| contact.pair == pair)
    }

    /// Whether the joint of each body is held.
    pub fn held_bodies(&self, elements: &Elements, bodies: usize) -> Vec<bool> {
        let mut held = vec![false; bodies];
        for (joint, mode) in elements.joints.iter().zip(&self.joints) {
            for member in &joint.members {
                held[member.coordinate.body] |= matches!(mode, JointMode::Held { .. });
            }
        }
        held
    }

    /// The efforts that are constant while the mode lasts, added to `efforts`: of friction that slides, and of motors at their bounds or between
    /// ticks.
    pub fn add_constant_efforts(&self, elements: &Elements, efforts: &mut [f64]) {
        self.add_friction(elements, efforts);
        self.add_given_efforts(elements, efforts);
    }

    /// Adds the efforts of sliding friction.
    fn add_friction(&self, elements: &Elements, efforts: &mut [f64]) {
        for (joint, mode) in elements.joints.iter().zip(&self.joints) {
            if let JointMode::Free { sliding } = mode {
                efforts[joint.coordinate.freedom] -= f64::from(*sliding) * joint.friction;
            }
        }
    }

    /// Adds the efforts of motors at their bounds or between ticks.
    fn add_given_efforts(&self, elements: &Elements, efforts: &mut [f64]) {
        for (motor, mode) in elements.motors.iter().zip(&self.motors) {
            let freedom = motor.coordinate.freedom;
            match *mode {
                MotorMode::Unbounded => {}
                MotorMode::Saturated(sign) => efforts[freedom] += f64::from(sign) * motor.max_effort,
                MotorMode::Given(effort) => efforts[freedom] += effort,
            }
        }
    }

    /// Writes all efforts in a state, which has its time, but those that hold: from outside, of friction that slides, and of motors.
    pub fn efforts_at(&self, elements: &Elements, inputs: Inputs, since: f64, state: &State, efforts: &mut [f64]) {
        inputs.write_constant(efforts);
        inputs.add_feedback(state, efforts);
        self.add_constant_efforts(elements, efforts);
        self.add_motor_efforts(elements, since, state.time, state, efforts);
    }

    /// The same without friction: a new decision begins with these efforts.
    pub fn driving_efforts(&self, elements: &Elements, inputs: Inputs, state: &State) -> Vec<f64> {
        let mut efforts = vec![0.0; state.velocity.len()];
        inputs.write_constant(&mut efforts);
        inputs.add_feedback(state, &mut efforts);
        self.add_given_efforts(elements, &mut efforts);
        self.add_motor_efforts(elements, state.time, state.time, state, &mut efforts);
        efforts
    }

    /// The efforts of motors that follow their laws, at a time (s) and state, added to `efforts`; their targets belong to the piece that begins at or
    /// before `since` (s).
    pub fn add_motor_efforts(&self, elements: &Elements, since: f64, time: f64, state: &State, efforts: &mut [f64]) {
        for (motor, mode) in elements.motors.iter().zip(&self.motors) {
            if *mode == MotorMode::Unbounded {
                let at = motor.coordinate;
                let position = state.position[at.position] + state.compensation[at.position];
                efforts[at.freedom] += motor.unbounded(since, time, position, state.velocity[at.freedom]);
            }
        }
    }
}

impl Mode {
    /// Takes the modes of another. Allocates only for more contacts.
    pub fn copy_from(&mut self, other: &Mode) {
        let Mode { joints, motors, contacts, idle, kept, unpressed, seams } = other;
        self.joints.clone_from(joints);
        self.motors.clone_from(motors);
        self.contacts.clone_from(contacts);
        self.idle.clone_from(idle);
        self.kept.clone_from(kept);
        self.unpressed.clone_from(unpressed);
        self.seams.clone_from(seams);
    }

    /// Whether another differs in the directions of slips at most.
    pub fn is_like(&self, other: &Mode) -> bool {
        let of = |closed: &Closed| {
            let Moments { rolling, spinning } = closed.moments;
            let kinds = [rolling, spinning].map(|moment| std::mem::discriminant(&moment));
            (closed.contact.pair, closed.contact.features, closed.slides.is_some(), kinds)
        };
        self.joints == other.joints
            && self.motors == other.motors
            && self.contacts.iter().map(of).eq(other.contacts.iter().map(of))
    }

    /// The closed contacts as closures, where the bodies are now.
    pub(crate) fn closures(&self, touching: &Touching, bodies: &[BodyState]) -> Closures {
        let mut closures = Closures::default();
        for closed in &self.contacts {
            if self.is_anchored(closed) {
                closures.anchors.push(closed.anchor(bodies));
            } else {
                closures.touches.push(closed.touch(touching));
            }
        }
        closures
    }

    /// Whether a closed contact is anchored, so that its place is held, not its velocity: a corner that sticks, unless another contact slides on one of
    /// its bodies. What friction holds must not bear the load of what brakes then, which steps tell apart in the rows of contacts alone
    /// ([`crate::mechanism::structure::ranks::counting`]).
    pub fn is_anchored(&self, closed: &Closed) -> bool {
        let slides_beside =
            |other: &Closed| other.slides.is_some() && other.contact.joint.shares_a_body(&closed.contact.joint);
        closed.is_corner_that_sticks() && !self.contacts.iter().any(slides_beside)
    }
}

impl Closed {
    /// The contact with what its friction does.
    pub(crate) fn touch(&self, touching: &Touching) -> TouchJoint {
        let mut joint = self.contact.joint.clone();
        let friction = touching.pairs[self.contact.pair].friction;
        joint.touch.grip = match self.slides {
            Some(direction) => Grip::Slides { friction, direction },
            None => Grip::Rolls,
        };
        joint.moments = self.moments;
        joint
    }

    /// Whether rolling and whether spinning friction hold it, as numbers.
    pub fn held_turns(&self) -> [usize; 2] {
        [self.moments.rolling, self.moments.spinning].map(|moment| usize::from(moment == Moment::Holds))
    }

    /// Whether its pressure is looked at alone where forces are not unique: friction still follows the pressures of sliding contacts. Flat ends have points
    /// at the places where they press.
    pub(crate) fn shares(&self, touching: &Touching) -> bool {
        let rubs = touching.pairs[self.contact.pair].friction > 0.0;
        rubs && self.slides.is_some() && self.contact.flat_end().is_none()
    }

    /// Whether friction brakes it: it slides, or turns against a moment.
    pub fn is_braked(&self) -> bool {
        self.slides.is_some() || self.moments.brake()
    }

    /// Whether it is a corner that sticks on a face. None has a place on a belt.
    fn is_corner_that_sticks(&self) -> bool {
        let joint = &self.contact.joint;
        let is_corner = joint.touch.features == [Feature::Plane, Feature::Point { radius: 0.0 }];
        self.slides.is_none() && !joint.is_belt() && is_corner && self.moments == Moments::default()
    }

    /// The place of a contact that is anchored.
    fn anchor(&self, bodies: &[BodyState]) -> LoopJoint {
        let joint = &self.contact.joint;
        let point = touch_motion(joint, bodies).point;
        let on = |end: &Attachment| {
            let body = end.on(bodies);
            let place = body.rotation.transpose() * (point - body.position);
            let frame = Pose::from_parts(Translation3::from(place), Rotation3::identity());
            Attachment { body: end.body, frame }
        };
        LoopJoint { name: "contact".into(), kind: LoopKind::Spherical, a: on(&joint.a), b: on(&joint.b) }
    }
}

impl JointMode {
    /// The efforts that can hold a joint: λ from … to [N m or N].
    pub fn holding(self, joint: &ElementJoint) -> (f64, f64) {
        match self {
            JointMode::Held { on } => joint.holding(on),
            JointMode::Free { .. } => joint.holding(None),
        }
    }
}
