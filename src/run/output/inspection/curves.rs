//! The curves of a log: joint positions and velocities, energy error, constraint error, reactions, contact forces.
//!
//! ```text
//!     energy error  |E − E₀ + D − W| / max T          no unit; E₀ at the start, D dissipated or lost, W work put in since,
//!                                                      T the kinetic energy of all steps in the log
//! ```
//!
//! An orientation has the quaternions q and −q. The one nearer to the sample before is drawn; logs and tables have w ≥ 0.
//!
//! Events are thin ticks that stand on the axis of time.
//!
//! Long logs are thinned: of every interval of time the smallest and the largest value are drawn.

use crate::drawing::picture::{Figure, Panel, Picture, Scale, Series};
use crate::drawing::style::curve;
use crate::mechanism::ground::words::counted;
use crate::output::inspection::joint_values::{JointKinds, Quantity, contact_forces, joint_values, wrenches};
use crate::output::inspection::summary::short;
use crate::output::log::reading::decode::LoggedEvent;
use crate::output::log::reading::frames::{Figures, Frame, Slopes, Visitor, visit};
use crate::output::log::reading::records::ReadError;
use crate::output::log::seconds;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Most curves in one picture; more can neither be told apart nor named.
const MOST_CURVES: usize = 12;

/// Most titles and names that are listed when one is not known.
const NAMED: usize = 24;

/// Intervals of time whose smallest and largest values are drawn.
const INTERVALS: usize = 1200;

/// Values below this are drawn here on logarithmic axes, because smaller ones are below the resolution of a double.
const LEAST: f64 = 1e-17;

struct Gatherer<'k> {
    kinds: &'k JointKinds,
    /// Sorted by quantity in the order of the figure, curves in the order of the log.
    curves: Vec<(Quantity, Vec<Curve>)>,
    initial: Option<f64>,
    largest_kinetic: f64,
    /// Times of events (s).
    events: Vec<f64>,
    /// Times of the first frame and of that before (s).
    before: Option<[f64; 2]>,
    scene: String,
    method: String,
}

struct Curve {
    label: String,
    points: Vec<(f64, f64)>,
}

/// Whether a word is in the title of a quantity or the name of one of its curves.
fn is_of(word: &str, quantity: Quantity, curve: &Curve) -> bool {
    let word = word.to_lowercase();
    quantity.title().to_lowercase().contains(&word) || curve.label.to_lowercase().contains(&word)
}

impl Gatherer<'_> {
    /// Whether any curve has a word in its title or name.
    fn has(&self, word: &str) -> bool {
        self.curves.iter().any(|(quantity, curves)| curves.iter().any(|curve| is_of(word, *quantity, curve)))
    }

    /// Keeps the curves that have one of the words; without words all.
    fn keep(&mut self, words: &[String]) {
        if words.is_empty() {
            return;
        }
        for (quantity, curves) in &mut self.curves {
            curves.retain(|curve| words.iter().any(|word| is_of(word, *quantity, curve)));
        }
        self.curves.retain(|(_, curves)| !curves.is_empty());
    }

    /// The titles, and the names of the first curves.
    fn known(&self) -> String {
        let titles = self.curves.iter().map(|(quantity, _)| quantity.title().to_string());
        let mut names: Vec<String> = titles.collect();
        for curve in self.curves.iter().flat_map(|(_, curves)| curves) {
            if !names.contains(&curve.label) {
                names.push(curve.label.clone());
            }
        }
        let more = names.len().saturating_sub(NAMED);
        names.truncate(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{}{more}", names.join(", "))
    }

    fn add(&mut self, quantity: Quantity, label: &str, time: f64, value: f64) {
        let found = self.curves.iter_mut().position(|(known, _)| *known == quantity);
        let place = found.unwrap_or_else(|| {
            self.curves.push((quantity, Vec::new()));
            self.curves.len() - 1
        });
        let curves = &mut self.curves[place].1;
        match curves.iter_mut().find(|curve| curve.label == label) {
            Some(curve) => curve.points.push((time, value)),
            None => curves.push(Curve { label: label.to_string(), points: vec![(time, value)] }),
        }
    }
}

