//! First iterations in single precision.
//!
//! An increment has to be as accurate as the error that it leaves, which is a tenth of it. While increments are large, poses, residual and
//! factors are therefore worked out in single precision `~`, from displacements that are kept in double precision all along:
//!
//! ```text
//!     θ̃ = θ rounded,   H̃(q̃_k) α̃_k = −ρ̃_k(θ̃),   δ_i = Σ_k Â_ik α̃_k
//! ```
//!
//! Eight single lanes fill 256 bits. Such an iteration takes half the time if the processor has no 512-bit registers, or works on them in two halves.
//! Rounding leaves some 10⁻⁵ rad of the displacements, more where the masses of a tree differ much, and leaves it in all powers of time; a guess is
//! off in the high ones, of which an iteration leaves least. Steps that are iterated very far therefore do without, and [`FirstIterations`] finds out
//! where single precision is too little altogether.
//!
//! Iterations in double precision may keep the factors of the last such iteration ([`crate::solve::kept_factors`]).

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::Numbers;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::plan::tree::Plan;
use crate::solve::kept_factors::Chord;
use crate::stages::articulated::Eliminated;
use crate::stages::attempt::StopRule;
use crate::stages::pose::{MAX_TURN, StagePose};
use crate::stages::start::Start;
use crate::stages::workspace::Stages;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::{Body, Mechanism};
use nalgebra::{Matrix3, Vector3};

/// Increments above this (rad, m) are followed by another iteration in single precision.
const LARGE: f64 = 1e-2;
/// Increments count as no smaller than their rounding (rad, m), so that a step ends on them only if its stop is coarser.
const ROUNDED: f64 = 1e-5;
/// Steps that are iterated further than this (rad, m) begin in double precision: a bound of 1e-9 gains little if motions amplify errors, and makes
/// the errors of a run less like the errors of finer ones (doc/decisions/003-simplified-newton-iteration.md).
const FINEST: f64 = 1e-7;
/// If a moment is below this part of half the sum of a link's own, single precision leaves two digits of a factor or fewer.
const LIGHTEST: f64 = 1e-5;
/// The largest number of attempts without single precision after one that has failed: one after the first failure, twice as many after the next.
const REST: usize = 64;

/// The workspace of first iterations, and when there are any.
#[derive(Clone)]
pub(crate) struct FirstIterations<V: Lanes> {
    stages: Option<Box<Stages<V::Single>>>,
    /// Whether the attempt may begin with them.
    allowed: bool,
    /// Whether the next iteration is one of them.
    next: bool,
    /// Whether the latest one was.
    latest: bool,
    /// How many attempts do without.
    rest: usize,
    /// How many will after the next that fails.
    next_rest: usize,
}

impl<V: Lanes> FirstIterations<V> {
    /// First iterations without history.
    pub fn new() -> Self {
        FirstIterations { stages: None, allowed: false, next: false, latest: false, rest: 0, next_rest: 1 }
    }

    /// Makes room for them if steps iterated as far as `stop` benefit. They do not if all bodies only slide, because then the first iteration is the
    /// last. A body that floats freely is little work, and links that hardly resist torsion would keep rounding only.
    pub fn prepare(&mut self, mechanism: &Mechanism, plan: &Plan, tableau: &Tableau, stop: f64) {
        let turns = plan.bodies.iter().any(|body| !body.slides);
        let rounded_away = mechanism.bodies.iter().any(|body| least_moment(body) < LIGHTEST);
        if V::HAS_SINGLE && stop >= FINEST && turns && !plan.tumbles && mechanism.is_plain_tree() && !rounded_away {
            self.stages = Some(Box::new(Stages::planned(plan.clone(), mechanism, tableau)));
        }
    }

    /// An attempt at a step, that is to be iterated by a rule.
    pub fn allow(&mut self, rule: &StopRule) {
        self.allowed = rule.rough && rule.increment >= FINEST && self.rest == 0;
        self.rest = self.rest.saturating_sub(1);
        self.leave();
    }

    /// Forgets the motion: the next step starts from something else.
    pub fn forget(&mut self) {
        (self.rest, self.next_rest) = (0, 1);
    }

