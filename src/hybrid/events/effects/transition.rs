//! Carries out an event: the state is put on it to the last bit, limits and contacts that are met give their impulses, and the elements at rest are
//! decided anew.
//!
//! ```text
//!     1. φ = 0 exactly: a position on its bound, a rate that is zero
//!     2. impacts on all limits and contacts that are met                        contacts.rs, impact.rs
//!        motors whose efforts jump with the rates beyond their bounds, or back
//!     3. joints and contacts at rest: held or let go, all together              decision.rs
//! ```
//!
//! An element whose impacts follow each other ever faster comes to rest at `t∞ = t_k + T_k/(1 − ρ)`, with the flight `T_k` that would follow and the
//! ratio ρ of two impacts. The impact is plastic if the greatest remaining height, `γ⁺²/(2 g)` with `g = 2 γ⁺/T`, is too small to matter.

use crate::events::effects::blocked::blocked;
use crate::events::effects::brakes::Brake;
use crate::events::effects::contacts::Contacts;
use crate::events::effects::deciding::decide;
use crate::events::effects::decision::{Scene, Undecided, Yielding};
use crate::events::effects::gathering::{Gathered, cut_in_crowd, gather_meetings};
use crate::events::effects::immobile::{at_dead_points, idle_pairs};
use crate::events::effects::impact::{Impulses, Meeting, collide, holding_impulses};
use crate::events::effects::low_rebounds::{bring_low_to_rest, unseen_flight};
use crate::events::effects::memory::{Done, Found, Memory};
use crate::events::effects::noted::{Met, note_bound, note_impacts, note_joints, note_pairs, note_seized};
use crate::events::effects::omitted_flights::{change_of_speed, speed_in_doubt};
use crate::events::effects::resting::{bring_rows_to_rest, energy, joints_at_rest, keep_from_gaining};
use crate::events::effects::seams::held_seams;
use crate::events::effects::seizing::Seized;
use crate::events::effects::stopped::stop_roundings;
use crate::events::effects::unpressed::unpressed;
use crate::events::finding::watched::{Watched, unbounded};
use crate::events::modes::mode::{JointMode, Mode, MotorMode};
use crate::events::modes::tolerances::{BEYOND_LIMIT, rate_at_rest};
use crate::instant::cone::problem::ROUGH;
use crate::instant::holding::blocks::{Of, Row, row_of_freedom};
use crate::instant::holding::elements::Elements;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::state::State;

/// Rounds in which limits that kick each other open are brought to rest.
const CALMING: usize = 8;

/// Points that are added to flat ends, at most.
const COMPLETING: usize = 48;

