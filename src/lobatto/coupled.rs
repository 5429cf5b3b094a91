//! The exact Newton step, with all stages coupled: for closed loops, and where nothing simpler converges.
//!
//! Newton's method on the stage equations with the multipliers of the closures, `λ_k = h² Λ_k`, all rows k and unknown stages
//! i at once (newton.md §4c, loops.md §1 of the project's method pages). With η the twists about a common origin, for every
//! body, joint axis and closure
//!
//! ```text
//!     Σ_i D_ki η_i − J_kᵀ dλ_k = −(E_k − J_kᵀ λ_k)         rows: projected on the joint axes s_k at the rows' stages
//!     J_i η_i + ε Σ_k Â_ik dλ_k = −g_i                     η_body = η_parent + s_i δ_i
//!
//!     D_ki = B_ki [ m          −m x̂_i                          ]      N = R_i Σ R_kᵀ  [kg m²]
//!                 [ m x̂_k      tr N − N − m x̂_k x̂_i            ]
//! ```
//!
//! ε acts on the increments only (proximal): converged gaps are zero whatever it is, and redundant equations need no decision
//! about rank. The multipliers start from zero in every step, so that nothing that no equation determines is
//! carried on. The curvature `d(Jᵀλ)` is left out.
//!
//! With one stage, `B = Â = 1`, the same system projects velocities and positions on the closures ([`super::projection`]).