    /// The attempt begins, from this start.
    pub fn begin(&mut self, start: &Start, step: f64) {
        if V::HAS_SINGLE
            && self.allowed
            && let Some(stages) = self.stages.as_deref_mut()
        {
            self.next = true;
            in_lanes!(V, stages.take_start(start, step));
        }
    }

    /// Later iterations are in double precision.
    pub fn leave(&mut self) {
        (self.next, self.latest) = (false, false);
    }

    /// The attempt has failed: that is for the lack of precision, if it happens again and again.
    pub fn fail(&mut self) {
        if self.allowed {
            self.rest = self.next_rest;
            self.next_rest = (2 * self.rest).min(REST);
        }
    }

    /// An iteration in single precision, if it is time for one: finds the increments of `stages`, returns the largest.
    pub fn iterate(&mut self, stages: &mut Stages<V>, chord: &mut Chord, gravity: &[f64; 3]) -> Option<f64> {
        // Known to the compiler, so that vectors without single precision carry no code for it.
        if V::HAS_SINGLE && self.next { self.iterate_single(stages, chord, gravity) } else { None }
    }

    /// [`Self::iterate`] of vectors with single precision, when it is time for it.
    #[inline(always)]
    fn iterate_single(&mut self, stages: &mut Stages<V>, chord: &mut Chord, gravity: &[f64; 3]) -> Option<f64> {
        let single = self.stages.as_deref_mut()?;
        let keeps = chord.keeps();
        let increment = in_lanes!(V, {
            for (single, &displacement) in single.displacement.iter_mut().zip(&stages.displacement) {
                *single = displacement.narrow();
            }
            single.sweep_poses();
            if keeps {
                single.sweep_wrenches::<false>(gravity);
            } else {
                single.sweep_residual(gravity);
            }
            let largest = single.sweep_increments();
            for (increment, &single) in stages.increment.iter_mut().zip(&single.increment) {
                *increment = V::widen(single);
            }
            Numbers::largest(largest)
        });
        if increment.is_nan() || increment > MAX_TURN {
            // Out of the range of single numbers, or pure rounding, as near a gimbal lock: continue from here in double precision.
            self.fail();
            self.leave();
            self.allowed = false;
            chord.restart();
            return None;
        }
        if increment < LARGE {
            self.next = false;
            self.next_rest = 1;
        }
        self.latest = true;
        chord.see(increment);
        Some(increment.max(ROUNDED))
    }

    /// An iteration in double precision follows, which may keep the factors of the latest one, if that was one of these.
    pub fn hand_over(&mut self, stages: &mut Stages<V>) {
        if V::HAS_SINGLE
            && self.latest
            && let Some(single) = &self.stages
        {
            in_lanes!(V, {
                for (own, single) in stages.factors.eliminated.iter_mut().zip(&single.factors.eliminated) {
                    widen_factors(own, single);
                }
            });
        }
        self.latest = false;
    }

    /// The poses of the latest iteration, if it was one of these.
    pub fn latest(&self) -> Option<&[StagePose<V::Single>]> {
        if V::HAS_SINGLE && self.latest { self.stages.as_ref().map(|stages| &stages.poses[..]) } else { None }
    }
}

/// The least moment of a body about the axes of its joint, or less, over half the sum of its moments about the joint's anchor. Children of a body
/// only increase the first.
fn least_moment(body: &Body) -> f64 {
    let frame = &body.joint.on_child;
    let arm = frame.translation.vector;
    let moments = Matrix3::from_diagonal(&body.inertia)
        + (Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose()) * body.mass;
    let least = match body.joint.kind.rotation() {
        FreeRotation::None => return f64::INFINITY,
        FreeRotation::AboutZ => {
            let axis = frame.rotation * Vector3::z();
            axis.dot(&(moments * axis))
        }
        FreeRotation::Ball => body.inertia.min(),
    };
    2.0 * least / moments.trace()
}

/// A rotation in double precision, without its displacement.
#[inline(always)]
pub(crate) fn widened<V: Lanes>(pose: &StagePose<V::Single>) -> StagePose<V> {
    let [x, y, z] = pose.u.0;
    StagePose { w: V::widen(pose.w), u: Vector([V::widen(x), V::widen(y), V::widen(z)]), anchor: Vector::zero() }
}

