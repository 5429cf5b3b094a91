//! The workspace of the forces at the stages of a step: efforts along the freedoms, wrenches on the bodies, and their terms. The equations are in
//! [`crate::equations::forces`].

use crate::numbers::algebra::Vector;
use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::numbers::reductions::at_end;
use crate::plan::forces::AppliedPlan;
use crate::stages::coefficients::row_stage;
use crate::stages::force_motion::Place;
use crate::stages::rotors::Rotors;
use crate::tableau::butcher::Tableau;
use crate::tableau::dampers::damper_shares;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
/// The forces on a mechanism at the stages of a step.
#[derive(Clone)]
pub struct Applied<V> {
    /// Effort on each degree of freedom, conjugate to its displacement [N m or N]: it enters the row of that freedom.
    pub efforts: Vec<V>,
    /// Force (N) and torque about the anchor [N m] on each body, in world axes, of all that does not act in joints.
    pub wrenches: Vec<(Vector<V>, Vector<V>)>,
    /// `c` of the dampers along each degree of freedom; times h and κ of the rows it is their addition to its inertia.
    pub resistance: Vec<f64>,
    /// κ of each row ([`crate::tableau::dampers`]).
    pub(crate) shares: V,
    /// Energy that the finished step dissipated, and the work put into it (J).
    pub exchange: Exchange,
    pub(crate) plan: AppliedPlan,
    /// The time at the start of the step (s), for forces that change.
    pub(crate) time: f64,
    /// Rotors that are geared to joints.
    pub(crate) rotors: Option<Rotors<V>>,
    /// Efforts that change in time, at the stages of the attempt.
    pub(crate) changing: Vec<Changing<V>>,
    /// The place whose velocities the rows take.
    pub(crate) rows: Place<V>,
    /// The same with the end of the step in the last lane.
    pub(crate) end: Place<V>,
}

/// An effort along a scalar coordinate that changes in time.
#[derive(Clone)]
pub(crate) struct Changing<V> {
    pub(crate) freedom: usize,
    /// At the stages of the rows, and of the end of the step.
    pub(crate) rows: V,
    pub(crate) end: V,
}

impl<V: Copy> Applied<V> {
    /// Minus the residual of the rotor of a degree of freedom, or its momentum at the end of the step, and its inertia; `None` without rotors.
    #[inline(always)]
    pub(crate) fn rotor(&self, freedom: usize) -> Option<(V, f64)> {
        self.rotors.as_ref().map(|rotors| (rotors.carried[freedom], rotors.inertia[freedom]))
    }
}

impl<V: Lanes> Applied<V> {
    /// Room for the forces and rotors of a mechanism; `None` without them.
    pub fn new(mechanism: &Mechanism, tableau: &Tableau) -> Option<Box<Self>> {
        if mechanism.is_unforced() {
            return None;
        }
        let active = tableau.stages - 1;
        let place = |stage_of_lane: &dyn Fn(usize) -> usize, weight_of_lane: &dyn Fn(usize) -> f64| {
            let lanes = |value: &dyn Fn(usize) -> f64| V::from_slice(&(0..active).map(value).collect::<Vec<f64>>());
            let mut velocity = [V::zero(); MAX_LANES];
            for (column, lane_values) in velocity.iter_mut().enumerate().take(active) {
                *lane_values = lanes(&|lane| tableau.velocity[stage_of_lane(lane) * active + column]);
            }
            let moved = lanes(&|lane| if stage_of_lane(lane) == 0 { 0.0 } else { 1.0 });
            let nodes = lanes(&|lane| tableau.nodes[stage_of_lane(lane)]);
            Place { velocity, moved, weights: lanes(weight_of_lane), nodes }
        };
        let row_stage = |lane: usize| row_stage(lane, active);
        let end_weight = |lane: usize| if lane + 1 == active { tableau.weights[active] } else { 0.0 };
        let share = |lane: usize| damper_shares(tableau)[row_stage(lane)];
        let shares = V::from_slice(&(0..active).map(share).collect::<Vec<f64>>());
        let mut resistance = vec![0.0; mechanism.velocity_count];
        for damper in &mechanism.forces.joint_dampers {
            resistance[damper.freedom] += damper.coefficient;
        }
        Some(Box::new(Applied {
            efforts: vec![V::zero(); mechanism.velocity_count],
            wrenches: vec![(Vector::zero(), Vector::zero()); mechanism.bodies.len()],
            resistance,
            shares,
            exchange: Exchange::default(),
            plan: AppliedPlan::new(mechanism),
            time: 0.0,
            rotors: Rotors::new(mechanism, tableau),
            changing: Vec::new(),
            rows: place(&row_stage, &|lane| tableau.weights[row_stage(lane)]),
            end: place(&|lane| lane + 1, &end_weight),
        }))
    }

    /// Takes the time at the start of the next step (s).
    pub fn clock(&mut self, time: f64) {
        self.time = time;
    }

    /// Takes the efforts that drive the joints in the next step.
    pub fn drive(&mut self, efforts: &[f64]) {
        self.plan.drive(efforts);
    }

    /// Takes the efforts along some freedoms at all stages of the next attempt, freedom after freedom. Allocates at the first time alone.
    pub fn change(&mut self, freedoms: &[usize], at_stages: &[f64], stages: usize) {
        let active = stages - 1;
        if self.changing.len() != freedoms.len() {
            let new = |&freedom| Changing { freedom, rows: V::zero(), end: V::zero() };
            self.changing = freedoms.iter().map(new).collect();
        }
        for ((changing, &freedom), efforts) in self.changing.iter_mut().zip(freedoms).zip(at_stages.chunks(stages)) {
            let mut lanes = [[0.0; MAX_LANES]; 2];
            for lane in 0..active {
                lanes[0][lane] = efforts[row_stage(lane, active)];
                lanes[1][lane] = efforts[lane + 1];
            }
            changing.freedom = freedom;
            [changing.rows, changing.end] = lanes.map(|lanes| V::from_slice(&lanes[..active]));
        }
    }

    /// Work of the efforts that drive scalar coordinates over a solved step (J): the effort times the displacement at its end.
    #[inline(always)]
    pub(crate) fn driven_work(&self, displacement: &[V], active: usize) -> f64 {
        self.plan.driven.iter().map(|&(freedom, effort)| effort * at_end(displacement[freedom], active)).sum()
    }
}
