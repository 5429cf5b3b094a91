//! Which topics a log has: all of them, or those that the user names.
//!
//! `/rosout`, what is said about the run, is in every log.

use std::str::FromStr;

/// The topics that one can do without; those of robots in a scene have the robot's name before them.
const NAMES: [&str; 13] = [
    "robot_description",
    "visual_markers",
    "tf",
    "joint_states",
    "multi_dof_joint_states",
    "reactions",
    "motors",
    "contacts",
    "contact_forces",
    "events",
    "energy",
    "constraint",
    "solver",
];

/// The topics of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topics {
    /// Their names without the slash; `None` stands for all.
    chosen: Option<Vec<String>>,
}

impl Topics {
    /// The same but for this topic, which is named with its slash.
    #[must_use]
    pub(crate) fn without(&self, topic: &str) -> Self {
        let all = || NAMES.iter().map(|name| name.to_string()).collect();
        let chosen: Vec<String> = self.chosen.clone().unwrap_or_else(all);
        Topics { chosen: Some(chosen.into_iter().filter(|name| name != topic.trim_start_matches('/')).collect()) }
    }

    /// Whether the log has this topic, which is named with its slash and without that of a robot.
    pub(crate) fn has(&self, topic: &str) -> bool {
        let name = topic.trim_start_matches('/');
        self.chosen.as_ref().is_none_or(|chosen| chosen.iter().any(|chosen| chosen == name))
    }
}

/// A name that is no topic.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no topic {name:?}; topics are {}", NAMES.join(", "))]
pub struct UnknownTopic {
    /// What was given.
    pub name: String,
}

impl FromStr for Topics {
    type Err = UnknownTopic;

    /// Names with commas between, with or without their slashes.
    fn from_str(text: &str) -> Result<Self, UnknownTopic> {
        let named = text.split(',').map(|name| name.trim().trim_start_matches('/'));
        let known = |name: &str| match NAMES.contains(&name) {
            true => Ok(name.to_string()),
            false => Err(UnknownTopic { name: name.to_string() }),
        };
        Ok(Topics { chosen: Some(named.map(known).collect::<Result<_, _>>()?) })
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
        for wrong in ["", "tf,", "energies"] {
            let error = wrong.parse::<Topics>().expect_err(wrong).to_string();
            assert!(error.contains("joint_states"), "{error}");
        }
    }
}
