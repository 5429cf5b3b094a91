//! What acts on a mechanism from outside during one step: efforts that somebody decides on while the run goes on.

/// Efforts along the degrees of freedom: constant over a step, and some that change with time in a known way.
///
/// They act besides the forces of the mechanism ([`crate::description::forces::Forces`]). What they do is work put in, `∫ τ q̇ dt` (J).
#[derive(Clone, Copy, Default)]
pub struct Inputs<'i> {
    /// One entry a degree of freedom [N m or N], for ball joints about the axes of the child's joint frame; or empty: nothing acts.
    pub efforts: &'i [f64],
    /// Efforts that change in time, besides those.
    pub changing: Option<&'i dyn ChangingEfforts>,
}

/// Efforts that change smoothly in time, along scalar joint coordinates.
pub trait ChangingEfforts {
    /// The degrees of freedom along which they act, each once; the same for the whole life of an integrator.
    fn freedoms(&self) -> &[usize];
    /// The effort along the freedom of this entry at a time (s) [N m or N].
    fn effort(&self, entry: usize, time: f64) -> f64;
}

impl<'i> Inputs<'i> {
    /// Nothing acts from outside.
    pub const NONE: Inputs<'static> = Inputs { efforts: &[], changing: None };

    /// Constant efforts, one entry a degree of freedom.
    pub fn constant(efforts: &'i [f64]) -> Self {
        Inputs { efforts, changing: None }
    }

    /// Whether nothing acts.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.changing.is_none() && self.efforts.iter().all(|&effort| effort == 0.0)
    }
}
