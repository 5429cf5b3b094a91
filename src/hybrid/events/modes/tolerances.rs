//! Thresholds below which a gap, a slip, a rate or a force at an event counts as zero: those that several files share, or that had one name for two meanings.
//!
//! ```text
//!     a slip:   max(1e-13 m/s, 1e-10 u_max)         the stages are solved to some 1e-11 of the fastest body
//!     a rate:   max(1e-14 rad/s, 1e-12 q̇_max)       rates of joints are coordinates, and are rounded in their own size
//!     a gap:    1e-11 of the size of a function
//! ```
//!
//! u_max (m/s): the fastest that any body, or its surface at a contact that rubs, has been; q̇_max (rad/s or m/s): the fastest that the joint has been.

use nalgebra::Vector3;

/// A slip below this part of the fastest that any body has been is at rest: the solution of the stages leaves some 1e-11 of it.
const SLIP: f64 = 1e-10;
/// A slip below this is at rest, however slow all bodies have been [m/s].
pub(crate) const SLOWEST_SLIP: f64 = 1e-13;
/// Slips whose stop was found may be faster than rest by this factor: a step that ends at the stop leaves the component across the slip.
pub(crate) const STOPPED_SLIP: f64 = 1e4;
/// The same for a slip that falls straight to its stop within the shortest step, as at a light wheel or a caster.
pub(crate) const BRIEF_SLIP: f64 = 1e6;
/// The contacts of a pair are at rest together if each of them is slower than this many times the rest of one contact: they share one body's errors.
pub(crate) const SLIPS_TOGETHER: f64 = 100.0;
/// A slip against the direction in which it began is what the stop of another has left, if it is faster than rest by no more than this factor: contacts
/// that can hardly move against each other along the line between them do not come to rest together.
const LEFT_BY_STOP: f64 = 100.0;
/// Slips slower than this part of the fastest give no usable slope: the noise of slips at rest is a thousandth of them.
pub(crate) const STEEP_SLIP: f64 = 1e-7;
/// A rate below this part of the fastest that its joint has been is at rest: some thousand roundings.
const RATE: f64 = 1e-12;
/// A rate below this is at rest, however slow the joint has been [rad/s or m/s].
const SLOWEST_RATE: f64 = 1e-14;
/// A rate that an impact leaves is zero if it is this part of the largest before: laws of impact are solved to 1e-11.
pub(crate) const RATE_AFTER_IMPACT: f64 = 1e-9;
/// Functions this near to zero at an event, relative to their size, belong to it.
pub(crate) const AT_EVENT: f64 = 1e-11;
/// The way under constant accelerations ends at gaps of this part of what a pair is made of: some roundings.
pub(crate) const BALLISTIC_GAP: f64 = 1e-15;
/// Roundings of gaps, 1e-17 m, are velocities in steps on closed contacts that are shorter than this (s).
pub(crate) const SHORTEST: f64 = 1e-8;
/// A joint that is beyond a limit by more than this is not there by rounding (rad or m).
pub(crate) const BEYOND_LIMIT: f64 = 1e-12;

/// The speed up to which a slip is at rest, where no body has been faster than this (m/s): without the floor of scenes at rest.
pub(crate) fn slip_at_rest(fastest: f64) -> f64 {
    SLIP * fastest
}

/// The direction of a slip where a contact slides that began to do so in another, up to a speed of rest [m/s]: slower slips have the one in which they began.
pub(crate) fn direction_of_slip(slip: &Vector3<f64>, begins: Vector3<f64>, rest: f64) -> Vector3<f64> {
    let least = if slip.dot(&begins) < 0.0 { LEFT_BY_STOP * rest } else { rest };
    slip.try_normalize(least).unwrap_or(begins)
}

/// The rate up to which a joint is at rest that has never been faster than this (rad/s or m/s).
pub(crate) fn rate_at_rest(fastest: f64) -> f64 {
    SLOWEST_RATE.max(RATE * fastest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_has_its_own_direction_from_rest_on_and_against_its_begin_from_far_above_rest_on() {
        let (begins, rest) = (Vector3::x(), 1e-10);
        let of = |along: f64, across: f64| direction_of_slip(&Vector3::new(along, across, 0.0), begins, rest);
        assert_eq!(of(0.0, 0.9e-10), begins);
        assert_eq!(of(0.0, 2e-10), Vector3::y());
        // Where the stop of another has left it.
        assert_eq!(of(-3e-10, 1e-10), begins);
        assert_eq!(of(-2e-8, 0.0), -Vector3::x());
    }

    #[test]
    fn joints_and_slips_are_at_rest_below_a_part_of_the_fastest_motion_so_far() {
        // 3 m/s: 1e-10 of it; a joint that has never moved keeps the floor.
        assert_eq!(slip_at_rest(3.0), 1e-10 * 3.0);
        assert_eq!((rate_at_rest(0.0), rate_at_rest(2.0)), (1e-14, 2e-12));
    }
}
