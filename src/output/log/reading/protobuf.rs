//! Protocol Buffers, as far as logs of earlier versions need it: `/tf` and `/log` were Foxglove's messages.
//!
//! ```text
//!     message                    fields one after the other, in any order
//!     field                      key (number · 8 + kind), content
//!     kind 0                     integer: seven bits a byte, the lowest first; the highest bit says that more follow
//!     kind 1, 5                  eight, four bytes
//!     kind 2                     length as an integer, so many bytes: a text, or a message
//!
//!     FrameTransforms  { repeated FrameTransform transforms = 1 }
//!     FrameTransform   { string child_frame_id = 3; Vector3 translation = 4; Quaternion rotation = 5 }
//!     Vector3          { double x = 1; y = 2; z = 3 }        Quaternion { double x = 1; y = 2; z = 3; w = 4 }
//!     Log              { Level level = 2; string message = 3 }             levels from 3 on are warnings and errors
//! ```
//!
//! A damaged message is an error, never a panic. Source: Protocol Buffers, "Encoding" (protobuf.dev); foxglove/schemas.

use crate::output::log::reading::decode::{LinkPose, LogLine};

/// Decodes a `foxglove.FrameTransforms`.
pub(crate) fn transforms(data: &[u8]) -> Result<Vec<LinkPose>, String> {
    let mut links = Vec::new();
    fields(data, |number, content| {
        if let (1, Content::Bytes(transform)) = (number, content) {
            links.push(pose(transform)?);
        }
        Ok(())
    })?;
    Ok(links)
}

/// Decodes a `foxglove.Log`.
pub(crate) fn log_line(data: &[u8]) -> Result<LogLine, String> {
    let (mut level, mut message) = (0, String::new());
    fields(data, |number, content| {
        match (number, content) {
            (2, Content::Integer(value)) => level = value,
            (3, Content::Bytes(bytes)) => message = text(bytes)?,
            _ => {}
        }
        Ok(())
    })?;
    Ok(LogLine { is_problem: level >= 3, text: message })
}

fn pose(data: &[u8]) -> Result<LinkPose, String> {
    let mut pose = LinkPose { link: String::new(), position: [0.0; 3], orientation: [0.0; 4] };
    fields(data, |number, content| {
        match (number, content) {
            (3, Content::Bytes(bytes)) => pose.link = text(bytes)?,
            (4, Content::Bytes(bytes)) => pose.position = doubles(bytes)?,
            (5, Content::Bytes(bytes)) => {
                let [x, y, z, w] = doubles(bytes)?;
                pose.orientation = [w, x, y, z];
            }
            _ => {}
        }
        Ok(())
    })?;
    Ok(pose)
}

/// The fields 1 to `N` of a message of doubles; a missing field is zero.
fn doubles<const N: usize>(data: &[u8]) -> Result<[f64; N], String> {
    let mut all = [0.0; N];
    fields(data, |number, content| {
        if let (Some(place), Content::Double(value)) = (all.get_mut((number as usize).wrapping_sub(1)), content) {
            *place = value;
        }
        Ok(())
    })?;
    Ok(all)
}

fn text(bytes: &[u8]) -> Result<String, String> {
    String::from_utf8(bytes.to_vec()).map_err(|_| "a text is not UTF-8".to_string())
}

/// The content of a field.
enum Content<'d> {
    Integer(u64),
    Double(f64),
    Bytes(&'d [u8]),
}

/// Shows all fields of a message to `see`, with their numbers.
fn fields<'d>(mut rest: &'d [u8], mut see: impl FnMut(u64, Content<'d>) -> Result<(), String>) -> Result<(), String> {
    while !rest.is_empty() {
        let key = integer(&mut rest)?;
        match key % 8 {
            0 => see(key / 8, Content::Integer(integer(&mut rest)?))?,
            1 => {
                let (bytes, after) = rest.split_first_chunk().ok_or_else(ends)?;
                rest = after;
                see(key / 8, Content::Double(f64::from_le_bytes(*bytes)))?;
            }
            2 => {
                let length = usize::try_from(integer(&mut rest)?).unwrap_or(usize::MAX);
                let (bytes, after) = rest.split_at_checked(length).ok_or_else(ends)?;
                rest = after;
                see(key / 8, Content::Bytes(bytes))?;
            }
            5 => rest = rest.get(4..).ok_or_else(ends)?,
            kind => return Err(format!("a field is of the unknown kind {kind}")),
        }
    }
    Ok(())
}

fn integer(rest: &mut &[u8]) -> Result<u64, String> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (&byte, after) = rest.split_first().ok_or_else(ends)?;
        *rest = after;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err("a number has more than ten bytes".to_string())
}

fn ends() -> String {
    "it ends too early".to_string()
}

#[cfg(test)]
mod tests {
    use super::{log_line, transforms};

    /// A field of the kinds 0 and 2 for short contents, and of the kind 1.
    fn integer(number: u8, value: u8) -> Vec<u8> {
        vec![number << 3, value]
    }

    fn bytes(number: u8, content: &[u8]) -> Vec<u8> {
        // Lengths of up to 14 bits.
        let length = [content.len() as u8 & 0x7f | 0x80, (content.len() >> 7) as u8];
        [&[number << 3 | 2][..], &length, content].concat()
    }

    fn doubles(values: &[f64]) -> Vec<u8> {
        (1_u8..)
            .zip(values)
            .flat_map(|(number, value)| [&[number << 3 | 1][..], &value.to_le_bytes()].concat())
            .collect()
    }

    fn sample() -> Vec<u8> {
        let transform = |name: &str, shift: f64| {
            let stamp = [integer(1, 7), integer(2, 8)].concat();
            let names = [bytes(2, b"world"), bytes(3, name.as_bytes())].concat();
            let pose =
                [bytes(4, &doubles(&[shift, 0.0, -2.5])), bytes(5, &doubles(&[0.5, -0.5, shift, 1e-300]))].concat();
            bytes(1, &[bytes(1, &stamp), names, pose].concat())
        };
        [transform("größe", 1.25), transform(&"long".repeat(60), 0.0)].concat()
    }

    #[test]
    fn messages_of_earlier_versions_are_read_by_their_definitions() {
        let decoded = transforms(&sample()).expect("transforms");
        for (pose, (name, shift)) in decoded.iter().zip([("größe", 1.25), (&*"long".repeat(60), 0.0)]) {
            assert_eq!((&*pose.link, pose.position), (name, [shift, 0.0, -2.5]));
            assert_eq!(pose.orientation, [1e-300, 0.5, -0.5, shift]);
        }
        assert_eq!(decoded.len(), 2);
        for (level, is_problem) in [(2, false), (3, true), (4, true)] {
            let decoded = log_line(&[integer(2, level), bytes(3, b"a line")].concat()).expect("a line");
            assert_eq!((decoded.is_problem, &*decoded.text), (is_problem, "a line"));
        }
    }

    #[test]
    fn a_damaged_message_is_an_error_and_no_panic() {
        let whole = sample();
        let broken = (0..whole.len()).filter(|&cut| transforms(&whole[..cut]).is_err()).count();
        // Cut between the two transforms, and at the start, it is a whole message.
        assert_eq!(broken, whole.len() - 2);
        for place in 0..whole.len() {
            for bit in 0..8 {
                let mut damaged = whole.clone();
                damaged[place] ^= 1 << bit;
                let _ = transforms(&damaged);
            }
        }
    }
}
