//! The pairs of a mechanism that may touch: one list in few entries, shared by all copies of the mechanism until one of them changes it.
//!
//! ```text
//!     run (a, b, n, k):    pairs (a, b), (a, b + 1) … (a, b + k − 1) of colliders, with the numbers n, n + 1 … n + k − 1, one friction and one restitution
//! ```
//!
//! Three thousand balls on a floor have 4.5 million pairs, and six thousand runs: all later balls are one run for each ball, and the floor is another. Bodies
//! that alternate in their friction have a run for each change.

use crate::description::contact::ContactPair;
use std::sync::Arc;

/// Pairs of one collider with colliders that follow each other, all with the same laws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairRun {
    /// The first of them.
    pub first: ContactPair,
    /// How many there are.
    pub count: usize,
}

impl PairRun {
    /// The pair at a place of it.
    pub fn at(&self, place: usize) -> ContactPair {
        let ContactPair { number, b, .. } = self.first;
        ContactPair { number: number + place, b: b + place, ..self.first }
    }

    /// Its pairs.
    pub fn pairs(self) -> impl Iterator<Item = ContactPair> {
        (0..self.count).map(move |place| self.at(place))
    }

    /// Whether another one goes on where it ends.
    fn is_continued_by(&self, next: &ContactPair) -> bool {
        self.at(self.count) == *next
    }
}

/// A list of pairs. A copy is the same list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactPairs(Arc<Runs>);

/// The runs, and how many pairs there are up to the end of each.
#[derive(Clone, Debug, Default, PartialEq)]
struct Runs {
    runs: Vec<PairRun>,
    ends: Vec<usize>,
}

impl ContactPairs {
    /// How many pairs there are.
    pub fn len(&self) -> usize {
        self.0.ends.last().copied().unwrap_or(0)
    }

    /// Whether nothing may touch.
    pub fn is_empty(&self) -> bool {
        self.0.runs.is_empty()
    }

    /// The runs in their order.
    pub fn runs(&self) -> &[PairRun] {
        &self.0.runs
    }

    /// All pairs in their order.
    pub fn iter(&self) -> impl Iterator<Item = ContactPair> + Clone + '_ {
        self.0.runs.iter().flat_map(|run| (0..run.count).map(|place| run.at(place)))
    }

    /// The pair at a place of the list, which has one there.
    pub fn at(&self, place: usize) -> ContactPair {
        let Runs { runs, ends } = &*self.0;
        let run = ends.partition_point(|end| *end <= place);
        let before = if run > 0 { ends[run - 1] } else { 0 };
        runs[run].at(place - before)
    }

    /// The pair at a place of the list, if it has one there.
    pub fn get(&self, place: usize) -> Option<ContactPair> {
        (place < self.len()).then(|| self.at(place))
    }

    /// The pair with a number, in a list with numbers that ascend.
    pub fn with_number(&self, number: usize) -> Option<ContactPair> {
        let after = self.0.runs.partition_point(|run| run.first.number <= number);
        let run = self.0.runs[..after].last()?;
        let place = number - run.first.number;
        (place < run.count).then(|| run.at(place))
    }

    /// The place of the pair of two colliders, `a < b`, in a list that is in the order of its colliders.
    pub fn place_of(&self, a: usize, b: usize) -> Option<usize> {
        let Runs { runs, ends } = &*self.0;
        let after = runs.partition_point(|run| (run.first.a, run.first.b) <= (a, b));
        let run = runs[..after].last().filter(|run| run.first.a == a)?;
        let place = b - run.first.b;
        (place < run.count).then(|| ends[after - 1] - run.count + place)
    }

    /// Whether the pairs are in the order of their colliders, the first of each before the second.
    pub fn are_in_order(&self) -> bool {
        let runs = &self.0.runs;
        let end = |run: &PairRun| (run.first.a, run.first.b + run.count);
        runs.iter().all(|run| run.first.a < run.first.b)
            && runs.windows(2).all(|two| end(&two[0]) <= (two[1].first.a, two[1].first.b))
    }

    /// Adds a pair.
    pub fn push(&mut self, pair: ContactPair) {
        self.push_run(PairRun { first: pair, count: 1 });
    }

    /// Adds a run.
    pub fn push_run(&mut self, run: PairRun) {
        if run.count == 0 {
            return;
        }
        let end = self.len() + run.count;
        let Runs { runs, ends } = Arc::make_mut(&mut self.0);
        match (runs.last_mut(), ends.last_mut()) {
            (Some(last), Some(of_last)) if last.is_continued_by(&run.first) => {
                (last.count, *of_last) = (last.count + run.count, end);
            }
            _ => {
                runs.push(run);
                ends.push(end);
            }
        }
    }

    /// Removes all pairs.
    pub fn clear(&mut self) {
        *self = ContactPairs::default();
    }

    /// Changes all pairs, or leaves some out.
    pub fn retain_mut(&mut self, mut change: impl FnMut(&mut ContactPair) -> bool) {
        let changed = |mut pair: ContactPair| change(&mut pair).then_some(pair);
        *self = std::mem::take(self).iter().filter_map(changed).collect();
    }
}

