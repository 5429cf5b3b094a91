//! The efforts that act in a mode beside its springs and dampers, with their derivatives by the parameters and by time.
//!
//! ```text
//!     −σ τ_f           a joint that slides            ± bound      a motor at its bound
//!     kp r(t) + kd ṙ   a motor that follows its law   τ(t)         a load over time, an effort held since a tick
//! ```

use crate::derivatives::events::parameter::{Parameter, TimeLaws, WEIGHTS};
use crate::derivatives::forward::step::WIDTH;
use crate::derivatives::forward::tangent::Varied;
use crate::events::trace::{JointMode, Mode, MotorMode};
use crate::instant::holding::elements::Elements;
use nalgebra::{DMatrix, DVector};

/// Targets are polynomials between their instants, and waves are slow beside this time (s): differences over it are exact to rounding.
const SPAN: f64 = 1e-3;

/// Efforts at an instant.
#[derive(Clone)]
pub struct Efforts {
    /// n.
    pub values: DVector<f64>,
    /// By the parameters (n × p).
    pub slopes: DMatrix<f64>,
    /// By time (n).
    pub rates: DVector<f64>,
}

/// The laws of the efforts of a run.
pub(crate) struct EffortLaws<'e> {
    pub elements: &'e Elements,
    pub laws: &'e TimeLaws,
    pub parameters: &'e [Parameter],
    pub varied: &'e Varied,
}

impl EffortLaws<'_> {
    /// The efforts of a mode at some times (s), in the piece of targets that begins at or before `since`; `given` are the derivatives of efforts that
    /// are held between ticks (motors × p).
    pub fn at(&self, mode: &Mode, given: &DMatrix<f64>, since: f64, times: &[f64], freedoms: usize) -> Vec<Efforts> {
        let mut all = vec![self.constant(mode, given, freedoms); times.len()];
        all.iter_mut().zip(times).for_each(|(found, &time)| self.add_timed(mode, since, time, found));
        all
    }

    /// The efforts that do not depend on time.
    fn constant(&self, mode: &Mode, given: &DMatrix<f64>, freedoms: usize) -> Efforts {
        let p = self.parameters.len();
        let mut found = Efforts {
            values: DVector::zeros(freedoms),
            slopes: DMatrix::zeros(freedoms, p),
            rates: DVector::zeros(freedoms),
        };
        for (column, parameter) in self.parameters.iter().enumerate() {
            found.slopes.column_mut(column).copy_from(&parameter.constant_effort);
        }
        for (index, (joint, mode)) in self.elements.joints.iter().zip(&mode.joints).enumerate() {
            if let JointMode::Free { sliding } = mode {
                let (freedom, sign) = (joint.coordinate.freedom, -f64::from(*sliding));
                found.values[freedom] += sign * joint.friction;
                self.each(|chunk, part, column| {
                    let friction = &self.varied.chunks()[chunk].laws.joints[index].friction;
                    found.slopes[(freedom, column)] += sign * friction.parts[part];
                });
            }
        }
        for (index, (motor, mode)) in self.elements.motors.iter().zip(&mode.motors).enumerate() {
            let freedom = motor.coordinate.freedom;
            match *mode {
                MotorMode::Unbounded => {}
                MotorMode::Saturated(sign) => {
                    let sign = f64::from(sign);
                    found.values[freedom] += sign * motor.max_effort;
                    self.each(|chunk, part, column| {
                        let bound = &self.varied.chunks()[chunk].laws.motors[index].bound;
                        found.slopes[(freedom, column)] += sign * bound.parts[part];
                    });
                }
                MotorMode::Given(effort) => {
                    found.values[freedom] += effort;
                    (0..p).for_each(|column| found.slopes[(freedom, column)] += given[(index, column)]);
                }
            }
        }
        found
    }

    /// Adds those that do.
    fn add_timed(&self, mode: &Mode, since: f64, time: f64, found: &mut Efforts) {
        for (index, (motor, mode)) in self.elements.motors.iter().zip(&mode.motors).enumerate() {
            if *mode == MotorMode::Unbounded {
                let piece = self.laws.piece(index, since);
                self.add(found, motor.coordinate.freedom, time, |laws, time| driven(laws, index, piece, time));
            }
        }
        for (index, load) in self.laws.courses.iter().enumerate() {
            self.add(found, load.freedom, time, |laws, time| {
                laws.courses[index].effort * laws.courses[index].course.value(since, time)
            });
        }
    }

    /// The part of the effort of a motor that follows its law which depends on time alone: its value, its derivatives by the parameters (p) and by time.
    pub fn drive(&self, motor: usize, since: f64, time: f64) -> (f64, DVector<f64>, f64) {
        let p = self.parameters.len();
        let mut found = Efforts { values: DVector::zeros(1), slopes: DMatrix::zeros(1, p), rates: DVector::zeros(1) };
        let piece = self.laws.piece(motor, since);
        self.add(&mut found, 0, time, |laws, time| driven(laws, motor, piece, time));
        (found.values[0], found.slopes.row(0).transpose(), found.rates[0])
    }

    fn add(&self, found: &mut Efforts, freedom: usize, time: f64, of: impl Fn(&TimeLaws, f64) -> f64) {
        found.values[freedom] += of(self.laws, time);
        for (column, parameter) in self.parameters.iter().enumerate() {
            found.slopes[(freedom, column)] += parameter.slope(|laws| of(laws, time));
        }
        for (index, weight) in WEIGHTS.iter().enumerate() {
            let by = (index + 1) as f64 * SPAN;
            found.rates[freedom] += weight * (of(self.laws, time + by) - of(self.laws, time - by)) / SPAN;
        }
    }

    /// Calls `each(chunk, part, column)` for every parameter.
    fn each(&self, mut each: impl FnMut(usize, usize, usize)) {
        (0..self.parameters.len()).for_each(|column| each(column / WIDTH, column % WIDTH, column));
    }
}

/// The part of the effort of a motor that depends on time alone, in a piece of its target, whose instants move with the parameters.
fn driven(laws: &TimeLaws, motor: usize, piece: usize, time: f64) -> f64 {
    laws.motors[motor].drive(laws.beginning(motor, piece), time)
}
