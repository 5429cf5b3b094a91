//! The numbers below a count in disjoint sets, which are united by pairs of their members.
//!
//! Each number points to itself or to a smaller one of its set, and the first number of a set to itself. The way there is halved whenever it is gone.
//!
//! Source: R. E. Tarjan, J. van Leeuwen, Worst-case analysis of set union algorithms, J. ACM 31 (1984).

/// Disjoint sets of the numbers below a count.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    before: Vec<usize>,
}

impl DisjointSets {
    /// Each number alone.
    pub fn new(count: usize) -> Self {
        DisjointSets { before: (0..count).collect() }
    }

    /// The first number of the set of a number.
    pub fn first(&mut self, mut number: usize) -> usize {
        while self.before[number] != number {
            self.before[number] = self.before[self.before[number]];
            number = self.before[number];
        }
        number
    }

    /// Makes the sets of two numbers one; whether they were two.
    pub fn unite(&mut self, one: usize, other: usize) -> bool {
        let (one, other) = (self.first(one), self.first(other));
        self.before[one.max(other)] = one.min(other);
        one != other
    }

    /// For each number the first one of its set.
    pub fn firsts(mut self) -> Vec<usize> {
        (0..self.before.len()).map(|number| self.first(number)).collect()
    }

    /// For each number its set, counted from 0 in the order of their first numbers.
    pub fn numbers(self) -> Vec<usize> {
        let mut numbers = self.firsts();
        let mut count = 0;
        for number in 0..numbers.len() {
            let first = numbers[number];
            numbers[number] = if first == number { count } else { numbers[first] };
            count += usize::from(first == number);
        }
        numbers
    }

    /// The sets, each in order, in the order of their first numbers.
    pub fn parts(self) -> Vec<Vec<usize>> {
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for (number, part) in self.numbers().into_iter().enumerate() {
            if part == parts.len() {
                parts.push(Vec::new());
            }
            parts[part].push(number);
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_pairs_join_are_one_set_in_the_order_of_their_first() {
        let mut sets = DisjointSets::new(7);
        let two: Vec<bool> = [(5, 3), (6, 1), (3, 6), (1, 5)].map(|(one, other)| sets.unite(one, other)).to_vec();
        assert_eq!(two, [true, true, true, false]);
        assert_eq!((sets.first(5), sets.first(4)), (1, 4));
        assert_eq!(sets.clone().firsts(), [0, 1, 2, 1, 4, 1, 1]);
        assert_eq!(sets.clone().numbers(), [0, 1, 2, 1, 3, 1, 1]);
        assert_eq!(sets.parts(), [vec![0], vec![1, 3, 5, 6], vec![2], vec![4]]);
    }
}
