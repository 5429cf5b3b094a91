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
//! The method has first order and no rebounds; the energy that they would have given back is told. Its steps have a tenth of a millisecond, and up to
//! a millisecond in crowds that last. A step that would gain energy has its velocities scaled down. The energy that it loses beside the work of
//! motors counts as lost in impacts.
//!
//! Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988); M. Jean, The non-smooth contact dynamics method,
//! Computer Methods in Applied Mechanics and Engineering 177 (1999).

use crate::events::closing::{Bearing, Closing, Pressed, impulses_among, limits_in, pressed_in};
use crate::events::effects::omitted_flights::probe_velocities;
use crate::events::effects::resting::{energy, work_of_forces};
use crate::events::finding::speeds::{speed_at, speed_of};
use crate::events::integrator::Eventful;
use crate::instant::cone::bounded::minimise;
use crate::instant::cone::problem::Law;
use crate::instant::holding::blocks::{Block, Of, Row, Rows, row_of_freedom, rows_of_contact};
use crate::instant::holding::elements::inward;
use crate::instant::holding::moments::{Turning, blocks_of_turning};
use crate::instant::holding::per_pair::PerPair;
use crate::instant::holding::touching::Contact;
use crate::instant::start::assembly::assemble;
use crate::mechanism::description::body_state::WORLD;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::distance::distance;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;

/// A step that gains more than this part of the kinetic energy is scaled.
const GAIN: f64 = 1e-14;
/// This many closed contacts add the cost of about one step.
const CONTACTS_A_STEP: usize = 4;
/// The most rounds in which contacts that have pressed are put onto each other.
const LANDINGS: usize = 4;
/// The rounds end when the gaps are at most this part of the size of their pair. Contacts that are farther apart than `NEAR` of it have parted.
const LANDED: f64 = 1e-13;
const NEAR: f64 = 1e-4;
/// A limit is reached if its gap is at most this many times the gap that counts as being on it.
const NEARLY: f64 = 100.0;

/// Points move in a step by at most this many times the distance that they would move at the rates of its start.
const MOVES: f64 = 1.25;
/// Rounds in which pairs are added that come near because others push them.
const WIDENED: usize = 4;
/// A step in which a body could pass through another is made shorter this often at most.
const SHORTENED: usize = 4;
/// A step in which it moves by this part of the size of the pair is short enough, however thin the shapes are.
const THIN: f64 = 1e-3;

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

/// What was seen of a pair.
struct Looked {
    pair: usize,
    /// Its distance (m), and whether that is near enough.
    distance: f64,
    near: bool,
}

