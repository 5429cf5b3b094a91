//! First-order time stepping, used where events crowd or no step of the scheme can be solved, so that a run always continues.
//!
//! ```text
//!     v_f = v₀ + h a(q₀, v₀)                       under all forces, motors and inputs; without what follows
//!     v̄  = v_f + Y Wᵀ P,   u = D P + W v_f
//!     limits and contacts:   0 ≤ P_N ⊥ u_N + φ/h ≥ 0      for all that may close in the step, plastic, within Coulomb's cone
//!     friction of joints:    |P| ≤ h τ_f;    rolling and spinning friction: within ρ P_N and σ P_N
//!     q̄  = q₀ + h v̄,  on closures, within limits and out of overlaps by the least motion
//! ```
//!
//! The method has first order and no rebounds; the energy that they would have given back is told. Its steps have a microsecond in
//! the place of one that cannot be made, a tenth of a millisecond in crowds, and up to a millisecond in crowds that last. A step that would gain energy has its velocities scaled down. The energy that it loses beside the work of
//! motors counts as lost in impacts.
//!
//! Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988); M. Jean, The non-smooth contact dynamics method,
//! Computer Methods in Applied Mechanics and Engineering 177 (1999).

use crate::events::closing::{Bearing, Pressed};
use crate::events::crowded::LENGTHS;
use crate::events::effects::omitted_flights::probe_velocities;
use crate::events::effects::resting::{energy, work_of_forces};
use crate::events::integrator::Eventful;
use crate::events::parts::spending::Patience;
use crate::events::price::CHEAP;
use crate::instant::start::assembly::assemble_nearby;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::distance::distance;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// A step that gains more than this part of the kinetic energy is scaled.
const GAIN: f64 = 1e-14;

/// Dampers with time constants below half of this (s) make joints that creep stop and slip, and limits bear and release, without an end.
const HARD: f64 = 1e-4;

/// A step in which a body could pass through another is made shorter this often at most.
const SHORTENED: usize = 4;

mod landing;
mod pushing;

/// Contacts and limits that have pressed in a step of first order.
struct Pushed {
    pressed: Vec<Pressed>,
    limits: Vec<Bearing>,
    /// The pairs that were near enough to be looked at.
    near: Vec<usize>,
    /// Number of rebounds that are left out, and the energy that they would give back (J).
    rebounds: (usize, f64),
    /// The work of driven surfaces (J).
    driven: f64,
    /// The part of its length that the step may have, so that no pair passes through each other.
    part: f64,
}

impl Eventful {
    /// Whether steps between events are too frequent and too short for the run to advance, or the scheme has no mode to step in.
    pub(super) fn is_crowded(&mut self, state: &State) -> bool {
        self.progress.jams.pass();
        if self.progress.undecided {
            // Most are over in a moment; those that last are left by longer and longer steps.
            self.jam(state.time);
            return true;
        }
        if self.model.recipe.keeps(Rule::Crowds) {
            return false;
        }
        let is_mechanism = self.model.touching.pairs.is_empty();
        let dear = self.progress.spending.rate(state.time, Patience::Short) > CHEAP;
        self.progress.chatters = is_mechanism && dear && self.overshoots(state, HARD);
        (!is_mechanism || self.progress.chatters) && self.are_exact_steps_too_dear(state.time)
    }

    /// A step that begins at a time (s) could not be made.
    pub(super) fn jam(&mut self, time: f64) {
        self.progress.jams.jam(time, LENGTHS[0]);
    }

    /// Begins a step of first order at a time (s), which is a crowd of its own unless it passes a jam; returns its length (s).
    pub(super) fn begin_first_order(&mut self, time: f64) -> f64 {
        let is_crowd = self.progress.jams.next().is_none();
        if is_crowd {
            self.progress.spells.enter(time);
        }
        let length = self.first_order_length();
        if is_crowd {
            self.progress.spells.leave(time + length);
        }
        length
    }

    /// The length of a step of first order (s).
    pub(super) fn first_order_length(&self) -> f64 {
        self.progress.jams.next().unwrap_or_else(|| self.length_in_spells())
    }

