//! The exact Newton step, with all stages coupled: for closed loops, and where nothing simpler converges.
//!
//! Newton's method on the stage equations with the multipliers of the closures, `λ_k = h² Λ_k`, all rows k and unknown stages
//! i at once (newton.md §4c, loops.md §1 of the project's method pages). With η the twists about a common origin, for every
//! body, joint axis and closure
//!
//! ```text
//!     Σ_i D_ki η_i − J_kᵀ dλ_k = −(E_k − J_kᵀ λ_k)         rows: projected on the joint axes s_k at the rows' stages
//!     J_i η_i + ε Σ_k Â_ik dλ_k = −g_i                     η_body = η_parent + s_i δ_i
//! ```
//!
//! with the mass blocks D and screws s of `body`, the gradients J of `closures`, and the elimination step by step in `operations`.
//!
//! ε acts on the increments only (proximal): converged gaps are zero whatever it is, and redundant equations need no decision
//! about rank. The multipliers start from zero in every step, so that nothing that no equation determines is
//! carried on. The curvature `d(Jᵀλ)` is left out.
//!
//! With one stage, `B = Â = 1`, the same system projects velocities and positions on the closures ([`super::projection`]).

mod body;
mod closures;
mod operations;

use super::algebra::{Matrix, Vector};
use super::closure::{EndStart, Equation, EquationValue, Moved, equations};
use super::elimination::{Elimination, Operation, TWIST};
use super::front::Fronts;
use super::lanes::{Lanes, in_lanes};
use super::stage::{MAX_LANES, Stages, moved_rows, row_stage};
use super::start::{Plan, Start};
use super::tableau::Tableau;
use crate::model::{Attachment, Mechanism};

/// ε of all solves: large against the square of the gaps that iterates leave, small against what is weak.
pub const PROXIMAL: f64 = 1e-8;

/// The matrix entries of the scheme, as the system needs them.
struct Mixing<V> {
    /// Number of stages coupled.
    active: usize,
    /// Row k of B, lanes i.
    mass: [V; MAX_LANES],
    /// Row i of Â, lanes k.
    solve: [V; MAX_LANES],
    /// Row k of Ā B, lanes i: the velocity of the rows.
    velocity: [V; MAX_LANES],
    /// Zero where a row has the geometry of the start.
    moved: V,
}

/// What a force changes by, row by row: `h² ∂F_k/∂y_i = −(stiffness h² 1 + damping h Ā B)_ki` for a scalar y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Resistance {
    stiffness: f64,
    damping: f64,
}

/// The linear system of a step, and what it is made of.
pub struct Coupled<V: Lanes> {
    elimination: Elimination,
    fronts: Fronts<V>,
    mixing: Mixing<V>,
    unit: [V; MAX_LANES],
    equations: Vec<Equation>,
    /// Of the loops, then of the springs.
    rows_of_loop: Vec<std::ops::Range<usize>>,
    loops: usize,
    /// Of the point springs, and of every freedom's joint springs and dampers.
    resistances: Vec<Resistance>,
    in_joints: Vec<Resistance>,
    /// Efforts along the freedoms, times h².
    pub efforts: Vec<V>,
    /// Length of the step (s).
    pub step: f64,
    /// ε, as a part of the mobility of an equation.
    pub proximal: f64,
    attachments: Vec<[Attachment; 2]>,
    ends: Vec<[EndStart; 2]>,
    origin: [f64; 3],
    /// Every body since the start of the step, at the columns' and at the rows' stages.
    moved: Vec<[Moved<V>; 2]>,
    /// What every body resists with, about the common origin: force, torque.
    pub bias: Vec<(Vector<V>, Vector<V>)>,
    /// One entry a row: at the columns' stages, and its gradient at the rows'.
    values: Vec<[EquationValue<V>; 2]>,
    /// The right-hand side of the closures.
    pub gaps: Vec<V>,
    /// `λ`, and its latest increment.
    pub multipliers: Vec<V>,
    multiplier_increments: Vec<V>,
    twists: Vec<[V; TWIST]>,
    screws: Vec<[V; TWIST]>,
    kept: Vec<V>,
    kept_at: Vec<usize>,
    /// Mobility of every row in the direction of its own gradient, before the others of its closure.
    scales: Vec<f64>,
    /// The part of it that the other rows leave.
    pub left_over: Vec<f64>,
}

