//! Contacts whose gaps loops alone keep as they are: a roller of a scissor lift that glides along a table, the end of a rod whose slider is parallel to it.
//!
//! ```text
//!     kept:   W Y Wᵀ ≤ 1e-12 |W|⁴/(W H Wᵀ)  and  |φ̇| ≤ rest,  here and a little further along the motion that loops allow
//! ```
//!
//! W is the row of the normal, Y the answer with closures; a tree answers with `W H⁻¹ Wᵀ ≥ |W|⁴/(W H Wᵀ)`. The row is a sum of rows of the loops, so that
//! rigid bodies do not tell how much the contact presses, and no impulse at it changes anything. At a dead point a row is such a sum in one place alone: a
//! little further on the contact answers.
//!
//! Gaps and closures are analytic functions: a gap that loops keep near a state they keep until the mechanism comes to a place where its branches meet.

use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Row, Rows, rows_of_contact};
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::closure::Mimic;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::distance::size;
use crate::mechanism::motion::energy::energy;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;

/// Answers below this part of the answers of a tree are roundings; loops in place give 1e-28 of them. It is the square of a slope of 1e-6.
const ROUNDING: f64 = 1e-12;
/// How far bodies go along the motion that loops allow, as a part of the size of the mechanism. It opens the loops by the square of this part, and the
/// answer of a kept row is its fourth power; the answer after a dead point is its square.
const FURTHER: f64 = 1e-4;

/// Which of some contacts loops keep as they are; `rest` is the fastest rate that counts as rest [m/s].
pub(crate) fn kept_by_loops(
    whole: &Mechanism,
    response: &mut Response,
    state: &State,
    contacts: &[Contact],
    rest: f64,
) -> Vec<bool> {
    let mut kept = vec![false; contacts.len()];
    // Joints that are moved in time are no loops.
    let has_loops = !whole.loops.is_empty() || !whole.touches.is_empty() || !whole.mimics.iter().all(Mimic::is_moved);
    if !has_loops || contacts.is_empty() {
        return kept;
    }
    if whole.moves_joints() {
        // A motion in time may press contacts together later that it keeps now.
        let mut loops = whole.clone();
        loops.mimics.retain(|mimic| !mimic.is_moved());
        return kept_by_loops(&loops, &mut Response::new(&loops), state, contacts, rest);
    }
    let bodies = body_states(whole, state);
    let is_still = |contact: &Contact| touch_motion(&contact.joint, &bodies).rate.abs() <= rest;
    kept.iter_mut().zip(contacts).for_each(|(kept, contact)| *kept = is_still(contact));
    leave_answering(whole, response, state, contacts, &mut kept);
    if kept.contains(&true) {
        let further = further(whole, response, state);
        leave_answering(whole, response, &further, contacts, &mut kept);
    }
    kept
}

/// Leaves the kept contacts whose answers in a state are roundings.
fn leave_answering(whole: &Mechanism, response: &mut Response, state: &State, contacts: &[Contact], kept: &mut [bool]) {
    let bodies = body_states(whole, state);
    let numbers: Vec<usize> = (0..kept.len()).filter(|&number| kept[number]).collect();
    let normal = |&number: &usize| rows_of_contact(whole, &bodies, &contacts[number].joint, false);
    let rows: Vec<Row> = numbers.iter().flat_map(normal).collect();
    let least: Vec<f64> = rows.iter().map(|row| least_of_tree(whole, state, row)).collect();
    let answers = Rows::new(response, state, rows).square.diagonal();
    for ((&number, answer), least) in numbers.iter().zip(answers.iter()).zip(least) {
        kept[number] = *answer <= ROUNDING * least;
    }
}

/// |W|⁴/(W H Wᵀ), in which the rates Wᵀ have the energy of the denominator; below zero for a row without entries, which no loop holds.
fn least_of_tree(whole: &Mechanism, state: &State, row: &Row) -> f64 {
    let square: f64 = row.iter().map(|entry| entry * entry).sum();
    let moves = State { velocity: row.to_vec(), ..state.clone() };
    let twice = 2.0 * energy(whole, &body_states(whole, &moves)).kinetic;
    if twice > 0.0 { square * square / twice } else { -1.0 }
}

