//! Dips of a watched function below zero between two samples at which it is positive.
//!
//! If its second derivative is at most M there, it is
//!
//! ```text
//!     f(a + u) ≥ f(a) + s u − M u (L − u)/2,     s = (f(b) − f(a))/L,  L = b − a          least at u = L/2 − s/M, if that is inside
//! ```
//!
//! M is taken from second differences of neighbouring samples and from what these differ by. Where the bound is below zero, the interval is halved, and
//! M is estimated anew. No dip is looked for in a function that bends by less than what counts as zero: one that stays at zero would dip everywhere.

/// The second derivative between samples over what their differences say, besides what these differ by.
const SHARPER: f64 = 1.5;
/// In half an interval it is estimated anew, as no less than this part of the estimate before.
const FLATTER: f64 = 0.1;
/// Halvings of an interval in search of a dip.
const HALVINGS: u32 = 20;
/// Looks in search of dips of a function in a step. Its bend is bounded anew in every half, so that smooth functions take some tens at most; noise has a
/// larger one the shorter the interval is.
pub(super) const DIP_LOOKS: u32 = 1000;

/// A bound of the second derivative between the samples j − 1 and j, which are so far apart (s): from the second differences that contain both, and what
/// they differ by. At an end of the samples that is what the two nearest differ by.
pub(super) fn bend_before(of: &[f64], j: usize, apart: f64) -> f64 {
    let second = |middle: usize| (of[middle - 1] - 2.0 * of[middle] + of[middle + 1]) / apart.powi(2);
    let last = of.len() - 2;
    let (one, other) = if j == 1 {
        (1, 2)
    } else if j == of.len() - 1 {
        (last, last - 1)
    } else {
        (j - 1, j)
    };
    let (one, other) = (second(one), second(other));
    SHARPER * one.max(other).max(0.0) + (one - other).abs()
}

/// A point in an interval (times in s, values) at whose ends a function is not negative, and where it is, if its second derivative is at most `bend` there
/// and changes up to `zero` are none. `looks` are counted down; none are left if the function is too rough to tell.
pub(super) fn dips(
    interval: [(f64, f64); 2],
    bend: f64,
    zero: f64,
    looks: &mut u32,
    value: &mut impl FnMut(f64) -> f64,
) -> Option<f64> {
    halve(interval, bend, zero, HALVINGS, looks, value)
}

/// The same in an interval that may be halved so often.
fn halve(
    [(start, first), (end, last)]: [(f64, f64); 2],
    bend: f64,
    zero: f64,
    halvings: u32,
    looks: &mut u32,
    value: &mut impl FnMut(f64) -> f64,
) -> Option<f64> {
    let length = end - start;
    // Functions that are not looked at have infinite values.
    if halvings == 0 || !(bend * length.powi(2) > zero && bend.is_finite()) {
        return None;
    }
    let slope = (last - first) / length;
    let least = 0.5 * length - slope / bend;
    if !(least > 0.0 && least < length && first + slope * least < 0.5 * bend * least * (length - least)) {
        return None;
    }
    let middle = start + 0.5 * length;
    if *looks == 0 || !(middle > start && middle < end) {
        return None;
    }
    *looks -= 1;
    let found = value(middle);
    if found < 0.0 {
        return Some(middle);
    }
    let bend = SHARPER * (4.0 * (first - 2.0 * found + last) / length.powi(2)).max(FLATTER * bend);
    halve([(start, first), (middle, found)], bend, zero, halvings - 1, looks, value)
        .or_else(|| halve([(middle, found), (end, last)], bend, zero, halvings - 1, looks, value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::finding::detection::{First, Room, SAMPLES, first_sign_change};

    #[test]
    fn noise_is_looked_at_a_thousand_times_and_is_no_clear_look_and_a_smooth_function_is() {
        let look = |function: &dyn Fn(f64) -> f64| {
            let (mut room, mut count) = (Room::default(), 0);
            let found = first_sign_change(&mut room, 1, 0.0, 1.0, [&[1e-12]; 2], First::Thirds, |time, _, values| {
                count += 1;
                values[0] = function(time);
            });
            assert!(found.is_none(), "{found:?}");
            (count, room.unclear)
        };
        // A force with peaks of roundings over roundings.
        let noise = |time: f64| 7.0 + 1e30 * (((1e6 * time).sin() * 43758.5).fract() - 0.5).max(0.0).powi(4);
        assert_eq!(look(&noise), (DIP_LOOKS + SAMPLES as u32 + 1, true));
        // It comes down to 1e-9 of its change.
        let (count, unclear) = look(&|time| (time - 0.437).powi(2) + 1e-9);
        assert!(!unclear && count < DIP_LOOKS / 10, "{count}");
    }
}