    /// Makes one such step towards `until` from the start of the step that failed.
    pub(super) fn stumble(&mut self, inputs: Inputs, state: &mut State, until: f64) -> StepOutcome {
        let start = self.trial.origin.clone();
        state.copy_from(&start);
        if let Some(outcome) = self.enter_crowd(inputs, state, until) {
            return outcome;
        }
        let efforts = self.mode.driving_efforts(&self.model.elements, inputs, state);
        let mut free = vec![0.0; self.model.whole.velocity_count];
        self.workspaces.response.accelerations(state, &efforts, &mut free);
        let jammed = self.progress.jams.next().is_some();
        let longer = if jammed { self.model.coarser } else { 1.0 };
        let mut step = (longer * self.begin_first_order(start.time)).min(until - start.time);
        let mut rounds = 0;
        let Pushed { pressed, limits, near, rebounds, driven, .. } = loop {
            let pushed = self.pushed(step, &start, &free, &mut state.velocity, rounds == SHORTENED);
            // Short enough that no body passes through another.
            if pushed.part >= 1.0 || rounds == SHORTENED {
                break pushed;
            }
            (step, rounds) = (step * pushed.part, rounds + 1);
        };
        self.tally.leave_out(rebounds.0, rebounds.1, &self.model.whole, &start);
        let moved: Vec<f64> = state.velocity.iter().map(|rate| step * rate).collect();
        let moving = State { velocity: state.velocity.clone(), ..start.clone() };
        self.tally.smeared[1] += if jammed { step } else { 0.0 };
        self.tally.left_of_steps += step * self.speed_in_doubt(&start, &free, step);
        let loads = work_of_forces(&self.model.whole, &moving, step);
        state.displace(&self.model.whole, &moved);
        state.time = start.time + step;
        // If it fails, closures stay open by the error of a step of first order.
        let wanted = state.velocity.clone();
        let _ = assemble_nearby(&self.model.whole, state);
        if !state.velocity.iter().all(|rate| rate.is_finite()) {
            state.velocity = wanted;
        }
        self.land(&pressed, &limits, state);
        let work = loads + driven + efforts.iter().zip(&moved).map(|(effort, moved)| effort * moved).sum::<f64>();
        self.bound(&start, state, work);
        self.tally.first_order = (self.tally.first_order.0 + 1, self.tally.first_order.1 + step);
        self.see_jump(&start, state);
        self.progress.stepped_over = Some(state.clone());
        self.previous.outside.clear();
        self.previous.outside.extend_from_slice(inputs.efforts);
        let events = self.tally.events.len();
        self.pass_anew(inputs, state);
        self.tally.events.truncate(events);
        // Closed contacts have been moved, which must not gain energy either.
        let lost = self.bound(&start, state, work);
        let bodies = body_states(&self.model.whole, state);
        let distance = |&pair: &usize| self.model.touching.distance_within(pair, &bodies, 0.0);
        self.trial.overlap = near.iter().map(distance).fold(self.trial.overlap, |deepest, gap| deepest.max(-gap));
        let piece = self.workspaces.active_mut();
        piece.small = piece.moving.gather(&self.model.whole, state);
        self.tally.steps += 1;
        self.tally.stepped += step;
        StepOutcome::new(step, 1, self.exchange_of_balance(work, lost))
    }

    /// Whether a step of first order under the dampers, springs and motors of its start reverses what they damp: `h (D + h K) Y > 2` along a freedom.
    /// Steps over events have these forces at their ends.
    pub(super) fn overshoots(&mut self, state: &State, step: f64) -> bool {
        let dampers = self.model.whole.forces.joint_dampers.iter().map(|damper| (damper.freedom, damper.coefficient));
        let motors = self.model.elements.motors.iter().filter(|motor| motor.period == 0.0).map(|motor| {
            let (stiffness, damping) = motor.law.gains();
            (motor.coordinate.freedom, damping + step * stiffness)
        });
        let (freedoms, slopes): (Vec<usize>, Vec<f64>) = dampers.chain(motors).unzip();
        let answers = self.workspaces.response.diagonal(state, freedoms.into_iter());
        answers.iter().zip(slopes).any(|(answer, slope)| step * slope * answer > 2.0)
    }

    /// The speed by which bodies may move otherwise within a step of first order [m/s]: its pushes are those of its end, and may be those of its start, so
    /// that the motion is in doubt by what forces without contacts change in it.
    fn speed_in_doubt(&self, start: &State, free: &[f64], step: f64) -> f64 {
        let whole = &self.model.whole;
        let falling = start.velocity.iter().zip(free).map(|(rate, acceleration)| rate + step * acceleration).collect();
        let falling = State { velocity: falling, ..start.clone() };
        distance(&probe_velocities(whole, start), &probe_velocities(whole, &falling))
    }

