//! The workspace of a step of a mechanism that moves in a plane: three coordinates a body instead of six.
//!
//! The same scheme and the same iteration as in space ([`crate::step::spatial`]), with SO(2) embedded in R² instead of SO(3) in R⁹. Omitted terms are
//! zero in a plane, so both take the same steps, but for rounding.
//!
//! ```text
//!     turns and paths of all stages from θ       planar/sweeps.rs         g(Q_i) = 0 to rounding at every iterate
//!     forces F_k, if there are any               planar/forces.rs
//!     residual ρ_k, factors of H(q_k)            planar/sweeps.rs, planar/articulated.rs
//!     or ρ_k alone, with factors kept            planar/kept_factors.rs
//!     δ_i = Σ_k Â_ik α_k,  H(q_k) α_k = −ρ_k     planar/sweeps.rs
//!     velocity from H(q̄) v̄ = Sᵀ p̄                the same sweeps with the momentum weights        (2.5.11h)
//! ```

use crate::coupled::newton::StageUnknowns;
use crate::coupled::system::Screw;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::planar::geometry::Flat;
use crate::planar::start::{PlanarPlan, PlanarStart};
use crate::planar::workspace::PlanarStages;
use crate::stages::coefficients::Coefficients;
use crate::stages::forces::Applied;
use crate::stages::momenta::MomentumWeights;
use crate::stages::pose::Turn;
use crate::stages::unknowns::Unknowns;
use crate::step::workspace::Workspace;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::plane::Plane;

/// [`Workspace`] in a plane.
#[derive(Clone)]
pub(crate) struct PlanarWorkspace<V: Lanes> {
    stages: PlanarStages<V>,
    coefficients: Coefficients<V>,
    weights: MomentumWeights<V>,
    /// Gravity in the plane [m/s²]; zero along the normal.
    gravity: [f64; 3],
    plane: Plane,
}

impl<V: Lanes> PlanarWorkspace<V> {
    /// The workspace for a mechanism in its plane and a scheme.
    pub fn new(mechanism: &Mechanism, plane: &Plane, tableau: &Tableau) -> Self {
        let stages = PlanarStages::new(mechanism, plane, tableau);
        PlanarWorkspace {
            coefficients: Coefficients::new(tableau),
            weights: MomentumWeights::new(tableau),
            gravity: stages.plan.gravity,
            plane: *plane,
            stages,
        }
    }
}

impl<V: Lanes> Workspace<V> for PlanarWorkspace<V> {
    type Plan = PlanarPlan;
    type Start = PlanarStart;
    type Geometry<L: Lanes> = Flat<L>;

    fn new_start(mechanism: &Mechanism) -> PlanarStart {
        PlanarStart::new(mechanism)
    }

    fn energy(start: &PlanarStart) -> Energy {
        start.energy
    }

    fn full_plan(&self, mechanism: &Mechanism) -> PlanarPlan {
        PlanarPlan::new(mechanism, &self.plane)
    }

    fn geometry<L: Lanes>(&self, mechanism: &Mechanism, tableau: Option<&Tableau>) -> Flat<L> {
        Flat::new(mechanism, &self.plane, tableau)
    }

    fn start(&self) -> &PlanarStart {
        &self.stages.start
    }

    fn start_mut(&mut self) -> &mut PlanarStart {
        &mut self.stages.start
    }

    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        self.stages.start.set(&self.stages.plan, mechanism, state);
    }

    fn set_end(&self, end: &mut PlanarStart, mechanism: &Mechanism, state: &State) {
        end.set(&self.stages.plan, mechanism, state);
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
        self.stages.unknowns(&self.coefficients)
    }

    fn applied(&self) -> Option<&Applied<V>> {
        self.stages.applied.as_deref()
    }

    fn applied_mut(&mut self) -> Option<&mut Applied<V>> {
        self.stages.applied.as_deref_mut()
    }

    const TAKES_BOUND: bool = true;

    fn bound(&mut self, largest: f64) {
        self.stages.largest = largest;
    }

    fn set_step(&mut self, step: f64) {
        self.stages.step = step;
    }

    /// The velocities at the end have overwritten them, with different dampers if the mechanism has dampers.
    fn has_factors(&self) -> bool {
        self.stages.applied.is_none()
    }

    fn is_general(&self) -> bool {
        self.stages.is_general()
    }

    fn iterate(&mut self, keeps: bool, refined: bool) -> f64 {
        let PlanarWorkspace { stages, coefficients, gravity, .. } = self;
        // Vectors that carry the general sweeps alone are not compiled with the others.
        if V::GENERAL_ALONE || stages.applied.is_some() {
            if keeps {
                in_lanes!(V, stages.increments::<true, true, true>(coefficients, gravity))
            } else {
                in_lanes!(V, stages.increments::<true, true, false>(coefficients, gravity))
            }
        } else {
            match (keeps, refined) {
                // Increments that settle are small.
                (_, true) => in_lanes!(V, stages.increments::<true, false, true>(coefficients, gravity)),
                (true, false) => in_lanes!(V, stages.increments::<false, false, true>(coefficients, gravity)),
                (false, false) => in_lanes!(V, stages.increments::<false, false, false>(coefficients, gravity)),
            }
        }
    }

    fn place_stages(&mut self, geometry: &mut Flat<V>, bias: &mut [Screw<V>]) {
        let PlanarWorkspace { stages, coefficients, gravity, .. } = self;
        in_lanes!(V, geometry.place_stages(stages, coefficients, gravity, bias));
    }

    fn stage_unknowns(&mut self) -> StageUnknowns<'_, V, Flat<V>> {
        let PlanarStages { plan, start, displacement, increment, applied, step, .. } = &mut self.stages;
        let efforts = applied.as_ref().map_or(&[][..], |applied| &applied.efforts);
        let rotors = applied.as_ref().and_then(|applied| applied.rotors.as_ref());
        let rotors = rotors.map_or(&[][..], |rotors| &rotors.carried);
        StageUnknowns { plan, start, displacement, increment, efforts, rotors, step: *step }
    }

    fn legendre(&self, top: V) -> f64 {
        in_lanes!(V, self.stages.largest_coefficient(top))
    }

    fn furthest_turn(&self) -> Turn {
        in_lanes!(V, self.stages.furthest_turn())
    }

    fn end_velocities(&mut self, refined: bool, velocity: &mut [f64]) -> Option<f64> {
        let PlanarWorkspace { stages, coefficients, weights, gravity, .. } = self;
        if V::GENERAL_ALONE || stages.applied.is_some() {
            in_lanes!(V, stages.end_velocities::<true, true>(coefficients, weights, gravity, velocity));
        } else if refined {
            in_lanes!(V, stages.end_velocities::<true, false>(coefficients, weights, gravity, velocity));
        } else {
            in_lanes!(V, stages.end_velocities::<false, false>(coefficients, weights, gravity, velocity));
        }
        None
    }
}
