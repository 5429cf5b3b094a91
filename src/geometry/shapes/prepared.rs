//! Prepared shapes, kept as long as what they are made of.
//!
//! The hull of some thousands of points takes as long as many steps, and each pair, each run of a study and each look at an overlap asks for the same
//! one. A shape is the same if its points are the same allocation and its pose has the same bits:
//!
//! ```text
//!     (points, pose) ─▶ known ─▶ shared
//!                    └▶ prepared, and kept until the points are dropped
//! ```

use catena_mechanism::description::joint::Pose;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The prepared shapes of one kind.
pub(crate) struct Prepared<S, T> {
    known: Mutex<Vec<Known<S, T>>>,
}

/// A shape, with its source.
struct Known<S, T> {
    source: Weak<S>,
    pose: Pose,
    shape: Arc<T>,
}

impl<S, T> Prepared<S, T> {
    /// A store without shapes.
    pub const fn new() -> Self {
        Prepared { known: Mutex::new(Vec::new()) }
    }

    /// The shape of a source in a pose; `make` prepares it where it is not known.
    pub fn of<E>(&self, source: &Arc<S>, pose: &Pose, make: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        // While a weak reference is kept, no other source has its address.
        let same =
            |known: &&Known<S, T>| known.source.as_ptr() == Arc::as_ptr(source) && has_same_bits(&known.pose, pose);
        if let Some(known) = self.lock().iter().find(same) {
            return Ok(known.shape.clone());
        }
        // Others may prepare the same one meanwhile: both get equal shapes.
        let shape = Arc::new(make()?);
        let mut known = self.lock();
        known.retain(|known| known.source.strong_count() > 0);
        known.push(Known { source: Arc::downgrade(source), pose: *pose, shape: shape.clone() });
        Ok(shape)
    }

    /// In how many poses a source is known.
    #[cfg(test)]
    pub fn poses(&self, source: &Arc<S>) -> usize {
        self.lock().iter().filter(|known| known.source.as_ptr() == Arc::as_ptr(source)).count()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Known<S, T>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn has_same_bits(one: &Pose, other: &Pose) -> bool {
    let entries = |pose: &Pose| -> [u64; 12] {
        let (place, turn) = (&pose.translation.vector, pose.rotation.matrix());
        std::array::from_fn(|index| if index < 3 { place[index] } else { turn[index - 3] }.to_bits())
    };
    entries(one) == entries(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_shape_is_prepared_once_for_a_source_and_a_pose_and_again_after_the_source_is_dropped() {
        let store: Prepared<f64, f64> = Prepared::new();
        let mut made = 0;
        let mut ask = |source: &Arc<f64>, pose: &Pose| {
            let make = || {
                made += 1;
                Ok::<f64, ()>(**source)
            };
            (store.of(source, pose, make).expect("a shape"), made)
        };
        let (here, there) = (Pose::identity(), Pose::from_parts(Vector3::x().into(), Default::default()));
        let source = Arc::new(1.0);
        assert_eq!((*ask(&source, &here).0, ask(&source, &here).1), (1.0, 1));
        // Another pose, another source with an equal value, and the copy of a reference.
        assert_eq!(ask(&source, &there).1, 2);
        let other = Arc::new(1.0);
        assert_eq!(ask(&other, &here).1, 3);
        assert_eq!(ask(&source.clone(), &here).1, 3);
        drop(other);
        for count in 0..100 {
            // Each of these may have the address of the one before, and a value of its own.
            let source = Arc::new(f64::from(count));
            assert_eq!((*ask(&source, &here).0, ask(&source, &here).1), (f64::from(count), 4 + count));
        }
        // Of the dropped ones only the last may be left.
        assert!(store.lock().len() <= 3);
    }
}