/// Carries out an event; `efforts` writes the efforts from outside and of motors for a mode and state.
pub(crate) fn transit(
    scene: &mut Scene,
    mode: &mut Mode,
    state: &mut State,
    memory: &mut Memory,
    found: &Found,
    mut efforts: impl FnMut(&Mode, &State) -> Vec<f64>,
) -> Done {
    let elements = scene.elements;
    let mut done = Done {
        joints: vec![false; elements.joints.len()],
        motors: vec![false; elements.motors.len()],
        ..Done::default()
    };
    let before = mode.clone();
    let yielding = Yielding::of(found.triggers);
    // In scenes with contacts, steps that do not look at a limit may go beyond it.
    let rests: Vec<f64> = memory.joints.iter().map(|joint| rate_at_rest(joint.fastest)).collect();
    let stopped = stop_joints(scene, state, found.triggers, &rests);
    let beyond =
        !scene.touching.pairs.is_empty() && found.triggers.iter().any(|trigger| is_beyond(elements, state, trigger));
    let before_it = if beyond { energy(scene.whole, state).total() } else { 0.0 };
    settle(elements, mode, state, found.triggers, &mut done);
    let settled = stopped + if beyond { keep_from_gaining(scene, state, before_it) } else { 0.0 };
    stop_slow_joints(elements, state, &rests, false);
    let mut contacts = Contacts::gather(scene, &before, state, found, memory.fastest);
    contacts.leave_out_kept(scene, state);
    let lifted = contacts.move_apart(scene, state);
    let velocity = state.velocity.clone();
    let Gathered { mut meetings, mut ends, mut left } = gather_meetings(scene, state, memory, found, &rests, &contacts);
    let brakes = Brake::all(scene, state, found.height);
    let mut collided = collide(scene, state, &meetings, &brakes);
    for round in 0..COMPLETING {
        let Ok(impulses) = &collided else { break };
        if !contacts.has_flat_ends() {
            break;
        }
        let first = meetings.len() - contacts.count();
        let after = std::mem::replace(&mut state.velocity, velocity.clone());
        let holding = holding_impulses(scene, state, &meetings[first..]);
        state.velocity = after;
        if !contacts.complete_impact(scene, state, &holding, &impulses.normal[first..], round) {
            break;
        }
        state.velocity.copy_from_slice(&velocity);
        Gathered { meetings, ends, left } = gather_meetings(scene, state, memory, found, &rests, &contacts);
        collided = collide(scene, state, &meetings, &brakes);
    }
    let failed = collided.is_err();
    let mut impulses = collided.unwrap_or_else(|_| bring_to_rest(scene, state, &meetings));
    done.unsolved += usize::from(failed || impulses.residual > 0.0);
    contacts.rest_below(impulses.rounding);
    let rates: Vec<f64> = meetings.iter().map(|meeting| meeting.rate(&velocity)).collect();
    done.left = left;
    done.cut = cut_in_crowd(scene, memory, state.time, &contacts, &meetings, &rates, &impulses);
    done.speed_in_doubt = speed_in_doubt(scene, memory, &contacts, (&meetings, &brakes), &velocity, state);
    if impulses.residual > 0.0 {
        done.speed_of_unsolved = impulses.residual * change_of_speed(scene, &velocity, state);
    }
    let known = |state: &State| efforts(mode, state);
    let (of, time) = ((scene.touching, &*memory, &contacts), state.time);
    let unseen = |pair: usize| unseen_flight(of, &meetings, &rates, time, pair);
    let height = |of: Of| contacts.pair_of(of).and_then(unseen).map_or(found.height, |gap| found.height.max(gap));
    let low = bring_low_to_rest(scene, state, (&meetings, &brakes), &mut impulses, &rates, known, height);
    (done.lost, done.driven) = (settled + lifted + impulses.lost, impulses.driven);
    done.left += low.iter().map(|low| low.height).sum::<f64>() + impulses.slides;
    let mut flights = ends.clone();
    flights.extend(low.into_iter().map(|low| {
        let of = meetings[low.index].block.of;
        (contacts.pair_of(of).map_or(of, Of::Contact), low.until)
    }));
    let met =
        Met { meetings: &meetings, rates: &rates, impulses: &impulses.normal, ends: &ends, stopped: found.triggers };
    note_impacts(scene, memory, state.time, &contacts, &met, &mut done);
    done.blocked = blocked(scene, &velocity, state, &meetings, &impulses.normal);
    done.blocked = done.blocked.map(|of| contacts.pair_of(of).map_or(of, Of::Contact));
    if done.blocked.is_some() {
        state.velocity = velocity;
        return done;
    }
    memory.omit_flights(&flights);
    stop_slow_joints(elements, state, &rests, true);
    let struck = impulses.normal.iter().any(|&impulse| impulse != 0.0);
    if struck {
        jump_to_bounds(elements, mode, state, &mut done);
        contacts.unpressed.clear();
    }
    // A contact that is seized in every round is undecided.
    let mut unsolved = true;
    for _ in 0..CALMING {
        done.lost += contacts.come_to_rest(scene, state, &yielding);
        if contacts.join_touching(scene, state) {
            done.lost += contacts.come_to_rest(scene, state, &yielding);
        }
        if struck {
            stop_roundings(scene.whole, state, &velocity);
        }
        let known = efforts(mode, state);
        let mut decided = decide(scene, mode, state, &known, &yielding, &contacts.candidates);
        for round in 0..COMPLETING {
            let Ok(found) = &decided else { break };
            // An inexact answer has errors at every point.
            if found.off > 0.0 || !contacts.complete_decision(scene, state, found, round) {
                break;
            }
            decided = decide(scene, mode, state, &known, &yielding, &contacts.candidates);
        }
        if decided.as_ref().is_ok_and(|decided| decided.off > 0.0) && contacts.jams() {
            continue;
        }
        match decided {
            Ok(decided) => {
                done.unsolved += usize::from(decided.off > 0.0);
                done.undecided = decided.off > ROUGH;
                contacts.begin_to_tilt(scene, state, &decided, &mut mode.contacts);
                unsolved = false;
                break;
            }
            Err(Undecided::Inconsistent(candidate)) => match contacts.seize(scene, state, candidate) {
                Some(Seized { lost, driven, impulses }) => {
                    (done.lost, done.driven) = (done.lost + lost, done.driven + driven);
                    note_seized(scene, state.time, &impulses, &mut done);
                }
                None => break,
            },
            Err(Undecided::Unsolved) => break,
        }
    }
    if unsolved {
        done.unsolved += 1;
        done.undecided = true;
        mode.contacts = contacts.keep_closed();
    }
    mode.idle = idle_pairs(scene, state, mode, &contacts.candidates);
    mode.kept = std::mem::take(&mut contacts.kept);
    mode.unpressed = unpressed(scene, state, mode, &contacts.candidates);
    mode.seams = held_seams(scene, state, &contacts.seams, mode);
    note_joints(elements, state.time, [&before, mode], &met, &mut done);
    note_pairs(scene, state.time, [&before, mode], &met, &mut done);
    let meets = |brake: &Brake| Meeting { block: brake.block(velocity.len()), restitution: 0.0, rest: 0.0 };
    done.meetings = impulses.held.iter().map(meets).chain(meetings).collect();
    done.contacts = contacts.take();
    done
}

