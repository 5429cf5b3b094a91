//! Elements that touch, rest or stick at an instant, as the blocks of one problem.
//!
//! ```text
//!     joint on a limit or with friction     one row: its degree of freedom
//!     contact without friction, rope        one row: its normal, its tension
//!     contact                               three rows: normal, two tangents
//!     rolling or spinning friction          three rows ([`crate::instant::holding::moments`]), after the rows of its contact
//!
//!     W  (m × n)  all rows: rates u = W v;     Y Wᵀ  (n × m)  their response;     D = W Y Wᵀ  (m × m)
//! ```
//!
//! A row is the vector of efforts along the freedoms that do the work of a unit force along the row ([`efforts_of_wrenches`]). Impulses and forces
//! `r` along the rows change velocities and accelerations by `Y Wᵀ r`. Surfaces that move over their bodies add their velocity w to the rates along
//! tangents, `u = W v + w`, and their drives do the work `−w · r`.

use crate::instant::cone::apart::entries_of;
use crate::instant::cone::problem::Law;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::elements::Elements;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::disjoint_sets::DisjointSets;
use crate::mechanism::motion::efforts::efforts_of_wrenches;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations};
use crate::mechanism::motion::reeved::pulls;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{belt, tangents, touch_accelerations, touch_motion, turning_accelerations};
use nalgebra::{DMatrix, DVector, Vector3};
use std::ops::Deref;

/// A component of a motion that is this part of it is rounding.
const NOTHING: f64 = 1e-15;
/// The same of an answer, which is a square of components.
const EMPTY: f64 = 1e-24;
/// An acceleration that is this part of the terms that cancel in it is rounding.
const ROUNDING: f64 = 1e-14;
/// Bodies whose relative acceleration is below this part of their own accelerations are in common free fall and exert no force on each other. If they
/// turn on each other, tilts of 1e-13 that an impact has left make a tenth of that, and so do states between the ends of steps.
const BESIDE: f64 = 1e-9;

/// Whose block it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// A joint, by its number among the elements.
    Joint(usize),
    /// A contact, by its number in a list of the caller.
    Contact(usize),
    /// The rolling or the spinning friction of a contact, by the same number.
    Moment { contact: usize, spinning: bool },
}

/// One block.
#[derive(Clone, Debug)]
pub struct Block {
    pub of: Of,
    pub law: Law,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// A row of W: one entry a degree of freedom.
#[derive(Clone, Debug)]
pub struct Row {
    entries: Vec<f64>,
    /// w: the velocity along it that surfaces have over their bodies [m/s].
    belt: f64,
}

impl From<Vec<f64>> for Row {
    fn from(entries: Vec<f64>) -> Self {
        Row { entries, belt: 0.0 }
    }
}

impl Row {
    /// Its entries that are not zero, with their freedoms: a contact has some for those of two bodies and of what carries them.
    pub(crate) fn acting(&self) -> Vec<(usize, f64)> {
        self.iter().copied().enumerate().filter(|(_, entry)| *entry != 0.0).collect()
    }

    /// `u = w + W v` of this row.
    pub fn rate(&self, velocity: &[f64]) -> f64 {
        let rate: f64 = self.entries.iter().zip(velocity).map(|(a, b)| a * b).sum();
        if self.belt == 0.0 { rate } else { rate + self.belt }
    }

    /// The sum of some rows times factors.
    pub fn combined(rows: &[Row], factors: &[f64]) -> Self {
        let mut sum = Row { entries: vec![0.0; rows.first().map_or(0, |row| row.entries.len())], belt: 0.0 };
        for (row, factor) in rows.iter().zip(factors) {
            sum.entries.iter_mut().zip(&row.entries).for_each(|(sum, entry)| *sum += factor * entry);
            sum.belt += factor * row.belt;
        }
        sum
    }
}

impl Deref for Row {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.entries
    }
}

/// The rows of blocks with their response.
#[derive(Clone)]
pub struct Rows {
    rows: Vec<Row>,
    /// Y Wᵀ.
    columns: DMatrix<f64>,
    /// D.
    pub square: DMatrix<f64>,
}

impl Block {
    /// The block of a joint, by its number: a force along its freedom, of `count` of all, with this sign and between these bounds [N m or N].
    pub fn of_joint(index: usize, freedom: usize, count: usize, sign: f64, [lower, upper]: [f64; 2]) -> Self {
        let rows = vec![row_of_freedom(count, freedom, sign)];
        Block { of: Of::Joint(index), law: Law::Interval { lower, upper }, rows }
    }
}

/// The row of one degree of freedom, with a sign.
pub(crate) fn row_of_freedom(count: usize, freedom: usize, sign: f64) -> Row {
    let mut row = vec![0.0; count];
    row[freedom] = sign;
    row.into()
}

