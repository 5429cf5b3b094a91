//! Encodes `tf2_msgs/msg/TFMessage` by filling in numbers: all else is the same in every message.
//!
//! ```text
//!     TFMessage         { TransformStamped[] transforms }
//!     TransformStamped  { Header header; string child_frame_id; Transform transform }
//!     Header            { Time stamp; string frame_id }
//!     Transform         { Vector3 translation; Quaternion rotation }       7 doubles: x, y, z, and the quaternion x, y, z, w
//! ```
//!
//! Source: the packages `tf2_msgs` and `geometry_msgs` of ROS 2.

use crate::mechanism::description::joint::Pose;
use crate::model::LinkFrame;
use crate::output::log::encoding::cdr;
use crate::output::log::encoding::cdr::CdrWriter;

/// The frame all poses are given in, unless a moving link has taken the name.
const WORLD_FRAME: &str = "world";

/// Bytes of a stamp and of a pose.
const STAMP: usize = 8;
const POSE: usize = 7 * 8;

/// Encodes the poses of the same frames again and again.
pub(crate) struct TransformsEncoder {
    /// The message with zeros for all numbers.
    encoded: Vec<u8>,
    /// The places of each frame's stamp and pose in it.
    places: Vec<(usize, usize)>,
}

impl TransformsEncoder {
    /// Frames of these names, all in the frame `parent`.
    pub(crate) fn new<'n>(parent: &str, children: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let mut encoded = Vec::new();
        let mut writer = CdrWriter::begin(&mut encoded);
        writer.unsigned(children.len() as u32);
        let places = children
            .map(|child| {
                writer.time(0);
                let stamp = writer.place() - STAMP;
                writer.string(parent);
                writer.string(child);
                (stamp, writer.row(7))
            })
            .collect();
        TransformsEncoder { encoded, places }
    }

    /// The message with zeros.
    pub(crate) fn encoded(&self) -> &[u8] {
        &self.encoded
    }

    /// Puts the stamp and the poses (translation, quaternion w, x, y, z) of all frames into a message.
    pub(crate) fn fill(&self, message: &mut [u8], nanoseconds: u64, poses: impl Iterator<Item = ([f64; 3], [f64; 4])>) {
        let time = cdr::time(nanoseconds);
        for (&(stamp, pose), ([x, y, z], [qw, qx, qy, qz])) in self.places.iter().zip(poses) {
            message[stamp..stamp + STAMP].copy_from_slice(&time);
            cdr::fill(&mut message[pose..pose + POSE], [x, y, z, qx, qy, qz, qw].into_iter());
        }
    }
}

/// The links that get a transform: all, save a link that is the world frame itself.
pub(crate) fn drawn_links(links: &[LinkFrame]) -> Vec<LinkFrame> {
    let is_world =
        |link: &LinkFrame| link.name == WORLD_FRAME && link.body.is_none() && link.in_body == Pose::identity();
    links.iter().filter(|link| !is_world(link)).cloned().collect()
}

/// The name of the frame of the world.
pub(crate) fn world_frame(links: &[LinkFrame]) -> &'static str {
    // A link may be called `world` and still move; its transform must not have itself as the parent.
    if drawn_links(links).iter().any(|link| link.name == WORLD_FRAME) { "simulation_world" } else { WORLD_FRAME }
}

#[cfg(test)]
mod tests {
    use super::TransformsEncoder;
    use crate::output::log::reading::decode;

    /// Names of every length modulo eight, so that every padding occurs.
    #[test]
    fn what_is_filled_in_is_what_a_reader_of_the_fields_finds() {
        let names: Vec<String> = (0..17).map(|length| "ö".repeat(length / 2) + &"x".repeat(length % 2)).collect();
        for parent in ["world", "", "a longer name"] {
            let encoder = TransformsEncoder::new(parent, names.iter().map(String::as_str));
            let poses = (0..names.len()).map(|frame| {
                let [a, b] = [frame as f64, -1e300 / (frame + 1) as f64];
                ([a, b, f64::MIN_POSITIVE], [a + 0.5, b / 2.0, -0.0, 1.0 / (a + 1.0)])
            });
            for nanoseconds in [0, 1, 16_666_667, 999_999_999, 1_000_000_000, 123_456_789_012_345_678] {
                let mut message = encoder.encoded().to_vec();
                encoder.fill(&mut message, nanoseconds, poses.clone());
                let decoded = decode::transforms(&message).expect("a message");
                assert_eq!(decoded.len(), names.len());
                for ((pose, name), (position, orientation)) in decoded.iter().zip(&names).zip(poses.clone()) {
                    assert_eq!((&pose.link, pose.position, pose.orientation), (name, position, orientation));
                }
            }
        }
    }
}
