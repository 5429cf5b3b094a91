//! The poses of all stages from the joint displacements: the forward sweep.
//!
//! All stages of a step are rebuilt from the joint displacements `θ_i` since its start, root to leaf, so that every
//! joint holds to rounding at every iterate. Rotations since the start are unit quaternions
//! `(w, u)` in world axes, `R_i = (1 + N_i) R_0`, and positions are increments, so that no difference of poses is
//! ever formed:
//!
//! ```text
//!     q_b   = q_p ∘ exp(Σ θ z_0)                        z_0: free rotation axes at the start
//!     Δa_b  = Δa_p + N_p arm + Σ θ (1 + N_p) e_0        e_0: free translation axes at the start
//!     N     = 2 (w û + u uᵀ − |u|² 1)
//! ```

use super::algebra::{Matrix, Vector};
use super::applied::Applied;
use super::lanes::Lanes;
use super::numbers::{Arithmetic, Numbers};
use super::plan::Plan;
use super::predictor::Unknowns;
use super::residual::Turned;
use super::row_geometry::LookAhead;
use super::rows::Stored;
use super::start::Start;
use super::step::larger;
use super::sweeps::Factors;
use super::tableau::Tableau;
use super::turns::{FEW, compose, rotate_increment};
use crate::model::{FreeRotation, Mechanism, Rule};

/// The largest number of lanes any vector type has.
pub const MAX_LANES: usize = 16;

/// The largest joint rotation within a step the kernel represents (rad).
pub const MAX_TURN: f64 = 3.1;

/// How far a joint has turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// The largest angle at any stage (rad).
    pub angle: f64,
    /// Its first degree of freedom that turns.
    pub freedom: usize,
}

impl Turn {
    /// The larger of two, the first of equals.
    pub fn or(self, other: Turn) -> Turn {
        if other.angle > self.angle { other } else { self }
    }
}

/// Rotation and anchor displacement of a body at all stages, since the start of the step, in world axes.
#[derive(Clone, Copy)]
pub struct StagePose<V> {
    /// Real part of the quaternion.
    pub w: V,
    /// Vector part of the quaternion.
    pub u: Vector<V>,
    /// Displacement of the anchor (m).
    pub anchor: Vector<V>,
}

impl<V: Arithmetic> StagePose<V> {
    /// `N = R R₀ᵀ − 1 = 2 (w û + u uᵀ − |u|²)`, without cancellation.
    #[inline(always)]
    pub fn increment(&self) -> Matrix<V> {
        self.turned().matrix()
    }

    /// What N is linear in.
    #[inline(always)]
    pub fn turned(&self) -> Turned<V> {
        let [x, y, z] = self.u.0;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let products = [x2 * x, x2 * y, x2 * z, y2 * y, y2 * z, z2 * z];
        Turned { products, vector: [self.w * x2, self.w * y2, self.w * z2] }
    }
}

/// The coefficients of the scheme as lanes. Lane `j` of an unknown is stage `j + 2`; lane `j` of a residual is row
/// `j + 2`, except that the last lane is row 1: the two share their geometry, except for the last lane, where the
/// row's is that of the start.
pub struct Coefficients<V> {
    /// Number of lanes in use, s − 1.
    pub active: usize,
    /// B by columns.
    pub residual: [V; MAX_LANES],
    /// What rounding has cut off B, by columns.
    pub residual_rest: [V; MAX_LANES],
    /// What rounding has cut off the nodes.
    pub nodes_rest: V,
    /// Â by columns.
    pub solve: [V; MAX_LANES],
    /// Nodes c_2 … c_s.
    pub nodes: V,
    /// One where a row has its stage's geometry, zero where it has that of the start.
    pub moved: V,
}

/// The stage (0 is the start) that a lane of a residual stands for, of `active` lanes in use.
pub fn row_stage(lane: usize, active: usize) -> usize {
    if lane + 1 == active { 0 } else { lane + 1 }
}

/// One in the lanes of residuals that have the geometry of their stage, zero in that of the start.
pub fn moved_rows<V: Numbers>(active: usize) -> V {
    let moved: Vec<f64> = (0..active).map(|lane| if row_stage(lane, active) == 0 { 0.0 } else { 1.0 }).collect();
    V::from_parts(&moved, &[])
}

