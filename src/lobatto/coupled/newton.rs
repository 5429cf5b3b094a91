//! The exact Newton method on the stage equations: the residuals of all bodies and closures, and the coupled solve, in any [`Geometry`].
//!
//! ```text
//!     Σ_i D_ki η_i − J_kᵀ dλ_k = −(E_k − J_kᵀ λ_k),     J_i η_i + ε Σ_k Â_ik dλ_k = −g_i,     λ ← λ + dλ
//! ```
//!
//! The twists of all bodies are η, their residuals `E_k` [kg m, kg m²: h² times a force and its torque], the multipliers of the closures
//! `λ_k = h² Λ_k` and their gaps `g_i` (m, rad): [`crate::coupled::system`], which has the elimination. A mimic is a closure of two freedoms,
//! `g = q_follower − ratio · q_leader − offset`. A joint that is moved in time has `g_i = q_i − r(t₀ + c_i h)`, and its drive puts in the work
//! `h Σ_k b_k Λ_k ṙ(t₀ + c_k h)` (J); the last stage is that of the projection of velocities.

use crate::coupled::known::Known;
use crate::coupled::system::{Coupled, Geometry, Screw};
use crate::coupled::touching::Touching;
use crate::numbers::lanes::{Lanes, MAX_LANES, in_lanes};
use crate::numbers::reductions::largest;
use crate::plan::elimination::TWIST;
use crate::stages::coefficients::row_stage;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::closure::Mimic;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;

/// An iteration in which friction has not the direction of the slips is not the last, however small its increments are.
const LAGS: f64 = 1e-9;

/// The exact Newton method for one mechanism and scheme.
#[derive(Clone)]
pub(crate) struct Newton<V: Lanes, G: Geometry<V>> {
    coupled: Coupled<V>,
    geometry: G,
    mimics: Mimics,
}

/// A step that the method solves.
pub(crate) struct StageUnknowns<'s, V: Lanes, G: Geometry<V>> {
    pub plan: &'s G::Plan,
    pub start: &'s G::Start,
    /// Displacement of every freedom at the stages 2 … s (rad, m).
    pub displacement: &'s [V],
    /// To be found (rad, m).
    pub increment: &'s mut [V],
    /// Efforts of forces along every freedom in the rows [N m, N]; empty without forces.
    pub efforts: &'s [V],
    /// Minus the residual of the rotor of every freedom [kg m² or kg m]; empty without rotors.
    pub rotors: &'s [V],
    /// Length of the step (s).
    pub step: f64,
}

impl<V: Lanes, G: Geometry<V>> Newton<V, G> {
    /// The workspace, over a geometry of all stages with the lines of springs.
    pub fn new(mechanism: &Mechanism, geometry: G, tableau: &'static Tableau) -> Self {
        let coupled = Coupled::of_stages(mechanism, &geometry, tableau);
        Newton { coupled, geometry, mimics: Mimics::new(mechanism, tableau) }
    }

    /// Takes the start of a step, and the ranks and flags of its closures.
    pub fn begin(&mut self, plan: &G::Plan, start: &G::Start, known: Option<&Known>) {
        if let Some(known) = known {
            self.coupled.known.copy_from(known);
        }
        self.geometry.begin(plan, start);
        self.coupled.begin();
    }

    /// The geometry, in which the caller places the bodies before every iteration, and the wrenches of the bodies about the common origin, which the
    /// caller writes.
    pub fn bodies(&mut self) -> (&mut G, &mut [Screw<V>]) {
        (&mut self.geometry, &mut self.coupled.bias)
    }

    /// The contacts, if any has friction.
    pub fn rubbing(&self) -> Option<&Touching<V>> {
        self.geometry.touching().filter(|touching| !touching.leans().is_empty())
    }

    /// Whether contacts exchange energy with what is no body.
    pub fn exchanges(&self) -> bool {
        self.geometry.touching().is_some_and(Touching::exchanges)
    }

    /// Energy that friction dissipated in the rows of a solved step, and the work of driven surfaces (J), after the bodies are placed.
    pub fn exchanged(&self) -> Exchange {
        let Coupled { multipliers, .. } = &self.coupled;
        let touching = self.geometry.touching();
        let of = |touching: &Touching<V>| touching.exchanged(self.coupled.rows_of_touches(touching), multipliers);
        touching.map_or(Exchange::default(), of)
    }

    /// Takes the time at the start of the next step (s).
    pub fn clock(&mut self, time: f64) {
        self.mimics.time = time;
    }

    /// Work of the joints that are moved in time in the rows of a solved step (J).
    pub fn moving_work(&self) -> f64 {
        self.mimics.work(&self.coupled)
    }