use super::algebra::{Matrix, Vector};
use super::closure::{EndStart, Equation, EquationValue, Moved, equations, evaluate};
use super::elimination::{Column, Elimination, Operation, TWIST, Unknown};
use super::front::{Fronts, Screws};
use super::lanes::{Lanes, in_lanes};
use super::stage::{MAX_LANES, Stages};
use super::start::{Plan, Start};
use super::tableau::Tableau;
use crate::model::{Attachment, FreeRotation, Mechanism};

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
        let row_of_lane = |lane: usize| if lane + 1 == active { 0 } else { lane + 1 };
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
        let moved: Vec<f64> = (0..active).map(|lane| if lane + 1 == active { 0.0 } else { 1.0 }).collect();
        Self::new(mechanism, Mixing { active, mass, solve, velocity, moved: V::from_slice(&moved) }, true)
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
        let (bodies, rows) = (mechanism.bodies.len(), elimination.row_count());
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

    /// Gaps and gradients of all loops.
    #[inline(always)]
    pub fn evaluate_closures(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop) {
            let mut out = [EquationValue::zero(); 6];
            for side in 0..2 {
                let moved = [0, 1].map(|end: usize| ends[end].body.map(|body| &self.moved[body][side]));
                evaluate(&self.equations[rows.clone()], ends, moved, &mut out[..rows.len()]);
                for (value, out) in self.values[rows.clone()].iter_mut().zip(&out) {
                    value[side] = *out;
                }
            }
            for (gap, value) in self.gaps[rows.clone()].iter_mut().zip(&self.values[rows.clone()]) {
                *gap = value[0].gap;
            }
        }
    }

    /// The rows of the mimics.
    pub fn mimic_rows(&self) -> std::ops::Range<usize> {
        let first = self.rows_of_loop[..self.loops].last().map_or(0, |rows| rows.end);
        first..self.equations.len() - self.resistances.len()
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

    /// Lets the multipliers push on the bodies: `bias ← bias − Jᵀ λ`.
    #[inline(always)]
    pub fn push(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop[..self.loops]) {
            for row in rows.clone() {
                let value = &self.values[row][1];
                for (end, sign) in ends.iter().zip([1.0, -1.0]) {
                    if let Some(body) = end.body {
                        let factor = self.multipliers[row] * V::splat(sign);
                        let (force, torque) = self.bias[body];
                        self.bias[body] =
                            (value.force.times_plus(factor, force), value.torque.times_plus(factor, torque));
                    }
                }
            }
        }
    }

    /// The equations of all closures.
    pub fn rows(&self) -> &[super::elimination::Row] {
        &self.elimination.rows
    }

    /// The latest increments of the multipliers.
    pub fn multiplier_increments(&self) -> &[V] {
        &self.multiplier_increments
    }

    /// The direction in which a multiplier pushes on the second end of its loop: force, and torque about the common origin;
    /// the first lane.
    pub fn direction(&self, row: usize) -> ([f64; 3], [f64; 3]) {
        let value = &self.values[row][0];
        let first = |vector: Vector<V>| vector.0.map(|lanes| lanes.to_array().as_ref()[0]);
        (first(value.force), first(value.torque))
    }

    /// Where the second end of a loop is at the start, from the common origin (m).
    pub fn end_point(&self, closure: usize) -> [f64; 3] {
        self.ends[closure][1].point
    }

    /// The twists of all bodies for rates of the freedoms, where the step starts.
    pub fn twists_of(&mut self, plan: &Plan, start: &Start, rates: &[f64]) {
        for body in 0..plan.bodies.len() {
            let parent = plan.bodies[body].parent;
            let mut twist = parent.map_or([V::zero(); TWIST], |parent| self.twists[parent]);
            for freedom in plan.bodies[body].freedoms() {
                let screw = self.screws_of(plan, start, &[], body, freedom).columns;
                for (twist, screw) in twist.iter_mut().zip(screw) {
                    *twist = screw.mul_add(V::splat(rates[freedom]), *twist);
                }
            }
            self.twists[body] = twist;
        }
    }

    /// The rates of the gaps of all loops for the present twists, in place of the gaps.
    pub fn rates(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop) {
            for row in rows.clone() {
                let value = &self.values[row][0];
                let mut rate = V::zero();
                for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
                    if let Some(body) = end.body {
                        let directions = value.force.0.into_iter().chain(value.torque.0);
                        for (direction, twist) in directions.zip(self.twists[body]) {
                            rate = (direction * V::splat(sign)).mul_add(twist, rate);
                        }
                    }
                }
                self.gaps[row] = rate;
            }
        }
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
                    in_lanes!(V, self.own(level, plan, start, *body));
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

    /// Clears the slots of multipliers that come in, and brings their right-hand sides.
    #[inline(always)]
    fn enter(&mut self, level: usize, slots: &[usize], present: &[usize], gaps: &[(usize, usize)]) {
        self.fronts.enter(level, slots, present);
        let right = self.fronts.right_hand_side();
        for &(row, slot) in gaps {
            let gap = self.gaps[row].to_array();
            for k in 0..self.mixing.active {
                self.fronts.block(level, slot, right)[k] = first_lane::<V>(-gap.as_ref()[k]);
                if self.equations[row] == Equation::Line {
                    self.fronts.add(level, slot, slot, k, self.unit[k]);
                }
            }
        }
    }

    /// A body's inertia and residual.
    #[inline(always)]
    fn own(&mut self, level: usize, plan: &Plan, start: &Start, body: usize) {
        let mut anchors = [Vector::zero(); 2];
        for side in 0..2 {
            anchors[side] = self.anchor(start, body, side);
        }
        let known = &start.bodies[body];
        own_inertia(
            &mut self.fronts,
            level,
            &self.mixing,
            OwnBody {
                anchors,
                moved: &self.moved[body],
                mass: plan.bodies[body].mass,
                com: known.com,
                sigma: known.sigma,
                bias: self.bias[body],
            },
        );
    }

    /// One equation at one end of its loop: (row, slot, sign).
    #[inline(always)]
    fn end(&mut self, level: usize, (row, slot, sign): (usize, usize, f64)) {
        let active = self.mixing.active;
        let mut by_gap = self.unit;
        if self.equations[row] == Equation::Line {
            let spring = row + self.resistances.len() - self.equations.len();
            for k in 0..active {
                by_gap[k] = self.resistance(&self.resistances[spring], k);
            }
        }
        couple(&mut self.fronts, level, [&by_gap[..active], &self.unit[..active]], slot, sign, &self.values[row]);
    }

    /// The pivot of a multiplier, with its proximal term.
    #[inline(always)]
    fn take_multiplier(
        &mut self,
        level: usize,
        row: usize,
        slot: usize,
        columns: &[Column],
        measure: &[(usize, usize)],
    ) {
        let mut largest = 0.0_f64;
        for &(row, slot) in measure {
            self.scales[row] = mobility(&mut self.fronts, level, slot, &self.mixing);
            largest = largest.max(self.scales[row]);
        }
        for &(row, _) in measure {
            // Nothing moves along this equation: any scale will do, but not zero.
            if self.scales[row] <= PROXIMAL * largest {
                self.scales[row] = if largest > 0.0 { largest } else { 1.0 };
            }
        }
        self.left_over[row] = mobility(&mut self.fronts, level, slot, &self.mixing) / self.scales[row];
        self.fronts.take_multiplier(level, slot, columns);
        if self.equations[row] != Equation::Line {
            let proximal = V::splat(self.proximal * self.scales[row]);
            for k in 0..self.mixing.active {
                let pivot = self.fronts.pivot();
                pivot[k] = self.mixing.solve[k].mul_add(proximal, pivot[k]);
            }
        }
    }

    /// The value of an eliminated unknown from those that come after it; a freedom moves on the twist of its body.
    #[inline(always)]
    fn back_substitute(
        &mut self,
        plan: &Plan,
        operation: &Operation,
        kept_at: usize,
        columns: &[Column],
        increment: &mut [V],
    ) {
        match operation {
            Operation::Freedom { body, freedom, .. } if *freedom == plan.bodies[*body].first_axis => {
                self.twists[*body] = match plan.bodies[*body].parent {
                    Some(parent) => self.twists[parent],
                    None => [V::zero(); TWIST],
                };
            }
            _ => {}
        }
        let solution = self.substitute(kept_at, columns);
        match operation {
            Operation::Freedom { body, freedom, .. } => {
                increment[*freedom] = solution;
                for component in 0..TWIST {
                    let twist = &mut self.twists[*body][component];
                    *twist = self.screws[*freedom][component].mul_add(solution, *twist);
                }
            }
            Operation::Multiplier { row, .. } => self.multiplier_increments[*row] = solution,
            _ => {}
        }
    }

    /// `−h² ∂F_k/∂y_i` of a row k, for a scalar y.
    #[inline(always)]
    fn resistance(&self, resistance: &Resistance, k: usize) -> V {
        let stiffness = V::splat(self.step * self.step * resistance.stiffness) * self.mixing.moved * self.unit[k];
        self.mixing.velocity[k].mul_add(V::splat(self.step * resistance.damping), stiffness)
    }

    /// What acts along a freedom itself: efforts, how joint springs and dampers resist, and mimics: (row, slot, coefficient).
    #[inline(always)]
    fn take_efforts(&mut self, freedom: usize, direct: &[(usize, usize, f64)]) {
        let active = self.mixing.active;
        let right = self.fronts.right_hand_side();
        let mut effort = self.efforts[freedom];
        for &(row, slot, coefficient) in direct {
            let coefficient = V::splat(coefficient);
            effort = self.multipliers[row].mul_add(coefficient, effort);
            for k in 0..active {
                let entry = self.unit[k] * coefficient;
                let left = self.fronts.left_block(slot);
                left[k] = left[k] + entry;
                let right = self.fronts.right_block(slot);
                right[k] = right[k] - entry;
            }
        }
        let effort = effort.to_array();
        for k in 0..active {
            let block = self.fronts.right_block(right);
            block[k] = block[k] + first_lane::<V>(effort.as_ref()[k]);
        }
        let resistance = self.in_joints[freedom];
        if resistance != Resistance::default() {
            for k in 0..active {
                let entry = self.resistance(&resistance, k);
                let pivot = self.fronts.pivot();
                pivot[k] = pivot[k] + entry;
            }
        }
    }

    /// Adds the latest increments to the multipliers.
    #[inline(always)]
    pub fn advance_multipliers(&mut self) {
        for (multiplier, increment) in self.multipliers.iter_mut().zip(&self.multiplier_increments) {
            *multiplier = *multiplier + *increment;
        }
    }

    /// The value of an eliminated unknown from those that come after it.
    #[inline(always)]
    fn substitute(&self, kept_at: usize, columns: &[Column]) -> V {
        let active = self.mixing.active;
        let mut sums = [V::zero(); MAX_LANES];
        for (number, column) in columns.iter().enumerate() {
            let value = match column.unknown {
                Unknown::Twist { body, component } => self.twists[body][component],
                Unknown::Multiplier(row) => self.multiplier_increments[row],
            };
            let kept = &self.kept[kept_at + number * V::COUNT..kept_at + (number + 1) * V::COUNT];
            for k in 0..active {
                sums[k] = kept[k].mul_add(value, sums[k]);
            }
        }
        let right = &self.kept[kept_at + columns.len() * V::COUNT..kept_at + (columns.len() + 1) * V::COUNT];
        let mut solution = V::zero_array();
        for k in 0..active {
            solution.as_mut()[k] = right[k].to_array().as_ref()[0] - sums[k].sum();
        }
        V::from_array(solution)
    }

    /// The screw of a freedom at the rows' and the columns' stages; without displacements, at the start.
    #[inline(always)]
    fn screws_of(&self, plan: &Plan, start: &Start, displacement: &[V], body: usize, freedom: usize) -> Screws<V> {
        let mut sides = [[V::zero(); TWIST]; 2];
        for (side, screw) in sides.iter_mut().enumerate() {
            *screw = self.screw(plan, start, displacement, body, freedom, side);
        }
        Screws { columns: sides[0], rows: sides[1] }
    }

    #[inline(always)]
    fn screw(
        &self,
        plan: &Plan,
        start: &Start,
        displacement: &[V],
        body: usize,
        freedom: usize,
        side: usize,
    ) -> [V; TWIST] {
        let plan = &plan.bodies[body];
        let rotations = plan.first_axis + plan.translations;
        let mut axis = Vector::splat(&start.axes[freedom]);
        if freedom < rotations {
            if let Some(parent) = plan.parent {
                axis = self.moved[parent][side].turn.apply_plus(axis, axis);
            }
            let [x, y, z] = axis.0;
            return [x, y, z, V::zero(), V::zero(), V::zero()];
        }
        if plan.rotation == FreeRotation::Ball && !displacement.is_empty() {
            let mut vector = Vector::zero();
            for freedom in rotations..rotations + 3 {
                vector = Vector::splat(&start.axes[freedom]).times_plus(displacement[freedom], vector);
            }
            if side == 1 {
                vector = vector.times(self.mixing.moved);
            }
            axis = super::sweeps::tilt(vector, axis);
        }
        let along = self.moved[body][side].turn.apply_plus(axis, axis);
        let linear = self.anchor(start, body, side).cross(along);
        let ([a, b, c], [x, y, z]) = (linear.0, along.0);
        [a, b, c, x, y, z]
    }
}

