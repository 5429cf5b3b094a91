//! How far a problem is gone on with where Newton's method stalls: less far where an island has many contacts.

/// An island with more blocks is large: it has many contacts that others could replace, and each digit costs some hundred iterations.
const LARGE: usize = 500;

/// How far a problem is gone on with where Newton's method stalls.
#[derive(Clone, Copy)]
pub(crate) struct Effort {
    /// The residual that is wanted.
    pub residual: f64,
    /// Most iterations in which proximal points do not halve it.
    pub patience: usize,
    /// The residual at which neither interior points nor convex problems are tried.
    pub enough: f64,
}

impl Effort {
    /// For a problem of this number of blocks whose residual is to be below `tolerance`.
    pub fn of(blocks: usize, tolerance: f64) -> Self {
        let (least, patience, enough): (f64, usize, f64) =
            if blocks > LARGE { (1e-6, 60, 1e-5) } else { (0.0, usize::MAX, 1e-8) };
        Effort { residual: tolerance.max(least), patience, enough: enough.max(tolerance) }
    }
}
