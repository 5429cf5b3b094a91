//! Motors that hold their joints where a run starts.
//!
//! ```text
//!     r = q(0),   and where no gains are given  kp = M ω²,  kd = 2 M ω
//! ```
//!
//! with the position q of the joint [rad or m], the target r of its motor, the diagonal entry M of the mass matrix at the start, which is the inertia
//! about the joint with all others held [kg m² or kg], and a natural frequency ω (rad/s): critically damped.

use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::{Motor, MotorLaw};
use crate::mechanism::description::target::Target;
use crate::mechanism::motion::state::State;
use crate::model::Model;
use crate::output::report::joint_name;
use crate::scene::{JointReference, Scene, SceneMotor};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The natural frequency of motors that hold a robot without given gains (rad/s): 10 Hz. A joint that carries a weight at a distance l gives way by
/// g/(l ω²), 2.5 mm at 1 m.
const FREQUENCY: f64 = 20.0 * std::f64::consts::PI;

/// `--hold`: motors that hold all joints without motors of their own where the run starts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hold {
    /// N m/rad or N/m.
    pub kp: Option<f64>,
    /// N m s/rad or N s/m; with `kp` alone 0.
    pub kd: Option<f64>,
    /// The part of the weight beyond each joint that an effort besides the gains holds; 0 without it.
    pub gravity: Option<f64>,
}

impl Hold {
    /// Adds the motors to a scene.
    pub(crate) fn add_to(self, scene: &mut Scene) {
        let (law, frequency) = match (self.kp, self.kd) {
            (None, None) => (MotorLaw::Position { kp: 0.0, kd: 0.0 }, Some(FREQUENCY)),
            (kp, kd) => (MotorLaw::Position { kp: kp.unwrap_or(0.0), kd: kd.unwrap_or(0.0) }, None),
        };
        for (robot, placed) in scene.robots.iter().enumerate() {
            for joint in placed.robot.joints.iter().filter(|joint| joint.can_be_driven()) {
                let reference = JointReference { robot, joint: joint.name.clone() };
                let moved = scene.motions.iter().any(|motion| motion.joint == reference);
                if moved || scene.motors.iter().any(|motor| motor.joint == reference) {
                    continue;
                }
                scene.motors.push(SceneMotor {
                    joint: reference,
                    on: format!("{}{}", placed.prefix, joint.name),
                    law,
                    target: Target::constant(0.0),
                    at_start: true,
                    frequency,
                    lenient: true,
                    table: None,
                    max_effort: None,
                    period: 0.0,
                    gravity_compensation: self.gravity.unwrap_or(0.0),
                    line: placed.line,
                });
            }
        }
    }
}

/// The motors of a run from this state, if they differ from the motors of the model. Motors with a known target hold their joints there, with these gains
/// where none are given: the run before has done so.
pub(crate) fn motors_from(model: &Model, start: &State, known: &HeldTargets) -> Option<Vec<Motor>> {
    if model.at_start.is_empty() {
        return None;
    }
    let mut motors = model.mechanism.nonsmooth.motors.clone();
    let tuned = model.at_start.iter().any(|held| held.frequency.is_some());
    let masses = tuned.then(|| mass_matrix(&model.mechanism, start));
    for held in &model.at_start {
        let Some(motor) = motors.get_mut(held.motor) else { continue };
        let known = known.get(joint_name(model, motor.coordinate.body));
        let position = start.position[motor.coordinate.position];
        motor.target = Target::constant(known.map_or(position, |&[target, ..]| target));
        if let (Some(frequency), Some(masses)) = (held.frequency, &masses) {
            let inertia = masses[(motor.coordinate.freedom, motor.coordinate.freedom)];
            let own = [inertia * frequency * frequency, 2.0 * inertia * frequency];
            let [kp, kd] = known.map_or(own, |&[_, kp, kd]| [kp, kd]);
            motor.law = MotorLaw::Position { kp, kd };
        }
    }
    Some(motors)
}

/// Motors that hold their joints at the start of a run: by the names of joints the target (rad or m), kp and kd.
pub type HeldTargets = BTreeMap<String, [f64; 3]>;

/// The same of a model that runs. Logs have them, so that a run that goes on from a log holds the joints where that run has held them.
pub(crate) fn held_targets(model: &Model) -> HeldTargets {
    let motors = &model.mechanism.nonsmooth.motors;
    let held = model.at_start.iter().filter_map(|held| motors.get(held.motor));
    let numbers = |motor: &Motor| match motor.law {
        MotorLaw::Position { kp, kd } => Some([motor.target.value(0.0), kp, kd]),
        MotorLaw::Velocity { .. } | MotorLaw::Effort => None,
    };
    let named = held.filter_map(|motor| Some((joint_name(model, motor.coordinate.body).to_string(), numbers(motor)?)));
    named.collect()
}

/// The mechanism of a run from this state.
pub fn mechanism_from<'m>(model: &'m Model, start: &State) -> Cow<'m, Mechanism> {
    match motors_from(model, start, &HeldTargets::new()) {
        None => Cow::Borrowed(&model.mechanism),
        Some(motors) => {
            let mut mechanism = model.mechanism.clone();
            mechanism.nonsmooth.motors = motors;
            Cow::Owned(mechanism)
        }
    }
}