impl<V: Numbers> Coefficients<V> {
    /// Arranges a tableau in lanes.
    pub fn new(tableau: &Tableau) -> Self {
        let active = tableau.stages - 1;
        let row_of_lane = |lane: usize| row_stage(lane, active);
        let mut residual = [V::zero(); MAX_LANES];
        let mut residual_rest = [V::zero(); MAX_LANES];
        let mut solve = [V::zero(); MAX_LANES];
        for column in 0..active {
            let rows: Vec<f64> =
                (0..active).map(|lane| tableau.b_matrix[row_of_lane(lane) * active + column]).collect();
            let rest: Vec<f64> =
                (0..active).map(|lane| tableau.remainders.b_matrix[row_of_lane(lane) * active + column]).collect();
            residual[column] = V::from_parts(&rows, &rest);
            residual_rest[column] = V::from_parts(&rest, &[]);
            let rows: Vec<f64> = (0..active).map(|lane| tableau.a_hat[lane * active + row_of_lane(column)]).collect();
            solve[column] = V::from_parts(&rows, &[]);
        }
        Coefficients {
            active,
            residual,
            residual_rest,
            nodes_rest: V::from_parts(&tableau.remainders.nodes[1..], &[]),
            solve,
            nodes: V::from_parts(&tableau.nodes[1..], &tableau.remainders.nodes[1..]),
            moved: moved_rows(active),
        }
    }
}

/// The workspace of a step: everything that has lanes.
pub struct Stages<V: Numbers> {
    /// Which bodies hang where.
    pub plan: Plan,
    /// The known start of the step.
    pub start: Start<V::Real>,
    /// The scheme.
    pub coefficients: Coefficients<V>,
    /// Displacement of every degree of freedom since the start: the unknowns.
    pub displacement: Vec<V>,
    /// The latest Newton increment of the unknowns.
    pub increment: Vec<V>,
    /// One entry a body.
    pub poses: Vec<StagePose<V>>,
    /// What the Newton step leaves.
    pub factors: Factors<V>,
    /// What a sweep knows of the next body.
    pub early: LookAhead<V, Stored<V>>,
    /// Forces besides gravity, if the mechanism has any.
    pub applied: Option<Box<Applied<V>>>,
    /// Length of the step (s).
    pub step: f64,
}

impl<V: Numbers> Stages<V> {
    /// A workspace for a scheme and a mechanism on which nothing acts but gravity; the rules that are `kept` from leaving something out are
    /// switched off.
    pub fn unforced(mechanism: &Mechanism, tableau: &Tableau, kept: &[Rule]) -> Self {
        Self::planned(Plan::lean(mechanism, kept), mechanism, tableau)
    }

    /// The same with a plan.
    pub fn planned(plan: Plan, mechanism: &Mechanism, tableau: &Tableau) -> Self {
        let bodies = mechanism.bodies.len();
        let freedoms = mechanism.velocity_count;
        Stages {
            coefficients: Coefficients::new(tableau),
            displacement: vec![V::zero(); freedoms],
            increment: vec![V::zero(); freedoms],
            poses: vec![StagePose { w: V::splat(1.0), u: Vector::zero(), anchor: Vector::zero() }; bodies],
            factors: Factors::new(&plan, freedoms),
            early: LookAhead::new(V::store_all([V::zero(); 12])),
            applied: None,
            start: Start::with_units(mechanism),
            plan,
            step: 0.0,
        }
    }

    /// Takes the start of the step and its length from those who have them in doubles.
    pub fn take_start(&mut self, start: &Start, step: f64) {
        self.start.take(start, V::real);
        self.step = step;
    }

    /// Adds the increments to the displacements; returns the largest displacement.
    #[inline(always)]
    pub fn advance(&mut self) -> f64 {
        let mut largest = V::zero();
        for (displacement, &increment) in self.displacement.iter_mut().zip(&self.increment) {
            *displacement = *displacement + increment;
            largest = displacement.max_abs(largest);
        }
        largest.largest()
    }

    /// The forward sweep: poses of all bodies at all stages from `displacement`.
    #[inline(always)]
    pub fn sweep_poses(&mut self) {
        let start = &self.start;
        let few = largest(&self.displacement) <= FEW;
        let still = StagePose { w: V::splat(1.0), u: Vector::zero(), anchor: Vector::zero() };
        let mut last = still;
        for (index, (plan, known)) in self.plan.bodies.iter().zip(&start.bodies).enumerate() {
            let turns = !plan.parent_slides;
            let mut pose = match plan.parent {
                Some(parent) => {
                    // From registers, because each body waits for its parent's.
                    let mut pose = if parent + 1 == index { last } else { self.poses[parent] };
                    if turns {
                        pose.anchor = rotate_increment(pose.w, pose.u, Vector::splat(&known.arm)).plus(pose.anchor);
                    }
                    pose
                }
                None => still,
            };
            let mut freedom = plan.first_axis;
            for _ in 0..plan.translations {
                let axis = Vector::splat(&start.axes[freedom]);
                let turned = if turns { rotate_increment(pose.w, pose.u, axis).plus(axis) } else { axis };
                pose.anchor = turned.times_plus(self.displacement[freedom], pose.anchor);
                freedom += 1;
            }
            match plan.rotation {
                FreeRotation::None => {}
                FreeRotation::AboutZ => {
                    let angle = self.displacement[freedom];
                    let (cosine, sine) = V::half_angle(angle * angle, few);
                    let axis = Vector::splat(&start.axes[freedom]).times(sine * angle);
                    (pose.w, pose.u) = if turns { compose(pose.w, pose.u, cosine, axis) } else { (cosine, axis) };
                }
                FreeRotation::Ball => {
                    let turn = self.rotation_vector(freedom);
                    let (cosine, sine) = V::half_angle(turn.dot(turn), false);
                    let axis = turn.times(sine);
                    (pose.w, pose.u) = if turns { compose(pose.w, pose.u, cosine, axis) } else { (cosine, axis) };
                }
            }
            self.poses[index] = pose;
            last = pose;
        }
    }

