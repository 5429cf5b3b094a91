//! The start of a step to 32 digits, carried along from the end of the step before.
//!
//! At the end of a step a body has the turn `N` and the anchor displacement `Δa` (its parent has the index `p`), in world axes:
//!
//! ```text
//!     arm ← arm + Δa − Δa_p        com ← (1 + N) com        Σ ← (1 + N) Σ (1 + N)ᵀ
//!     s ← (1 + N) s for rotations, (1 + N_p) s for translations
//!     ω = ω_p + Σ s q̇              v_a = v_a,p + ω_p × arm + Σ s q̇,      v = v_a + ω × com
//! ```
//!
//! Axes are made unit vectors again; other vectors that turn together lose 10⁻³² of their lengths and angles a step.

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::double::Double;
use crate::numbers::extended::Extended;
use crate::numbers::lanes::Lanes;
use crate::numbers::rotations::rotate_increment;
use crate::plan::tree::{BodyPlan, Plan};
use crate::stages::pose::StagePose;
use crate::stages::start::{BodyStart, Pivot, Start};
use crate::stages::workspace::Stages;
use catena_mechanism::description::joint::FreeRotation;

/// A vector of 32 digits.
type Long = [Extended; 3];

/// The vector of one lane.
#[inline(always)]
fn of_lane<V: Lanes>(vector: Vector<Double<V>>, lane: usize) -> Long {
    vector.0.map(|component| component.lane(lane))
}

/// Takes a start of sixteen digits, and makes of it one that is good to 32.
#[inline(always)]
pub(crate) fn widen<V: Lanes>(plan: &Plan, start: &Start, gravity: &[f64; 3], wide: &mut Start<Extended>) {
    wide.take(start, Double::<V>::real);
    for (index, own) in plan.bodies.iter().enumerate() {
        straighten::<V>(own, &mut wide.axes);
        set_velocity::<V>(own, index, wide);
        set_pivot::<V>(own, index, gravity, wide);
    }
}

/// Makes the axes of a joint, which nearly are, unit vectors to 32 digits, and the axes of a ball joint normal to each other. A rotation about
/// another vector would stretch all vectors, axes included, so that the error would grow from step to step.
#[inline(always)]
fn straighten<V: Lanes>(own: &BodyPlan, axes: &mut [Long]) {
    for axis in &mut axes[own.freedoms()] {
        *axis = of_lane(unit(Vector::<Double<V>>::splat(axis)), 0);
    }
    if own.rotation == FreeRotation::Ball {
        let first = own.first_axis + own.translations;
        let x = Vector::<Double<V>>::splat(&axes[first]);
        let y = Vector::splat(&axes[first + 1]);
        let y = unit(x.times_minus(x.dot(y), y));
        axes[first + 1] = of_lane(y, 0);
        axes[first + 2] = of_lane(x.cross(y), 0);
    }
}

/// A vector that is nearly a unit vector, made one: `a (3 − |a|²)/2`, a step of Newton's method.
#[inline(always)]
fn unit<V: Lanes>(axis: Vector<Double<V>>) -> Vector<Double<V>> {
    let half = Double::splat(0.5);
    axis.times(half * (Double::splat(3.0) - axis.dot(axis)))
}

/// The start after the step that `stages` have solved, of which `end` has the rates.
#[inline(always)]
pub(crate) fn carry<V: Lanes>(stages: &Stages<Double<V>>, gravity: &[f64; 3], end: &mut Start<Extended>) {
    let (start, last) = (&stages.start, stages.coefficients.active - 1);
    let still = StagePose { w: Double::splat(1.0), u: Vector::zero(), anchor: Vector::zero() };
    for (index, (own, known)) in stages.plan.bodies.iter().zip(&start.bodies).enumerate() {
        let pose = &stages.poses[index];
        let parent = own.parent.map_or(&still, |parent| &stages.poses[parent]);
        let turned = |vector: Long, by: &StagePose<Double<V>>| {
            let vector = Vector::splat(&vector);
            rotate_increment(by.w, by.u, vector).plus(vector)
        };
        for freedom in own.freedoms() {
            let slides = freedom < own.first_axis + own.translations;
            end.axes[freedom] = of_lane(turned(start.axes[freedom], if slides { parent } else { pose }), last);
        }
        straighten::<V>(own, &mut end.axes);
        let arm = Vector::splat(&known.arm).plus(pose.anchor.minus(parent.anchor));
        end.bodies[index] = BodyStart {
            mass: known.mass,
            arm: of_lane(arm, last),
            com: of_lane(turned(known.com, pose), last),
            sigma: if own.spherical { known.sigma } else { turned_moments(pose, &known.sigma, last) },
            ..BodyStart::default()
        };
        set_velocity::<V>(own, index, end);
        set_pivot::<V>(own, index, gravity, end);
    }
}

/// `(1 + N) Σ (1 + N)ᵀ`.
#[inline(always)]
fn turned_moments<V: Lanes>(pose: &StagePose<Double<V>>, sigma: &[Extended; 6], lane: usize) -> [Extended; 6] {
    let [xx, xy, xz, yy, yz, zz] = *sigma;
    let turn = pose.increment();
    let half = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(|row| {
        let row = Vector::splat(&row);
        turn.apply_plus(row, row).0
    });
    let column = |index: usize| {
        let column = Vector([half[0][index], half[1][index], half[2][index]]);
        of_lane(turn.apply_plus(column, column), lane)
    };
    let [[xx, _, _], [xy, yy, _], [xz, yz, zz]] = [column(0), column(1), column(2)];
    [xx, xy, xz, yy, yz, zz]
}

/// The constants of the equation of a body on a hinge that the world holds, if it is one; all other fields of the body are set.
#[inline(always)]
fn set_pivot<V: Lanes>(own: &BodyPlan, index: usize, gravity: &[f64; 3], start: &mut Start<Extended>) {
    if let Some(pivot) = own.pivot {
        let (known, axis) = (&start.bodies[index], &start.axes[own.first_axis]);
        start.pivots[pivot] = Pivot::new::<Double<V>>(known, axis, gravity);
    }
}

/// The velocities of a body whose other fields are set, as are the velocities of its parent.
#[inline(always)]
fn set_velocity<V: Lanes>(own: &BodyPlan, index: usize, start: &mut Start<Extended>) {
    let known = &start.bodies[index];
    let (mut velocity, mut spin) = (Vector::<Double<V>>::zero(), Vector::zero());
    if let Some(parent) = own.parent {
        let parent = &start.bodies[parent];
        spin = Vector::splat(&parent.spin);
        // Vector from the parent's centre of mass by way of its anchor.
        let arm = Vector::splat(&known.arm).minus(Vector::splat(&parent.com));
        velocity = spin.cross_plus(arm, Vector::splat(&parent.velocity));
    }
    for freedom in own.freedoms() {
        let (axis, rate) = (Vector::splat(&start.axes[freedom]), Double::whole(start.rates[freedom]));
        if freedom < own.first_axis + own.translations {
            velocity = axis.times_plus(rate, velocity);
        } else {
            spin = axis.times_plus(rate, spin);
        }
    }
    velocity = spin.cross_plus(Vector::splat(&known.com), velocity);
    let known = &mut start.bodies[index];
    (known.velocity, known.spin) = (of_lane(velocity, 0), of_lane(spin, 0));
}
