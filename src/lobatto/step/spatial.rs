//! The workspace of a step in space: six coordinates a body.
//!
//! ```text
//!     poses of all stages from θ                 stages/workspace.rs      g(Q_i) = 0 to rounding at every iterate
//!                                                solve/single_precision.rs    at first
//!     forces F_k, if there are any               equations/forces.rs
//!     residual ρ_k, factors of H(q_k)            equations/residual.rs, equations/pivot.rs, stages/articulated.rs
//!     or ρ_k alone, with factors kept            solve/kept_factors.rs
//!     or all of it for one body in flight        solve/free_body.rs
//!     δ_i = Σ_k Â_ik α_k,  H(q_k) α_k = −ρ_k     solve/sweeps.rs
//!     velocity from H(q̄) v̄ = Sᵀ p̄                ending/velocities.rs, ending/refinement.rs        (2.5.11h)
//! ```

use crate::coupled::newton::StageUnknowns;
use crate::coupled::space::Space;
use crate::coupled::system::Screw;
use crate::ending::refinement::have_lost_digits;
use crate::ending::two_motions::TwoEndings;
use crate::ending::velocities::Ending;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{larger, largest_coefficient};
use crate::plan::tree::Plan;
use crate::solve::kept_factors::Chord;
use crate::solve::single_precision::{FirstIterations, widened};
use crate::stages::attempt::StopRule;
use crate::stages::forces::Applied;
use crate::stages::pose::{Turn, largest_of_turn};
use crate::stages::start::Start;
use crate::stages::unknowns::Unknowns;
use crate::stages::workspace::{Stages, furthest_turn};
use crate::step::workspace::Workspace;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;

/// [`Workspace`] in space.
#[derive(Clone)]
pub(crate) struct SpatialWorkspace<V: Lanes> {
    pub(crate) stages: Stages<V>,
    first: FirstIterations<V>,
    ending: Ending<<V as Lanes>::One>,
    two: Option<Box<TwoEndings<V::Two>>>,
    gravity: [f64; 3],
    /// Entry of the top row of the inverse Legendre matrix for stage 1.
    first_legendre: f64,
}

impl<V: Lanes> SpatialWorkspace<V> {
    /// The workspace for a mechanism and a scheme; `kept` are the disabled simplification rules.
    pub fn new(mechanism: &Mechanism, tableau: &Tableau, kept: &[Rule]) -> Self {
        let stages = Stages::new(mechanism, tableau, kept);
        SpatialWorkspace {
            first: FirstIterations::new(),
            ending: Ending::new(&stages.plan, mechanism.velocity_count, tableau),
            two: None,
            gravity: mechanism.gravity.into(),
            first_legendre: tableau.top_legendre[0],
            stages,
        }
    }
}

impl<V: Lanes> Workspace<V> for SpatialWorkspace<V> {
    type Plan = Plan;
    type Start = Start;
    type Geometry<L: Lanes> = Space<L>;

    fn new_start(mechanism: &Mechanism) -> Start {
        Start::with_units(mechanism)
    }

    fn energy(start: &Start) -> Energy {
        start.energy
    }

    fn bodies(start: &Start) -> Option<&[BodyState]> {
        Some(start.body_states())
    }

    fn full_plan(&self, mechanism: &Mechanism) -> Plan {
        Plan::new(mechanism)
    }

    fn geometry<L: Lanes>(&self, mechanism: &Mechanism, tableau: Option<&Tableau>) -> Space<L> {
        Space::new(mechanism, tableau)
    }

    fn start(&self) -> &Start {
        &self.stages.start
    }

