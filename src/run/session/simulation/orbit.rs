//! Multipliers of a motion that comes back: how slight changes of its start have grown after a period.
//!
//! ```text
//!     Φ = ∂(q, v)(T)/∂(q, v)(0)                 multipliers μ: eigenvalues of Φ         growth ln|μ|/T,   rotation arg μ/2π
//! ```
//!
//! Φ is the derivative of the steps of the run, in the same frames at both ends. Multipliers of conservative motions come in pairs μ, 1/μ. An orbit that
//! may begin anywhere on itself has the multiplier 1; with energy it has it twice, and that pair is found to the root of roundings alone.
//!
//! Source: G. Floquet, Annales scientifiques de l'École normale supérieure 12 (1883).

use crate::session::error::Error;
use crate::session::simulation::Simulation;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;

/// Directions of starts that loops close have singular values below this part of the largest: closing loops leaves as much.
const CLOSED: f64 = 1e-8;

/// Multipliers of a motion over a period.
#[derive(Clone, Debug)]
pub struct Multipliers {
    /// The time at which it begins (s).
    pub begin: f64,
    /// T (s).
    pub period: f64,
    /// μ, the largest first; a complex pair has two.
    pub values: Vec<Complex<f64>>,
    /// How far q and v at the end are from the start [rad, m, and per s]; whole turns of joints count as none.
    pub apart: f64,
    /// Warnings: causes of derivatives that are worse than their order.
    pub warnings: Vec<String>,
}

impl Simulation {
    /// Makes the run to its end, and takes its duration for the period of a motion that comes back.
    ///
    /// # Errors
    /// As of [`Simulation::sensitivity`].
    pub fn multipliers(self) -> Result<Multipliers, Error> {
        let model = self.model().clone();
        let run = self.sensitivity(&["start.q", "start.v"])?;
        let matrix = |row: usize| {
            let (n, columns) = run.dq[row].shape();
            let mut whole = DMatrix::zeros(2 * n, columns);
            whole.view_mut((0, 0), (n, columns)).copy_from(&run.dq[row]);
            whole.view_mut((n, 0), (n, columns)).copy_from(&run.dv[row]);
            whole
        };
        let last = run.times.len() - 1;
        let begun = matrix(0);
        // On closed loops a start follows from fewer numbers; the others are projected, and have multipliers of zero.
        let starts = begun.singular_values();
        let count = starts.iter().filter(|value| **value > CLOSED * starts.max()).count();
        let mut values: Vec<Complex<f64>> = matrix(last).complex_eigenvalues().iter().copied().collect();
        values.sort_by(|one, other| other.norm().total_cmp(&one.norm()).then(other.im.total_cmp(&one.im)));
        values.truncate(count);
        let [begin, end] = [0, last].map(|row| (&run.q[row], &run.v[row]));
        let mut apart = end.1.iter().zip(begin.1).map(|(end, begin)| (end - begin).abs()).fold(0.0, f64::max);
        for joint in model.coordinates().joints() {
            let [one, other] = [begin.0, end.0].map(|q| &q[joint.q.clone()]);
            let slides = if joint.q.len() == joint.v.len() { joint.q.len() } else { joint.q.len() - 4 };
            let kind = model.description().joints[joint.record].body;
            let kind = kind.map(|body| model.description().mechanism.bodies[body].joint.kind);
            for entry in 0..slides {
                let off = other[entry] - one[entry];
                let turns = kind.is_some_and(|kind| kind.unit(entry) == "rad");
                apart = apart.max(if turns { off - TAU * (off / TAU).round() } else { off }.abs());
            }
            // Both signs of a quaternion are one turn.
            let turned = |sign: f64| {
                let pairs = one[slides..].iter().zip(&other[slides..]);
                pairs.map(|(one, other)| (sign * other - one).abs()).fold(0.0, f64::max)
            };
            apart = apart.max(turned(1.0).min(turned(-1.0)));
        }
        let (begin, period) = (run.times[0], run.times[last] - run.times[0]);
        Ok(Multipliers { begin, period, values, apart, warnings: run.warnings })
    }
}
