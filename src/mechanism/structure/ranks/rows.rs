//! The gradients of all closing equations in joint coordinates, dimensionless.
//!
//! The freedoms of a loop are the ones on its circuit: between its ends and the body at which their branches meet. The points are `P_a`, `P_b` (m),
//! `d = P_b − P_a`, directions `u` on a and `w` on b, and a turn is about the axis `z` through the point p, or a slide along `t`:
//!
//! ```text
//!     equation            turn on the branch of b    of a                                 slide on the branch of b, of a
//!     d · u = 0           z × (P_b − p) · u          −z × (P_a − p) · u + d · (z × u)      ± t · u
//!     u · w = 0           −z · (u × w)               z · (u × w)                          0
//!     (d·d − L²)/2L = 0   d · z × (P_b − p) / L      −d · z × (P_a − p) / L               ± d · t / L
//!     contact: φ = 0      z × (p − c) · n, with p the point of contact and c that of the axis; along tangents if it rolls
//!     rope: φ = 0         Σ z × (P_i − c) · f_i over the points that the freedom carries      ([`crate::motion::reeved`])
//!     mimic               follower 1, leader −multiplier
//! ```
//!
//! Rows in m are divided by the size of their loop, the largest distance of any two joints and ends on its circuit; columns of slides are multiplied
//! by the largest size of the loops that move with them; a mimic's row by its largest entry.

use crate::description::body_state::{BodyState, WORLD};
use crate::description::closure::{Attachment, LoopKind, Mimic};
use crate::description::contact::{Feature, Grip, TouchJoint};
use crate::description::joint::FreeRotation;
use crate::description::mechanism::Mechanism;
use crate::motion::gaps::{loop_gaps, mimic_gap};
use crate::motion::reeved::pulls;
use crate::motion::state::State;
use crate::motion::touches::{TouchMotion, tangents, touch_motion};
use nalgebra::Vector3;

/// Loops are no smaller than this part of the largest, and than the roundings of places [m per m from the origin].
const SMALLEST: f64 = 1e-7;
const UNIT_OF_PLACES: f64 = 1e-9;

/// One equation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The closure that it belongs to: the loops first, then the contacts, then the mimics.
    pub closure: usize,
    /// The freedoms that it knows, in their order, and the entries.
    pub entries: Vec<(usize, f64)>,
    /// Its error, dimensionless like the entries.
    pub gap: f64,
    /// Whether friction holds it beside friction that brakes: a force that others can give is theirs.
    pub adheres: bool,
    /// Whether it moves its freedoms, as a joint that is moved in time or a belt does: they are not still, however many equations they have.
    pub moves: bool,
}

/// The motion that a freedom gives to the bodies it carries: about or along an axis through a point.
#[derive(Clone, Copy)]
struct Screw {
    turns: bool,
    axis: Vector3<f64>,
    point: Vector3<f64>,
}

/// The size of every loop (m), and the length of every freedom: for a slide the size of its loops (m), for a turn one.
pub fn scales(mechanism: &Mechanism, bodies: &[BodyState]) -> (Vec<f64>, Vec<f64>) {
    let circuits = circuits(mechanism);
    let sizes = sizes(mechanism, bodies, &circuits);
    let mut lengths = vec![0.0_f64; mechanism.velocity_count];
    for (size, circuit) in sizes.iter().zip(&circuits) {
        for freedom in circuit.iter().flatten().flat_map(|&body| mechanism.bodies[body].joint.velocity_range()) {
            lengths[freedom] = lengths[freedom].max(*size);
        }
    }
    for body in &mechanism.bodies {
        let slides = body.joint.kind.translation_axes().len();
        for (offset, freedom) in body.joint.velocity_range().enumerate() {
            if offset >= slides || lengths[freedom] == 0.0 {
                lengths[freedom] = 1.0;
            }
        }
    }
    (sizes, lengths)
}

