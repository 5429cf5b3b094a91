//! The ratio of CPU times at equal accuracy.
//!
//! The cost of a method at an error level is read off its *front*: the runs that no other run of the method beats in
//! both error and cost, joined by straight lines on logarithmic axes,
//!
//! ```text
//!     log c(ε) = log c_a + (log ε − log ε_a) / (log ε_b − log ε_a) · (log c_b − log c_a),     ε_b ≤ ε ≤ ε_a
//! ```
//!
//! The cost at a level coarser than the whole front is the cost of the cheapest run. A level finer than the front is not reached, because costs are
//! not extrapolated. The ratio at a level is the cost of the cheapest rival (RK4, DOP853) over the cost of our cheapest method.

use crate::chart::measure::SceneChart;
use crate::chart::method::Method;
use crate::chart::table::Measurement;

/// The levels of the table of ratios (m).
pub const LEVELS: [f64; 3] = [1e-3, 1e-6, 1e-9];

/// Whether a method reaches an error level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// At this cost [CPU seconds per simulated second].
    Cost(f64),
    /// It does not; this is the smallest error it has (m).
    Floor(f64),
    /// It has no run that came to an end.
    Nothing,
}

/// The runs of a method that no other run of it beats, cheapest first: errors fall and costs rise along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Front(Vec<(f64, f64)>);

impl Front {
    /// The front of (error (m), cost) pairs.
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut points: Vec<(f64, f64)> = points.into_iter().collect();
        points.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.total_cmp(&b.0)));
        let mut front: Vec<(f64, f64)> = Vec::new();
        for point in points {
            if front.last().is_none_or(|last| point.0 < last.0) {
                front.push(point);
            }
        }
        Front(front)
    }

    /// The front of one method's measurements.
    pub fn of(measurements: &[Measurement], method: &str) -> Self {
        Front::new(measurements.iter().filter(|one| one.method == method).filter_map(Measurement::point))
    }

    /// The cost of an error level (m).
    pub fn at(&self, level: f64) -> Reach {
        let (Some(first), Some(last)) = (self.0.first(), self.0.last()) else { return Reach::Nothing };
        if level < last.0 {
            return Reach::Floor(last.0);
        }
        if level >= first.0 {
            return Reach::Cost(first.1);
        }
        let next = self.0.partition_point(|point| point.0 > level);
        let (coarse, fine) = (self.0[next - 1], self.0[next]);
        // An error of zero is infinitely far away on a logarithmic axis, so the cost is the cost of the finer run.
        if fine.0 == 0.0 || fine.0 == coarse.0 {
            return Reach::Cost(fine.1);
        }
        let fraction = (level / coarse.0).ln() / (fine.0 / coarse.0).ln();
        Reach::Cost(coarse.1 * (fine.1 / coarse.1).powf(fraction))
    }
}

/// The cheapest of several methods at a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Best {
    /// The method; the one with the lowest floor if the level is not reached.
    pub method: Method,
    /// Its cost or floor.
    pub reach: Reach,
}

/// The comparison at one level.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The error level (m).
    pub level: f64,
    /// The cheapest rival.
    pub rival: Option<Best>,
    /// Our cheapest fixed-step or tolerance run.
    pub ours: Option<Best>,
    /// Ours from a tolerance, with an estimate of its error.
    pub tolerance: Option<Best>,
    /// Ours from a tolerance, without an estimate.
    pub unestimated: Option<Best>,
    /// The cheapest rival at a tenth of the level: the second run from which a rival knows its error.
    pub second: Option<Best>,
}

impl Comparison {
    /// The comparison at an error level in a scene. An error below the noise of the reference counts as that noise, because it is luck. No method
    /// reaches a level below the noise.
    pub fn of(chart: &SceneChart, level: f64) -> Self {
        let noise = chart.reference.floor();
        let seen = |one: &Measurement| Measurement { error: one.error.max(noise), ..one.clone() };
        let measurements: Vec<Measurement> =
            chart.measurements.iter().filter(|one| one.point().is_some()).map(seen).collect();
        Comparison::at(&measurements, level)
    }

    /// The comparison at an error level, from measurements taken as they are.
    pub fn at(measurements: &[Measurement], level: f64) -> Self {
        let best = |wanted: fn(Method) -> bool| best(measurements, level, wanted);
        Comparison {
            level,
            rival: best(Method::is_rival),
            ours: best(Method::is_ours),
            tolerance: best(|method| method == Method::LobattoTolerance),
            unestimated: best(|method| method == Method::LobattoUnestimated),
            second: self::best(measurements, 0.1 * level, Method::is_rival),
        }
    }

    /// Cost of the best rival over our best cost.
    pub fn ratio(&self) -> Option<f64> {
        quotient(self.rival, self.ours)
    }

    /// Cost of two runs of the best rivals, at the level and at a tenth of it, over the cost of our run with an estimate: both then know their error.
    pub fn tolerance_ratio(&self) -> Option<f64> {
        Some(quotient(self.rival, self.tolerance)? + quotient(self.second, self.tolerance)?)
    }

    /// Cost of one run of the best rival over the cost of our run without an estimate: neither knows its error.
    pub fn unestimated_ratio(&self) -> Option<f64> {
        quotient(self.rival, self.unestimated)
    }
}

fn quotient(rival: Option<Best>, ours: Option<Best>) -> Option<f64> {
    match (rival?.reach, ours?.reach) {
        (Reach::Cost(rival), Reach::Cost(ours)) => Some(rival / ours),
        _ => None,
    }
}

fn best(measurements: &[Measurement], level: f64, wanted: fn(Method) -> bool) -> Option<Best> {
    let candidates = Method::WITH_EVENTS.iter().copied().filter(|&method| wanted(method));
    let reached = candidates.map(|method| Best { method, reach: Front::of(measurements, &method.id()).at(level) });
    // Costs come before floors, and small numbers before large ones.
    let rank = |best: &Best| match best.reach {
        Reach::Cost(cost) => (0, cost),
        Reach::Floor(floor) => (1, floor),
        Reach::Nothing => (2, 0.0),
    };
    reached.filter(|best| best.reach != Reach::Nothing).min_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    })
}
