//! The durability of a topic: whether late subscribers receive its last message when the log is played, as in bags of ROS 2.
//!
//! Source: rosbag2 (`qos.cpp`, `mcap_storage.cpp`).

use std::collections::BTreeMap;

/// The offer of a topic that never changes: reliable, and for late subscribers too. The numbers are the ones of bags of ROS 2 Humble, which later
/// versions read as well.
const LATCHED: &str = "\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: 1
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
";

/// Who is shown the messages of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Durability {
    /// Those who are there.
    Volatile,
    /// Those who come later, too.
    Latched,
}

impl Durability {
    /// The metadata of a channel.
    pub(crate) fn metadata(self) -> BTreeMap<String, String> {
        match self {
            Durability::Volatile => BTreeMap::new(),
            Durability::Latched => BTreeMap::from([("offered_qos_profiles".to_string(), LATCHED.to_string())]),
        }
    }
}
