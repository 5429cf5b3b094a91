//! Lent inertia: added in the matrix of the solve to light freedoms that closures tie to heavy ones, and removed again by iteration.
//!
//! A light leader of heavy followers moves alone with the mobility `(H⁻¹)_xx`, and with its followers with as many times less as it is lighter. The
//! proximal term of the solve is a part ε of the first and would exceed the second. So the matrix alone, not the equations, gets
//!
//! ```text
//!     H_xx + w_x,    w_x = 1e-4 / m_x,   m_x = [Z (Zᵀ H Z)⁻¹ Zᵀ]_xx,   Z: directions in which the closures let the mechanism move
//! ```
//!
//! at most 1e-4 of the largest inertia of the bodies that are tied to each other. Iterations then leave some 1e-4 each, and converge to the exact
//! solution. A freedom whose own inertia is not well below w_x gets no loan, so most mechanisms are solved as they stand. H is kept as a factor,
//! `H = Bᵀ B` with a row for every component of every body's momentum, largest rows first, so that light bodies keep their digits beside heavy ones.
//! Source: numerical experiments, in which six repetitions of the solve reach rounding at every mass ratio.

use crate::description::body_state::{BodyState, WORLD};
use crate::description::mechanism::{Body, Mechanism};
use crate::motion::kinematics::forward_kinematics;
use crate::motion::state::State;
use crate::structure::islands::first_of_tied;
use crate::structure::ranks::counting::Ranks;
use nalgebra::{DMatrix, DVector};

/// w_x over the inertia that the closures give to a freedom.
const LENT: f64 = 1e-4;
/// A freedom gets a loan only if it is at least this many times its own inertia.
const LIGHT: f64 = 10.0;
/// Only where a body is lighter than the heaviest by this there is anything to lend.
const SPREAD: f64 = 1e-3;
/// Mechanisms of more freedoms are solved as they stand: the factor would be too large.
const LARGEST: usize = 400;

/// Inertia lent to every freedom [kg m² or kg]; empty if it is zero.
pub fn lent_inertia(mechanism: &Mechanism, state: &State, ranks: &Ranks) -> Vec<f64> {
    let count = mechanism.velocity_count;
    let Some(free) = ranks.free.as_ref().filter(|_| count <= LARGEST) else { return Vec::new() };
    let firsts = first_of_tied(mechanism);
    if !may_be_light(mechanism, ranks, &firsts) {
        return Vec::new();
    }
    let factor = factor(mechanism, state, &ranks.lengths);
    let units = DMatrix::identity(count, count);
    let mut directions = DMatrix::zeros(count, free.len());
    for (column, direction) in free.iter().enumerate() {
        direction.iter().for_each(|&(freedom, value)| directions[(freedom, column)] = value);
    }
    let parts = part_of_freedoms(mechanism, &firsts);
    let mut largest = vec![0.0_f64; mechanism.bodies.len()];
    for (column, &part) in factor.column_iter().zip(&parts) {
        largest[part] = largest[part].max(column.norm_squared());
    }
    let triangle = triangle(factor);
    let (alone, together) = (mobilities(&triangle, &units), mobilities(&triangle, &directions));
    let lent: Vec<f64> = (0..count)
        .map(|freedom| {
            let inertia = LENT * (1.0 / together[freedom]).min(largest[parts[freedom]]);
            let helps = inertia.is_finite() && inertia * alone[freedom] > LIGHT;
            if helps { inertia / ranks.lengths[freedom].powi(2) } else { 0.0 }
        })
        .collect();
    if lent.iter().all(|&inertia| inertia == 0.0) { Vec::new() } else { lent }
}

/// For every freedom the first body of the part of its body, from those of all bodies.
fn part_of_freedoms(mechanism: &Mechanism, firsts: &[usize]) -> Vec<usize> {
    let mut parts = vec![0; mechanism.velocity_count];
    for (body, &first) in mechanism.bodies.iter().zip(firsts) {
        parts[body.joint.velocity_range()].fill(first);
    }
    parts
}

