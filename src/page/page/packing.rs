//! Arrays of numbers as text in a page: differences, byte planes, zlib, base64.
//!
//! ```text
//!     d_k = x_k − x_{k−1}  (mod 2^8w, each column from 0)    words of w bytes; of an f32 its bits
//!     plane_b = byte b of all d_k                            bytes of the same weight lie together, so that zlib finds repetitions
//!     text = base64(zlib(plane_0 plane_1 … of all arrays))
//! ```
//!
//! `assets/packed.js` is the inverse. Because `miniz_oxide` has one implementation for all processors, the same numbers give the same text.

use miniz_oxide::deflate::compress_to_vec_zlib;
use serde::Serialize;

/// How much effort zlib makes, from 0 to 10.
const LEVEL: u8 = 7;

/// The place of an array in the bytes of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Place {
    /// Its first byte.
    at: usize,
    /// Number of words.
    count: usize,
    /// Bytes of a word.
    width: usize,
    /// Words of a column, within which differences are taken; zero: no differences.
    column: usize,
}

/// The arrays of a page.
#[derive(Default)]
pub(super) struct Packed {
    bytes: Vec<u8>,
}

impl Packed {
    /// Adds numbers in columns of the same length, one after the other.
    pub(super) fn floats(&mut self, numbers: impl Iterator<Item = f32>, column: usize) -> Place {
        let words: Vec<u64> = numbers.map(|number| u64::from(number.to_bits())).collect();
        self.words(&words, 4, column)
    }

    /// Adds one column in double precision.
    pub(super) fn doubles(&mut self, numbers: &[f64]) -> Place {
        let words: Vec<u64> = numbers.iter().map(|number| number.to_bits()).collect();
        self.words(&words, 8, words.len())
    }

    /// Adds words of `width` bytes, with differences in each column, or without if `column` is zero.
    pub(super) fn words(&mut self, words: &[u64], width: usize, column: usize) -> Place {
        let place = Place { at: self.bytes.len(), count: words.len(), width, column };
        let before = |k: usize| if column == 0 || k.is_multiple_of(column) { 0 } else { words[k - 1] };
        let differences: Vec<[u8; 8]> =
            words.iter().enumerate().map(|(k, word)| word.wrapping_sub(before(k)).to_le_bytes()).collect();
        for byte in 0..width {
            self.bytes.extend(differences.iter().map(|word| word[byte]));
        }
        place
    }

    /// The text of all arrays.
    pub(super) fn text(&self) -> String {
        base64(&compress_to_vec_zlib(&self.bytes, LEVEL))
    }
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let is_padding = digit > three.len();
            let index = (word >> (18 - 6 * digit)) & 63;
            text.push(if is_padding { '=' } else { char::from(DIGITS[index as usize]) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Packed, base64};
    use miniz_oxide::inflate::decompress_to_vec_zlib;

    #[test]
    fn base64_is_that_of_the_standard() {
        // The test vectors of RFC 4648, section 10.
        let cases =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")];
        for (plain, text) in cases {
            assert_eq!(base64(plain.as_bytes()), text);
        }
    }

    #[test]
    fn planes_and_differences_give_the_numbers_back() {
        let numbers = [1.5f32, -2.25, 3e20, f32::NAN, 0.0, -0.0];
        let mut packed = Packed::default();
        packed.words(&[7, 65535, 0], 2, 3);
        let place = packed.floats(numbers.into_iter(), 3);
        assert_eq!((place.at, place.count), (6, 6));
        let mut word = 0u32;
        for (k, number) in numbers.iter().enumerate() {
            let difference =
                u32::from_le_bytes([0, 1, 2, 3].map(|byte| packed.bytes[place.at + byte * place.count + k]));
            word = if k % 3 == 0 { difference } else { word.wrapping_add(difference) };
            assert_eq!(word, number.to_bits(), "number {k}");
        }
        let zlib = miniz_oxide::deflate::compress_to_vec_zlib(&packed.bytes, super::LEVEL);
        assert_eq!(decompress_to_vec_zlib(&zlib).expect("zlib"), packed.bytes);
    }
}
