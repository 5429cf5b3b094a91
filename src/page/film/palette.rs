//! The colours of a GIF: at most 255, chosen by median cut.
//!
//! ```text
//!     bins:     64 × 64 × 64, the upper six bits of red, green and blue; with their counts and sums of colours
//!     cut:      the box with the largest  count · (longest edge)²  is divided along that edge at its median, until there are 255
//!     palette:  the mean colour of each box;  a pixel has the colour that is nearest to the middle of its bin
//! ```
//!
//! Source: P. Heckbert, Color image quantization for frame buffer display, SIGGRAPH 1982.

use crate::film::canvas::Image;

/// Bits of a channel that tell bins apart, and their number.
const BITS: u32 = 6;
const BINS: usize = 1 << (3 * BITS);

/// The most colours: GIF has 256, of which one is transparent.
pub(super) const MOST: usize = 255;

/// The number of the transparent colour.
pub(super) const TRANSPARENT: u8 = 255;

/// Counts of the colours of some pictures.
pub(super) struct Histogram {
    count: Vec<u64>,
    sum: Vec<[u64; 3]>,
}

impl Histogram {
    pub(super) fn new() -> Self {
        Histogram { count: vec![0; BINS], sum: vec![[0; 3]; BINS] }
    }

    /// Counts the pixels of a picture.
    pub(super) fn add(&mut self, image: &Image) {
        for pixel in &image.pixels {
            let bin = bin(*pixel);
            self.count[bin] += 1;
            for channel in 0..3 {
                self.sum[bin][channel] += u64::from(pixel[channel]);
            }
        }
    }

    /// The colours that show these pictures best.
    pub(super) fn palette(&self) -> Palette {
        let mut boxes = vec![Cut::of(self, (0..BINS).filter(|bin| self.count[*bin] > 0).collect())];
        while boxes.len() < MOST {
            let largest = (0..boxes.len()).max_by_key(|k| (boxes[*k].weight, std::cmp::Reverse(*k)));
            let Some(largest) = largest.filter(|k| boxes[*k].bins.len() > 1) else { break };
            let (low, high) = boxes.swap_remove(largest).halves(self);
            boxes.extend([low, high]);
        }
        let colors = boxes.iter().map(|cut| {
            let count: u64 = cut.bins.iter().map(|bin| self.count[*bin]).sum();
            let sum = |channel: usize| cut.bins.iter().map(|bin| self.sum[*bin][channel]).sum::<u64>();
            [0, 1, 2].map(|channel| (sum(channel) as f64 / count.max(1) as f64).round() as u8)
        });
        Palette { colors: colors.collect(), nearest: vec![None; BINS] }
    }
}

/// The bin of a colour.
fn bin(pixel: [u8; 3]) -> usize {
    pixel.iter().fold(0, |bin, channel| bin << BITS | usize::from(channel >> (8 - BITS)))
}

/// The bin's place along a channel.
fn along(bin: usize, channel: usize) -> usize {
    bin >> (BITS as usize * (2 - channel)) & ((1 << BITS) - 1)
}

/// A box of bins.
struct Cut {
    bins: Vec<usize>,
    /// The channel along which it is longest.
    channel: usize,
    /// Its need to be divided; zero of a single bin.
    weight: u64,
}

impl Cut {
    fn of(histogram: &Histogram, bins: Vec<usize>) -> Self {
        let count: u64 = bins.iter().map(|bin| histogram.count[*bin]).sum();
        let length = |channel: usize| {
            let places = || bins.iter().map(|bin| along(*bin, channel));
            places().max().unwrap_or(0) - places().min().unwrap_or(0)
        };
        let channel = (0..3).max_by_key(|channel| (length(*channel), 2 - channel)).unwrap_or(0);
        let weight = count * (length(channel) as u64).pow(2);
        Cut { bins, channel, weight }
    }

    /// Both halves at the median of its longest channel; each has at least one bin.
    fn halves(mut self, histogram: &Histogram) -> (Self, Self) {
        self.bins.sort_by_key(|bin| (along(*bin, self.channel), *bin));
        let half: u64 = self.bins.iter().map(|bin| histogram.count[*bin]).sum::<u64>() / 2;
        let mut counted = 0;
        let before = self.bins.iter().take_while(|bin| {
            counted += histogram.count[**bin];
            counted <= half
        });
        let place = before.count().clamp(1, self.bins.len() - 1);
        let high = self.bins.split_off(place);
        (Cut::of(histogram, self.bins), Cut::of(histogram, high))
    }
}

/// Colours, and the nearest of them to each bin that has been asked for.
pub(super) struct Palette {
    /// Red, green, blue.
    pub colors: Vec<[u8; 3]>,
    nearest: Vec<Option<u8>>,
}

impl Palette {
    /// The number of the colour that stands for a pixel.
    pub(super) fn index(&mut self, pixel: [u8; 3]) -> u8 {
        let bin = bin(pixel);
        if let Some(known) = self.nearest[bin] {
            return known;
        }
        let middle = pixel.map(|channel| i32::from(channel >> (8 - BITS) << (8 - BITS)) + (1 << (7 - BITS)));
        let apart = |color: &[u8; 3]| (0..3).map(|k| (i32::from(color[k]) - middle[k]).pow(2)).sum::<i32>();
        let nearest = (0u8..).zip(&self.colors).min_by_key(|(_, color)| apart(color)).map_or(0, |(index, _)| index);
        self.nearest[bin] = Some(nearest);
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::{Histogram, MOST};
    use crate::film::canvas::Image;

    #[test]
    fn few_colours_are_kept_and_many_are_near() {
        let few = [[250, 10, 10], [10, 250, 10], [10, 10, 250]];
        let picture = |pixels: Vec<[u8; 3]>| Image { width: pixels.len(), height: 1, pixels };
        let mut histogram = Histogram::new();
        histogram.add(&picture(few.to_vec()));
        let mut palette = histogram.palette();
        for color in few {
            let index = palette.index(color);
            assert_eq!(palette.colors[usize::from(index)], color);
        }
        // All shades of a colour cube in steps of 8: 255 boxes of 32 768 bins are some 5 bins wide, so 20 of 255 at most.
        let many: Vec<[u8; 3]> =
            (0..32 * 32 * 32).map(|k: usize| [k >> 10, k >> 5 & 31, k & 31].map(|part| (8 * part) as u8)).collect();
        let mut histogram = Histogram::new();
        histogram.add(&picture(many.clone()));
        let mut palette = histogram.palette();
        assert_eq!(palette.colors.len(), MOST);
        for color in many {
            let index = usize::from(palette.index(color));
            let shown = palette.colors[index];
            assert!((0..3).all(|k| color[k].abs_diff(shown[k]) <= 40), "{color:?} as {shown:?}");
        }
    }
}
