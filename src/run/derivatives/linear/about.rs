//! Linear equations about an instant of a run, or about the equilibrium near a state.
//!
//! They hold within a mode: joints that are stuck stay so, motors keep to their laws or bounds, and contacts stay as they are. An equilibrium belongs to
//! its own mode: joints that Newton's iteration moves beyond a limit are put on it, and the mode is decided again. Contacts with friction roll on the way
//! to it.

use crate::derivatives::linear::equilibrium::{EquilibriumError, settle};
use crate::derivatives::linear::linearised::{LinearError, Linearised};
use crate::derivatives::linear::modes::NoModes;
use crate::events::{Moving, MovingError};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::words::counted;
use crate::mechanism::motion::state::State;

/// Modes that are tried for an equilibrium.
const MODES: usize = 20;

/// Why there are no linear equations.
#[derive(Debug, thiserror::Error)]
pub enum LinearizeError {
    /// The mode of the state cannot be told.
    #[error(transparent)]
    Moving(#[from] MovingError),
    /// The equations cannot be solved.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// Friction has no derivative.
    #[error(
        "{} to slide here, and friction has no derivative between two directions; \
         take an instant at which they slide, or rest",
        counted(*count, "closed contact begins", "closed contacts begin")
    )]
    Begins { count: usize },
    /// Rest needs more friction than there is.
    #[error(
        "no equilibrium was found: {} more friction than there is, where the forces balance; \
         give more friction, a start at which they rest, or take an instant with --at T",
        counted(*count, "closed contact needs", "closed contacts need")
    )]
    Slips { count: usize },
    /// There is no equilibrium.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// There are no modes.
    #[error(transparent)]
    Modes(#[from] NoModes),
    /// No mode has its own equilibrium.
    #[error(
        "no equilibrium was found: joints stick and slide in turn from one attempt to the next; \
         give a start at which they rest, or take an instant with --at T"
    )]
    Undecided,
}

/// Linear equations of motion in coordinates of the state, with the mechanism that they are of.
pub struct About {
    pub moving: Moving,
    /// The state of the whole mechanism.
    pub state: State,
    pub linearised: Linearised,
    /// Iterations to the equilibrium; `None` at an instant.
    pub iterations: Option<usize>,
}

/// The equations about a state of a mechanism, under efforts along its degrees of freedom.
///
/// # Errors
/// [`LinearizeError`] for states whose motion has no linear equations.
pub fn about_instant(mechanism: &Mechanism, state: &State, efforts: &[f64]) -> Result<About, LinearizeError> {
    refuse_unknown(mechanism)?;
    of(Moving::at(mechanism, state, efforts)?, state.clone(), None)
}

/// The equations about the equilibrium near a state, under the same efforts.
///
/// # Errors
/// As of [`about_instant`], and if no equilibrium is found.
pub fn about_rest(mechanism: &Mechanism, state: &State, efforts: &[f64]) -> Result<About, LinearizeError> {
    refuse_unknown(mechanism)?;
    let mut state = state.clone();
    state.velocity.fill(0.0);
    let mut moving = Moving::at(mechanism, &state, efforts)?;
    let mut iterations = 0;
    for _ in 0..MODES {
        moving.let_roll();
        let mut own = moving.state.clone();
        let mut there = state.clone();
        let mut is_outside = |own: &State| {
            moving.spread(own, &mut there);
            !put_within_limits(mechanism, &mut there)
        };
        iterations += settle(moving.mechanism(), &mut own, &moving.efforts, &moving.driven(), &mut is_outside)?;
        moving.spread(&own, &mut state);
        state.velocity.fill(0.0);
        let is_within = put_within_limits(mechanism, &mut state);
        let there = Moving::at(mechanism, &state, efforts)?;
        let same = there.is_like(&moving);
        moving = there;
        if same && is_within {
            return of(moving, state, Some(iterations));
        }
    }
    match moving.beginning_to_slide() {
        0 => Err(LinearizeError::Undecided),
        count => Err(LinearizeError::Slips { count }),
    }
}

/// Refuses forces that the equations of [`Linearised`] leave out.
fn refuse_unknown(mechanism: &Mechanism) -> Result<(), LinearError> {
    let forces = &mechanism.forces;
    let known = forces.drags.is_empty() && forces.link_loads.is_empty() && forces.joint_courses.is_empty();
    let known = known && forces.gravity_compensations.is_empty();
    if known { Ok(()) } else { Err(LinearError::Unknown) }
}

fn of(moving: Moving, state: State, iterations: Option<usize>) -> Result<About, LinearizeError> {
    let count = moving.beginning_to_slide();
    if count > 0 {
        return Err(LinearizeError::Begins { count });
    }
    let linearised = Linearised::about(moving.mechanism(), &moving.state, &moving.efforts, &moving.driven())?;
    Ok(About { moving, state, linearised, iterations })
}

/// Puts joints that are beyond a limit on it; returns whether all were within.
fn put_within_limits(mechanism: &Mechanism, state: &mut State) -> bool {
    let mut within = true;
    for limit in &mechanism.nonsmooth.limits {
        let slot = limit.coordinate.position;
        let position = state.position[slot] + state.compensation[slot];
        let inside = position.min(limit.upper).max(limit.lower);
        if inside != position {
            (state.position[slot], state.compensation[slot]) = (inside, 0.0);
            within = false;
        }
    }
    within
}
