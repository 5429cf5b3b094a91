//! Sums of slopes, which are most of what a step of [`crate::dop853`] does besides evaluations.

use crate::dop853_table::Row;

/// `out = y + h out`.
#[inline]
pub fn add_scaled(y: &[f64], step: f64, out: &mut [f64]) {
    for (entry, &value) in out.iter_mut().zip(y) {
        *entry = value + step * *entry;
    }
}

/// `out = Σ w_j k_j` over the nonzero weights of a row, in a single pass over the slopes.
#[inline]
pub fn weighted_sum(row: Row, slopes: &[f64], out: &mut [f64]) {
    match row.len() {
        1 => weighted_sum_of::<1>(row, slopes, out),
        2 => weighted_sum_of::<2>(row, slopes, out),
        3 => weighted_sum_of::<3>(row, slopes, out),
        4 => weighted_sum_of::<4>(row, slopes, out),
        5 => weighted_sum_of::<5>(row, slopes, out),
        6 => weighted_sum_of::<6>(row, slopes, out),
        7 => weighted_sum_of::<7>(row, slopes, out),
        8 => weighted_sum_of::<8>(row, slopes, out),
        9 => weighted_sum_of::<9>(row, slopes, out),
        _ => weighted_sum_of::<12>(row, slopes, out),
    }
}

#[inline]
fn weighted_sum_of<const COUNT: usize>(row: Row, slopes: &[f64], out: &mut [f64]) {
    let n = out.len();
    let terms: [(f64, &[f64]); COUNT] = std::array::from_fn(|j| {
        let (stage, weight) = row[j];
        (weight, &slopes[stage * n..(stage + 1) * n])
    });
    for (i, entry) in out.iter_mut().enumerate() {
        let mut sum = 0.0;
        for (weight, slope) in &terms {
            sum += weight * slope[i];
        }
        *entry = sum;
    }
}
