//! The pose and motion of a body in the plane at the start of a step.

/// The start-of-step part of a body.
#[derive(Clone, Copy, Default)]
pub(crate) struct PlanarBody {
    /// Vector from the parent's anchor to this body's (m).
    pub arm: [f64; 2],
    /// In the unit of mass of the step: the mass, the moment of inertia through the anchor [m²], and the mass times the arm from the
    /// anchor to the centre of mass (m).
    pub mass: f64,
    pub inertia: f64,
    pub heavy: [f64; 2],
    /// Angular velocity about n [rad/s].
    pub spin: f64,
    /// Velocity of the anchor against the parent, by the slides [m/s].
    pub sliding: [f64; 2],
    /// Cosine and sine of the turn since zero displacement.
    pub turn: [f64; 2],
    /// Place (m) and velocity [m/s] of the anchor.
    pub position: [f64; 2],
    pub velocity: [f64; 2],
}

/// `(C + S J) v`.
pub(crate) fn turned([cosine, sine]: &[f64; 2], [x, y]: &[f64; 2]) -> [f64; 2] {
    [cosine * x - sine * y, sine * x + cosine * y]
}