    fn start_mut(&mut self) -> &mut Start {
        &mut self.stages.start
    }

    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        self.stages.start.set(mechanism, state);
        self.first.forget();
    }

    fn set_end(&self, end: &mut Start, mechanism: &Mechanism, state: &State) {
        end.set_with::<V>(mechanism, state);
    }

    fn displacement(&self) -> &[V] {
        &self.stages.displacement
    }

    fn increment(&self) -> &[V] {
        &self.stages.increment
    }

    fn advanced(&mut self) -> (&mut [V], &[V]) {
        (&mut self.stages.displacement, &self.stages.increment)
    }

    fn unknowns(&mut self) -> Unknowns<'_, V> {
        self.stages.unknowns()
    }

    fn known(&self) -> usize {
        self.stages.plan.known()
    }

    fn balls(&self) -> Vec<usize> {
        self.stages.plan.balls()
    }

    fn applied(&self) -> Option<&Applied<V>> {
        self.stages.applied.as_deref()
    }

    fn applied_mut(&mut self) -> Option<&mut Applied<V>> {
        self.stages.applied.as_deref_mut()
    }

    fn prepare_single(&mut self, mechanism: &Mechanism, tableau: &Tableau, stop: f64) {
        self.first.prepare(mechanism, &self.stages.plan, tableau, stop);
    }

    fn set_step(&mut self, step: f64) {
        self.stages.step = step;
    }

    fn begin_attempt(&mut self, rule: &StopRule) {
        self.first.allow(rule);
    }

    fn end_failed(&mut self) {
        self.first.fail();
    }

    fn begin_iteration(&mut self) {
        self.first.begin(&self.stages.start, self.stages.step);
    }

    fn leave_single(&mut self) {
        self.first.leave();
    }

    fn has_factors(&self) -> bool {
        self.first.latest().is_none()
    }

    fn is_general(&self) -> bool {
        self.stages.is_general()
    }

    /// In single precision, or of one body in free flight.
    fn iterate_specially(&mut self, chord: &mut Chord, refined: bool) -> Option<f64> {
        let SpatialWorkspace { stages, first, gravity, .. } = self;
        if let Some(increment) = first.iterate(stages, chord, gravity) {
            return Some(increment);
        }
        first.hand_over(stages);
        if !stages.plan.tumbles {
            return None;
        }
        Some(if refined {
            in_lanes!(V, stages.tumble::<true>(gravity).largest())
        } else {
            in_lanes!(V, stages.tumble::<false>(gravity).largest())
        })
    }

    fn iterate(&mut self, keeps: bool, refined: bool) -> f64 {
        let SpatialWorkspace { stages, gravity, .. } = self;
        in_lanes!(V, stages.sweep_poses());
        if stages.applied.is_some() {
            in_lanes!(V, stages.sweep_applied(false));
        }
        // Vectors that carry the general sweeps alone are not compiled with the others.
        if V::GENERAL_ALONE || stages.applied.is_some() {
            if keeps {
                in_lanes!(V, stages.sweep_forced_wrenches(gravity));
            } else {
                in_lanes!(V, stages.sweep_forced_residual(gravity));
            }
        } else {
            match (keeps, refined) {
                // Increments that settle are small.
                (_, true) => in_lanes!(V, stages.sweep_wrenches::<true>(gravity)),
                (true, false) => in_lanes!(V, stages.sweep_wrenches::<false>(gravity)),
                (false, false) => in_lanes!(V, stages.sweep_residual(gravity)),
            }
        }
        in_lanes!(V, stages.sweep_increments().largest())
    }

    fn begin_exactly(&mut self) {
        let SpatialWorkspace { stages, gravity, .. } = self;
        if stages.plan.tumbles {
            in_lanes!(V, stages.place_tumbler(gravity));
        }
        self.first.leave();
    }

    fn place_stages(&mut self, geometry: &mut Space<V>, bias: &mut [Screw<V>]) {
        let SpatialWorkspace { stages, gravity, .. } = self;
        in_lanes!(V, stages.sweep_poses());
        if stages.applied.is_some() {
            in_lanes!(V, stages.sweep_applied(false));
        }
        in_lanes!(V, geometry.place_stages(stages, gravity, bias));
    }

    fn stage_unknowns(&mut self) -> StageUnknowns<'_, V, Space<V>> {
        let Stages { plan, start, displacement, increment, applied, step, .. } = &mut self.stages;
        let efforts = applied.as_ref().map_or(&[][..], |applied| &applied.efforts);
        let rotors = applied.as_ref().and_then(|applied| applied.rotors.as_ref());
        let rotors = rotors.map_or(&[][..], |rotors| &rotors.carried);
        StageUnknowns { plan, start, displacement, increment, efforts, rotors, step: *step }
    }

    fn legendre(&self, top: V) -> f64 {
        let (stages, start) = (&self.stages, self.first_legendre);
        in_lanes!(V, {
            // Loops, because closures over vectors are not inlined here.
            let mut largest = largest_coefficient(&stages.displacement[stages.plan.known()..], top);
            match self.first.latest() {
                Some(poses) => {
                    for pose in poses {
                        largest = larger(largest, largest_of_turn(&widened::<V>(pose), top, start));
                    }
                }
                None => {
                    for pose in &stages.poses {
                        largest = larger(largest, largest_of_turn(pose, top, start));
                    }
                }
            }
            largest
        })
    }

    fn furthest_turn(&self) -> Turn {
        in_lanes!(V, furthest_turn(&self.stages))
    }

    fn end_velocities(&mut self, refined: bool, velocity: &mut [f64]) -> Option<f64> {
        let SpatialWorkspace { stages, ending, gravity, .. } = self;
        if stages.plan.tumbles {
            in_lanes!(V, stages.place_tumbler(gravity));
            in_lanes!(V, ending.tumbler_velocities(stages, gravity, velocity));
            return None;
        }
        in_lanes!(V, stages.sweep_poses());
        if stages.applied.is_some() {
            in_lanes!(V, stages.sweep_applied(true));
        }
        let square = if V::GENERAL_ALONE || stages.applied.is_some() {
            in_lanes!(V, ending.velocities::<V, true, true>(stages, gravity, velocity))
        } else if refined {
            in_lanes!(V, ending.velocities::<V, true, false>(stages, gravity, velocity))
        } else {
            in_lanes!(V, ending.velocities::<V, false, false>(stages, gravity, velocity))
        };
        // The resistance of dampers is in the factors, and is no kinetic energy.
        stages.applied.is_none().then_some(square)
    }

    fn refine_velocities(&mut self, end: &Start, square: f64, velocity: &mut [f64]) -> bool {
        let SpatialWorkspace { stages, ending, gravity, .. } = self;
        let lost = have_lost_digits(square, end.energy.kinetic * stages.start.units);
        if lost {
            in_lanes!(V, ending.refine(stages, gravity, velocity, square));
        }
        lost
    }

    fn prepare_two(&mut self, mechanism: &Mechanism) -> bool {
        let SpatialWorkspace { stages, two, .. } = self;
        let has_two = mechanism.is_plain_tree() && !stages.plan.tumbles;
        if has_two {
            two.get_or_insert_with(|| Box::new(TwoEndings::new(&stages.plan, mechanism))).starts.accept(false);
        }
        has_two
    }

    fn record_end(&mut self, refined: bool, motion: usize) {
        let SpatialWorkspace { stages, ending, gravity, two: Some(two), .. } = self else { return };
        in_lanes!(V, stages.sweep_poses());
        if V::GENERAL_ALONE || refined {
            in_lanes!(V, ending.record::<V, _, true>(stages, gravity, motion, two));
        } else {
            in_lanes!(V, ending.record::<V, _, false>(stages, gravity, motion, two));
        }
    }

    fn two_velocities(&mut self, beside: &Start, velocities: [&mut [f64]; 2]) -> [f64; 2] {
        let SpatialWorkspace { stages, ending, gravity, two: Some(two), .. } = self else { return [f64::NAN; 2] };
        two.starts.join([&stages.start, beside]);
        two.velocities(&stages.plan, &ending.in_common(stages.step, gravity), velocities)
    }

    fn set_two_ends(&mut self, ends: [&mut Start; 2], mechanism: &Mechanism, states: [&State; 2]) {
        if let Some(two) = &mut self.two {
            two.starts.set(ends, mechanism, states);
        }
    }

    fn accept_two(&mut self, ends: bool) {
        if let Some(two) = &mut self.two {
            two.starts.accept(ends);
        }
    }

    fn lacks_digits(&self, end: &Start, square: f64) -> bool {
        have_lost_digits(square, end.energy.kinetic * self.stages.start.units)
    }
}
