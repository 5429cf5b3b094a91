//! The inside of a step: which polynomial each degree of freedom is interpolated by, and the error of samples.
//!
//! The velocities at the ends of a step add a part of the size `S` and of degree `s`, and one of the size `B` and of degree `s + 1`, to the
//! polynomial through the stages ([`catena_lobatto::tableau::dense`]). In a smooth motion these are its next coefficients, and small. A damper that
//! is too hard for the step hardly changes the velocities at the ends, while the displacements are right: the contribution of the velocities is an
//! error then. In steps with such a damper a freedom is interpolated through the stages alone where `S + B` is more than half of its own top Legendre
//! coefficient `E_i`.
//!
//! The error of samples inside a step of `s` stages, from the largest top Legendre coefficient `E` of the step, and from `S + B`, `E_i` and the
//! [lever](crate::instants::levers) `l` of each freedom:
//!
//! ```text
//!     w = max l c_s √(S + B) E^{3/4},    or max ½ l E_i of those that are interpolated through the stages alone
//! ```
//!
//! with the constants measured in `doc/decisions/005-samples-between-steps.md`.

use crate::instants::levers::levers;
use crate::instants::sampling::{Interpolation, LastStep};
use catena_lobatto::tableau::butcher::Tableau;
use catena_lobatto::tableau::dense::DenseRule;
use catena_mechanism::description::forces::Forces;
use catena_mechanism::description::mechanism::Mechanism;

/// `c_s` of the stages that chosen steps have.
const FIVE: f64 = 1.0;
const NINE: f64 = 4.0;
/// The error of samples of a freedom that is interpolated through the stages alone, over `E_i`.
const ALONE: f64 = 0.5;
/// The part of `E_i` above which end velocities do not belong to the motion.
const ADDED: f64 = 0.5;

/// The inside of the last step.
#[derive(Clone)]
pub(crate) struct Inside {
    rule: DenseRule,
    /// The weights of the stages 2 … s in a top Legendre coefficient.
    top: &'static [f64],
    /// `c_s`, where it was measured.
    factor: Option<f64>,
    /// For each degree of freedom, whether it is interpolated through the stages alone.
    alone: Vec<bool>,
    /// Whether any degree of freedom is.
    any_alone: bool,
    /// Motion of the bodies per displacement of each freedom (1, m).
    levers: Vec<f64>,
    /// The largest error of samples of freedoms that were interpolated through the stages alone, so far (m).
    ringing: f64,
    /// Room for sums over the stages, with the weights of two polynomials.
    sums: Vec<[f64; 2]>,
    other_sums: Vec<[f64; 2]>,
}

/// Whether there are dampers, one of which may be too hard for a step.
pub(crate) fn has_dampers(forces: &Forces) -> bool {
    let between_points = forces.point_springs.iter().any(|spring| spring.damping > 0.0);
    !forces.joint_dampers.is_empty() || between_points || !forces.drags.is_empty()
}

impl Inside {
    /// For steps of a scheme and a mechanism.
    pub fn new(tableau: &'static Tableau, mechanism: &Mechanism) -> Self {
        let freedoms = mechanism.velocity_count;
        let factor = match tableau.stages {
            5 => Some(FIVE),
            9 => Some(NINE),
            _ => None,
        };
        Inside {
            rule: DenseRule::new(tableau),
            top: &tableau.top_legendre[1..],
            factor,
            alone: vec![false; freedoms],
            any_alone: false,
            levers: levers(mechanism),
            ringing: 0.0,
            sums: vec![[0.0; 2]; freedoms],
            other_sums: vec![[0.0; 2]; freedoms],
        }
    }

    /// Looks at the last step, of which the largest top Legendre coefficient is `legendre` (rad, m): chooses the polynomials, with a damper that is
    /// too hard for the step or without, and returns the error of samples (m), where it is known.
    pub fn look(&mut self, mechanism: &Mechanism, last: &LastStep, too_hard: bool, legendre: f64) -> Option<f64> {
        let Inside { rule, top, factor, alone, any_alone, levers, ringing, sums, other_sums } = self;
        *any_alone = false;
        if too_hard {
            last.kernel.weigh_displacements([top, top], other_sums);
        }
        last.kernel.weigh_displacements(rule.end_slopes(last.inner), sums);
        let (mut largest, mut largest_alone) = (0.0_f64, 0.0_f64);
        last.for_each_freedom(mechanism, |freedom, start, end| {
            let lever = levers[freedom];
            let added: f64 = rule.additions(sums[freedom], start, end).iter().sum();
            let own = if too_hard { other_sums[freedom][0].abs() } else { f64::INFINITY };
            alone[freedom] = added > ADDED * own;
            if alone[freedom] {
                *any_alone = true;
                largest_alone = largest_alone.max(ALONE * lever * own);
            } else {
                largest = largest.max(lever * lever * added);
            }
        });
        *ringing = ringing.max(largest_alone);
        factor.map(|factor| (factor * (largest * legendre * legendre.sqrt()).sqrt()).max(largest_alone))
    }

    /// The largest error of samples in steps that are too long for a damper, so far (m).
    pub fn ringing(&self) -> f64 {
        self.ringing
    }

    /// Writes positions and velocities at the point `x` of the last step, from 0 to 1. Does not allocate.
    pub fn sample(
        &mut self,
        mechanism: &Mechanism,
        last: &LastStep,
        x: f64,
        position: &mut [f64],
        velocity: &mut [f64],
    ) {
        let Inside { rule, alone, any_alone, sums, other_sums, .. } = self;
        let both = Interpolation::new(last, rule.weights(x), sums);
        let nodes = any_alone.then(|| Interpolation::new(last, rule.weights_of_nodes(x), other_sums));
        last.sample(mechanism, &both, nodes.as_ref().map(|nodes| (nodes, &alone[..])), position, velocity);
    }
}
