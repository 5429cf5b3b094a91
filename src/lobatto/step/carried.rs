//! The data of a companion motion: its start, and its distance from the main motion at the stages of a step
//! ([`crate::step::carrying`]).

use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{add_to, largest_coefficient};
use crate::stages::extrapolation::Extrapolation;
use crate::stages::unknowns::Unknowns;
use crate::step::workspace::Workspace;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;

/// The carried motion.
#[derive(Clone)]
pub(crate) struct Carried<V, S> {
    /// The start of its next step.
    pub(crate) start: S,
    /// The end of the carried motion.
    pub(crate) end: S,
    /// `θ` of the first motion.
    pub(crate) solved: Vec<V>,
    /// `δ`, of the freedoms that are iterated.
    pub(crate) apart: Vec<V>,
    /// `v_y − v` at the start of the step.
    pub(crate) rates: Vec<f64>,
    /// Whether both motions end at once, its displacements and velocities at the end then, and whether both ends were set at once.
    pub(crate) at_once: bool,
    pub(crate) displaced: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) both_set: bool,
    pub(crate) past: Extrapolation<V>,
}

impl<V: Lanes, S> Carried<V, S> {
    /// Room for a mechanism with this number of degrees of freedom, of which some are iterated.
    pub(crate) fn new<W: Workspace<V, Start = S>>(
        mechanism: &Mechanism,
        freedoms: usize,
        iterated: usize,
        tableau: &Tableau,
    ) -> Self {
        Carried {
            start: W::new_start(mechanism),
            end: W::new_start(mechanism),
            solved: vec![V::zero(); freedoms],
            apart: vec![V::zero(); iterated],
            rates: vec![0.0; iterated],
            at_once: false,
            displaced: vec![0.0; freedoms],
            velocity: vec![0.0; freedoms],
            both_set: false,
            past: Extrapolation::new(iterated, tableau),
        }
    }

    /// Takes the place of the first motion in a workspace, with a guess of the distance.
    pub(crate) fn part_from<W: Workspace<V, Start = S>>(&mut self, workspace: &mut W) {
        self.solved.copy_from_slice(workspace.displacement());
        let first = workspace.unknowns();
        for (own, &rate) in self.rates.iter_mut().zip(first.rates) {
            *own = -rate;
        }
        std::mem::swap(workspace.start_mut(), &mut self.start);
        let Unknowns { displacement, rates, step, coefficients } = workspace.unknowns();
        for (own, &rate) in self.rates.iter_mut().zip(rates) {
            *own += rate;
        }
        let (past, rates) = (&mut self.past, &self.rates[..]);
        let apart = &mut self.apart[..];
        in_lanes!(V, {
            if past.has_past() {
                past.guess(Unknowns { displacement: apart, rates, step, coefficients });
            } else {
                for (apart, &rate) in apart.iter_mut().zip(rates) {
                    *apart = coefficients.nodes * V::splat(step * rate);
                }
            }
            add_to(displacement, apart);
        });
    }

    /// Moves the end of the step by its truncation. The freedom with the largest top Legendre coefficient `Σ_i L_i θ_i` moves by `truncation` (rad,
    /// m), and the others in proportion to theirs, so that freedoms held by a symmetry of the motion stay.
    pub(crate) fn truncate(&self, top: V, truncation: f64, displaced: &mut [f64]) {
        in_lanes!(V, {
            let share = truncation / largest_coefficient(&self.solved, top).max(f64::MIN_POSITIVE);
            for (displaced, &solved) in displaced.iter_mut().zip(&self.solved) {
                *displaced += share * (solved * top).sum();
            }
        });
    }

    /// Takes the distance of the motions in the solved step.
    pub(crate) fn part<W: Workspace<V, Start = S>>(&mut self, workspace: &mut W) {
        let known = workspace.known();
        let (apart, solved) = (&mut self.apart[..], &self.solved[known..]);
        let Unknowns { displacement, .. } = workspace.unknowns();
        in_lanes!(V, {
            for ((apart, &own), &first) in apart.iter_mut().zip(displacement.iter()).zip(solved) {
                *apart = own - first;
            }
        });
    }

    /// Learns from the distance of the motions in the step.
    pub(crate) fn learn<W: Workspace<V, Start = S>>(&mut self, workspace: &mut W) {
        let Unknowns { step, coefficients, .. } = workspace.unknowns();
        let (past, rates, apart) = (&mut self.past, &self.rates[..], &mut self.apart[..]);
        in_lanes!(V, past.learn(&Unknowns { displacement: apart, rates, step, coefficients }));
    }

    /// Exchanges both motions in a workspace that has solved both.
    pub(crate) fn exchange<W: Workspace<V, Start = S>>(&mut self, workspace: &mut W) {
        std::mem::swap(workspace.start_mut(), &mut self.start);
        workspace.advanced().0.swap_with_slice(&mut self.solved);
    }
}
