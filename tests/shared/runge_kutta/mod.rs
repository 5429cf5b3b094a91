//! Runge and Kutta's method of order four, for equations of motion that tests write out.

// Every program of tests compiles its own copy of this module and uses some of it.
#![allow(dead_code)]

/// One step of Runge and Kutta's method of order four.
pub fn runge_kutta<const N: usize>(slope: &impl Fn(&[f64; N]) -> [f64; N], y: &[f64; N], h: f64) -> [f64; N] {
    let ahead = |part: f64, k: &[f64; N]| std::array::from_fn(|i| y[i] + part * h * k[i]);
    let first = slope(y);
    let second = slope(&ahead(0.5, &first));
    let third = slope(&ahead(0.5, &second));
    let fourth = slope(&ahead(1.0, &third));
    std::array::from_fn(|i| y[i] + h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]))
}

/// The state after a time (s) in so many steps of it.
pub fn after<const N: usize>(
    slope: impl Fn(&[f64; N]) -> [f64; N],
    mut y: [f64; N],
    time: f64,
    steps: usize,
) -> [f64; N] {
    for _ in 0..steps {
        y = runge_kutta(&slope, &y, time / steps as f64);
    }
    y
}