/// All equations of a state whose bodies are placed so, in the order of a projection on the closures, and the length of every freedom: for a slide
/// the size of its loops (m), for a turn one.
pub fn closure_rows(mechanism: &Mechanism, state: &State, bodies: &[BodyState]) -> (Vec<Row>, Vec<f64>) {
    let screws = screws(mechanism, bodies);
    let circuits = circuits(mechanism);
    let (sizes, lengths) = scales(mechanism, bodies);
    let mut rows = Vec::new();
    for (closure, (joint, circuit)) in mechanism.loops.iter().zip(&circuits).enumerate() {
        let size = sizes[closure];
        let freedoms = freedoms_of(mechanism, circuit);
        let gaps = loop_gaps(joint, bodies);
        let far = [&joint.a, &joint.b].map(|end| end.place(bodies).0.amax());
        let rounding = f64::EPSILON * far[0].max(far[1]);
        let ((a, on_a), (b, on_b)) = (joint.a.place(bodies), joint.b.place(bodies));
        let apart = b - a;
        let mut put = |unit: f64, entry: &dyn Fn(&Screw, usize) -> f64| {
            let gap = gaps.position[rows.len() - first_row(&rows, closure)].abs().max(rounding);
            let entries = freedoms
                .iter()
                .map(|&(freedom, side)| (freedom, entry(&screws[freedom], side) * lengths[freedom] / unit));
            rows.push(Row { closure, entries: entries.collect(), gap: gap / unit, adheres: false, moves: false });
        };
        let rate = |screw: &Screw, side: usize| {
            let motion = if screw.turns { screw.axis.cross(&([a, b][side] - screw.point)) } else { screw.axis };
            if side == 0 { -motion } else { motion }
        };
        for &slide in joint.kind.slides() {
            let along = on_a.column(slide).into_owned();
            put(size, &|screw, side| {
                let turned = if screw.turns && side == 0 { apart.dot(&screw.axis.cross(&along)) } else { 0.0 };
                rate(screw, side).dot(&along) + turned
            });
        }
        for &(first, second) in joint.kind.squares() {
            let square = on_a.column(first).cross(&on_b.column(second));
            put(1.0, &|screw, side| match (screw.turns, side) {
                (false, _) => 0.0,
                (true, 0) => screw.axis.dot(&square),
                (true, _) => -screw.axis.dot(&square),
            });
        }
        if let LoopKind::Distance(length) = joint.kind {
            put(size, &|screw, side| apart.dot(&rate(screw, side)) / length);
        }
    }
    for (number, joint) in mechanism.touches.iter().enumerate() {
        let closure = mechanism.loops.len() + number;
        let freedoms = freedoms_of(mechanism, &circuits[closure]);
        if joint.is_reeved() {
            let entries = rope_entries(mechanism, joint, bodies, &screws, &freedoms).into_iter();
            let entries = entries.map(|(freedom, entry)| (freedom, entry * lengths[freedom] / sizes[closure]));
            let TouchMotion { gap, point, .. } = touch_motion(joint, bodies);
            let gap = gap.abs().max(f64::EPSILON * point.amax()) / sizes[closure];
            rows.push(Row { closure, entries: entries.collect(), gap, adheres: false, moves: false });
            continue;
        }
        let turns = |direction: &Vector3<f64>| {
            let entry = |&(freedom, side): &(usize, usize)| {
                let Screw { turns, axis, .. } = &screws[freedom];
                let along = if *turns { axis.dot(direction) * lengths[freedom] } else { 0.0 };
                (freedom, if side == 0 { -along } else { along })
            };
            freedoms.iter().map(entry).collect()
        };
        rows.extend(touch_rows(joint, bodies, closure, sizes[closure], turns, |direction, point| {
            let entry = |&(freedom, side): &(usize, usize)| {
                let Screw { turns, axis, point: center } = &screws[freedom];
                let motion = if *turns { axis.cross(&(point - center)) } else { *axis };
                let along = motion.dot(direction) * lengths[freedom] / sizes[closure];
                (freedom, if side == 0 { -along } else { along })
            };
            freedoms.iter().map(entry).collect()
        }));
    }
    rows.extend(mimic_rows(mechanism, state, &lengths));
    tell_what_adheres(mechanism, &mut rows);
    (rows, lengths)
}

/// Marks the tangents of contacts that friction holds while it brakes others beside them. The rows of a contact are its normal, its tangents, and the
/// turnings that are held.
pub fn tell_what_adheres(mechanism: &Mechanism, rows: &mut [Row]) {
    for (number, joint) in
        mechanism.touches.iter().enumerate().filter(|(_, joint)| mechanism.holds_beside_rubbing(joint))
    {
        let closure = mechanism.loops.len() + number;
        let count = rows.iter().filter(|row| row.closure == closure).count();
        let own = rows.iter_mut().filter(|row| row.closure == closure);
        own.take(count.saturating_sub(joint.moments.rows())).skip(1).for_each(|row| row.adheres = true);
    }
}

