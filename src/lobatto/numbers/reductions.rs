//! Reductions of lanes to one number: largest values, values at the end of the step, weighted sums over the stages.

use crate::numbers::arithmetic::Numbers;
use crate::numbers::lanes::{Lanes, in_lanes};
/// E of the displacements alone: their largest top Legendre coefficient, of which `top` has the weights of the stages.
#[inline(always)]
pub(crate) fn largest_coefficient<V: Lanes>(displacements: &[V], top: V) -> f64 {
    let mut largest = 0.0_f64;
    for displacement in displacements {
        largest = larger(largest, (*displacement * top).sum().abs());
    }
    largest
}

/// The larger of a number and another, which may be a NaN and then is not: `f64::max` asks whether the first is one, too.
#[inline(always)]
pub(crate) fn larger(number: f64, other: f64) -> f64 {
    if other > number { other } else { number }
}

/// The degree of freedom with the largest increment; a NaN counts as largest.
pub(crate) fn worst_freedom<V: Lanes>(increments: &[V]) -> usize {
    let size = |freedom: usize| increments[freedom].max_abs(V::zero()).largest();
    (0..increments.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0)
}

/// Values at the end of the step.
pub(crate) fn write_ends<V: Lanes>(values: &[V], active: usize, ends: &mut [f64]) {
    in_lanes!(V, {
        for (end, &value) in ends.iter_mut().zip(values) {
            *end = at_end(value, active);
        }
    });
}

/// A value at the end of the step: the last of the `active` lanes.
#[inline(always)]
pub(crate) fn at_end<V: Lanes>(value: V, active: usize) -> f64 {
    value.to_array().as_ref()[active - 1]
}

/// Two weighted sums over the stages for each degree of freedom.
pub(crate) fn weigh<V: Lanes>(displacements: &[V], weights: [&[f64]; 2], sums: &mut [[f64; 2]]) {
    let weights = weights.map(V::from_slice);
    in_lanes!(V, {
        for (sums, &displacement) in sums.iter_mut().zip(displacements) {
            *sums = [(displacement * weights[0]).sum(), (displacement * weights[1]).sum()];
        }
    });
}

/// The largest of any freedom's values at any stage, without their signs.
#[inline(always)]
pub(crate) fn largest<V: Numbers>(values: &[V]) -> f64 {
    let mut largest = V::zero();
    for value in values {
        largest = value.max_abs(largest);
    }
    largest.largest()
}

/// The largest difference of two motions in any freedom at any stage, without its sign.
#[inline(always)]
pub(crate) fn largest_difference<V: Numbers>(one: &[V], other: &[V]) -> f64 {
    let mut largest = V::zero();
    for (&one, &other) in one.iter().zip(other) {
        largest = (one - other).max_abs(largest);
    }
    largest.largest()
}

/// Adds increments to values; returns the largest of these at any stage, without their signs.
#[inline(always)]
pub(crate) fn add_to<V: Numbers>(values: &mut [V], increments: &[V]) -> f64 {
    let mut largest = V::zero();
    for (value, &increment) in values.iter_mut().zip(increments) {
        *value = *value + increment;
        largest = value.max_abs(largest);
    }
    largest.largest()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vectors::portable::Portable;

    #[test]
    fn the_worst_freedom_is_the_one_that_is_no_number_or_else_the_largest() {
        let worst = |values: &[f64]| {
            let increments: Vec<Portable<4>> =
                values.iter().map(|&value| Portable::from_slice(&[0.0, value])).collect();
            worst_freedom(&increments)
        };
        assert_eq!(worst(&[1.0, -3.0, 2.0]), 1);
        for (values, at) in [([f64::NAN, 1.0, 2.0], 0), ([1.0, f64::NAN, 2.0], 1), ([1.0, 2.0, -f64::NAN], 2)] {
            assert_eq!(worst(&values), at);
        }
    }
}
