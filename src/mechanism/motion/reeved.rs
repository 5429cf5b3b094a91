//! Ropes through several points: a rope runs freely through eyelets that are fixed in bodies or in the world.
//!
//! The points `P_0 … P_m` (m) are where the rope is tied, and the eyelets between. One tension T (N) is in all of it, because eyelets have no friction:
//!
//! ```text
//!     d_i = P_{i+1} − P_i,    u_i = d_i/|d_i|
//!     φ = L − Σ |d_i|                  (m)        L is the length of the rope; it is taut where φ = 0
//!     f_i = u_i − u_{i−1}                         the pull of a unit tension on P_i;  f_0 = u_0,  f_m = −u_{m−1}
//!     φ̇ = Σ f_i · Ṗ_i                  [m/s]
//!     φ̈ = Σ f_i · P̈_i − Σ (|ḋ_i|² − (u_i · ḋ_i)²)/|d_i|
//! ```
//!
//! φ̈ comes from numbers with derivatives ([`crate::ground::smooth`]). A rope that runs twice between two points counts both runs: block and tackle.
//! Points that meet have no direction, and pull nothing there.
//!
//! Source: J. García de Jalón, E. Bayo, Kinematic and Dynamic Simulation of Multibody Systems (1994), section 2.5 (distances as constraints).

use crate::description::body_state::BodyState;
use crate::description::closure::Attachment;
use crate::forces::point_spring::NO_LENGTH;
use crate::ground::smooth::{Jet, Smooth, Triple};
use crate::motion::kinematics::BodyAcceleration;
use crate::motion::moving_points::moving_point;
use nalgebra::Vector3;

/// The length of a rope through `count` points (m); `pull` is told point by point what a unit tension in the next or the last part of the rope pulls.
#[inline(always)]
pub fn reeved<S: Smooth>(
    count: usize,
    point: impl Fn(usize) -> Triple<S>,
    mut pull: impl FnMut(usize, Triple<S>),
) -> S {
    let mut sum = S::constant(0.0);
    for next in 1..count {
        let apart = point(next).minus(point(next - 1));
        let length = (apart.dot(apart) + S::constant(NO_LENGTH)).square_root();
        let along = apart.times(length.reciprocal());
        pull(next - 1, along);
        pull(next, along.times(S::constant(-1.0)));
        sum = sum + length;
    }
    sum
}

/// The length of a rope through points (m).
pub fn rope_length(points: &[Attachment], bodies: &[BodyState]) -> f64 {
    reeved(points.len(), |index| Triple(points[index].point(bodies).0.into()), |_, _| ())
}

/// The pulls `f` of a unit tension with their points (m): `exert(body, f, P)`, more than once for most points.
pub fn pulls(
    points: &[Attachment],
    bodies: &[BodyState],
    mut exert: impl FnMut(Option<usize>, Vector3<f64>, Vector3<f64>),
) {
    let place = |index: usize| points[index].point(bodies).0;
    let point = |index: usize| Triple(place(index).into());
    reeved::<f64>(points.len(), point, |index, along| {
        exert(points[index].body, Vector3::from(along.0), place(index));
    });
}

/// How a rope moves.
pub(crate) struct RopeMotion {
    /// φ (m).
    pub gap: f64,
    /// φ̇ [m/s].
    pub rate: f64,
    /// f of its last point, and that point in the world (m).
    pub pull: Vector3<f64>,
    pub last: Vector3<f64>,
}

/// The motion of a rope of this length (m).
pub(crate) fn rope_motion(length: f64, points: &[Attachment], bodies: &[BodyState]) -> RopeMotion {
    let place = |index: usize| points[index].point(bodies);
    let (mut rate, mut pull) = (0.0, Vector3::zeros());
    let long = reeved::<f64>(
        points.len(),
        |index| Triple(place(index).0.into()),
        |index, along| {
            let along = Vector3::from(along.0);
            rate += along.dot(&place(index).1);
            pull = along;
        },
    );
    let last = points.last().map_or(Vector3::zeros(), |last| last.point(bodies).0);
    RopeMotion { gap: length - long, rate, pull, last }
}

/// The second derivative of the gap of a rope for these accelerations of the bodies [m/s²].
pub(crate) fn rope_acceleration(
    points: &[Attachment],
    bodies: &[BodyState],
    accelerations: &[BodyAcceleration],
) -> f64 {
    let point = |index: usize| {
        let end: &Attachment = &points[index];
        let (linear, angular) = end.body.map_or((Vector3::zeros(), Vector3::zeros()), |body| accelerations[body]);
        moving_point(end.on(bodies), [&linear, &angular], &end.point(bodies).0)
    };
    -reeved::<Jet>(points.len(), point, |_, _| ()).second
}
