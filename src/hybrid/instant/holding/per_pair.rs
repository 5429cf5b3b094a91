//! Values of some pairs, by their numbers.

/// A value for some pairs; the others have the default.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PerPair<T> {
    /// In the order of the numbers.
    known: Vec<(usize, T)>,
}

impl<T: Default> PerPair<T> {
    fn place(&self, pair: usize) -> Result<usize, usize> {
        // Small scenes know all their pairs.
        match self.known.get(pair) {
            Some((number, _)) if *number == pair => Ok(pair),
            _ => self.known.binary_search_by_key(&pair, |(number, _)| *number),
        }
    }

    /// The value of a pair, if it has one.
    pub fn get(&self, pair: usize) -> Option<&T> {
        self.place(pair).ok().map(|place| &self.known[place].1)
    }

    /// The value of a pair, at first the default.
    pub fn of(&mut self, pair: usize) -> &mut T {
        let place = match self.place(pair) {
            Ok(place) => place,
            Err(place) => {
                self.known.insert(place, (pair, T::default()));
                place
            }
        };
        &mut self.known[place].1
    }

    /// All values, in the order of the numbers of their pairs.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &T)> {
        self.known.iter().map(|(pair, value)| (*pair, value))
    }

    /// The same, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (usize, &mut T)> {
        self.known.iter_mut().map(|(pair, value)| (*pair, value))
    }

    /// Keeps the values of the pairs that a test keeps.
    pub fn retain(&mut self, mut keeps: impl FnMut(usize) -> bool) {
        self.known.retain(|(pair, _)| keeps(*pair));
    }

    /// Forgets all values.
    pub fn clear(&mut self) {
        self.known.clear();
    }

    /// Gives all of these pairs, whose numbers ascend, a value; known values stay.
    pub fn extend(&mut self, pairs: &[usize], make: impl Fn(usize) -> T) {
        let mut before = std::mem::take(&mut self.known).into_iter().peekable();
        let mut new = pairs.iter().copied().peekable();
        loop {
            match (before.peek(), new.peek()) {
                (Some((known, _)), Some(pair)) if known == pair => _ = new.next(),
                (Some((known, _)), Some(pair)) if pair < known => {
                    self.known.push((*pair, make(*pair)));
                    new.next();
                }
                (Some(_), _) => self.known.extend(before.next()),
                (None, Some(pair)) => {
                    self.known.push((*pair, make(*pair)));
                    new.next();
                }
                (None, None) => break,
            }
        }
    }
}

impl PerPair<bool> {
    /// Whether the value of a pair is true.
    pub fn holds(&self, pair: usize) -> bool {
        self.get(pair).is_some_and(|value| *value)
    }

    /// Whether any value is true.
    pub fn any(&self) -> bool {
        self.known.iter().any(|(_, value)| *value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_the_numbers_of_their_pairs_and_the_others_have_none() {
        let mut values = PerPair::default();
        for pair in [70, 3, 12, 3] {
            *values.of(pair) += 1;
        }
        assert_eq!([3, 12, 70, 4].map(|pair| values.get(pair).copied()), [Some(2), Some(1), Some(1), None]);
        values.extend(&[0, 3, 40, 70, 71], |pair| pair);
        let all: Vec<(usize, usize)> = values.iter().map(|(pair, value)| (pair, *value)).collect();
        assert_eq!(all, [(0, 0), (3, 2), (12, 1), (40, 40), (70, 1), (71, 71)]);
        values.retain(|pair| pair > 3);
        assert_eq!(values.iter().map(|(pair, _)| pair).collect::<Vec<_>>(), [12, 40, 70, 71]);
    }
}
