//! The present mode with all that belongs to it: the mechanism, its elements and their states, and the piece that moves.

use crate::events::modes::mode::Mode;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::held::Held as Moving;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::mechanism::Mechanism;

/// A mechanism, its elements, their mode, and the reduced mechanism that moves in it.
#[derive(Clone, Copy)]
pub(crate) struct Present<'p> {
    pub whole: &'p Mechanism,
    pub elements: &'p Elements,
    pub touching: &'p Touching,
    pub mode: &'p Mode,
    pub moving: &'p Moving,
    /// A slip up to this is at rest, and its direction is a rounding [m/s].
    pub rest: f64,
}