/// The entries of a rope through several points: what its pulls do along each of these freedoms.
fn rope_entries(
    mechanism: &Mechanism,
    joint: &TouchJoint,
    bodies: &[BodyState],
    screws: &[Screw],
    freedoms: &[(usize, usize)],
) -> Vec<(usize, f64)> {
    let mut entries: Vec<(usize, f64)> = freedoms.iter().map(|&(freedom, _)| (freedom, 0.0)).collect();
    pulls(&joint.reeved, bodies, |body, pull, place| {
        for body in above(mechanism, body) {
            for freedom in mechanism.bodies[body].joint.velocity_range() {
                if let Ok(index) = entries.binary_search_by_key(&freedom, |(freedom, _)| *freedom) {
                    let Screw { turns, axis, point } = &screws[freedom];
                    let motion = if *turns { axis.cross(&(place - point)) } else { *axis };
                    entries[index].1 += motion.dot(&pull);
                }
            }
        }
    });
    entries
}

/// The freedoms on a circuit in their order, and on which of its branches they are.
fn freedoms_of(mechanism: &Mechanism, circuit: &[Vec<usize>; 2]) -> Vec<(usize, usize)> {
    let of = |&body: &usize| mechanism.bodies[body].joint.velocity_range();
    let of_side = |side: usize| circuit[side].iter().flat_map(of).map(move |freedom| (freedom, side));
    let mut freedoms: Vec<(usize, usize)> = of_side(0).chain(of_side(1)).collect();
    freedoms.sort_unstable();
    freedoms
}

/// The equations of a contact, of which `entries` are the entries along a direction at a point, and `turns` those of turning about a direction.
fn touch_rows(
    joint: &TouchJoint,
    bodies: &[BodyState],
    closure: usize,
    size: f64,
    turns: impl Fn(&Vector3<f64>) -> Vec<(usize, f64)>,
    entries: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Vec<(usize, f64)>,
) -> Vec<Row> {
    if joint.touch.rows() == 0 {
        return Vec::new();
    }
    let TouchMotion { gap, normal, point, .. } = touch_motion(joint, bodies);
    let rounding = f64::EPSILON * point.amax();
    let row = |direction: &Vector3<f64>, gap: f64, moves: bool| Row {
        closure,
        entries: entries(direction, &point),
        gap: gap.max(rounding) / size,
        adheres: false,
        moves,
    };
    let mut rows = vec![row(&normal, gap.abs(), false)];
    if joint.touch.grip == Grip::Rolls {
        // A belt carries what it holds.
        rows.extend(tangents(&normal).iter().map(|tangent| row(tangent, 0.0, joint.is_belt())));
    }
    if joint.moments.rows() > 0 {
        let held = joint.held_turns(&normal, &tangents(&normal));
        rows.extend(held.map(|along| Row {
            closure,
            entries: turns(&along),
            gap: f64::EPSILON,
            adheres: false,
            moves: false,
        }));
    }
    rows
}

/// The equations of the mimics.
pub fn mimic_rows(mechanism: &Mechanism, state: &State, lengths: &[f64]) -> Vec<Row> {
    let row = |(number, mimic): (usize, &Mimic)| {
        let terms = mimic.terms().map(|(own, coefficient)| (own.freedom, coefficient * lengths[own.freedom]));
        let mut entries: Vec<(usize, f64)> = terms.filter(|(_, entry)| *entry != 0.0).collect();
        entries.sort_unstable_by_key(|(freedom, _)| *freedom);
        let largest = entries.iter().fold(0.0_f64, |most, (_, entry)| most.max(entry.abs()));
        entries.iter_mut().for_each(|(_, entry)| *entry /= largest);
        let gap = mimic_gap(mimic, state).0.abs() / largest;
        let closure = mechanism.loops.len() + mechanism.touches.len() + number;
        Row { closure, entries, gap, adheres: false, moves: mimic.is_moved() }
    };
    mechanism.mimics.iter().enumerate().map(row).collect()
}

/// The first of the rows of a closure, which are the last.
fn first_row(rows: &[Row], closure: usize) -> usize {
    rows.iter().rposition(|row| row.closure != closure).map_or(0, |last| last + 1)
}

