//! The equations of closures at one configuration as kinematics sees them: which of them are empty, and all of them without dimension.
//!
//! Let `(f, t)` be the direction in which the multiplier of a row pushes, and `(v, ω)` the screw of a freedom on the circuit of its loop, both about
//! the common origin ([`crate::coupled::system`]):
//!
//! ```text
//!     J_ix = ± (f · v + t · ω)        + on the branch of the second end, − on that of the first           [1], [m], [1/m]
//!     A_ix = J_ix L_x / L_i           with the lengths of [`catena_mechanism::structure::ranks`]
//!     empty:   |f · v + t · ω| <= 1e-10 (|f| |v| + |t| |ω|)   for every freedom: components that should be zero are rounded, too
//! ```

use crate::coupled::system::{Coupled, Geometry, One};
use crate::numbers::lanes::Lanes;
use catena_mechanism::structure::ranks::rows::Row;
use std::ops::Range;

/// An equation is empty where its gradient along every freedom is this part of the magnitudes that it is rounded from.
const EMPTY: f64 = 1e-10;

/// Finds the equations of the loops whose gradients at the start of a step are rounding.
pub(crate) fn find_empty<G: Geometry<One>>(
    coupled: &mut Coupled<One>,
    geometry: &G,
    plan: &G::Plan,
    start: &G::Start,
    circuits: &[[Vec<usize>; 2]],
) {
    let loops = coupled.closure_of_row().partition_point(|&closure| closure < circuits.len());
    let mut empty = std::mem::take(&mut coupled.known.empty);
    empty.resize(loops, true);
    empty.fill(true);
    for (row, empty) in empty.iter_mut().enumerate() {
        // The force part is first.
        let (direction, forces) = (coupled.direction(row), G::WIDTH.div_ceil(2));
        let bodies = &circuits[coupled.closure_of_row()[row]];
        let moves = |body: usize, freedom: usize| {
            let screw = geometry.screws(plan, start, &[], body, freedom).columns;
            let along: f64 = direction.iter().zip(&screw).take(G::WIDTH).map(|(a, b)| a * one(*b)).sum();
            let size = |part: Range<usize>| {
                norm(direction[part.clone()].iter().copied()) * norm(screw[part].iter().copied().map(one))
            };
            along.abs() > EMPTY * (size(0..forces) + size(forces..G::WIDTH))
        };
        *empty = !bodies
            .iter()
            .flatten()
            .any(|&body| G::tree(plan).bodies[body].freedoms().any(|freedom| moves(body, freedom)));
    }
    coupled.reeved.iter().for_each(|end| empty[end.row] = false);
    coupled.known.empty = empty;
}

/// The equations of the loops at the start of a step, dimensionless with the sizes of the loops and the lengths of the freedoms. Which of them friction holds
/// is not told.
pub(crate) fn equations<G: Geometry<One>>(
    coupled: &Coupled<One>,
    geometry: &G,
    plan: &G::Plan,
    start: &G::Start,
    circuits: &[[Vec<usize>; 2]],
    [sizes, lengths]: [&[f64]; 2],
) -> Vec<Row> {
    let loops = coupled.closure_of_row().partition_point(|&closure| closure < circuits.len());
    let row = |row: usize| {
        let (closure, direction) = (coupled.closure_of_row()[row], coupled.direction(row));
        if coupled.reeved.iter().any(|end| end.row == row) {
            let entries = rope_entries(coupled, geometry, plan, start, (row, &circuits[closure][0]));
            let entries =
                entries.into_iter().map(|(freedom, along)| (freedom, along * lengths[freedom] / sizes[closure]));
            let gap = one(coupled.gaps[row]).abs() / sizes[closure];
            return Row { closure, entries: entries.collect(), gap, adheres: false, moves: false };
        }
        // The force part is first; without it an equation is one of angles.
        let angles = direction[..G::WIDTH.div_ceil(2)].iter().all(|&component| component == 0.0);
        let unit = if angles { 1.0 } else { sizes[closure] };
        let mut entries = Vec::new();
        for (bodies, sign) in circuits[closure].iter().zip([-1.0, 1.0]) {
            for &body in bodies {
                for freedom in G::tree(plan).bodies[body].freedoms() {
                    let screw = geometry.screws(plan, start, &[], body, freedom).columns;
                    let along = direction.iter().zip(screw).take(G::WIDTH).map(|(a, b)| a * one(b)).sum::<f64>();
                    entries.push((freedom, sign * along * lengths[freedom] / unit));
                }
            }
        }
        entries.sort_unstable_by_key(|(freedom, _)| *freedom);
        Row { closure, entries, gap: one(coupled.gaps[row]).abs() / unit, adheres: false, moves: false }
    };
    (0..loops).map(row).collect()
}

/// The entries of the equation of a rope through several points, along the freedoms of the bodies on its circuit.
fn rope_entries<G: Geometry<One>>(
    coupled: &Coupled<One>,
    geometry: &G,
    plan: &G::Plan,
    start: &G::Start,
    (row, circuit): (usize, &[usize]),
) -> Vec<(usize, f64)> {
    let bodies = &G::tree(plan).bodies;
    let mut entries = Vec::new();
    for &body in circuit {
        let above = |end: usize| std::iter::successors(Some(end), |&own| bodies[own].parent);
        let ends = coupled.reeved.iter().filter(|end| end.row == row && above(end.body).any(|own| own == body));
        let pulls: Vec<usize> = ends.map(|end| end.gradient).collect();
        for freedom in bodies[body].freedoms() {
            let screw = geometry.screws(plan, start, &[], body, freedom).columns;
            let along = |&pull: &usize| coupled.direction(pull).iter().zip(screw).map(|(a, b)| a * one(b)).sum::<f64>();
            entries.push((freedom, pulls.iter().map(along).sum::<f64>()));
        }
    }
    entries.sort_unstable_by_key(|(freedom, _)| *freedom);
    entries
}

/// The Euclidean norm.
fn norm(entries: impl Iterator<Item = f64>) -> f64 {
    entries.map(|entry| entry * entry).sum::<f64>().sqrt()
}

/// The number in the only lane.
fn one(value: One) -> f64 {
    value.to_array()[0]
}
