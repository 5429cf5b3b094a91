//! The messages of `/motors`: the effort of every motor at every sample, and then the efforts `NAME/gravity_compensation` that hold weights.
//!
//! The effort of a continuous motor follows from the sample. A sampled motor holds its effort between ticks, which the steps of a run know. Where they
//! do not tell it, it follows from the state at the last tick, which is a sample only by chance. The state is taken from the cubic polynomial with the
//! positions `q₀, q₁` and rates `v₀, v₁` of the samples before and after the tick, `h` apart:
//!
//! ```text
//!     q(x) = q₀ + x (h v₀ + x (3Δ − 2 h v₀ − h v₁ + x (h v₀ + h v₁ − 2Δ))),   Δ = q₁ − q₀,   x = (t − t₀)/h
//! ```
//!
//! It is exact where ticks are samples, and otherwise off by O(h⁴), or by the jump of the rate if an impact lies between the same two
//! samples. A log with at least one sample per tick at the times of the ticks has exact efforts.

use crate::lobatto::instants::snapshot::INSTANTS;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::model::Model;
use crate::output::log::encoding::definitions::JOINT_STATE;
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::template::Template;
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;
use crate::output::report::joint_name;

/// Writes the efforts of motors.
pub(crate) struct MotorMessages {
    channel: Option<u16>,
    template: Template,
    motors: Vec<LoggedMotor>,
    /// One entry a motor, sample after sample.
    efforts: Vec<f64>,
    /// The efforts that hold weights, if there are any.
    holding: Option<Holding>,
}

/// The efforts that hold weights.
struct Holding {
    mechanism: Mechanism,
    bodies: Vec<BodyState>,
    /// One entry for each, sample after sample.
    efforts: Vec<f64>,
}

impl Holding {
    fn of(mechanism: &Mechanism) -> Option<Self> {
        (!mechanism.forces.gravity_compensations.is_empty()).then(|| Holding {
            mechanism: mechanism.clone(),
            bodies: vec![WORLD; mechanism.bodies.len()],
            efforts: Vec::new(),
        })
    }

    /// Adds the efforts of a sample.
    fn add(&mut self, position: &[f64], velocity: &[f64]) {
        let Holding { mechanism, bodies, efforts } = self;
        forward_kinematics(mechanism, position, velocity, bodies);
        let all = &mechanism.forces.gravity_compensations;
        efforts.extend(all.iter().map(|holding| holding.effort(mechanism, bodies)));
    }
}

/// The end of the name of an effort that holds a weight.
pub(crate) const OF_GRAVITY: &str = "/gravity_compensation";

impl MotorMessages {
    /// Adds the channel if the model has motors and it is wanted; without it efforts are worked out all the same, because reactions follow
    /// from them.
    pub(crate) fn new(sink: &mut dyn MessageSink, model: &Model, wanted: &Topics) -> Result<Option<Self>, LogError> {
        let motors = &model.mechanism.nonsmooth.motors;
        if motors.is_empty() {
            return Ok(None);
        }
        let is_wanted = wanted.has("/motors");
        let channel = is_wanted.then(|| sink.channel("/motors", &JOINT_STATE, Durability::Volatile)).transpose()?;
        let holding = model.mechanism.forces.gravity_compensations.iter();
        let holding =
            holding.map(|holding| format!("{}{OF_GRAVITY}", model.mechanism.joint_of_freedom(holding.freedom)));
        let names = motors.iter().map(|motor| joint_name(model, motor.coordinate.body).to_string()).chain(holding);
        let names: Vec<String> = names.collect();
        Ok(Some(MotorMessages {
            channel,
            template: Template::efforts("", names.iter().map(String::as_str)),
            holding: Holding::of(&model.mechanism),
            motors: motors.iter().cloned().map(LoggedMotor::new).collect(),
            efforts: Vec::with_capacity(INSTANTS * motors.len()),
        }))
    }

    /// Works out the efforts at some samples; samples come in order of time. `held` has the efforts that sampled motors are known to hold there, an entry
    /// a motor, or is empty.
    pub(crate) fn work_out(&mut self, times: &[f64], positions: &[f64], velocities: &[f64], held: &[Option<f64>]) {
        self.efforts.clear();
        self.holding.iter_mut().for_each(|holding| holding.efforts.clear());
        let samples =
            positions.chunks(positions.len() / times.len()).zip(velocities.chunks(velocities.len() / times.len()));
        let count = self.motors.len();
        for (sample, (&time, (position, velocity))) in times.iter().zip(samples).enumerate() {
            let held = held.get(sample * count..(sample + 1) * count).unwrap_or_default();
            for (index, logged) in self.motors.iter_mut().enumerate() {
                let coordinate = logged.motor.coordinate;
                let seen = Seen { time, position: position[coordinate.position], rate: velocity[coordinate.freedom] };
                let worked_out = logged.effort(seen);
                self.efforts.push(held.get(index).copied().flatten().unwrap_or(worked_out));
            }
            if let Some(holding) = self.holding.as_mut().filter(|_| self.channel.is_some()) {
                holding.add(position, velocity);
            }
        }
    }