impl FromIterator<ContactPair> for ContactPairs {
    fn from_iter<I: IntoIterator<Item = ContactPair>>(pairs: I) -> Self {
        let mut list = ContactPairs::default();
        pairs.into_iter().for_each(|pair| list.push(pair));
        list
    }
}

impl From<Vec<ContactPair>> for ContactPairs {
    fn from(pairs: Vec<ContactPair>) -> Self {
        pairs.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(number: usize, ends: [usize; 2], friction: f64) -> ContactPair {
        ContactPair::without_moments(number, ends, friction, 0.0)
    }

    #[test]
    fn copies_share_their_pairs_until_one_of_them_is_changed() {
        let first = ContactPairs::from(vec![pair(0, [0, 1], 0.5)]);
        let mut second = first.clone();
        assert_eq!(first.runs().as_ptr(), second.runs().as_ptr());
        second.push(pair(1, [0, 2], 0.5));
        assert_eq!((first.len(), second.len()), (1, 2));
        assert_eq!((first.runs().len(), second.runs().len()), (1, 1));
    }

    #[test]
    fn a_list_in_runs_is_the_list_of_its_pairs_and_finds_each_by_its_place_number_and_colliders() {
        // Collider 2 has no pair with 4; 5 has another friction; numbers have a gap, as in a part of a mechanism.
        let ends = [[0, 1], [0, 2], [0, 3], [0, 5], [1, 2], [1, 3], [1, 4], [1, 5], [2, 3], [2, 5]];
        let friction = |b: usize| if b == 5 { 0.9 } else { 0.5 };
        let all: Vec<ContactPair> =
            (0..).zip(ends).map(|(place, [a, b])| pair(place + 3 * usize::from(a > 0), [a, b], friction(b))).collect();
        let list = ContactPairs::from(all.clone());
        // 0: 1 to 3, 5; 1: 2 to 4, 5; 2: 3, 5.
        assert_eq!(list.runs().len(), 6);
        assert!(list.iter().eq(all.iter().copied()));
        assert!(list.are_in_order());
        for (place, wanted) in all.iter().enumerate() {
            assert_eq!(list.get(place), Some(*wanted));
            assert_eq!(list.with_number(wanted.number), Some(*wanted));
            assert_eq!(list.place_of(wanted.a, wanted.b), Some(place));
        }
        assert_eq!((list.get(10), list.with_number(5), list.with_number(13)), (None, None, None));
        assert_eq!((list.place_of(0, 4), list.place_of(2, 4), list.place_of(3, 4)), (None, None, None));
        let mut fewer = list.clone();
        fewer.retain_mut(|pair| {
            pair.friction = 0.5;
            pair.b != 2
        });
        assert_eq!(
            fewer.iter().map(|pair| [pair.a, pair.b]).collect::<Vec<_>>(),
            [[0, 1], [0, 3], [0, 5], [1, 3], [1, 4], [1, 5], [2, 3], [2, 5]]
        );
        assert!(!ContactPairs::from(vec![all[1], all[0]]).are_in_order());
    }

    #[test]
    fn pairs_of_all_with_all_take_a_run_for_each_collider() {
        let count = 300;
        let ends = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let list: ContactPairs = ends.enumerate().map(|(number, ends)| pair(number, ends, 0.5)).collect();
        assert_eq!((list.len(), list.runs().len()), (count * (count - 1) / 2, count - 1));
    }
}
