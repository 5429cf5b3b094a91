//! Which runs a process makes, and which of them are in one file of rows.

use std::ops::Range;
use std::str::FromStr;

/// One of several equal parts of a sweep: `K/N`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

/// Not a shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no shard; give K/N with K from 1 to N, such as 3/8")]
pub struct UnknownShard(String);

impl Shard {
    /// All runs.
    pub const WHOLE: Shard = Shard { number: 1, of: 1 };

    /// Its number, from 1, and how many there are.
    pub fn numbers(self) -> (u64, u64) {
        (self.number, self.of)
    }

    /// Its indices: consecutive ones.
    pub fn range(self, runs: u64) -> Range<u64> {
        let bound = |number: u64| (u128::from(runs) * u128::from(number) / u128::from(self.of)) as u64;
        bound(self.number - 1)..bound(self.number)
    }
}

impl FromStr for Shard {
    type Err = UnknownShard;

    fn from_str(text: &str) -> Result<Self, UnknownShard> {
        let numbers = || {
            let (number, of) = text.split_once('/')?;
            let (number, of) = (number.trim().parse().ok()?, of.trim().parse().ok()?);
            (1..=of).contains(&number).then_some(Shard { number, of })
        };
        numbers().ok_or_else(|| UnknownShard(text.to_string()))
    }
}

/// The ranges of the files of rows: they end at multiples of the rows of a file, whatever the shard.
pub(super) fn files(range: Range<u64>, rows_per_file: u64) -> impl Iterator<Item = Range<u64>> {
    let mut first = range.start;
    std::iter::from_fn(move || {
        (first < range.end).then(|| {
            let end = ((first / rows_per_file + 1) * rows_per_file).min(range.end);
            let file = first..end;
            first = end;
            file
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shards_of_a_sweep_hold_every_index_once() {
        for (runs, of) in [(10, 3), (2, 5), (1 << 53, 7), (0, 2), (100, 1)] {
            let shards: Vec<Range<u64>> = (1..=of).map(|number| Shard { number, of }.range(runs)).collect();
            assert_eq!((shards[0].start, shards[shards.len() - 1].end), (0, runs));
            assert!(shards.windows(2).all(|pair| pair[0].end == pair[1].start), "{shards:?}");
        }
    }

    #[test]
    fn files_end_at_multiples_wherever_a_shard_begins() {
        let all: Vec<Range<u64>> = files(3..11, 4).collect();
        assert_eq!(all, [3..4, 4..8, 8..11]);
        assert_eq!(files(5..5, 4).count(), 0);
    }

    #[test]
    fn a_shard_is_counted_from_one() {
        assert_eq!("3/8".parse(), Ok(Shard { number: 3, of: 8 }));
        for text in ["0/8", "9/8", "3", "a/b", "1/0", "-1/2"] {
            assert!(text.parse::<Shard>().unwrap_err().to_string().contains("K from 1 to N"), "{text}");
        }
    }
}