/// Whether a joint is beyond a limit by more than roundings.
fn is_beyond(elements: &Elements, state: &State, trigger: &Watched) -> bool {
    let Watched::Gap(index, side) = *trigger else { return false };
    let joint = &elements.joints[index];
    joint.gap(side, joint.position(state)) < -BEYOND_LIMIT
}

/// Stops the joints whose slides end here by an impulse in each, if they are faster than rest; returns the energy that this takes (J). A slide whose
/// forces jump ends where its step begins, at whatever rate: to set that rate to zero alone would change momenta, and may give energy. At a dead point of
/// a loop the joint turns round by itself: its rate is a rounding, and an impulse along it would stop the whole loop. Joints at rest stay at rest: the
/// roundings that such an impulse would leave in their rates would be slips, of all of them.
fn stop_joints(scene: &mut Scene, state: &mut State, triggers: &[Watched], rests: &[f64]) -> f64 {
    let fast = |trigger: &Watched| match *trigger {
        Watched::Slide(index) => {
            let joint = &scene.elements.joints[index];
            (joint.rate(state).abs() > rests[index]).then_some(joint.coordinate.freedom)
        }
        _ => None,
    };
    let stops: Vec<usize> = triggers.iter().filter_map(fast).collect();
    if stops.is_empty() {
        return 0.0;
    }
    let still = joints_at_rest(scene.elements, state);
    let mut freedoms = [stops, still.clone()].concat();
    let dead = at_dead_points(scene.whole, scene.response, state, &freedoms);
    freedoms.retain(|freedom| !dead.contains(freedom));
    let rows = freedoms.into_iter().map(|freedom| row_of_freedom(state.velocity.len(), freedom, 1.0)).collect();
    let taken = bring_rows_to_rest(scene, state, rows);
    still.iter().for_each(|&freedom| state.velocity[freedom] = 0.0);
    taken
}

/// Sets tiny rates to zero, and the rates of joints whose bounds leave no room if `locked`.
fn stop_slow_joints(elements: &Elements, state: &mut State, rests: &[f64], locked: bool) {
    for (joint, &rest) in elements.joints.iter().zip(rests) {
        let rate = &mut state.velocity[joint.coordinate.freedom];
        if rate.abs() <= rest || locked && joint.is_locked() {
            *rate = 0.0;
        }
    }
}

/// All meetings come to rest along their first rows: the fallback if the law of impact could not be solved. Slips of contacts with friction are then not
/// known.
fn bring_to_rest(scene: &mut Scene, state: &mut State, meetings: &[Meeting]) -> Impulses {
    let mut rests: Vec<usize> = Vec::new();
    let mut lost = 0.0;
    let fastest = meetings.iter().map(|meeting| meeting.rate(&state.velocity).abs()).fold(0.0, f64::max);
    // Limits that come to rest may make others approach.
    loop {
        let approach = |index: &usize| !rests.contains(index) && meetings[*index].rate(&state.velocity) < 0.0;
        let more: Vec<usize> = (0..meetings.len()).filter(approach).collect();
        if more.is_empty() {
            break;
        }
        rests.extend(more);
        let first = rests.iter().map(|&index| meetings[index].block.rows[0].clone()).collect();
        lost += bring_rows_to_rest(scene, state, first);
        if !scene.touching.pairs.is_empty() {
            break;
        }
    }
    let rate = |row: &Row| row.rate(&state.velocity).abs();
    let slips = |meeting: &Meeting| meeting.block.rows[1..].iter().map(rate).fold(0.0, f64::max);
    let slip = rests.iter().map(|&index| slips(&meetings[index])).fold(0.0, f64::max);
    let residual = if slip > 0.0 { (slip / fastest).min(1.0) } else { 0.0 };
    Impulses { lost, residual, ..Impulses::none(meetings) }
}