    /// [`rotation_vector`] of this step.
    #[inline(always)]
    pub fn rotation_vector(&self, freedom: usize) -> Vector<V> {
        rotation_vector(&self.start, &self.displacement, freedom)
    }
}

impl<V: Lanes> Stages<V> {
    /// A workspace for a mechanism and a scheme, without the rules that are `kept` from leaving something out.
    pub fn new(mechanism: &Mechanism, tableau: &Tableau, kept: &[Rule]) -> Self {
        Stages { applied: Applied::new(mechanism, tableau), ..Stages::unforced(mechanism, tableau, kept) }
    }

    /// Whether a step takes the most general sweeps: forces act, or there are no others ([`Lanes::GENERAL_ALONE`]). Where sweeps are chosen
    /// the same is written out: behind a call the compiler would know too late.
    #[inline(always)]
    pub fn is_general(&self) -> bool {
        V::GENERAL_ALONE || self.applied.is_some()
    }

    /// What the predictor is to guess.
    pub fn unknowns(&mut self) -> Unknowns<'_, V> {
        let known = self.plan.known();
        Unknowns {
            displacement: &mut self.displacement[known..],
            rates: &self.start.rates[known..],
            step: self.step,
            coefficients: &self.coefficients,
        }
    }

    /// The largest increment of any freedom at any stage.
    #[inline(always)]
    pub fn largest_increment(&self) -> f64 {
        largest(&self.increment)
    }
}

/// The rotation vector of a ball joint since the start, in world axes, from the first of its degrees of freedom.
#[inline(always)]
pub fn rotation_vector<V: Arithmetic>(start: &Start<V::Real>, displacement: &[V], freedom: usize) -> Vector<V> {
    let axes = &start.axes[freedom..freedom + 3];
    let first = Vector::splat(&axes[0]).times(displacement[freedom]);
    let second = Vector::splat(&axes[1]).times_plus(displacement[freedom + 1], first);
    Vector::splat(&axes[2]).times_plus(displacement[freedom + 2], second)
}

/// The largest of any freedom's values at any stage, without their signs.
#[inline(always)]
pub(super) fn largest<V: Numbers>(values: &[V]) -> f64 {
    let mut largest = V::zero();
    for value in values {
        largest = value.max_abs(largest);
    }
    largest.largest()
}

/// The largest top Legendre coefficient of `sin φ` and `cos φ` of a body's rotation.
#[inline(always)]
pub(super) fn largest_of_turn<V: Lanes>(pose: &StagePose<V>, top: V, start: f64) -> f64 {
    let weighted = pose.w * top;
    let twice = weighted + weighted;
    let [x, y, z] = pose.u.0;
    // w² − |u|² = 2w² − 1 for a unit quaternion, one at the start; the coefficient of a constant is zero.
    let cosine = (twice * pose.w).sum() + 2.0 * start;
    let (x, y, z) = ((twice * x).sum().abs(), (twice * y).sum().abs(), (twice * z).sum().abs());
    larger(larger(larger(cosine.abs(), x), y), z)
}

/// The joint that has turned furthest since the start.
#[inline(always)]
pub(super) fn furthest_turn<V: Lanes>(stages: &Stages<V>) -> Turn {
    let mut furthest = Turn::default();
    for plan in &stages.plan.bodies {
        let freedom = plan.first_axis + plan.translations;
        let square = match plan.rotation {
            FreeRotation::None => continue,
            FreeRotation::AboutZ => (stages.displacement[freedom] * stages.displacement[freedom]).largest(),
            FreeRotation::Ball => {
                let vector = stages.rotation_vector(freedom);
                vector.dot(vector).largest()
            }
        };
        furthest = furthest.or(Turn { angle: square.sqrt(), freedom });
    }
    furthest
}