/// A body at all stages, as its part of the system needs it.
struct OwnBody<'b, V> {
    /// Its anchor from the common origin, at the columns' and the rows' stages.
    anchors: [Vector<V>; 2],
    moved: &'b [Moved<V>; 2],
    mass: f64,
    com: [f64; 3],
    sigma: [f64; 6],
    bias: (Vector<V>, Vector<V>),
}

/// Adds `D_ki` and the right-hand side of a body to the twist part of a front.
#[inline(always)]
fn own_inertia<V: Lanes>(fronts: &mut Fronts<V>, level: usize, mixing: &Mixing<V>, body: OwnBody<V>) {
    let com = Vector::splat(&body.com);
    let turn = &body.moved[0].turn;
    let column = turn.apply_plus(com, com).plus(body.anchors[0]);
    let row = body.moved[1].turn.apply_plus(com, com).plus(body.anchors[1]);
    let [xx, xy, xz, yy, yz, zz] = body.sigma;
    // Row c of R_k Σ is column c of Σ R_kᵀ.
    let spread = spread_rows(&body.moved[1].turn, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let row_center = [row.0[0].to_array(), row.0[1].to_array(), row.0[2].to_array()];
    let right = fronts.right_hand_side();
    let (force, torque) = (body.bias.0.0, body.bias.1.0);
    for component in 0..TWIST {
        let bias = if component < 3 { force[component] } else { torque[component - 3] };
        let bias = bias.to_array();
        let block = fronts.block(level, component, right);
        for k in 0..mixing.active {
            block[k] = block[k] + first_lane::<V>(-bias.as_ref()[k]);
        }
    }
    for k in 0..mixing.active {
        let weight = mixing.mass[k];
        let heavy = weight * V::splat(body.mass);
        let at = [
            V::splat(row_center[0].as_ref()[k]),
            V::splat(row_center[1].as_ref()[k]),
            V::splat(row_center[2].as_ref()[k]),
        ];
        // Column c of N = (1 + turn) Σ R_kᵀ.
        let mut second = [[V::zero(); 3]; 3];
        for c in 0..3 {
            let entry = Vector([
                V::splat(spread[c][0].as_ref()[k]),
                V::splat(spread[c][1].as_ref()[k]),
                V::splat(spread[c][2].as_ref()[k]),
            ]);
            second[c] = turn.apply_plus(entry, entry).0;
        }
        let trace = second[0][0] + second[1][1] + second[2][2];
        let across = column.dot(Vector(at));
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            fronts.add(level, axis, axis, k, heavy);
            // −m x̂_i above, m x̂_k below.
            fronts.add(level, axis, 3 + next, k, heavy * column.0[last]);
            fronts.add(level, axis, 3 + last, k, -(heavy * column.0[next]));
            fronts.add(level, 3 + axis, next, k, -(heavy * at[last]));
            fronts.add(level, 3 + axis, last, k, heavy * at[next]);
        }
        for r in 0..3 {
            for c in 0..3 {
                let mut value = -(weight * second[c][r]) - heavy * column.0[r] * at[c];
                if r == c {
                    value = value + weight * trace + heavy * across;
                }
                fronts.add(level, 3 + r, 3 + c, k, value);
            }
        }
    }
}

