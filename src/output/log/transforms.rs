//! Encodes `foxglove.FrameTransforms` by filling in numbers: all else is the same in every message.
//!
//! Protobuf writes a field as its number and kind in one byte, a length where the kind needs one, and the content:
//!
//! ```text
//!     FrameTransforms  { repeated FrameTransform transforms = 1 }
//!     FrameTransform   { Timestamp timestamp = 1; string parent_frame_id = 2; string child_frame_id = 3;
//!                        Vector3 translation = 4; Quaternion rotation = 5 }
//!     Timestamp        { int64 seconds = 1; int32 nanos = 2 }        Vector3, Quaternion { double x = 1; y = 2; … }
//! ```
//!
//! Source: Protocol Buffers, "Encoding" (protobuf.dev); foxglove/schemas, FrameTransform.proto.

/// Kinds of fields: a variable-length integer, a double, something with a length.
const INTEGER: u8 = 0;
const DOUBLE: u8 = 1;
const LENGTH: u8 = 2;

const fn key(field: u8, kind: u8) -> u8 {
    field << 3 | kind
}

/// Length of a message of `N` doubles.
const fn doubles_length(count: usize) -> u8 {
    9 * count as u8
}

/// Lengths of a translation and of a rotation, and of both fields with what is before the first numbers.
const TRANSLATION: usize = 27;
const ROTATION: usize = 36;
const POSE: usize = 2 + TRANSLATION + 2 + ROTATION;

/// Encodes the poses of the same frames again and again.
pub(crate) struct TransformsEncoder {
    /// For each frame the encoded names of its parent and itself.
    names: Vec<Vec<u8>>,
    stamp: Vec<u8>,
    /// A message of zeros: until the stamp has another length all differ in numbers alone.
    message: Vec<u8>,
    /// Where each frame's stamp and pose are in it.
    places: Vec<(usize, usize)>,
}

impl TransformsEncoder {
    /// Frames of these names, all in the frame `parent`.
    pub(crate) fn new<'n>(parent: &str, children: impl Iterator<Item = &'n str>) -> Self {
        let named = |child: &str| {
            let mut names = Vec::new();
            for (field, name) in [(2, parent), (3, child)] {
                names.push(key(field, LENGTH));
                push_integer(name.len() as u64, &mut names);
                names.extend_from_slice(name.as_bytes());
            }
            names
        };
        let names = children.map(named).collect();
        TransformsEncoder { names, stamp: Vec::new(), message: Vec::new(), places: Vec::new() }
    }

    /// A message with all names, and zeros for the poses, at this time.
    pub(crate) fn prepare(&mut self, nanoseconds: u64) -> &[u8] {
        let length = self.stamp.len();
        self.encode_stamp(nanoseconds);
        if self.stamp.len() != length {
            self.lay_out();
        }
        &self.message
    }

    /// Puts the stamp and the poses (translation, quaternion w, x, y, z) of all frames into the message that was prepared.
    pub(crate) fn fill(&self, message: &mut [u8], poses: impl Iterator<Item = ([f64; 3], [f64; 4])>) {
        for (&(stamp, pose), (translation, [w, x, y, z])) in self.places.iter().zip(poses) {
            message[stamp..stamp + self.stamp.len()].copy_from_slice(&self.stamp);
            let (first, second) = message[pose..pose + POSE].split_at_mut(2 + TRANSLATION);
            fill_doubles(&mut first[2..], &translation);
            fill_doubles(&mut second[2..], &[x, y, z, w]);
        }
    }

    /// A message with all names, the stamp, and zeros for the other numbers.
    fn lay_out(&mut self) {
        let out = &mut self.message;
        out.clear();
        self.places.clear();
        for names in &self.names {
            out.push(key(1, LENGTH));
            push_integer((self.stamp.len() + names.len() + POSE) as u64, out);
            let stamp = out.len();
            out.extend_from_slice(&self.stamp);
            out.extend_from_slice(names);
            self.places.push((stamp, out.len()));
            for (field, count) in [(4, 3), (5, 4)] {
                out.extend_from_slice(&[key(field, LENGTH), doubles_length(count)]);
                for number in 1..=count as u8 {
                    out.push(key(number, DOUBLE));
                    out.extend_from_slice(&[0; 8]);
                }
            }
        }
    }

    fn encode_stamp(&mut self, nanoseconds: u64) {
        self.stamp.clear();
        self.stamp.extend_from_slice(&[key(1, LENGTH), 0, key(1, INTEGER)]);
        push_integer(nanoseconds / 1_000_000_000, &mut self.stamp);
        self.stamp.push(key(2, INTEGER));
        push_integer(nanoseconds % 1_000_000_000, &mut self.stamp);
        // Two numbers of at most ten bytes each.
        self.stamp[1] = self.stamp.len() as u8 - 2;
    }
}

/// Seven bits a byte, the lowest first; the highest bit says that more follow.
fn push_integer(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Puts numbers into their fields, behind the byte that each begins with.
fn fill_doubles(fields: &mut [u8], values: &[f64]) {
    for (field, value) in fields.chunks_exact_mut(9).zip(values) {
        field[1..].copy_from_slice(&value.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::TransformsEncoder;
    use foxglove::Decode;
    use foxglove::messages::FrameTransforms;

    #[test]
    fn what_is_encoded_is_decoded_by_the_generated_code() {
        let long = "a name with more than one hundred and twenty-seven letters ".repeat(4);
        let names = ["base", "", "größe", &long];
        let mut encoder = TransformsEncoder::new("world", names.into_iter());
        let poses = [
            ([0.0, -0.0, 1.0], [1.0, 0.0, 0.0, 0.0]),
            ([1e300, -1e-300, f64::MIN_POSITIVE], [0.5, -0.5, 0.5, -0.5]),
            ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 7.0]),
            ([-1.0, 0.1, 0.2], [0.3, 0.4, 0.5, 0.6]),
        ];
        for nanoseconds in [0, 1, 127, 128, 16_666_667, 999_999_999, 1_000_000_000, 123_456_789_012_345_678] {
            let mut message = encoder.prepare(nanoseconds).to_vec();
            encoder.fill(&mut message, poses.into_iter());
            let decoded = FrameTransforms::decode(&message[..]).expect("a message").transforms;
            assert_eq!(decoded.len(), names.len());
            for ((transform, name), (p, q)) in decoded.iter().zip(names).zip(poses) {
                assert_eq!((&*transform.parent_frame_id, &*transform.child_frame_id), ("world", name));
                assert_eq!(transform.timestamp.expect("a stamp").total_nanos(), nanoseconds);
                let (translation, turn) = (transform.translation.expect("there"), transform.rotation.expect("there"));
                assert_eq!([translation.x, translation.y, translation.z], p);
                assert_eq!([turn.w, turn.x, turn.y, turn.z], q);
            }
        }
    }
}
