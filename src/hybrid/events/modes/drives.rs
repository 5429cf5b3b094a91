//! Motors within steps: both gains in the equations of the step, and their effect on the energy.
//!
//! A motor that follows its law `τ = kp (r − q) + kd (ṙ − q̇)` is, within a step, three things that the scheme has:
//!
//! ```text
//!     a spring        −kp (q − r₀)              r₀: a target that never changes, else 0     stiffness in Newton's matrix
//!     a damper        −kd q̇                                                                 damping in Newton's matrix
//!     an effort       e(t) = kp (r(t) − r₀) + kd ṙ(t)                                       at each stage
//! ```
//!
//! so that stiff gains cost iterations, not steps. Its work is the sum of the three: of the spring `−½ kp [(q − r₀)²]`, of the damper `−h Σ b_k kd
//! q̇_k²` and of the effort `h Σ b_k e_k q̇_k`, with the rates of the scheme.

use crate::events::modes::mode::{Mode, MotorMode};
use crate::instant::holding::elements::Elements;
use crate::instant::holding::held::Held;
use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::description::forces::{JointDamper, JointSpring};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::{Motor, MotorLaw};
use crate::mechanism::motion::inputs::ChangingEfforts;
use crate::mechanism::motion::state::State;
use crate::stepping::step_maker::PieceSteps;

/// How far the steps know of the targets that were given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Commands {
    /// All is known, or no target was given.
    #[default]
    Known,
    /// A motor that follows commands has another target.
    Given,
    /// A motor follows its first command: it is no spring any more.
    Begun,
}

/// The motors of a mode that follow their laws and move something.
#[derive(Clone)]
pub(crate) struct Drives {
    entries: Vec<Drive>,
    /// The motors whose efforts change in time, and the freedoms along which they act.
    changing: Vec<usize>,
    freedoms: Vec<usize>,
    /// Their targets are of the piece that begins at or before this time (s).
    since: f64,
    rates: Vec<f64>,
}

#[derive(Clone)]
struct Drive {
    motor: Motor,
    /// Its number.
    index: usize,
    /// The coordinate in the reduced mechanism.
    coordinate: Coordinate,
    /// r₀.
    rest: f64,
}

impl Drives {
    /// Adds the motors of a mode to the reduced mechanism.
    pub fn add(elements: &Elements, mode: &Mode, whole: &Mechanism, held: &mut Held) -> Self {
        let mut drives =
            Drives { entries: Vec::new(), changing: Vec::new(), freedoms: Vec::new(), since: 0.0, rates: Vec::new() };
        for (index, (motor, mode)) in elements.motors.iter().zip(&mode.motors).enumerate() {
            let Some(coordinate) = held.coordinate(whole, motor.coordinate) else { continue };
            if *mode != MotorMode::Unbounded {
                continue;
            }
            let (kp, kd) = motor.law.gains();
            let still = motor.target.is_constant();
            let rest =
                if still && matches!(motor.law, MotorLaw::Position { .. }) { motor.target.value(0.0) } else { 0.0 };
            let forces = &mut held.mechanism.forces;
            if kp > 0.0 {
                forces.joint_springs.push(JointSpring { coordinate, stiffness: kp, rest });
            }
            if kd > 0.0 {
                forces.joint_dampers.push(JointDamper { freedom: coordinate.freedom, coefficient: kd });
            }
            if !(still && matches!(motor.law, MotorLaw::Position { .. })) {
                drives.changing.push(drives.entries.len());
                drives.freedoms.push(coordinate.freedom);
            }
            drives.entries.push(Drive { motor: motor.clone(), index, coordinate, rest });
        }
        drives
    }

    /// Whether motors that follow commands have other targets now.
    pub fn is_behind(&self, elements: &Elements) -> bool {
        self.entries.iter().any(|drive| elements.motors[drive.index].target != drive.motor.target)
    }

    /// Takes over the targets that motors have now; the kind of each is as before.
    pub fn heed(&mut self, elements: &Elements) {
        for drive in &mut self.entries {
            drive.motor.target.copy_from(&elements.motors[drive.index].target);
        }
    }

    /// A step begins at this time (s).
    pub fn begin(&mut self, time: f64) {
        self.since = time;
    }

    /// Whether any effort changes in time.
    pub fn change(&self) -> bool {
        !self.changing.is_empty()
    }

    /// The energy that springs gave and dampers took in the last step of the reduced mechanism, from `start` to `end` (J).
    pub fn exchanged(&mut self, steps: &dyn PieceSteps, start: &State, end: &State) -> (f64, f64) {
        let (mut given, mut taken) = (0.0, 0.0);
        let length = end.time - start.time;
        for Drive { motor, coordinate, rest, .. } in &self.entries {
            let (kp, kd) = motor.law.gains();
            let stretch = |state: &State| state.position[coordinate.position] - rest;
            let moved = displacement(start, end, coordinate.position);
            // ½ kp (x₀² − x₁²), without cancellation.
            given -= 0.5 * kp * moved * (stretch(start) + stretch(end));
            if kd > 0.0 {
                taken += length * kd * steps.mean_square_rate(*coordinate, &mut self.rates);
            }
        }
        (given, taken)
    }
}

impl ChangingEfforts for Drives {
    fn freedoms(&self) -> &[usize] {
        &self.freedoms
    }

    fn effort(&self, entry: usize, time: f64) -> f64 {
        let Drive { motor, rest, .. } = &self.entries[self.changing[entry]];
        motor.drive(self.since, time) - motor.law.gains().0 * rest
    }
}

/// How far a scalar coordinate has moved, with what rounding left out of both positions.
pub(crate) fn displacement(start: &State, end: &State, position: usize) -> f64 {
    (end.position[position] - start.position[position]) + (end.compensation[position] - start.compensation[position])
}
