//! The joint settings of a scene file: motors, and values that replace the values of the URDF.
//!
//! Units: m, rad, N, N m, s.

use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::mechanism::description::target::{Interpolation, Target, TargetError};
use crate::scene::coupling::JointReference;
use std::path::PathBuf;

/// A `[[motor]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMotor {
    /// The joint that it drives.
    pub joint: JointReference,
    /// The name of the joint, as written.
    pub on: String,
    /// How its effort follows from its target.
    pub law: MotorLaw,
    /// Its target over time; of no use where the target is the start.
    pub target: Target,
    /// Whether its target is the position of its joint at the start of the run.
    pub at_start: bool,
    /// Natural frequency (rad/s) from which its gains follow at the start of the run, instead of the gains of its law: critically damped, with the
    /// inertia about its joint.
    pub frequency: Option<f64>,
    /// Whether it is left out where its joint is not simulated: it was not named for itself.
    pub lenient: bool,
    /// The table that the target was read from; `None` if the target is a number.
    pub table: Option<TargetTable>,
    /// The bound of its effort, if given; infinite where the file says that there is no bound.
    pub max_effort: Option<f64>,
    /// Time between two evaluations of its effort (s); zero if it is continuous.
    pub period: f64,
    /// The part of the weight beyond its joint that an effort besides its law holds, at every instant.
    pub gravity_compensation: f64,
    /// The line of its `joint`.
    pub line: usize,
}

/// A `[[motion]]`: a joint that is moved in time.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMotion {
    /// The joint.
    pub joint: JointReference,
    /// Its name, as written.
    pub on: String,
    /// Its position over time (rad or m).
    pub position: Target,
    /// The table that it was read from, if there is one.
    pub table: Option<TargetTable>,
    /// The line of its `joint`.
    pub line: usize,
}

/// The target of a motor as a table of the scene file or a CSV file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetTable {
    /// Time (s) and value of each entry.
    pub points: Vec<(f64, f64)>,
    /// How values between them come about.
    pub interpolation: Interpolation,
}

/// A `[[joint]]`: its values replace the values of the URDF, and `None` keeps the value of the URDF.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneJoint {
    /// The joint.
    pub joint: JointReference,
    /// Its name, as written.
    pub name: String,
    /// Its limits.
    pub limit: Option<LimitChoice>,
    /// Restitution of impacts on its limits, 0 to 1.
    pub restitution: Option<f64>,
    /// Dry friction [N m or N], not negative.
    pub friction: Option<f64>,
    /// Viscous damping [N m s/rad or N s/m], not negative.
    pub damping: Option<f64>,
    /// Inertia of the rotor that is geared to it, about its own coordinate [kg m² or kg], not negative.
    pub armature: Option<f64>,
    /// The line of its `name`.
    pub line: usize,
}

/// Limits that a scene file gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LimitChoice {
    /// No limits.
    Unlimited,
    /// Smallest and largest position [rad or m]; equal ones lock the joint.
    Range(f64, f64),
}

/// A text file that a scene names, such as the CSV file of a target.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// The path of its file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

impl TargetTable {
    /// The target that it gives.
    ///
    /// # Errors
    /// The wrong entry, counted from 0, if the defect belongs to one, and the defect.
    pub(crate) fn target(&self) -> Result<Target, (Option<usize>, String)> {
        let target = Target::table(&self.points, self.interpolation).map_err(|error| {
            let (entry, how) = match error {
                TargetError::Empty => (None, ""),
                TargetError::NotFinite { index, .. } => (index.checked_sub(1), ""),
                TargetError::Order { index, time, before } if time == before => {
                    (index.checked_sub(1), ", and interpolation = \"hold\" for jumps")
                }
                TargetError::Order { index, .. } => (index.checked_sub(1), ""),
            };
            (entry, format!("its table over time: {error}{how}"))
        })?;
        for (before, pair) in self.points.windows(2).enumerate() {
            let middle = 0.5 * pair[0].0 + 0.5 * pair[1].0;
            if !target.value(middle).is_finite() || !target.rate(middle).is_finite() {
                let reason =
                    "its table over time changes so much from the entry before that its rate is infinite".to_string();
                return Err((Some(before + 1), reason));
            }
        }
        Ok(target)
    }
}

impl LimitChoice {
    /// Limits between which there is a position.
    ///
    /// # Errors
    /// The defect of the limits.
    pub(crate) fn between(lower: f64, upper: f64) -> Result<Self, String> {
        if lower.is_nan() || upper.is_nan() {
            return Err("a limit must not be NaN; write -inf or inf where there is none".to_string());
        }
        if lower > upper {
            return Err(format!("the lower limit {lower} is above the upper limit {upper}; swap them"));
        }
        if lower == f64::INFINITY || upper == f64::NEG_INFINITY {
            return Err(format!("no position is between {lower} and {upper}"));
        }
        Ok(LimitChoice::Range(lower, upper))
    }
}