/// Puts the state on the event, and changes the motors that are at it.
fn settle(elements: &Elements, mode: &mut Mode, state: &mut State, triggers: &[Watched], done: &mut Done) {
    let time = state.time;
    for &trigger in triggers {
        match trigger {
            Watched::Gap(index, side) => {
                elements.joints[index].put_on(side, state);
                done.joints[index] = true;
            }
            Watched::Slide(index) => {
                state.velocity[elements.joints[index].coordinate.freedom] = 0.0;
                done.joints[index] = true;
            }
            Watched::Bears(index, _) => done.joints[index] = true,
            Watched::Margin => {
                for (joint, mode) in done.joints.iter_mut().zip(&mode.joints) {
                    *joint |= matches!(mode, JointMode::Held { .. });
                }
            }
            Watched::Motor(index, side) => {
                let is = if side == Side::Upper { 1 } else { -1 };
                mode.motors[index] = MotorMode::Saturated(is);
                done.motors[index] = true;
                note_bound(&elements.motors[index], [0, is], time, &mut done.events);
            }
            // The modes of contacts are found again, from the places of the bodies.
            Watched::Approach(_)
            | Watched::Presses(_)
            | Watched::Returns(_)
            | Watched::Grips(_)
            | Watched::Slips(_)
            | Watched::SlipsTogether(_)
            | Watched::Resists(..)
            | Watched::Turns(..)
            | Watched::Feature(_) => {}
            Watched::Excess(index) => {
                mode.motors[index] = MotorMode::Unbounded;
                done.motors[index] = true;
                // The motor leaves either of its bounds.
                note_bound(&elements.motors[index], [1, 0], time, &mut done.events);
            }
        }
    }
}

/// Motors whose unbounded efforts are beyond their bounds after an impact, or no longer: their rates have jumped.
fn jump_to_bounds(elements: &Elements, mode: &mut Mode, state: &State, done: &mut Done) {
    let time = state.time;
    for (index, motor) in elements.motors.iter().enumerate() {
        let was = match mode.motors[index] {
            MotorMode::Unbounded => 0,
            MotorMode::Saturated(sign) => sign,
            MotorMode::Given(_) => continue,
        };
        let effort = unbounded(elements, index, time, time, state);
        let is = if effort.abs() > motor.max_effort { effort.signum() as i8 } else { 0 };
        if is != was {
            mode.motors[index] = if is == 0 { MotorMode::Unbounded } else { MotorMode::Saturated(is) };
            done.motors[index] = true;
            note_bound(motor, [was, is], time, &mut done.events);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::dynamics::response::Response;
    use crate::instant::holding::touching::Touching;
    use crate::mechanism::description::closure::Coordinate;
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::{Body, Mechanism};
    use crate::mechanism::description::nonsmooth::DryFriction;
    use crate::mechanism::motion::contact_solvers::ContactSolvers;
    use nalgebra::Vector3;

    /// Three links on hinges in a row; the first two hinges have friction.
    fn chain() -> Mechanism {
        let link = |index: usize| {
            let [before, own] = [if index == 0 { 0.0 } else { 0.2 }, -0.2].map(|x| Pose::translation(x, 0.0, 0.0));
            let joint = Joint::new("hinge", JointKind::Revolute, before, own);
            let parent = index.checked_sub(1);
            Body { name: "link".into(), parent, mass: 1.0, inertia: Vector3::repeat(1e-2), joint }
        };
        let mut chain = Mechanism::new("chain", Vector3::zeros(), (0..3).map(link).collect()).expect("three links");
        for body in 0..2 {
            let joint = &chain.bodies[body].joint;
            let coordinate = Coordinate { body, position: joint.position_index, freedom: joint.velocity_index };
            chain.nonsmooth.friction.push(DryFriction { coordinate, effort: 1.0 });
        }
        chain
    }

    #[test]
    fn joints_at_rest_stay_at_rest_where_others_stop_from_any_rate() {
        let chain = chain();
        let (elements, touching) = (Elements::new(&chain), Touching::new(&chain));
        let (mut response, mut solvers) = (Response::new(&chain), ContactSolvers::default());
        let mut scene = Scene {
            whole: &chain,
            elements: &elements,
            touching: &touching,
            near: &[],
            response: &mut response,
            solvers: &mut solvers,
        };
        for rate in [1.4e-12, 1e-3, 3.0] {
            let mut state = State::zero(&chain);
            state.position.copy_from_slice(&[0.2, 0.9, -0.4]);
            state.velocity.copy_from_slice(&[0.0, rate, 0.5]);
            let had = energy(&chain, &state).kinetic;
            let taken = stop_joints(&mut scene, &mut state, &[Watched::Slide(1)], &[1e-14, 1e-13]);
            let [held, stopped, moves] = state.velocity[..] else { panic!("three freedoms") };
            // Without the row of the first joint it is left with a third of the rate.
            assert_eq!(held, 0.0);
            assert!(stopped.abs() <= 1e-15 * rate, "{stopped:e} of {rate:e}");
            // The impulse does turn the last link.
            assert!((moves - 0.5).abs() > 0.1 * rate, "{moves}");
            let left = had - energy(&chain, &state).kinetic - taken;
            assert!(left.abs() <= 1e-14 * had, "{left:e} of {had}");
        }
    }
}
