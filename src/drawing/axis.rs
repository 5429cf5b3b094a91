//! The range, ticks and grid lines of an axis, linear or logarithmic.

use crate::picture::Scale;

/// An axis with its range and ticks settled.
pub(crate) struct Axis {
    /// The name of its quantity, with the unit.
    pub label: String,
    log: bool,
    /// In decades if logarithmic.
    pub range: (f64, f64),
    /// Values of the ticks in the same numbers, and their labels.
    pub ticks: Vec<(f64, String)>,
    /// Values of the grid lines, and whether they are strong.
    pub grid: Vec<(f64, bool)>,
}

impl Axis {
    /// Settles range and ticks for the values to be shown, with at most about `labels` labels.
    pub fn new(scale: &Scale, values: impl Iterator<Item = f64>, labels: i32) -> Self {
        match scale {
            Scale::Linear { label, range } => {
                let ticks = round_ticks(*range, labels);
                let grid = ticks.iter().map(|tick| (tick.0, true)).collect();
                Axis { label: label.clone(), log: false, range: *range, ticks, grid }
            }
            Scale::Log { label, least, most } => {
                let inside = values.filter(|value| (*least..=*most).contains(value)).map(f64::log10);
                let (low, high) =
                    inside.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
                let (low, high) = if low.is_finite() { (low, high) } else { (-6.0, 0.0) };
                // A sixth of a decade of air, so that markers do not sit on the frame.
                let (low, high) = (low - 0.17, high + 0.17);
                let (first, last) = (low.ceil() as i32, high.floor() as i32);
                let stride = (last - first) / labels + 1;
                let labelled = |decade: &i32| decade.rem_euclid(stride) == 0;
                let decades = (first..=last).filter(labelled).map(|decade| (f64::from(decade), power_of_ten(decade)));
                // One decade alone gives no scale: numbers between are labelled, too.
                let ticks: Vec<(f64, String)> = if first < last { decades.collect() } else { few_ticks(low, high) };
                // Lines at 2, 3 … 9 help where there are few decades and clutter where there are many.
                let fine = if last - first > 7 { 1..=1 } else { 1..=9 };
                let lines = (first - 1..=last + 1).flat_map(|decade| {
                    fine.clone().map(move |digit| (f64::from(decade) + f64::from(digit).log10(), digit == 1))
                });
                let grid = lines.filter(|line| (low..=high).contains(&line.0)).collect();
                Axis { label: label.clone(), log: true, range: (low, high), ticks, grid }
            }
        }
    }

    /// A value of the data as a fraction of the axis; `None` outside.
    pub fn fraction(&self, value: f64) -> Option<f64> {
        let value = if self.log { value.log10() } else { value };
        let fraction = (value - self.range.0) / (self.range.1 - self.range.0);
        (-1e-9..=1.0 + 1e-9).contains(&fraction).then_some(fraction)
    }

    /// A tick or grid line as a fraction of the axis.
    pub fn tick_fraction(&self, tick: f64) -> f64 {
        (tick - self.range.0) / (self.range.1 - self.range.0)
    }
}

/// Ticks at 1, 2 and 5 times powers of ten in a range of few decades (logarithms to base ten).
fn few_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let decades = low.floor() as i32..=high.floor() as i32;
    let ticks = decades.flat_map(|decade| {
        [1, 2, 5].map(|digit| {
            let words = if digit == 1 { power_of_ten(decade) } else { format!("{digit}·{}", power_of_ten(decade)) };
            (f64::from(decade) + f64::from(digit).log10(), words)
        })
    });
    ticks.filter(|tick| (low..=high).contains(&tick.0)).collect()
}

/// `10⁻⁶`.
pub fn power_of_ten(exponent: i32) -> String {
    let raise = |letter: char| match letter {
        '-' => '⁻',
        digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit.to_digit(10).unwrap_or(0) as usize],
    };
    format!("10{}", exponent.to_string().chars().map(raise).collect::<String>())
}

/// Ticks at multiples of 1, 2 or 5 times a power of ten, about `labels` of them.
fn round_ticks((from, to): (f64, f64), labels: i32) -> Vec<(f64, String)> {
    let raw = (to - from) / f64::from(labels.clamp(2, 8));
    let decade = 10_f64.powf(raw.log10().floor());
    let Some(step) = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * decade).into_iter().find(|&step| step >= raw) else {
        return Vec::new();
    };
    let digits = (-step.log10().floor()).max(0.0) as usize;
    let (first, last) = ((from / step).ceil() as i64, (to / step + 1e-9).floor() as i64);
    (first..=last).map(|k| k as f64 * step).map(|tick| (tick, tick_label(tick, digits))).collect()
}

/// A number with this number of digits behind the point, or as a power of ten if it would be too long beside an axis.
fn tick_label(tick: f64, digits: usize) -> String {
    if digits <= 6 || tick == 0.0 {
        format!("{tick:.*}", if digits <= 6 { digits } else { 0 })
    } else {
        format!("{tick:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_with_one_power_of_ten_or_none_has_labels_between() {
        let labels = |values: [f64; 2]| {
            let scale = Scale::Log { label: String::new(), least: 0.0, most: f64::MAX };
            let axis = Axis::new(&scale, values.into_iter(), 8);
            axis.ticks.into_iter().map(|tick| tick.1).collect::<Vec<_>>()
        };
        assert_eq!(labels([0.03, 0.4]), ["5·10⁻²", "10⁻¹", "2·10⁻¹", "5·10⁻¹"]);
        assert_eq!(labels([2.0, 3.0]), ["2·10⁰"]);
        assert_eq!(labels([0.03, 4.0]), ["10⁻¹", "10⁰"]);
    }
}
