//! The present mode with all that belongs to it: the mechanism, its elements and their states, and the piece that moves.

use crate::events::modes::held::Held as Moving;
use crate::events::modes::mode::Mode;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::Vector3;

/// A mechanism, its elements, what they do, and what moves while they do it.
#[derive(Clone, Copy)]
pub(crate) struct Present<'p> {
    pub whole: &'p Mechanism,
    pub elements: &'p Elements,
    pub touching: &'p Touching,
    pub mode: &'p Mode,
    pub moving: &'p Moving,
    pub begun: Begun<'p>,
}

/// The directions in which closed contacts slide where the step begins.
#[derive(Clone, Copy, Default)]
pub(crate) struct Begun<'p> {
    /// One unit vector in the world for each contact; none where nothing is known but the mode.
    pub slips: &'p [Vector3<f64>],
    /// A slip below this has the direction of its start, the more the slower it is [m/s]: before it stops its own is noise of the solution of the stages.
    pub slow: f64,
}