    /// Takes the energy that a step has gained beside the work (J) from the velocities; returns the energy that it has lost (J).
    pub(super) fn bound(&self, start: &State, end: &mut State, work: f64) -> f64 {
        let (before, after) = (energy(&self.model.whole, start), energy(&self.model.whole, end));
        let gained = after.total() - before.total() - work;
        // Joints that are moved in time keep their rates, whatever energy that takes.
        if gained > GAIN * after.kinetic && after.kinetic > 0.0 && !self.model.whole.moves_joints() {
            let factor = ((after.kinetic - gained) / after.kinetic).max(0.0).sqrt();
            end.velocity.iter_mut().for_each(|rate| *rate *= factor);
        }
        before.total() + work - energy(&self.model.whole, end).total()
    }

    /// The exchange of a step with this work of motors and loads that has lost this energy (J). Joints that are moved in time do work that the
    /// balance alone tells: what the step gains is theirs.
    pub(super) fn exchange_of_balance(&self, work: f64, lost: f64) -> Exchange {
        let given = if self.model.whole.moves_joints() { (-lost).max(0.0) } else { 0.0 };
        Exchange { work: work + given, impacts: lost + given, ..Exchange::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::modes::mode::JointMode;
    use crate::mechanism::description::closure::{Coordinate, JointLimit};
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::{Body, Mechanism};
    use crate::mechanism::motion::event::Side;
    use crate::mechanism::motion::integrator::Integrator;
    use crate::mechanism::motion::touches::touch_motion;
    use crate::stepping::length::stage_choice::StageChoice;
    use crate::stepping::recipe::{Recipe, Steps};
    use crate::stepping::step_maker::StepPace;
    use nalgebra::Vector3;

    /// Bodies under gravity, of which the first has a shape that may touch a floor.
    fn over_floor(bodies: Vec<Body>, shape: Shape, friction: f64, restitution: f64) -> Mechanism {
        let mut mechanism = Mechanism::new("loose", Vector3::z() * -9.81, bodies).expect("bodies that move");
        let nonsmooth = &mut mechanism.nonsmooth;
        for (body, shape) in [(Some(0), shape), (None, Shape::HalfSpace)] {
            nonsmooth.colliders.push(Collider::still("one", body, Pose::identity(), shape));
        }
        nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], friction, restitution));
        mechanism
    }

    /// A run of it with chosen steps that makes no steps over events.
    fn without_crowds(mechanism: &Mechanism) -> Eventful {
        let steps = Steps::Chosen { tolerance: 1e-6, stop: 1e-10, stages: StageChoice::Many };
        let mut eventful = Eventful::new(mechanism, Recipe::new(steps, Vec::new())).expect("possible steps");
        eventful.workspaces.crowd = None;
        eventful
    }

    const CUBE: Shape = Shape::Box { half: Vector3::new(0.1, 0.1, 0.1) };

    /// A cube of 0.2 m.
    fn cube() -> Body {
        let joint = Joint::new("box", JointKind::Floating, Pose::identity(), Pose::identity());
        Body { name: "box".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(0.01 / 1.5), joint }
    }

    /// The cube, turned by an angle (rad) about y, goes round its lower edge at a rate [rad/s].
    fn on_edge(mechanism: &Mechanism, angle: f64, spin: f64) -> State {
        let turned = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle);
        let arm = turned * Vector3::new(-0.1, 0.0, 0.1);
        let mut state = State::zero(mechanism);
        state.position[..3].copy_from_slice(arm.as_slice());
        state.position[3..7].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
        state.velocity[..3].copy_from_slice((Vector3::y() * spin).cross(&arm).as_slice());
        state.velocity[4] = spin;
        state
    }

    #[test]
    fn steps_that_have_failed_do_not_leave_their_length_to_those_after_the_one_that_stands_for_them() {
        // A ball in the air over a floor.
        let joint = Joint::new("ball", JointKind::Floating, Pose::identity(), Pose::identity());
        let body = Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(4e-3), joint };
        let mechanism = over_floor(vec![body], Shape::Sphere { radius: 0.1 }, 0.5, 0.0);
        let mut eventful = without_crowds(&mechanism);
        let mut state = State::zero(&mechanism);
        state.position[2] = 100.0;
        let inputs = Inputs::constant(&[0.0; 6]);
        eventful.step(&mechanism, inputs, &mut state, 1e-3).expect("a step");
        // As short as a step is when it is given up.
        let piece = &mut eventful.workspaces.pieces[eventful.workspaces.current];
        let pace = StepPace::Step { length: 1e-14, kinetic: 1.0 };
        piece.steps.as_mut().expect("a body that moves").keep_pace(pace, state.time);
        piece.small.position[2] += 1e-9;
        let short = eventful.step(&mechanism, inputs, &mut state, 1.0).expect("a step").step;
        assert!(short > 0.0 && short < 1e-13, "{short:e}");
        eventful.trial.origin.copy_from(&state);
        eventful.stumble(inputs, &mut state, 1.0);
        eventful.previous.left = Some(state.clone());
        let after = eventful.step(&mechanism, inputs, &mut state, 1.0).expect("a step").step;
        assert!(after >= 0.9 * LENGTHS[0], "{after:e}");
    }

    #[test]
    fn an_edge_about_which_a_box_turns_neither_leaves_the_floor_nor_slides_in_a_step_of_first_order() {
        let mechanism = over_floor(vec![cube()], CUBE, 1.0, 0.3);
        let mut eventful = without_crowds(&mechanism);
        // Turned by 0.3 rad about y, over an edge that the centre of mass goes round at 2 rad/s.
        let (angle, spin) = (0.3_f64, 2.0);
        let mut state = on_edge(&mechanism, angle, spin);
        let inputs = Inputs::constant(&[0.0; 6]);
        eventful.begin(&mechanism, inputs, &mut state).expect("a start");
        assert_eq!(eventful.mode.contacts.len(), 2);
        for _ in 0..20 {
            eventful.trial.origin.copy_from(&state);
            eventful.stumble(inputs, &mut state, 1.0);
            let bodies = body_states(&mechanism, &state);
            let touches: Vec<_> =
                eventful.mode.contacts.iter().map(|closed| touch_motion(&closed.contact.joint, &bodies)).collect();
            assert_eq!(touches.len(), 2, "at {}", state.time);
            for touch in touches {
                assert!(touch.gap.abs() <= 1e-13 && touch.slip.norm() <= 1e-13, "at {}: {touch:?}", state.time);
            }
        }
    }

    #[test]
    fn a_joint_that_bears_on_its_limit_stays_there_in_a_step_of_first_order() {
        // A box about whose edge it turns, and on it a flap that leans on its limit.
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
        let frame = |x: f64, z: f64| Pose::from_parts(nalgebra::Translation3::new(x, 0.0, z), turn);
        let joint = Joint::new("flap", JointKind::Revolute, frame(0.1, 0.1), frame(-0.2, 0.0));
        let flap = Body { name: "flap".into(), parent: Some(0), mass: 0.2, inertia: Vector3::repeat(1e-4), joint };
        let mut mechanism = over_floor(vec![cube(), flap], CUBE, 1.0, 0.0);
        let hinge = &mechanism.bodies[1].joint;
        let coordinate = Coordinate { body: 1, position: hinge.position_index, freedom: hinge.velocity_index };
        mechanism.nonsmooth.limits.push(JointLimit { coordinate, lower: -1.0, upper: 0.0, restitution: 0.0 });
        let mut eventful = without_crowds(&mechanism);
        let (angle, spin) = (0.1_f64, 1.0);
        let mut state = on_edge(&mechanism, angle, spin);
        let inputs = Inputs::constant(&[0.0; 7]);
        eventful.begin(&mechanism, inputs, &mut state).expect("a start");
        assert_eq!(eventful.mode.joints[0], JointMode::Held { on: Some(Side::Upper) });
        for _ in 0..20 {
            eventful.trial.origin.copy_from(&state);
            eventful.stumble(inputs, &mut state, 1.0);
            let [place, rate] = [state.position[coordinate.position], state.velocity[coordinate.freedom]];
            assert_eq!([place, rate], [0.0; 2], "at {}", state.time);
            assert_eq!(eventful.mode.joints[0], JointMode::Held { on: Some(Side::Upper) }, "at {}", state.time);
        }
    }
}