/// The screws of all freedoms.
fn screws(mechanism: &Mechanism, bodies: &[BodyState]) -> Vec<Screw> {
    let mut screws = Vec::with_capacity(mechanism.velocity_count);
    for (body, state) in mechanism.bodies.iter().zip(bodies) {
        let joint = &body.joint;
        let point = state.position + state.rotation * joint.on_child.translation.vector;
        let parent = body.parent.map_or(WORLD.rotation, |parent| bodies[parent].rotation);
        let on_parent = parent * joint.on_parent.rotation.matrix();
        let on_child = state.rotation * joint.on_child.rotation.matrix();
        let axes = match joint.kind.rotation() {
            FreeRotation::None => 0..0,
            FreeRotation::AboutZ => 2..3,
            FreeRotation::Ball => 0..3,
        };
        let slides = joint.kind.translation_axes().iter().map(|&axis| (false, on_parent.column(axis).into_owned()));
        let turns = axes.map(|axis| (true, on_child.column(axis).into_owned()));
        screws.extend(slides.chain(turns).map(|(turns, axis)| Screw { turns, axis, point }));
    }
    screws
}

/// The circuits of all loops, then of all contacts; of a rope through several points all that move it are on the first branch.
pub fn circuits(mechanism: &Mechanism) -> Vec<[Vec<usize>; 2]> {
    let loops = mechanism.loops.iter().map(|joint| circuit(mechanism, [&joint.a, &joint.b]));
    let touches = mechanism.touches.iter().map(|joint| match joint.is_reeved() {
        true => [moving_rope(mechanism, &joint.reeved), Vec::new()],
        false => circuit(mechanism, [&joint.a, &joint.b]),
    });
    loops.chain(touches).collect()
}

/// The bodies whose joints move a rope through these points, in their order: those that carry one of its points but not all.
fn moving_rope(mechanism: &Mechanism, points: &[Attachment]) -> Vec<usize> {
    let mut carried = vec![0; mechanism.bodies.len()];
    for point in points {
        above(mechanism, point.body).for_each(|body| carried[body] += 1);
    }
    let moves = |&body: &usize| (1..points.len()).contains(&carried[body]);
    (0..carried.len()).filter(moves).collect()
}

/// A body and all that carry it.
fn above(mechanism: &Mechanism, body: Option<usize>) -> impl Iterator<Item = usize> {
    std::iter::successors(body, |&body| mechanism.bodies[body].parent)
}

/// The bodies between each end of a loop or contact and where the branches meet.
fn circuit(mechanism: &Mechanism, ends: [&Attachment; 2]) -> [Vec<usize>; 2] {
    let branches = ends.map(|end| above(mechanism, end.body).collect::<Vec<usize>>());
    let common = branches[0].iter().rev().zip(branches[1].iter().rev()).take_while(|(one, other)| one == other).count();
    branches.map(|mut branch| {
        branch.truncate(branch.len() - common);
        branch
    })
}

/// The size of every loop (m).
fn sizes(mechanism: &Mechanism, bodies: &[BodyState], circuits: &[[Vec<usize>; 2]]) -> Vec<f64> {
    let mut far = 0.0_f64;
    let loops = mechanism.loops.iter().map(|joint| [&joint.a, &joint.b].map(|end| end.place(bodies).0));
    // The origins of touching features may be anywhere in a plane or on a line. A rope reaches from its first end to its point.
    let touches = mechanism.touches.iter().map(|joint| {
        let point = touch_motion(joint, bodies).point;
        match joint.touch.features[0] {
            _ if joint.is_reeved() => joint.points().map(|end| end.point(bodies).0).collect(),
            Feature::Hollow { .. } => vec![joint.a.place(bodies).0, point],
            _ => vec![point; 2],
        }
    });
    let own: Vec<f64> = loops
        .map(Vec::from)
        .chain(touches)
        .zip(circuits)
        .map(|(ends, circuit)| {
            let of_body = |&body: &usize| {
                let child = &mechanism.bodies[body].joint.on_child.translation.vector;
                bodies[body].position + bodies[body].rotation * child
            };
            let mut points: Vec<Vector3<f64>> = circuit.iter().flatten().map(of_body).collect();
            points.extend(ends);
            far = points.iter().fold(far, |far, point| far.max(point.amax()));
            // Within a factor of the square root of three of the largest distance, in linear time.
            let extent = |axis: usize| {
                let of = |by: fn(f64, f64) -> f64, from: f64| points.iter().map(|point| point[axis]).fold(from, by);
                of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)
            };
            (0..3).map(extent).fold(0.0, f64::max)
        })
        .collect();
    let largest = own.iter().fold(0.0_f64, |most, &size| most.max(size));
    let smallest = (SMALLEST * largest).max(UNIT_OF_PLACES * far);
    own.into_iter().map(|size| size.max(smallest)).map(|size| if size > 0.0 { size } else { 1.0 }).collect()
}