impl<V: Lanes> Coupled<V> {
    /// The system of a step of the scheme.
    pub fn of_stages(mechanism: &Mechanism, tableau: &Tableau) -> Self {
        let active = tableau.stages - 1;
        let row_of_lane = |lane: usize| row_stage(lane, active);
        let mut mass = [V::zero(); MAX_LANES];
        let mut solve = [V::zero(); MAX_LANES];
        let mut velocity = [V::zero(); MAX_LANES];
        for lane in 0..active {
            velocity[lane] = V::from_slice(&tableau.velocity[row_of_lane(lane) * active..][..active]);
            let row = row_of_lane(lane) * active;
            mass[lane] = V::from_slice(&tableau.b_matrix[row..row + active]);
            let columns: Vec<f64> = (0..active).map(|k| tableau.a_hat[lane * active + row_of_lane(k)]).collect();
            solve[lane] = V::from_slice(&columns);
        }
        Self::new(mechanism, Mixing { active, mass, solve, velocity, moved: moved_rows(active) }, true)
    }

    /// The system of a projection at one configuration.
    pub fn of_one(mechanism: &Mechanism) -> Self {
        let one = [V::splat(1.0); MAX_LANES];
        Self::new(mechanism, Mixing { active: 1, mass: one, solve: one, velocity: one, moved: V::zero() }, false)
    }

    fn new(mechanism: &Mechanism, mixing: Mixing<V>, forces: bool) -> Self {
        let elimination = Elimination::new(mechanism, forces);
        let mut unit = [V::zero(); MAX_LANES];
        for (lane, unit) in unit[..mixing.active].iter_mut().enumerate() {
            let mut array = V::zero_array();
            array.as_mut()[lane] = 1.0;
            *unit = V::from_array(array);
        }
        let mut kept_at = Vec::with_capacity(elimination.operations.len());
        let mut kept = 0;
        for operation in &elimination.operations {
            kept_at.push(kept);
            if let Operation::Freedom { columns, .. } | Operation::Multiplier { columns, .. } = operation {
                kept += (columns.len() + 1) * V::COUNT;
            }
        }
        let mut rows_of_loop = Vec::new();
        let mut all = Vec::new();
        for joint in &mechanism.loops {
            rows_of_loop.push(all.len()..all.len() + joint.kind.rows());
            all.extend(equations(joint.kind));
        }
        all.extend(mechanism.mimics.iter().map(|_| Equation::Mimic));
        let mut attachments: Vec<[Attachment; 2]> = mechanism.loops.iter().map(|joint| [joint.a, joint.b]).collect();
        let mut resistances = Vec::new();
        let mut in_joints = vec![Resistance::default(); mechanism.velocity_count];
        if forces {
            for spring in &mechanism.forces.point_springs {
                rows_of_loop.push(all.len()..all.len() + 1);
                all.push(Equation::Line);
                attachments.push([spring.a, spring.b]);
                resistances.push(Resistance { stiffness: spring.stiffness, damping: spring.damping });
            }
            for damper in &mechanism.forces.joint_dampers {
                in_joints[damper.freedom].damping += damper.coefficient;
            }
            for spring in &mechanism.forces.joint_springs {
                in_joints[spring.coordinate.freedom].stiffness += spring.stiffness;
            }
        }
        let (bodies, rows) = (mechanism.bodies.len(), elimination.closure_of_row.len());
        let still = Moved { turn: Matrix::zero(), anchor: Vector::zero() };
        Coupled {
            fronts: Fronts::new(mixing.active, elimination.slots, elimination.levels),
            elimination,
            mixing,
            unit,
            equations: all,
            rows_of_loop,
            ends: vec![[EndStart::default(); 2]; attachments.len()],
            attachments,
            resistances,
            in_joints,
            loops: mechanism.loops.len(),
            efforts: vec![V::zero(); mechanism.velocity_count],
            step: 0.0,
            proximal: PROXIMAL,
            origin: [0.0; 3],
            moved: vec![[still; 2]; bodies],
            bias: vec![(Vector::zero(), Vector::zero()); bodies],
            values: vec![[EquationValue::zero(); 2]; rows],
            gaps: vec![V::zero(); rows],
            multipliers: vec![V::zero(); rows],
            multiplier_increments: vec![V::zero(); rows],
            twists: vec![[V::zero(); TWIST]; bodies],
            screws: vec![[V::zero(); TWIST]; mechanism.velocity_count],
            kept: vec![V::zero(); kept],
            kept_at,
            scales: vec![0.0; rows],
            left_over: vec![0.0; rows],
        }
    }