impl Visitor for Gatherer<'_> {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        let time = frame.time();
        for value in joint_values(frame, self.kinds) {
            // Reactions are drawn below, by their size; efforts are parts of them.
            if matches!(value.quantity, Quantity::Force | Quantity::Torque | Quantity::Effort) {
                continue;
            }
            let label =
                if value.component.is_empty() { value.joint } else { format!("{} {}", value.joint, value.component) };
            self.add(value.quantity, &label, time, value.value);
        }
        let norm = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (joint, (force, torque)) in wrenches(&frame.reactions) {
            self.add(Quantity::Force, joint, time, norm(force));
            self.add(Quantity::Torque, joint, time, norm(torque));
        }
        let mut forces: Vec<(String, f64)> =
            contact_forces(frame).into_iter().map(|(pair, force)| (pair, norm(&force))).collect();
        // A contact that is not closed has no force.
        let known = self.curves.iter().filter(|(quantity, _)| *quantity == Quantity::ContactForce);
        let known: Vec<String> = known.flat_map(|(_, curves)| curves).map(|curve| curve.label.clone()).collect();
        for label in &known {
            if forces.iter().all(|(pair, _)| pair != label) {
                forces.push((label.clone(), 0.0));
            }
        }
        for (pair, force) in forces {
            if known.iter().all(|label| *label != pair) {
                let none = self.before.into_iter().flatten();
                none.for_each(|earlier| self.add(Quantity::ContactForce, &pair, earlier, 0.0));
            }
            self.add(Quantity::ContactForce, &pair, time, force);
        }
        self.before = Some([self.before.map_or(time, |[first, _]| first), time]);
        ControlFlow::Continue(())
    }

    fn slopes(&mut self, slopes: &Slopes) {
        let Slopes { key, by, .. } = slopes;
        let time = seconds(slopes.nanoseconds);
        for (quantity, values) in [(Quantity::Slope, &by.positions), (Quantity::RateSlope, &by.velocities)] {
            for (name, value) in by.names.iter().zip(values) {
                self.add(quantity, &format!("{name} by {key}"), time, *value);
            }
        }
    }

    fn event(&mut self, event: LoggedEvent) {
        self.events.push(event.time);
    }

    fn figures(&mut self, figures: &Figures) {
        let time = seconds(figures.nanoseconds);
        if let (Some([kinetic, ..]), Some(balance)) = (figures.energy, figures.balance()) {
            let initial = *self.initial.get_or_insert(balance);
            self.largest_kinetic = self.largest_kinetic.max(kinetic);
            self.add(Quantity::EnergyError, "energy", time, (balance - initial).abs());
        }
        if let Some([position, velocity]) = figures.violation {
            self.add(Quantity::Violation, "position [m]", time, position);
            self.add(Quantity::Violation, "velocity [m/s]", time, velocity);
        }
    }

    fn metadata(&mut self, name: &str, entries: &std::collections::BTreeMap<String, String>) {
        if name == "simulation" {
            let entry = |name: &str| entries.get(name).filter(|text| !text.is_empty());
            self.scene = entry("scene").or_else(|| entry("robot")).cloned().unwrap_or_default();
            self.method = [("method", ""), ("stages", " stages"), ("tolerance", " m tolerance"), ("step", " s step")]
                .iter()
                .filter_map(|(name, unit)| Some(format!("{}{unit}", short(entry(name)?))))
                .collect::<Vec<_>>()
                .join(", ");
        }
    }
}

/// Why there is no figure.
#[derive(Debug, thiserror::Error)]
pub enum CurvesError {
    /// It is not a log.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// No curve of the log has this word in its title or name.
    #[error("{}: no curve has {word:?} in its title or name; there are {known}", log.display())]
    Unknown { log: PathBuf, word: String, known: String },
}

