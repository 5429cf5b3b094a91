//! Which topics a log has: all of them, or those that the user names.
//!
//! If no shape can touch another, a log has `/collision_shapes` of links only when the topic is named. `/rosout`, the lines of text about the run, is
//! in every log.

use std::str::FromStr;

/// The topics that can be left out; topics of robots in a scene have the robot's name before them.
const NAMES: [&str; 16] = [
    "robot_description",
    "visual_markers",
    "collision_shapes",
    "tf",
    "joint_states",
    "multi_dof_joint_states",
    "reactions",
    "motors",
    "contacts",
    "contact_forces",
    "ropes",
    "events",
    "energy",
    "constraint",
    "solver",
    "sensitivities",
];

/// The topics of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topics {
    /// Their names without the slash; `None` stands for all.
    chosen: Option<Vec<String>>,
    /// Topics of them that it does not have after all.
    left_out: Vec<String>,
}

/// A name without its slash.
fn bare(topic: &str) -> &str {
    topic.trim_start_matches('/')
}

impl Topics {
    /// The same but for this topic, which is named with its slash.
    #[must_use]
    pub(crate) fn without(&self, topic: &str) -> Self {
        let mut left_out = self.left_out.clone();
        left_out.push(bare(topic).to_string());
        Topics { left_out, ..self.clone() }
    }

    /// Whether the log has this topic, which is named with its slash and without the robot's name.
    pub(crate) fn has(&self, topic: &str) -> bool {
        let is_left_out = self.left_out.iter().any(|left_out| left_out == bare(topic));
        !is_left_out && (self.chosen.is_none() || self.names(topic))
    }

    /// Whether the user has named this topic, which is given with its slash.
    pub(crate) fn names(&self, topic: &str) -> bool {
        self.chosen.as_ref().is_some_and(|chosen| chosen.iter().any(|chosen| chosen == bare(topic)))
    }
}

/// A name that is no topic.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no topic {name:?}; topics are {}", NAMES.join(", "))]
pub struct UnknownTopic {
    /// The given name.
    pub name: String,
}

impl FromStr for Topics {
    type Err = UnknownTopic;

    /// Names with commas between, with or without their slashes.
    fn from_str(text: &str) -> Result<Self, UnknownTopic> {
        let named = text.split(',').map(|name| bare(name.trim()));
        let known = |name: &str| match NAMES.contains(&name) {
            true => Ok(name.to_string()),
            false => Err(UnknownTopic { name: name.to_string() }),
        };
        Ok(Topics { chosen: Some(named.map(known).collect::<Result<_, _>>()?), left_out: Vec::new() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_topics_are_chosen_and_unknown_ones_refused() {
        let topics: Topics = "tf, /energy".parse().expect("topics");
        assert!(topics.has("/tf") && topics.has("/energy") && !topics.has("/joint_states"));
        assert!(NAMES.iter().all(|name| Topics::default().has(&format!("/{name}"))));
        let fewer = topics.without("/tf");
        assert!(!fewer.has("/tf") && fewer.has("/energy") && !Topics::default().without("/tf").has("/tf"));
        assert!(topics.names("/tf") && !topics.names("/solver") && !Topics::default().names("/tf"));
        for wrong in ["", "tf,", "energies"] {
            let error = wrong.parse::<Topics>().expect_err(wrong).to_string();
            assert!(error.contains("joint_states"), "{error}");
        }
    }
}