/// The row of a force f on the second of two bodies at a point p of the world, and its opposite on the first.
pub(crate) fn row_of_force(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    [first, second]: [Option<usize>; 2],
    point: &Vector3<f64>,
    force: &Vector3<f64>,
) -> Row {
    let mut wrenches = vec![(Vector3::zeros(), Vector3::zeros()); bodies.len()];
    for (end, sign) in [(first, -1.0), (second, 1.0)] {
        if let Some(body) = end {
            let force = force * sign;
            wrenches[body].0 += force;
            wrenches[body].1 += (point - bodies[body].position).cross(&force);
        }
    }
    row_of_wrenches(mechanism, bodies, &mut wrenches)
}

/// The row of forces (N) and torques about the centres of mass [N m] on the bodies, which are overwritten.
fn row_of_wrenches(mechanism: &Mechanism, bodies: &[BodyState], wrenches: &mut [(Vector3<f64>, Vector3<f64>)]) -> Row {
    let mut row = vec![0.0; mechanism.velocity_count];
    efforts_of_wrenches(mechanism, bodies, wrenches, &mut row);
    row.into()
}

/// The row of a unit tension in a rope through several points.
fn row_of_rope(mechanism: &Mechanism, bodies: &[BodyState], joint: &TouchJoint) -> Row {
    let mut wrenches = vec![(Vector3::zeros(), Vector3::zeros()); bodies.len()];
    add_pulls(joint, bodies, 1.0, &mut wrenches);
    row_of_wrenches(mechanism, bodies, &mut wrenches)
}

/// Adds what a tension (N) in a rope through several points exerts on the bodies: forces, and torques about their centres of mass.
pub(crate) fn add_pulls(
    joint: &TouchJoint,
    bodies: &[BodyState],
    tension: f64,
    wrenches: &mut [(Vector3<f64>, Vector3<f64>)],
) {
    pulls(&joint.reeved, bodies, |body, pull, place| {
        if let Some(body) = body {
            let force = pull * tension;
            wrenches[body].0 += force;
            wrenches[body].1 += (place - bodies[body].position).cross(&force);
        }
    });
}

/// The row of a torque on the second body about a direction of the world, and its opposite on the first.
pub(crate) fn row_of_torque(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    joint: &TouchJoint,
    torque: &Vector3<f64>,
) -> Row {
    let mut wrenches = vec![(Vector3::zeros(), Vector3::zeros()); bodies.len()];
    for (end, sign) in [(joint.a.body, -1.0), (joint.b.body, 1.0)] {
        if let Some(body) = end {
            wrenches[body].1 += torque * sign;
        }
    }
    row_of_wrenches(mechanism, bodies, &mut wrenches)
}

/// The rows of a contact: its normal, and with friction its two tangents.
pub(crate) fn rows_of_contact(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    joint: &TouchJoint,
    friction: bool,
) -> Vec<Row> {
    if joint.is_reeved() {
        return vec![row_of_rope(mechanism, bodies, joint)];
    }
    let touch = touch_motion(joint, bodies);
    let [first, second] = tangents(&touch.normal);
    let count = if friction { 3 } else { 1 };
    let mut rows: Vec<Row> = [touch.normal, first, second][..count]
        .iter()
        .map(|along| row_of_force(mechanism, bodies, [joint.a.body, joint.b.body], &touch.point, along))
        .collect();
    if friction {
        leave_roundings_out(&mut rows);
    }
    if friction && joint.is_belt() {
        let belt = belt(joint, bodies, &touch.normal);
        (rows[1].belt, rows[2].belt) = (belt.dot(&first), belt.dot(&second));
    }
    rows
}

/// Empties a row of the three of a contact whose entries are all roundings: a freedom moves the point along a vector, of which each row has one
/// component. A wheel on slides has such a row across its plane, and forces along it would have no bounds.
fn leave_roundings_out(rows: &mut [Row]) {
    let count = rows[0].len();
    let moves = |freedom: usize| rows.iter().map(|row| row[freedom].powi(2)).sum::<f64>().sqrt();
    let is_rounding = |row: &Row| (0..count).all(|freedom| row[freedom].abs() <= NOTHING * moves(freedom));
    let empty: Vec<bool> = rows.iter().map(is_rounding).collect();
    rows.iter_mut().zip(empty).filter(|(_, empty)| *empty).for_each(|(row, _)| row.entries.fill(0.0));
}

/// The fall `Σ |w a|` along a row w under accelerations a of the joints: bodies that fall freely beside each other press with the difference of these
/// terms, which is rounding.
pub(crate) fn fall(row: &[f64], accelerations: &[f64]) -> f64 {
    row.iter().zip(accelerations).map(|(w, a)| (w * a).abs()).sum()
}

