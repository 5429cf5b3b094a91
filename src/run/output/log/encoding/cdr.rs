//! CDR, the encoding of ROS 2 messages, as far as the log needs it.
//!
//! ```text
//!     00 01 00 00                      encapsulation: plain CDR, little endian, no options
//!     number of n bytes                starts at a multiple of n, counted from the end of the encapsulation
//!     string                           u32 length with the final NUL, the bytes, NUL
//!     sequence                         u32 number of elements, the elements
//! ```
//!
//! A structure is its fields one after the other.

/// Writes one CDR message into a buffer that is used again and again.
pub(crate) struct CdrWriter<'b> {
    buffer: &'b mut Vec<u8>,
}

const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

impl<'b> CdrWriter<'b> {
    /// Empties the buffer and starts a message in it.
    pub(crate) fn begin(buffer: &'b mut Vec<u8>) -> Self {
        buffer.clear();
        buffer.extend_from_slice(&ENCAPSULATION);
        CdrWriter { buffer }
    }

    fn align(&mut self, size: usize) {
        let offset = self.buffer.len() - ENCAPSULATION.len();
        self.buffer.resize(ENCAPSULATION.len() + offset.next_multiple_of(size), 0);
    }

    /// A length, count or other unsigned number of four bytes.
    pub(crate) fn unsigned(&mut self, value: u32) {
        self.align(4);
        self.buffer.extend_from_slice(&value.to_le_bytes());
    }

    /// A time.
    pub(crate) fn time(&mut self, nanoseconds: u64) {
        self.align(4);
        self.buffer.extend_from_slice(&time(nanoseconds));
    }

    /// A string.
    pub(crate) fn string(&mut self, text: &str) {
        self.unsigned(text.len() as u32 + 1);
        self.buffer.extend_from_slice(text.as_bytes());
        self.buffer.push(0);
    }

    /// A double.
    pub(crate) fn double(&mut self, value: f64) {
        self.align(8);
        self.buffer.extend_from_slice(&value.to_le_bytes());
    }

    /// Adds `count` doubles that are fields one after the other, all zero; returns the place of the first.
    pub(crate) fn row(&mut self, count: usize) -> usize {
        self.align(8);
        let start = self.buffer.len();
        self.buffer.resize(start + 8 * count, 0);
        start
    }

    /// A number of one byte, or a truth value.
    pub(crate) fn byte(&mut self, value: u8) {
        self.buffer.push(value);
    }

    /// A number of four bytes with a fraction.
    pub(crate) fn single(&mut self, value: f32) {
        self.align(4);
        self.buffer.extend_from_slice(&value.to_le_bytes());
    }

    /// Adds a sequence of `count` structures of `N` doubles, all zero; returns the place of the first.
    pub(crate) fn structures<const N: usize>(&mut self, count: usize) -> usize {
        self.unsigned(count as u32);
        // An empty sequence has no element that would need the padding; readers do not skip any.
        if count > 0 {
            self.align(8);
        }
        let start = self.buffer.len();
        self.buffer.resize(start + 8 * N * count, 0);
        start
    }

    /// A sequence of structures of three doubles.
    pub(crate) fn triples(&mut self, triples: &[[f32; 3]]) {
        let start = self.structures::<3>(triples.len());
        fill(&mut self.buffer[start..], triples.iter().flatten().map(|value| f64::from(*value)));
    }

    /// The place of the next field without alignment.
    pub(crate) fn place(&self) -> usize {
        self.buffer.len()
    }
}

/// A `builtin_interfaces/Time`; seconds beyond its 31 bits stay at the largest.
pub(crate) fn time(nanoseconds: u64) -> [u8; 8] {
    let seconds = i32::try_from(nanoseconds / 1_000_000_000).unwrap_or(i32::MAX);
    let [a, b, c, d] = seconds.to_le_bytes();
    let [e, f, g, h] = ((nanoseconds % 1_000_000_000) as u32).to_le_bytes();
    [a, b, c, d, e, f, g, h]
}

/// Puts doubles into a message, where they belong.
#[inline]
pub(crate) fn fill(bytes: &mut [u8], values: impl Iterator<Item = f64>) {
    // Without zip, which would be a call here for each message.
    let mut places = bytes.as_chunks_mut().0.iter_mut();
    for value in values {
        let Some(place) = places.next() else { return };
        *place = value.to_le_bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::CdrWriter;
    use super::fill;

    #[test]
    fn numbers_are_aligned_from_the_end_of_the_encapsulation() {
        let mut buffer = vec![9; 3];
        let mut writer = CdrWriter::begin(&mut buffer);
        writer.string("ab");
        let place = writer.structures::<1>(1);
        fill(&mut buffer[place..], [1.0].into_iter());
        let expected: &[u8] = &[
            0, 1, 0, 0, // encapsulation
            3, 0, 0, 0, b'a', b'b', 0, 0, // the string and one byte of padding
            1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, // a count at 8, the double at 16
        ];
        assert_eq!(buffer[..16], expected[..16]);
        assert_eq!(buffer[16..20], [0; 4]);
        assert_eq!(buffer[20..], expected[16..]);
    }
}
