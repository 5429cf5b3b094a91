//! Things that a run uses while it lasts: lent by the caller, or shared with it, so that the run owns its part.

use std::borrow::Borrow;
use std::ops::Deref;
use std::sync::Arc;

/// An owner of a `T`, shared with others.
pub(crate) type Owner<T> = Arc<dyn Borrow<T> + Send + Sync>;

/// A `T` that is lent, or a share of its owner.
pub enum Held<'h, T: 'static> {
    /// The caller keeps it.
    Lent(&'h T),
    /// It lives as long as anyone holds it.
    Shared(Owner<T>),
}

impl<T> Clone for Held<'_, T> {
    fn clone(&self) -> Self {
        match self {
            Held::Lent(lent) => Held::Lent(lent),
            Held::Shared(owner) => Held::Shared(owner.clone()),
        }
    }
}

impl<T> Deref for Held<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        match self {
            Held::Lent(lent) => lent,
            Held::Shared(owner) => (**owner).borrow(),
        }
    }
}
