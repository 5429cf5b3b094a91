//! Collects the kept quantities of a run: samples of curves, and the extremes of the samples.

use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::motion::integrator::MethodDescription;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::model::Model;
use crate::simulation::{Observer, ObserverError, Sample};
use crate::sweep::quantities::{Instant, Kept};
use crate::sweep::rows::Cell;

/// The smallest and the largest value so far, with their times (s).
#[derive(Clone, Copy, Default)]
struct Extremes {
    least: Option<(f64, f64)>,
    most: Option<(f64, f64)>,
}

/// The observations of a run.
pub(super) struct Watch<'w> {
    model: &'w Model,
    kept: &'w Kept,
    bodies: Vec<BodyState>,
    times: Vec<f64>,
    curves: Vec<Vec<f64>>,
    extremes: Vec<Extremes>,
}

impl<'w> Watch<'w> {
    pub fn new(model: &'w Model, kept: &'w Kept) -> Self {
        Watch {
            model,
            kept,
            bodies: vec![WORLD; model.mechanism.bodies.len()],
            times: Vec::new(),
            curves: vec![Vec::new(); kept.curves.len()],
            extremes: vec![Extremes::default(); kept.extremes.len()],
        }
    }

    /// The cells of extremes.
    pub fn extremes(&self, cells: &mut Vec<Cell>) {
        for of in &self.extremes {
            for seen in [of.least, of.most] {
                let [value, time] = seen
                    .map_or([Cell::Nothing, Cell::Nothing], |(value, time)| [Cell::Number(value), Cell::Number(time)]);
                cells.extend([value, time]);
            }
        }
    }

    /// The cells of curves.
    pub fn curves(self, cells: &mut Vec<Cell>) {
        if !self.curves.is_empty() {
            cells.push(Cell::Numbers(self.times));
        }
        cells.extend(self.curves.into_iter().map(Cell::Numbers));
    }
}

impl Observer for Watch<'_> {
    fn begin_again(&mut self, _: &MethodDescription) -> Result<(), ObserverError> {
        self.times.clear();
        self.curves.iter_mut().for_each(Vec::clear);
        self.extremes.fill(Extremes::default());
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        forward_kinematics(&self.model.mechanism, sample.position, sample.velocity, &mut self.bodies);
        let instant =
            Instant { model: self.model, position: sample.position, velocity: sample.velocity, bodies: &self.bodies };
        if !self.curves.is_empty() {
            self.times.push(sample.time);
        }
        for (curve, quantity) in self.curves.iter_mut().zip(&self.kept.curves) {
            curve.push(instant.value(quantity).unwrap_or(f64::NAN));
        }
        for (of, quantity) in self.extremes.iter_mut().zip(&self.kept.extremes) {
            let Some(value) = instant.value(quantity) else { continue };
            if of.least.is_none_or(|(least, _)| value < least) {
                of.least = Some((value, sample.time));
            }
            if of.most.is_none_or(|(most, _)| value > most) {
                of.most = Some((value, sample.time));
            }
        }
        Ok(())
    }
}
