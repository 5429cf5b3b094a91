//! The next extreme of a quantity that is known in time. Steps without motion end there.
//!
//! ```text
//!     f₀, f₁, …, f_n at equal distances of h (s):    the first i at which f_i − f_{i−1} and f_{i+1} − f_i have opposite signs
//!     t = t_i + ½ h (f_{i−1} − f_{i+1}) / (f_{i−1} − 2 f_i + f_{i+1})          the vertex of the parabola through the three
//! ```
//!
//! No motion bounds a step in which all bodies are held, and forces that hold them are looked at at a few samples. Between extremes of a load a force
//! changes in one direction, so that the ends of the step show whether it leaves its set.
//!
//! Ranges of formulas bound the stretch before ([`crate::mechanism::description::formula_ranges`]): no pulse in it is shorter than the distance of
//! the instants.

/// Instants at which a quantity is looked at.
const INSTANTS: usize = 1024;
/// Changes below this part of the largest value are roundings.
const ROUNDING: f64 = 1e-12;

/// The first extreme of a quantity after `since`, or `until` (s).
pub(crate) fn next_extreme(since: f64, until: f64, mut value: impl FnMut(f64) -> f64) -> f64 {
    let h = (until - since) / INSTANTS as f64;
    let at = |index: usize| since + h * index as f64;
    let (mut before, mut here) = (value(since), value(at(1)));
    let mut size = before.abs().max(here.abs());
    for index in 1..INSTANTS {
        let after = value(at(index + 1));
        size = size.max(after.abs());
        let (rises, falls) = (here - before, after - here);
        if rises * falls < 0.0 && rises.abs().max(falls.abs()) > ROUNDING * size {
            let vertex = 0.5 * h * (before - after) / (before - 2.0 * here + after);
            return at(index) + vertex;
        }
        // A value that stays is followed by one that changes: the change before counts.
        if falls != 0.0 {
            before = here;
        }
        here = after;
    }
    until
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extreme_is_found_where_it_is_and_none_in_what_rises_or_stays() {
        // Parabolas through points at distances of h miss the maximum of a sine by less than h² of its phase.
        let found = next_extreme(0.2, 5.0, |time| time.sin());
        assert!((found - std::f64::consts::FRAC_PI_2).abs() < 3e-5, "{found}");
        let pulse = next_extreme(0.0, 5.0, |time| (-(time - 3.2) * (time - 3.2)).exp());
        assert!((pulse - 3.2).abs() < 3e-5, "{pulse}");
        assert_eq!(next_extreme(0.0, 5.0, |time| time), 5.0);
        assert_eq!(next_extreme(0.0, 5.0, |_| 2.0), 5.0);
        // A step up and down again, with a value that stays between.
        let top = next_extreme(0.0, 4.0, |time| if (1.0..2.0).contains(&time) { 1.0 } else { 0.0 });
        assert!((1.9..2.1).contains(&top), "{top}");
    }
}
