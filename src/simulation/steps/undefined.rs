//! Formulas of time that have no finite value somewhere in a stretch of a run, as `ln(2 − t)` from t = 2 s on, and joints that a motion moves beyond
//! their limits.
//!
//! A formula is looked at at instants at most 0.02 s apart, and halved between the last instant at which it is finite and the first at which it is
//! not. A pole between two instants is not seen: steps then fail at it, or go past it.

use crate::mechanism::description::mechanism::Mechanism;

/// The longest time between two instants (s), and how many instants there are at least and at most.
const APART: f64 = 0.02;
const FEWEST: f64 = 16.0;
const MOST: f64 = 20_000.0;

/// Halvings until the instant is known: of 0.02 s to a rounding.
const HALVINGS: usize = 50;

/// The first formula of a mechanism that is not finite somewhere from one time to another (s): the name of what has it, and when.
pub(crate) fn undefined(mechanism: &Mechanism, from: f64, to: f64) -> Option<(String, f64)> {
    let mut first: Option<(String, f64)> = None;
    let mut look = |name: &dyn Fn() -> String, is_finite: &dyn Fn(f64) -> bool| {
        let until = first.as_ref().map_or(to, |(_, time)| *time);
        if let Some(time) = first_not(is_finite, from, until) {
            first = Some((name(), time));
        }
    };
    for motor in mechanism.nonsmooth.motors.iter().filter(|motor| motor.target.as_formula().is_some()) {
        let finite = |time: f64| motor.target.motion(time, time).iter().all(|value| value.is_finite());
        look(
            &|| format!("the target of the motor on {:?}", mechanism.joint_of_freedom(motor.coordinate.freedom)),
            &finite,
        );
    }
    for mimic in &mechanism.mimics {
        if let Some(motion) = mimic.over_time.as_ref().filter(|motion| motion.as_formula().is_some()) {
            let finite = |time: f64| motion.motion(time, time).iter().all(|value| value.is_finite());
            look(&|| format!("the motion of {:?}", mimic.name), &finite);
        }
    }
    for load in mechanism.forces.joint_courses.iter().filter(|load| load.course.has_formula()) {
        look(&|| format!("the load in joint {:?}", mechanism.joint_of_freedom(load.freedom)), &|time| {
            load.course.value(time, time).is_finite()
        });
    }
    for load in mechanism.forces.link_loads.iter().filter(|load| load.course.has_formula()) {
        let name = || format!("the load on the body of joint {:?}", mechanism.bodies[load.body].joint.name);
        look(&name, &|time| load.course.value(time, time).is_finite());
    }
    first
}

/// The first joint that a motion moves beyond its limits somewhere from one time to another (s), as a rope that is paid out beyond its end: its name,
/// and when. Limits of other joints that are moved are left out.
pub(crate) fn beyond(mechanism: &Mechanism, from: f64, to: f64) -> Option<(String, f64)> {
    let moved = mechanism.mimics.iter().filter_map(|mimic| Some((mimic, mimic.over_time.as_ref()?)));
    let limited = moved.filter_map(|(mimic, motion)| {
        let limit = mechanism.limits.iter().find(|limit| limit.coordinate == mimic.follower)?;
        let inside = |time: f64| (limit.lower..=limit.upper).contains(&motion.motion(time, time)[0]);
        let time = if inside(from) { first_not(&inside, from, to)? } else { from };
        Some((mimic.name.clone(), time))
    });
    limited.min_by(|(_, one), (_, other)| one.total_cmp(other))
}

/// The first instant at which something is not so.
fn first_not(is_so: &dyn Fn(f64) -> bool, from: f64, to: f64) -> Option<f64> {
    let count = ((to - from) / APART).ceil().clamp(FEWEST, MOST);
    let at = |index: usize| if index as f64 == count { to } else { from + (to - from) * index as f64 / count };
    let bad = (1..=count as usize).find(|&index| !is_so(at(index)))?;
    let (mut good, mut bad) = (at(bad - 1), at(bad));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if is_so(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Some(bad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_instant_at_which_a_logarithm_ends_is_found_to_rounding_and_a_finite_formula_has_none() {
        let found = first_not(&|time: f64| (2.0 - time).ln().is_finite(), 0.0, 5.0).expect("it ends");
        assert!((found - 2.0).abs() < 1e-14, "{found}");
        assert_eq!(first_not(&|time: f64| (2.0 - time).ln().is_finite(), 0.0, 1.999), None);
        assert_eq!(first_not(&|time: f64| time.sin().is_finite(), 0.0, 1e9), None);
    }
}
