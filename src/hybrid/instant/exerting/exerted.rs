//! The efforts and forces of motors, dry friction, limits and contacts in one state.
//!
//! ```text
//!     τ_i = τ_motor,i − τ_f,i sign(q̇_i)        a joint that moves, with friction τ_f
//!     τ_i = τ_motor,i + λ_i                    a joint at rest (q̇_i = 0) that has friction or is on a limit
//!     f   = λ_N n + λ_T                        a contact that touches and does not part, with its moments of friction
//!
//!     a = b + D λ,   b = W a_free + Ẇ v,  D = W Y Wᵀ                 W: rows of joints at rest and of contacts, Y: their response
//!     λ_i ∈ [lo_i, hi_i]:   a_i = 0 inside,  a_i ≥ 0 at lo_i,  a_i ≤ 0 at hi_i;   contacts: Signorini's and Coulomb's law
//! ```
//!
//! [N m or N]; a_free are the accelerations without λ, with all forces and closures. The set is `[−τ_f, τ_f]` where friction alone holds, without
//! bound into the allowed range on a limit. If several λ fit, the ones of least compliance are taken. Contacts whose forces the run has told are known
//! loads, except contacts with moments of friction and ropes through several points: a point does not tell all of them.
//!
//! Source: Ch. Glocker, Set-Valued Force Laws, Springer 2001, chapter 9.

