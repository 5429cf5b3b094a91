//! The pairs of a mechanism that may touch: one list, shared by all copies of the mechanism until one of them changes it.

use crate::description::contact::ContactPair;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// A list of pairs, read and changed as a vector. A copy is the same list: a thousand bodies have half a million pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactPairs(Arc<Vec<ContactPair>>);

impl Deref for ContactPairs {
    type Target = Vec<ContactPair>;

    fn deref(&self) -> &Vec<ContactPair> {
        &self.0
    }
}

impl DerefMut for ContactPairs {
    fn deref_mut(&mut self) -> &mut Vec<ContactPair> {
        Arc::make_mut(&mut self.0)
    }
}

impl From<Vec<ContactPair>> for ContactPairs {
    fn from(pairs: Vec<ContactPair>) -> Self {
        ContactPairs(Arc::new(pairs))
    }
}

impl<'p> IntoIterator for &'p ContactPairs {
    type Item = &'p ContactPair;
    type IntoIter = std::slice::Iter<'p, ContactPair>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_their_pairs_until_one_of_them_is_changed() {
        let first = ContactPairs::from(vec![ContactPair::without_moments(0, [0, 1], 0.5, 0.0)]);
        let mut second = first.clone();
        assert_eq!(first.as_ptr(), second.as_ptr());
        second.push(ContactPair::without_moments(1, [0, 2], 0.5, 0.0));
        assert_eq!((first.len(), second.len()), (1, 2));
        assert_ne!(first.as_ptr(), second.as_ptr());
    }
}
