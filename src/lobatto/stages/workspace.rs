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

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::Numbers;
use crate::numbers::lanes::Lanes;
use crate::numbers::reductions::{add_to, largest};
use crate::numbers::rotations::{compose, rotate_increment};
use crate::numbers::series::FEW;
use crate::plan::tree::Plan;
use crate::stages::coefficients::Coefficients;
use crate::stages::factors::Factors;
use crate::stages::forces::Applied;
use crate::stages::pose::{StagePose, Turn, rotation_vector};
use crate::stages::row_geometry::LookAhead;
use crate::stages::rows::Stored;
use crate::stages::start::Start;
use crate::stages::unknowns::Unknowns;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;

/// The workspace of a step: everything that has lanes.
#[derive(Clone)]
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
    /// The factors of the Newton step.
    pub factors: Factors<V>,
    /// The inputs of a sweep for the next body.
    pub early: LookAhead<V, Stored<V>>,
    /// Forces besides gravity, if the mechanism has any.
    pub applied: Option<Box<Applied<V>>>,
    /// Length of the step (s).
    pub step: f64,
}

impl<V: Numbers> Stages<V> {
    /// A workspace for a scheme and a mechanism under gravity alone; the simplification rules in `kept` are disabled.
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

    /// Takes the start of the step and its length from callers that have them in doubles.
    pub fn take_start(&mut self, start: &Start, step: f64) {
        self.start.take(start, V::real);
        self.step = step;
    }

    /// Adds the increments to the displacements; returns the largest displacement.
    #[inline(always)]
    pub fn advance(&mut self) -> f64 {
        add_to(&mut self.displacement, &self.increment)
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
                    // Pose of the parent from registers, because each body waits for it.
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

    /// Whether a step takes the most general sweeps: forces act, or there are no others ([`Lanes::GENERAL_ALONE`]). The choice of the sweeps writes
    /// this condition out: behind a call the compiler would know it too late.
    #[inline(always)]
    pub fn is_general(&self) -> bool {
        V::GENERAL_ALONE || self.applied.is_some()
    }

    /// The unknowns of the predictor.
    pub fn unknowns(&mut self) -> Unknowns<'_, V> {
        let known = self.plan.known();
        Unknowns {
            displacement: &mut self.displacement[known..],
            rates: &self.start.rates[known..],
            step: self.step,
            coefficients: &self.coefficients,
        }
    }
}

/// The joint that has turned furthest since the start.
#[inline(always)]
pub(crate) fn furthest_turn<V: Lanes>(stages: &Stages<V>) -> Turn {
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
