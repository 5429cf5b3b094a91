//! The contact forces of a run as arrays: for each sample the closed contacts, with where they touch and which force acts there.
//!
//! Samples have different numbers of contacts, so the contacts of all samples lie in a row:
//!
//! ```text
//!     sample k has the contacts  starts_k … starts_{k+1} − 1
//!     numbers: six columns, x y z of the point (m), x y z of the force on the first of the pair (N), all in the world
//! ```
//!
//! A pair is named `a|b`, as events name it, and has a number in the order in which pairs first touch.

use crate::output::log::reading::decode::LoggedContact;
use crate::page::packing::{Packed, Place};
use serde::Serialize;
use std::collections::HashMap;

/// Collects the contacts of samples.
#[derive(Default)]
pub(super) struct Contacts {
    numbers_of_pairs: HashMap<String, u64>,
    /// The names of pairs, by number.
    pairs: Vec<String>,
    /// How many contacts there are before each sample.
    starts: Vec<u64>,
    /// The pair of each contact.
    which: Vec<u64>,
    /// Point and force of each contact.
    rows: Vec<[f64; 6]>,
}

/// The layer of arrows of contact forces.
#[derive(Serialize)]
pub(super) struct ContactLayer {
    name: &'static str,
    unit: &'static str,
    pairs: Vec<String>,
    /// The most contacts of a sample.
    most: u64,
    /// One number a sample, and the number of all contacts.
    starts: Place,
    which: Place,
    numbers: Place,
}

impl Contacts {
    /// Takes the contacts of the next sample.
    pub(super) fn take(&mut self, contacts: &[LoggedContact]) {
        self.starts.push(self.rows.len() as u64);
        for LoggedContact { a, b, position, force, .. } in contacts {
            let new = self.pairs.len() as u64;
            let number = *self.numbers_of_pairs.entry(format!("{a}|{b}")).or_insert_with_key(|name| {
                self.pairs.push(name.clone());
                new
            });
            self.which.push(number);
            let ([x, y, z], [fx, fy, fz]) = (*position, *force);
            self.rows.push([x, y, z, fx, fy, fz]);
        }
    }

    /// The layer, or `None` if the log has no contacts.
    pub(super) fn pack(&self, packed: &mut Packed) -> Option<ContactLayer> {
        let count = self.rows.len();
        if count == 0 {
            return None;
        }
        let starts: Vec<u64> = self.starts.iter().copied().chain([count as u64]).collect();
        let columns = (0..6).flat_map(|k| self.rows.iter().map(move |row| row[k] as f32));
        Some(ContactLayer {
            name: "Contacts",
            unit: "N",
            pairs: self.pairs.clone(),
            most: starts.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0),
            starts: packed.words(&starts, 4, starts.len()),
            which: packed.words(&self.which, 4, 0),
            numbers: packed.floats(columns, count),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(a: &str, b: &str, force: f64) -> LoggedContact {
        LoggedContact {
            a: a.to_string(),
            b: b.to_string(),
            position: [1.0, 2.0, 3.0],
            normal: [0.0, 0.0, 1.0],
            force: [0.0, 0.0, force],
            gap: 0.0,
            state: "stick".to_string(),
        }
    }

    #[test]
    fn samples_without_contacts_are_empty_and_pairs_are_numbered_as_they_first_touch() {
        let mut contacts = Contacts::default();
        contacts.take(&[]);
        assert!(contacts.pack(&mut Packed::default()).is_none());
        contacts.take(&[contact("foot", "floor", 1.0), contact("hand", "wall", 2.0)]);
        contacts.take(&[]);
        contacts.take(&[contact("hand", "wall", 3.0)]);
        assert_eq!((&contacts.starts, &contacts.which), (&vec![0, 0, 2, 2], &vec![0, 1, 1]));
        assert_eq!(contacts.rows[2], [1.0, 2.0, 3.0, 0.0, 0.0, 3.0]);
        let layer = contacts.pack(&mut Packed::default()).expect("contacts");
        assert_eq!((layer.pairs, layer.most), (vec!["foot|floor".to_string(), "hand|wall".to_string()], 2));
    }
}
