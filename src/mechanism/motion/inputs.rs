//! What acts on a mechanism from outside during one step: efforts that somebody decides on while the run goes on.

/// Efforts along the degrees of freedom, constant over a step.
///
/// They act besides the forces of the mechanism ([`crate::description::forces::Forces`]). What they do is work put in, `∫ τ q̇ dt` (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs<'i> {
    /// One entry a degree of freedom [N m or N], for ball joints about the axes of the child's joint frame; or empty: nothing acts.
    pub efforts: &'i [f64],
}

impl Inputs<'_> {
    /// Nothing acts from outside.
    pub const NONE: Inputs<'static> = Inputs { efforts: &[] };

    /// Whether nothing acts.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.efforts.iter().all(|&effort| effort == 0.0)
    }
}