    /// The efforts at those samples: one entry a motor, sample after sample.
    pub(crate) fn efforts(&self) -> &[f64] {
        &self.efforts
    }

    /// Adds the message of one of them.
    pub(crate) fn write(&self, sample: usize, stamp: u64, sink: &mut dyn MessageSink) -> Result<(), LogError> {
        let Some(channel) = self.channel else { return Ok(()) };
        let count = self.motors.len();
        let message = sink.message(channel, stamp, self.template.encoded())?;
        self.template.fill_stamp(message, stamp);
        let holding = self.holding.as_ref().map_or(&[][..], |holding| {
            let count = holding.mechanism.forces.gravity_compensations.len();
            &holding.efforts[sample * count..][..count]
        });
        let efforts = self.efforts[sample * count..][..count].iter().chain(holding);
        self.template.fill(message, 0, efforts.copied());
        Ok(())
    }
}

/// The coordinate of a motor in a sample.
#[derive(Clone, Copy)]
struct Seen {
    time: f64,
    position: f64,
    rate: f64,
}

impl Seen {
    /// Position and rate at a time between two samples.
    fn between(self, other: Seen, time: f64) -> (f64, f64) {
        let step = other.time - self.time;
        let x = (time - self.time) / step;
        if x >= 1.0 {
            return (other.position, other.rate);
        }
        let change = other.position - self.position;
        let (first, second) = (step * self.rate, step * other.rate);
        let (square, cubic) = (3.0 * change - 2.0 * first - second, first + second - 2.0 * change);
        let position = self.position + x * (first + x * (square + x * cubic));
        (position, (first + x * (2.0 * square + x * 3.0 * cubic)) / step)
    }
}

/// A motor, and the known state at its last tick.
struct LoggedMotor {
    motor: Motor,
    last: Option<Seen>,
    /// The number of the last tick, and the effort that is held since.
    tick: f64,
    held: f64,
}

impl LoggedMotor {
    fn new(motor: Motor) -> Self {
        LoggedMotor { motor, last: None, tick: 0.0, held: 0.0 }
    }

    /// The effort at a sample.
    fn effort(&mut self, seen: Seen) -> f64 {
        let period = self.motor.period;
        if period <= 0.0 {
            return self.motor.effort(seen.time, seen.position, seen.rate);
        }
        // A tick that the sample has reached but for a rounding is reached.
        let tick = (seen.time / period + 1e-9).floor();
        match self.last.replace(seen) {
            None => self.held = self.motor.effort(seen.time, seen.position, seen.rate),
            Some(before) if tick > self.tick => {
                let time = tick * period;
                let (position, rate) = before.between(seen, time);
                self.held = self.motor.effort(time, position, rate);
            }
            Some(_) => {}
        }
        self.tick = tick;
        self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::closure::Coordinate;
    use crate::mechanism::description::nonsmooth::MotorLaw;
    use crate::mechanism::description::target::Target;

    fn motor(period: f64) -> LoggedMotor {
        LoggedMotor::new(Motor {
            coordinate: Coordinate { body: 0, position: 0, freedom: 0 },
            law: MotorLaw::Position { kp: 10.0, kd: 2.0 },
            target: Target::constant(1.0),
            max_effort: 100.0,
            period,
            held: None,
        })
    }

    /// q = t − t² + t³.
    fn seen(time: f64) -> Seen {
        Seen { time, position: time - time * time + time.powi(3), rate: 1.0 - 2.0 * time + 3.0 * time * time }
    }

    fn of_state(time: f64) -> f64 {
        motor(0.0).effort(seen(time))
    }

    #[test]
    fn a_sampled_motor_holds_the_effort_of_its_last_tick_between_samples() {
        let mut sampled = motor(0.1);
        for time in [0.0, 0.06, 0.12, 0.18, 0.3, 0.55, 0.6] {
            let tick = (time / 0.1 + 1e-9_f64).floor() * 0.1;
            let effort = sampled.effort(seen(time));
            assert!((effort - of_state(tick)).abs() < 1e-13, "at {time}: {effort} and not {}", of_state(tick));
        }
    }

    #[test]
    fn a_continuous_motor_has_the_effort_of_the_sample_within_its_bound() {
        let mut bounded = motor(0.0);
        assert_eq!(bounded.effort(seen(0.5)), 10.0 * (1.0 - 0.375) - 2.0 * 0.75);
        bounded.motor.max_effort = 3.0;
        assert_eq!(bounded.effort(seen(0.5)), 3.0);
    }
}