/// A state a little further along a motion that closures allow: the answer to efforts of which no two are alike.
fn further(whole: &Mechanism, response: &mut Response, state: &State) -> State {
    let efforts: Vec<f64> = (0..whole.velocity_count).map(|freedom| 1.0 + 0.37 * (freedom as f64).sqrt()).collect();
    let answer = Rows::new(response, state, vec![efforts.into()]);
    let mut moves = State { velocity: answer.columns().column(0).iter().copied().collect(), ..state.clone() };
    let fastest = body_states(whole, &moves).iter().map(|body| body.velocity.norm()).fold(0.0, f64::max);
    if fastest > 0.0 {
        let factor = FURTHER * size(whole, state) / fastest;
        let change: Vec<f64> = moves.velocity.iter().map(|rate| factor * rate).collect();
        moves.displace(whole, &change);
    }
    State { velocity: state.velocity.clone(), ..moves }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::holding::touching::Touching;
    use crate::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use nalgebra::{Rotation3, Translation3, Vector3};

    const CRANK: f64 = 0.2;
    const ROD: f64 = 0.5;
    const RADIUS: f64 = 0.03;

    /// A slider crank in the plane y = 0. The ball end of its rod moves along x on a table with the slider, and touches a wall at its farthest. At an angle of
    /// the crank (rad).
    fn slider_crank(angle: f64) -> (Mechanism, State) {
        let about = |place: f64, axis: Rotation3<f64>| Pose::from_parts(Translation3::new(place, 0.0, 0.0), axis);
        // Joints turn about, and move along, the third axes of their frames.
        let y = Rotation3::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
        let x = Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
        let hinge = |at: f64| Joint::new("hinge", JointKind::Revolute, about(at, y), about(0.0, y));
        let slide = Joint::new("slide", JointKind::Prismatic, about(0.0, x), about(0.0, x));
        let body = |name: &str, parent: Option<usize>, joint: Joint| {
            let (name, inertia) = (name.into(), Vector3::repeat(0.01));
            Body { name, parent, mass: 1.0, inertia, joint }
        };
        let bodies =
            vec![body("crank", None, hinge(0.0)), body("rod", Some(0), hinge(CRANK)), body("slider", None, slide)];
        let mut mechanism = Mechanism::new("crank", Vector3::z() * -9.81, bodies).expect("three bodies");
        let end = |body: usize, at: f64| Attachment { body: Some(body), frame: about(at, y) };
        let (a, b) = (end(1, ROD), end(2, 0.0));
        mechanism.loops.push(LoopJoint { name: "close".into(), kind: LoopKind::Revolute, a, b });
        let nonsmooth = &mut mechanism.nonsmooth;
        nonsmooth.colliders.push(Collider::still(
            "end",
            Some(1),
            Pose::translation(ROD, 0.0, 0.0),
            Shape::Sphere { radius: RADIUS },
        ));
        let table = Pose::translation(0.0, 0.0, -RADIUS);
        let facing = Rotation3::from_axis_angle(&Vector3::y_axis(), -std::f64::consts::FRAC_PI_2);
        let wall = Pose::from_parts(Translation3::new(CRANK + ROD + RADIUS, 0.0, 0.0), facing);
        for (pair, pose) in [table, wall].into_iter().enumerate() {
            nonsmooth.colliders.push(Collider::still("face", None, pose, Shape::HalfSpace));
            nonsmooth.pairs.push(ContactPair::without_moments(pair, [pair + 1, 0], 0.3, 0.0));
        }
        let mut state = State::zero(&mechanism);
        let rises = -(CRANK * angle.sin() / ROD).asin();
        state.position.copy_from_slice(&[angle, rises - angle, CRANK * angle.cos() + ROD * rises.cos()]);
        (mechanism, state)
    }

    #[test]
    fn the_end_of_a_rod_is_kept_on_the_table_along_which_its_slider_moves_and_not_at_the_wall_at_its_dead_point() {
        for (angle, kept) in [(0.0, vec![true, false]), (0.4, vec![true])] {
            let (mechanism, state) = slider_crank(angle);
            let (touching, bodies) = (Touching::new(&mechanism), body_states(&mechanism, &state));
            let near = [0, 1].into_iter().flat_map(|pair| touching.near(pair, &bodies, 1e-9));
            let contacts: Vec<Contact> = near.map(|(contact, _)| contact).collect();
            let mut response = Response::new(&mechanism);
            assert_eq!(kept_by_loops(&mechanism, &mut response, &state, &contacts, 1e-12), kept, "{angle} rad");
            // Without the loop the rod may leave both.
            let mut tree = mechanism.clone();
            tree.loops.clear();
            let none = kept_by_loops(&tree, &mut Response::new(&tree), &state, &contacts, 1e-12);
            assert!(!none.contains(&true));
        }
    }
}