/// The curves of a log as a figure; with words those alone in whose titles or names one of them is, in large or small letters.
///
/// # Errors
/// [`CurvesError`] if it is not a log, or a word is in no title or name.
pub fn curves(log: &Path, kinds: &JointKinds, words: &[String]) -> Result<Figure, CurvesError> {
    let mut gatherer = Gatherer {
        kinds,
        curves: Vec::new(),
        initial: None,
        largest_kinetic: 0.0,
        events: Vec::new(),
        before: None,
        scene: String::new(),
        method: String::new(),
    };
    let completeness = visit(log, &mut gatherer)?;
    if let Some(word) = words.iter().find(|word| !gatherer.has(word)) {
        return Err(CurvesError::Unknown { log: log.to_path_buf(), word: word.clone(), known: gatherer.known() });
    }
    let orientations = gatherer.curves.iter_mut().filter(|(quantity, _)| *quantity == Quantity::Orientation);
    orientations.for_each(|(_, curves)| curves.chunks_mut(4).for_each(go_on));
    gatherer.keep(words);
    let scale = if gatherer.largest_kinetic > 0.0 { gatherer.largest_kinetic } else { 1.0 };
    let all_points = || gatherer.curves.iter().flat_map(|(_, curves)| curves).flat_map(|curve| &curve.points);
    let end = all_points().map(|point| point.0).fold(0.0, f64::max);
    let mut sorted = std::mem::take(&mut gatherer.curves);
    sorted.sort_by_key(|(quantity, _)| *quantity);
    let last = sorted.len().saturating_sub(1);
    let pictures = sorted.into_iter().enumerate().map(|(index, (quantity, mut curves))| {
        if quantity == Quantity::EnergyError {
            curves.iter_mut().flat_map(|curve| &mut curve.points).for_each(|point| point.1 /= scale);
        }
        picture(quantity, curves, &gatherer.events, end, index == last)
    });
    let mut pictures: Vec<Picture> = pictures.collect();
    if let (Some(first), false) = (pictures.first_mut(), gatherer.events.is_empty()) {
        first.notes.push(format!("ticks: {}", counted(gatherer.events.len(), "event", "events")));
    }
    let incomplete = match completeness {
        Some(completeness) if completeness.is_complete() => "",
        Some(completeness) if completeness.damaged => " (the log is damaged)",
        _ => " (the log is truncated)",
    };
    Ok(Figure { title: format!("{}{incomplete}", gatherer.scene), subtitle: gatherer.method.clone(), pictures })
}

/// Turns the signs of the four curves of an orientation so that they do not jump.
fn go_on(curves: &mut [Curve]) {
    let count = curves.iter().map(|curve| curve.points.len()).min().unwrap_or(0);
    for sample in 1..count {
        let along: f64 = curves.iter().map(|curve| curve.points[sample - 1].1 * curve.points[sample].1).sum();
        if along < 0.0 {
            curves.iter_mut().for_each(|curve| curve.points[sample].1 *= -1.0);
        }
    }
}

fn picture(quantity: Quantity, curves: Vec<Curve>, events: &[f64], end: f64, is_last: bool) -> Picture {
    // The note that there are more takes the room of two.
    let most = if curves.len() > MOST_CURVES { MOST_CURVES - 2 } else { MOST_CURVES };
    let hidden = curves.len().saturating_sub(most);
    let shown = curves.into_iter().take(most).enumerate();
    let series: Vec<Series> = shown
        .map(|(index, found)| Series {
            label: shortened(&found.label),
            look: curve(index),
            points: thinned(&found.points, end)
                .into_iter()
                .map(|(time, value)| (time, if quantity.is_logarithmic() { value.max(LEAST) } else { value }))
                .collect(),
            markers_every: usize::MAX,
        })
        .collect();
    let label = quantity.unit().to_string();
    let y = if quantity.is_logarithmic() {
        Scale::Log { label, least: LEAST, most: f64::MAX }
    } else {
        let values =
            || series.iter().flat_map(|series| &series.points).map(|point| point.1).filter(|value| value.is_finite());
        let (low, high) =
            values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        // Something that does not move is a line in the middle.
        let size = low.abs().max(high.abs());
        let air = if size > 0.0 { (0.06 * (high - low)).max(1e-3 * size) } else { 1.0 };
        Scale::Linear { label, range: (low - air, high + air) }
    };
    let hidden = (hidden > 0).then(|| format!("and {hidden} more, see --csv"));
    Picture {
        title: quantity.title().to_string(),
        subtitle: String::new(),
        x: Scale::Linear {
            label: if is_last { "simulated time [s]".to_string() } else { String::new() },
            range: (0.0, if end > 0.0 { end } else { 1.0 }),
        },
        y,
        bands: Vec::new(),
        panels: vec![Panel { heading: String::new(), series }],
        notes: hidden.into_iter().collect(),
        marks: events.to_vec(),
    }
}