/// Ẇ v + W a: the second rates of the rows of blocks, for accelerations a of the joints; `touching` gives the contact of a number.
pub(crate) fn second_rates<'c>(
    mechanism: &Mechanism,
    elements: &Elements,
    bodies: &[BodyState],
    state: &State,
    accelerations: &[f64],
    blocks: &[Block],
    touching: impl Fn(usize) -> &'c TouchJoint,
) -> Vec<f64> {
    let mut of_bodies = vec![BodyAcceleration::default(); bodies.len()];
    if blocks.iter().any(|block| !matches!(block.of, Of::Joint(_))) {
        body_accelerations(mechanism, bodies, &state.velocity, accelerations, &mut of_bodies);
    }
    let mut rates = Vec::with_capacity(blocks.iter().map(|block| block.rows.len()).sum());
    for block in blocks {
        match block.of {
            Of::Joint(index) => rates.push(accelerations[elements.joints[index].coordinate.freedom]),
            Of::Contact(index) => {
                let joint = touching(index);
                let tangents = tangents(&touch_motion(joint, bodies).normal);
                let along = touch_accelerations(joint, bodies, &of_bodies, &tangents);
                let along = &along[..block.rows.len()];
                // Roundings accelerate bodies that fall beside each other apart, also across their fall; a sliding contact is accelerated along its
                // plane as well.
                let most = block.rows.iter().map(|row| fall(row, accelerations)).fold(0.0, f64::max);
                let held = if matches!(block.law, Law::Sliding { .. }) { 1 } else { along.len() };
                let least = if joint.a.body.is_some() && joint.b.body.is_some() { BESIDE } else { ROUNDING };
                let together = along[..held].iter().all(|rate| rate.abs() <= least * most);
                let rate = |(row, rate): (usize, &f64)| if together && row < held { 0.0 } else { *rate };
                rates.extend(along.iter().enumerate().map(rate));
            }
            Of::Moment { contact, spinning } => {
                let joint = touching(contact);
                let tangents = tangents(&touch_motion(joint, bodies).normal);
                let [first, second, normal] = turning_accelerations(joint, bodies, &of_bodies, &tangents);
                rates.extend(if spinning { [0.0, normal, 0.0] } else { [0.0, first, second] });
            }
        }
    }
    rates
}

/// The answer in `D = W Y Wᵀ` up to which a row has roundings for entries, 1e-16 of others. Answers of light bodies and of other units are far above it.
pub fn least_answer(square: &DMatrix<f64>) -> f64 {
    EMPTY * square.diagonal().iter().fold(0.0, |most: f64, own| most.max(*own))
}

/// Rows in parts that have no freedom in common, neither of their entries nor of their responses (n × m).
fn rows_joined(entries: &[Vec<(usize, f64)>], columns: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let mut rows = DisjointSets::new(entries.len());
    // The first row with an entry for each freedom.
    let mut first = vec![None; columns.nrows()];
    for (row, entries) in entries.iter().enumerate() {
        for &(freedom, _) in entries {
            rows.unite(row, *first[freedom].get_or_insert(row));
        }
    }
    entries_of(columns, |freedom, row| {
        if let Some(other) = first[freedom] {
            rows.unite(row, other);
        }
    });
    rows.parts()
}

impl Rows {
    /// The rows of blocks at a state.
    pub fn of(response: &mut Response, state: &State, blocks: &[Block]) -> Self {
        Rows::new(response, state, blocks.iter().flat_map(|block| block.rows.iter().cloned()).collect())
    }

    /// Rows at a state.
    pub fn new(response: &mut Response, state: &State, rows: Vec<Row>) -> Self {
        let columns = response.answers(state, &rows);
        let entries: Vec<Vec<(usize, f64)>> = rows.iter().map(Row::acting).collect();
        let mut square = DMatrix::zeros(rows.len(), rows.len());
        for part in rows_joined(&entries, &columns) {
            let entry = |row: usize, column: usize| -> f64 {
                entries[row].iter().map(|&(freedom, entry)| entry * columns[(freedom, column)]).sum()
            };
            for (place, &column) in part.iter().enumerate() {
                square[(column, column)] = entry(column, column);
                for &row in &part[..place] {
                    // Symmetric to the last bit.
                    let mean = 0.5 * (entry(row, column) + entry(column, row));
                    (square[(row, column)], square[(column, row)]) = (mean, mean);
                }
            }
        }
        Rows { rows, columns, square }
    }

    /// `u = W v + w`.
    pub fn rates(&self, velocity: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|row| row.rate(velocity)).collect()
    }

    /// W' Y Wᵀ: the rates along other rows that unit impulses along these give.
    pub fn responses(&self, others: &[Row]) -> DMatrix<f64> {
        let entries: Vec<Vec<(usize, f64)>> = others.iter().map(Row::acting).collect();
        DMatrix::from_fn(others.len(), self.rows.len(), |row, column| {
            entries[row].iter().map(|&(freedom, entry)| entry * self.columns[(freedom, column)]).sum()
        })
    }

    /// The work of the drives of belts for impulses along the rows, `−w · P` (J).
    pub fn work_of_belts(&self, impulses: &[f64]) -> f64 {
        let driven = self.rows.iter().zip(impulses).filter(|(row, _)| row.belt != 0.0);
        driven.map(|(row, impulse)| -row.belt * impulse).fold(0.0, |sum, work| sum + work)
    }

    /// v + Y Wᵀ r.
    pub fn add(&self, impulses: &[f64], velocity: &mut [f64]) {
        let change = &self.columns * DVector::from_column_slice(impulses);
        for (rate, change) in velocity.iter_mut().zip(change.iter()) {
            *rate += change;
        }
    }

    /// W, one row after the other.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Y Wᵀ.
    pub fn columns(&self) -> &DMatrix<f64> {
        &self.columns
    }
}