/// Whether any body is light enough, beside another of its part, for a loan.
fn may_be_light(mechanism: &Mechanism, ranks: &Ranks, firsts: &[usize]) -> bool {
    let length = ranks.lengths.iter().fold(1.0_f64, |most, &length| most.max(length));
    let mut heaviest = vec![0.0_f64; firsts.len()];
    for (body, &first) in mechanism.bodies.iter().zip(firsts) {
        heaviest[first] = heaviest[first].max(body.inertia.max().max(body.mass * length * length));
    }
    let lightness = |body: &Body| body.inertia.max().min(body.mass * length * length);
    mechanism.bodies.iter().zip(firsts).any(|(body, &first)| lightness(body) < SPREAD * heaviest[first])
}

/// `B`: the roots of the kinetic energy of every body for a unit of every freedom, largest rows first.
fn factor(mechanism: &Mechanism, state: &State, lengths: &[f64]) -> DMatrix<f64> {
    let count = mechanism.velocity_count;
    let mut factor = DMatrix::zeros(6 * mechanism.bodies.len(), count);
    let (mut unit, mut bodies) = (vec![0.0; count], vec![WORLD; mechanism.bodies.len()]);
    for freedom in 0..count {
        unit[freedom] = lengths[freedom];
        forward_kinematics(mechanism, &state.position, &unit, &mut bodies);
        unit[freedom] = 0.0;
        for (index, (body, BodyState { rotation, velocity, angular_velocity, .. })) in
            mechanism.bodies.iter().zip(&bodies).enumerate()
        {
            let linear = velocity * body.mass.sqrt();
            let angular = (rotation.transpose() * angular_velocity).component_mul(&body.inertia.map(f64::sqrt));
            factor.fixed_view_mut::<3, 1>(6 * index, freedom).copy_from(&linear);
            factor.fixed_view_mut::<3, 1>(6 * index + 3, freedom).copy_from(&angular);
        }
    }
    let mut order: Vec<usize> = (0..factor.nrows()).collect();
    let largest: Vec<f64> = factor.row_iter().map(|row| row.amax()).collect();
    order.sort_by(|&one, &other| largest[other].total_cmp(&largest[one]));
    factor.select_rows(&order)
}

/// `R Pᵀ` of `B P = Q R`, which has the same products as B, in no more rows than there are freedoms.
fn triangle(factor: DMatrix<f64>) -> DMatrix<f64> {
    let factors = factor.col_piv_qr();
    let mut triangle = factors.r();
    factors.p().inv_permute_columns(&mut triangle);
    triangle
}

/// `[Z (Zᵀ Bᵀ B Z)⁻¹ Zᵀ]_xx` for every freedom x; infinite if a direction moves no mass.
fn mobilities(factor: &DMatrix<f64>, directions: &DMatrix<f64>) -> Vec<f64> {
    let moved = factor * directions;
    if moved.ncols() == 0 {
        return vec![0.0; directions.nrows()];
    }
    // More rows than columns, whatever the directions.
    let moved = moved.resize_vertically(factor.nrows().max(directions.ncols()), 0.0);
    let qr = moved.col_piv_qr();
    let triangle = qr.r();
    directions
        .row_iter()
        .map(|row| {
            let mut entries: DVector<f64> = row.transpose();
            qr.p().permute_rows(&mut entries);
            entries_of(&triangle, &entries)
        })
        .collect()
}

/// `|R⁻ᵀ x|²`, infinite for a singular R.
fn entries_of(triangle: &DMatrix<f64>, entries: &DVector<f64>) -> f64 {
    match triangle.tr_solve_upper_triangular(entries) {
        Some(solution) if solution.iter().all(|value| value.is_finite()) => solution.norm_squared(),
        _ => f64::INFINITY,
    }
}