use crate::instant::cone::apart::forces_apart;
use crate::instant::cone::problem::{Law, Problem, Unsolved};
use crate::instant::cone::{least_compliance, solve};
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Block, Of, Rows, add_pulls, rows_of_contact, second_rates};
use crate::instant::holding::elements::Elements;
use crate::instant::holding::kept_by_loops::kept_by_loops;
use crate::instant::holding::moments::{Turning, blocks_of_turning, have_moments, solve_with_moments};
use crate::instant::holding::near::Near;
use crate::instant::holding::touching::{Contact, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::forces::total::BodyWrench;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::efforts::efforts_of_wrenches;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{TouchMotion, tangents, touch_motion};
use nalgebra::Vector3;

/// Gaps up to this part of the size of a pair touch: states between ends of steps have the error of the dense output.
const TOUCHED: f64 = 1e-7;
/// Gaps that open no faster than this stay closed, and slips that are no faster count as rest [m/s].
const AT_REST: f64 = 1e-7;

/// Works out the efforts of one state after another.
pub struct Exerted {
    elements: Elements,
    touching: Touching,
    mechanism: Mechanism,
    response: Response,
    state: State,
    /// One entry a degree of freedom, for the state above and these efforts of motors, with those that do the work of the contacts.
    efforts: Vec<f64>,
    /// The same of motors, friction and limits alone.
    in_joints: Vec<f64>,
    /// The wrenches of the contacts on the bodies.
    wrenches: Vec<BodyWrench>,
    /// The contacts at which there is no impact, as reports name them.
    points: Vec<ContactPoint>,
    /// The contacts of the state that is asked for next, if they are told, and whether points tell all that contacts of this mechanism exert.
    told: Option<Vec<ContactPoint>>,
    tell_all: bool,
    motors: Vec<f64>,
    /// Whether any state has been asked for.
    known: bool,
    free: Vec<f64>,
    /// Joints at rest that something can hold, and contacts.
    blocks: Vec<Block>,
}

impl Exerted {
    /// The workspace for a mechanism; `None` if it has neither motors nor friction nor limits nor anything that may touch.
    pub fn new(mechanism: &Mechanism) -> Option<Self> {
        (!mechanism.nonsmooth.is_empty()).then(|| {
            let (elements, touching) = (Elements::new(mechanism), Touching::new(mechanism));
            let tell_all = !touching.pairs.need_events();
            Exerted {
                touching,
                told: None,
                tell_all,
                mechanism: mechanism.clone(),
                response: Response::new(mechanism),
                state: State::zero(mechanism),
                efforts: vec![0.0; mechanism.velocity_count],
                in_joints: vec![0.0; mechanism.velocity_count],
                wrenches: vec![BodyWrench::default(); mechanism.bodies.len()],
                points: Vec::new(),
                motors: Vec::with_capacity(elements.motors.len()),
                known: false,
                free: vec![0.0; mechanism.velocity_count],
                blocks: Vec::with_capacity(elements.joints.len()),
                elements,
            }
        })
    }

    /// Takes the time of the states that follow (s).
    pub fn clock(&mut self, time: f64) {
        self.known &= self.state.time == time;
        self.state.time = time;
    }

    /// Takes the contacts of the states that follow, with their forces; `None` if they are to be worked out.
    pub fn touch(&mut self, points: Option<&[ContactPoint]>) {
        let points = points.filter(|_| self.tell_all);
        if self.told.as_deref() != points {
            self.told = points.map(<[ContactPoint]>::to_vec);
            self.known = false;
        }
    }

    /// The efforts at these positions and velocities, with the efforts of the motors: one entry a motor, or an empty slice if no motor drives; and
    /// the wrenches of the contacts on the bodies. Does not allocate while no joint is held and no bodies may touch.
    pub fn at(&mut self, position: &[f64], velocity: &[f64], motors: &[f64]) -> (&[f64], &[BodyWrench]) {
        let Exerted { elements, state, efforts, motors: before, known, blocks, .. } = self;
        // The efforts of the same state are kept.
        let same = state.position == position && state.velocity == velocity && before == motors;
        if std::mem::replace(known, true) && same {
            return (&self.efforts, &self.wrenches);
        }
        before.clear();
        before.extend_from_slice(motors);
        state.position.copy_from_slice(position);
        state.velocity.copy_from_slice(velocity);
        efforts.fill(0.0);
        for (motor, effort) in elements.motors.iter().zip(motors) {
            efforts[motor.coordinate.freedom] += effort;
        }
        blocks.clear();
        for (index, joint) in elements.joints.iter().enumerate() {
            let (freedom, rate) = (joint.coordinate.freedom, joint.rate(state));
            let side = joint.side(joint.position(state));
            if rate != 0.0 {
                efforts[freedom] -= joint.friction * rate.signum();
            } else if joint.friction > 0.0 || side.is_some() {
                blocks.push(Block::of_joint(index, freedom, efforts.len(), 1.0, joint.holding(side).into()));
            }
        }
        self.in_joints.copy_from_slice(&self.efforts);
        self.wrenches.fill(BodyWrench::default());
        self.points.clear();
        let points = self.told.as_ref().is_some_and(|points| !points.is_empty());
        let touches = points || !self.touching.pairs.is_empty();
        let bodies = if touches { body_states(&self.mechanism, &self.state) } else { Vec::new() };
        let contacts = if self.told.is_some() { Vec::new() } else { self.take_contacts(&bodies) };
        self.load(&bodies);
        if !self.blocks.is_empty() {
            self.share(&bodies, &contacts);
        }
        (&self.efforts, &self.wrenches)
    }

    /// The contacts of a state in which motors alone drive, in the order of their pairs; empty at an impact.
    pub fn contacts(mechanism: &Mechanism, state: &State) -> Vec<ContactPoint> {
        if mechanism.nonsmooth.pairs.is_empty() {
            return Vec::new();
        }
        let Some(mut exerted) = Exerted::new(mechanism) else { return Vec::new() };
        let effort = |motor: &Motor| {
            let at = motor.coordinate;
            motor.bounded(motor.effort(state.time, state.position[at.position], state.velocity[at.freedom]))
        };
        let motors: Vec<f64> = exerted.elements.motors.iter().map(effort).collect();
        exerted.clock(state.time);
        exerted.at(&state.position, &state.velocity, &motors);
        exerted.points
    }

    /// The part of the efforts that were asked for last that acts in joints: of motors, friction and limits.
    pub fn in_joints(&self) -> &[f64] {
        &self.in_joints
    }

    /// Adds the forces of contacts that are told to the efforts and wrenches, if there are any.
    fn load(&mut self, bodies: &[BodyState]) {
        let Exerted { mechanism, efforts, wrenches, told, .. } = self;
        let Some(points) = told.as_ref().filter(|points| !points.is_empty()) else { return };
        let nonsmooth = &mechanism.nonsmooth;
        for ContactPoint { pair, position, force, .. } in points {
            let Some(pair) = nonsmooth.pairs.with_number(*pair) else { continue };
            for (collider, sign) in [(pair.a, 1.0), (pair.b, -1.0)] {
                if let Some(body) = nonsmooth.colliders[collider].body {
                    wrenches[body].0 += sign * force;
                    wrenches[body].1 += sign * (position - bodies[body].position).cross(force);
                }
            }
        }
        let (mut on_subtrees, mut of_contacts) = (wrenches.clone(), vec![0.0; efforts.len()]);
        efforts_of_wrenches(mechanism, bodies, &mut on_subtrees, &mut of_contacts);
        efforts.iter_mut().zip(of_contacts).for_each(|(effort, own)| *effort += own);
    }

    /// The contacts that touch and do not part, as blocks after the blocks of the joints; without those that loops keep, which have no determinate force.
    fn take_contacts(&mut self, bodies: &[BodyState]) -> Vec<(Contact, TouchMotion)> {
        let pairs = &self.touching.pairs;
        let near = Near::within(pairs, bodies, |body| TOUCHED * pairs.reach_of(body));
        let touch = |&pair: &usize| self.touching.near(pair, bodies, pairs[pair].within(TOUCHED));
        let mut touching: Vec<Contact> = near.pairs().iter().flat_map(touch).map(|(contact, _)| contact).collect();
        touching.retain(|contact| touch_motion(&contact.joint, bodies).rate <= AT_REST);
        let kept = kept_by_loops(&self.mechanism, &mut self.response, &self.state, &touching, AT_REST);
        let mut contacts = Vec::new();
        for (contact, _) in touching.into_iter().zip(kept).filter(|(_, kept)| !kept) {
            let (of, touch) = (&self.touching.pairs[contact.pair], touch_motion(&contact.joint, bodies));
            let slides = (touch.slip.norm() > AT_REST).then(|| {
                let along = touch.slip.normalize();
                tangents(&touch.normal).map(|tangent| tangent.dot(&along))
            });
            let law = Law::of_contact(of.friction, slides);
            let rows = rows_of_contact(&self.mechanism, bodies, &contact.joint, of.friction > 0.0);
            self.blocks.push(Block { of: Of::Contact(contacts.len()), law, rows });
            let Turning { across, along } = Turning::of(&contact.joint, bodies, &touch.normal);
            let turning = Turning {
                across: if of.arm() * across.norm() > AT_REST { across } else { Vector3::zeros() },
                along: if of.arm() * along.abs() > AT_REST { along } else { 0.0 },
            };
            let (number, joint) = (contacts.len(), &contact.joint);
            self.blocks.extend(blocks_of_turning(&self.mechanism, bodies, joint, &of.moments, number, &turning));
            contacts.push((contact, touch));
        }
        contacts
    }

    /// Shares the holding forces among the blocks, and adds them to the efforts and wrenches.
    fn share(&mut self, bodies: &[BodyState], contacts: &[(Contact, TouchMotion)]) {
        let Exerted { elements, touching, mechanism, response, state, efforts, in_joints, .. } = self;
        let Exerted { wrenches, points, free, blocks, .. } = self;
        response.accelerations(state, efforts, free);
        let mut rows = Rows::of(response, state, blocks);
        let mut offset =
            second_rates(mechanism, elements, bodies, state, free, blocks, |contact| &contacts[contact].0.joint);
        let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
        if have_moments(blocks) {
            // The problem that follows has the loads of the last round.
            let _ = solve_with_moments(blocks, &mut rows.square, &mut offset, &laws, |problem| solve(problem, None));
        }
        let problem = Problem { mobility: &rows.square, free: &offset, laws: &laws };
        let forces = forces_apart(&problem, |part| match solve(part, None) {
            Ok(answer) if contacts.is_empty() => answer.forces,
            Ok(answer) => least_compliance(part, &answer),
            Err(Unsolved::Stopped { best }) => best.forces,
            Err(_) => vec![0.0; part.free.len()],
        });
        let mut first = 0;
        for block in &*blocks {
            for (row, force) in block.rows.iter().zip(&forces[first..]) {
                efforts.iter_mut().zip(row.iter()).for_each(|(effort, row)| *effort += row * force);
            }
            if let Of::Joint(index) = block.of {
                in_joints[elements.joints[index].coordinate.freedom] += forces[first];
            }
            if let Of::Contact(index) = block.of {
                let (contact, touch) = &contacts[index];
                let [along, across] = tangents(&touch.normal);
                let directions = [touch.normal, along, across];
                let force: Vector3<f64> =
                    directions.iter().zip(&forces[first..first + block.rows.len()]).map(|(d, f)| d * *f).sum();
                if touch.rate >= -AT_REST {
                    points.push(touching.reported(contact, touch, &force, touch.slip.norm() <= AT_REST));
                }
                if contact.joint.is_reeved() {
                    add_pulls(&contact.joint, bodies, forces[first], wrenches);
                }
                let ends = [(contact.joint.a.body, -1.0), (contact.joint.b.body, 1.0)];
                for (end, sign) in ends.into_iter().filter(|_| !contact.joint.is_reeved()) {
                    if let Some(body) = end {
                        wrenches[body].0 += sign * force;
                        wrenches[body].1 += sign * (touch.point - bodies[body].position).cross(&force);
                    }
                }
            }
            if let Of::Moment { contact, spinning } = block.of {
                let (Contact { joint, .. }, touch) = &contacts[contact];
                let [along, across] = tangents(&touch.normal);
                let (one, other) = (forces[first + 1], forces[first + 2]);
                let torque = if spinning { touch.normal * one } else { along * one + across * other };
                for (end, sign) in [(joint.a.body, -1.0), (joint.b.body, 1.0)] {
                    end.into_iter().for_each(|body| wrenches[body].1 += sign * torque);
                }
            }
            first += block.rows.len();
        }
    }
}
