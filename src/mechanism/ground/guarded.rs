//! A value behind a lock that its owner alone takes: room that a method which cannot change its owner works in. Unlike a `RefCell` it may be shared
//! between threads, and it can be cloned.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// A value behind a lock.
#[derive(Debug, Default)]
pub struct Guarded<T>(Mutex<T>);

impl<T> Guarded<T> {
    /// Of a value.
    pub fn new(value: T) -> Self {
        Guarded(Mutex::new(value))
    }

    /// The value, for one who has it alone: without a lock.
    pub fn get_mut(&mut self) -> &mut T {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// The value behind its lock. A thread that holds it must not ask again.
    pub fn lock(&self) -> MutexGuard<'_, T> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T: Clone> Clone for Guarded<T> {
    fn clone(&self) -> Self {
        Guarded::new(self.lock().clone())
    }
}
