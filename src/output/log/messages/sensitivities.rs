//! The messages of `/sensitivities/…`: the derivatives of the run by a parameter, a topic each, at the ends of steps.
//!
//! A message is a `sensor_msgs/msg/JointState`. Its names are degrees of freedom, its positions ∂q/∂θ and its velocities ∂v/∂θ. If the standard
//! deviation σ of θ is known, its efforts are σ |∂q/∂θ|. The frame of its header is the whole key of θ. The name of a topic has a slash for each dot
//! of the key, and an underscore for all that ROS does not allow in names.
//!
//! Ends of steps whose instants move with a parameter, as those at events, have no message: derivatives are at fixed times.

use crate::output::log::encoding::definitions::{JOINT_STATE, SENSITIVITIES};
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::template::Template;
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;
use std::sync::Arc;

/// The derivatives of a run, which its log has besides.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// The parameters.
    pub keys: Vec<String>,
    /// Their standard deviations, where they are known.
    pub deviations: Vec<Option<f64>>,
    /// The degrees of freedom (n).
    pub freedoms: Vec<String>,
    /// At the ends of steps, in order of time.
    pub rows: Vec<DerivativesRow>,
}

/// The derivatives at the end of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DerivativesRow {
    /// s.
    pub time: f64,
    /// ∂q/∂θ and ∂v/∂θ, for each parameter (n each).
    pub slopes: Vec<[Vec<f64>; 2]>,
}

/// Writes the derivatives.
pub(crate) struct SensitivityMessages {
    derivatives: Arc<Derivatives>,
    /// Channels, layouts and standard deviations, one a parameter.
    topics: Vec<(u16, Template, Option<f64>)>,
}

impl SensitivityMessages {
    /// Adds the channels, if there are derivatives and they are wanted.
    pub(crate) fn new(
        sink: &mut dyn MessageSink,
        derivatives: Option<&Arc<Derivatives>>,
        wanted: &Topics,
    ) -> Result<Option<Self>, LogError> {
        let Some(derivatives) = derivatives.filter(|_| wanted.has(SENSITIVITIES)) else { return Ok(None) };
        let mut names: Vec<String> = Vec::new();
        let mut topics = Vec::new();
        for (index, key) in derivatives.keys.iter().enumerate() {
            let mut name = topic(key);
            while names.contains(&name) {
                name.push('_');
            }
            let channel = sink.channel(&name, &JOINT_STATE, Durability::Volatile)?;
            names.push(name);
            let deviation = derivatives.deviations.get(index).copied().flatten();
            let freedoms = derivatives.freedoms.iter().map(String::as_str);
            let template = match deviation {
                Some(_) => Template::joint_state(key, freedoms),
                None => Template::slopes(key, freedoms),
            };
            topics.push((channel, template, deviation));
        }
        Ok(Some(SensitivityMessages { derivatives: derivatives.clone(), topics }))
    }

    /// Adds the messages of a row.
    pub(crate) fn write(&self, row: usize, stamp: u64, sink: &mut dyn MessageSink) -> Result<(), LogError> {
        let Some(row) = self.derivatives.rows.get(row) else { return Ok(()) };
        for ((channel, template, deviation), slopes) in self.topics.iter().zip(&row.slopes) {
            let message = sink.message(*channel, stamp, template.encoded())?;
            template.fill_stamp(message, stamp);
            for (place, numbers) in slopes.iter().enumerate() {
                template.fill(message, place, numbers.iter().copied());
            }
            if let Some(deviation) = deviation {
                template.fill(message, slopes.len(), slopes[0].iter().map(|slope| deviation * slope.abs()));
            }
        }
        Ok(())
    }
}

/// The topic of a key, with names as ROS allows them: letters, digits and underscores, no digit at the beginning.
fn topic(key: &str) -> String {
    let token = |token: &str| {
        let kept = token.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' });
        let kept: String = kept.collect();
        if kept.chars().next().is_none_or(|first| first.is_ascii_digit()) { format!("_{kept}") } else { kept }
    };
    let tokens: Vec<String> = key.split('.').map(token).collect();
    format!("{SENSITIVITIES}/{}", tokens.join("/"))
}

#[cfg(test)]
mod tests {
    use super::topic;

    #[test]
    fn topics_of_keys_have_names_that_ros_allows() {
        assert_eq!(topic("link.upper-arm.mass"), "/sensitivities/link/upper_arm/mass");
        assert_eq!(topic("start.q.7"), "/sensitivities/start/q/_7");
    }
}