impl Eventful {
    /// Whether steps between events are too frequent and too short for the run to advance, or the scheme has no mode to step in.
    pub(super) fn is_crowded(&mut self, state: &State) -> bool {
        if self.progress.undecided {
            self.progress.crowding.fail(state.time);
            return true;
        }
        // Given steps may be short without any event.
        let chosen = self.model.recipe.tolerance().is_some();
        let work = if chosen { 1 + self.mode.contacts.len() / CONTACTS_A_STEP } else { 1 };
        let bearable = self.bearable_labour();
        let may = !self.model.touching.pairs.is_empty() && !self.model.recipe.keeps(Rule::Crowds);
        may && self.progress.crowding.count(state.time, work, bearable)
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
        let jammed = self.progress.crowding.is_jammed();
        let longer = if jammed { self.model.coarser } else { 1.0 };
        let mut step = (longer * self.progress.crowding.length()).min(until - start.time);
        let mut rounds = 0;
        let Pushed { pressed, limits, near, rebounds, driven, .. } = loop {
            let pushed = self.pushed(step, &start, &free, &mut state.velocity);
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
        let _ = assemble(&self.model.whole, state);
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
        let impacts = self.bound(&start, state, work);
        let bodies = body_states(&self.model.whole, state);
        let distance = |&pair: &usize| self.model.touching.distance_within(pair, &bodies, 0.0);
        self.trial.overlap = near.iter().map(distance).fold(self.trial.overlap, |deepest, gap| deepest.max(-gap));
        let piece = self.workspaces.active_mut();
        piece.small = piece.moving.gather(&self.model.whole, state);
        self.tally.steps += 1;
        self.tally.stepped += step;
        StepOutcome::new(step, 1, Exchange { work, impacts, ..Exchange::default() })
    }

    /// The speed by which bodies may move otherwise within a step of first order [m/s]: its pushes are those of its end, and may be those of its start, so
    /// that the motion is in doubt by what forces without contacts change in it.
    fn speed_in_doubt(&self, start: &State, free: &[f64], step: f64) -> f64 {
        let whole = &self.model.whole;
        let falling = start.velocity.iter().zip(free).map(|(rate, acceleration)| rate + step * acceleration).collect();
        let falling = State { velocity: falling, ..start.clone() };
        distance(&probe_velocities(whole, start), &probe_velocities(whole, &falling))
    }

    /// Rebounds that a step leaves out, and the energy that they would give back, `½ e² P |γ⁻|` each (J). An impact slower than the fall in one step
    /// has no rebound.
    fn left_out(
        &self,
        blocks: &[Block],
        sides: &[Option<Side>],
        contacts: &[Contact],
        impulses: &[f64],
        before: &[f64],
    ) -> (usize, f64) {
        let slow = 2.0 * self.progress.crowding.length() * self.model.whole.gravity.norm();
        let (mut row, mut count, mut sum) = (0, 0, 0.0);
        for (block, side) in blocks.iter().zip(sides) {
            let restitution = match (block.of, side) {
                (Of::Joint(joint), Some(_)) => self.model.elements.joints[joint].restitution,
                (Of::Joint(_), None) | (Of::Moment { .. }, _) => 0.0,
                (Of::Contact(contact), _) => self.model.touching.pairs[contacts[contact].pair].restitution,
            };
            if restitution > 0.0 && impulses[row] > 0.0 && before[row] < -slow {
                (count, sum) = (count + 1, sum - 0.5 * restitution.powi(2) * impulses[row] * before[row]);
            }
            row += block.rows.len();
        }
        (count, sum)
    }

    /// Blocks that may close or hold in a step of this length from a state, for velocities without it, and their gaps (m or rad). Pairs as far from
    /// each other as `wider` (m) are among them. Returns also what was seen of each pair.
    fn closing_within(
        &mut self,
        step: f64,
        start: &State,
        velocity: &[f64],
        wider: &PerPair<f64>,
    ) -> (Closing, Vec<Looked>) {
        let Closing { mut blocks, mut gaps, mut contacts, mut sides } = Closing::default();
        for (index, joint) in self.model.elements.joints.iter().enumerate() {
            let freedom = joint.coordinate.freedom;
            let mut add = |bounds: [f64; 2], side: Option<Side>, gap: f64| {
                blocks.push(Block::of_joint(index, freedom, velocity.len(), side.map_or(1.0, inward), bounds));
                gaps.push(gap);
                sides.push(side);
            };
            if joint.friction > 0.0 {
                let most = step * joint.friction;
                add([-most, most], None, 0.0);
            }
            for side in joint.sides() {
                let gap = joint.gap(side, joint.position(start));
                // One that bears may be pushed by contacts alone.
                let bears = gap <= joint.at_limit(side);
                if bears || gap + step * inward(side) * velocity[freedom] < 0.0 {
                    add([0.0, f64::INFINITY], Some(side), gap);
                }
            }
        }
        let bodies = body_states(&self.model.whole, start);
        self.look_ahead(&bodies, |body, reach| {
            let fastest = bodies[body].velocity.norm() + bodies[body].angular_velocity.norm() * reach;
            2.0 * step * fastest + 5.0 * step * step
        });
        let mut seen = Vec::with_capacity(self.trial.near.pairs().len());
        for &pair in self.trial.near.pairs() {
            let of = &self.model.touching.pairs[pair];
            let ends = of.parts.iter().flat_map(|(bodies, reach)| bodies.iter().zip(reach));
            let speed = ends.filter_map(|(body, reach)| {
                let state = &bodies[(*body)?];
                Some(state.velocity.norm() + state.angular_velocity.norm() * reach.min(of.size()))
            });
            let within =
                (2.0 * step * speed.sum::<f64>() + 10.0 * step * step).max(wider.get(pair).copied().unwrap_or(0.0));
            let distance = self.model.touching.distance_within(pair, &bodies, within);
            seen.push(Looked { pair, distance, near: distance <= within });
            if distance > within {
                continue;
            }
            for (contact, gap) in self.model.touching.near(pair, &bodies, within) {
                let rows = rows_of_contact(&self.model.whole, &bodies, &contact.joint, of.friction > 0.0);
                let law = Law::of_contact(of.friction, None);
                blocks.push(Block { of: Of::Contact(contacts.len()), law, rows });
                let (number, whole) = (contacts.len(), &self.model.whole);
                let still = Turning::default();
                blocks.extend(blocks_of_turning(whole, &bodies, &contact.joint, &of.moments, number, &still));
                gaps.push(gap);
                gaps.resize(blocks.len(), 0.0);
                contacts.push(contact);
                sides.resize(blocks.len(), None);
            }
        }
        (Closing { blocks, gaps, contacts, sides }, seen)
    }

    /// Adds the free accelerations, and the impulses of all blocks that may close in a step, to velocities at its start. A pair that was far may come
    /// near because others push it: it is then looked at as well.
    fn pushed(&mut self, step: f64, start: &State, free: &[f64], velocity: &mut [f64]) -> Pushed {
        let mut wider: PerPair<f64> = PerPair::default();
        let mut round = 0;
        loop {
            for ((rate, before), acceleration) in velocity.iter_mut().zip(&start.velocity).zip(free) {
                *rate = before + step * acceleration;
            }
            let (Closing { blocks, gaps, contacts, sides }, seen) = self.closing_within(step, start, velocity, &wider);
            let (mut pressed, mut limits, mut rebounds, mut driven) = (Vec::new(), Vec::new(), (0, 0.0), 0.0);
            if !blocks.is_empty() {
                let rows = Rows::of(&mut self.workspaces.response, start, &blocks);
                let mut rates = rows.rates(velocity);
                let mut row = 0;
                for (block, gap) in blocks.iter().zip(&gaps) {
                    rates[row] += gap / step;
                    row += block.rows.len();
                }
                let impulses = impulses_among(&rows, &rates, &blocks);
                rows.add(&impulses, velocity);
                driven = rows.work_of_belts(&impulses);
                let before = rows.rates(&start.velocity);
                rebounds = self.left_out(&blocks, &sides, &contacts, &impulses, &before);
                pressed = pressed_in(&blocks, &gaps, &contacts, &impulses);
                limits = limits_in(&blocks, &gaps, &sides, &impulses);
            }
            let moving = body_states(&self.model.whole, &State { velocity: velocity.to_vec(), ..start.clone() });
            let (mut part, mut widened) = (1.0_f64, false);
            for &Looked { pair, distance, near } in &seen {
                let of = &self.model.touching.pairs[pair];
                let moves = MOVES * step * speed_of(of, &moving);
                if near {
                    let through = of.breadth.max(THIN * of.size());
                    part = part.min(if moves > through { 0.5 * through / moves } else { 1.0 });
                } else if distance <= moves {
                    (*wider.of(pair), widened) = (moves, true);
                }
            }
            // Pairs that were left out may come near because others push them.
            let begins = body_states(&self.model.whole, start);
            widened |= self.look_ahead(&begins, |body, reach| {
                MOVES * step * speed_at([moving[body], WORLD], [reach, f64::INFINITY])
            });
            if !widened || round == WIDENED {
                let near = seen.iter().filter(|looked| looked.near).map(|looked| looked.pair).collect();
                return Pushed { pressed, limits, near, rebounds, driven, part };
            }
            round += 1;
        }
    }

    /// Puts contacts that have pressed in a step onto each other, and joints onto the limits that have borne them, by the least motion. Their
    /// velocities are projected as well: held contacts hold still, and sliding ones keep a normal rate of zero. Normals turn in a step, and a
    /// remaining gap would fall back in the next step as an impact.
    fn land(&mut self, pressed: &[Pressed], limits: &[Bearing], state: &mut State) {
        let joints = &self.model.elements.joints;
        let limit_gap = |limit: &Bearing, state: &State| {
            let joint = &joints[limit.joint];
            joint.gap(limit.side, joint.position(state))
        };
        let limit_row = |limit: &Bearing, count: usize| {
            row_of_freedom(count, joints[limit.joint].coordinate.freedom, inward(limit.side))
        };
        let of = |pressed: &Pressed| &self.model.touching.pairs[pressed.contact.pair];
        for _ in 0..LANDINGS {
            let bodies = body_states(&self.model.whole, state);
            let gap = |pressed: &&Pressed| touch_motion(&pressed.contact.joint, &bodies).gap;
            let near = |pressed: &&Pressed| gap(pressed).abs() <= of(pressed).within(NEAR);
            let landing: Vec<&Pressed> = pressed.iter().filter(near).collect();
            let mut gaps: Vec<f64> = landing.iter().map(gap).collect();
            let landed = landing.iter().zip(&gaps).all(|(pressed, gap)| gap.abs() <= of(pressed).within(LANDED));
            let on_limit = |limit: &Bearing| limit_gap(limit, state).abs() <= joints[limit.joint].at_limit(limit.side);
            if landed && limits.iter().all(on_limit) {
                break;
            }
            let normal =
                |pressed: &&Pressed| rows_of_contact(&self.model.whole, &bodies, &pressed.contact.joint, false);
            let mut rows: Vec<Row> = landing.iter().flat_map(normal).collect();
            rows.extend(limits.iter().map(|limit| limit_row(limit, state.velocity.len())));
            gaps.extend(limits.iter().map(|limit| limit_gap(limit, state)));
            let rows = Rows::new(&mut self.workspaces.response, state, rows);
            let mut change = vec![0.0; state.velocity.len()];
            rows.add(&pull(&rows, &gaps), &mut change);
            state.displace(&self.model.whole, &change);
            let _ = assemble(&self.model.whole, state);
        }
        let bodies = body_states(&self.model.whole, state);
        let closed = pressed.iter().filter(|pressed| {
            let now = touch_motion(&pressed.contact.joint, &bodies).gap.abs();
            pressed.gap.abs().max(now) <= of(pressed).closed_anew()
        });
        let rows = closed
            .flat_map(|pressed| rows_of_contact(&self.model.whole, &bodies, &pressed.contact.joint, pressed.holds));
        let mut rows: Vec<Row> = rows.collect();
        let bears = |limit: &&Bearing| limit.gap <= joints[limit.joint].at_limit(limit.side);
        rows.extend(limits.iter().filter(bears).map(|limit| limit_row(limit, state.velocity.len())));
        if !rows.is_empty() {
            let rows = Rows::new(&mut self.workspaces.response, state, rows);
            rows.add(&pull(&rows, &rows.rates(&state.velocity)), &mut state.velocity);
        }
        for limit in limits {
            let joint = &joints[limit.joint];
            if limit_gap(limit, state).abs() <= NEARLY * joint.at_limit(limit.side) {
                joint.put_on(limit.side, state);
            }
            if bears(&limit) {
                state.velocity[joint.coordinate.freedom] = 0.0;
            }
        }
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
}

/// The efforts along rows that bring these values of them to zero, with the least change of the vector that the rows act on.
fn pull(rows: &Rows, values: &[f64]) -> Vec<f64> {
    minimise(&rows.square, values, &vec![(f64::NEG_INFINITY, f64::INFINITY); values.len()]).efforts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::modes::mode::JointMode;
    use crate::events::parts::crowding::STEP;
    use crate::mechanism::description::closure::{Coordinate, JointLimit};
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::{Body, Mechanism};
    use crate::mechanism::motion::integrator::Integrator;
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
        let mut eventful =
            Eventful::new(mechanism, Recipe { steps, kept: Vec::new(), asked_for: false }).expect("possible steps");
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
        assert!(after >= 0.9 * STEP, "{after:e}");
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