/// The factors of an axis that an iteration may keep.
#[inline(always)]
fn widen_factors<V: Lanes>(own: &mut Eliminated<V>, single: &Eliminated<V::Single>) {
    own.inverse = V::widen(single.inverse);
    for axis in 0..3 {
        own.force_ratio.0[axis] = V::widen(single.force_ratio.0[axis]);
        own.torque_ratio.0[axis] = V::widen(single.torque_ratio.0[axis]);
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::numbers::arithmetic::Arithmetic;
    use crate::numbers::lanes::Isa;
    use crate::vectors::pair::Pair;
    use crate::vectors::portable::Portable;
    use crate::vectors::x86::{Avx256, Single};
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use catena_mechanism::motion::state::State;
    use nalgebra::{Rotation3, Translation3};

    /// Two bodies on joints of a kind and one on a hinge, on frames that are not aligned.
    fn chain(kind: JointKind) -> Mechanism {
        let body = |name: &str, parent, kind, askew: f64| {
            let frame = |at: f64| {
                let turn = Rotation3::from_euler_angles(at, askew - 0.4 * at, 0.5 - askew);
                Pose::from_parts(Translation3::new(0.3 * at, -0.1, 0.4 * askew), turn)
            };
            let joint = Joint::new(name, kind, frame(0.7), frame(-0.5));
            Body { name: name.into(), parent, mass: 1.0 + askew, inertia: Vector3::new(0.05, 0.08, 0.1), joint }
        };
        let bodies = vec![
            body("inner", None, kind, 0.9),
            body("outer", Some(0), kind, 0.2),
            body("hinged", Some(0), JointKind::Revolute, 0.5),
        ];
        Mechanism::new(kind.name(), Vector3::new(1.0, -2.0, -9.0), bodies).unwrap()
    }

    /// The increments of an iteration with new factors from where the step starts, and of the next, which keeps them.
    fn increments<N: Numbers>(mechanism: &Mechanism, lane: impl Fn(N, usize) -> f64) -> [Vec<f64>; 2] {
        let tableau = Tableau::of(9).unwrap();
        let mut state = State::zero(mechanism);
        for (freedom, rate) in state.velocity.iter_mut().enumerate() {
            *rate = (2.0 + 3.0 * freedom as f64).sin();
        }
        let mut exact = Stages::<Portable<8>>::new(mechanism, tableau, &[]);
        exact.start.set(mechanism, &state);
        let mut stages = Stages::<N>::unforced(mechanism, tableau, &[]);
        stages.take_start(&exact.start, 0.05);
        let gravity = mechanism.gravity.into();
        let all = |stages: &Stages<N>| {
            stages.increment.iter().flat_map(|&own| [0, 3, 7].map(|stage| lane(own, stage))).collect::<Vec<f64>>()
        };
        stages.sweep_poses();
        stages.sweep_residual(&gravity);
        stages.sweep_increments();
        let full = all(&stages);
        stages.advance();
        stages.sweep_poses();
        stages.sweep_wrenches::<false>(&gravity);
        stages.sweep_increments();
        [full, all(&stages)]
    }

    #[test]
    fn an_iteration_in_single_precision_has_the_increments_of_one_in_double_precision_to_its_digits() {
        if Isa::detect() == Isa::Portable {
            println!("skipped: this processor has no AVX2");
            return;
        }
        use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
        for kind in [Revolute, Prismatic, Planar, Spherical, Floating] {
            let mechanism = chain(kind);
            let double = Avx256::run(|| increments::<Pair<Avx256, 8>>(&mechanism, Arithmetic::lane));
            let single =
                Avx256::run(|| increments::<Single>(&mechanism, |own, lane| f64::from(Arithmetic::lane(own, lane))));
            for (which, (double, single)) in ["full", "kept"].into_iter().zip(double.iter().zip(&single)) {
                let apart = double.iter().zip(single).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                let largest = double.iter().copied().map(f64::abs).fold(0.0, f64::max);
                println!("{}, {which}: {apart:.1e} of {largest:.1e}", kind.name());
                // 6e-8 of displacements of some tenths, which the mixing of nine stages and light bodies on heavy ones magnify by some 1e3.
                assert!(apart > 0.0 && apart < 1e-4, "{}, {which}: {apart:.1e} apart", kind.name());
                // The stages differ by enough to be told apart.
                assert!(largest > 100.0 * apart, "{}, {which}: {largest:.1e}", kind.name());
            }
        }
    }
}
