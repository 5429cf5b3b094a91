//! The gradient of a loss of samples of a run by any number of parameters, against time.
//!
//! ```text
//!     run ─▶ tape ─▶ q, v at the given times ─▶ the loss: its value, ∂/∂q, ∂/∂v ─▶ back to the start: ∂/∂θ
//! ```
//!
//! The steps of the run also end at the samples, so that no interpolation has a part in it.

use crate::derivatives::events::reverse::{Adjoint, Tape};
use crate::session::error::Error;
use crate::session::simulation::Simulation;
use crate::session::simulation::sensitivity::prepared::Prepared;
use nalgebra::DVector;

/// The parameters and the samples of a gradient.
#[derive(Clone, Copy, Debug)]
pub struct Backward<'b> {
    /// Parameters, as [`Simulation::sensitivity`] takes them.
    pub keys: &'b [&'b str],
    /// The times of the samples after the start, in their order (s).
    pub times: &'b [f64],
    /// One of so many states of the tape is kept, and those between are computed again: 1 keeps all. The gradient is the same.
    pub every: usize,
}

/// The samples of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// s.
    pub times: Vec<f64>,
    /// q and v at these times.
    pub q: Vec<Vec<f64>>,
    /// v.
    pub v: Vec<Vec<f64>>,
}

/// A loss of samples with its derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lost {
    /// Its value.
    pub value: f64,
    /// By the displacements along the degrees of freedom at each sample (n each); turns of ball joints are about the axes of the child.
    pub by_q: Vec<Vec<f64>>,
    /// By the velocities (n each).
    pub by_v: Vec<Vec<f64>>,
}

/// A loss and its gradient.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient {
    /// The parameters θ (p).
    pub keys: Vec<String>,
    /// The loss.
    pub value: f64,
    /// ∂/∂θ (p).
    pub by: Vec<f64>,
}

impl Simulation {
    /// Makes the run to its end, and computes the gradient of a loss of its samples by parameters, at a cost that hardly depends on their number.
    ///
    /// ```
    /// use catena::prelude::*;
    /// use catena::session::{Backward, Lost, Samples};
    ///
    /// let model = Model::load("robots/double_pendulum.urdf")?;
    /// // The square of the first angle at the end.
    /// let loss = |samples: &Samples| {
    ///     let angle = samples.q[0][0];
    ///     Lost { value: angle * angle, by_q: vec![vec![2.0 * angle, 0.0]], by_v: vec![vec![0.0; 2]] }
    /// };
    /// let asked = Backward { keys: &["start.q.shoulder", "lower_arm.mass"], times: &[0.5], every: 1 };
    /// let found = Simulation::new(&model).duration(0.5).start([("shoulder", 1.0)])?.gradient(&asked, loss)?;
    /// assert_eq!(found.by.len(), 2);
    /// # Ok::<(), catena::session::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::sensitivity`]; motors with ticks and corners that stick have no derivatives against time; a loss with other numbers of samples
    /// or degrees of freedom.
    pub fn gradient(self, asked: &Backward, loss: impl FnOnce(&Samples) -> Lost) -> Result<Gradient, Error> {
        let prepared = Prepared::new(self, asked.keys, asked.times)?;
        let (subject, mut run) = (prepared.subject(&[]), prepared.traced()?);
        let mut tape = Tape::new(&subject, &prepared.start, asked.every);
        let mut samples = Samples::default();
        let mut pieces = Vec::new();
        let (mut state, mut count) = (prepared.start.clone(), 0);
        while let Some(until) = prepared.until(state.time) {
            tape.add(prepared.step(&mut run, &mut state, until)?)?;
            if asked.times.contains(&state.time) {
                let (q, v) = prepared.model.flat(tape.state());
                samples.times.push(state.time);
                samples.q.push(q);
                samples.v.push(v);
                pieces.push(count);
            }
            count += 1;
        }
        prepared.check(tape.state())?;
        let lost = loss(&samples);
        let n = prepared.start.velocity.len();
        for (what, rows) in [("derivatives of the loss by q", &lost.by_q), ("derivatives of the loss by v", &lost.by_v)]
        {
            let given = rows.iter().find(|row| row.len() != n).map(Vec::len);
            if let Some((given, wanted)) =
                given.map(|given| (given, n)).or((rows.len() != pieces.len()).then_some((rows.len(), pieces.len())))
            {
                return Err(Error::Count { what, given, wanted });
            }
        }
        let of_end = |piece: usize| {
            let sample = pieces.iter().position(|known| *known == piece)?;
            let [positions, velocities] = [&lost.by_q, &lost.by_v].map(|of| DVector::from_column_slice(&of[sample]));
            Some(Adjoint { positions, velocities, time: 0.0 })
        };
        let by = tape.gradient(&prepared.parameters, &of_end)?;
        Ok(Gradient { keys: prepared.told, value: lost.value, by })
    }
}