    /// Takes the start of a step: frames, origin, and multipliers from zero.
    pub fn begin(&mut self, start: &Start) {
        self.origin = if start.bodies.is_empty() { [0.0; 3] } else { start.anchor(0) };
        for (ends, attachments) in self.ends.iter_mut().zip(&self.attachments) {
            *ends = [0, 1].map(|end: usize| EndStart::new(&attachments[end], start, &self.origin));
        }
        self.multipliers.fill(V::zero());
    }

    /// The bodies at all stages from the poses of a step.
    #[inline(always)]
    pub fn move_bodies(&mut self, stages: &Stages<V>) {
        let mask = self.mixing.moved;
        for (moved, pose) in self.moved.iter_mut().zip(&stages.poses) {
            let turn = pose.increment();
            *moved = [
                Moved { turn, anchor: pose.anchor },
                Moved { turn: turn.times(mask), anchor: pose.anchor.times(mask) },
            ];
        }
    }

    /// Where an anchor is at the rows' stages, from the common origin.
    #[inline(always)]
    pub fn row_anchor(&self, start: &Start, body: usize) -> Vector<V> {
        self.anchor(start, body, 1)
    }

    #[inline(always)]
    fn anchor(&self, start: &Start, body: usize, side: usize) -> Vector<V> {
        let (anchor, origin) = (start.anchor(body), self.origin);
        let from_origin = [anchor[0] - origin[0], anchor[1] - origin[1], anchor[2] - origin[2]];
        Vector::splat(&from_origin).plus(self.moved[body][side].anchor)
    }

    /// Factors the system and solves it: fills the increments of the freedoms. Not inlined anywhere: every operation is
    /// compiled for the vectors on its own, once.
    pub fn solve(&mut self, plan: &Plan, start: &Start, displacement: &[V], increment: &mut [V]) {
        let operations = std::mem::take(&mut self.elimination.operations);
        let mut level = 0;
        let mut opened = false;
        for (index, operation) in operations.iter().enumerate() {
            let eliminated = match operation {
                Operation::Open => {
                    level += usize::from(opened);
                    opened = true;
                    self.fronts.open(level);
                    None
                }
                Operation::Enter { slots, present, gaps } => {
                    in_lanes!(V, self.enter(level, slots, present, gaps));
                    None
                }
                Operation::Own { body, ends } => {
                    in_lanes!(V, self.own(level, start, *body));
                    for &end in ends {
                        in_lanes!(V, self.end(level, end));
                    }
                    None
                }
                Operation::Freedom { body, freedom, columns, direct } => {
                    let screws = in_lanes!(V, self.screws_of(plan, start, displacement, *body, *freedom));
                    self.screws[*freedom] = screws.columns;
                    in_lanes!(V, self.fronts.take_freedom(level, &screws, columns));
                    in_lanes!(V, self.take_efforts(*freedom, direct));
                    Some(columns)
                }
                Operation::Multiplier { row, slot, columns, measure } => {
                    in_lanes!(V, self.take_multiplier(level, *row, *slot, columns, measure));
                    Some(columns)
                }
                Operation::Merge { slots, enter, present, twist } => {
                    self.fronts.enter(level - 1, enter, present);
                    in_lanes!(V, self.fronts.merge(level, slots, *twist));
                    level -= 1;
                    None
                }
            };
            if let Some(columns) = eliminated {
                let kept_at = self.kept_at[index];
                let kept = &mut self.kept[kept_at..kept_at + (columns.len() + 1) * V::COUNT];
                let fronts = &mut self.fronts;
                in_lanes!(V, fronts.eliminate(level, columns, kept));
            }
        }
        for (index, operation) in operations.iter().enumerate().rev() {
            if let Operation::Freedom { columns, .. } | Operation::Multiplier { columns, .. } = operation {
                let kept_at = self.kept_at[index];
                in_lanes!(V, self.back_substitute(plan, operation, kept_at, columns, increment));
            }
        }
        self.elimination.operations = operations;
    }
}

/// A number in lane 0.
#[inline(always)]
fn first_lane<V: Lanes>(value: f64) -> V {
    let mut array = V::zero_array();
    array.as_mut()[0] = value;
    V::from_array(array)
}
