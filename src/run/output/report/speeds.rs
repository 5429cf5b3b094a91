//! The observer that watches speeds of joints for which a largest one is given (`<limit velocity>` of a URDF).
//!
//! It sees the samples of a run, the first at the start and the last at the end. A speed that is exceeded between two samples alone is not seen. The
//! observer does not limit the speed of a joint.

use crate::mechanism::description::joint::JointKind;
use crate::mechanism::description::nonsmooth::SpeedLimit;
use crate::mechanism::ground::words::{rounded, short};
use crate::mechanism::motion::integrator::MethodDescription;
use crate::model::Model;
use crate::output::report::events::joint_name;
use crate::simulation::{Observer, ObserverError, Sample};

/// A speed at its limit is not beyond it for a rounding.
const ROUNDING: f64 = 1e-9;

/// Keeps the largest speeds that were seen.
pub struct SpeedWatch {
    joints: Vec<Watched>,
}

/// A joint that is watched.
struct Watched {
    name: String,
    unit: &'static str,
    limit: SpeedLimit,
    /// The largest speed so far [rad/s or m/s].
    largest: f64,
}

impl SpeedWatch {
    /// Watches all joints of a model for which a largest speed is given, if there are any.
    pub fn new(model: &Model) -> Option<Self> {
        let joints: Vec<Watched> = model
            .mechanism
            .nonsmooth
            .speeds
            .iter()
            .map(|&limit| {
                let body = limit.coordinate.body;
                let slides =
                    model.mechanism.bodies.get(body).is_some_and(|body| body.joint.kind == JointKind::Prismatic);
                let unit = if slides { "m/s" } else { "rad/s" };
                Watched { name: joint_name(model, body).to_string(), unit, limit, largest: 0.0 }
            })
            .collect();
        (!joints.is_empty()).then_some(SpeedWatch { joints })
    }

    /// The warning in one line: the joint that was faster by the largest factor, and how many others were too fast.
    pub fn warning(&self) -> Option<String> {
        let over = |joint: &Watched| joint.largest / joint.limit.speed;
        let fast: Vec<&Watched> = self.joints.iter().filter(|joint| over(joint) > 1.0 + ROUNDING).collect();
        let Watched { name, unit, limit, largest } = *fast.iter().max_by(|a, b| over(a).total_cmp(&over(b)))?;
        let (seen, speed) = (rounded(*largest), limit.speed);
        // All digits where three of them do not tell the difference.
        let seen = if seen == rounded(speed) { short(*largest) } else { seen };
        let speed = short(speed);
        let others = match fast.len() - 1 {
            0 => String::new(),
            1 => "; 1 more joint is too fast".to_string(),
            more => format!("; {more} more joints are too fast"),
        };
        Some(format!(
            "joint {name:?} moves at up to {seen} {unit}, its <limit velocity> is {speed}: it is watched, not enforced{others}"
        ))
    }
}

impl Observer for SpeedWatch {
    fn begin_again(&mut self, _: &MethodDescription) -> Result<(), ObserverError> {
        self.joints.iter_mut().for_each(|joint| joint.largest = 0.0);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        for joint in &mut self.joints {
            let speed = sample.velocity.get(joint.limit.coordinate.freedom).map_or(0.0, |rate| rate.abs());
            joint.largest = joint.largest.max(speed);
        }
        Ok(())
    }

    fn skips_contacts(&self) -> bool {
        true
    }
}