/// The part of a label that fits into the legend: the beginning, and the end, by which joints of one robot and coordinates of one joint differ.
fn shortened(label: &str) -> String {
    const LETTERS: usize = 44;
    const LAST: usize = 24;
    let count = label.chars().count();
    if count <= LETTERS {
        return label.to_string();
    }
    label.chars().take(LETTERS - 1 - LAST).chain(['…']).chain(label.chars().skip(count - LAST)).collect()
}

/// The first of the smallest and of the largest values of every interval of time, in order of time.
fn thinned(points: &[(f64, f64)], end: f64) -> Vec<(f64, f64)> {
    if points.len() <= 2 * INTERVALS {
        return points.to_vec();
    }
    let interval = |point: &(f64, f64)| ((point.0 / end) * INTERVALS as f64) as usize;
    let mut thin = Vec::with_capacity(2 * INTERVALS + 2);
    for chunk in points.chunk_by(|a, b| interval(a) == interval(b)) {
        let extreme = |sign: f64| {
            chunk
                .iter()
                .enumerate()
                .min_by(|(_, a), (_, b)| (sign * a.1).total_cmp(&(sign * b.1)))
                .map_or(0, |(place, _)| place)
        };
        let (low, high) = (extreme(1.0), extreme(-1.0));
        thin.push(chunk[low.min(high)]);
        if low != high {
            thin.push(chunk[low.max(high)]);
        }
    }
    thin
}

#[cfg(test)]
mod tests {
    use super::{Curve, INTERVALS, go_on, thinned};

    #[test]
    fn curves_of_an_orientation_do_not_jump_where_its_quaternions_change_sign() {
        // Two turns about one axis in steps of 0.1 rad, with w ≥ 0 as in a log: it jumps at each half turn.
        let mut curves: Vec<Curve> = (0..4).map(|_| Curve { label: String::new(), points: Vec::new() }).collect();
        for step in 0..126 {
            let (sine, cosine) = (0.05 * f64::from(step)).sin_cos();
            let sign = cosine.signum();
            for (curve, value) in curves.iter_mut().zip([cosine, 0.6 * sine, 0.0, 0.8 * sine]) {
                curve.points.push((f64::from(step), sign * value));
            }
        }
        go_on(&mut curves);
        for curve in &curves {
            assert!(curve.points.windows(2).all(|two| (two[1].1 - two[0].1).abs() <= 0.05));
        }
        assert!(curves[0].points[63].1 < -0.99, "half of the turns");
    }

    #[test]
    fn thinning_keeps_every_peak_and_the_order_of_time() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), 0.0)).collect();
        points[77_777].1 = 5.0;
        points[33_333].1 = -3.0;
        let thin = thinned(&points, 99_999.0);
        assert!(thin.len() <= 2 * INTERVALS + 2, "{}", thin.len());
        assert!(thin.contains(&(77_777.0, 5.0)) && thin.contains(&(33_333.0, -3.0)));
        assert!(thin.is_sorted_by(|a, b| a.0 < b.0));
    }
}