    /// Writes the forces (N) on the second ends of loops and contacts at the rows' stages of a solved step of this length (s), stage after stage of each;
    /// whether there are forces in space.
    pub fn closure_forces(&self, step: f64, forces: &mut Vec<[f64; 3]>) -> bool {
        let in_space = G::WIDTH == TWIST;
        forces.clear();
        let closures = if in_space { self.coupled.loops } else { 0 };
        (0..closures).for_each(|closure| self.coupled.closure_forces(closure, step, forces));
        in_space
    }

    /// One iteration, after the bodies are placed: fills the increments, advances the multipliers; returns the largest increment.
    pub fn solve(&mut self, stages: StageUnknowns<'_, V, G>) -> f64 {
        let Newton { coupled, geometry, mimics } = self;
        let StageUnknowns { plan, start, displacement, increment, efforts, rotors, step } = stages;
        coupled.step = step;
        in_lanes!(V, coupled.evaluate(geometry));
        coupled.keep_gaps_of_motions(geometry, plan, start, displacement);
        let lags = geometry.touching_mut().is_some_and(|touching| coupled.turn(touching));
        mimics.gaps(coupled, G::mimic_gaps(start), displacement);
        in_lanes!(V, {
            let square = V::splat(step * step);
            for (scaled, &effort) in coupled.efforts.iter_mut().zip(efforts) {
                *scaled = effort * square;
            }
            for (scaled, &carried) in coupled.efforts.iter_mut().zip(rotors) {
                *scaled = *scaled + carried;
            }
        });
        in_lanes!(V, coupled.push());
        coupled.solve(geometry, plan, start, displacement, increment);
        coupled.known.locked_freedoms().for_each(|freedom| increment[freedom] = V::zero());
        in_lanes!(V, coupled.advance_multipliers());
        coupled.share_multipliers(geometry, plan, start, displacement);
        let largest = in_lanes!(V, largest(increment));
        if lags { largest.max(LAGS) } else { largest }
    }
}

/// The mimics of a mechanism, at the stages of a step.
#[derive(Clone)]
struct Mimics {
    all: Vec<Mimic>,
    tableau: &'static Tableau,
    /// At the start of the step (s).
    time: f64,
}

impl Mimics {
    /// The method for a mechanism.
    fn new(mechanism: &Mechanism, tableau: &'static Tableau) -> Self {
        Mimics { all: mechanism.mimics.clone(), tableau, time: 0.0 }
    }

    /// Their gaps at all stages, from the gaps at the start of the step and the displacements since.
    fn gaps<V: Lanes>(&self, coupled: &mut Coupled<V>, start: &[f64], displacement: &[V]) {
        for (row, (&gap, mimic)) in coupled.mimic_rows().zip(start.iter().zip(&self.all)) {
            let (follows, leads) = (displacement[mimic.follower.freedom], displacement[mimic.leader.freedom]);
            coupled.gaps[row] = leads.neg_mul_add(V::splat(mimic.multiplier), follows + V::splat(gap));
            for (own, ratio) in &mimic.more {
                coupled.gaps[row] = displacement[own.freedom].neg_mul_add(V::splat(*ratio), coupled.gaps[row]);
            }
            if mimic.is_moved() {
                let [place, ..] = mimic.motion(self.time, self.time);
                let moved =
                    self.at_stages(coupled.step, |stage| stage + 1, |time| mimic.motion(self.time, time)[0] - place);
                coupled.gaps[row] = coupled.gaps[row] - moved;
            }
        }
    }

    /// A function of time at a stage of each lane.
    fn at_stages<V: Lanes>(&self, step: f64, stage: impl Fn(usize) -> usize, value: impl Fn(f64) -> f64) -> V {
        let mut lanes = [0.0; MAX_LANES];
        let active = self.tableau.stages - 1;
        for (lane, own) in lanes[..active].iter_mut().enumerate() {
            *own = value(self.time + step * self.tableau.nodes[stage(lane)]);
        }
        V::from_slice(&lanes[..active])
    }

    /// `h⁻¹ Σ_k b_k λ_k ṙ_k` over the rows (J).
    fn work<V: Lanes>(&self, coupled: &Coupled<V>) -> f64 {
        let active = self.tableau.stages - 1;
        let mut work = 0.0;
        for (row, mimic) in coupled.mimic_rows().zip(&self.all).filter(|(_, mimic)| mimic.is_moved()) {
            let stage = |lane: usize| row_stage(lane, active);
            let rates: V = self.at_stages(coupled.step, stage, |time| mimic.motion(self.time, time)[1]);
            let powers = (coupled.multipliers[row] * rates).to_array();
            let powers = powers.as_ref()[..active].iter().enumerate();
            work += powers.map(|(lane, power)| self.tableau.weights[stage(lane)] * power).sum::<f64>() / coupled.step;
        }
        work
    }
}