/// The rows of `(1 + turn) Σ`, as arrays over the stages.
#[inline(always)]
fn spread_rows<V: Lanes>(turn: &Matrix<V>, sigma: [[f64; 3]; 3]) -> [[V::Array; 3]; 3] {
    let mut spread = [[V::zero_array(); 3]; 3];
    for c in 0..3 {
        let second = Vector::splat(&sigma[c]);
        let turned = turn.apply_plus(second, second).0;
        for r in 0..3 {
            spread[r][c] = turned[r].to_array();
        }
    }
    spread
}

/// Couples the multiplier in a slot to the twist of a body at one end of its loop. A closure's row is its gap alone; the
/// row of a spring's tension is what its length makes of it, `by_gap`.
#[inline(always)]
fn couple<V: Lanes>(
    fronts: &mut Fronts<V>,
    level: usize,
    [by_gap, unit]: [&[V]; 2],
    slot: usize,
    sign: f64,
    value: &[EquationValue<V>; 2],
) {
    let sign = V::splat(sign);
    for component in 0..TWIST {
        let (column, row) = match component {
            0..3 => (value[0].force.0[component], value[1].force.0[component]),
            _ => (value[0].torque.0[component - 3], value[1].torque.0[component - 3]),
        };
        let (column, row) = (column * sign, row * sign);
        for (k, (by_gap, unit)) in by_gap.iter().zip(unit).enumerate() {
            fronts.add(level, slot, component, k, column * *by_gap);
            fronts.add(level, component, slot, k, -(row * *unit));
        }
    }
}

/// How easily the multiplier in a slot moves its own equation: the size of its block, by that of Â.
#[inline(always)]
fn mobility<V: Lanes>(fronts: &mut Fronts<V>, level: usize, slot: usize, mixing: &Mixing<V>) -> f64 {
    let mut size = (V::zero(), V::zero());
    for (entry, solve) in fronts.block(level, slot, slot).iter().zip(&mixing.solve) {
        size = (size.0 + entry.max_abs(V::zero()), size.1 + solve.max_abs(V::zero()));
    }
    size.0.sum() / size.1.sum()
}

/// A number in lane 0.
#[inline(always)]
fn first_lane<V: Lanes>(value: f64) -> V {
    let mut array = V::zero_array();
    array.as_mut()[0] = value;
    V::from_array(array)
}
